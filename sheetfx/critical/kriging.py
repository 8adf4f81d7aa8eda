"""A normal process through values at places, which tells how well it knows what lies between (Krige 1951).

The values are a constant, unknown one, and a process of normal values whose covariance at a distance r is

    variance exp(-r^2 / (2 length^2)),

with an independent part at each place, as of kinks. Length and share of that part are the likeliest (Rasmussen and
Williams 2006, sections 2.7 and 5.4).
"""

from __future__ import annotations

import numpy as np
from scipy.linalg import cho_factor, cho_solve
from scipy.optimize import minimize
from scipy.spatial.distance import cdist

from ..rounding import NONE

STARTS = (1.0, 1e-2), (3.0, 1e-2)  # lengths, and shares of the independent part, from which the likeliest are sought


class Kriging:
    """A process through values at places.

    Parameters
    ----------
    places, values : shapes (n, dimension) and (n,)

    Attributes
    ----------
    length, share : of the covariance, and of its independent part in the variance at a place
    """

    def __init__(self, places: np.ndarray, values: np.ndarray):
        self._places, self._squares = places, cdist(places, places, "sqeuclidean")
        self._size = float(np.std(values)) or 1.0
        self._values = (values - np.mean(values)) / self._size
        self._offset = float(np.mean(values))
        found = [minimize(self._unlikely, np.log(start), method="Nelder-Mead") for start in STARTS]
        self.length, self.share = np.exp(min(found, key=lambda one: one.fun).x)
        self._solve(self.length, self.share)

    def _solve(self, length: float, share: float) -> float:
        """Factor the covariance; its logarithm of the likelihood, negative and without constants."""
        count = len(self._values)
        self._factor = cho_factor(np.exp(-self._squares / (2 * length**2)) + (share + NONE) * np.eye(count), lower=True)
        ones = cho_solve(self._factor, np.ones(count))
        self._ones, self._weight = ones, float(ones.sum())
        self._level = float(ones @ self._values) / self._weight
        self._rest = cho_solve(self._factor, self._values - self._level)
        self._variance = max(float((self._values - self._level) @ self._rest) / count, NONE)
        return count / 2 * np.log(self._variance) + float(np.log(np.diag(self._factor[0])).sum())

    def _unlikely(self, logarithms: np.ndarray) -> float:
        try:
            return self._solve(*np.exp(logarithms))
        except np.linalg.LinAlgError:
            return np.inf

    def _covariance(self, places: np.ndarray, others: np.ndarray) -> np.ndarray:
        return np.exp(-cdist(places, others, "sqeuclidean") / (2 * self.length**2))

    def mean(self, places: np.ndarray) -> np.ndarray:
        """Expected values at places, shape (m,)."""
        return self._offset + self._size * (self._level + self._covariance(places, self._places) @ self._rest)

    def deviation(self, places: np.ndarray) -> np.ndarray:
        """Standard deviations of the values at places, shape (m,)."""
        across = self._covariance(places, self._places)
        left = 1 + self.share - np.einsum("ij,ji->i", across, cho_solve(self._factor, across.T))
        left += (1 - across @ self._ones) ** 2 / self._weight
        return self._size * np.sqrt(self._variance * np.maximum(left, 0.0))

    def draws(self, places: np.ndarray, count: int, random: np.random.Generator) -> np.ndarray:
        """Values that the process may have at places, shape (count, m)."""
        across = self._covariance(places, self._places)
        off = 1 - across @ self._ones
        left = self._covariance(places, places) - across @ cho_solve(self._factor, across.T)
        left += np.outer(off, off) / self._weight + self.share * np.eye(len(places))
        values, vectors = np.linalg.eigh(left)
        root = vectors * np.sqrt(np.maximum(values, 0.0) * self._variance)
        return self.mean(places) + self._size * random.standard_normal((count, len(places))) @ root.T
