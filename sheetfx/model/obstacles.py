"""Rigid obstacles that structures touch: gaps and slips as forms."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated, ClassVar, Protocol, runtime_checkable

import numpy as np

from .. import forms
from ..checks import NONZERO, Positive, check
from ..rounding import same


@runtime_checkable
class Obstacle(Protocol):
    """What an `ObstacleContact` asks of an obstacle; one of one's own need not derive from anything.

    Attributes
    ----------
    travel : direction of its free motion, of any length; None: it is fixed
    dimensions : of the spaces that it can stand in
    """

    travel: Sequence[float] | None
    dimensions: Sequence[int]

    def gap(self, x, shift):
        """Distance of a place from the obstacle as a UFL scalar, negative inside, with a slope of 1.

        Parameters
        ----------
        x : UFL vector
        shift : list of UFL scalars or numbers, how far the obstacle has moved along each direction of space
        """


def way_of(obstacle: Obstacle) -> np.ndarray | None:
    """Unit vector of the direction in which an obstacle travels; None: it is fixed."""
    return None if obstacle.travel is None else np.asarray(obstacle.travel) / np.linalg.norm(obstacle.travel)


def add_travel(fields, obstacle: Obstacle, mesh) -> None:
    """Make the travel of an obstacle an unknown, if it may move, and once for all that touch it."""
    if obstacle.travel is not None and not fields.has(obstacle, "travel"):
        fields.add_number(obstacle, mesh, "travel", mesh.size)


@dataclass(frozen=True, eq=False)
class RigidCylinder:
    """Rigid cylinder along z (a circle in the plane of x and y) that may travel along a direction.

    Attributes
    ----------
    radius, centre : of the circle
    travel : direction of its free motion; None: it is fixed
    """

    dimensions: ClassVar = 2, 3

    radius: Positive
    centre: tuple[float, float]
    travel: Annotated[tuple[float, float], NONZERO] | None = None

    def __post_init__(self):
        check(self)

    def gap(self, x, shift):
        return forms.interface.cylinder_gap(x, self._centre(shift), self.radius)

    def slip(self, x, shift, x_before, shift_before):
        return forms.interface.cylinder_slip(x, self._centre(shift), x_before, self._centre(shift_before), self.radius)

    def _centre(self, shift):
        return [c + s for c, s in zip(self.centre, shift, strict=False)]


@dataclass(frozen=True, eq=False)
class RigidPlane:
    """Rigid half of the plane, or of space, behind `point`; `normal` points to the free side.

    Attributes
    ----------
    point, normal : with as many components as the space that it stands in has dimensions; a unit normal
    travel : direction of its free motion; None: it is fixed
    """

    point: tuple[float, ...]
    normal: Annotated[tuple[float, ...], NONZERO]
    travel: Annotated[tuple[float, ...], NONZERO] | None = None

    def __post_init__(self):
        check(self)
        if not len(self.point) == len(self.normal) == len(self.travel or self.point) in (2, 3):
            raise ValueError(f"RigidPlane: point is {self.point}, normal {self.normal}, travel {self.travel}; give two "
                             "components to each in the plane, three in space")
        length = sum(c * c for c in self.normal) ** 0.5
        if not same(length, 1.0):
            raise ValueError(f"RigidPlane: normal {self.normal} has length {length}; it must be a unit vector")

    @property
    def dimensions(self) -> Sequence[int]:
        return [len(self.point)]

    def gap(self, x, shift):
        return forms.interface.plane_gap(x, self._point(shift), self._vector(self.normal))

    def slip(self, x, shift, x_before, shift_before):
        tangent = self._vector((-self.normal[1], self.normal[0]))
        return forms.interface.plane_slip(x, self._point(shift), x_before, self._point(shift_before), tangent)

    def _point(self, shift):
        return self._vector([p + s for p, s in zip(self.point, shift, strict=True)])

    @staticmethod
    def _vector(components):
        return forms.vector(components)


@dataclass(frozen=True, eq=False)
class RigidSphere:
    """Rigid sphere (a circle in the plane) that may travel along a direction; for an `ObstacleContact`.

    Attributes
    ----------
    radius, centre : with as many components as the space that it stands in has dimensions
    travel : direction of its free motion; None: it is fixed
    """

    radius: Positive
    centre: tuple[float, ...]
    travel: Annotated[tuple[float, ...], NONZERO] | None = None

    def __post_init__(self):
        check(self)
        if not len(self.centre) == len(self.travel or self.centre) in (2, 3):
            raise ValueError(f"RigidSphere: centre is {self.centre}, travel {self.travel}; give two components to each "
                             "in the plane, three in space")

    @property
    def dimensions(self) -> Sequence[int]:
        return [len(self.centre)]

    def gap(self, x, shift):
        return forms.interface.sphere_gap(x, [c + s for c, s in zip(self.centre, shift, strict=True)], self.radius)
