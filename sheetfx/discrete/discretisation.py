"""From a scene to a discrete system: fields, contributions, supports."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import chain
from typing import TYPE_CHECKING, TypeVar

import ufl
from mpi4py import MPI

from ..mesh.reader import NamedMesh
from ..model.contact import Contact
from ..model.obstacles import add_travel, way_of
from ..model.reported import combined, counted
from ..model.scene import Scene
from .contact import ContactFields, eliminates
from .contact_work import ContactWork
from .contribution import Contribution
from .elements import ElementWork
from .fields import Fields
from .form_work import FormWork, by_mesh, work_of
from .kinematics import Kinematics
from .layer import LayerFields, LayerWork
from .layout import Layout
from .load_work import works_of_loads, works_of_natural_strains
from .nodal import FixedIncrements
from .partless import refuse_cells_without_part
from .potential import look_for_potentials
from .redundant import without_redundant
from .sharing import sharings_of
from .structure import Structure
from .supports import fixed_dofs, turn_nodes
from .system import System
from .timing import Stopwatch
from .unknowns import Unknowns

if TYPE_CHECKING:
    from ..model.joints import Joint

Other = TypeVar("Other")


def discretised(given: Scene | Other, mixed_points: bool, monitors: Sequence) -> Discretisation | Other:
    """A scene with its fields and system; any other problem as it is.

    Parameters
    ----------
    monitors : of the scene and of controls, which supports must leave free
    """
    if not isinstance(given, Scene):
        return given
    for monitor in monitors:
        given.require_free(monitor)
    return Discretisation(given, mixed_points)


class Discretisation(Structure):
    """Fields and system of a scene.

    Attributes
    ----------
    fields : Fields
    layout : rows of the system
    system : System
    contacts : list of ContactFields
    sharings : nodes that have the unknowns of others
    follower : loads that follow the structure, and for each whether their forces have a potential nevertheless
    """

    def __init__(self, scene: Scene, mixed_points: bool = True):
        self.scene, self.clock = scene, Stopwatch()
        fields = self.fields = Fields(scene)
        for mesh in scene.meshes:
            turn_nodes(self.kinematics(mesh), [s for s in scene.supports if s.mesh is mesh])
        self.sharings = sharings_of(scene.joints, fields)
        for contact in scene.contacts:
            add_travel(fields, contact.obstacle, contact.beam.mesh)
        for thing in (*scene.all_loads, *scene.all_joints):
            thing.unknowns(fields)
        self.contacts = [(LayerFields if eliminates(c) else ContactFields)(c, f"multiplier{i}")
                         for i, c in enumerate(scene.contacts)]
        fields.blocks += [c.block for c in self.contacts if c.block is not None]
        self.unknowns = fields.unknowns = Unknowns(fields.blocks)
        self._close_contacts()
        fixed = fixed_dofs(fields, self.sharings)
        refuse_cells_without_part(fields, fixed, self.sharings)
        if mixed_points:
            self.unknowns.changes = [f.create_change() for f in self.unknowns.fields]
        with self.clock("compile"):
            loads = [(load, list(works)) for load, works in works_of_loads(fields)]
            self._of_joints = [(joint, list(self._works_of(joint))) for joint in scene.all_joints]
            joints = [work for _, works in self._of_joints for work in works]
            others = [*self._of_contacts(), *joints, *chain(*(works for _, works in loads)), FixedIncrements()]
            parts = list(self._of_parts())
            contributions = [*parts, *others, *works_of_natural_strains(scene, parts)]
        layout = without_redundant(Layout(fields.comm, fields.blocks, fixed, self.sharings), joints, self.unknowns,
                                   scene.meshes)
        self.layout = layout
        self.follower = look_for_potentials(loads, self.unknowns, layout, fields.factors, self.clock)
        self.system = System(self.unknowns, contributions, layout, fields.factors, self.clock)
        self._totals = [(kind, [load.total(fields.at_stage(n)) for load in counting])
                        for n, (kind, counting) in enumerate(counted(stage.loads) for stage in scene.all_stages)]

    @property
    def works_of_parts(self) -> list[ElementWork]:
        """Internal virtual work of each part of the scene, in their order."""
        return self.system.contributions[:len(self.scene.parts)]

    def work_of(self, part) -> ElementWork:
        """Internal virtual work of a part."""
        return self.works_of_parts[self.scene.parts.index(part)]

    def kinematics(self, mesh: NamedMesh) -> Kinematics:
        return self.fields.kinematics(mesh)

    def travel(self, obstacle):
        """Displacement vector of an obstacle, as UFL components."""
        if not self.fields.has(obstacle, "travel"):
            return [0.0, 0.0]
        return [self.fields.own(obstacle, "travel") * c for c in way_of(obstacle)]

    def travelled(self, obstacle) -> float:
        """How far an obstacle has moved along its travel, the same on all processes."""
        if not self.fields.has(obstacle, "travel"):
            return 0.0
        return float(self.fields.own_field(obstacle, "travel").value.x.array[0])

    def _position(self, contact: Contact):
        """Current position of the points of a beam that may touch."""
        beam, frame = contact.beam, contact.beam.frame()
        k = self.kinematics(beam.mesh)
        x = ufl.SpatialCoordinate(beam.mesh.domain) + k.u
        if contact.side:
            x = x + contact.lever * k.rotation.rotate(frame.normal)
        return x

    def _close_contacts(self) -> None:
        """Express gaps in the fields; refuse obstacles that start inside, move free ones to first touch."""
        for c in self.contacts:
            contact, mesh = c.contact, c.contact.beam.mesh
            c.close(self._position(contact), self.travel(contact.obstacle), self._before)
            with self.clock("compile"):
                c.prepare(self.unknowns.at_rest)
            smallest = mesh.comm.allreduce(c.smallest_gap(), op=MPI.MIN)
            if smallest < -1e-6 * contact.beam.section.depth:
                raise ValueError(
                    f"{type(contact.obstacle).__name__}: starts {-smallest:.4g} inside the structure; "
                    "move its centre or point out of it")
            if self.fields.has(contact.obstacle, "travel"):
                travel = self.fields.own_field(contact.obstacle, "travel")
                travel.start(max(self.travelled(contact.obstacle), smallest + 1e-9 * mesh.size))

    def _before(self, expression):
        return self.unknowns.at_rest(self.unknowns.previous(ufl.as_ufl(expression)))

    def _of_parts(self) -> Iterator[Contribution]:
        for number, part in enumerate(self.scene.parts):
            k = self.kinematics(part.mesh)
            internal = part.internal(k.u, k.total_rotation).less(self.fields.natural_strains(part))
            yield ElementWork(internal, self.unknowns.fields, self.unknowns.changes, f"history of part {number}")

    def _of_contacts(self) -> Iterator[Contribution]:
        for contact in self.contacts:
            work = LayerWork if isinstance(contact, LayerFields) else ContactWork
            yield work(self.fields, contact, self.clock)

    def _works_of(self, joint: Joint) -> Iterator[Contribution]:
        yield from joint.contributions(self.fields)
        for work in by_mesh([work_of(joint, self.fields)]):
            yield FormWork(self.unknowns, work, smooth=joint.smooth, conservative=joint.conservative)

    def works_of_joint(self, joint: Joint) -> list[Contribution]:
        """Contributions of a joint.

        Raises
        ------
        ValueError
            If the scene has it not.
        """
        found = [works for one, works in self._of_joints if one is joint]
        if not found:
            raise ValueError(f"{type(joint).__name__}: is no joint of this scene; give one of its joints")
        return found[0]

    def strain_energy(self, part) -> float:
        """Energy that a part stores now, on all processes."""
        return part.mesh.comm.allreduce(self.work_of(part).energy())

    def dissipated(self) -> float:
        """Energy that laws with history of all parts have dissipated by now, as far as they tell, on all processes."""
        return self.fields.comm.allreduce(sum(work.dissipated() for work in self.works_of_parts if work.tells_energy))

    def total_load(self) -> float:
        """Load of the present stage on the whole structure, of the magnitudes of its loads or the reaction.

        See `model.reported`.
        """
        unit = self.load_of_unit()
        if unit is not None:
            return unit * self.system.factor
        kind, totals = self._totals[self.system.factors.stage]
        return combined(kind, [total() for total in totals if callable(total)], self.scene.symmetry_factor)

    def load_of_unit(self) -> float | None:
        """Total load of the present stage for a load factor of 1; None where it is a reaction."""
        kind, totals = self._totals[self.system.factors.stage]
        return None if any(map(callable, totals)) else combined(kind, totals, self.scene.symmetry_factor)
