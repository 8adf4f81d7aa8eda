"""Material, and what all sections of beams have in common."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

import numpy as np

from ..checks import Positive, Range, check


@dataclass(frozen=True)
class Elastic:
    """Linear elastic material.

    Attributes
    ----------
    modulus : Young's modulus (force / length^2)
    poisson : Poisson's ratio; the thesis gives none for the arch, 0.3 is taken (it enters through
        the shear stiffness only: 0.02 % of the arch's limit load between 0 and 0.5)
    density : mass per volume, for vibrations; None: not given
    """

    modulus: Positive
    poisson: Annotated[float, Range(above=-1, most=0.5)] = 0.3
    density: Positive | None = None

    def __post_init__(self):
        check(self)

    @property
    def shear_modulus(self) -> float:
        return self.modulus / 2 / (1 + self.poisson)


class Section:
    """Section constants; the normal of the frame is the direction of the depth.

    Attributes
    ----------
    depth : from the lowest fibre to the highest
    area : of the section
    second_moments : of the area, about the normal and about the binormal through the centroid
    torsion : Saint-Venant's torsion constant
    shear_factor : on the shear stiffness of the area
    product : of inertia, the integral of the distances along normal and binormal over the area; zero where these are
        principal axes
    shear_centre : its distances from the centroid along normal and binormal; None: not known, the centroid is taken.
        The moment by which an axial force twists a section (Wagner's) is in no strain of `forms.beam.simo_reissner`
    warping : constant about the shear centre (length^6), which no beam has in its stiffness; 0: none, or not
        known
    """

    depth: float
    area: float
    second_moments: tuple[float, float]
    torsion: float
    shear_factor: float
    product: float = 0.0
    shear_centre: tuple[float, float] | None = (0.0, 0.0)
    warping: float = 0.0

    weight = "give its material one: Elastic(modulus, poisson, density=...)"

    @property
    def faces(self) -> tuple[float, float]:
        """Places of the lowest and the highest fibre from the centroid, along the depth."""
        return -self.depth / 2, self.depth / 2

    @property
    def shear(self) -> np.ndarray:
        """Shear areas as a symmetric matrix, shape (2, 2): shear forces along normal and binormal, per shear modulus,
        by the shear strains along both.
        """
        return self.shear_factor * self.area * np.eye(2)

    def warping_length(self, material: Elastic) -> float:
        """Root of E I_w / (G I_t), over which warping that is held somewhere fades (Vlasov 1961, chapter 2)."""
        return float(np.sqrt(material.modulus * self.warping / (material.shear_modulus * self.torsion)))

    def stiffness(self, material: Elastic, dimension: int, shear_rigidity: float = 1.0) -> list:
        """Stiffnesses in the order of the strains of `forms.beam.simo_reissner`.

        Shear strains of the shear centre, and axes that are not principal, couple the centroid's strains (Timoshenko
        and Gere 1961, section 5.1; Pilkey 2002, section 1.6).

        Parameters
        ----------
        dimension : 2: EA, k GA, EI; 3: EA, k GA, k GA, GJ, EI about the normal, EI about the binormal
        shear_rigidity : factor on the shear stiffness; with 1e3 a slender beam is shear-rigid

        Returns
        -------
        list of numbers, or of the rows of a symmetric matrix where strains are coupled in space.
        """
        axial = material.modulus * self.area
        shear = material.shear_modulus * shear_rigidity * self.shear
        about_normal, about_binormal = (material.modulus * i for i in self.second_moments)
        if dimension == 2:
            return [axial, float(shear[0, 0]), about_binormal]
        y, z = self.shear_centre or (0.0, 0.0)
        arm = np.array([-z, y])
        matrix = np.diag([axial, 0.0, 0.0, material.shear_modulus * self.torsion, about_normal, about_binormal])
        matrix[1:3, 1:3] = shear
        matrix[1:3, 3] = matrix[3, 1:3] = shear @ arm
        matrix[3, 3] += arm @ shear @ arm
        matrix[4, 5] = matrix[5, 4] = -material.modulus * self.product
        return matrix.tolist() if y or z or self.product or shear[0, 1] else np.diag(matrix).tolist()

    def fibres(self) -> tuple[np.ndarray, np.ndarray]:
        """Places of fibres from the centroid, along normal and binormal, shape (n, 2), and their areas.

        Raises
        ------
        ValueError
            For a section that has none.
        """
        raise ValueError(f"{type(self).__name__}: has no fibres, which a plastic material needs; give a Rectangle, a "
                         "Tube or FibreList")

    def weighs(self, material: Elastic) -> bool:
        """Whether a density is known; `weight` says what to do where none is."""
        return material.density is not None

    def inertia(self, material: Elastic, dimension: int) -> list[float]:
        """Mass per length, and rotary inertia per length about the binormal (2), or in space (3) about all axes of the
        section and, last, the product of inertia of normal and binormal.
        """
        density = material.density or 0.0
        about_normal, about_binormal = (density * i for i in self.second_moments)
        in_space = [about_normal + about_binormal, about_normal, about_binormal, -density * self.product]
        return [density * self.area, *([about_binormal] if dimension == 2 else in_space)]
