"""The balance of work and energy along a step, which holds between states of one path however its rates waver.

What the loads do on the way from one state to the next is the change of the energy, and what friction takes. With these
known a path that leads there gives its loads in between: a step whose loads do not fit has jumped to another path.
"""

from __future__ import annotations

from itertools import pairwise
from math import inf
from typing import NamedTuple

import numpy as np

from ..rounding import SAFETY
from .corner import SHORT_OF
from .segment import Jump, Segment
from .state import State

WAVER = 1e-3  # of the work by the whole load, that loads which waver may be off
ASIDE = 0.1  # of the motion of the step before, least one that counts: others go on where the load's own stands still
POINTS = 5  # of integration of residuals along a straight way: exact for energies of degree 10


class _Way(NamedTuple):
    """Loads and motions along the load of a step, of the increment before it, and of the tangents at both ends.

    Each is a pair: of the load factor, and of the motion along the load.
    """

    step: tuple[float, float]
    before: tuple[float, float]
    tangents: tuple[tuple[float, float], tuple[float, float]]

    @property
    def is_straight(self) -> bool:
        """Whether load and motion go the way of the step at both of its ends."""
        return all(own * rate > 0 for tangent in self.tangents for own, rate in zip(self.step, tangent, strict=True))


def require_work(segment: Segment, earlier: State | None) -> None:
    """Refuse a step whose work is not stored or dissipated, unless contributions do not tell theirs.

    The load follows a parabola through the states; behind a corner a straight line; and around one the tangents at both
    ends. A step with a corner inside is sound up to there. Otherwise states within the step tell the load in between.

    Parameters
    ----------
    earlier : the state before the step; None: the parabola is none

    Raises
    ------
    Jump
    """
    before, after, tracer = segment.before, segment.after, segment.tracer
    if not tracer.system.work_known:
        return
    follows = earlier is not None and before.stage == after.stage and before.length > 0
    (change, gross), way, load = _energy(segment, before.direction if follows else (0.0, 0 * after.increment))
    share = after.length / before.length if follows else 0.0
    steepest, farthest = (max(abs(own), share * abs(last)) for own, last in zip(way.step, way.before, strict=True))
    allowed = tracer.control.unbalanced * steepest + WAVER * abs(after.factor)
    exact, *_ = tracer.snes.getTolerances()
    allowed = allowed * max(abs(way.step[1]), ASIDE * farthest) + SAFETY * exact * gross
    if abs(change - _even(way, share)) <= allowed:
        return
    if way.is_straight and abs(change - _even(way, 0.0)) <= allowed:
        return
    corner, work = _cornered(way)
    matches = abs(change - work) <= allowed
    if (matches and not 1 - SHORT_OF <= corner <= SHORT_OF) or tracer.stands_still(after):
        return
    sound = segment[corner * after.length] if matches and segment.reach(corner * after.length) else None
    if sound is None and _closes_in(segment, change, allowed, load):
        return
    raise Jump("the work done along the step is not what is stored and dissipated", sound)


