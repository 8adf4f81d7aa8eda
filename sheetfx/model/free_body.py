"""A structure without supports: its mean motion is held, which takes no force from loads in equilibrium."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
import ufl

from .. import forms
from ..mesh.reader import COMPONENTS
from .beam import Bar, Beam
from .joints import Joint
from .shell import Shell


class FreeBody(Joint):
    """Holds the integrals of displacement and of rotation about the origin over all parts, by multipliers.

    They are the sums of the loads' forces and moments, per measure of the parts.

    Parameters
    ----------
    part : over which the integrals of this one are taken
    first : the one that has the multipliers; None: this one
    """

    def __init__(self, part: Beam | Bar | Shell, first: FreeBody | None = None):
        self._part, self._first = part, first or self

    def _names(self) -> Sequence[str]:
        return [f"motion {name}" for name in COMPONENTS[self._part.mesh.dimension]]

    def unknowns(self, fields) -> None:
        if self._first is self:
            for name in self._names():
                fields.add_number(self, self._part.mesh, name, np.inf, multiplier=True)

    def work(self, fields):
        part, mesh = self._part, self._part.mesh
        forces = [fields.own(self._first, name) for name in self._names()]
        motions = forms.load.rigid_measures(ufl.SpatialCoordinate(mesh.domain), fields.displacement(mesh),
                                            fields.rotation(mesh), mesh.size)
        return fields.vary(sum(f * motion for f, motion in zip(forces, motions, strict=True))) * part.measure()


def held_freely(parts: Sequence[Beam | Bar | Shell]) -> Iterator[FreeBody]:
    """What holds the mean motion of a structure that nothing else holds, one for each part."""
    first = None
    for part in parts:
        body = FreeBody(part, first)
        first = first or body
        yield body
