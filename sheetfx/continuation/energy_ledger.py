"""What the balance of energy knows of the states of a path, and of states that are found within its steps for it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import cast

import numpy as np

from ..discrete.discretisation import Discretisation
from ..rounding import SAME
from .segment import Jump, Missed, Segment
from .state import State
from .tracer import Tracer

UNSURE = 0.01  # of its difference from the rule of a single point, what Gauss's rule along a step may be off
GAUSS_ALONG = (1 + np.sqrt(0.6) * np.array([-1.0, 0.0, 1.0])) / 2, np.array([5.0, 8.0, 5.0]) / 18


@dataclass(frozen=True)
class Account:
    """Known of a state: energies, W of each stage so far, q of the present one and its rate by the factor.

    Dead loads are those that W was made of in the first state; `unsure` is the accuracy of q since the state before.

    Attributes
    ----------
    joints : energy of each joint and contact
    touches : of those with friction what their work from this state to the next depends on, as far as they tell
    place : part of the step from the last state of the path that leads here; 0: a state of the path
    """

    state: State
    parts: list[float]
    joints: list[float]
    touches: list[np.ndarray | None]
    dissipated: float
    done: list[float]
    product: float
    rate: float
    dead: bool
    proportional: bool
    unsure: float = 0.0
    place: float = 0.0


class EnergyLedger:
    """Accounts of the states of a path, and of states within its steps.

    Parameters
    ----------
    states : of the path

    Attributes
    ----------
    fallen : numbers of states into which the structure has fallen from the one before
    """

    def __init__(self, tracer: Tracer, states: Sequence[State]):
        self._tracer, self._structure = tracer, cast(Discretisation, tracer.discretisation)
        self._loads: dict[int, np.ndarray] = {}
        self._within: list[Segment | None] = [None] * (len(states) - 1)
        system = tracer.system
        self._others = [c for c in system.contributions[len(self._structure.scene.parts):] if c.stage is None]
        self._turning = system.free_rows(lambda field: field.curved)
        self._steps = [[self._account(state)] for state in states]
        self.fallen = [n for n in range(1, len(states))
                       if not states[n].length and states[n].stage == states[n - 1].stage]

    @property
    def dead(self) -> bool:
        """Whether loads are the same in all states."""
        return all(account.dead for step in self._steps for account in step)

    def balanced(self) -> list[Account]:
        """All of them in order; W and q are integrals of the loads along the way where these change."""
        accounts = [account for step in self._steps for account in step]
        return accounts if self.dead or self.fallen else self._followed()

    def rubbed(self, before: Account, after: Account) -> float:
        """Work that contacts with friction take up between two states and do not store, on all processes."""
        ways = zip(self._others, before.touches, after.touches, before.joints, after.joints, strict=True)
        return sum(joint.work_between(start, end) - now + then for joint, start, end, then, now in ways
                   if start is not None and end is not None)

    def halve(self, pieces: Sequence[int]) -> bool:
        """Find the states in the middle of pieces between accounts, if they converge; whether there are new ones."""
        numbers = [(step, i) for step, accounts in enumerate(self._steps) for i in range(len(accounts))]
        found = []
        for step, i in (numbers[piece] for piece in pieces):
            before, after = self._steps[step][0].state, self._steps[step + 1][0].state
            if before.stage != after.stage:
                continue
            segment = self._segment(step)
            places = [*(account.place for account in self._steps[step]), 1.0]
            place = (places[i] + places[i + 1]) / 2
            try:
                found.append((step, replace(self._account(segment[place * segment.after.length]), place=place)))
            except (Jump, Missed):
                continue
        for step, account in found:
            self._steps[step] = sorted([*self._steps[step], account], key=lambda a: a.place)
        return bool(found)

    def _segment(self, step: int) -> Segment:
        """The step from a state of the path, of the length that the tracer's control gives it."""
        if (segment := self._within[step]) is None:
            tracer, (before, after) = self._tracer, (self._steps[i][0].state for i in (step, step + 1))
            tracer.back_to(before)
            measure, increment = tracer.control.measure, tracer.system.create_vector(after.increment)
            length = abs(measure(tracer.tangent, increment, after.load_increment)) or after.length
            segment = self._within[step] = Segment(tracer, before, replace(after, length=length))
        return segment

    def _account(self, state: State) -> Account:
        system, held = self._tracer.system, self._tracer.system.multiplier_rows
        load, structure = system.create_vector(), self._structure
        system.restore(state.fields)
        place = system.step_by([np.zeros((len(f.table), f.width)) if f.curved else f.table
                                for f in system.unknowns.fields]).array
        done, dead = [], True
        for stage in range(state.stage + 1):
            system.load(load, stage)
            kept = self._loads.setdefault(stage, load.array.copy())
            dead = dead and _equal(system, load.array, kept) and not system.comm.allreduce(
                load.array[self._turning].any())
            done.append(_product(system, load.array, place, held))
        product, rate = (_product(system, load.array, by) for by in (place, state.response))
        parts = zip(structure.scene.parts, structure.works_of_parts, strict=True)
        stored = [structure.strain_energy(part) if work.tells_energy else np.nan for part, work in parts]
        joints = [c.energy() or 0.0 for c in self._others]
        touches = [c.touch() if c.rubs else None for c in self._others]
        return Account(state, stored, joints, touches, structure.dissipated(), done, product, rate, dead,
                       dead or _proportional(system, state))

    def _followed(self) -> list[Account]:
        """Accounts in which W and q are integrals of the loads along the way, which change with the structure."""
        tracer, system = self._tracer, self._tracer.system
        done = np.zeros(self._steps[-1][0].state.stage + 1)
        accounts, product = [replace(self._steps[0][0], done=done.tolist(), product=0.0)], 0.0
        for step, (inner, (after, *_)) in enumerate(pairwise(self._steps)):
            begins = after.state.stage != inner[0].state.stage  # a stage, where q of its loads does, as their W
            product = 0.0 if begins else product
            for left, right in pairwise([*inner, after]):
                powers = []
                if not begins:
                    ends = left.place, right.place or 1.0
                    for place, weight in zip(*GAUSS_ALONG, strict=True):
                        at = ends[0] + place * (ends[1] - ends[0])
                        power, by_stage = self._powers(step, at, after.state.stage)
                        done[:len(by_stage)] += weight * (ends[1] - ends[0]) * by_stage
                        powers.append((ends[1] - ends[0]) * power)
                change = float(np.dot(GAUSS_ALONG[1], powers)) if powers else 0.0
                product += change
                accounts.append(replace(right, done=done.tolist(), product=product,
                                        unsure=UNSURE * abs(change - powers[1]) if powers else 0.0))
        system.restore(tracer.state.fields)
        return accounts

    def _powers(self, step: int, place: float, stage: int) -> tuple[float, np.ndarray]:
        """Rates of q and of each stage's W by the part of a step, at a place of it."""
        system, held, segment = self._tracer.system, self._tracer.system.multiplier_rows, self._segment(step)
        load, length = system.create_vector(), place * segment.after.length
        factor, increment = segment.dense.at(length, segment.states)
        _, rate = segment.dense.rate_at(length, segment.states)
        powers = np.empty(stage + 1)
        with system.additive_increments(frozen=False):
            system.configure(system.create_vector(increment), segment.before.factor + factor)
            for n in range(stage + 1):
                system.load(load, n)
                powers[n] = _product(system, load.array, rate, held)
        return _product(system, load.array, rate), powers


def _proportional(system, state: State) -> bool:
    """Whether the loads of a state's stage are proportional to their factor."""
    load, other = system.create_vector(), system.create_vector()
    system.load(load)
    system.factors.set(state.factor / 2 + 1)
    system.load(other)
    system.factors.set(state.factor)
    return _equal(system, load.array, other.array)


def _equal(system, one: np.ndarray, other: np.ndarray) -> bool:
    change, size = (system.comm.allreduce(float(v @ v)) for v in (one - other, other))
    return change <= SAME**2 * size


def _product(system, load: np.ndarray, place: np.ndarray, without: np.ndarray | None = None) -> float:
    if without is not None:
        place = place.copy()
        place[without] = 0.0
    return system.comm.allreduce(float(load @ place))
