"""Critical points between two converged states: found by sign changes, pinpointed by repeating the step."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from scipy.optimize import minimize_scalar

from ..continuation.segment import Jump, Missed, Segment
from ..continuation.state import CriticalPoint, State
from ..continuation.tracer import tracer_of
from .crossings import REACHES, Crossing, pass_zero
from .koiter import postbuckling

SAME = 1e-6  # relative difference of loads of one multiple point
CROWDED = 4  # bifurcations, more of which are too many for one step
CLUSTER = 0.01  # relative difference of the loads of a step that may hold any number
SHORTEST = 1 / 64  # of a step, piece that must be explained


def locate(tracer, earlier: State | None, before: State, after: State,
           others: Sequence[Callable[[Segment], list[CriticalPoint]]] = ()) -> tuple[CriticalPoint, ...]:
    """Critical points that the step from `before` to `after` brings to light; the tracer ends at `after`.

    A change of sign of the load rate is a limit point, which changes the number of unstable directions
    by one; any other change in that number means bifurcations. A step with more than a few of them is too
    long, unless their loads lie close together. A piece of path whose load does not follow from the tangents
    at its ends, or that turns, is also looked at in its middle.

    As a contact slides over contact points the load rate wavers about that of the smooth path, while
    the load itself hardly does. With contact a limit point is therefore a step in which the load
    turns, and is searched there and in the step before it, which starts at `earlier`.

    Parameters
    ----------
    others : functions that look for critical points of other kinds on a segment, such as `flutter.Flutter`

    Raises
    ------
    Jump
        If the states of the step do not lie on one smooth piece of path.
    """
    segment = Segment(tracer, before, after)
    if segment.guarded and _crowded(before, after):
        raise Jump(f"{_hidden(before, after)} bifurcations lie in one step")
    if not tracer.system.smooth:
        limits = _turning_loads(segment, earlier)
    else:
        if segment.guarded:
            _check(segment)
        limits = [_stationary_load(segment, *pair) for pair in segment.pairs()
                  if segment[pair[0]].load_rate * segment[pair[1]].load_rate < 0]
    if limits and segment.guarded and not tracer.control.passes_limits:
        raise Jump("a limit point lies in a step that prescribes the load")
    points = [_limit(*found) for found in limits]
    crossings = _bifurcations(segment, [length for s, length, _ in limits if s is segment])
    points += [_bifurcation(segment, cluster) for cluster in _clusters(crossings)]
    for other in others:
        points += other(segment)
    if len(segment.states) > 2 or points:
        tracer.back_to(after)
    return tuple(sorted(points, key=lambda p: (p.step, p.length)))


def state_at(path, before: State, after: State, point: CriticalPoint) -> State:
    """The state of a critical point of the step from `before` to `after`, again; the tracer ends there.

    Parameters
    ----------
    path : Path or Tracer that the states belong to

    Raises
    ------
    ArithmeticError
        If it does not converge again.
    """
    tracer = tracer_of(path)
    segment = Segment(tracer, before, after)
    if abs(point.length - after.length) <= 1e-12 * after.length:
        tracer.factorise_at(after)
        return after
    try:
        if segment.guarded:
            _check(segment)
        if point.kind == "bifurcation":
            _surround(segment, point.length)
        state = segment.on_path(point.length)
    except (Jump, Missed):
        raise ArithmeticError(f"the {point.kind} at load {point.load:.6g} in step {point.step} does not converge "
                              "again; resume the path with a shorter step before it") from None
    tracer.factorise_at(state)
    return state


def _surround(segment: Segment, length: float) -> None:
    """Have states on both sides of a bifurcation, from which its own is interpolated."""
    for reach in REACHES[:2]:
        for wanted in (length - reach * segment.after.length, length + reach * segment.after.length):
            if 0 < wanted < segment.after.length:
                segment.reach(wanted)


def _check(segment: Segment) -> None:
    """Look into the middle of pieces that turn, or whose load the tangents at their ends do not explain."""
    pieces = segment.pairs()
    while pieces:
        left, right = pieces.pop()
        if not segment.explained(left, right):
            if right - left < SHORTEST * segment.after.length:
                raise Jump("tangents within the step do not explain its load")
            middle = (left + right) / 2
            if not segment.reach(middle):
                raise Jump("the middle of the step does not converge")
            pieces += [(left, middle), (middle, right)]


def _stationary_load(segment: Segment, left: float, right: float) -> tuple[Segment, float, bool]:
    """Where the load rate is zero between two lengths, and whether the load rises before."""
    values = segment.root(lambda s: segment[s].load_rate, left, right, 1e-12)
    return segment, next(iter(values)), segment[left].load_rate > 0


def _limit(segment: Segment, length: float, rising: bool) -> CriticalPoint:
    state = segment.states[length]
    return CriticalPoint("limit", state.load, state.deflection, state.step, float(length),
                         name="maximum" if rising else "minimum")


def _turning_loads(segment: Segment, earlier: State | None) -> list[tuple[Segment, float, bool]]:
    """The state of the highest (lowest) load where the load turns from one step to the next."""
    before, after = segment.before, segment.after
    if not before.load_increment * after.load_increment < 0:
        return []
    sign = 1.0 if before.load_increment > 0 else -1.0
    segments = [segment] if earlier is None else [Segment(segment.tracer, earlier, before), segment]
    for one in segments:

        def opposite_load(length, one=one):
            try:
                return -sign * one[length].factor
            except Missed:
                return -sign * one.before.factor

        minimize_scalar(opposite_load, bounds=(0.0, one.after.length), method="bounded",
                        options={"xatol": 0.02 * one.after.length})
    return [max(((one, length, sign > 0) for one in segments for length in one.states),
                key=lambda found: sign * found[0].states[found[1]].factor)]


def _bifurcations(segment: Segment, limits: list[float]) -> list[Crossing]:
    """Where eigenvalues other than those of limit points pass zero, along the path.

    With contact, where eigenvalues waver, only the ends of the step are compared; with friction nothing is.
    """
    near, system = 1e-5 * segment.after.length, segment.tracer.system
    if not system.smooth and not system.conservative:
        return []
    candidates = sorted(segment.states) if system.smooth else [0.0, segment.after.length]
    lengths = [s for s in candidates if all(abs(s - limit) > near for limit in limits)]
    found = [c for pair in zip(lengths[:-1], lengths[1:], strict=True) for c in _crossings(segment, *pair, near)]
    return sorted(found, key=lambda c: c.length)


def _hidden(one: State, other: State) -> int:
    """Least number of bifurcations between two states: a limit point changes the unstable directions by one."""
    if one.unstable_modes is None or other.unstable_modes is None:
        return 0
    change = abs(one.unstable_modes - other.unstable_modes)
    return abs(change - 1) if one.load_rate * other.load_rate < 0 else change


def _crowded(before: State, after: State) -> bool:
    """Whether so many bifurcations lie between two states that these should be nearer to each other."""
    apart = abs(after.factor - before.factor) > CLUSTER * max(abs(after.factor), abs(before.factor))
    return apart and _hidden(before, after) > CROWDED


def _crossings(segment: Segment, left: float, right: float, near: float) -> list[Crossing]:
    one, other = segment[left], segment[right]
    count = _hidden(one, other)
    if not count:
        return []
    if one.load_rate * other.load_rate < 0:
        middle = (left + right) / 2
        if right - left <= 3 * near:
            return [Crossing(left, one.load, one.deflection)] * count
        if not segment.reach(middle):
            return []
        return _crossings(segment, left, middle, near) + _crossings(segment, middle, right, near)
    return pass_zero(segment, left, right, count)


def _clusters(crossings: list[Crossing]) -> list[list[Crossing]]:
    """Crossings at equal loads together."""
    clusters: list[list[Crossing]] = []
    for crossing in crossings:
        if clusters and abs(crossing.load - clusters[-1][-1].load) <= SAME * abs(crossing.load):
            clusters[-1].append(crossing)
        else:
            clusters.append([crossing])
    return clusters


def _bifurcation(segment: Segment, crossings: list[Crossing]) -> CriticalPoint:
    """A simple or multiple bifurcation, classified."""
    first, count, tracer = crossings[0], len(crossings), segment.tracer
    point = CriticalPoint("bifurcation", first.load, first.deflection, segment.after.step, first.length, count)
    if not tracer.system.smooth or not tracer.system.conservative:
        return point
    state = segment.on_path(first.length)
    values, modes = segment.spectrum(first.length, count)
    tracer.factorise_at(state)
    null = [modes[i] for i in np.argsort(np.abs(values))[:count]]
    return postbuckling(tracer, state, null, point, [segment.before, segment.after])
