"""Critical points between two converged states: found by sign changes, pinpointed by repeating the step."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.interpolate import KroghInterpolator
from scipy.optimize import minimize_scalar

from ..continuation.segment import Jump, Missed, Segment
from ..continuation.state import CriticalPoint, State
from ..continuation.tracer import tracer_of
from .koiter import postbuckling

SAME = 1e-6  # relative difference of loads of one multiple point
SHORTEST = 1 / 64  # of a step, piece that must be explained
REACH = 0.05  # of a piece of path, about a bifurcation, in which it is interpolated
FALSE_ROOTS = 10  # places where an eigenvalue comes near to zero, as beside a limit point, before it passes it
FOLD = 0.9  # of the length of a piece of path, motion along the mode where a limit point is
NOISE = 1e-6  # of the length of a piece of path, motion along a mode that does not count


def locate(tracer, earlier: State | None, before: State, after: State,
           most: int | None = None) -> tuple[CriticalPoint, ...]:
    """Critical points that the step from `before` to `after` brings to light; the tracer ends at `after`.

    A change of sign of the load rate is a limit point, which changes the number of unstable directions
    by one; any other change in that number means bifurcations. A step with more than `most` of them is too
    long. A piece of path whose load does not follow from the tangents at its ends, or that turns, is also looked at
    in its middle.

    As a contact slides over contact points the load rate wavers about that of the smooth path, while
    the load itself hardly does. With contact a limit point is therefore a step in which the load
    turns, and is searched there and in the step before it, which starts at `earlier`.

    Raises
    ------
    Jump
        If the states of the step do not lie on one smooth piece of path.
    """
    segment = Segment(tracer, before, after)
    hidden = _hidden(before, after)
    if segment.guarded and most is not None and hidden > most:
        raise Jump(f"{hidden} bifurcations lie in one step")
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
    if len(segment.states) > 2 or points:
        tracer.back_to(after)
    return tuple(sorted(points, key=lambda p: (p.step, p.length)))


def searched(system, control) -> list[str]:
    """What a path of a system under a control is searched for, and what not, in sentences."""
    if not system.smooth:
        found = ["limit points: where the load turns from one step to the next (contact makes its rate waver)"]
        found.append("bifurcations: unstable modes compared at the ends of steps only" if system.conservative else
                     "bifurcations: not looked for (contact with friction)")
    elif system.conservative:
        found = ["limit points: by the rate of the load", "bifurcations: by the inertia of the tangent, also within "
                 "steps that the tangents at their ends do not explain"]
    else:
        found = ["limit points: by the rate of the load", "bifurcations: by the sign of the determinant of the "
                 "unsymmetric tangent; not seen: two in one step, double ones, flutter"]
    if not control.guarded:
        found.append("other paths: not looked for, steps are taken as they are")
    elif not system.smooth:
        found.append("other paths: a step that turns too far is cut; jumps within steps are not looked for")
    else:
        found.append("other paths: steps that leave the smooth path are cut")
    return found


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
        state = segment[point.length]
    except (Jump, Missed):
        raise ArithmeticError(f"the {point.kind} at load {point.load:.6g} in step {point.step} does not converge "
                              "again; resume the path with a shorter step before it") from None
    tracer.factorise_at(state)
    return state


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


@dataclass(frozen=True)
class _Crossing:
    """Where an eigenvalue of the tangent passes zero: the nearest state's length, and what is interpolated there."""

    length: float
    load: float
    deflection: float


def _bifurcations(segment: Segment, limits: list[float]) -> list[_Crossing]:
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
    """Least number of bifurcations between two states: a limit point changes the unstable directions by one.

    Of unsymmetric tangents only the determinant is known, which simple bifurcations change.
    """
    if one.unstable_modes is None:
        change = one.determinant_sign != other.determinant_sign
    else:
        change = abs(one.unstable_modes - other.unstable_modes)
    return abs(change - 1) if one.load_rate * other.load_rate < 0 else change


def _crossings(segment: Segment, left: float, right: float, near: float) -> list[_Crossing]:
    one, other = segment[left], segment[right]
    count = _hidden(one, other)
    if not count:
        return []
    if one.load_rate * other.load_rate < 0:
        middle = (left + right) / 2
        if right - left <= 3 * near:
            return [_Crossing(left, one.load, one.deflection)] * count
        if not segment.reach(middle):
            return []
        return _crossings(segment, left, middle, near) + _crossings(segment, middle, right, near)
    numbers = [None] if one.unstable_modes is None else range(*sorted((one.unstable_modes, other.unstable_modes)))
    return [_crossing(segment, number, count + 2, left, right) for number in numbers]


