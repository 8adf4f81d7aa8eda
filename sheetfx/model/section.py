"""Material, and section data of beams (any consistent units; the scenes use N and mm)."""

from __future__ import annotations

from dataclasses import dataclass
from math import pi, tanh
from typing import Annotated

import numpy as np

from ..checks import NotNegative, Positive, Range, check, checked
from . import layers


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
    """Section constants; the normal of the frame is the direction of the depth."""

    depth: float
    area: float
    second_moments: tuple[float, float]
    torsion: float
    shear_factor: float

    def stiffness(self, material: Elastic, dimension: int, shear_rigidity: float = 1.0) -> list[float]:
        """Stiffnesses in the order of the strains of `forms.beam.simo_reissner`.

        Parameters
        ----------
        dimension : 2: EA, k GA, EI; 3: EA, k GA, k GA, GJ, EI about the normal, EI about the binormal
        shear_rigidity : factor on the shear stiffness; with 1e3 a slender beam is shear-rigid
        """
        axial = material.modulus * self.area
        shear = self.shear_factor * material.shear_modulus * self.area * shear_rigidity
        about_normal, about_binormal = (material.modulus * i for i in self.second_moments)
        if dimension == 2:
            return [axial, shear, about_binormal]
        return [axial, shear, shear, material.shear_modulus * self.torsion, about_normal, about_binormal]

    def fibres(self) -> tuple[np.ndarray, np.ndarray]:
        """Places of fibres from the centroid, along normal and binormal, shape (n, 2), and their areas.

        Raises
        ------
        ValueError
            For a section that has none.
        """
        raise ValueError(f"{type(self).__name__}: has no fibres, which a plastic material needs; give a Rectangle, a "
                         "Tube or FibreList")

    def inertia(self, material: Elastic, dimension: int) -> list[float]:
        """Mass per length, and rotary inertia per length about the binormal (2) or all axes of the section (3)."""
        density = material.density or 0.0
        about_normal, about_binormal = (density * i for i in self.second_moments)
        rotary = [about_binormal] if dimension == 2 else [about_normal + about_binormal, about_normal, about_binormal]
        return [density * self.area, *rotary]


@dataclass(frozen=True)
class Rectangle(Section):
    """Solid rectangle, `width` across the plane of bending and `depth` in it.

    Attributes
    ----------
    points : fibres along each side, by Gauss's rule, of a plastic material
    """

    width: Positive
    depth: Positive
    shear_factor: Positive = 5 / 6
    points: int = 5

    def __post_init__(self):
        check(self)
        layers.require_points(self)

    def fibres(self):
        return layers.rectangle(self.width, self.depth, self.points)

    @property
    def area(self):
        return self.width * self.depth

    @property
    def second_moments(self):
        return self.depth * self.width**3 / 12, self.width * self.depth**3 / 12

    @property
    def torsion(self):
        """Saint-Venant's torsion constant (Timoshenko and Goodier 1970, eq. 170), six terms of the series."""
        long, short = max(self.width, self.depth), min(self.width, self.depth)
        series = sum(tanh(n * pi * long / (2 * short)) / n**5 for n in range(1, 12, 2))
        return long * short**3 * (1 / 3 - 64 / pi**5 * short / long * series)


@dataclass(frozen=True)
class Tube(Section):
    """Round tube by outer diameter and wall thickness.

    Attributes
    ----------
    points : fibres on a quarter of the circumference, and as dense through the wall, of a plastic material
    """

    diameter: Positive
    thickness: Positive
    shear_factor: Positive = 0.5
    points: int = 5

    def __post_init__(self):
        check(self)
        layers.require_points(self)
        if 2 * self.thickness > self.diameter:
            raise ValueError(f"Tube: thickness {self.thickness} is more than half the diameter {self.diameter}")

    @property
    def depth(self):
        return self.diameter

    def fibres(self):
        return layers.ring(self.diameter, self.thickness, self.points)

    @property
    def _inner(self):
        return self.diameter - 2 * self.thickness

    @property
    def area(self):
        return pi / 4 * (self.diameter**2 - self._inner**2)

    @property
    def second_moments(self):
        moment = pi / 64 * (self.diameter**4 - self._inner**4)
        return moment, moment

    @property
    def torsion(self):
        return 2 * self.second_moments[0]


