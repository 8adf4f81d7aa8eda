"""Curves of critical points by whole paths, where the equations of a critical point do not hold.

What plasticity and friction remember depends on the way to the point, and contact and forces without a potential have
no third variations. Each point then lies on the path of its own structure: it has the same kind, and the null vector
most like the last one's.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from ..case import Case, trace
from ..checks import Count, require
from ..continuation.state import CriticalPoint
from ..critical.augmented import KINDS
from ..critical.curve import CurveEnds, CurvePoint
from ..critical.error_bar import ALIKE
from ..path import PathFailure
from ..record import Record

SHORTEST = 1 / 8  # part of a step, below which the point is given up as lost


@dataclass(frozen=True)
class _Found:
    """A critical point of a path, and its null vector in the scaled norm, this process's part."""

    point: CriticalPoint
    mode: np.ndarray


class CurveByPaths:
    """The curve of a critical point, an iterator over points, each by the whole path of its structure.

    ```python
    for point in fx.CurveByPaths(lambda friction: arch.case(friction=friction), 0.0, 0.4, steps=4):
        print(point)
    ```

    Parameters
    ----------
    case : function from the number to the case, of which only values change and nodes move
    at, to : first and last number
    number : of the critical point along the first path, from 1 on
    steps : equal parts of the range; a part is halved where no point of the next path is like the last one
    known : points of an interrupted curve, which goes on from there

    Attributes
    ----------
    factorisations : that its paths have taken

    Raises
    ------
    ValueError
        If both numbers are the same, or the first path has not so many limit points and bifurcations.
    CurveEnds
        While iterating, where a path fails, or has no point like the last one, however short the part.
    """

    def __init__(self, case: Callable[[float], Case], at: float, to: float, *, number: int = 1, steps: int = 20,
                 known: Sequence[CurvePoint] = ()):
        require("curve", at=(at, float), to=(to, float), number=(number, Count), steps=(steps, Count))
        if at == to:
            raise ValueError(f"curve: at and to are both {at:g}; give a range of the number")
        self._case, self._at, self._to, self._number, self._steps = case, at, to, number, steps
        self._known, self.factorisations = list(known), 0

    def __iter__(self) -> Iterator[CurvePoint]:
        known, longest = self._known, (self._to - self._at) / self._steps
        if known and known[-1].number == self._to:
            return
        here, found = (known[-1].number, self._again(known[-1])) if known else (self._at, self._first())
        if not known:
            yield self._point(here, found.point)
        length = longest
        while here != self._to:
            ahead = self._to if abs(self._to - here) < 1.5 * abs(length) else here + length
            alike = self._most_alike(ahead, found)
            if alike is None:
                length /= 2
                if abs(length) < SHORTEST * abs(longest):
                    raise CurveEnds(f"curve: at {ahead:g} no {found.point.kind} point is like that at {here:g}, load "
                                    f"{found.point.load:.6g}; what is before it is right")
                continue
            here, found, length = ahead, alike, longest
            yield self._point(here, found.point)

    @staticmethod
    def _point(number: float, point: CriticalPoint) -> CurvePoint:
        return CurvePoint(number, point.load, point.deflection, point.kind)

    def _first(self) -> _Found:
        points = self._points(self._at, KINDS)
        if self._number > len(points):
            raise ValueError(f"curve: point {self._number} is asked for, but the path at {self._at:g} has "
                             f"{len(points)} limit points and bifurcations; give one of these, begin at another value, "
                             "or let the path go further")
        return points[self._number - 1]

    def _again(self, known: CurvePoint) -> _Found:
        """The point of the last known number, by its path."""
        points = self._points(known.number, [known.kind])
        if not points:
            raise CurveEnds(f"curve: the path at {known.number:g} has no {known.kind} point any more; begin anew")
        return min(points, key=lambda one: abs(one.point.deflection - known.deflection))

    def _most_alike(self, number: float, last: _Found) -> _Found | None:
        points = self._points(number, [last.point.kind])
        if points and points[0].mode.shape != last.mode.shape:
            raise ValueError("curve: the number changes the unknowns of the structure; give one that changes values "
                             "and places only")
        cosines = [abs(_product(self._comm, one.mode, last.mode)) for one in points]
        alike = [one for one, cosine in zip(points, cosines, strict=True) if cosine >= ALIKE]
        return min(alike, key=lambda one: abs(one.point.deflection - last.point.deflection), default=None)

    def _points(self, number: float, kinds: Sequence[str]) -> list[_Found]:
        try:
            record = trace(self._case(number))
        except PathFailure as failure:
            raise CurveEnds(f"curve: the path at {number:g} fails ({failure}); what is before it is right") from failure
        self.factorisations += sum(state.factorisations for state in record.states)
        self._comm = record.path.discretisation.system.comm
        return [_Found(point, _scaled(record, point)) for point in record.critical_points if point.kind in kinds]


def _scaled(record: Record, point: CriticalPoint) -> np.ndarray:
    """The first null vector of a point, of length 1."""
    system = record.path.discretisation.system
    mode = record.critical_modes(point)[0] * np.sqrt(system.weights.array)
    return mode / _product(system.comm, mode, mode) ** 0.5


def _product(comm, one: np.ndarray, other: np.ndarray) -> float:
    return float(comm.allreduce(one @ other))
