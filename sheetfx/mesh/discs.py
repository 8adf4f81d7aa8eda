"""Discs and rings on surfaces: where the head, the washer or the shank of a bolt holds a sheet."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..checks import NotNegative, Positive, check
from .lines import place_of
from .projection import Cells

AROUND, THROUGH = 12, 3  # samples along a circle, and circles (Gauss's rule by area): exact to degree 5 and more
SAG = 0.25  # of the radius, that a surface may bend away from the plane of the disc


@dataclass(frozen=True)
class Disc:
    """A disc on a surface, or a ring, over which a joint holds in the mean.

    Its area has a finite stiffness however fine the mesh is, which a single point of a sheet has not.

    Attributes
    ----------
    at : name of a point of the first part's mesh, or a place: the middle
    radius : outer radius
    inner : radius of the hole in the middle; 0: none
    """

    at: str | tuple[float, float, float]
    radius: Positive
    inner: NotNegative = 0.0

    def __post_init__(self):
        check(self)
        if self.inner >= self.radius:
            raise ValueError(f"Disc at {self.at!r}: inner is {self.inner:g}, not below its radius {self.radius:g}; "
                             "give that of the hole in the middle, or none")

    def samples(self, part: Cells, title: str) -> tuple[np.ndarray, np.ndarray]:
        """Places on the plane of the surface at its middle, shape (n, 3), and the shares of the area.

        Raises
        ------
        ValueError
            If the part is no surface, or the disc goes beyond it.
        """
        if part.mesh.domain.topology.dim != 2:
            raise ValueError(f"{title}: a Disc is on a surface, and the first part is one of curves; give the surface "
                             "first")
        middle = place_of(part.mesh, self.at)
        which, reference, _ = part.closest(middle[None])
        normal = part.normals(which, reference)[0]
        first = np.cross(normal, np.eye(3)[np.abs(normal).argmin()])
        first /= np.linalg.norm(first)
        nodes, weights = np.polynomial.legendre.leggauss(THROUGH)
        squares = (self.inner**2 + self.radius**2 + (self.radius**2 - self.inner**2) * nodes) / 2
        angles = 2 * np.pi * (np.arange(AROUND) + 0.5) / AROUND
        ways = np.cos(angles)[:, None] * first + np.sin(angles)[:, None] * np.cross(normal, first)
        places = (middle + np.sqrt(squares)[:, None, None] * ways).reshape(-1, 3)
        off = part.closest(places)[2]
        if off.max() > SAG * self.radius:
            worst = ", ".join(f"{c:.6g}" for c in places[off.argmax()])
            raise ValueError(f"{title}: its point ({worst}) is {off.max():.4g} off the surface; keep the disc of "
                             f"radius {self.radius:g} within it, and give the radius of a hole as `inner`")
        return places, np.repeat(weights / (2 * AROUND), AROUND)
