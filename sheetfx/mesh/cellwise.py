"""Fields that know one cell only: what a mesh is like inside each of its cells."""

from __future__ import annotations

import basix
from dolfinx import fem

from ..compat import JIT, geometry_degree, interpolation_points

SIMPLICES = basix.CellType.interval, basix.CellType.triangle


def cellwise(domain, expression) -> fem.Function:
    """A UFL vector interpolated at the nodes of each cell's geometry, so that its gradient can be taken."""
    family = "DG" if domain.basix_cell() in SIMPLICES else "DQ"
    values = fem.Function(fem.functionspace(domain, (family, geometry_degree(domain), expression.ufl_shape)))
    values.interpolate(fem.Expression(expression, interpolation_points(values.function_space), jit_options=JIT))
    return values
