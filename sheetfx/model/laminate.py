"""Layered shell sections."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from math import atan2, cos, degrees, hypot, radians, sin

import numpy as np

from ..checks import Positive, check
from ..notices import warn
from .plate import ShellSection, ShellStiffness

APART = 100  # factor between transverse shear moduli from which on plies hardly have one rotation
NONE = 1e-9  # harmonic of the bending stiffness, against its mean, that is rounding


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
    density : mass per volume, for vibrations; None: the shell's material's
    expansion : coefficients of linear expansion along and across the fibres, per degree, see `Temperature`; None: not
        known
    """

    thickness: Positive
    angle: float
    along: Positive
    across: Positive
    poisson: float
    shear: Positive
    transverse: tuple[Positive, Positive] | None = None
    density: Positive | None = None
    expansion: tuple[float, float] | None = None

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

    def expansions(self) -> np.ndarray:
        """Strains (e11, e22, 2 e12) by a degree on the axes of the shell (Jones 1975, eq. 4.80).

        Raises
        ------
        ValueError
            If the ply has no expansion.
        """
        if self.expansion is None:
            raise ValueError("Ply: expansion is None, so that what a temperature does is not known; give the "
                             "coefficients along and across the fibres, or Temperature one for all plies")
        (along, across), (c, s) = self.expansion, self._direction()
        return np.array([c * c * along + s * s * across, s * s * along + c * c * across, 2 * c * s * (along - across)])

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
    shear_factor : on the sum of the plies' transverse shear stiffness; None: `transverse_shear` has the stiffness, 5/6
        of the sum for plies of one material
    drilling : factor on the membrane's shear stiffness, see `Plate`
    """

    plies: Sequence[Ply]
    shear_factor: Positive | None = None
    drilling: Positive = 1.0
    thickness: float = field(init=False)

    weight = "give each Ply one: Ply(..., density=...)"

    def __post_init__(self):
        check(self)
        if not self.plies:
            raise ValueError("Laminate: plies is empty; give at least one Ply")
        object.__setattr__(self, "thickness", sum(ply.thickness for ply in self.plies))
        moduli = [m for ply in self.plies for m in (ply.transverse or (ply.shear,))]
        if (ratio := max(moduli) / min(moduli)) > APART:
            warn(f"Laminate: transverse shear moduli of its plies differ by a factor of {ratio:.3g}; all plies "
                 "have one rotation, so that the bending of faces apart, wrinkling and crushing of a soft core are "
                 "left out")

    def stiffness(self, material=None) -> ShellStiffness:
        """Integrals of the plies' stiffness over the thickness, about its middle."""
        membrane, coupling, bending = _integrals(self.plies)
        across = self.transverse_shear() if self.shear_factor is None else self.shear_factor * sum(
            ply.thickness * ply.transverse_shear() for ply in self.plies)
        return ShellStiffness(_rows(membrane), _rows(coupling), _rows(bending), _rows(across),
                              float(self.drilling * membrane[2, 2]))

    def transverse_shear(self) -> np.ndarray:
        """Stiffness by the energy of the shear stress that balances the bending stress of the plies, shape (2, 2).

        Shear forces are the slopes of both bending moments, each along its own axis, without membrane forces (Whitney
        1973; Rohwer 1988). It depends on these axes, by some percent where plies have other angles: they are the
        principal axes of the bending stiffness, so that the stiffness turns with the plies.
        """
        angle = _principal_angle(_bending(*_integrals(self.plies))[1])
        plies = [replace(ply, angle=ply.angle - degrees(angle)) for ply in self.plies]
        shift, flexibility = _bending(*_integrals(plies))
        flexibility = np.linalg.inv(flexibility)
        points, weights = np.polynomial.legendre.leggauss(3)  # stresses are of the second degree in each ply
        below, bottom, energy = np.zeros((3, 3)), -self.thickness / 2, np.zeros((2, 2))
        for ply in plies:
            z = bottom + ply.thickness * np.array([*(1 + points) / 2, 1.0])[:, None, None]
            stresses = below + ply.plane_stress() @ ((z - bottom) * shift + (z**2 - bottom**2) / 2 * np.eye(3))
            for rate, weight in zip(stresses[:-1] @ flexibility, weights, strict=True):
                shear = np.array([[rate[0, 0], rate[2, 1]], [rate[2, 0], rate[1, 1]]])
                energy += weight * ply.thickness / 2 * shear.T @ np.linalg.solve(ply.transverse_shear(), shear)
            below, bottom = stresses[-1], bottom + ply.thickness
        c, s = cos(angle), sin(angle)
        turned = np.array([[c, s], [-s, c]])
        return turned.T @ np.linalg.inv(energy) @ turned

    def weighs(self, material) -> bool:
        return super().weighs(material) or all(ply.density for ply in self.plies)

    def expansions(self) -> np.ndarray:
        """Membrane and bending strains by a degree, and by a degree per length along the normal, shape (2, 6)."""
        heights = _heights(self.plies)
        powers = [np.diff(heights**n) / n for n in (1, 2, 3)]
        loads = np.array([ply.plane_stress() @ ply.expansions() for ply in self.plies])
        forces = [np.concatenate([powers[n] @ loads, powers[n + 1] @ loads]) for n in (0, 1)]
        return np.linalg.solve(self.stiffness().moduli, np.array(forces).T).T

    def ply_at(self, height: float) -> Ply:
        """The ply at a height above the middle; of two that meet there the upper one."""
        tops = _heights(self.plies)[1:]
        return self.plies[min(int(np.searchsorted(tops, height, side="right")), len(tops) - 1)]

    def inertia(self, material) -> list[float]:
        mass, first, second = self._moments(material)
        return [mass, second - first**2 / mass]

    def mass_centre(self, material) -> float:
        mass, first, _ = self._moments(material)
        return first / mass

    def _moments(self, material) -> list[float]:
        """Mass per area, and its moments of first and second degree about the middle."""
        heights = _heights(self.plies)
        densities = np.array([ply.density or material.density for ply in self.plies])
        return [float(densities @ np.diff(heights**n)) / n for n in (1, 2, 3)]


