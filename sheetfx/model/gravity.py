"""The weight of parts, from their densities."""

from __future__ import annotations

from dataclasses import dataclass
from typing import cast

import numpy as np
import ufl
from dolfinx import fem

from .. import forms
from ..checks import check, require_components
from ..jit import compiled_form
from ..mesh.numbers import as_constants, lift_numbers
from .beam import Bar, Beam
from .cross_section import Elastic
from .loads import Load
from .shell import Shell


@dataclass(frozen=True, eq=False)
class Gravity(Load):
    """Weight of a part, for a load factor of 1; it acts on the meshed line or surface, whatever the offset.

    Attributes
    ----------
    part : Bar, Beam or Shell whose material, or plies, have a density
    acceleration : vector, length / time^2
    """

    part: Beam | Bar | Shell
    acceleration: tuple[float, ...]

    def __post_init__(self):
        check(self)
        require_components("Gravity: acceleration", self.acceleration, self.part.mesh.dimension)
        if not any(self.acceleration):
            raise ValueError("Gravity: acceleration is zero, so that nothing has a weight; give the vector of gravity")
        if not self.part.section.weighs(cast(Elastic, self.part.material)):
            raise ValueError(f"Gravity: the {type(self.part).__name__} on group {self.part.group or 'all'!r} has no "
                             f"density; {self.part.section.weight}")

    def _mass(self):
        """Mass per length or area of the mesh, as UFL."""
        part, domain = self.part, self.part.mesh.domain
        if isinstance(part, Shell):
            mass, *_ = part.sections.numbers(lambda section: section.inertia(part.material))
            return mass * part.mid_surface()[1]
        mass, *_ = part.sections.numbers(lambda section: section.inertia(part.material, part.mesh.dimension))
        return mass * (part.eccentricity()[1] if isinstance(part, Beam) else 1.0) + 0 * ufl.SpatialCoordinate(domain)[0]

    def work(self, fields):
        mesh, given = self.part.mesh, as_constants(self.part.mesh.domain, list(map(float, self.acceleration)))
        force = forms.vector([fields.factor * self._mass() * c for c in given])
        return forms.load.dead_force(force, fields.displacement(mesh), fields.vary) * self.part.measure()

    def total(self, fields) -> float:
        mesh = self.part.mesh
        whole = fem.assemble_scalar(compiled_form(lift_numbers(self._mass() * self.part.measure(), mesh.domain)))
        return mesh.comm.allreduce(float(whole)) * float(np.linalg.norm(self.acceleration))
