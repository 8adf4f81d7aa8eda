"""Critical points between two converged states: found by sign changes, pinpointed by repeating the step."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
from petsc4py import PETSc

from ..continuation.defect import SHORTEST, cornered, has_small_defect
from ..continuation.lapse import remembering
from ..continuation.segment import Jump, Missed, Segment
from ..continuation.state import CriticalPoint, State
from ..continuation.tracer import Tracer, tracer_of
from ..continuation.work import require_work
from ..rounding import same
from .crossings import CLOSEST, Crossing, pass_zero, unresolved
from .heading import hides
from .stationary import returning, stationary_loads, surround, turns
from .turning import Limit, turning_loads

TOGETHER = 1e-3  # of a step, distance of the crossings of one multiple point
AGREE = 0.01  # of the load that a step adds, difference between two interpolations of a bifurcation's load

# from the tracer, which is at the state of a bifurcation, null vectors, the point, and the states before and after
Naming = Callable[[Tracer, State, Sequence[PETSc.Vec], CriticalPoint, Sequence[State]], CriticalPoint]


def locate(tracer, earlier: State | None, before: State, after: State, named: Naming,
           others: Sequence[Callable[[Segment], list[CriticalPoint]]] = ()) -> dict[CriticalPoint, State | None]:
    """Critical points that the step from `before` to `after` brings to light; the tracer ends at `after`.

    A change of sign of the load rate is a limit point, which changes the number of unstable directions
    by one; any other change in that number means bifurcations. A piece of path with a large defect is also looked
    at in its middle.

    As a contact slides over contact points the load rate wavers about the smooth path's, while
    the load itself hardly does. With contact a limit point is therefore a step in which the load
    turns, and is searched there and in the step before it, which starts at `earlier`.

    Parameters
    ----------
    named : gives a bifurcation its name, from its state and null vectors, such as `koiter.postbuckling`
    others : functions that look for critical points of other kinds on a segment, such as `flutter.Flutter`

    Returns
    -------
    The points in their order, with their states; None: the search has not had it.

    Raises
    ------
    Jump
        If the states of the step do not lie on one smooth piece of path.
    """
    segment = Segment(tracer, before, after)
    returns: list[float] = []
    if segment.flows and tracer.control.guarded:
        _check(segment)
    if any(contribution.remembers for contribution in tracer.system.contributions):
        after = segment.states[after.length] = segment.after = remembering(segment)
    if segment.nonsmooth:
        if tracer.control.guarded:
            require_work(segment, earlier)
        limits = [limit for limit in turning_loads(segment, earlier) if limit.segment.nonsmooth]
    else:
        if segment.guarded:
            _check(segment)
        limits, returns = stationary_loads(segment)
        if segment.guarded and (limits or returns) and _check(segment):
            limits, returns = stationary_loads(segment, returns)
        limits = _turned_before(segment, earlier) + limits
    points: dict[CriticalPoint, State | None] = dict(map(_limit, limits))
    crossings = _bifurcations(segment, [limit.length for limit in limits if limit.segment is segment], returns)
    crossings += [returning(segment, length) for length in returns]
    clusters = _clusters(crossings, TOGETHER * after.length, tracer.control.same_load)
    points |= (_bifurcation(segment, cluster, named) for cluster in clusters)
    if tracer.control.guarded and turns(segment) > sum(limit.segment is segment for limit in limits) + len(returns):
        raise Jump("the load turns beside a bifurcation that the step passes")
    for other in others:
        points |= dict.fromkeys(other(segment))
    if tracer.state is not after:
        tracer.back_to(after)
    return dict(sorted(points.items(), key=lambda found: (found[0].step, found[0].length)))


def step_of(who: str, states: Sequence[State], point: CriticalPoint, size: int) -> tuple[State, State]:
    """States before and after a critical point, of a path with so many unknowns on this process.

    Raises
    ------
    ValueError
        In the name of who asks, where they are missing or belong to another path.
    """
    by_step = {state.step: state for state in states}
    if not {point.step - 1, point.step} <= set(by_step):
        raise ValueError(f"{who}: the states of steps {point.step - 1} and {point.step} around the {point.kind} at "
                         f"load {point.load:.6g} are missing; give the states of the whole path")
    found = by_step[point.step - 1], by_step[point.step]
    if len({len(state.increment) for state in found} | {size}) > 1:
        raise ValueError(f"{who}: the states have {len(found[1].increment)} unknowns and the path has {size}; give "
                         "states of this path")
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
    if same(point.length / after.length, 1.0):
        tracer.factorise_at(after)
        return after
    try:
        if segment.guarded:
            _check(segment)
        if point.kind == "bifurcation":
            surround(segment, point.length)
        state = segment.on_path(point.length)
    except (Jump, Missed):
        raise ArithmeticError(f"the {point.kind} at load {point.load:.6g} in step {point.step} does not converge "
                              "again; resume the path with a shorter step before it") from None
    tracer.factorise_at(state)
    return state


def _check(segment: Segment) -> bool:
    """Look into the middle of pieces with a large defect.

    Of the shortest pieces rounding may decide: they are left as a search has made them.

    Returns
    -------
    Whether there were any.
    """
    shortest, known = SHORTEST * segment.after.length, len(segment.states)
    pieces = [(left, right) for left, right in segment.pairs()[::-1] if right - left >= shortest]
    while pieces:
        left, right = pieces.pop()
        middle, is_long = (left + right) / 2, right - left >= shortest
        if is_long and not segment.flows and hides(segment, left, right) and segment.reach(middle):
            pieces += [(middle, right), (left, middle)]
            continue
        if not _is_clear(segment, left, right):
            sound = segment.states[left] if left else None
            if not is_long:
                raise Jump("states within the step do not lie on the curve that their tangents make", sound)
            if not segment.reach(middle, only_guessed=sound is not None):
                raise Jump("the middle of the step does not converge", sound)
            pieces += [(middle, right), (left, middle)]
    return len(segment.states) > known


def _is_clear(segment: Segment, left: float, right: float) -> bool:
    """Whether tangents tell what lies between two states; where points flow there may be a corner."""
    if (left, right) not in segment.clear:
        segment.clear[left, right] = has_small_defect(segment, left, right) or (
            segment.flows and cornered(segment, left, right))
    return segment.clear[left, right]


def _limit(limit: Limit) -> tuple[CriticalPoint, State]:
    state = limit.segment.states[limit.length]
    return CriticalPoint("limit", state.load, state.deflection, state.step, float(limit.length or state.length),
                         name="maximum" if limit.rising else "minimum", spread=limit.spread), state


def _turned_before(segment: Segment, earlier: State | None) -> list[Limit]:
    """The limit point of a step with contact before one without, at whose start the load has turned by its rate."""
    before = segment.before
    if earlier is None or before.load_rate * before.load_increment >= 0:
        return []
    return turning_loads(segment, earlier) if Segment(segment.tracer, earlier, before).nonsmooth else []


def _bifurcations(segment: Segment, limits: list[float], returns: list[float]) -> list[Crossing]:
    """Where eigenvalues pass zero along the path, limit points aside.

    At limit points, and where a path returns, an eigenvalue is zero, and rounding decides about its sign as near as
    pieces are not divided any more. The ends of the step are compared nevertheless: other steps count from them.
    With contact, where eigenvalues waver, the ends of the step are compared, and the states in between that are known
    to have the most and the fewest unstable modes.
    """
    near = CLOSEST * segment.after.length
    if segment.after.unstable_modes is None:
        return []
    if segment.nonsmooth:
        lengths = _extremes(segment)
    else:
        lengths = [s for s in sorted(segment.states) if s in (0.0, segment.after.length) or all(
            abs(s - zero) > near for zero in (*limits, *returns))]
    found = []
    for pair in zip(lengths[:-1], lengths[1:], strict=True):
        one, other = segment[pair[0]], segment[pair[1]]
        limit = (one.load_rate * other.load_rate < 0 and one.unstable_modes != other.unstable_modes
                 if segment.nonsmooth else any(pair[0] < length < pair[1] for length in limits))
        found += _crossings(segment, *pair, near, limit)
    return found


def _extremes(segment: Segment) -> list[float]:
    """The ends of a step and its states with the most and the fewest unstable modes, if these lie within it."""
    counts = {s: state.unstable_modes or 0 for s, state in segment.states.items()}
    most, fewest = (extreme(counts, key=counts.__getitem__) for extreme in (max, min))
    return sorted({0.0, segment.after.length, most, fewest})


def _hidden(one: State, other: State, limit: bool) -> int:
    """Least number of bifurcations between two states: a limit point changes the unstable directions by one."""
    if one.unstable_modes is None or other.unstable_modes is None:
        return 0
    change = abs(one.unstable_modes - other.unstable_modes)
    return abs(change - 1) if limit else change


def _crossings(segment: Segment, left: float, right: float, near: float, limit: bool) -> list[Crossing]:
    """Crossings between two states, between which a limit point lies or not."""
    one, other = segment[left], segment[right]
    count = _hidden(one, other, limit)
    if not count:
        return []
    if not limit:
        return pass_zero(segment, left, right, count)
    middle = (left + right) / 2
    if right - left <= 3 * near:
        return unresolved(segment, left, right, count)
    if not segment.reach(middle):
        return unresolved(segment, left, right, count)
    before = one.load_rate * segment[middle].load_rate < 0
    return (_crossings(segment, left, middle, near, before)
            + _crossings(segment, middle, right, near, not before))


def _clusters(crossings: list[Crossing], near: float, same: float) -> list[list[Crossing]]:
    """Crossings at equal loads together, in the order of their lengths, unless these differ by more than `near`.

    Parameters
    ----------
    same : relative difference of equal loads
    """
    clusters: list[list[Crossing]] = []
    for crossing in sorted(crossings, key=lambda c: c.length):
        last = clusters[-1][-1] if clusters else None
        if (last and (crossing.spread, crossing.corner) == (last.spread, last.corner)
                and crossing.length - last.length <= near
                and abs(crossing.load - last.load) <= same * abs(crossing.load)):
            clusters[-1].append(crossing)
        else:
            clusters.append([crossing])
    return clusters


def _agree(segment: Segment, *loads: float) -> bool:
    """Whether loads of a bifurcation agree: its state's, and where eigenvalues and where tangents have it.

    Where a path turns onto another one nearby, states that look like neighbours are not: their tangents lead away, and
    what lies between them is no equilibrium.
    """
    rise = np.ptp([s.load for s in segment.states.values()])
    return np.ptp(loads) <= AGREE * rise + segment.tracer.control.exact * max(map(abs, loads))


def _bifurcation(segment: Segment, crossings: list[Crossing], named: Naming) -> tuple[CriticalPoint, State | None]:
    """A simple or multiple bifurcation, classified, and its state.

    Where points have yielded the tangent belongs to a linear comparison solid, which goes on loading (Hill 1958). Its
    bifurcation is the first one of the structure, such as Shanley's (1947) of a column, but it has no energy that would
    say what follows, when points unload.
    """
    first, count, tracer = crossings[0], len(crossings), segment.tracer
    point = CriticalPoint("bifurcation", first.load, first.deflection, segment.after.step, first.length, count,
                          spread=first.spread)
    if segment.nonsmooth or not tracer.system.conservative or first.spread:
        tracer.back_to(segment.states[min(s for s in segment.states if s >= first.length)])
        solid = tracer.system.history.moved
        return replace(point, name="comparison solid" if solid else "corner" if first.corner else ""), None
    led, _ = segment.seen(first.length)
    try:
        state = segment.on_path(first.length)
    except Missed:
        return point, None
    if segment.guarded and not _agree(segment, state.load, first.load, led):
        raise Jump("the load at a bifurcation is not that of the path around it")
    values, modes = segment.spectrum(first.length, count)
    tracer.factorise_at(state)
    nearest = np.argsort(np.abs(values))[:count]
    null = [modes[i] for i in nearest]
    return named(tracer, state, null, point, [segment.before, segment.after]), state
