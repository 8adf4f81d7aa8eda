"""Where a beam penetrates an obstacle: pieces of cells between the roots of the gap, with points of integration.

The pressure of a contact layer has a kink at the edge of the zone that touches. On fixed points the tangent jumps
whenever one of them comes to touch; on points that lie between the edges of the zone, wherever these are, forces and
tangent belong to exact integration, which change continuously as the zone slides and grows.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.polynomial import chebyshev, legendre

from ..rounding import SPLIT

SAMPLES = 5  # of the gap in a cell, which is a polynomial of degree 4 or nearly so
POINTS = 5  # in a piece, exact for the square of such a gap


@dataclass(frozen=True)
class Zones:
    """Points of integration, one row for each.

    Attributes
    ----------
    cells : (n,), numbers of their cells
    reference : (n,), places in the cells from 0 to 1
    weights : (n,), lengths on the reference cell that belong to them
    """

    cells: np.ndarray
    reference: np.ndarray
    weights: np.ndarray

    @classmethod
    def where_negative(cls, gaps: np.ndarray) -> Zones:
        """Zones in which an interpolated gap is negative.

        Parameters
        ----------
        gaps : shape (cells, SAMPLES), at `samples()`
        """
        near = np.flatnonzero(gaps.min(axis=1) < np.ptp(gaps, axis=1) / 4)
        fine = gaps[near] @ _FINE.T
        dips = np.abs(np.diff(fine, 2, axis=1)).max(axis=1, initial=0.0)
        inside, outside = ((sign * fine > dips[:, None]).all(axis=1) for sign in (-1, 1))
        pieces = [(cell, 0.0, 1.0) for cell in near[inside]]
        pieces += [(cell, *piece) for cell in near[~(inside | outside)]
                   for piece in _negative(_COEFFICIENTS @ gaps[cell])]
        cells, left, right = np.array(sorted(pieces)).reshape(-1, 3).T
        cells = cells.astype(np.int64)
        inside, weights = _RULE
        lengths = (right - left)[:, None]
        return cls(np.repeat(cells, POINTS), (left[:, None] + lengths * (1 + inside) / 2).ravel(),
                   (lengths * weights / 2).ravel())

    def interpolate(self, table: np.ndarray) -> np.ndarray:
        """Values at the points from values at samples, shape (cells, SAMPLES, ...)."""
        return np.einsum("ns,ns...->n...", self.rows, table[self.cells])

    @cached_property
    def rows(self) -> np.ndarray:
        """Rows that interpolate values at the samples of a cell, shape (n, SAMPLES)."""
        return chebyshev.chebvander(2 * self.reference - 1, SAMPLES - 1) @ _COEFFICIENTS


def samples() -> np.ndarray:
    """Places in a cell, from 0 to 1 and both included, at which values are taken for interpolation."""
    return (1 - np.cos(np.pi * np.arange(SAMPLES) / (SAMPLES - 1))) / 2


def _negative(coefficients: np.ndarray) -> list[tuple[float, float]]:
    """Pieces of a cell in which a polynomial is negative."""
    roots = chebyshev.chebroots(chebyshev.chebtrim(coefficients, np.finfo(float).eps * np.abs(coefficients).max()))
    real = np.sort(roots.real[np.abs(roots.imag) < SPLIT])
    edges = np.concatenate([[-1.0], real[np.abs(real) < 1], [1.0]])
    middles = chebyshev.chebval((edges[:-1] + edges[1:]) / 2, coefficients)
    return [((1 + a) / 2, (1 + b) / 2) for a, b, value in zip(edges[:-1], edges[1:], middles, strict=True)
            if value < 0]


_COEFFICIENTS = np.linalg.inv(chebyshev.chebvander(2 * samples() - 1, SAMPLES - 1))
_FINE = chebyshev.chebvander(np.linspace(-1, 1, 17), SAMPLES - 1) @ _COEFFICIENTS
_RULE = legendre.leggauss(POINTS)
