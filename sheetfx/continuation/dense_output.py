"""Increments along a step by its states and their tangents: Hermite's interpolation, whose order rises with each state.

A tangent is a direction at its own state. As a rate of the increments since the step began its rotations are those of
Rodrigues vectors, and its size is that with which the control's measure of the step grows.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from scipy.interpolate import KroghInterpolator

from ..rounding import DIFFERENCE, root
from .state import State

MOST = 4  # states that are interpolated between
APART = 0.1  # distance of two states over their distance from the place in question


class DenseOutput:
    """The way from a state on.

    Parameters
    ----------
    tracer : Tracer, which ends at `before` whenever a place is asked for
    before, after : states at both ends of a step
    """

    def __init__(self, tracer, before: State, after: State):
        self._tracer, self._before, self._after = tracer, before, after
        self._rates: dict[float, tuple[State, tuple[float, np.ndarray] | None]] = {}
        self._tangents: dict[float, tuple[State, tuple[float, np.ndarray]]] = {}

    def at(self, length: float, states: dict[float, State]) -> tuple[float, np.ndarray]:
        """Increments of load factor and unknowns at a length, between states by their lengths."""
        return self._interpolated(length, states, 0)

    def rate_at(self, length: float, states: dict[float, State]) -> tuple[float, np.ndarray]:
        """Rates of the values of `at`, by the share of the step's length."""
        return self._interpolated(length, states, 1)

    def _interpolated(self, length: float, states: dict[float, State], order: int) -> tuple[float, np.ndarray]:
        """Increments of load factor and unknowns, or their derivatives of an order."""
        places, data = self._data(length, states)
        self._tracer.back_to(self._before)
        weights = KroghInterpolator(places, np.eye(len(places))).derivative(length / self._after.length, order)
        return (float(sum(w * load for w, (load, _) in zip(weights, data, strict=True))),
                sum(w * x for w, (_, x) in zip(weights, data, strict=True)))

    def turning(self, left: float, right: float, states: dict[float, State]) -> float | None:
        """Length at which the load factor is stationary between two states; None if that is not seen."""
        length = (left + right) / 2
        for _ in range(2):
            places, data = self._data(length, states)
            load, ends = KroghInterpolator(places, [factor for factor, _ in data]), (
                left / self._after.length, right / self._after.length)
            rates = [load.derivative(end) for end in ends]
            if not rates[0] * rates[1] < 0:
                return None
            length = self._after.length * root(load.derivative, *ends)
        return length

    def _data(self, length: float, states: dict[float, State]) -> tuple[list[float], list[tuple[float, np.ndarray]]]:
        """Places of the step, twice where the rate is known, and increments and rates there."""
        places, data = [], []
        for place in _nearest(length, states):
            state, rate = states[place], self._rate(place, states[place])
            increments = state.direction if place else (0.0, np.zeros_like(state.increment))
            for value in [increments] if rate is None else [increments, rate]:
                places.append(place / self._after.length)
                data.append(value)
        return places, data

    def _rate(self, length: float, state: State) -> tuple[float, np.ndarray] | None:
        """Rates by the share of the step's length; None where the tangent does not lead on."""
        known = self._rates.get(length)
        if known is None or known[0] is not state:
            known = self._rates[length] = state, self._found(length, state)
        return known[1]

    def _found(self, length: float, state: State) -> tuple[float, np.ndarray] | None:
        tracer, (load, along) = self._tracer, self.tangent(length, state)
        measure, tangent = tracer.control.measure, tracer.tangent
        tracer.back_to(self._before)
        if not length:
            leads = tracer.inner((load, along), self._after.direction) > 0
            pace = measure(tangent, tracer.system.create_vector(along), load) if leads else 0.0
        else:
            x, rate = (tracer.system.create_vector(values) for values in (state.increment, along))
            tracer.system.configure(x, state.factor)
            part = float(DIFFERENCE * length / (measure(tangent, rate, load) or 1.0))
            ahead, behind = (measure(tangent, x + sign * part * rate, state.load_increment + sign * part * load)
                             for sign in (1.0, -1.0))
            pace = (ahead - behind) / (2 * part)
        if not pace > 0:
            return None
        size = self._after.length / pace
        return size * load, size * along

    def tangent(self, length: float, state: State) -> tuple[float, np.ndarray]:
        """Tangent of a state as rates of the increments since the step began: rotations turn in each state's own axes.

        The system does not stay where it is.
        """
        known = self._tangents.get(length)
        if known is None or known[0] is not state:
            known = self._tangents[length] = state, self._turned(state) if length else state.tangent
        return known[1]

    def _turned(self, state: State) -> tuple[float, np.ndarray]:
        tracer, system, (load, along) = self._tracer, self._tracer.system, state.tangent
        system.restore(state.fields)
        motions = system.motions(system.create_vector(along))
        tracer.back_to(self._before)
        system.configure(system.create_vector(state.increment), state.factor)
        return load, system.rate_by(motions).array.copy()


def _nearest(length: float, places: Iterable[float]) -> list[float]:
    """Places about a length, those next to it first, without those that are too close to each other."""
    ordered = sorted(places, key=lambda s: abs(s - length))
    sides = [next((s for s in ordered if side * (s - length) >= 0), None) for side in (-1, 1)]
    found = [s for s in dict.fromkeys(sides) if s is not None]
    for s in ordered:
        if len(found) < MOST and all(abs(s - other) > APART * abs(s - length) for other in found):
            found.append(s)
    return found