def _closes_in(segment: Segment, change: float, allowed: float, load: np.ndarray) -> bool:
    """Whether the work by states within a step comes to be its change of energy, as more of them are known.

    Between two states it lies between those along the chord and along the tangents at both. States are added where
    these differ most, until it is what it has to be, or cannot be: where the step has jumped to another path the loads
    of states that are neighbours become alike, their works do not. Where the load turns, or where a chord goes another
    way than the tangents at its ends, nothing is known. From rest the load may rise before anything moves.

    Parameters
    ----------
    load : on the unknowns (this process's part), with which they do work
    """
    def along(increment: tuple[float, np.ndarray]) -> np.ndarray:
        return np.array([increment[0], segment.tracer.system.comm.allreduce(float(load @ increment[1]))])

    states, shortest = segment.states, segment.tracer.control.smallest * segment.tracer.shortest
    while True:
        lengths = sorted(states)
        places = [along(states[length].direction) if length else np.zeros(2) for length in lengths]
        tangents = [along(states[length].tangent) for length in lengths]
        if not segment.before.length:
            tangents[0] = places[-1] * (1.0, 0.0)
        steps = np.diff(places, axis=0)
        chords = [(one[0] + other[0]) / 2 * step[1] for (one, other), step in zip(pairwise(places), steps, strict=True)]
        bends = [_cornered(_Way(step, (0.0, 0.0), ends))[1] - step.prod() / 2
                 for step, ends in zip(steps, pairwise(tangents), strict=True)]
        bends = [bend if abs(step.prod()) > allowed else 0.0 for bend, step in zip(bends, steps, strict=True)]
        if np.ptp(np.sign(steps), axis=0).any() or not np.isfinite(bends).all():
            return False
        off, left_open = abs(change - sum(chords) - sum(bends) / 2), sum(map(abs, bends)) / 2
        if max(off, left_open) <= allowed or off > allowed + left_open:
            return off <= allowed
        widest = int(np.argmax(np.abs(bends)))
        left, right = lengths[widest:widest + 2]
        if right - left < shortest or not segment.reach((left + right) / 2):
            return False


def _even(way: _Way, share: float) -> float:
    """Work of the load beyond that at the start of a step, by a parabola through three states, or a line through two.

    Parameters
    ----------
    share : ratio of the step's length to the last step's; 0: there is none
    """
    rise, motion = way.step
    bends = [share * (share * a - b) / (1 + share) for a, b in zip(way.before, way.step, strict=True)]
    return rise * motion / 2 + (bends[0] * motion - bends[1] * rise) / 6


def _cornered(way: _Way) -> tuple[float, float]:
    """Part of a step at which the tangents at its ends meet, and the work along them; infinite: they do not."""
    (rise, motion), (one, other) = way.step, way.tangents
    if not (turn := one[0] * other[1] - other[0] * one[1]):
        return 0.0, inf
    parts = (rise * other[1] - other[0] * motion) / turn, (one[0] * motion - rise * one[1]) / turn
    if min(parts) <= 0:
        return 0.0, inf
    return parts[0] / sum(parts), rise * motion / 2 + parts[0] * parts[1] * turn / 2


def _energy(segment: Segment,
            step_before: tuple[float, np.ndarray]) -> tuple[tuple[float, float], _Way, np.ndarray]:
    """Work taken up from the first to the last state less that of the first load; the way of the loads; and the load.

    Beside the work the sum of the sizes of its parts.
    """
    before, after, tracer = segment.before, segment.after, segment.tracer
    system, increment = tracer.system, after.increment
    rough, smooth = system.rough, [c for c in system.contributions if c not in system.rough]
    out, moved = system.create_vector(), system.create_vector()
    tracer.back_to(before)
    starts = [c.touch() for c in rough]
    load = tracer.load_vector().array
    points, weights = np.polynomial.legendre.leggauss(POINTS)
    change = 0.0
    with system.additive_increments(frozen=False):
        for part, weight in zip((1 + points) / 2, weights / 2, strict=True):
            moved.array[:] = part * increment
            system.configure(moved, before.factor)
            system.residual_of(smooth, out)
            change += weight * float(out.array @ increment)
        moved.array[:] = increment
        system.configure(moved, before.factor)
        ends = [c.touch() for c in rough]
        system.load(out)
        loads = load, out.array
    tracer.back_to(after)
    ends = [c.touch() if c.augments else end for c, end in zip(rough, ends, strict=True)]
    stored = sum(c.work_between(*states) for c, *states in zip(rough, starts, ends, strict=True))
    motions = [sum(loads) / 2 @ increment, load @ step_before[1],
               *(one @ state.tangent[1] for one, state in zip(loads, (before, after), strict=True))]
    change, *motions = system.comm.allreduce(np.array([change, *motions])).tolist()
    step, last = (after.load_increment, motions[0]), (step_before[0], motions[1])
    tangents = (before.load_rate, motions[2]), (after.load_rate, motions[3])
    return (change + stored, abs(change) + abs(stored)), _Way(step, last, tangents), sum(loads) / 2
