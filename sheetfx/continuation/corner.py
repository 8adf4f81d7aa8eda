"""Steps around corners of a path, at which something begins or ceases to touch or to slip.

Ahead of a corner another tangent holds than behind it. Where the structure has lost stability with it the path leads on
at an angle of more than ninety degrees from where it came, with a load that turns: Newton's iteration from the tangent
behind the corner, or along the one ahead but forwards, hops between both. It converges from a prediction along the
tangent ahead of the corner, in whichever sense contacts go on as they are there.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import nullcontext
from itertools import product

import numpy as np
from mpi4py import MPI
from petsc4py import PETSc

from .inertia import can_stick, sticking
from .linear import SingularTangent
from .state import CriticalPoint, State
from .visited import VisitedStates

SHORTER, FEWEST = 1 / 4, 3  # ratio of the lengths of steps that are tried, and how many at least
LEAST = 1 / 8  # of the usual first step, the longest one at least: beside a corner steps have become short
AHEAD = 0.5  # of a step that is tried, distance at which the tangent is the other side's
SHORT_OF = 0.98  # of the way to a change of contact, for the state ahead of it; beyond it a corner leaves steps whole
BACK = 0.95  # cosine of the angle with the step before, from which a step goes back where it came from


def around_corner(tracer, before: State, longest: float, failed: float, trail: VisitedStates | None = None,
                  earlier: State | None = None) -> Iterator[State]:
    """Steps from a state that lies at a corner of the path, the shortest first; at the end back at the state.

    None is looked for on smooth paths, at the start of a stage, nor where the control leaves steps as they are. Where
    it prescribes the load, the path leads on with that load.

    Parameters
    ----------
    longest, failed : length of the longest step that is tried, and of the shortest one that has failed ahead
    trail : states that have led here; None: they do not matter
    earlier : the one before; None: not known
    """
    control = tracer.control
    if tracer.system.smooth or not control.guarded or not before.length:
        return
    if not control.passes_limits:
        if (found := tracer.attempt(failed)) is not None:
            yield found
        return
    flows = earlier is not None and tracer.system.history.moved_since(earlier.fields)
    ways = (False, True) if can_stick(tracer.system) else (False,)
    for length, sticks in product(_lengths(longest, failed), ways):
        try:
            solution, forwards = _ahead(tracer, before, AHEAD * length, sticks)
        except SingularTangent:
            continue
        for sign in _senses(tracer, before, solution, forwards, AHEAD * length):
            tracer.back_to(before)
            after = tracer.attempt_along(solution, sign, length)
            if (after is not None and _leads_on(tracer, before, after, earlier) and not (trail and trail.holds(after))
                    and not (flows and _unloads(tracer, before, after))):
                yield after
    tracer.back_to(before)


def up_to_bifurcation(tracer, before: State, failed: float) -> tuple[State, CriticalPoint] | None:
    """The last state before points begin to flow with which the comparison solid loses stability, and that point.

    None where nothing tells of it, or where it is known. Beyond it no short step has converged: as at the collapse of a
    frame that sways, the tangent of loading has lost its stability at once, and what follows is not near.

    Parameters
    ----------
    failed : length of the shortest step that has been tried
    """
    system, modes = tracer.system, before.unstable_modes
    known = any(point.kind == "bifurcation" for point in before.critical)
    if system.smooth or system.rough or not system.conservative or not tracer.control.passes_limits or known:
        return None
    try:
        _, forwards = _ahead(tracer, before, failed, sticks=False)
        pivots = tracer.stepper.linear.negative_pivots()
    except SingularTangent:
        pivots = None
    tracer.back_to(before)
    count = 0 if None in (pivots, modes) else abs(pivots - system.multipliers - modes) - (forwards < 0)
    exact, *_ = tracer.snes.getTolerances()
    while count > 0 and failed * abs(before.load_rate) > exact * abs(before.factor):
        failed /= 2
        if (after := tracer.attempt(failed)) is not None:
            return after, CriticalPoint("bifurcation", after.load, after.deflection, after.step, after.length, count,
                                        "comparison solid")
    return None


def change_ahead(tracer, before: State, within: float) -> float | None:
    """Length of a step, along its tangent, at which contact changes last within a length; None: nowhere there."""
    tracer.back_to(before)
    system, load = tracer.system, tracer.control.predict(within, tracer.control.direction(before), tracer.tangent)
    now, then = (_gaps(tracer, before, part, part * before.response) for part in (0.0, load))
    changes = now * then < 0
    last = float(np.max(now[changes] / (now - then)[changes], initial=0.0))
    return within * system.comm.allreduce(last, MPI.MAX) or None


def _gaps(tracer, before: State, load: float, x: np.ndarray) -> np.ndarray:
    """Gaps of all contacts at increments of the load factor and of the unknowns; at the end back at the state."""
    system = tracer.system
    tracer.x.array[:] = x
    system.configure(tracer.x, before.factor + load)
    found = np.concatenate([c.gaps() for c in system.contributions])
    tracer.back_to(before)
    return found


def _senses(tracer, before: State, solution: PETSc.Vec, forwards: float, distance: float) -> list[float]:
    """Signs of the load with which a path may lead on behind a corner: those with which contacts change as ahead of it.

    Both where no gap tells, or some tell one and some the other; the way forwards first.

    Parameters
    ----------
    solution, forwards : as of `_ahead` at the distance
    """
    load, x = before.tangent
    now, then = (_gaps(tracer, before, part * load, part * x) for part in (0.0, distance))
    small = distance / tracer.distance(1.0, solution.array)
    rates = _gaps(tracer, before, small, small * solution.array) - now
    ways = np.array([((now * then < 0) & (then * rates * sign > 0)).sum() for sign in (forwards, -forwards)])
    tracer.system.comm.Allreduce(MPI.IN_PLACE, ways, MPI.SUM)
    return [sign for sign, way in zip((forwards, -forwards), ways, strict=True) if way or not ways.any()]


def up_to_change(tracer, before: State, ahead: float) -> State | None:
    """A state just ahead of where contact changes, about at a length; None: none converges.

    The tangent of a state close to it tells once more where that is.
    """
    tracer.back_to(before)
    near = tracer.attempt(SHORT_OF * ahead)
    if near is None:
        return None
    rest = change_ahead(tracer, near, 2 * (1 - SHORT_OF) * ahead)
    tracer.back_to(before)
    closer = tracer.attempt(near.length + SHORT_OF * rest) if rest else None
    return closer or near


def _lengths(longest: float, failed: float) -> list[float]:
    """Those that are tried, in ascending order: a short step around a corner sees what lies close behind it.

    It has to be longer than the one that failed ahead of the corner, which may end there.
    """
    lengths = [longest]
    while len(lengths) < FEWEST or lengths[-1] * SHORTER > failed:
        lengths.append(lengths[-1] * SHORTER)
    return lengths[::-1]


def _ahead(tracer, before: State, distance: float, sticks: bool) -> tuple[PETSc.Vec, float]:
    """Response to the load at a distance along the tangent, and the sign of the load with which it leads on.

    What touches there may have slid up to it, so that it slips; if it `sticks` it does so from there on.
    """
    tracer.back_to(before)
    load, x = before.tangent
    system, solution = tracer.system, tracer.system.create_vector()
    tracer.x.array[:] = distance * x
    system.configure(tracer.x, before.factor + distance * load)
    system.extrapolate_stress()
    with sticking(system) if sticks else nullcontext():
        tracer.stepper.factorise(tracer.snes, tracer.x)
    tracer.stepper.linear.solve(tracer.load_vector(), solution)
    return solution, float(np.sign(tracer.inner((0.0, solution.array), (0.0, x)))) or 1.0


def _leads_on(tracer, before: State, after: State, earlier: State | None) -> bool:
    """Whether a step does not go back along the one before: where it turns back sharply other modes are unstable."""
    one, other = before.direction, after.direction
    return (after.unstable_modes != _unstable_behind(before, after.length, earlier)
            or tracer.inner(one, other) > -BACK * tracer.distance(*one) * tracer.distance(*other))


def _unstable_behind(before: State, distance: float, earlier: State | None) -> int | None:
    """Number of unstable modes at a distance back along the path, which may have passed its corner by a hair."""
    passed = any(point.step == before.step and point.kind != "event" and before.length - point.length < distance
                 for point in before.critical)
    return earlier.unstable_modes if passed and earlier is not None else before.unstable_modes


def _unloads(tracer, before: State, after: State) -> bool:
    """Whether a step goes back while what flowed unloads, as it can from each of its states: a structure that is
    stiffer without other contacts, or in which nothing flows. One that has lost stability is not stiffer.
    """
    more = (after.unstable_modes or 0) - (before.unstable_modes or 0)
    if tracer.inner(before.direction, after.direction) >= 0 or more > 0:
        return False
    stiffer = tracer.system.conservative and more < 0 and after.contact_points == before.contact_points
    return stiffer or not tracer.system.history.moved_since(before.fields)
