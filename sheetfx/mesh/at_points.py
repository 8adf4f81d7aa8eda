"""Expressions evaluated, and given values kept, at reference points of cells."""

from __future__ import annotations

import basix.ufl
import numpy as np
from dolfinx import fem
from dolfinx.mesh import Mesh

from ..jit import compiled_expression
from .numbers import with_constants
from .quadrature import Rule


def at_points(expression, points: np.ndarray) -> fem.Expression:
    """A UFL expression to be evaluated at reference points of cells."""
    return compiled_expression(expression, points, with_constants)


def values_at_points(domain: Mesh, cells: np.ndarray, rule: Rule, shape: tuple) -> tuple[fem.Function, np.ndarray]:
    """Given values at the points of a rule as a function, and for each of the cells its rows in `x.array`."""
    element = basix.ufl.quadrature_element(domain.basix_cell(), value_shape=shape, points=rule.points,
                                           weights=rule.weights)
    function = fem.Function(fem.functionspace(domain, element))
    return function, function.function_space.dofmap.list[cells]


def put(function: fem.Function, rows: np.ndarray, values: np.ndarray) -> None:
    """Give a function of `values_at_points` values of shape (cells, points, components)."""
    function.x.array.reshape(-1, values.shape[2])[rows.ravel()] = values.reshape(-1, values.shape[2])
