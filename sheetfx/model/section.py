"""Sections of beams (any consistent units; the scenes use N and mm)."""

from __future__ import annotations

from dataclasses import dataclass
from math import pi, tanh

import numpy as np

from ..checks import NotNegative, Positive, check, checked
from . import layers
from .cross_section import Elastic, Section
from .varying import Measure, varying

__all__ = ["Elastic", "FibreList", "Flanged", "Rectangle", "Section", "Tube", "effective_width", "round_bar"]

ROUNDING = 1e-14  # product of inertia beside the polar second moment that is none
ALIKE = 1e-9  # third moments of fibres within a circle of radius 1, per area, that are none


@dataclass(frozen=True)
class Rectangle(Section):
    """Solid rectangle, `width` across the plane of bending and `depth` in it.

    Attributes
    ----------
    points : fibres along each side, by Gauss's rule, of a plastic material
    """

    width: Measure
    depth: Measure
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

    diameter: Measure
    thickness: Measure
    shear_factor: Positive = 0.5
    points: int = 5

    def __post_init__(self):
        check(self)
        layers.require_points(self)
        if not varying(self) and 2 * self.thickness > self.diameter:
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
    shear_centre : its distances from the centroid along the direction of the depth and across it; None: the centroid,
        which it is where fibres lie alike on both sides of that; else a beam in space warns
    """

    places: tuple[tuple[float, float], ...]
    areas: tuple[Positive, ...]
    torsion: Positive
    shear_factor: Positive = 5 / 6
    shear_centre: tuple[float, float] | None = None

    def __post_init__(self):
        check(self)
        places, areas = np.asarray(self.places, float), np.asarray(self.areas, float)
        if places.shape != (len(areas), 2) or not (areas > 0).all():
            raise ValueError(f"FibreList: places has shape {places.shape}, with areas {areas.tolist()}; give a pair of "
                             "distances and a positive area for each fibre")
        off = areas @ places / areas.sum()
        if np.abs(off).max() > 1e-9 * np.ptp(places):
            raise ValueError(f"FibreList: the centroid of its fibres is {off.tolist()}; measure places from there")
        if self.shear_centre is None and _alike_on_both_sides(places, areas):
            object.__setattr__(self, "shear_centre", (0.0, 0.0))

    def fibres(self):
        return np.asarray(self.places, float), np.asarray(self.areas, float)

    @property
    def depth(self):
        return self.faces[1] - self.faces[0]

    @property
    def faces(self):
        along = np.asarray(self.places, float)[:, 0]
        return float(along.min()), float(along.max())

    @property
    def area(self):
        return sum(self.areas)

    @property
    def second_moments(self):
        places, areas = self.fibres()
        y, z = places.T
        return float(areas @ z**2), float(areas @ y**2)

    @property
    def product(self):
        places, areas = self.fibres()
        found = float(areas @ places.prod(axis=1))
        return found if abs(found) > ROUNDING * sum(self.second_moments) else 0.0


def _alike_on_both_sides(places: np.ndarray, areas: np.ndarray) -> bool:
    """Whether fibres are the same turned by 180 degrees about the centroid, by their third moments."""
    y, z = (places / np.abs(places).max()).T
    return all(abs(areas @ (y**n * z ** (3 - n))) <= ALIKE * areas.sum() for n in range(4))


@dataclass(frozen=True)
class Flanged(Section):
    """A bar and a flat flange that act as one section, such as the part of a panel that works with its bar.

    The bar may be a Flanged again, as for an I section. Its axis goes through its centroid.

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
        if names := varying(self.bar):
            raise ValueError(f"Flanged: {names[0]} of its bar, a {type(self.bar).__name__}, is a function of the "
                             "place; give a number")

    @property
    def depth(self):
        return self.faces[1] - self.faces[0]

    @property
    def faces(self):
        low, high = self.bar.faces
        return (min(low, self.offset - self.thickness / 2) - self.centroid,
                max(high, self.offset + self.thickness / 2) - self.centroid)

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
    def product(self):
        return self.bar.product

    @property
    def shear_centre(self):
        """Mean of both parts' own by their second moments about the depth, which is their share of a force across it
        (Timoshenko and Gere 1961, section 5.1); not known where the bar's is beside the depth.
        """
        own = self.bar.shear_centre
        if own is None or own[1] or self.bar.product:
            return None
        bar, flange = self.bar.second_moments[0], self._flange * self.width**2 / 12
        return (bar * own[0] + flange * self.offset) / (bar + flange) - self.centroid, 0.0

    @property
    def warping(self):
        """Of parts whose sections turn about one shear centre, each by its own second moment about the depth."""
        if self.shear_centre is None:
            return 0.0
        own, place = self.bar.shear_centre, self.shear_centre[0] + self.centroid
        return (self.bar.warping + self.bar.second_moments[0] * (own[0] - place)**2
                + self._flange * self.width**2 / 12 * (self.offset - place)**2)

    @property
    def torsion(self):
        return self.bar.torsion + self.width * self.thickness**3 / 3

    @property
    def shear_factor(self):
        """Mean of the bar's and a rectangle's, by area."""
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
