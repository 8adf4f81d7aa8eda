"""The rest of a tangent that is bordered by a few vectors near the modes that become unstable.

With these vectors Phi, and the weights W of the inner product, the small matrix

    G = (Phi^T W K^-1 W Phi)^-1

is singular where the tangent K is, with the same number of null vectors, and smooth along the path (Govaerts 2000,
chapter 3). Eigenvalues change their order where they pass zero together; G does not mind.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

import numpy as np
from petsc4py import PETSc
from scipy.interpolate import KroghInterpolator

from .. import rounding
from ..continuation.segment import Segment
from ..continuation.spectrum import diagonal, nearest_pairs

ABOUT = 1e-5  # relative error of modes that become unstable, near which vectors do


class Determinant:
    """The matrix G at states of a segment.

    Parameters
    ----------
    left, right : lengths between which `count` eigenvalues pass zero

    Attributes
    ----------
    numbers : of the eigenvalues of G, in ascending order, that have other signs at `left` than at `right`
    """

    def __init__(self, segment: Segment, left: float, right: float, count: int):
        self._segment, self._tracer = segment, segment.tracer
        self._weights = self._tracer.system.weights
        self._known: dict[float, tuple[np.ndarray, list[PETSc.Vec]]] = {}
        self._vectors = self._soft(right, self._modes_at(right, count))
        self.numbers = self._changing(left, right)
        if len(self.numbers) != count:
            self._vectors = self._soft(left, [*self._modes_at(left, count), *self._vectors])
            self.numbers = self._changing(left, right)
        self._left, self._right = (self._signs(s) for s in (left, right))

    def _modes_at(self, length: float, count: int) -> list[PETSc.Vec]:
        """Modes near zero at a state; of pairs that are not real, as friction makes of double ones, both parts."""
        tracer, system = self._tracer, self._tracer.system
        if system.conservative:
            return self._segment.spectrum(length, count + 2, ABOUT)[1]
        tracer.factorise_at(self._segment[length])
        with system.clock("solve"):
            pairs = nearest_pairs(tracer.stepper.linear, diagonal(self._weights), count + 2, ABOUT)
        return [part for value, *parts in pairs if value.imag >= 0 for part in parts[:1 + (value.imag > 0)]]

    def _soft(self, length: float, modes: Sequence[PETSc.Vec]) -> list[PETSc.Vec]:
        """Orthonormal vectors that span some modes but for those that do not yield, which a prescribed motion holds.

        G at the length is known with them.
        """
        vectors = orthonormal(self._weights, modes)
        inverse, solutions = self._inverse(length, vectors)
        _, sizes, rows = np.linalg.svd(inverse)
        soft = rows[sizes > rounding.NONE * sizes[0]]
        self._known = {length: (np.linalg.inv(soft @ inverse @ soft.T), _combined(soft, solutions))}
        return _combined(soft, vectors)

    def _inverse(self, length: float, vectors: Sequence[PETSc.Vec]) -> tuple[np.ndarray, list[PETSc.Vec]]:
        """The inverse of G at a state, and the solutions K^-1 W Phi."""
        self._tracer.factorise_at(self._segment[length])
        solutions = [vector.duplicate() for vector in vectors]
        with self._tracer.system.clock("solve"):
            self._tracer.stepper.linear.solve_all([self._weights * vector for vector in vectors], solutions)
        weighted = [self._weights * solution for solution in solutions]
        return np.array([[one.dot(other) for other in weighted] for one in vectors]), solutions

    def at(self, length: float) -> np.ndarray:
        """G at a state."""
        if length not in self._known:
            inverse, solutions = self._inverse(length, self._vectors)
            self._known[length] = np.linalg.inv(inverse), solutions
        return self._known[length][0]

    def _eigenvalues(self, matrix: np.ndarray) -> np.ndarray:
        """In ascending order; where some are not real, their real parts."""
        if self._tracer.system.conservative:
            return np.linalg.eigvalsh((matrix + matrix.T) / 2)
        return np.sort(np.linalg.eigvals(matrix).real)

    def _changing(self, left: float, right: float) -> list[int]:
        """Numbers of the eigenvalues of G that have other signs at one length than at another."""
        signs = [self._eigenvalues(self.at(s)) < 0 for s in (left, right)]
        return list(np.flatnonzero(signs[0] != signs[1]))

    def _signs(self, length: float) -> list[bool]:
        """Signs of the eigenvalues that pass zero."""
        return list(self._eigenvalues(self.at(length))[self.numbers] < 0)

    def change(self, left: float, right: float) -> float:
        """Of the eigenvalues that pass zero, from one length to another: the sum of its sizes."""
        one, other = (self._eigenvalues(self.at(s))[self.numbers] for s in (left, right))
        return float(np.abs(other - one).sum())

    def roots(self, samples: Sequence[float], places: Sequence[float] | None = None) -> np.ndarray:
        """Lengths at which eigenvalues pass zero, in ascending order, by an interpolation between states.

        Infinite if these are not on both sides.

        Parameters
        ----------
        places : of the samples, in another measure that grows or falls along the path
        """
        place = dict(zip(samples, samples if places is None else places, strict=True))
        before = [s for s in samples if self._signs(s) == self._left]
        behind = [s for s in samples if self._signs(s) == self._right]
        if not before or not behind:
            return np.full(len(self.numbers), np.inf)
        border = KroghInterpolator(list(place.values()), np.array([self.at(s) for s in samples]))
        ends = place[max(before)], place[min(behind)]

        def eigenvalue(number: int, length: float) -> float:
            return self._eigenvalues(border(length))[number]

        return np.sort([rounding.root(partial(eigenvalue, number), *ends) for number in self.numbers])

    def null_vectors(self, nearest: float) -> list[np.ndarray]:
        """About the null vectors of the tangent at crossings, from the solutions at a near state, the nearest first."""
        values, vectors = np.linalg.eigh((self.at(nearest) + self.at(nearest).T) / 2)
        found = []
        for number in sorted(self.numbers, key=lambda number: abs(values[number])):
            share = self.at(nearest) @ vectors[:, number]
            mode, = _combined(share[None], self._known[nearest][1])
            found.append(mode.array / self._tracer.distance(0.0, mode.array))
        return found


def _combined(shares: np.ndarray, vectors: Sequence[PETSc.Vec]) -> list[PETSc.Vec]:
    """Sums of shares of vectors, one for each row."""
    return [sum((float(c) * v for c, v in zip(row, vectors, strict=True)), 0.0 * vectors[0]) for row in shares]


def orthonormal(weights: PETSc.Vec, vectors: Sequence[PETSc.Vec]) -> list[PETSc.Vec]:
    """Vectors that span the same, orthonormal in the inner product with weights; those that add nothing left out."""
    found: list[PETSc.Vec] = []
    for vector in vectors:
        rest, size = vector.copy(), (weights * vector).dot(vector) ** 0.5
        for _ in range(2):
            for one in found:
                rest.axpy(-(weights * rest).dot(one), one)
        left = (weights * rest).dot(rest) ** 0.5
        if left > 1e-3 * size:
            rest.scale(1 / left)
            found.append(rest)
    return found
