"""What a structure answers to the path follower: its monitored displacement, its size, and its faults."""

from __future__ import annotations

from collections.abc import Sequence
from typing import cast

import numpy as np
from petsc4py import PETSc

from ..mesh.reader import NamedMesh
from ..model.scene import Monitor, Scene, Stage
from .fields import Fields
from .free_body import unbalanced
from .free_motions import why_singular, without_numbers
from .functional import Functional, Turn
from .layout import Layout
from .motion_words import motions_in_words, rigid_motions_in_words
from .unknowns import Unknowns
from .visiting import Visiting


class Structure(Visiting):
    """The share of a scene's `Discretisation` in the protocol `continuation.problem.Problem`."""

    scene: Scene
    fields: Fields
    unknowns: Unknowns
    layout: Layout
    unresponsive = ("Scene: the structure does not respond to its loads; they act on supports only, or cancel out: "
                    "move or change them")

    @property
    def stages(self) -> Sequence[Stage]:
        return self.scene.stages

    @property
    def size(self) -> float:
        return self.scene.meshes[0].size

    @property
    def massless(self) -> str:
        heavy = all(p.material is not None and p.material.density is not None for p in self.scene.parts)
        return "" if heavy else "a part has no density"

    def monitored(self, monitor: Monitor):
        """The block of the monitored displacement, and its local dofs on the process that owns it."""
        if monitor.at is None:
            field = self.fields.own_field(monitor.on, "travel")
            block = next(b for b in self.unknowns.blocks if b.fields[0] is field)
            return block, np.arange(block.index_map.size_local)
        mesh = cast(NamedMesh, monitor.on)
        k = self.fields.kinematics(mesh)
        return k.block, k.point_dofs(mesh, monitor.at, cast(str, monitor.component))

    def functional(self, monitor: Monitor | None = None) -> Functional:
        """A displacement, or a rotation; None: the one that the scene monitors."""
        monitor = monitor or self.scene.monitor
        block, dofs = self.monitored(monitor)
        vector = self.system.functional(block, dofs, monitor.sign)
        if (monitor.component or "").startswith("r") and block.fields[1].curved:
            return Turn(vector, self.layout, block.fields[1], dofs, monitor.sign)
        return Functional(vector)

    def nodal_changes(self, step: PETSc.Vec) -> list[np.ndarray]:
        """Nodal displacements of all meshes by a step, one node in each row."""
        changes, values = self.system.changes(step), [f.value for f in self.unknowns.fields]
        return [changes[values.index(self.fields.kinematics(mesh).u)].reshape(-1, mesh.dimension)
                for mesh in self.scene.meshes]

    def unbalanced(self, load: PETSc.Vec) -> str:
        return unbalanced(self, load)

    def why_singular(self) -> str:
        return why_singular(self)

    def without_numbers(self, when: str) -> str:
        return without_numbers(self, when)

    def unstable_at_rest(self, count: int, modes: Sequence[np.ndarray]) -> str:
        """Number of unstable modes of the unloaded structure, and what the first ones look like."""
        told = [rigid_motions_in_words(self, column) or motions_in_words(self, column)
                for column in (np.array(mode)[:, None] for mode in modes)]
        words = f" ({'; '.join(told)})" if told else ""
        return (f"Scene: the unloaded structure is unstable in {count} mode{'s' * (count > 1)}{words}; loads of a "
                "first stage may stabilise it, else look for stiffnesses that are negative, as of springs or own laws")
