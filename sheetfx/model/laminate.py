"""Layered shell sections."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from math import cos, radians, sin

import numpy as np

from ..checks import Positive, check
from .plate import ShellSection, ShellStiffness


@dataclass(frozen=True)
class Ply:
    """A layer of a material with fibres.

    Attributes
    ----------
    thickness : length
    angle : of the fibres, degrees from the shell's first axis toward its second one
    along, across : moduli E1 along the fibres and E2 across them
    poisson : nu12, contraction across the fibres for stretching along them
    shear : modulus G12
    transverse : moduli G13 and G23; None: both G12
    """

    thickness: Positive
    angle: float
    along: Positive
    across: Positive
    poisson: float
    shear: Positive
    transverse: tuple[Positive, Positive] | None = None

    def __post_init__(self):
        check(self)
        if not self.poisson**2 < self.along / self.across:
            raise ValueError(f"Ply: poisson is {self.poisson}; its square must be below along / across = "
                             f"{self.along / self.across:.4g}, or the energy is not positive")

    def plane_stress(self) -> np.ndarray:
        """Stiffness (Jones 1975, eqs. 2.61 and 2.80) for (e11, e22, 2 e12) on the axes of the shell, shape (3, 3)."""
        scale = 1 / (1 - self.poisson**2 * self.across / self.along)
        along, across = self.along * scale, self.across * scale
        coupled = self.poisson * across
        own = np.array([[along, coupled, 0.0], [coupled, across, 0.0], [0.0, 0.0, self.shear]])
        c, s = self._direction()
        strains = np.array([[c * c, s * s, c * s], [s * s, c * c, -c * s], [-2 * c * s, 2 * c * s, c * c - s * s]])
        return strains.T @ own @ strains

    def transverse_shear(self) -> np.ndarray:
        """Stiffness for the transverse shear strains (g1, g2) on the axes of the shell, shape (2, 2)."""
        c, s = self._direction()
        turned = np.array([[c, s], [-s, c]])
        return turned.T @ np.diag(self.transverse or (self.shear, self.shear)) @ turned

    def _direction(self) -> tuple[float, float]:
        return cos(radians(self.angle)), sin(radians(self.angle))


@dataclass(frozen=True)
class Laminate(ShellSection):
    """Shell section of plies, by classical lamination theory with first-order shear (Reddy 2004, chapter 3).

    Attributes
    ----------
    plies : from the lowest, against the normal, to the highest
    shear_factor : on the transverse shear stiffness
    drilling : factor on the membrane's shear stiffness, see `Plate`
    """

    plies: Sequence[Ply]
    shear_factor: Positive = 5 / 6
    drilling: Positive = 1.0
    thickness: float = field(init=False)

    def __post_init__(self):
        check(self)
        if not self.plies:
            raise ValueError("Laminate: plies is empty; give at least one Ply")
        object.__setattr__(self, "thickness", sum(ply.thickness for ply in self.plies))

    def stiffness(self, material=None) -> ShellStiffness:
        """Integrals of the plies' stiffness over the thickness, about its middle."""
        heights = np.cumsum([0.0, *(ply.thickness for ply in self.plies)]) - self.thickness / 2
        plane = np.array([ply.plane_stress() for ply in self.plies])
        membrane, coupling, bending = (np.tensordot(np.diff(heights**n) / n, plane, 1) for n in (1, 2, 3))
        across = self.shear_factor * sum(ply.thickness * ply.transverse_shear() for ply in self.plies)
        return ShellStiffness(_rows(membrane), _rows(coupling), _rows(bending), _rows(across),
                              float(self.drilling * membrane[2, 2]))


def _rows(matrix: np.ndarray) -> tuple[tuple[float, ...], ...]:
    """A matrix as nested tuples, rounding beside its largest entry as zeros."""
    rounded = np.where(np.abs(matrix) < 1e-14 * np.abs(matrix).max(), 0.0, matrix)
    return tuple(map(tuple, rounded.tolist()))
