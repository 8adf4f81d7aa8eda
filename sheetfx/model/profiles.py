"""Sections of rolled and welded profiles by their dimensions; constants come from their outlines."""

from __future__ import annotations

from dataclasses import dataclass
from math import pi

import numpy as np

from ..checks import NotNegative, Positive, check
from .outline import Outlined
from .varying import Measure, varying

ARC = 12  # edges of a quarter of a circle, with which a fillet lacks 1 % of its area


class Profile(Outlined):
    """A profile; measures that do not fit together are refused."""

    def __post_init__(self):
        check(self)
        for fits, what in () if varying(self) else self._conditions():
            if not fits:
                raise ValueError(f"{type(self).__name__}: {what}")

    def _conditions(self):
        """Pairs: whether measures fit, and what to say where they do not."""
        raise NotImplementedError


@dataclass(frozen=True)
class ISection(Profile):
    """I section, flanges across the depth.

    Attributes
    ----------
    depth : between the outer faces of the flanges
    width, flange : width and thickness of the flanges; of the upper one alone where the lower one's are given
    web : thickness of the web
    root : radius of the fillets between web and flanges
    lower_width, lower_flange : width and thickness of the lower flange; None: as above
    """

    depth: Measure
    width: Measure
    web: Measure
    flange: Measure
    root: NotNegative = 0.0
    lower_width: Positive | None = None
    lower_flange: Positive | None = None

    def _conditions(self):
        lower_width, lower_flange = self._lower
        narrow = min(self.width, lower_width)
        yield (self.flange + lower_flange + 2 * self.root < self.depth,
               f"depth {self.depth} leaves no web between flanges and fillets; make it larger")
        yield self.web + 2 * self.root < narrow, f"width {narrow} leaves no flange beside the web; make it larger"

    @property
    def _lower(self):
        return self.lower_width or self.width, self.lower_flange or self.flange

    @property
    def rings(self):
        (width, flange), top, half = self._lower, self.depth, self.web / 2
        right = [(0, width / 2), (flange, width / 2), (flange, half, self.root),
                 (top - self.flange, half, self.root), (top - self.flange, self.width / 2), (top, self.width / 2)]
        left = [(y, -z, *radius) for y, z, *radius in reversed(right)]
        return [rounded(right + left)]


@dataclass(frozen=True)
class TSection(Profile):
    """T section, its flange at the upper end of the depth.

    Attributes
    ----------
    depth : with the flange
    width, flange : width and thickness of the flange
    web : thickness of the web
    root : radius of the fillets between web and flange
    """

    depth: Measure
    width: Measure
    web: Measure
    flange: Measure
    root: NotNegative = 0.0

    def _conditions(self):
        yield self.flange + self.root < self.depth, f"depth {self.depth} leaves no web below the flange; make it larger"
        yield (self.web + 2 * self.root < self.width,
               f"width {self.width} leaves no flange beside the web; make it larger")

    @property
    def rings(self):
        top, half = self.depth, self.web / 2
        right = [(0, half), (top - self.flange, half, self.root), (top - self.flange, self.width / 2),
                 (top, self.width / 2)]
        return [rounded(right + [(y, -z, *radius) for y, z, *radius in reversed(right)])]


@dataclass(frozen=True)
class CSection(Profile):
    """Channel, its web along the depth, and flanges on the side of the binormal (tangent x depth).

    Attributes
    ----------
    depth : between the outer faces of the flanges
    width, flange : width, with the web, and thickness of the flanges
    web : thickness of the web
    root : radius of the fillets between web and flanges
    """

    depth: Measure
    width: Measure
    web: Measure
    flange: Measure
    root: NotNegative = 0.0

    def _conditions(self):
        yield (2 * (self.flange + self.root) < self.depth,
               f"depth {self.depth} leaves no web between flanges and fillets; make it larger")
        yield self.web + self.root < self.width, f"width {self.width} leaves no flange beside the web; make it larger"

    @property
    def rings(self):
        low, high = self.flange, self.depth - self.flange
        return [rounded([(0, 0), (0, self.width), (low, self.width), (low, self.web, self.root),
                         (high, self.web, self.root), (high, self.width), (self.depth, self.width), (self.depth, 0)])]


