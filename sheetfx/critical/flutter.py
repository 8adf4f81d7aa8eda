"""Flutter: where two frequencies of a structure under loads that follow it meet and become complex.

Under loads without a potential a structure can lose its stability while its tangent stays regular: two squares of
frequencies of small vibrations, K mode = omega^2 M mode, meet on the real axis and leave it as a conjugate pair
(Bolotin 1963; Ziegler 1968). Beyond, motions oscillate and grow. Squares that coincide without acting on each other, as
those of equal bending in two planes, of torsion beside bending, or of two waves of a ring, stay real.

Between two states of a path all squares nearest to zero are followed at once, by the tangents and masses of both on the
modes of both (`_Between`); where that shows pairs that begin or end, the step is cut there until states on both sides
of each point say the same.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from math import inf

import numpy as np
from petsc4py import PETSc
from scipy.linalg import eigvals
from scipy.optimize import minimize_scalar

from ..continuation.segment import Jump, Missed, Segment
from ..continuation.spectrum import nearest_pairs
from ..continuation.state import CriticalPoint, State
from ..rounding import NONE
from .vibration import is_complex, mass_matrix

COUNT = 12  # squares of frequencies, those nearest to zero, that are followed beside those that flutter already
KNOWN = 1 - 1e-6  # of the largest square that is found, size up to which all are known
ROUNDED = 1e-5  # of the load, distance of points between which rounding parts squares that have met, or joins them
JUST_MET = 0.01  # imaginary part over the size, at most, of a pair that has begun there
NEAR = 0.01  # of a piece of path, distance from where a pair seems to begin of the states that are looked at
SAMPLES, BESIDE = 17, 0.05  # places that are looked at between two states, the outermost a part of the way beyond
FINE = 1e-6  # part of the way between two states, error of where a pair begins by the modes of both
CLOSING = 1 / 3  # of the sum of those beside it, difference of squares that may touch: a quarter if they cross evenly
TOUCHING = 1e-6  # of the largest square, difference of those that always coincide


@dataclass(frozen=True)
class _Spectrum:
    """Squares of frequencies of a state, those nearest to zero, and what they follow from.

    Attributes
    ----------
    reach : size up to which all squares are known
    modes : this process's part, real and imaginary parts in columns of their own
    """

    squares: np.ndarray
    reach: float
    modes: np.ndarray
    tangent: PETSc.Mat
    mass: PETSc.Mat


def _pairs(squares: np.ndarray, reach: float, most: float = inf) -> int:
    """Number of complex pairs up to a size, and up to an imaginary part over the size."""
    return sum(v.imag > 0 and is_complex(v) and abs(v) <= reach and v.imag <= most * abs(v) for v in squares.tolist())


class Flutter:
    """Looks for flutter in the steps of a path whose tangent is not symmetric and whose parts have densities."""

    def __init__(self, tracer):
        self._tracer, self._mass = tracer, mass_matrix(tracer.discretisation)
        self._comm = tracer.system.comm
        self._last: tuple[State, _Spectrum] | None = None

    @staticmethod
    def concerns(tracer) -> bool:
        """Whether flutter is possible, and can be looked for."""
        return not tracer.discretisation.massless and tracer.system.smooth and not tracer.system.conservative

    def __call__(self, segment: Segment) -> list[CriticalPoint]:
        """Points at which two frequencies meet, or part again, in a step."""
        before = self._last[1] if self._last and self._last[0] is segment.before else self._at(segment, 0.0)
        after = self._at(segment, segment.after.length, COUNT + 2 * _pairs(before.squares, before.reach))
        self._last = segment.after, after
        try:
            return _told_apart(self._points(segment, 0.0, segment.after.length, (before, after)))
        except Missed:
            if segment.guarded:
                raise Jump("the states about a flutter do not converge") from None
            return []

    def _at(self, segment: Segment, length: float, count: int = COUNT) -> _Spectrum:
        """Spectrum of a state of the step.

        Raises
        ------
        Jump, Missed
        """
        tracer = self._tracer
        tracer.factorise_at(segment[length])
        mass = self._mass().copy()
        found = nearest_pairs(tracer.stepper.linear, mass, count)
        squares = np.array([value for value, *_ in found])
        parts = [part.array for value, *both in found if value.imag >= 0 for part in both[:1 + (value.imag > 0)]]
        modes = np.column_stack(parts) if parts else np.empty((mass.getLocalSize()[0], 0))
        return _Spectrum(squares, KNOWN * np.abs(squares).max(initial=0.0), modes, tracer.system.matrix.copy(), mass)

    def _points(self, segment: Segment, left: float, right: float, ends: tuple[_Spectrum, _Spectrum],
                parent: float = inf) -> list[CriticalPoint]:
        """Points between two lengths whose spectra are given, on a piece of a parent, by ever nearer states.

        Where squares have met a little rounding parts them, or joins them: on a piece of one that has a point the
        states at its ends are believed, where the modes of both show none.
        """
        lengths = [left + part * (right - left) for part in _Between(self._comm, *ends).changes()]
        if not lengths and parent < inf and _change(ends):
            lengths = [(left + right) / 2]
        if not lengths:
            return []
        size = max(abs(segment.after.factor), abs(segment.after.load_increment))
        if segment.load_change(segment[left], right - left) <= segment.tracer.control.exact * size:
            return _met(segment, left, right, ends)
        near = NEAR * (right - left)
        first, last = ([s for s, other in neighbours if abs(s - other) > 2 * near] for neighbours in (
            zip(lengths, [-inf, *lengths[:-1]], strict=True), zip(lengths, [*lengths[1:], inf], strict=True)))
        wanted = {*(s - near for s in first), *(s + near for s in last)}
        if right - left > parent / 2:
            wanted.add((left + right) / 2)
        cuts = [left, *sorted(s for s in wanted if left < s < right), right]
        spectra = [ends[0], *(self._at(segment, s, len(ends[1].squares)) for s in cuts[1:-1]), ends[1]]
        return [point for piece, both in zip(pairwise(cuts), pairwise(spectra), strict=True)
                for point in self._points(segment, *piece, both, right - left)]


def _told_apart(points: Sequence[CriticalPoint]) -> list[CriticalPoint]:
    """Points of a step in their order, those that follow each other as closely as rounding tells as one.

    Squares that meet depend on rounding by its root: their pair begins and ends several times within a stretch of load
    that grows with the stiffest part over the softest. What counts is how many pairs there are behind it.
    """
    together: list[list[CriticalPoint]] = []
    for point in points:
        if together and abs(point.load - together[-1][-1].load) <= ROUNDED * abs(point.load):
            together[-1].append(point)
        else:
            together.append([point])
    found = []
    for group in together:
        change = sum(p.multiplicity if p.name == "begins" else -p.multiplicity for p in group)
        if change:
            name = "begins" if change > 0 else "ends"
            first = next(p for p in group if p.name == name)
            found.append(replace(first, multiplicity=abs(change)))
    return found


def _met(segment: Segment, left: float, right: float, ends: tuple[_Spectrum, _Spectrum]) -> list[CriticalPoint]:
    """The point between two states that lie together, at one of which pairs are nearly real.

    Others, which pass the size up to which squares are known, do not count.
    """
    change = _change(ends, JUST_MET)
    load, deflection = ((getattr(segment[left], name) + getattr(segment[right], name)) / 2
                        for name in ("load", "deflection"))
    if not change:
        return []
    return [CriticalPoint("flutter", load, deflection, segment.after.step, (left + right) / 2, abs(change),
                          name="begins" if change > 0 else "ends")]


def _change(ends: tuple[_Spectrum, _Spectrum], most: float = inf) -> int:
    """Change of the number of complex pairs, up to an imaginary part over the size."""
    reach = min(end.reach for end in ends)
    before, after = (_pairs(end.squares, reach, most) for end in ends)
    return after - before


class _Between:
    """Squares of frequencies between two states, by the tangents and masses of both on the modes of both.

    At the states these are the squares that are known there; between them tangents and masses are interpolated.
    """

    def __init__(self, comm, one: _Spectrum, other: _Spectrum):
        self._reach = min(one.reach, other.reach)
        modes = np.hstack([one.modes, other.modes])
        tangents, masses = ([_projected(comm, matrix, modes) for matrix in both] for both in (
            (one.tangent, other.tangent), (one.mass, other.mass)))
        scale = 1 / np.sqrt(np.diag(masses[0] + masses[1]))
        sizes, span = np.linalg.eigh(scale[:, None] * (masses[0] + masses[1]) * scale)
        span = scale[:, None] * span[:, sizes > NONE] / np.sqrt(sizes[sizes > NONE])
        self._tangents, self._masses = ([span.T @ m @ span for m in both] for both in (tangents, masses))

    def _squares(self, part: float) -> np.ndarray:
        tangent, mass = ((1 - part) * one + part * other for one, other in (self._tangents, self._masses))
        values = eigvals(tangent, mass)
        return values[np.abs(values) <= self._reach]

    def changes(self) -> list[float]:
        """Parts of the way from one state to the other where the number of complex pairs changes, in ascending order.

        Pairs that begin and end between two places that are looked at are seen where two squares come close.
        """
        if not self._reach:
            return []
        grid = np.linspace(-BESIDE, 1 + BESIDE, SAMPLES)
        squares = [self._squares(part) for part in grid]
        places = {0.0, 1.0, *grid[1:-1]} | set(self._close(grid, squares))
        found = []
        for left, right in pairwise(sorted(places)):
            before, after = self._pairs(left), self._pairs(right)
            while before != after and right - left > FINE:
                middle = (left + right) / 2
                if self._pairs(middle) == before:
                    left = middle
                else:
                    right = middle
            if before != after:
                found.append((left + right) / 2)
        return found

    def _pairs(self, part: float) -> int:
        return _pairs(self._squares(part), self._reach)

    def _close(self, grid: Sequence[float], squares: Sequence[np.ndarray]) -> Iterator[float]:
        """Places where neighbouring squares are nearer to each other than on both sides."""
        for n in range(1, len(grid) - 1):
            if len({len(values) for values in squares[n - 1:n + 2]}) > 1:
                continue
            gaps = [_gaps(values) for values in squares[n - 1:n + 2]]
            falls = gaps[1] < CLOSING * (gaps[0] + gaps[2])
            for number in np.flatnonzero(falls & (gaps[1] > TOUCHING * self._reach)):
                yield self._closest(number, grid[n - 1], grid[n + 1])

    def _closest(self, number: int, left: float, right: float) -> float:
        """Place where two neighbouring squares are nearest to each other."""
        def gap(part: float) -> float:
            gaps = _gaps(self._squares(part))
            return gaps[number] if number < len(gaps) else np.inf

        bounds = max(left, 0.0), min(right, 1.0)
        return float(minimize_scalar(gap, bounds=bounds, method="bounded", options={"xatol": FINE}).x)


def _gaps(squares: np.ndarray) -> np.ndarray:
    """Differences of neighbouring squares; zero for complex pairs."""
    return np.diff(np.sort(squares.real))


def _projected(comm, matrix: PETSc.Mat, modes: np.ndarray) -> np.ndarray:
    """Product of a matrix with modes from both sides."""
    vector, product = matrix.createVecs()
    columns = np.empty_like(modes)
    for n, mode in enumerate(modes.T):
        vector.array[:] = mode
        matrix.mult(vector, product)
        columns[:, n] = product.array
    return comm.allreduce(modes.T @ columns)
