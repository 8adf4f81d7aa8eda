"""The curve of a path between its states, by their tangents."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from scipy.interpolate import CubicHermiteSpline, KroghInterpolator

from ..continuation.state import CriticalPoint, State
from .shown import Shown

PIECES = 24  # straight pieces between two knots
TURNING = 1.0  # radians between the tangent of a state and the chord of a step, beyond which it does not lead along it
MOST = 3  # critical points within a step, up to which one polynomial goes through all of them


def monitored(record: Shown, states: Sequence[State]) -> tuple[np.ndarray, np.ndarray]:
    """Deflection and load of states, and their rates along the path, each of shape (states, 2)."""
    return (np.array([(s.deflection, s.load) for s in states]),
            np.array([(_deflection_rate(record, s), _load_rate(record, s)) for s in states]))


def _deflection_rate(record: Shown, state: State) -> float:
    tracer = record.path.tracer
    return tracer.monitored_rate(tracer.system.create_vector(state.tangent[1]))


def _load_rate(record: Shown, state: State) -> float:
    """Rate of the reported load: of a prescribed motion its reaction's."""
    discretisation, system = record.path.discretisation, record.path.discretisation.system
    unit = discretisation.load_of_unit()
    if unit is not None:
        return unit * state.load_rate
    motions = system.motions(system.create_vector(state.tangent[1]))
    multipliers = [(field, field.value.x.array.copy(), motion.ravel())
                   for field, motion in zip(system.unknowns.fields, motions, strict=True) if field.multiplier]
    for field, _, motion in multipliers:
        field.show(motion)
    rate = discretisation.total_load()
    for field, kept, _ in multipliers:
        field.show(kept)
    return rate


def curve_of(record: Shown, states: Sequence[State], values: np.ndarray, rates: np.ndarray,
             inside: Callable[[CriticalPoint], Sequence[float]] | None = None,
             stationary: int | None = None) -> tuple[np.ndarray, np.ndarray]:
    """Points of the curve of some values along a path.

    It is Hermite's cubic in the length of each step, with the tangents of its ends, or with the ones that lead
    along it; critical points are on it.

    Parameters
    ----------
    values, rates : of states, and their rates by the length of the path, shape (states, n)
    inside : function that gives the values at a critical point; None: critical points are left out
    stationary : number of the value that limit points are extremes of

    Returns
    -------
    (m, n) points; (m - 1,) number of the interval between states and critical points that each piece lies in
    """
    if len(states) < 2:
        return values, np.zeros(0, dtype=int)
    points, knots = [values[:1]], 0
    for i, (before, after) in enumerate(zip(states[:-1], states[1:], strict=True)):
        slopes = _slopes(record, before, after, values[i:i + 2], rates[i:i + 2])
        own = points_in(states, after) if inside else []
        places = np.array([0.0, *(p.length / after.length for p in own), 1.0])
        at = np.vstack([values[i], *(inside(p) for p in own), values[i + 1]]) if inside else values[i:i + 2]
        limits = [n for n, p in enumerate(own, start=1) if p.kind == "limit" and stationary is not None]
        for piece in _pieces(places, at, slopes, limits, stationary):
            points.append(piece[1:])
            knots += 1
    return np.concatenate(points), np.repeat(np.arange(knots), PIECES)


def points_in(states: Sequence[State], after: State) -> list[CriticalPoint]:
    """Critical points of the step to a state, in their order; a later state may have brought them to light."""
    return sorted((p for s in states for p in s.critical if p.step == after.step), key=lambda p: p.length)


def _slopes(record: Shown, before: State, after: State, values: np.ndarray, rates: np.ndarray) -> np.ndarray:
    """Rates at both ends of a step by the part of it that has been gone."""
    tracer, chord = record.path.tracer, after.direction
    size = tracer.distance(*chord)
    return np.array([size * rate if tracer.angle(chord, state.tangent) <= TURNING else values[1] - values[0]
                     for state, rate in zip((before, after), rates, strict=True)])


def _pieces(places: np.ndarray, values: np.ndarray, slopes: np.ndarray, limits: Sequence[int],
            stationary: int | None) -> list[np.ndarray]:
    """Points of the cubics between places of a step, with the slopes that an interpolation of all of it has there.

    Parameters
    ----------
    limits, stationary : numbers of places where one of the values has no slope, and of that value
    """
    ends = CubicHermiteSpline((0.0, 1.0), values[[0, -1]], slopes).derivative()
    if 2 < len(places) <= 2 + MOST and np.diff(places).min() > 0:
        order = np.argsort(np.concatenate([places, (0.0, 1.0)]), kind="stable")
        ends = KroghInterpolator(np.concatenate([places, (0.0, 1.0)])[order],
                                 np.vstack([values, slopes])[order]).derivative
    rates = np.vstack([slopes[0], *(ends(place) for place in places[1:-1]), slopes[1]])
    for place in limits:
        rates[place, stationary] = 0.0
    found = []
    for k in range(len(places) - 1):
        if places[k + 1] <= places[k]:
            found.append(np.linspace(values[k], values[k + 1], PIECES + 1))
            continue
        cubic = CubicHermiteSpline(places[k:k + 2], values[k:k + 2], rates[k:k + 2])
        found.append(cubic(np.linspace(places[k], places[k + 1], PIECES + 1)))
    return found
