"""Forces at points from strains and laws that are written in UFL."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cached_property

import numpy as np
import ufl
from dolfinx import fem
from dolfinx.mesh import create_interval
from mpi4py import MPI

from ..jit import compiled_expression
from ..mesh.numbers import with_constants
from .densities import WAY

EVERY = slice(None)


class PointLaw:
    """Forces at points from a strain measure and a law that are written in UFL.

    With strains e(z) and resultants s(e) the forces are f = s . de/dz. The points are the cells of a mesh of their own,
    on which z is constant in each cell, so that all are evaluated by one compiled kernel, whose results are kept for as
    long as what they depend on is the same.

    Parameters
    ----------
    strains : function (values, data, factor) -> UFL vector; `values` and `data` are lists of UFL vectors
    law : function from strains to resultants, both UFL vectors
    sizes : numbers of components of the values
    data : arrays of shape (points, components) that strains may depend on
    factor : function that gives the load factor
    weights : of the points, by which forces are multiplied; None: 1
    """

    def __init__(self, strains: Callable, law: Callable, sizes: Sequence[int], data: Sequence[np.ndarray],
                 count: int, factor: Callable[[], float], weights: np.ndarray | None = None):
        self._factor, self._count, self._size = factor, count, sum(sizes)
        self._weights = np.ones(count) if weights is None else weights
        self._known: dict[fem.Expression, np.ndarray] = {}
        if not count:
            return
        mesh = self._mesh = create_interval(MPI.COMM_SELF, count, (0.0, 1.0))
        self._cells = np.arange(count, dtype=np.int32)
        self._constant = fem.Constant(mesh, 0.0)
        self._z = self._on_cells(self._size)
        constants = self._data = [self._on_cells(d.shape[1], d) for d in data]
        z = self._variable = ufl.variable(self._z)
        now = ufl.variable(self._constant)
        ends = np.cumsum(sizes)
        values = [ufl.as_vector([z[int(i)] for i in range(end - size, end)]) for end, size in zip(ends, sizes,
                                                                                                  strict=True)]
        e, (i, j, k) = strains(values, constants, now), ufl.indices(3)
        self._density = sum(weight * ufl.dot(law(share * e), e) for share, weight in WAY)
        resultants, slopes = law(e), ufl.diff(e, z)
        self._change, self._held = self._on_cells(self._size), self._on_cells(e.ufl_shape[0])
        force, held = (ufl.as_vector(s[i] * slopes[i, j], j) for s in (resultants, self._held))
        material = ufl.as_matrix(ufl.diff(resultants, z)[i, j] * slopes[i, k], (k, j))
        self._strains, self._measure, self._law = self._expression(e), e, law
        self._force, self._holding = self._expression(force), self._expression(held)
        self._stiffness = self._expression(material + ufl.diff(held, z))
        self._resultants = self._expression(resultants + ufl.dot(ufl.diff(resultants, z), self._change))
        self._pull = self._expression(-ufl.diff(force, now))

    def give(self, number: int, values: np.ndarray) -> None:
        """Change one of the arrays of data that strains depend on."""
        if self._count:
            self._put(self._data[number], values)

    def weigh(self, weights: np.ndarray) -> None:
        """Change the weights of the points."""
        self._weights = weights

    def strains(self, z: np.ndarray) -> np.ndarray:
        """Strains at z, shape (points, strains)."""
        return self._evaluate(self._strains, z, self._held.function_space.dofmap.bs) if self._count else z

    def resultants(self, z: np.ndarray) -> np.ndarray:
        """Resultants at z, shape (points, strains)."""
        return self.extrapolated(z, np.zeros_like(z))

    def _on_cells(self, size: int, values: np.ndarray | None = None) -> fem.Function:
        function = fem.Function(fem.functionspace(self._mesh, ("DG", 0, (size,))))
        if values is not None:
            self._put(function, values)
        return function

    def _put(self, function: fem.Function, values: np.ndarray) -> None:
        array, cells = function.x.array.reshape(values.shape), function.function_space.dofmap.list[:, 0]
        if not np.array_equal(array[cells], values):
            array[cells] = values
            self._known.clear()

    def _expression(self, expression) -> fem.Expression | None:
        expression = ufl.algorithms.expand_derivatives(expression)
        if isinstance(expression, ufl.classes.Zero):
            return None
        if ufl.domain.extract_unique_domain(expression) is None:  # numbers alone, which DOLFINx does not compile
            expression = fem.Constant(self._mesh, 1.0) * expression
        return compiled_expression(expression, np.array([[0.5]]), with_constants)

    def _evaluate(self, expression: fem.Expression | None, z: np.ndarray, *shape: int,
                  points: np.ndarray | slice = EVERY) -> np.ndarray:
        if not self._count or expression is None:
            return np.zeros((len(np.arange(self._count)[points]), *shape))
        self._put(self._z, z)
        if self._constant.value != (factor := self._factor()):
            self._constant.value = factor
            self._known.clear()
        if points is not EVERY:
            return expression.eval(self._mesh, self._cells[points]).reshape(-1, *shape)
        if expression not in self._known:
            self._known[expression] = expression.eval(self._mesh, self._cells)
            self._known[expression].flags.writeable = False
        return self._known[expression].reshape(-1, *shape)

    def _weighted(self, expression: fem.Expression | None, z: np.ndarray, *shape: int,
                  points: np.ndarray | slice = EVERY) -> np.ndarray:
        return self._evaluate(expression, z, *shape, points=points) * self._weights[points].reshape(
            -1, *(1,) * len(shape))

    def forces(self, z: np.ndarray) -> np.ndarray:
        """Forces alone."""
        return self._weighted(self._force if self._count else None, z, self._size)

    def __call__(self, z: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Forces and stiffness."""
        return self.forces(z), self.stiffness(z)

    def stiffness(self, z: np.ndarray, points: np.ndarray | slice = EVERY) -> np.ndarray:
        """Stiffness at some of the points."""
        if not self._count:
            return np.zeros((0, self._size, self._size))
        self._put(self._held, self.extrapolated(z, np.zeros_like(z)))
        return self._weighted(self._stiffness, z, self._size, self._size, points=points)

    def extrapolated(self, z: np.ndarray, change: np.ndarray) -> np.ndarray:
        """Resultants at z, and their linear change by a change of z."""
        if not self._count:
            return np.zeros((0, 0))
        self._put(self._change, change)
        return self._evaluate(self._resultants, z, self._held.function_space.dofmap.bs)

    def holding(self, resultants: np.ndarray, z: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Forces of given resultants, and stiffness in which these stand for those at z.

        The mixed integration point tangent (Magisano, Leonetti and Garcea 2017).
        """
        if not self._count:
            return np.zeros((0, self._size)), np.zeros((0, self._size, self._size))
        self._put(self._held, resultants)
        return self._weighted(self._holding, z, self._size), self._weighted(self._stiffness, z, self._size, self._size)

    @cached_property
    def _of_strains(self) -> list[fem.Expression | None]:
        """Derivatives of strains by z, then resultants and moduli as functions of strains that are given."""
        given = ufl.variable(self._held)
        resultants = self._law(given)
        return [self._expression(e) for e in (
            ufl.diff(self._measure, self._variable), resultants, ufl.diff(resultants, given))]

    def slopes(self, z: np.ndarray) -> np.ndarray:
        """Derivatives of the strains at z, shape (points, strains, m)."""
        return self._evaluate(self._of_strains[0], z, self._held.function_space.dofmap.bs, self._size)

    def resultants_of(self, strains: np.ndarray, z: np.ndarray) -> np.ndarray:
        """Resultants of given strains, times the weights."""
        self._put(self._held, strains)
        return self._weighted(self._of_strains[1], z, strains.shape[1])

    def moduli_of(self, strains: np.ndarray, z: np.ndarray) -> np.ndarray:
        """Moduli of given strains, times the weights."""
        self._put(self._held, strains)
        return self._weighted(self._of_strains[2], z, strains.shape[1], strains.shape[1])

    @cached_property
    def _energy(self) -> fem.Expression | None:
        return self._expression(ufl.as_vector([self._density]))

    def energy(self, z: np.ndarray) -> float:
        """Work of the resultants on the way to the strains at z, of all points of this process."""
        return float(self._weighted(self._energy, z, 1).sum()) if self._count else 0.0

    def load(self, z: np.ndarray) -> np.ndarray:
        """Derivative of the external forces by the load factor."""
        return self._weighted(self._pull if self._count else None, z, self._size)
