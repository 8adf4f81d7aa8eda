"""Forces of joints, and of supports and prescribed motions: what the nodes that these hold lack of balance."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

import numpy as np
from mpi4py import MPI

from ..mesh.reader import COMPONENTS, NamedMesh
from ..model.joints import Joint
from ..model.loads import PrescribedDisplacement, PrescribedRotation
from ..model.supports import Support
from .discretisation import Discretisation
from .nodal_field import AdditiveField
from .sharing import share_marks
from .supports import fixed_by
from .unknowns import Block

MULTIPLIERS = {PrescribedDisplacement: "reaction", PrescribedRotation: "moment"}  # unknowns of motions, by their names


@dataclass(frozen=True)
class Reaction:
    """What holds some nodes acts on the structure, in one configuration.

    Attributes
    ----------
    places : where the nodes of this process are now, shape (n, dimension)
    forces : on these nodes, along the directions of space, the same shape
    moments : about the nodes of rotations of this process, shape (m, 1 in the plane or 3); in space conjugate to the
        spin, about axes of space that do not turn
    """

    places: np.ndarray
    forces: np.ndarray
    moments: np.ndarray
    comm: MPI.Comm

    @property
    def force(self) -> np.ndarray:
        """Resultant of all processes, shape (dimension,)."""
        return self.comm.allreduce(self.forces.sum(axis=0))

    @property
    def middle(self) -> np.ndarray:
        """Mean of the places on all processes; for one point that point, where there are none the origin."""
        return self.comm.allreduce(self.places.sum(axis=0)) / (self.comm.allreduce(len(self.places)) or 1)

    def moment(self, about: Sequence[float] | None = None) -> np.ndarray:
        """Resultant moment of all processes, shape (1,) in the plane or (3,).

        Parameters
        ----------
        about : a fixed place; None: `middle`
        """
        arms = self.places - (self.middle if about is None else np.asarray(about, dtype=float))
        turned = np.cross(np.pad(arms, [(0, 0), (0, 3 - arms.shape[1])]),
                          np.pad(self.forces, [(0, 0), (0, 3 - arms.shape[1])]))
        return self.comm.allreduce(self.moments.sum(axis=0) + turned.sum(axis=0)[3 - self.moments.shape[1]:])


@dataclass(frozen=True)
class ReactionPath:
    """Resultants along a path, the same on all processes.

    Attributes
    ----------
    force : shape (states, dimension)
    moment : shape (states, 1 in the plane or 3)
    """

    force: np.ndarray
    moment: np.ndarray


@dataclass(frozen=True)
class _Held:
    """Nodes of a field of which something holds some components: numbers and marks, shape (n, width)."""

    block: Block
    field: AdditiveField
    nodes: np.ndarray
    components: np.ndarray

    def force(self, arrays: Sequence[np.ndarray]) -> np.ndarray:
        """Part of nodal vectors along the components, along the directions of space, shape (n, width)."""
        field, width = self.field, self.field.width
        vectors = arrays[field.dofs].reshape(-1, width)[self.nodes]
        if field.axes is None:
            return np.where(self.components, vectors, 0.0)
        axes = field.axes[self.nodes]
        along = np.where(self.components, np.einsum("nij,ni->nj", axes, vectors), 0.0)
        return np.einsum("nij,nj->ni", axes, along)


class Holds:
    """Supports and prescribed motions of a scene with the components of nodes that each holds.

    A component that several hold counts for the first of them, supports before motions. A support that fixes one
    component of a rotation, whose direction turns with the node, has the whole moment there.

    Attributes
    ----------
    things : supports and motions
    """

    def __init__(self, discretisation: Discretisation):
        self._discretisation, scene = discretisation, discretisation.scene
        fields = discretisation.fields
        self.things = [*scene.supports, *(load for load in scene.all_loads if type(load) in MULTIPLIERS)]
        taken = [np.empty(0, dtype=np.int64) for _ in fields.blocks]
        self._held: list[list[_Held]] = []
        for thing in self.things:
            place = fields.blocks.index(fields.kinematics(thing.mesh).block)
            dofs = np.setdiff1d(fixed_by(fields.kinematics(thing.mesh), _as_support(thing)), taken[place])
            self._held.append([_held(fields.blocks[place], field, dofs) for field in fields.blocks[place].fields])
            taken[place] = np.union1d(taken[place], dofs)
            taken = share_marks(discretisation.sharings, fields.blocks, taken)

    def at(self, of: object) -> list[object]:
        """Supports and motions by themselves, or all at a named place.

        Raises
        ------
        ValueError
            Where there are none.
        """
        found = [thing for thing in self.things if thing is of or thing.at == of]
        if not found:
            places = ", ".join(dict.fromkeys(repr(thing.at) for thing in self.things))
            raise ValueError(f"reactions: no support or prescribed motion at {of!r}; choose from {places}")
        return found

    def reactions(self) -> list[tuple[Any, Reaction]]:
        """Of each support and motion in the present configuration."""
        discretisation = self._discretisation
        system, comm = discretisation.system, discretisation.system.comm
        with self._without_motions():
            arrays = system.arrays(system.at_nodes(lambda forces: [c.residual(forces) for c in system.contributions]))
        found = []
        for thing, (moved, *turned) in zip(self.things, self._held, strict=True):
            array = arrays[discretisation.fields.blocks.index(moved.block)]
            where = moved.field.value.function_space.tabulate_dof_coordinates()[:, :thing.mesh.dimension]
            moments = turned[0].force(array) if turned else np.zeros((0, 2 * thing.mesh.dimension - 3))
            found.append((thing, Reaction((where + moved.field.table)[moved.nodes], moved.force(array), moments, comm)))
        return found

    def along(self, snapshots: Sequence[dict], of: object, about: Sequence[float] | None = None) -> ReactionPath:
        """Resultants of `at(of)` in configurations that snapshots of the system give, and back to where it was."""
        chosen = self.at(of)
        return _along(self._discretisation, snapshots, about, lambda: joined(
            [r for thing, r in self.reactions() if any(thing is other for other in chosen)]))

    @contextmanager
    def _without_motions(self) -> Iterator[None]:
        """Let the multipliers of prescribed motions be zero inside."""
        fields = [self._discretisation.fields.own_field(thing, MULTIPLIERS[type(thing)])
                  for thing in self.things if type(thing) in MULTIPLIERS]
        kept = [field.value.x.array.copy() for field in fields]
        for field, values in zip(fields, kept, strict=True):
            field.show(np.zeros_like(values))
        try:
            yield
        finally:
            for field, values in zip(fields, kept, strict=True):
                field.show(values)


def joint_reaction(discretisation: Discretisation, joint: Joint, on: NamedMesh) -> Reaction:
    """What a joint exerts on the nodes of a mesh in the present configuration.

    Raises
    ------
    ValueError
        If the joint is not one of the scene, has no forces of its own, or is not on the mesh.
    """
    works = discretisation.works_of_joint(joint)
    if not works:
        raise ValueError(f"joint_forces: {_name(joint)} has no forces of its own: its parts have unknowns in "
                         "common; weld them to know what it transfers")
    system, k = discretisation.system, discretisation.kinematics(on)
    arrays = system.arrays(system.at_nodes(lambda forces: [work.residual(forces) for work in works]))
    array, (moved, *turned) = arrays[discretisation.fields.blocks.index(k.block)], k.block.fields
    owned = moved.value.function_space.dofmap.index_map.size_local
    forces = -array[moved.dofs].reshape(-1, moved.width)[:owned]
    places = moved.value.function_space.tabulate_dof_coordinates()[:owned, :on.dimension] + moved.table[:owned]
    there = forces.any(axis=1)
    moments = np.zeros((0, 2 * on.dimension - 3))
    if turned:
        count = turned[0].value.function_space.dofmap.index_map.size_local
        moments = -array[turned[0].dofs].reshape(-1, turned[0].width)[:count]
    return Reaction(places[there], forces[there], moments, system.comm)


def joint_path(discretisation: Discretisation, snapshots: Sequence[dict], joint: Joint, on: NamedMesh | None,
               about: Sequence[float] | None) -> ReactionPath:
    """Resultants of a joint on a part in configurations that snapshots give; the system ends where it was."""
    meshes = list(dict.fromkeys(mesh for mesh, _ in joint.points))
    if on is None and len(meshes) != 2:
        named = "one mesh alone" if len(meshes) == 1 else "several meshes"
        raise ValueError(f"joint_forces: {_name(joint)} is on {named}; name in `on` the mesh of the part that it "
                         "acts on (forces of two ends on one mesh cancel out)")
    return _along(discretisation, snapshots, about, lambda: joint_reaction(discretisation, joint, on or meshes[1]))


def _along(discretisation: Discretisation, snapshots: Sequence[dict], about: Sequence[float] | None,
           reaction: Callable[[], Reaction]) -> ReactionPath:
    """Resultants of a reaction in configurations that snapshots give; the system ends where it was."""
    forces, moments = [], []
    with discretisation.visiting(discretisation.system.snapshot()):
        for snapshot in snapshots:
            discretisation.system.restore(snapshot)
            found = reaction()
            forces.append(found.force)
            moments.append(found.moment(about))
    return ReactionPath(np.array(forces), np.array(moments))


def _name(joint: Joint) -> str:
    return getattr(joint, "name", type(joint).__name__)


def joined(reactions: Sequence[Reaction]) -> Reaction:
    """Several reactions as one."""
    parts = [np.concatenate([getattr(r, name) for r in reactions]) for name in ("places", "forces", "moments")]
    return Reaction(*parts, reactions[0].comm)


def _as_support(thing) -> Support:
    """A support of what a support or a prescribed motion holds."""
    if isinstance(thing, Support):
        return thing
    turns = [name for name in COMPONENTS[thing.mesh.dimension] if name.startswith("r")]
    return Support(thing.mesh, thing.at, getattr(thing, "component", " ".join(turns)))


def _held(block: Block, field: AdditiveField, dofs: np.ndarray) -> _Held:
    """Nodes of this process of which some components are among local dofs of their block."""
    components = np.isin(field.dofs, dofs).reshape(-1, field.width)
    components = components[:field.value.function_space.dofmap.index_map.size_local]
    if field.curved and field.partly_fixed is not None:
        own = field.partly_fixed.nodes[field.partly_fixed.nodes < len(components)]
        components[own] = components[own].any(axis=1, keepdims=True)
    nodes = np.flatnonzero(components.any(axis=1))
    return _Held(block, field, nodes, components[nodes])