@checked
def round_bar(diameter: Positive, points: int = 5) -> Tube:
    """Solid round section."""
    return Tube(diameter, diameter / 2, shear_factor=0.9, points=points)


@dataclass(frozen=True)
class FibreList(Section):
    """Section that is given by its fibres.

    Attributes
    ----------
    places : pairs of distances from the centroid along the direction of the depth and across it
    areas : of the fibres
    torsion : Saint-Venant's torsion constant
    shear_factor : on the shear stiffness of the area
    """

    places: tuple[tuple[float, float], ...]
    areas: tuple[Positive, ...]
    torsion: Positive
    shear_factor: Positive = 5 / 6

    def __post_init__(self):
        check(self)
        places, areas = np.asarray(self.places, float), np.asarray(self.areas, float)
        if places.shape != (len(areas), 2) or not (areas > 0).all():
            raise ValueError(f"FibreList: places has shape {places.shape}, with areas {areas.tolist()}; give a pair of "
                             "distances and a positive area for each fibre")
        off = areas @ places / areas.sum()
        if np.abs(off).max() > 1e-9 * np.ptp(places):
            raise ValueError(f"FibreList: the centroid of its fibres is {off.tolist()}; measure places from there")

    def fibres(self):
        return np.asarray(self.places, float), np.asarray(self.areas, float)

    @property
    def depth(self):
        return float(np.ptp(np.asarray(self.places)[:, 0]))

    @property
    def area(self):
        return sum(self.areas)

    @property
    def second_moments(self):
        places, areas = self.fibres()
        y, z = places.T
        return float(areas @ z**2), float(areas @ y**2)


@dataclass(frozen=True)
class Flanged(Section):
    """A bar and a flat flange that act as one section, such as the part of a panel that works with its bar.

    Attributes
    ----------
    bar : Section of the bar itself
    width, thickness : of the flange, across the direction of the depth and along it
    offset : distance of the middle of the flange from the bar's axis, along the depth; the common centroid is
        `centroid` off that axis, where `Beam(offset=(section.centroid, 0.0))` puts it
    """

    bar: Section
    width: Positive
    thickness: Positive
    offset: float = 0.0

    def __post_init__(self):
        check(self)

    @property
    def depth(self):
        low = min(-self.bar.depth / 2, self.offset - self.thickness / 2)
        return max(self.bar.depth / 2, self.offset + self.thickness / 2) - low

    def fibres(self):
        (bar, areas), flange = self.bar.fibres(), layers.rectangle(self.width, self.thickness, self._points)
        own, other = ([from_axis - self.centroid, 0.0] for from_axis in (0.0, self.offset))
        return np.vstack((bar + own, flange[0] + other)), np.concatenate((areas, flange[1]))

    @property
    def _points(self):
        return getattr(self.bar, "points", 5)

    @property
    def _flange(self):
        return self.width * self.thickness

    @property
    def area(self):
        return self.bar.area + self._flange

    @property
    def centroid(self):
        """Distance of the common centroid from the bar's axis, along the depth."""
        return self.offset * self._flange / self.area

    @property
    def second_moments(self):
        about_normal, about_binormal = self.bar.second_moments
        apart = self.offset**2 * self.bar.area * self._flange / self.area
        return (about_normal + self._flange * self.width**2 / 12,
                about_binormal + self._flange * self.thickness**2 / 12 + apart)

    @property
    def torsion(self):
        return self.bar.torsion + self.width * self.thickness**3 / 3

    @property
    def shear_factor(self):
        """Mean of the bar's and that of a rectangle, by area."""
        return (self.bar.shear_factor * self.bar.area + 5 / 6 * self._flange) / self.area


@checked
def effective_width(span: Positive, thickness: Positive, own: NotNegative, panels: NotNegative) -> float:
    """Width of panels that works with a bar as its flange: min(span / 3, own + 12 thickness, own + panels).

    The rule of codes for composite beams (thesis, eq. 5.1; GB 50017), in which the two halves of the panels count with
    at most six thicknesses each.

    Parameters
    ----------
    span : length of the bar
    thickness : of the panels
    own : width of the bar itself
    panels : sum of half the clear distances to the next bars on both sides
    """
    return min(span / 3, own + 12 * thickness, own + panels)
