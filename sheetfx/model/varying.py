"""Sections whose measures, such as thickness or depth, are functions of the place."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import fields, replace
from typing import TYPE_CHECKING, Any

import basix
import basix.ufl
import numpy as np
import ufl
from dolfinx import fem

from ..checks import Positive
from ..communicators import lasting
from ..compat import interpolation_points
from ..jit import compiled_expression
from ..mesh.cellwise import SIMPLICES
from ..mesh.numbers import as_constants, mapped

if TYPE_CHECKING:
    Measure = Any
else:
    Measure = Positive | Callable  # a number, or a function from the place, a UFL vector, to one


def varying(section) -> list[str]:
    """Names of the measures of a section that are functions."""
    return [f.name for f in fields(section) if callable(getattr(section, f.name))] if hasattr(
        section, "__dataclass_fields__") else []


def require_uniform(part, what: str) -> None:
    """Refuse a section with measures that are functions, where one number is needed."""
    if names := varying(part.section):
        raise ValueError(f"{what}: {names[0]} of the {type(part.section).__name__} of a {type(part).__name__} is a "
                         "function of the place; give a part for each group with numbers")


class VaryingSection:
    """The sections of a part at points inside its cells.

    Points are Gauss's, so that a step of a measure between two cells stays one, and on intervals and quadrilaterals
    numbers are exact at the points of integration.

    Parameters
    ----------
    part : with mesh, section and group
    degree : of the polynomials in each cell by which numbers are interpolated

    Raises
    ------
    ValueError
        Where a measure is no number that the section accepts, on all processes.
    """

    def __init__(self, part, degree: int):
        self._domain, self._section, self._names = part.mesh.domain, part.section, varying(part.section)
        self._cells = part.mesh.group(part.group)
        self._degree, self._title = degree, f"{type(part).__name__} on group {part.group or 'all'!r}"
        if not self._names:
            self.typical = part.section
            return
        space = self._space(())
        points, cells = interpolation_points(space), self._cells
        x = ufl.SpatialCoordinate(self._domain)
        table = compiled_expression(ufl.as_vector([*(self._measure(n, x) for n in self._names), *x]), points)
        found = table.eval(self._domain, cells).reshape(len(cells) * len(points), -1)
        measures, first, self._which = np.unique(found[:, :len(self._names)], axis=0, return_index=True,
                                                 return_inverse=True)
        self._which = self._which.reshape(len(cells), len(points))
        self._sections, said = [], None
        try:
            for row, place in zip(measures, found[first, len(self._names):], strict=True):
                self._sections.append(self._made(row, place))
        except ValueError as error:
            said = str(error)
        told = lasting(self._domain.comm).allgather((said, self._sections[:1]))
        if said := next((words for words, _ in told if words), None):
            raise ValueError(said)
        self.typical = next(some[0] for _, some in told if some)

    def _measure(self, name: str, x):
        given = getattr(self._section, name)
        value = given if isinstance(given, ufl.core.expr.Expr) else given(x)
        if not isinstance(value, (int, float)) and getattr(value, "ufl_shape", None) != ():
            raise ValueError(f"{self._title}: {name} gives {value!r} of its {type(self._section).__name__}; give "
                             "one number, in UFL where it depends on the place")
        return value + 0 * x[0]

    def _made(self, row: np.ndarray, place: np.ndarray):
        try:
            return replace(self._section, **dict(zip(self._names, map(float, row), strict=True)))
        except ValueError as error:
            raise ValueError(f"{self._title}: at the place {place.round(9).tolist()} {error}") from error

    def _space(self, shape: tuple):
        family = "P" if self._domain.basix_cell() in SIMPLICES else "Q"
        element = basix.ufl.element(family, self._domain.basix_cell(), self._degree, shape=shape,
                                    lagrange_variant=basix.LagrangeVariant.gl_warped, discontinuous=True)
        return fem.functionspace(self._domain, element)

    def in_cells(self, function: Callable) -> np.ndarray:
        """An array that a function makes of a section, in the middle one of each cell's points or the one before it."""
        if not self._names:
            return np.asarray(function(self._section), float)[None]
        return np.array([function(section) for section in self._sections])[self._which[:, self._which.shape[1] // 2]]

    def numbers(self, function: Callable):
        """A nest of numbers that a function makes of a section, as constants, or as fields where measures vary."""
        if not self._names:
            return as_constants(self._domain, function(self._section))
        rows = [_flat(function(section)) for section in self._sections]
        size = len(_flat(function(self.typical)))
        table = np.array(rows).reshape(len(rows), size)
        there = np.abs(table).max(axis=0, initial=0.0) > 0
        there = np.any(lasting(self._domain.comm).allgather(there), axis=0)
        space = self._space((int(there.sum()),))
        field = fem.Function(space)
        rows = space.dofmap.list[self._cells].ravel()
        field.x.array.reshape(-1, there.sum())[rows] = table[:, there][self._which.ravel()]
        components = iter(np.where(there, np.cumsum(there) - 1, -1).tolist())
        return mapped(function(self.typical), lambda _: field[i] if (i := next(components)) >= 0 else 0.0)


def _flat(nest) -> list[float]:
    found: list[float] = []
    mapped(nest, found.append)
    return found
