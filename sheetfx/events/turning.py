"""Limit points where rates of the load waver, as with contact: the load itself turns from one step to the next."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ..continuation.segment import Segment
from ..continuation.state import CriticalPoint, State
from .leaping import require_convergence

SEARCHED, RESOLUTION = 12, 0.02  # states at which the load is searched, and part of a step that they are apart
SHORT = 1 / 16  # of the usual first step, a step of which rates say little
SHARP = 1e-3  # change of load between two states by the lower one of their rates, over the load, at a corner


class Limit(NamedTuple):
    """A limit point.

    Attributes
    ----------
    segment : that has its state
    length : of the state
    rising : whether the load rises before it
    spread : loads between which it lies, where no more is known
    """

    segment: Segment
    length: float
    rising: bool
    spread: tuple[float, float] | None = None


def turning_loads(segment: Segment, earlier: State | None) -> list[Limit]:
    """The state of the highest (lowest) load where the load turns from one step to the next.

    Where the control prescribes the load it turns because the control does, which is no limit point. A step may pass a
    corner at which the load turns, or a maximum, and end at a load that goes on: the rates at its ends tell.

    It is searched by parabolas through loads, which rates that waver do not disturb, then by halving the way between
    states where the load rises and falls: where something sticks, slips or opens the path has a corner. Without
    contact rates do not waver, and points that begin to flow make corners: the way is halved first.

    Raises
    ------
    Jump
        If the states beside it do not converge.
    """
    before, after = segment.before, segment.after
    if not segment.tracer.control.passes_limits:
        return []
    sign = before.load_sense or np.sign(before.load_increment)
    if inside := not sign * load_sense(segment.tracer, before, after) < 0:
        sign, earlier = np.sign(before.load_rate), None
        if not ((unstable := _loses_stability(segment, sign)) or _peaks(segment, sign)):
            return []
    segments, since = _since_limit(segment, earlier)
    starts = [-before.length, 0.0][-len(segments):]
    known = {start + length: (one, length) for one, start in zip(segments, starts, strict=True)
             for length in one.states if start + length >= since}

    def load(place: float) -> float:
        one, length = known[place]
        return sign * one.states[length].factor

    def rate(place: float) -> float:
        one, length = known[place]
        return sign * one.states[length].load_rate

    for _ in range(SEARCHED):
        places = sorted(known)
        best = places.index(max(places[1:-1] or places, key=load))
        around = places[max(best - 1, 0): best + 2]
        loads, rates = [load(s) for s in around], [rate(s) for s in around]
        place = None if segment.tracer.system.rough else _behind_corner(around, loads, rates)
        if place is None:
            place = _vertex(around, loads)
            if place is None or min(abs(place - s) for s in known) < RESOLUTION * after.length:
                place = _behind_corner(around, loads, rates)
        if place is None:
            break
        one, start = next((one, start) for one, start in zip(segments, starts, strict=True)
                          if start <= place <= start + one.after.length)
        if not one.reach(place - start):
            if one is segment:
                require_convergence(segment, segment.neighbours(place - start)[0])
            break
        known[place] = one, place - start
    highest = max(known, key=load)
    if inside and not unstable and load(highest) - max(load(0.0), load(after.length)) <= SHARP * abs(load(highest)):
        return []
    one, length = known[highest]
    return [Limit(one, length, sign > 0)]


def _since_limit(segment: Segment, earlier: State | None) -> tuple[list[Segment], float]:
    """The step and, where the load may turn in the one before it, that, and the place from which on it is searched.

    Places are lengths from the start of the step. The step before is searched from its last limit point on.
    """
    before = segment.before
    last = max((point.length for point in before.critical if point.kind == "limit" and point.step == before.step),
               default=0.0)
    if earlier is None or last >= before.length:
        return [segment], 0.0
    one = Segment(segment.tracer, earlier, before)
    if last and not (one.nonsmooth and one.reach(last)):
        return [segment], 0.0
    return [one, segment], last - before.length


def _peaks(segment: Segment, sign: float) -> bool:
    """Whether the rates at both ends of a step tell of a turn of the load inside, as at a corner of the path."""
    ends = segment.before, segment.after
    loads, rates = ([sign * value for value in values] for values in (
        [state.factor for state in ends], [state.load_rate for state in ends]))
    rough = bool(segment.tracer.system.rough)
    return rough and _behind_corner([0.0, segment.after.length], loads, rates) is not None


def _loses_stability(segment: Segment, sign: float) -> bool:
    """Whether the rate of the load turns within a step, and one mode loses or regains its stability."""
    before, after = segment.before, segment.after
    one, other = before.unstable_modes, after.unstable_modes
    turns = sign * before.load_rate > 0 > sign * after.load_rate
    return turns and one is not None and other is not None and abs(other - one) == 1


def load_sense(tracer, before: State, after: State, points: Sequence[CriticalPoint] = ()) -> float:
    """Sense in which the load has changed last, by more than Newton's iteration leaves open; 0: it has not yet.

    Parameters
    ----------
    points : that the step has passed
    """
    for point in reversed(points):
        if point.kind == "limit" and point.step == after.step:
            return 1.0 if point.name == "minimum" else -1.0
    exact, *_ = tracer.snes.getTolerances()
    told = abs(after.load_increment) > exact * abs(after.factor)
    return float(np.sign(after.load_increment)) if told else before.load_sense


def _behind_corner(places: Sequence[float], loads: Sequence[float], rates: Sequence[float]) -> float | None:
    """The middle between places where the load clearly rises and falls; None: there are none."""
    for s, rise, t, fall in zip(places, rates, places[1:], rates[1:], strict=False):
        if min(rise, -fall) * (t - s) > SHARP * abs(max(loads)):
            return (s + t) / 2
    return None


def _vertex(places: Sequence[float], loads: Sequence[float]) -> float | None:
    """Where the parabola through places and loads is highest, between the outer ones; None: nowhere."""
    if len(places) < 3:
        return sum(places) / len(places)
    bend, slope, _ = np.polyfit(np.subtract(places, places[0]), loads, 2)
    return float(np.clip(places[0] - slope / (2 * bend), places[0], places[-1])) if bend < 0 else None
