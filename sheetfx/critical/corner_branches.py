"""Branches of a corner of a path, at which pairs open or close: all tangents with which it can go on.

Let K be the tangent just ahead of the corner, G the derivatives of the gaps of those pairs that are about to open or
to close there, and k their stiffnesses. For rates of the unknowns x' and of the load factor l',

    x' = K^-1 (l' p + G^T f),   g' = G x',   f = k g' of pairs that open, -k g' of those that close, zero of others,

which is a solution where gaps of all open pairs grow and gaps of closed ones shrink: a linear complementarity problem
(Cottle, Pang and Stone 1992, chapter 1). Where the structure is stable with and without the pairs it has one solution
for each sense of the load. Where it is not there may be many, and going through all sets of pairs finds them all. The
one with which nothing changes leads back along the path.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import combinations

import numpy as np
from petsc4py import PETSc
from scipy.sparse import vstack

from ..continuation.segment import Segment
from ..continuation.state import CriticalPoint, State
from ..rounding import SAME

NEAR, TOGETHER = 1e-3, 1e-4  # of the load, way to the first pair that changes, and from there to the last one
MOST = 14  # pairs that change, of which all sets are gone through
LENGTHS = 4.0, 16.0, 64.0, 256.0  # of steps along branches that are tried, over the way to the last pair that changes
LEAST = 1e-6  # of the usual first step, that way at least


class Unsettled(ArithmeticError):
    """The branches of a corner cannot be told."""


@dataclass(frozen=True)
class Way:
    """A tangent with which a path can go on.

    Attributes
    ----------
    changes : for each pair that may open or close whether it does
    response : change of the unknowns by a unit of the load factor
    sense : 1 where the load rises, -1 where it falls
    """

    changes: np.ndarray
    response: PETSc.Vec
    sense: float


class Corner:
    """Pairs that are about to open or to close where a path is, and how the structure gives way there.

    Parameters
    ----------
    state : just ahead of the corner

    Raises
    ------
    Unsettled
    """

    def __init__(self, tracer, state: State):
        self._tracer, self._state, system = tracer, state, tracer.system
        pairs = [c for c in system.contributions if c.condenses]
        if not pairs or not system.conservative:
            raise Unsettled("branches of corners are known of pairs that are condensed, without friction")
        tracer.factorise_at(state)
        self._pairs = pairs
        gaps, motions = self._gaps(), vstack([c.motions() for c in pairs], format="csr")
        self._load = system.everywhere(system.create_vector(state.response))
        self._chosen = self._about_to_change(gaps, motions @ self._load * np.sign(state.load_rate))
        self._closed, self._motions = gaps[self._chosen] <= 0, motions[self._chosen]
        self._stiffness = self._stiffnesses(gaps)[self._chosen] * np.where(self._closed, 1, -1)
        self._responses = tracer.stepper.linear.responses(self._motions.T.tocsc())
        self._flexibility = np.asarray(self._motions @ self._responses.T)

    def _gaps(self) -> np.ndarray:
        return np.concatenate([c.place() for c in self._pairs])

    def _about_to_change(self, gaps: np.ndarray, rates: np.ndarray) -> np.ndarray:
        """Numbers of the pairs whose gaps pass zero together, first along the tangent."""
        size = abs(self._state.factor)
        with np.errstate(divide="ignore", invalid="ignore"):
            ahead = np.where(gaps * rates < 0, -gaps / rates, np.inf)
        first = ahead.min(initial=np.inf)
        if not first <= NEAR * size:
            raise Unsettled("no pair opens or closes close ahead")
        chosen = np.flatnonzero(ahead <= first + TOGETHER * size)
        way = ahead[chosen].max() * self._tracer.distance(0.0, self._state.response)
        self._way = max(way, LEAST * self._tracer.usual)
        if len(chosen) > MOST:
            raise Unsettled(f"{len(chosen)} pairs open or close together; the sets of {MOST} at most are gone through")
        return chosen

    def _stiffnesses(self, gaps: np.ndarray) -> np.ndarray:
        """Of all pairs where they touch."""
        shut, ends = np.where(gaps > 0, -gaps * (1 + SAME), 0.0), np.cumsum([c.pairs.count for c in self._pairs])[:-1]
        return np.concatenate([c.law_of_changes()[1](part).diagonal()
                               for c, part in zip(self._pairs, np.split(shut, ends), strict=True)])

    def ways(self) -> Iterator[Way]:
        """All but the one that leads back, by the number of pairs that change."""
        along, count = np.asarray(self._motions @ self._load), len(self._chosen)
        back = -np.sign(self._state.load_rate)
        for sense in (back, -back):
            for number in range(int(sense == back), count + 1):
                for members in map(list, combinations(range(count), number)):
                    changes = np.zeros(count, dtype=bool)
                    changes[members] = True
                    forces = np.zeros(count)
                    stiffness = self._stiffness[members, None]
                    forces[members] = np.linalg.solve(
                        np.eye(number) - stiffness * self._flexibility[np.ix_(members, members)],
                        stiffness[:, 0] * sense * along[members])
                    rates = sense * along + self._flexibility @ forces
                    if np.array_equal(rates > 0, self._closed == changes):
                        system = self._tracer.system
                        yield Way(changes, system.create_vector(
                            system.own(self._load + sense * (forces @ self._responses))), sense)

    def changed(self, state: State) -> np.ndarray:
        """For each pair that may open or close whether it has, up to a state; the tracer ends there."""
        if self._tracer.state is not state:
            self._tracer.back_to(state)
        return (self._gaps()[self._chosen] <= 0) != self._closed

    def start(self, way: Way) -> tuple[State | None, str]:
        """A state along a way past the corner, and why it may not lie there; None: none converges."""
        found = None
        for times in LENGTHS:
            self._tracer.back_to(self._state)
            state = self._tracer.attempt_along(way.response, way.sense, times * self._way)
            if state is not None and np.array_equal(self.changed(state), way.changes):
                return state, ""
            found = found or state
        return found, "other pairs open or close up to its start than its tangent says"


def corner_of(tracer, before: State, after: State, point: CriticalPoint) -> Corner:
    """The corner that a point of the step from `before` to `after` is.

    Raises
    ------
    Unsettled, Jump, Missed
    """
    return Corner(tracer, Segment(tracer, before, after)[point.length])
