"""The states that a path has come by, and whether it comes back to them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np

from .measuring import Measuring
from .state import State

ASIDE = 0.1  # of the rise of the load between two states, that a path may pass beside
APART = 0.5  # of the motion between two states, likewise; a path may bend between them
ALIKE = 1.5  # ratio of rates of the load that may be the same
SKETCHED = 24  # numbers that a displacement is told by


class VisitedStates:
    """States of a path without what makes them large; their displacements are told by products with a few vectors.

    These are random: their products with a motion have, by their squares, about the size that the motion has, whichever
    it is (Johnson and Lindenstrauss 1984).

    Parameters
    ----------
    measure : of the path
    states : that it has come by so far, each with the increments since the one before
    """

    def __init__(self, measure: Measuring, states: Sequence[State]):
        system = measure.system
        self._comm, self._rows = system.comm, system.free_rows(lambda field: not field.curved)
        weights = system.weights.array[self._rows]
        random = np.random.default_rng(self._comm.rank).normal(size=(SKETCHED, len(weights)))
        self._vectors = random * np.sqrt(weights / SKETCHED)
        self._states: list[State] = []
        self._places: list[np.ndarray] = []
        for state in states:
            self.append(state)

    def append(self, state: State) -> None:
        """Add the next state."""
        self._places.append(self._place(state) if self._states else np.zeros(SKETCHED))
        self._states.append(replace(state, fields={}, increment=state.increment[:0].copy(),
                                    response=state.response[:0].copy()))

    def _place(self, after: State) -> np.ndarray:
        """Displacements at a state that a step from the last one leads to, in a few numbers."""
        return self._places[-1] + self._comm.allreduce(self._vectors @ after.increment[self._rows])

    def holds(self, after: State) -> bool:
        """Whether a state that a step from the last one leads to lies between earlier ones.

        It does where load and rate, deflection and other displacements, what touches, and stability are those of the
        path: the step has jumped from an unstable piece of path back onto the one before.
        """
        place = self._place(after)
        return any(_between(one, other, after) and _near(start, end, place, _part(one, other, after))
                   for (one, other), (start, end) in zip(pairwise(self._states), pairwise(self._places), strict=True))


def _part(one: State, other: State, after: State) -> float:
    """Where between two states a third one's deflection is, from 0 to 1; outside of that: elsewhere."""
    way = other.deflection - one.deflection
    return (after.deflection - one.deflection) / way if way else -1.0


def _near(start: np.ndarray, end: np.ndarray, place: np.ndarray, part: float) -> bool:
    """Whether displacements lie about a part of the way between two states."""
    return bool(np.linalg.norm(place - start - part * (end - start)) <= APART * np.linalg.norm(end - start))


def _between(one: State, other: State, after: State) -> bool:
    """Whether a state may lie between two others by load and rate, deflection, what touches, and stability."""
    part, span = _part(one, other, after), abs(other.load - one.load)
    touching = sorted((one.contact_points, other.contact_points))
    rates = sorted(map(abs, (one.load_rate, other.load_rate)))
    return (one.stage == after.stage and 0 <= part <= 1 and touching[0] <= after.contact_points <= touching[1]
            and after.unstable_modes in (one.unstable_modes, other.unstable_modes)
            and rates[0] / ALIKE <= abs(after.load_rate) <= rates[1] * ALIKE
            and abs(one.load + part * (other.load - one.load) - after.load) < ASIDE * span)
