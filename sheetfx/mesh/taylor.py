"""Taylor series of functions of two variables, up to third order, at many points at once.

Rational shape functions are written as they stand in a formula, and bring their derivatives along.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import factorial

import numpy as np

POWERS = [(total - j, j) for total in range(4) for j in range(total + 1)]
SIZES = [(order + 1) * (order + 2) // 2 for order in range(4)]
_FACTORIALS = np.array([factorial(i) * factorial(j) for i, j in POWERS], dtype=float)


def _products(order: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Numbers of the terms of both factors that are multiplied, and the matrix that sums them up."""
    powers = POWERS[:SIZES[order]]
    pairs = [(a, b) for a in range(len(powers)) for b in range(len(powers)) if sum(powers[a] + powers[b]) <= order]
    sums = np.zeros((len(powers), len(pairs)))
    for number, (a, b) in enumerate(pairs):
        sums[powers.index((powers[a][0] + powers[b][0], powers[a][1] + powers[b][1])), number] = 1.0
    return *np.array(pairs).T, sums


_PRODUCTS = [_products(order) for order in range(4)]


class Taylor:
    """Terms of a series: coefficients of 1, x, y, x², xy, y², and so on up to an order.

    Attributes
    ----------
    terms : shape (terms, ...)
    """

    __array_ufunc__ = None

    def __init__(self, terms: np.ndarray):
        self.terms = terms

    @classmethod
    def linear(cls, values: np.ndarray, slopes: np.ndarray, order: int) -> Taylor:
        """Linear functions with values (..., n) and slopes (..., 2) that are the same at all points."""
        terms = np.zeros((SIZES[order], *values.shape))
        terms[0] = values
        if order:
            terms[1], terms[2] = slopes[..., 0, None], slopes[..., 1, None]
        return cls(terms)

    @classmethod
    def several(cls, functions: Sequence[Taylor]) -> Taylor:
        """Functions one behind the other, along a first axis."""
        return cls(np.stack([f.terms for f in functions], axis=1))

    def derivatives(self) -> np.ndarray:
        """Values and partial derivatives, in the order of the terms."""
        return self.terms * _FACTORIALS[:len(self.terms)].reshape(-1, *[1] * (self.terms.ndim - 1))

    def __getitem__(self, which) -> Taylor:
        """Some of the functions: an index into the axes behind the terms."""
        return Taylor(self.terms[:, which])

    def __add__(self, other: Taylor | float) -> Taylor:
        if isinstance(other, Taylor):
            return Taylor(self.terms + other.terms)
        terms = self.terms.copy()
        terms[0] += other
        return Taylor(terms)

    def __mul__(self, other: Taylor | float) -> Taylor:
        if not isinstance(other, Taylor):
            return Taylor(self.terms * other)
        first, second, sums = _PRODUCTS[SIZES.index(len(self.terms))]
        return Taylor(np.tensordot(sums, self.terms[first] * other.terms[second], 1))

    def times(self, other: Taylor) -> Taylor:
        """Products of several functions, along the first axis, with another one."""
        return self * Taylor(other.terms[:, None])

    def reciprocal(self) -> Taylor:
        """1 / f = (1 - r + r² - r³) / f(0), where r = f / f(0) - 1."""
        start = self.terms[0]
        rest = Taylor(self.terms / start)
        rest.terms[0] = 0.0
        found = Taylor(np.zeros_like(rest.terms)) + 1.0
        for _ in range(SIZES.index(len(self.terms))):
            found = rest * found * -1.0 + 1.0
        return Taylor(found.terms / start)

    def polynomial(self, coefficients: np.ndarray) -> Taylor:
        """A polynomial of the function, by coefficients of rising powers, whose own axes come first: (powers, ...)."""
        shape = coefficients.shape[1:]
        here = Taylor(self.terms.reshape(len(self.terms), *[1] * len(shape), *self.terms.shape[1:]))
        own = coefficients.reshape(*coefficients.shape, *[1] * (self.terms.ndim - 1))
        found = Taylor(np.zeros((len(self.terms), *shape, *self.terms.shape[1:]))) + own[-1]
        for row in own[-2::-1]:
            found = found * here + row
        return found
