"""Events of a path: states at which a test function of one's own passes zero, pinpointed as critical points are."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from numbers import Real
from typing import Annotated

import numpy as np
from scipy.optimize import brentq

from ..checks import Choice, Like, NotNegative, check, require
from .segment import Missed, Segment
from .state import CriticalPoint, State

TOLD = Like("a number, or True or False", lambda value: isinstance(value, Real))
EXACT = 1e-10  # relative error of the load at an event
SHORTEST = 1e-6  # of a step, within which a test that is only true or false changes


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


def occurrences(tracer, before: State, after: State, events: Sequence[Event]) -> list[Occurrence]:
    """Events that happen in the step from `before` to `after`, in their order; the tracer ends at `after`."""
    found = []
    for event in events:
        left, right = event.value(before), event.value(after)
        if (left * right < 0 or (left and not right)) and event.way * (right - left) >= 0:
            found.append(_occurrence(tracer, before, after, event))
    if found:
        tracer.back_to(after)
    return sorted(found, key=lambda occurrence: occurrence.point.length)


def _occurrence(tracer, before: State, after: State, event: Event) -> Occurrence:
    segment = Segment(tracer, before, after)
    if isinstance(event.test(after), bool):
        length = _bisected(segment, event)
    elif event.near:
        length = _near_zero(segment, event)
    else:
        values = segment.root(lambda s: event.value(segment[s]), 0.0, after.length, EXACT)
        length = next(iter(values))
    state = segment[length]
    point = CriticalPoint("event", state.load, state.deflection, after.step, float(length), name=event.name)
    return Occurrence(event, point, state)


def _near_zero(segment: Segment, event: Event) -> float:
    """Length at which a test function is zero within what is asked of it.

    Raises
    ------
    Missed
        If states in between do not converge; steps of a control that leaves them as they are end where they end.
    """
    def value(length):
        found = event.value(segment[length])
        return 0.0 if abs(found) <= event.near else found

    try:
        return float(brentq(value, 0.0, segment.after.length, xtol=1e-12 * segment.after.length))
    except Missed:
        if segment.tracer.control.guarded:
            raise
        return segment.after.length


def _bisected(segment: Segment, event: Event) -> float:
    """Length at which a test that is only true or false has changed."""
    left, right = 0.0, segment.after.length
    start = event.value(segment.before)
    while right - left > SHORTEST * segment.after.length:
        middle = (left + right) / 2
        try:
            changed = event.value(segment[middle]) != start
        except Missed:
            break
        left, right = (left, middle) if changed else (middle, right)
    return right


def end_at(tracer, after: State, occurrence: Occurrence) -> State:
    """The state of an event as the end of its step; the tracer ends there."""
    if occurrence.point.length >= after.length * (1 - 1e-12):
        return after
    tracer.back_to(occurrence.state)
    return occurrence.state
