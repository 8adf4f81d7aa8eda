"""Gap and slip against the closest point of a surface, and their first and second derivatives.

The coordinates of the closest point are eliminated from (x - y) . y,a = 0 (Laursen and Simo 1993, section 2; Wriggers
2006, section 4.1): derivatives of the gap need two derivatives of the surface by its coordinates, the slip's
three.
"""

from __future__ import annotations

from functools import cached_property

import numpy as np

ROWS = 1, 1, 2, 3  # of z: place of the point, place of the surface, first and second derivatives of the latter
SIZE = 3 * sum(ROWS)
_EYE = np.eye(SIZE).reshape(sum(ROWS), 3, SIZE)
APART, SLOPES = _EYE[0] - _EYE[1], _EYE[2:4]  # variations of x - y and of the first derivatives
CURVATURES = _EYE[[[4, 5], [5, 6]]]


class ClosestPoint:
    """Points, and the points of a surface that are closest to them.

    Derivatives are by z = (x, y, y,1, y,2, y,11, y,12, y,22).

    Parameters
    ----------
    apart : shape (n, 3), from the surface to the points
    slopes : shape (n, 2, 3), first derivatives of the surface's place by its coordinates
    curvatures, thirds : shapes (n, 2, 2, 3) and (n, 2, 2, 2, 3), the second and third ones

    Attributes
    ----------
    normal : shape (n, 3)
    distance, length : shape (n,), along the normal, with its sign; and to the point of the surface
    """

    def __init__(self, apart: np.ndarray, slopes: np.ndarray, curvatures: np.ndarray, thirds: np.ndarray):
        self._apart, self._slopes, self._curvatures, self._thirds = apart, slopes, curvatures, thirds
        normal = np.cross(slopes[:, 0], slopes[:, 1])
        self.normal = normal / np.linalg.norm(normal, axis=1, keepdims=True)
        self.distance, self.length = (self.normal * apart).sum(axis=1), np.linalg.norm(apart, axis=1)
        self._metric = np.einsum("nad,nbd->nab", slopes, slopes)
        self._bend = np.einsum("nd,nabd->nab", self.normal, curvatures)
        self._inverse = np.linalg.inv(self._metric - self.distance[:, None, None] * self._bend)

    @cached_property
    def _tilt(self) -> np.ndarray:
        """Variation of the slopes along the normal, at fixed coordinates."""
        return np.einsum("nd,adz->naz", self.normal, SLOPES)

    @cached_property
    def moves(self) -> np.ndarray:
        """Derivative of the coordinates of the closest point, shape (n, 2, SIZE)."""
        return self._inverse @ (self._slopes @ APART + self.distance[:, None, None] * self._tilt)

    def of_distance(self) -> np.ndarray:
        """Derivative of the signed distance, shape (n, SIZE)."""
        return self.normal @ APART

    def second_of_distance(self) -> np.ndarray:
        """Second derivative of the signed distance, shape (n, SIZE, SIZE)."""
        turn = self._tilt + self._bend @ self.moves
        mixed = _transposed(self._tilt) @ self.moves
        bent = _transposed(self.moves) @ self._bend @ self.moves
        lengthened = _transposed(turn) @ np.linalg.inv(self._metric) @ turn
        return self.distance[:, None, None] * lengthened - mixed - _transposed(mixed) - bent

    def second_of_coordinates(self, weights: np.ndarray) -> np.ndarray:
        """Second derivative of a sum of the coordinates with weights (n, 2), shape (n, SIZE, SIZE)."""
        share = (self._inverse @ weights[:, :, None])[:, :, 0]
        moves, back = self.moves, _transposed(self.moves)
        slopes = SLOPES + np.einsum("nabd,nbz->nadz", self._curvatures, moves)
        apart = APART - np.einsum("nad,naz->ndz", self._slopes, moves)
        along = np.einsum("na,nad->nd", share, self._slopes)
        linear = (np.einsum("na,nd,abdz->nbz", share, self._apart, CURVATURES)
                  - np.einsum("nd,adz->naz", along, SLOPES))
        quadratic = (np.einsum("na,nabcd,nd->nbc", share, self._thirds, self._apart)
                     - np.einsum("nd,nabd->nab", along, self._curvatures))
        mixed = back @ linear + np.einsum("na,nady,ndz->nyz", share, slopes, apart)
        return mixed + _transposed(mixed) + back @ quadratic @ moves


def _transposed(matrices: np.ndarray) -> np.ndarray:
    return matrices.transpose(0, 2, 1)
