"""Section data of shells (any consistent units; the scenes use N and mm)."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from typing import Annotated

import numpy as np
from scipy.linalg import block_diag

from ..checks import Choice, Like, NotNegative, Positive, check
from . import layers
from .section import Elastic
from .varying import Measure

EQUAL = 1e-9  # relative difference of stiffnesses of an isotropic section


def _square(value, size: int) -> bool:
    try:
        matrix = np.array(value, dtype=float)
    except (TypeError, ValueError):
        return False
    return matrix.shape == (size, size) and bool(np.isfinite(matrix).all())


SQUARE = {n: Like(f"{n} rows of {n} finite numbers", partial(_square, size=n)) for n in (2, 3)}


@dataclass(frozen=True)
class ShellStiffness:
    """Stiffness of a shell section per length, on the axes of the frame, for strains (e11, e22, 2 e12) and so on.

    Attributes
    ----------
    membrane, coupling, bending : 3 x 3 (force / length, force, force length)
    shear : 2 x 2 (force / length)
    drilling : resistance against rotation about the normal (force / length)
    """

    membrane: Annotated[tuple, SQUARE[3]]
    coupling: Annotated[tuple, SQUARE[3]]
    bending: Annotated[tuple, SQUARE[3]]
    shear: Annotated[tuple, SQUARE[2]]
    drilling: NotNegative

    @property
    def moduli(self) -> np.ndarray:
        """Matrix (6, 6) of membrane and bending, with their coupling."""
        membrane, coupling, bending = (np.array(block) for block in (self.membrane, self.coupling, self.bending))
        return np.block([[membrane, coupling], [coupling, bending]])

    @property
    def uncoupled(self) -> np.ndarray:
        """Matrix (9, 9) of membrane, bending, shear and drilling in the order of `forms.section.linear_shell`."""
        return block_diag(self.membrane, self.bending, self.shear, self.drilling)

    @property
    def isotropic(self) -> bool:
        """Whether it is the same on axes that are turned about the normal."""
        blocks = [(m := np.array(block), [m[0, 0] - m[1, 1], m[0, 0] - m[0, 1] - 2 * m[2, 2], m[0, 2], m[1, 2]])
                  for block in (self.membrane, self.coupling, self.bending)]
        blocks += [(m := np.array(self.shear), [m[0, 0] - m[1, 1], m[0, 1]])]
        return all(np.abs(differences).max() <= EQUAL * np.abs(m).max() for m, differences in blocks)


class ShellSection:
    """What all shell sections have in common."""

    thickness: float

    weight = "give its material one: Elastic(modulus, poisson, density=...)"

    def stiffness(self, material) -> ShellStiffness:
        """Stiffness per length."""
        raise NotImplementedError

    def weighs(self, material: Elastic | None) -> bool:
        """Whether a density is known; `weight` says what to do where none is."""
        return material is not None and material.density is not None

    def mass_centre(self, material: Elastic) -> float:
        """Height of the centre of mass above the mid-surface."""
        return 0.0

    def inertia(self, material: Elastic) -> list[float]:
        """Mass per area, and rotary inertia of the director per area, about the centre of mass."""
        density = material.density or 0.0
        return [density * self.thickness, density * self.thickness**3 / 12]


@dataclass(frozen=True)
class Plate(ShellSection):
    """Homogeneous shell section.

    Attributes
    ----------
    thickness : length, or a function of the place that gives it
    shear_factor : on the transverse shear stiffness
    drilling : factor on the membrane's shear stiffness; between 0.1 and 1 results hardly depend on it
    points : layers through the thickness of a plastic material
    rule : by which they are placed: "gauss", "lobatto" or "simpson" (the last two have layers on the faces)
    """

    thickness: Measure
    shear_factor: Positive = 5 / 6
    drilling: Positive = 1.0
    points: int = 5
    rule: Annotated[str, Choice(layers.RULES)] = "gauss"

    def __post_init__(self):
        check(self)
        layers.require_points(self)

    def layers(self) -> tuple[np.ndarray, np.ndarray]:
        """Places from the mid-surface and weights of the layers of a plastic material."""
        return layers.along(self.thickness, self.points, self.rule)

    def stiffness(self, material) -> ShellStiffness:
        """Plane-stress stiffness of an isotropic material."""
        nu, t = material.poisson, self.thickness
        plane = material.modulus / (1 - nu**2)
        unit = ((1.0, nu, 0.0), (nu, 1.0, 0.0), (0.0, 0.0, (1 - nu) / 2))
        shear = self.shear_factor * material.shear_modulus * t
        return ShellStiffness(
            membrane=_scaled(unit, plane * t), coupling=_scaled(unit, 0.0), bending=_scaled(unit, plane * t**3 / 12),
            shear=((shear, 0.0), (0.0, shear)), drilling=self.drilling * material.shear_modulus * t)


@dataclass(frozen=True)
class GivenPlate(ShellSection):
    """Shell section whose stiffness is given, for orthotropic or layered shells.

    Attributes
    ----------
    thickness : length, for the choice of quadrature
    matrices : ShellStiffness
    """

    thickness: Positive
    matrices: ShellStiffness

    def __post_init__(self):
        check(self)
        _require_energy(self.matrices)

    def stiffness(self, material=None) -> ShellStiffness:
        return self.matrices


def _scaled(matrix, factor):
    return tuple(tuple(factor * c for c in row) for row in matrix)


def _require_energy(given: ShellStiffness) -> None:
    """Refuse a stiffness of numbers that is not the second derivative of an energy, or of a negative one."""
    check(given)
    for name in ("membrane", "coupling", "bending", "shear"):
        matrix = np.array(getattr(given, name), dtype=float)
        if np.abs(matrix - matrix.T).max() > EQUAL * np.abs(matrix).max():
            raise ValueError(f"ShellStiffness: {name} is {matrix.tolist()}; it must be symmetric, as the second "
                             "derivative of an energy is")
    # Lengths are divided by one that makes both diagonals alike, so that rounding is small against either.
    membrane, coupling, bending = (np.array(m) for m in (given.membrane, given.coupling, given.bending))
    length = np.sqrt(np.trace(bending) / np.trace(membrane)) if np.trace(membrane) > 0 < np.trace(bending) else 1.0
    whole = np.block([[membrane, coupling / length], [coupling / length, bending / length**2]])
    for what, matrix in (("membrane, coupling and bending", whole), ("shear", np.array(given.shear))):
        lowest = np.linalg.eigvalsh(matrix)[0]
        if lowest < -EQUAL * np.abs(matrix).max():
            raise ValueError(f"ShellStiffness: {what} are not positive: some strains have a negative energy (least "
                             f"eigenvalue {lowest:.4g}); check the signs, and that couplings are small enough")
