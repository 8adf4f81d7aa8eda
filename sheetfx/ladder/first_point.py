"""The first critical point of a case, by its path or directly from that on coarser cells."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from ..continuation.state import CriticalPoint, State
from ..continuation.tracer import tracer_of
from ..continuation.transferred import between
from ..critical.augmented import KINDS, NoCriticalPoint, critical
from ..critical.error_bar import ErrorBar, error_bars
from ..model.scene import Scene
from ..path import Path, PathFailure, Until
from ..record import Record
from .left_out import LeftOut
from .rung import Evidence

if TYPE_CHECKING:
    from ..case import Case


@dataclass
class FirstPoint:
    """The path up to the first critical point of a case.

    Attributes
    ----------
    record : of the path, or of the point alone where it was found directly
    point : where it ends; None: it has none, or the model has been found wrong before
    refuted : name of a thing left out -> the state that needs it
    failure : why the path stopped; "": it did not
    seen : name of a thing left out -> what has watched the path for it
    given : null vectors of a point that was found directly
    """

    record: Record
    point: CriticalPoint | None = None
    refuted: dict[str, Evidence] = field(default_factory=dict)
    failure: str = ""
    seen: Mapping[str, Any] = field(default_factory=dict)
    given: Sequence[np.ndarray] = ()

    @property
    def load(self) -> float:
        """Of the point, or the largest one of its last stage where there is none."""
        states = self.record.states
        return self.point.load if self.point else max((s.load for s in states if s.stage == states[-1].stage), key=abs,
                                                      default=0.0)

    @property
    def state(self) -> State:
        """Of the point, or the last one of the path where there is none."""
        return self.record.state_at(self.point) if self.point else self.record.states[-1]

    @property
    def named(self) -> bool:
        """Whether it is a limit point or a bifurcation."""
        return self.point is not None and self.point.kind in KINDS

    @property
    def modes(self) -> Sequence[np.ndarray]:
        """Null vectors there."""
        return self.given or self.record.critical_modes(self.point)

    def bar(self) -> ErrorBar:
        """Error of its load by the polynomials of its mesh, see `critical.error_bar`."""
        return error_bars(self.record.path, [self.point], lambda _: self.state, lambda _: self.modes)[0]

    def watch(self, state: State) -> None:
        """Have a state looked at by all that watches."""
        self.refuted = {name: told for name, seen in self.seen.items() if (told := seen(state)) is not None}


def up_to_first(case: Case, whole: Scene, left: LeftOut, watched: LeftOut, until: Sequence[str] = ()) -> FirstPoint:
    """The path of a case up to its first critical point, or to where what it leaves out is needed.

    Parameters
    ----------
    case : without the things left out; where it is to take no step, it goes on to a point
    whole : its scene with that
    watched : of the things left out, what the path is watched for
    until : names of events of the case that are critical too
    """
    found = _begun(case, whole, left, watched)
    try:
        for state in found.record.path:
            found.record.states.append(state)
            found.point = next((p for p in state.critical if p.kind in KINDS or p.name in until), None)
            found.watch(found.state)
            if found.point or found.refuted:
                break
    except PathFailure as failure:
        found.failure = str(failure)
    if found.refuted:
        found.point = None
    return found


def _begun(case: Case, whole: Scene, left: LeftOut, watched: LeftOut) -> FirstPoint:
    end = case.until if case.until.steps else Until()
    path = Path(case.scene, case.control, end, mixed_points=case.mixed_points, events=case.events)
    record = Record(case, path, [])
    return FirstPoint(record, seen={
        rung.name: rung.watch(left.but(rung.name).scene(whole), record) for rung in watched.rungs})


def from_coarser(coarser: FirstPoint, case: Case, whole: Scene, left: LeftOut, watched: LeftOut) -> FirstPoint | None:
    """The critical point of a case next to that on coarser cells, without its path; None: only the path tells.

    That is so where the point has no direct equations, where they lead nowhere, and where another mode is unstable
    there, so that it is not the first point of the path.
    """
    point = coarser.point
    if not coarser.named or point is None or point.spread:
        return None
    found = _begun(case, whole, left, watched)
    path = found.record.path
    if not path.discretisation.system.smooth or path.discretisation.system.history.moved:
        return None
    try:
        guess, modes = between(coarser.state, coarser.record.path.discretisation, path.discretisation, coarser.modes)
        there = critical(path, guess, modes, kind=point.kind)
    except (ValueError, NoCriticalPoint):
        return None
    if unstable_beside(path, there.state, there.point.multiplicity) > 0:
        return None
    found.point, found.given = there.point, there.modes
    found.record.states.append(there.state)
    path.critical_states[there.point] = there.state
    found.watch(there.state)
    return found


def unstable_beside(path: Path, state: State, multiplicity: int) -> int:
    """Number of unstable modes at a critical point beside those that are critical."""
    tracer = tracer_of(path)
    tracer.factorise_at(state)
    nearest = sorted(tracer.spectrum(multiplicity)[0], key=abs)[:multiplicity]
    unstable = (tracer.stepper.linear.negative_pivots() or 0) - tracer.system.multipliers
    return unstable - sum(value < 0 for value in nearest)
