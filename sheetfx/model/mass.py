"""Masses that stand at points and along edges, for vibrations."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Annotated

import ufl

from .. import forms
from ..checks import NOT_NEGATIVE, check
from ..mesh.reader import COMPONENTS, NamedMesh
from .joints import Joint


@dataclass(frozen=True, eq=False)
class Mass(Joint):
    """Mass at a named point, or per length of a named edge, without stiffness and weight.

    Attributes
    ----------
    mesh, at : the point or edge
    mass : at each vertex of the point; per length of the edge
    inertia : against turning about any axis, likewise; as of a ball, the same about all
    """

    mesh: NamedMesh
    at: str
    mass: Annotated[float, NOT_NEGATIVE]
    inertia: Annotated[float, NOT_NEGATIVE] = 0.0
    on_ground = False

    def __post_init__(self):
        check(self)
        self.mesh.require(f"Mass at {self.at!r}", self.at, "point", "edge")
        if not (self.mass or self.inertia):
            raise ValueError(f"Mass at {self.at!r}: mass and inertia are 0; give one of them")

    def at_points(self) -> Iterator[tuple[str, float]]:
        """Components and what they have to move at a point; nothing along an edge."""
        if self.at in self.mesh.points:
            for number, component in enumerate(COMPONENTS[self.mesh.dimension]):
                if size := self.mass if number < self.mesh.dimension else self.inertia:
                    yield component, size

    def work_of_inertia(self, fields, changes, spins) -> ufl.Form | None:
        """Along an edge the bilinear form of rates and variations of displacement and spin; None at a point.

        Raises
        ------
        ValueError
            If nothing turns that has an inertia.
        """
        if self.at in self.mesh.points:
            return None
        if self.inertia and spins is None:
            raise ValueError(f"Mass at {self.at!r}: bars have no rotations; leave inertia out")
        work = forms.inertia.translation(self.mass, *changes)
        if self.inertia:
            work += self.inertia * ufl.dot(*spins)
        return work * self.mesh.facet_measure(self.at)
