"""Rigid obstacles that structures touch: gaps and slips as forms."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

from .. import forms
from ..checks import NONZERO, Positive, check


@dataclass(frozen=True, eq=False)
class RigidCylinder:
    """Rigid cylinder (a circle in the plane of x and y) that may travel along a direction.

    Attributes
    ----------
    radius, centre : of the circle
    travel : direction of its free motion; None: it is fixed
    """

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
        return [c + s for c, s in zip(self.centre, shift, strict=True)]


@dataclass(frozen=True, eq=False)
class RigidPlane:
    """Rigid half-plane behind `point`; `normal` points to the free side."""

    point: tuple[float, float]
    normal: Annotated[tuple[float, float], NONZERO]
    travel: Annotated[tuple[float, float], NONZERO] | None = None

    def __post_init__(self):
        check(self)
        length = sum(c * c for c in self.normal) ** 0.5
        if abs(length - 1) > 1e-12:
            raise ValueError(f"RigidPlane: normal {self.normal} has length {length}; it must be a unit vector")

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
