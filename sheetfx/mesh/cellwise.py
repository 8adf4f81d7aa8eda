"""Fields that know one cell only: what a mesh is like inside each of its cells."""

from __future__ import annotations

import basix
from dolfinx import fem

from ..compat import geometry_degree, interpolation_points
from ..jit import compiled_expression

SIMPLICES = basix.CellType.interval, basix.CellType.triangle


def cellwise(domain, expression, degree: int | None = None) -> fem.Function:
    """A UFL vector as a polynomial in each cell, so that its gradient can be taken.

    Parameters
    ----------
    degree : of the polynomials; None: the geometry's, whose nodes they are interpolated at; 0: the middle's value
    """
    family = "DG" if domain.basix_cell() in SIMPLICES else "DQ"
    degree = geometry_degree(domain) if degree is None else degree
    values = fem.Function(fem.functionspace(domain, (family, degree, expression.ufl_shape)))
    values.interpolate(compiled_expression(expression, interpolation_points(values.function_space)))
    return values
