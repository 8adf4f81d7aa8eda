"""Pairs of points of two parts: where they are in the beginning, how they touch, and how they do now."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from .contact import ContactState, status_of

STRETCHES = 16  # of a step, in which the work of friction is added up


@dataclass(frozen=True)
class PairState(ContactState):
    """State of the pairs of a contact on this process, one row for each.

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

    def work(self, strains, start, history) -> np.ndarray:
        """Energy of pressures and what friction has taken, per length of the line of contact.

        Parameters
        ----------
        strains : (n, 1 + slips), gaps now and slips since the last accepted state
        start : (n,), gaps of that state, asked for with friction only
        history : (n, 1 + 2 slips), its pressures that are augmented and its tractions, and slips up to it
        """
        table, n = self.table(), (history.shape[1] - 1) // 2
        work = unilateral_energy(strains[:, 0], history[:, 0], table)
        if self.rubs:
            gaps = start, strains[:, 0]
            work += friction_work(gaps, strains[:, 1:1 + n], history[:, 1:1 + n], history[:, 0], table)
        return work

    def state(self, moved, gap, pressure, traction, slip, here, slack: float) -> PairState:
        """State of the pairs, of which those have a weight that have a partner; each slips at its bound less a part.

        Parameters
        ----------
        moved : (n, d), displacements of the first part's points
        here : (n,), whether pairs have a partner
        slack : part of the bound
        """
        _, _, friction, cohesion, _ = self.parameters
        bound = (friction * pressure + cohesion) * (1 - slack)
        status = status_of(pressure, np.linalg.norm(traction, axis=1), bound)
        return PairState(self.points + moved, gap, pressure, traction, self.weights * here, status, slip)


def unilateral_energy(gap, pressure, parameters):
    """Energy whose derivative by the gap is the pressure of `forms.contact.mohr_coulomb` without friction, negative.

    Parameters
    ----------
    gap, pressure : arrays, shape (n,)
    parameters : array, shape (n, 5)

    Returns
    -------
    array, energy per length of the line of contact, zero where nothing touches.
    """
    normal, strength = parameters[:, 0], parameters[:, 4]
    trial = pressure - normal * gap
    held = np.maximum(trial, -strength)
    return (held**2 / 2 + held * (trial - held) - np.maximum(pressure, -strength)**2 / 2) / normal


def friction_work(gaps, slips, before, pressure, parameters):
    """Work of the tractions of `forms.contact.mohr_coulomb`, stored in elastic slip or dissipated.

    Gap and slip grow evenly, in stretches; in each of them tractions that have not slipped before do so at its end.
    Exact where pairs stick, slip under a pressure that changes evenly, or stick and then slip under a constant one.

    Parameters
    ----------
    gaps : pair of arrays, shape (n,), before and now
    slips : array, shape (n, d - 1), since before
    before : array, shape (n, d - 1), tractions before
    pressure : array, shape (n,), the multiplier
    parameters : array, shape (n, 5)

    Returns
    -------
    array, work per length of the line of contact.
    """
    normal, stiffness, friction, cohesion, strength = parameters.T
    work, traction, slip = np.zeros(len(slips)), before, slips / STRETCHES

    def bounds(part):
        trial = pressure - normal * ((1 - part) * gaps[0] + part * gaps[1])
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
