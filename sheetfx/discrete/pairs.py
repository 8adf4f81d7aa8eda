"""Pairs of points of two parts: where they are in the beginning, how they touch, and how they do now."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from .contact import ContactState, status_of

STRETCHES = 16  # of a step, in which the work of friction is added up


@dataclass(frozen=True)
class PairState(ContactState):
    """State of the pairs of a contact on all processes, one row for each.

    Attributes
    ----------
    traction : (n, d - 1), force per length against the slip
    slip : (n, d - 1), of the second part past the first since the beginning, along the line and across
    """

    slip: np.ndarray


@dataclass
class Pairs:
    """Pairs of points as they are in the beginning, and how they touch.

    Attributes
    ----------
    points : (n, d), places of the first part's points
    arms : (n, d), from these to the second part's points
    axes : (n, d, d), directions in the rows: out of the first part's face, along the line, across
    gap : (n,), initial
    weights : (n,), length that each stands for
    parameters : normal and tangential stiffness (pressure per length), friction coefficient, cohesion, tensile strength
    augmented : whether pressures are augmented until no pair penetrates by more than `tolerance`
    """

    points: np.ndarray
    arms: np.ndarray
    axes: np.ndarray
    gap: np.ndarray
    weights: np.ndarray
    parameters: Sequence[float]
    augmented: bool
    tolerance: float

    @property
    def count(self) -> int:
        return len(self.points)

    @property
    def dimension(self) -> int:
        return self.points.shape[1]

    @property
    def rubs(self) -> bool:
        """Whether there are tractions."""
        return self.parameters[2] > 0 or self.parameters[3] > 0

    def table(self) -> np.ndarray:
        """The parameters at each pair."""
        return np.tile(np.array(self.parameters, dtype=float), (self.count, 1))

    def work(self, start: np.ndarray, end: np.ndarray, stiffer: float, slack: float) -> np.ndarray:
        """Change of the energy of pressures, and what friction takes between states, per length of the line of contact.

        Pressures and tractions that are augmented grow evenly with the little that pairs penetrate, and slip where they
        stick; a tensile strength works on a gap that opens.

        Parameters
        ----------
        start, end : (n, 2 + 2 slips), gaps, trial pressures, tractions and slips of both states
        stiffer : factor of augmentation on the stiffness against slip
        slack : as of `state`
        """
        table, n = self.table(), (end.shape[1] - 2) // 2
        if self.augmented:
            pressures = [np.maximum(state[:, 1], 0.0) for state in (start, end)]
            left = [np.where(state[:, 1] > 0, state[:, 0], 0.0) for state in (start, end)]
            work = sum(pressures) / 2 * (left[0] - left[1])
            work += table[:, 4] * (np.maximum(end[:, 0], 0.0) - np.maximum(start[:, 0], 0.0))
        else:
            work = unilateral_energy(end[:, 0], table) - unilateral_energy(start[:, 0], table)
        if not n:
            return work
        table[:, 1] *= stiffer
        before, now, slips = start[:, 2:2 + n], end[:, 2:2 + n], end[:, 2 + n:] - start[:, 2 + n:]
        rubbed = friction_work((start[:, 1], end[:, 1]), slips, before, table)
        if self.augmented:
            sticks = np.linalg.norm(now, axis=1) < self.bound(end[:, 1], slack)
            rubbed = np.where(sticks, ((before + now) / 2 * slips).sum(axis=1), rubbed)
        return work + rubbed

    def stored(self, now: np.ndarray) -> np.ndarray:
        """Energy per length of the line of contact, of gaps, trial pressures, tractions and slips as of `work`."""
        if self.augmented:
            return np.zeros(self.count)
        table, n = self.table(), (now.shape[1] - 2) // 2
        return unilateral_energy(now[:, 0], table) + (now[:, 2:2 + n]**2).sum(axis=1) / (2 * table[:, 1])

    def bound(self, pressure: np.ndarray, slack: float) -> np.ndarray:
        """Traction at which pairs slip, less a part, by their pressure where they touch."""
        _, _, friction, cohesion, _ = self.parameters
        return (friction * pressure + cohesion) * (1 - slack)

    def state(self, moved, gap, pressure, traction, slip, here, slack: float) -> PairState:
        """State of the pairs, of which those have a weight that have a partner; each slips at its bound less a part.

        Parameters
        ----------
        moved : (n, d), displacements of the first part's points
        here : (n,), whether pairs have a partner
        slack : part of the bound
        """
        status = self.status(pressure, traction, slack)
        return PairState(self.points + moved, gap, pressure, traction, self.weights * here, status, slip)

    def status(self, pressure: np.ndarray, traction: np.ndarray, slack: float) -> np.ndarray:
        """Status of the pairs, each of which slips at its bound less a part."""
        return status_of(pressure, np.linalg.norm(traction, axis=1), self.bound(pressure, slack))


def unilateral_energy(gap, parameters):
    """Energy whose derivative by the gap is the pressure of `forms.contact.mohr_coulomb` without friction, negative.

    Parameters
    ----------
    gap : array, shape (n,)
    parameters : array, shape (n, 5)

    Returns
    -------
    array, energy per length of the line of contact, zero where nothing touches.
    """
    normal, strength = parameters[:, 0], parameters[:, 4]
    trial = -normal * gap
    held = np.maximum(trial, -strength)
    return (held**2 / 2 + held * (trial - held)) / normal


def friction_work(pressures, slips, before, parameters):
    """Work of the tractions of `forms.contact.mohr_coulomb`, stored in elastic slip or dissipated.

    Pressure and slip grow evenly, in stretches; in each of them tractions that have not slipped before do so at its
    end. Exact where pairs stick, slip under a pressure that changes evenly, or stick and then slip under a constant
    one.

    Parameters
    ----------
    pressures : pair of arrays, shape (n,), trial ones before and now, negative where pairs are open
    slips : array, shape (n, d - 1), since before
    before : array, shape (n, d - 1), tractions before
    parameters : array, shape (n, 5)

    Returns
    -------
    array, work per length of the line of contact.
    """
    _, stiffness, friction, cohesion, strength = parameters.T
    work, traction, slip = np.zeros(len(slips)), before, slips / STRETCHES

    def bounds(part):
        trial = (1 - part) * pressures[0] + part * pressures[1]
        return np.where(trial >= -strength, np.maximum(friction * trial + cohesion, 0), 0)

    slipping = np.linalg.norm(before, axis=1) >= bounds(0.0)
    for stretch in range(1, STRETCHES + 1):
        trial, bound = traction + stiffness[:, None] * slip, bounds(stretch / STRETCHES)
        size = np.linalg.norm(trial, axis=1)
        then = np.divide(bound, size, out=np.ones(len(size)), where=size > bound)[:, None] * trial
        even = np.where(slipping[:, None], slip, (then - traction) / stiffness[:, None])
        work += ((traction + then) / 2 * even + then * (slip - even)).sum(axis=1)
        traction, slipping = then, size >= bound
    return work
