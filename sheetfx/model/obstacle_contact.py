"""Contact of shells, and of beams in the plane and in space, with rigid obstacles."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Annotated

import numpy as np

from .. import forms
from ..checks import Choice, Count, NotNegative, Positive, check
from ..mesh.lines import Stretch
from ..mesh.projection import Cells
from ..mesh.reader import NamedMesh
from ..mesh.samples import Samples, samples_at
from .joints import Joint
from .obstacles import Obstacle
from .pair_contact import ELASTIC_SLIP, PENETRATION
from .places import each_of, require_places, title_of
from .surface_contact import half_thickness, touch_stiffness


@dataclass(frozen=True, eq=False)
class ObstacleContact(Joint):
    """Unilateral contact, with or without friction, of an edge, a face or a point of a part with a rigid obstacle.

    The obstacle is a part without unknowns, or with its travel as the only one. Gap and slip are those of the
    mid-surface or axis; what friction turns about is half the thickness away, which is left out.

    Attributes
    ----------
    mesh : of the part: a shell, or a beam in the plane or in space
    at : where on it: a named edge of surfaces, group of cells or point, a Stretch, or several alike; None: everywhere
    obstacle : RigidPlane, RigidCylinder, RigidSphere, or one's own (`obstacles.Obstacle`)
    distance : from the mid-surface or axis to where it touches; None: half the thickness (depth)
    friction : Coulomb's coefficient
    samples : Gauss points on each piece of a line, and along each side of a cell
    stiffness : pressure over penetration; None: ten times the bending stiffness of the part over a size between those
        of a cell and of what may touch, with which a free obstacle is held from the start
    tangential : stiffness against slip before the cone is reached; None: a hundredth of `stiffness`
    enforcement : "uzawa": pressures are augmented until nothing penetrates by more than a millionth of a cell; or
        "penalty", which needs a higher stiffness
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
    law: Callable = forms.contact.mohr_coulomb
    name: str = field(default="ObstacleContact", kw_only=True)

    smooth = False

    def __post_init__(self):
        check(self)
        require_places(self.name, self.mesh, each_of(self.at))
        what = type(self.obstacle).__name__
        if self.mesh.dimension not in self.obstacle.dimensions:
            raise ValueError(f"{self._title}: the {what} is not one in {self.mesh.dimension} dimensions; give its "
                             "vectors as many components as the mesh has dimensions, or take another obstacle")
        if self.mesh.domain.comm.size > 1:
            raise ValueError(f"{self._title}: contact with obstacles by ObstacleContact on "
                             f"{self.mesh.domain.comm.size} processes is not possible yet; take one process")

    @property
    def _title(self) -> str:
        return title_of(self.name, each_of(self.at)[0])

    @property
    def points(self) -> Sequence[tuple[NamedMesh, str | None]]:
        return [(self.mesh, None)]

    @property
    def conservative(self) -> bool:  # type: ignore[override]
        return self.friction == 0

    @cached_property
    def _samples(self) -> Samples:
        return samples_at(self.mesh, each_of(self.at), self.samples, self._title)

    def unknowns(self, fields):
        if self.obstacle.travel is not None and not fields.has(self.obstacle, "travel"):
            fields.add_number(self.obstacle, self.mesh, "travel", self.mesh.size)

    def contributions(self, fields):
        samples, parts = self._samples, [part for part in fields.scene.parts if part.mesh is self.mesh]
        size = float(Cells(self.mesh, samples.cells).sizes.mean())
        between = (size * max(size, samples.size)) ** 0.5
        stiffness = self.stiffness or touch_stiffness([parts], between, samples.extent)
        apart = max(map(half_thickness, parts)) if self.distance is None else self.distance
        count, d = samples.places.shape
        work = fields.obstacle_work(self, samples, {
            "arms": np.zeros((count, d)), "axes": np.zeros((count, d, d)), "gap": np.full(count, apart),
            "weights": samples.weights, "tolerance": PENETRATION * size, "augmented": self.enforcement == "uzawa",
            "parameters": (stiffness, self.tangential or ELASTIC_SLIP * stiffness, self.friction, 0.0, 0.0)})
        work.first_touch(self._title)
        yield work
