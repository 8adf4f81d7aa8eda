"""Critical points on ever finer meshes until their loads are exact enough, found again without the path up to them.

The augmented Newton method takes a point from mesh to mesh; where it does not apply, as with contact or yielding, a
piece of the finer path finds it. Errors are bars by one degree more, on two meshes, and then follow from changes of the
load: by c / (r - 1) where a change c is r times less than the one before (Roache 1998). With contact or yielding the
first change is taken for the error.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..checks import require
from ..continuation.options import Share
from ..continuation.state import CriticalPoint, State
from ..continuation.transferred import between
from ..critical.augmented import KINDS, critical
from ..critical.defining import without_third_variations
from ..critical.error_bar import ALIKE, error_bars
from ..path import Path
from ..record import Record
from ..richer_path import RicherPath
from .climb import FALLING, SECOND_ORDER
from .first_point import unstable_beside
from .meshes import Meshes
from .models import quiet


@dataclass(frozen=True)
class Refined:
    """A critical point on the coarsest mesh that is fine enough, or the last one that it was found on.

    Attributes
    ----------
    point : on the given mesh
    load : of the point on `mesh`
    error : of the load; None: not known
    mesh : the one where its search ends, in words
    reason : why the mesh is not fine enough, or the load doubtful; "" otherwise
    seconds : CPU time
    """

    point: CriticalPoint
    load: float
    error: float | None
    mesh: str
    reason: str = ""
    seconds: float = 0.0

    def __str__(self) -> str:
        off = {None: "its error is not known", 0.0: "exact on any mesh"}.get(self.error) or (
            f"{abs(self.error):.2g} too {'high' if self.error > 0 else 'low'}")
        reason = f" ({self.reason})" if self.reason else ""
        return f"{self.point.title} at load {self.load:.6g} with {self.mesh}, {off}{reason}"


@dataclass
class _There:
    """A point on one mesh, what its load has changed by from mesh to mesh, and what a finer one starts from.

    Attributes
    ----------
    given : number of other modes that are unstable there on the given mesh
    """

    load: float
    error: float | None
    reason: str = ""
    changes: tuple[float, ...] = ()
    path: Path | None = None
    state: State | None = None
    modes: Sequence[np.ndarray] = ()
    given: int = 0


class Refinement:
    """Finds the points of a record on finer meshes.

    Parameters
    ----------
    record : of the path on the given mesh
    meshes : of the case, level 0 being the given one
    within : error of loads, over the load
    told : called with each point on each mesh
    """

    def __init__(self, record: Record, meshes: Meshes, within: float,
                 told: Callable[[Refined], None] = lambda refined: None):
        require("Refinement", record=(record, Record), meshes=(meshes, Meshes), within=(within, Share))
        self._record, self._meshes, self._within, self._told = record, meshes, within, told
        self._paths: dict[int, Path] = {}
        self._richer: dict[int, RicherPath] = {}
        self._pieces = bool(without_third_variations(record.path.discretisation.system))

    def all(self, points: Sequence[CriticalPoint] | None = None) -> list[Refined]:
        """Points of the record; None: its limit points and bifurcations."""
        chosen = [p for p in self._record.critical_points if p.kind in KINDS] if points is None else points
        return [self._refined(point) for point in chosen]

    def _refined(self, point: CriticalPoint) -> Refined:
        begun, level, here, stopped = time.process_time(), 0, self._given(point), ""
        if point.spread:
            stopped = "points that could not be told apart"
        elif self._pieces and self._record.path.falls:
            stopped = "a path with falls"
        while not (stopped or self._enough(here)):
            if level == self._meshes.highest:
                stopped = f"more than {self._within:.3g} of it; no finer mesh is allowed"
                break
            try:
                finer = (self._by_piece if self._pieces else self._directly)(point, here, level + 1)
            except (ArithmeticError, ValueError) as failure:
                stopped = f"with {self._meshes.words(level + 1)}: {failure}"
            else:
                self._told(self._result(point, here, level, begun))
                here, level = finer, level + 1
        self._told(found := self._result(point, here, level, begun, stopped))
        return found

    def _result(self, point: CriticalPoint, here: _There, level: int, begun: float, stopped: str = "") -> Refined:
        reason = "; ".join(filter(None, (here.reason, stopped)))
        return Refined(point, here.load, here.error, self._meshes.words(level), reason, time.process_time() - begun)

    def _enough(self, here: _There) -> bool:
        return here.error is not None and abs(here.error) <= self._within * abs(here.load)

    def _given(self, point: CriticalPoint) -> _There:
        """The point on the given mesh."""
        if self._pieces or point.spread:
            return _There(point.load, None)
        bar = self._record.errors.get(point) or self._record.error_bars([point])[0]
        return _There(point.load, bar.error, bar.reason)

    def _directly(self, point: CriticalPoint, coarser: _There, level: int) -> _There:
        """The point by Newton's method from that on coarser cells."""
        if coarser.path is None:
            record = self._record
            coarser = replace(coarser, path=record.path, state=record.state_at(point),
                              modes=record.critical_modes(point))
            coarser.given = unstable_beside(record.path, coarser.state, point.multiplicity)
        path, given = self._path(level), coarser.given
        guess, modes = between(coarser.state, coarser.path.discretisation, path.discretisation, coarser.modes)
        found = critical(path, guess, modes, kind=point.kind)
        changes = (*coarser.changes, coarser.load - found.point.load)
        error, doubt = _error(changes), ""
        if error is None:
            (bar,) = error_bars(path, [found.point], lambda _: found.state, lambda _: found.modes)
            error, doubt = bar.error, bar.reason
        if (there := unstable_beside(path, found.state, point.multiplicity)) != given:
            doubt = (f"{there} other modes are unstable there and {given} on the given mesh: points have changed "
                     "places, or new ones lie before it; follow its path")
        return _There(found.point.load, error, doubt, changes, path, found.state, found.modes, given)

    def _by_piece(self, point: CriticalPoint, coarser: _There, level: int) -> _There:
        """The point by a piece of the path on the finer mesh."""
        if level not in self._richer:
            with quiet():
                scene = self._meshes.case(level).scene
            self._richer[level] = RicherPath(self._record.path, self._record.states, scene)
        with quiet():
            load, alike, _ = self._richer[level](point, ALIKE)
        changes = (*coarser.changes, coarser.load - load)
        error = _error(changes)
        return _There(load, changes[-1] if error is None else error,
                      "" if alike >= ALIKE else f"its mode may be another one there, alike to {alike:.2f}", changes)

    def _path(self, level: int) -> Path:
        if level not in self._paths:
            with quiet():
                case = self._meshes.case(level)
                self._paths[level] = Path(case.scene, case.control, mixed_points=case.mixed_points)
        return self._paths[level]


def _error(changes: Sequence[float]) -> float | None:
    """Error of a load by its last two changes; None: there is one, or they do not fall by FALLING."""
    if len(changes) < 2 or not abs(changes[-2]) >= FALLING * abs(changes[-1]):
        return None
    return changes[-1] / (min(abs(changes[-2] / changes[-1]), SECOND_ORDER) - 1) if changes[-1] else 0.0
