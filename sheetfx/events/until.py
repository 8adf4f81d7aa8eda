"""Where a path ends."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Annotated

from ..checks import Positive, Range, check
from ..continuation.state import State
from .event import Event

AT_BOUND = 1e-6  # relative distance from a bound at which a path has reached it


def _beyond(name: str, bound: float, state: State) -> float:
    """How far a value of a state is beyond a bound."""
    return abs(getattr(state, name)) - bound


@dataclass(frozen=True)
class Until:
    """Where a path ends: at the first of the given bounds (absolute values); `steps` 0: unloaded.

    The last step ends at the bound, and critical points beyond it are not reported.

    Attributes
    ----------
    event : where the path ends: an Event, or the test function of one
    deflection, load : in the last stage; met to a millionth
    steps : of all stages
    """

    event: Event | Callable[[State], float | bool] | None = None
    deflection: Positive | None = None
    load: Positive | None = None
    steps: Annotated[int, Range(least=0)] = 2000

    def __post_init__(self):
        if not (self.event is None or isinstance(self.event, Event) or callable(self.event)):
            raise ValueError(f"Until: event is {self.event!r}; it must be an Event or a function of a state (name "
                             "the bounds: Until(deflection=...))")
        check(self)

    @property
    def ending(self) -> Event | None:
        """The event that ends the path."""
        return self.event if self.event is None or isinstance(self.event, Event) else Event("end", self.event)

    @property
    def bounds(self) -> list[Event]:
        """Events at which deflection or load reach their bounds."""
        return [Event(f"{name} {bound:g}", partial(_beyond, name, bound), AT_BOUND * bound)
                for name, bound in self.prescribed]

    @property
    def prescribed(self) -> list[tuple[str, float]]:
        """Attributes of states that are bounded, and their bounds."""
        bounds = (("deflection", self.deflection), ("load", self.load))
        return [(name, bound) for name, bound in bounds if bound is not None]

    def stopped(self, state: State) -> str | None:
        """Why the path ends at this state in any stage, or None."""
        ending = self.ending
        if ending and any(p.kind == "event" and p.name == ending.name for p in state.critical):
            return f"event {ending.name!r} reached"
        return f"{self.steps} steps taken" if state.step >= self.steps else None
