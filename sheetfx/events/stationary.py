"""Where the load of a piece of path is stationary: limit points, and returns of a branch to where it came from."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.interpolate import KroghInterpolator

from ..continuation.segment import Missed, Segment
from ..continuation.work import WAVER
from ..rounding import SAME, root
from .crossings import REACHES, SAMPLES, Crossing
from .turning import SHORT, Limit

ONWARD = 0.1  # rate of a displacement where the load is stationary, over the larger one beside it
TURNED = 1e-5  # of the change of the load in a step, that by which it has turned, not wavered


def surround(segment: Segment, length: float, reaches: Sequence[float] = REACHES[:2]) -> None:
    """Have states on both sides of a bifurcation, from which its own is interpolated, none of them twice."""
    for away in (reach * segment.after.length for reach in reaches):
        for wanted in (length - away, length + away):
            if 0 < wanted < segment.after.length and min(abs(s - wanted) for s in segment.states) > away / 4:
                segment.reach(wanted)


def stationary_loads(segment: Segment, known: Sequence[float] = ()) -> tuple[list[Limit], list[float]]:
    """Where the load rate is zero: limit points, and lengths of returns.

    Parameters
    ----------
    known : lengths of returns that have been found with fewer states; those beside them now are dropped

    Raises
    ------
    Missed
        If states between two whose rates have other signs do not converge, and the segment is guarded.
    """
    limits: list[Limit] = []
    returns: list[float] = []
    for length in known:
        _forget_beside(segment, length)
    for left, right in segment.pairs():
        forgotten = not {left, right} <= segment.states.keys()  # beside a return
        if forgotten or not segment[left].load_rate * segment[right].load_rate < 0:
            continue
        rising = segment[left].load_rate > 0
        try:
            length = segment.stationary(left, right, SAME)
            if _returns(segment, length):
                returns.append(length)
            else:
                limits.append(Limit(segment, length, rising))
        except Missed:
            if segment.guarded:
                raise
            low, high = sorted(segment[s].load for s in (left, right))
            limits.append(Limit(segment, right, rising, (low, high)))
    return limits, returns


def _returns(segment: Segment, length: float) -> bool:
    """Whether the path comes back here to the one that it branched off, and the load turns at that bifurcation.

    A branch that is symmetric about the bifurcation leads through it to its mirror image: load and the displacement
    that it works on turn together. At a limit point the load alone turns, and the current stiffness passes zero. There
    the tangent is singular and rates are rounding: states on both sides tell them. These stay, those nearer are
    dropped.
    """
    def sides(reach: float) -> list[float]:
        wanted = (length - reach, length + reach)
        return [max((s for s in segment.states if s <= wanted[0]), default=0.0),
                min((s for s in segment.states if s >= wanted[1]), default=segment.after.length)]

    def stiff(reach: float) -> bool:
        one, other = (segment[s].current_stiffness for s in sides(reach))
        return one * other > 0

    if not (segment.guarded and segment.tracer.system.conservative):
        return False
    coarse, fine = (reach * segment.after.length for reach in REACHES[1:3])
    if not stiff(coarse):
        return False
    surround(segment, length, REACHES[:3])
    one, other = sides(coarse / 2)
    if segment[one].unstable_modes != segment[other].unstable_modes or not stiff(coarse / 2):
        return False
    beside = sorted({one, other, *sides(fine / 2)})
    rates = KroghInterpolator(beside, [(s.load_rate, s.load_rate / s.current_stiffness)
                                       for s in map(segment.__getitem__, beside)])
    if rates(one)[0] * rates(other)[0] > 0:
        return False
    onward = abs(rates(root(lambda s: rates(s)[0], one, other))[1])
    if onward > ONWARD * max(abs(rates(s)[1]) for s in (one, other)):
        return False
    _forget_beside(segment, length)
    return True


def _forget_beside(segment: Segment, length: float) -> None:
    """Drop the states beside a return whose rates are rounding."""
    segment.forget(length, REACHES[2] * segment.after.length / 2)


def turns(segment: Segment) -> int:
    """How often the load turns along the states that are known.

    Where it does so between states that a search for bifurcations has brought to light, the path bends away there, and
    those behind are on another one; or, with contact, limit points lie between the ends of the step. There loads waver,
    and of short steps nothing is said.
    """
    factors = [segment.states[s].factor for s in sorted(segment.states)]
    small, extreme, sense, count = TURNED * np.ptp(factors), factors[0], 0.0, 0
    if segment.nonsmooth:
        if segment.after.length <= SHORT * segment.tracer.usual:
            return 0
        small = max(small, WAVER * max(map(abs, factors)))
    for factor in factors[1:]:
        change = factor - extreme
        if abs(change) > small:
            count += sense * change < 0
            extreme, sense = factor, np.sign(change)
    return count


def returning(segment: Segment, length: float) -> Crossing:
    """The bifurcation that the path returns to, interpolated between states on both sides."""
    coarser, finer = (_stationary(segment, length, count) for count in (SAMPLES - 2, SAMPLES))
    if abs(finer.load - coarser.load) > segment.tracer.control.exact * abs(finer.load):
        surround(segment, length, REACHES[-1:])
        finer = _stationary(segment, length, SAMPLES)
    return finer


def _stationary(segment: Segment, length: float, count: int) -> Crossing:
    """Where the load rate is zero by an interpolation between the nearest states."""
    nearest = sorted(segment.states, key=lambda s: abs(s - length))
    left, right = (next(s for s in nearest if (s - length) * side > 0) for side in (-1, 1))
    samples = [left, right, *(s for s in nearest if s not in (left, right))][:count]
    table = KroghInterpolator(samples, [(segment[s].load_rate, segment[s].load, segment[s].deflection)
                                        for s in samples])
    found = root(lambda s: table(s)[0], left, right)
    _, load, deflection = table(found)
    return Crossing(found, float(load), float(deflection))
