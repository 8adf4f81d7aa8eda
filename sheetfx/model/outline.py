"""Sections by their outline: constants from polygons, with holes where they are hollow."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..checks import check
from .cross_section import Section
from .saint_venant import SaintVenant, saint_venant

ROUNDING = 1e-9  # of the size of a section
Ring = tuple[tuple[float, float], ...]


class Outlined(Section):
    """A section whose `rings` are known: its outer polygon, and its holes'.

    Area, second moments and product are exact (Steger 1996). Torsion constant, shear areas, shear centre and warping
    constant come from Saint-Venant's problem by finite elements (`model.saint_venant`), to half a percent.
    """

    @property
    def rings(self) -> Sequence[np.ndarray]:
        """Corners of the outer polygon and of holes, each of shape (n, 2), along the depth and across it."""
        raise NotImplementedError

    @cached_property
    def _about_centroid(self) -> tuple[list[np.ndarray], np.ndarray, np.ndarray]:
        """Rings about the centroid, the outer one counterclockwise and holes clockwise, moments of degree 0 to 2 about
        it (1, yy, zz, yz), and the centroid.
        """
        rings = [np.asarray(ring, float) for ring in self.rings]
        rings = [ring if (_moments(ring)[0] > 0) == (not i) else ring[::-1] for i, ring in enumerate(rings)]
        area, y, z = sum(_moments(ring) for ring in rings)[:3]
        centroid = np.array([y, z]) / area
        rings = [ring - centroid for ring in rings]
        return rings, sum(_moments(ring) for ring in rings)[[0, 3, 4, 5]], centroid

    @property
    def centroid(self) -> tuple[float, float]:
        """Its place in the coordinates of the rings."""
        y, z = self._about_centroid[2]
        return float(y), float(z)

    @property
    def faces(self):
        along = self._about_centroid[0][0][:, 0]
        return float(along.min()), float(along.max())

    @property
    def area(self):
        return float(self._about_centroid[1][0])

    @property
    def second_moments(self):
        _, along, across, _ = self._about_centroid[1]
        return float(across), float(along)

    @property
    def product(self):
        found = float(self._about_centroid[1][3])
        return found if abs(found) > ROUNDING * sum(self.second_moments) else 0.0

    @cached_property
    def _saint_venant(self) -> SaintVenant:
        """Of the same section with an area of 1."""
        size = self._size
        rings = tuple(tuple(map(tuple, (ring / size).tolist())) for ring in self._about_centroid[0])
        edge = sum(np.linalg.norm(np.roll(ring, -1, axis=0) - ring, axis=1).sum() for ring in map(np.array, rings))
        try:
            return saint_venant(rings, 2 / edge)  # the thickness of thin walls
        except Exception as error:
            raise ValueError(f"{type(self).__name__}: gmsh cannot mesh the outline of {self} ({error}); look at its "
                             "corners") from error

    @property
    def _size(self) -> float:
        return float(np.sqrt(self.area))

    @cached_property
    def _mirrored(self) -> tuple[bool, bool]:
        """Whether it is the same with distances across the depth, and along it, of the other sign."""
        return self._is_same((1, -1)), self._is_same((-1, 1))

    def _is_same(self, signs: tuple[int, int]) -> bool:
        corners = np.vstack(self._about_centroid[0])
        near = ROUNDING * np.ptp(corners)
        return all((np.abs(corners - corner * signs).max(axis=1) < near).any() for corner in corners)

    @property
    def torsion(self):
        return self._saint_venant.torsion * self._size**4

    @property
    def shear(self):
        found = self._saint_venant.shear * self._size**2
        return np.diag(np.diag(found)) if any(self._mirrored) else found

    @property
    def shear_factor(self):
        """Mean of those along both axes."""
        return float(np.trace(self.shear)) / 2 / self.area

    @property
    def shear_centre(self):
        across, along = self._mirrored
        if self._is_same((-1, -1)):
            return 0.0, 0.0
        y, z = map(float, self._saint_venant.shear_centre * self._size)
        return 0.0 if along else y, 0.0 if across else z

    @property
    def warping(self):
        return self._saint_venant.warping * self._size**6

    def fibres(self):
        return self._saint_venant.places * self._size, self._saint_venant.areas * self._size**2


@dataclass(frozen=True)
class PolygonSection(Outlined):
    """Section by its outline, a polygon, from which all constants are computed.

    Attributes
    ----------
    corners : pairs of distances along the direction of the depth and across it, from any origin, in turn around the
        outline; the beam's axis goes through the centroid, whose place `centroid` tells
    holes : corners of each hole, in the same coordinates
    """

    corners: Ring
    holes: Sequence[Ring] = ()

    def __post_init__(self):
        check(self)
        for name, ring in (("corners", self.corners), *((f"hole {i}", hole) for i, hole in enumerate(self.holes))):
            _require_simple(name, np.asarray(ring, float))
        for i, hole in enumerate(self.holes):
            if not all(_inside(np.asarray(self.corners, float), corner) for corner in np.asarray(hole, float)):
                raise ValueError(f"PolygonSection: hole {i} is not inside the corners {self.corners}; move it there")

    @property
    def rings(self):
        return [self.corners, *self.holes]

    @property
    def depth(self):
        return self.faces[1] - self.faces[0]


def _moments(ring: np.ndarray) -> np.ndarray:
    """Integrals of 1, y, z, yy, zz and yz over a polygon, negative where it runs clockwise (Steger 1996)."""
    (y, z), (a, b) = ring.T, np.roll(ring, -1, axis=0).T
    twice = y * b - a * z
    return np.array([twice.sum() / 2, twice @ (y + a) / 6, twice @ (z + b) / 6, twice @ (y * y + y * a + a * a) / 12,
                     twice @ (z * z + z * b + b * b) / 12, twice @ (2 * y * z + y * b + a * z + 2 * a * b) / 24])


def _require_simple(name: str, ring: np.ndarray) -> None:
    """Refuse a polygon without area, with a corner that stands twice, or whose edges cross."""
    if ring.ndim != 2 or ring.shape[1] != 2 or len(ring) < 3:
        raise ValueError(f"PolygonSection: {name} has shape {ring.shape}; give three or more pairs of distances")
    extent = np.ptp(ring, axis=0).max()
    edges = np.roll(ring, -1, axis=0) - ring
    if (short := np.linalg.norm(edges, axis=1) <= ROUNDING * extent).any():
        raise ValueError(f"PolygonSection: {name} has the corner {ring[np.argmax(short)].tolist()} twice in turn; "
                         "leave one out")
    if abs(_moments(ring - ring.mean(axis=0))[0]) <= ROUNDING * extent**2:
        raise ValueError(f"PolygonSection: {name} {ring.tolist()} enclose no area; give the corners in turn around it")
    for i in range(len(ring)):
        beyond = np.arange(i + 2, len(ring) - (i == 0))
        if (crossed := _cross(ring[i], edges[i], ring[beyond], edges[beyond])).any():
            raise ValueError(f"PolygonSection: {name} has edges that cross, from {ring[i].tolist()} and from "
                             f"{ring[beyond[np.argmax(crossed)]].tolist()}; give the corners in turn around it")


def _cross(start: np.ndarray, edge: np.ndarray, others: np.ndarray, their: np.ndarray) -> np.ndarray:
    """Whether an edge has a point in common with each of others."""
    apart = others - start
    determinant = edge[0] * their[:, 1] - edge[1] * their[:, 0]
    with np.errstate(divide="ignore", invalid="ignore"):
        along = (apart[:, 0] * their[:, 1] - apart[:, 1] * their[:, 0]) / determinant
        other = (apart[:, 0] * edge[1] - apart[:, 1] * edge[0]) / determinant
    return (along >= 0) & (along <= 1) & (other >= 0) & (other <= 1)


def _inside(ring: np.ndarray, place: np.ndarray) -> bool:
    """Whether a place is inside a polygon: a ray from there along y leaves it once more than it enters it."""
    (y, z), (a, b) = (ring - place).T, (np.roll(ring, -1, axis=0) - place).T
    passes = (z > 0) != (b > 0)
    return bool((y - z * (a - y) / np.where(passes, b - z, 1) > 0)[passes].sum() % 2)