@dataclass(frozen=True)
class LSection(Profile):
    """Angle: one leg along the depth and, from its lower end, one along the binormal (tangent x depth).

    Attributes
    ----------
    depth, width : lengths of the legs, from the heel
    thickness : of both legs
    root, toe : radii of the fillet between the legs, and of the inner edges of their ends
    """

    depth: Measure
    width: Measure
    thickness: Measure
    root: NotNegative = 0.0
    toe: NotNegative = 0.0

    def _conditions(self):
        for name in ("depth", "width"):
            yield (self.thickness + self.root + self.toe < getattr(self, name),
                   f"{name} {getattr(self, name)} leaves no leg beside thickness and radii; make it larger")
        yield self.toe <= self.thickness, f"toe {self.toe} is more than the thickness {self.thickness}; make it smaller"

    @property
    def rings(self):
        t = self.thickness
        toes = [(t, self.width, self.toe), (self.depth, t, self.toe)]
        return [rounded([(0, 0), (0, self.width), toes[0], (t, t, self.root), toes[1], (self.depth, 0)])]


@dataclass(frozen=True)
class ZSection(Profile):
    """Z section: the upper flange on the side of the binormal (tangent x depth) of the web, the lower one opposite.

    Attributes
    ----------
    depth : between the outer faces of the flanges
    width, flange : width of each flange, with the web, and its thickness
    web : thickness of the web
    root : radius of the fillets between web and flanges
    """

    depth: Measure
    width: Measure
    web: Measure
    flange: Measure
    root: NotNegative = 0.0

    _conditions = CSection._conditions

    @property
    def rings(self):
        half, middle, end = self.depth / 2, self.web / 2, self.width - self.web / 2
        upper = [(half, end), (half, -middle), (self.flange - half, -middle, self.root), (self.flange - half, -end)]
        return [rounded(upper + [(-y, -z, *radius) for y, z, *radius in upper])]


@dataclass(frozen=True)
class Box(Profile):
    """Hollow rectangle.

    Attributes
    ----------
    depth, width : between outer faces
    thickness : of the walls
    radius, inner : of the outer and of the inner edges; None: less than the outer one by the thickness, or 0
    """

    depth: Measure
    width: Measure
    thickness: Measure
    radius: NotNegative = 0.0
    inner: NotNegative | None = None

    def _conditions(self):
        small = min(self.depth, self.width)
        yield (2 * self.thickness < small,
               f"thickness {self.thickness} leaves no hole; make it smaller, or take a Rectangle")
        yield 2 * self.radius < small, f"radius {self.radius} is half a side or more; make it smaller, or take a Tube"
        yield (2 * (self._inner + self.thickness) < small,
               f"inner {self._inner} is half a side of the hole or more; make it smaller")

    @property
    def _inner(self):
        return max(self.radius - self.thickness, 0.0) if self.inner is None else self.inner

    @property
    def rings(self):
        def ring(depth, width, radius):
            return rounded([(-depth, -width, radius), (-depth, width, radius), (depth, width, radius),
                            (depth, -width, radius)])

        t = self.thickness
        return [ring(self.depth / 2, self.width / 2, self.radius),
                ring(self.depth / 2 - t, self.width / 2 - t, self._inner)]


def rounded(corners) -> np.ndarray:
    """Corners of a polygon; right angles that have a third value are rounded by that radius."""
    places, found = np.array([corner[:2] for corner in corners], float), []
    for i, (place, (_, _, *radius)) in enumerate(zip(places, corners, strict=True)):
        if not radius or not radius[0]:
            found.append(place)
            continue
        before, after = ((other - place) / np.linalg.norm(other - place) for other in (places[i - 1],
                                                                                    places[(i + 1) % len(places)]))
        angles = np.linspace(0, pi / 2, ARC + 1)[:, None]
        found.extend(place + radius[0] * (before + after - np.cos(angles) * after - np.sin(angles) * before))
    return np.vstack(found)