def _crossing(segment: Segment, number: int | None, count: int, left: float, right: float) -> _Crossing:
    """Zero of one eigenvalue, interpolated between states so far from it that rounding does not throw them off."""
    def value(length):
        return segment.eigenvalue(length, number, count)

    reach = REACH * (right - left)
    for _ in range(FALSE_ROOTS):
        bracket = (left, right) if number is None else _bracket(segment, number, left, right)
        middle = next(iter(segment.root(value, *bracket, 1e-3)))
        lengths = [s for s in _around(segment, middle, reach) if left <= s <= right]
        values = [value(s) for s in lengths]
        if min(values) < 0 < max(values):
            break
    table = [(s, segment[s].load, segment[s].deflection) for s in lengths]
    found = _Crossing(*map(float, KroghInterpolator(values, table)(0.0)))
    if abs(found.length - middle) > reach:
        found = _Crossing(*table[int(np.argmin(np.abs(values)))])
    if not segment.reach(found.length):
        found = replace(found, length=middle)
    if segment.guarded:
        _compare_sides(segment, found.length, reach, count)
    return found


def _bracket(segment: Segment, number: int, left: float, right: float) -> tuple[float, float]:
    """Neighbouring states between two others, on whose sides an eigenvalue has different signs."""
    before = segment[left].unstable_modes > number
    lengths = [s for s in sorted(segment.states) if left <= s <= right]
    passed = next(i for i, s in enumerate(lengths) if (segment[s].unstable_modes > number) != before)
    return lengths[passed - 1], lengths[passed]


def _around(segment: Segment, middle: float, reach: float) -> list[float]:
    """Lengths of states at a length and about `reach` to both sides, known ones where they are near enough."""
    lengths = [middle]
    for wanted in (middle - reach, middle - reach / 2, middle + reach / 2, middle + reach):
        nearest = min(segment.states, key=lambda s, wanted=wanted: abs(s - wanted))
        if abs(nearest - wanted) < reach / 8:
            lengths.append(nearest)
        elif 0 < wanted < segment.after.length and segment.reach(wanted):
            lengths.append(wanted)
    return lengths


def _compare_sides(segment: Segment, length: float, reach: float, count: int) -> None:
    """Refuse states on both sides of a bifurcation that the path does not lead through.

    Near the bifurcation of a slightly imperfect structure the path bends away along the mode; a step that goes
    straight on has jumped to another path, from which the mode deviates to the other side, or which itself goes
    along the mode at a limit point.
    """
    left = max((s for s in segment.states if s <= length - reach / 2), default=None)
    right = min((s for s in segment.states if s >= length + reach / 2), default=None)
    if left is None or right is None:
        return
    values, modes = segment.spectrum(length, count)
    mode = modes[int(np.argmin(np.abs(values)))].array
    moved, led = segment.along(mode, left, right)
    distance, size = segment.distance(left, right), max(abs(moved), abs(led))
    strays = (abs(moved - led) > size / 2 and size > NOISE * distance) or abs(moved) > FOLD * distance
    if strays and size > 10 * max(segment.uncertainty(segment[s]) for s in (left, right)):
        raise Jump("the path bends away from a bifurcation that the step passes")


def _clusters(crossings: list[_Crossing]) -> list[list[_Crossing]]:
    """Crossings at equal loads together."""
    clusters: list[list[_Crossing]] = []
    for crossing in crossings:
        if clusters and abs(crossing.load - clusters[-1][-1].load) <= SAME * abs(crossing.load):
            clusters[-1].append(crossing)
        else:
            clusters.append([crossing])
    return clusters


def _bifurcation(segment: Segment, crossings: list[_Crossing]) -> CriticalPoint:
    """A simple or multiple bifurcation, classified."""
    first, count, tracer = crossings[0], len(crossings), segment.tracer
    state = segment[first.length]
    point = CriticalPoint("bifurcation", first.load, first.deflection, segment.after.step, first.length, count)
    if not tracer.system.smooth or not tracer.system.conservative:
        return point
    values, modes = segment.spectrum(first.length, count)
    tracer.factorise_at(state)
    null = [modes[i] for i in np.argsort(np.abs(values))[:count]]
    return postbuckling(tracer, state, null, point, [segment.before, segment.after])
