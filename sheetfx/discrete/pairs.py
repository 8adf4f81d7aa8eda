"""Pairs of points of two parts: where they are in the beginning, how they touch, and how they do now."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from .contact import ContactState


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