def _heights(plies: Sequence[Ply]) -> np.ndarray:
    """Of the faces of plies above the middle."""
    heights = np.cumsum([0.0, *(ply.thickness for ply in plies)])
    return heights - heights[-1] / 2


def _integrals(plies: Sequence[Ply]) -> tuple[np.ndarray, ...]:
    """Membrane, coupling and bending stiffness about the middle."""
    heights = _heights(plies)
    plane = np.array([ply.plane_stress() for ply in plies])
    return tuple(np.tensordot(np.diff(heights**n) / n, plane, 1) for n in (1, 2, 3))


def _bending(membrane, coupling, bending) -> tuple[np.ndarray, np.ndarray]:
    """Membrane strains by curvatures, and bending stiffness, of a section without membrane forces."""
    shift = -np.linalg.solve(membrane, coupling)
    return shift, bending + coupling @ shift


def _principal_angle(bending: np.ndarray) -> float:
    """Angle from the axes to the directions of the largest and smallest stiffness (radians), of its second harmonic.

    Where that is none it is the angle of the fourth one, such as of plies across each other; 0 if both are none.
    """
    (d11, d12, d16), (_, d22, d26), (_, _, d66) = bending
    harmonics = (2, d11 - d22, 2 * (d16 + d26)), (4, d11 + d22 - 2 * d12 - 4 * d66, 4 * (d16 - d26))
    for number, even, odd in harmonics:
        if hypot(even, odd) > NONE * (d11 + d22):
            return atan2(odd, even) / number
    return 0.0


def _rows(matrix: np.ndarray) -> tuple[tuple[float, ...], ...]:
    """A matrix as nested tuples, rounding beside its largest entry as zeros."""
    rounded = np.where(np.abs(matrix) < 1e-14 * np.abs(matrix).max(), 0.0, matrix)
    return tuple(map(tuple, rounded.tolist()))
