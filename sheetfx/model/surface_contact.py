"""Contact of points of one part with the surface of another, along which they slide."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Annotated

import numpy as np

from .. import forms
from ..checks import NONZERO, Choice, Count, NotNegative, Positive, check
from ..mesh.lines import Stretch
from ..mesh.projection import Cells, cells_at
from ..mesh.reader import NamedMesh
from ..mesh.whole import whole
from .pair_contact import PARALLEL, PENETRATION
from .sampled_contact import SampledContact, faces, half_thickness, parts_on, touch_stiffness

EQUAL = 1e-9  # relative difference of faces of one distance


@dataclass(frozen=True, eq=False)
class SurfaceContact(SampledContact):
    """Unilateral contact, with or without friction, of an edge, a face or a point of one part with a surface.

    Points of the first part touch the closest point of the surface in its present shape. They slide along it, over
    the borders of its cells, and off its edges, where they are free. The surface is that of a mid-surface, and so is
    the slip: what friction turns about is half the thickness away, which is left out.

    Attributes
    ----------
    mesh : of the first part: a shell, or a beam in space
    at : where on it: a named edge of surfaces, group of cells or point, a Stretch, or several alike; None: everywhere
    to : mesh of the second part, of shells, and the name of a group of cells of it; None: all
    toward : direction from the first part to the second one, roughly, at the start; None: that of the closest points
    distance : between mid-surfaces, or the axis of a beam and a mid-surface, where the parts touch; None: half of both
        thicknesses (depths), of the first part at each of its cells. Offsets of shells are added by what they are
        along the surface's normal at the start
    friction : Coulomb's coefficient
    overhang : how far a surface goes on beyond its edges; None: half its thickness
    samples : Gauss points on each piece of a line, and along each side of a cell
    stiffness : pressure over penetration; None: ten times the bending stiffness of the softer part over the size of
        what may touch, with which Newton's steps are long and pressures take a few augmentations
    tangential : stiffness against slip before the cone is reached; None: a hundredth of `stiffness`
    enforcement : "uzawa": pressures are augmented until nothing penetrates by more than a millionth of a cell, nor
        slips where it sticks by more than that times `stiffness` over `tangential`; or "penalty", which needs a higher
        stiffness
    adjust : overlap at the start up to which points touch where they are, as of imperfect parts; 0: none
    law : function like `forms.contact.mohr_coulomb`, whose pressures are forces per area, per length along lines, and
        forces at points
    name : what messages call it
    """

    mesh: NamedMesh
    at: str | Stretch | Sequence[str | Stretch] | None
    to: tuple[NamedMesh, str | None]
    toward: Annotated[tuple[float, float, float], NONZERO] | None = None
    distance: NotNegative | None = None
    friction: NotNegative = 0.0
    overhang: NotNegative | None = None
    samples: Count = 2
    stiffness: Positive | None = None
    tangential: Positive | None = None
    enforcement: Annotated[str, Choice(("penalty", "uzawa"))] = "uzawa"
    adjust: NotNegative = 0.0
    law: Callable = forms.contact.mohr_coulomb
    name: str = field(default="SurfaceContact", kw_only=True)
    on_ground = False

    def __post_init__(self):
        check(self)
        self._require_part()
        if self.to[0].domain.topology.dim != 2 or self.to[0].dimension != 3:
            raise ValueError(f"{self._title}: the second part is no surface in space; give shells there, or use a "
                             "PairContact with curves")
        if self.mesh.dimension != 3:
            raise ValueError(f"{self._title}: the first part is in a plane; read its mesh in 3 dimensions")

    @property
    def points(self) -> Sequence[tuple[NamedMesh, str | None]]:
        return [(self.mesh, None), (self.to[0], None)]

    def contributions(self, fields):
        samples, to = self._samples, whole(self.to[0])
        cells = Cells(to, cells_at(to, self.to[1]))
        which, reference, _ = cells.closest(samples.places)
        normals = cells.normals(which, reference)
        arms = samples.places - cells.places(which, reference)
        side = self._sides(normals, arms)
        apart = self._distance(fields, cells, normals, side)
        along = side * (normals * arms).sum(axis=1)
        size = min(float(cells.sizes.mean()), self._cell_size)
        beside = np.linalg.norm(arms - (side * along)[:, None] * normals, axis=1) > PENETRATION * size
        gaps = np.where(beside, 0.0, along - apart)
        if gaps.min(initial=0.0) < -max(PENETRATION * size, self.adjust):
            place = ", ".join(f"{x:.6g}" for x in samples.places[gaps.argmin()])
            raise ValueError(f"{self._title}: the parts overlap by {-gaps.min():.6g} at ({place}); move one of them, "
                             "give a smaller distance, or adjust= where it is an imperfection")
        if self.adjust:
            apart = apart + np.minimum(gaps, 0.0)
        sides = [parts_on(fields, mesh) for mesh in (self.mesh, self.to[0])]
        stiffness = touch_stiffness(sides, max(size, samples.size), samples.extent)
        yield fields.surface_work(self, samples, (cells, which, reference, side),
                                  self._pairs(arms, apart, stiffness, size))

    def _sides(self, normals: np.ndarray, arms: np.ndarray) -> np.ndarray:
        """On which side of the surface the points are, seen along its normals: 1 or -1."""
        along = (normals * (arms / self.mesh.size if self.toward is None else -np.asarray(self.toward))).sum(axis=1)
        if np.abs(along).min(initial=1.0) <= PARALLEL:
            raise ValueError(f"{self._title}: no direction leads from one part to the other at the start; say in "
                             "`toward` on which side the second part is")
        return np.sign(along)

    def _distance(self, fields, cells: Cells, normals: np.ndarray, side: np.ndarray) -> np.ndarray:
        """Distance at which each sample touches, from the meshed surface or line to the other meshed surface.

        Parameters
        ----------
        cells : of the second part
        normals, side : of it, where it is closest to each sample, and 1 or -1: on which of its sides that is
        """
        thick, toward = self.distance is None, -side[:, None] * normals
        first = faces(parts_on(fields, self.mesh), self._samples.cells, self._normals, toward, thick, self._title)
        up, there = np.tile((0.0, 0.0, 1.0), (len(cells.cells), 1)), []
        for sign in (1.0, -1.0):
            second = faces(parts_on(fields, self.to[0]), cells.cells, up, sign * up, thick, self._title)
            if np.ptp(second) > EQUAL * np.abs(second).max():
                raise ValueError(f"{self._title}: the second part has faces from {second.min():.6g} to "
                                 f"{second.max():.6g} off its meshed surface, on which points slide; make a contact "
                                 "for each group of one thickness and offset")
            there.append(second[0])
        offsets = np.where(side > 0, *there)
        return (self.distance or 0.0) + first + offsets

    def border(self, fields) -> float:
        """How far the surface goes on beyond its edges."""
        if self.overhang is not None:
            return self.overhang
        return half_thickness(parts_on(fields, self.to[0]))
