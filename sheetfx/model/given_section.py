"""Sections of beams whose constants are given, as a table or another program has them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..checks import NotNegative, Positive, check
from .cross_section import Section

ROUNDING = 1e-9


@dataclass(frozen=True)
class GivenSection(Section):
    """Section by its constants; the normal is the direction of the depth, the binormal tangent x depth.

    Attributes
    ----------
    area : of the section
    second_moments : about the normal (of the distances across the depth) and about the binormal, through the centroid
    torsion : Saint-Venant's torsion constant
    product : of inertia, the integral of the distances along the depth and across it; 0: principal axes
    shear_areas : along the depth and across it; None: 5/6 of the area
    shear_centre : its distances from the centroid along the depth and across it
    warping : constant about the shear centre, of which beams warn where it matters; 0: none, or not known
    depth : between the outermost fibres, for contact; None: as of a rectangle of this area and second moment
    """

    area: Positive
    second_moments: tuple[Positive, Positive]
    torsion: Positive
    product: float = 0.0
    shear_areas: tuple[Positive, Positive] | None = None
    shear_centre: tuple[float, float] = (0.0, 0.0)
    warping: NotNegative = 0.0
    depth: Positive | None = None  # type: ignore[assignment]

    def __post_init__(self):
        check(self)
        about_normal, about_binormal = self.second_moments
        if self.product**2 >= about_normal * about_binormal * (1 - ROUNDING):
            raise ValueError(f"GivenSection: product {self.product} is not below the root of the product of both "
                             f"second moments {self.second_moments}, as for every section; look at its value")
        if self.depth is None:
            object.__setattr__(self, "depth", float(np.sqrt(12 * about_binormal / self.area)))

    @property
    def shear(self):
        return np.diag(self.shear_areas) if self.shear_areas else 5 / 6 * self.area * np.eye(2)

    @property
    def shear_factor(self):
        """Mean of those along both axes."""
        return float(np.trace(self.shear)) / 2 / self.area
