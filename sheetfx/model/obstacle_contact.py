"""Contact of shells, and of beams in the plane and in space, with rigid obstacles."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Annotated

import numpy as np
import ufl

from .. import forms
from ..checks import Choice, Count, NotNegative, Positive, check
from ..forms.evaluate import evaluate, prepared
from ..mesh.lines import Stretch
from ..mesh.reader import NamedMesh
from .obstacles import Obstacle, add_travel
from .own_forms import number_of
from .sampled_contact import SampledContact, faces, parts_on, touch_stiffness


@dataclass(frozen=True, eq=False)
class ObstacleContact(SampledContact):
    """Unilateral contact, with or without friction, of an edge, a face or a point of a part with a rigid obstacle.

    The obstacle is a part without unknowns, or with its travel as the only one. Gap and slip belong to the
    mid-surface or axis; what friction turns about is half the thickness away, which is left out.

    Attributes
    ----------
    mesh : of the part: a shell, or a beam in the plane or in space
    at : where on it: a named edge of surfaces, group of cells or point, a Stretch, or several alike; None: everywhere
    obstacle : RigidPlane, RigidCylinder, RigidSphere, or one's own (`obstacles.Obstacle`)
    distance : from the mid-surface or axis to where it touches; None: half the thickness (depth) of each cell. An
        offset of shells is added by what it is along the obstacle's normal at the start
    friction : Coulomb's coefficient
    samples : Gauss points on each piece of a line, and along each side of a cell
    stiffness : pressure over penetration; None: ten times the bending stiffness of the part over a size between those
        of a cell and of what may touch, with which a free obstacle is held from the start
    tangential : stiffness against slip before the cone is reached; None: a hundredth of `stiffness`
    enforcement : "uzawa": pressures are augmented until nothing penetrates by more than a millionth of a cell, nor
        slips where it sticks by more than that times `stiffness` over `tangential`; or "penalty", which needs a higher
        stiffness
    adjust : overlap at the start up to which points touch where they are, as of imperfect parts; 0: none
    law : function like `forms.contact.mohr_coulomb`, see `SurfaceContact`; it has a slip for each direction of space
    name : what messages call it
    """

    mesh: NamedMesh
    at: str | Stretch | Sequence[str | Stretch] | None
    obstacle: Obstacle
    distance: NotNegative | None = None
    friction: NotNegative = 0.0
    samples: Count = 2
    stiffness: Positive | None = None
    tangential: Positive | None = None
    enforcement: Annotated[str, Choice(("penalty", "uzawa"))] = "uzawa"
    adjust: NotNegative = 0.0
    law: Callable = forms.contact.mohr_coulomb
    name: str = field(default="ObstacleContact", kw_only=True)

    def __post_init__(self):
        check(self)
        self._require_part()
        what = type(self.obstacle).__name__
        if self.mesh.dimension not in self.obstacle.dimensions:
            raise ValueError(f"{self._title}: the {what} is not one in {self.mesh.dimension} dimensions; give its "
                             "vectors as many components as the mesh has dimensions, or take another obstacle")

    @property
    def points(self) -> Sequence[tuple[NamedMesh, str | None]]:
        return [(self.mesh, None)]

    def _faces(self, parts) -> np.ndarray:
        """Distance of the face that looks to the obstacle from the meshed surface or line, at each sample."""
        samples = self._samples
        point = ufl.Constant(self.mesh.domain.ufl_domain(), shape=(self.mesh.dimension,))
        x = ufl.variable(ufl.as_vector([point[i] for i in range(self.mesh.dimension)]))
        slope = prepared(ufl.diff(self.obstacle.gap(x, [0.0] * self.mesh.dimension), x))
        toward = -evaluate(slope, lambda node: samples.places if node == point else number_of(node))
        toward, thick = np.broadcast_to(toward, samples.places.shape), self.distance is None
        return (self.distance or 0.0) + faces(parts, samples.cells, self._normals, toward, thick, self._title)

    def unknowns(self, fields):
        add_travel(fields, self.obstacle, self.mesh)

    def contributions(self, fields):
        samples, parts, size = self._samples, parts_on(fields, self.mesh), self._cell_size
        stiffness = touch_stiffness([parts], (size * max(size, samples.size)) ** 0.5, samples.extent)
        apart = self._faces(parts)
        work = fields.obstacle_work(self, samples, self._pairs(np.zeros_like(samples.places), apart, stiffness, size))
        work.adjust(self.adjust)
        work.first_touch(self._title)
        yield work
