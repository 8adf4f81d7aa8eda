"""Section laws evaluated outside the kernels of the strains, at given strains."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import ufl
from dolfinx.mesh import Mesh

from ..mesh.quadrature import Rule
from .densities import at_points, put, values_at_points


class FormulaLaw:
    """A law written in UFL.

    Parameters
    ----------
    law : function from a UFL vector of strains to one of resultants
    size : number of strains
    domain, cells, rule : where it is evaluated
    """

    def __init__(self, law: Callable, size: int, domain: Mesh, cells: np.ndarray, rule: Rule):
        self._domain, self._cells, self._size = domain, cells, size
        self._given, self._rows = values_at_points(domain, cells, rule, (size,))
        strains = ufl.variable(self._given)
        resultants = law(strains)
        moduli = ufl.diff(resultants, strains)
        self._values = at_points(ufl.as_vector(
            [resultants[i] for i in range(size)] + [moduli[i, j] for i in range(size) for j in range(size)]),
            domain, rule.points)

    def __call__(self, chunk: slice, strains: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Resultants (cells, points, n) and moduli (cells, points, n, n) of strains (cells, points, n)."""
        put(self._given, self._rows[chunk], strains)
        values = self._values.eval(self._domain, self._cells[chunk]).reshape(*strains.shape[:2], -1)
        return values[..., :self._size], values[..., self._size:].reshape(*strains.shape, self._size)
