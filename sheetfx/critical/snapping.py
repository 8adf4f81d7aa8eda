"""Load histories to their end: a path that falls where its state has lost its stability, and goes on from there."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from math import isfinite

from ..continuation.control import ArcLength, DisplacementControl, LoadControl, StepRule
from ..continuation.state import CriticalPoint, State
from ..events.event import Event
from ..events.until import AT_BOUND
from .fall import SnapFailure, unstable
from .snap import Snap, first_fall

__all__ = ["Falling", "SnapFailure"]


@dataclass
class Falling:
    """How a path goes on under a held load or displacement.

    Attributes
    ----------
    control : of the test: what it holds during a fall, and towards what it goes on
    falls : of the path so far
    """

    control: StepRule
    falls: list[Snap] = field(default_factory=list)

    @property
    def hold(self) -> str:
        return "displacement" if isinstance(self.control, DisplacementControl) else "load"

    @property
    def between(self) -> StepRule:
        """How the path is followed between falls: past what the test could not hold, up to the next unstable state."""
        return self.control if isinstance(self.control, ArcLength) else ArcLength()

    def bounds(self, start: State) -> list[Event]:
        """Where the load factor has come to the target of a LoadControl."""
        if not (isinstance(self.control, LoadControl) and isfinite(target := self.control.target)):
            return []
        way = 1.0 if target >= start.factor else -1.0
        near = AT_BOUND * max(abs(target), abs(start.factor))
        return [Event(f"load factor {target:g}", lambda state: way * (state.factor - target), near)]

    def onward(self, tracer, before: State, step: Callable[[State], State]) -> Iterator[State]:
        """The state of the next step, or that from which the structure falls, and the one that it falls into.

        Raises
        ------
        SnapFailure
            If no stable state is found.
        """
        after = step(before)
        if not unstable(after, self.hold) or unstable(before, self.hold):
            yield after
            return
        fall = first_fall(tracer, before, after, self.hold)
        start, passed = fall.before, [p for p in after.critical if p.kind != "event"]
        event = CriticalPoint("event", start.load, start.deflection, start.step, start.length, name="snap")
        self.falls.append(fall)
        yield replace(start, critical=(*passed, event))
        end = self.control.facing(replace(fall.after, step=start.step + 1, next_length=tracer.usual))
        tracer.back_to(end)
        yield end
