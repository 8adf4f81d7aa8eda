"""Events of a path: states at which a test function of one's own passes zero, pinpointed as critical points are."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from numbers import Real
from typing import Annotated

import numpy as np

from ..checks import Choice, Like, NotNegative, check, require
from ..continuation.segment import Missed, Segment
from ..continuation.state import CriticalPoint, State
from ..rounding import SAME, root

TOLD = Like("a number, or True or False", lambda value: isinstance(value, Real))
SHORTEST = 1e-6  # of a step, within which a test that is only true or false changes
COARSE = 1 / 64  # of the usual first step, way without states that an event may lie on: refusing it would lead nowhere


class Hidden(Missed):
    """An event happens between states that are far apart, and none in between converges."""


@dataclass(frozen=True)
class Event:
    """Something that happens on a path: first contact, a stress that is reached, a plate that slides off.

    Attributes
    ----------
    name : what the path calls it
    test : function of a `State` whose value passes zero where it happens, or that turns from False to True (or back)
    near : how near to zero the value must come; 0: as near as the load can be told
    way : 1 or -1: only where the value rises or falls through zero; 0: both
    """

    name: str
    test: Callable[[State], float | bool]
    near: NotNegative = 0.0
    way: Annotated[int, Choice((-1, 0, 1))] = 0

    def __post_init__(self):
        check(self)

    def value(self, state: State) -> float:
        found = self.test(state)
        if isinstance(found, (bool, np.bool_)):
            return 1.0 if found else -1.0
        require(f"Event {self.name!r}", **{"what its test returns": (found, Annotated[float, TOLD])})
        return float(found)


@dataclass(frozen=True)
class Occurrence:
    """An event in a step, as a point of the path and as the state there."""

    event: Event
    point: CriticalPoint
    state: State


def occurrences(tracer, before: State, after: State, events: Sequence[Event], whole: bool = False) -> list[Occurrence]:
    """Events that happen in the step from `before` to `after`, in their order; the tracer ends at `after`.

    Parameters
    ----------
    whole : whether the step has to be taken as it is, unless an event asks how near its value must come

    Raises
    ------
    Hidden
        If states about an event do not converge and shorter steps may find them.
    """
    found = []
    for event in events:
        left, right = event.value(before), event.value(after)
        if (left * right < 0 or (left and not right)) and event.way * (right - left) >= 0:
            found.append(_occurrence(tracer, before, after, event, whole))
    if found:
        tracer.back_to(after)
    return sorted(found, key=lambda occurrence: occurrence.point.length)


def _occurrence(tracer, before: State, after: State, event: Event, whole: bool) -> Occurrence:
    """An event, at the state behind it where it is only known to lie between two."""
    segment, spread = Segment(tracer, before, after), None
    try:
        length = _length(segment, event)
    except Missed:
        left, length = _around(segment, event)
        if tracer.control.guarded and (event.near or (not whole and length - left > COARSE * tracer.usual)):
            raise Hidden from None
        low, high = sorted(segment[s].load for s in (left, length))
        spread = low, high
    state = segment[length]
    point = CriticalPoint("event", state.load, state.deflection, after.step, float(length), name=event.name,
                          spread=spread)
    return Occurrence(event, point, state)


def _length(segment: Segment, event: Event) -> float:
    """Length at which a test passes zero, or at which it has changed.

    Raises
    ------
    Missed
    """
    end = segment.after.length
    if isinstance(event.test(segment.after), (bool, np.bool_)):
        return _bisected(segment, event)

    def value(length):
        found = event.value(segment[length])
        return 0.0 if abs(found) <= event.near else found

    if event.near:
        return root(value, 0.0, end)
    segment.close_in(value, 0.0, end, segment.tracer.control.exact_event)
    return min(reversed(_around(segment, event)), key=lambda s: abs(value(s)))


def _bisected(segment: Segment, event: Event) -> float:
    """Length at which a test that is only true or false has changed."""
    left, right = 0.0, segment.after.length
    start = event.value(segment.before)
    while right - left > SHORTEST * segment.after.length:
        middle = (left + right) / 2
        changed = event.value(segment[middle]) != start
        left, right = (left, middle) if changed else (middle, right)
    return right


def _around(segment: Segment, event: Event) -> tuple[float, float]:
    """Lengths of the neighbouring states between which a test changes."""
    values = {length: event.value(state) for length, state in segment.states.items()}
    return next(pair for pair in segment.pairs() if values[pair[0]] and values[pair[0]] * values[pair[1]] <= 0)


def end_at(tracer, after: State, occurrence: Occurrence) -> State:
    """The state of an event as the end of its step; the tracer ends there."""
    if occurrence.point.length >= after.length * (1 - SAME):
        return after
    tracer.back_to(occurrence.state)
    return occurrence.state
