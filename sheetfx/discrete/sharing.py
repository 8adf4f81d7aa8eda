"""Nodes of one field whose unknowns belong to another field's nodes: full compatibility, by elimination."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from dolfinx import fem, la
from scipy.spatial import cKDTree

from ..mesh.reader import NamedMesh
from .nodal_field import AdditiveField
from .unknowns import Block


@dataclass(frozen=True)
class Sharing:
    """Nodes of a field that have no unknowns of their own, but share another field's.

    Attributes
    ----------
    field, of : fields with as many components
    nodes, of_nodes : local numbers on this process, its ghosts included, one for one
    """

    field: AdditiveField
    nodes: np.ndarray
    of: AdditiveField
    of_nodes: np.ndarray

    def entries(self, blocks: Sequence[Block]) -> tuple[int, np.ndarray, int, np.ndarray]:
        """Number of the field's block and local dofs there, and those that they share."""
        return (_block_of(self.field, blocks), _entries(self.field, self.nodes),
                _block_of(self.of, blocks), _entries(self.of, self.of_nodes))


def _block_of(field: AdditiveField, blocks: Sequence[Block]) -> int:
    return next(n for n, block in enumerate(blocks) if any(f is field for f in block.fields))


def _entries(field: AdditiveField, nodes: np.ndarray) -> np.ndarray:
    return field.dofs.reshape(-1, field.width)[nodes].ravel()


def sharings_of(joints, fields) -> list[Sharing]:
    """Sharings that joints ask for, checked against each other, with the axes of the nodes made the same."""
    sharings = [sharing for joint in joints for sharing in joint.shared(fields)]
    check_sharings(sharings)
    share_axes(sharings)
    return sharings


def check_sharings(sharings: Iterable[Sharing]) -> None:
    """Refuse nodes that share the unknowns of two nodes, or of nodes that share others' themselves.

    Raises
    ------
    ValueError
    """
    taken: dict[int, np.ndarray] = {}
    for sharing in sharings:
        before = taken.get(id(sharing.field), np.empty(0, dtype=np.int64))
        if len(np.intersect1d(before, sharing.nodes)):
            raise ValueError("Compatible: nodes of one mesh share the unknowns of two others; let these share those of "
                             "the first instead")
        taken[id(sharing.field)] = np.concatenate([before, sharing.nodes])
    for sharing in sharings:
        if len(np.intersect1d(taken.get(id(sharing.of), []), sharing.of_nodes)):
            raise ValueError("Compatible: nodes share the unknowns of nodes that share others' themselves; join both "
                             "to the last of the three meshes")


def share_axes(sharings: Iterable[Sharing]) -> None:
    """Give nodes the axes of those whose unknowns they share.

    Raises
    ------
    ValueError
        Where a support has given them others.
    """
    for sharing in sharings:
        own, axes = sharing.field.axes, sharing.of.axes
        if own is None and axes is None:
            continue
        identity = np.broadcast_to(np.eye(sharing.field.width), (len(sharing.nodes), *(sharing.field.width,) * 2))
        axes = identity if axes is None else axes[sharing.of_nodes]
        if own is None:
            own = sharing.field.axes = np.tile(np.eye(sharing.field.width), (len(sharing.field.table), 1, 1))
        elif not all(np.allclose(o, i) or np.allclose(o, a)
                     for o, i, a in zip(own[sharing.nodes], identity, axes, strict=True)):
            raise ValueError("Support: has axes of its own at nodes that share the unknowns of another mesh; name a "
                             "point or edge of that mesh in the support")
        own[sharing.nodes] = axes


def share_marks(sharings: Iterable[Sharing], blocks: Sequence[Block], dofs: Sequence[np.ndarray]) -> list[np.ndarray]:
    """Local dofs of each block that are among given ones, or share an unknown with one that is."""
    marks = [la.vector(block.index_map, block.width) for block in blocks]
    for mark, chosen in zip(marks, dofs, strict=True):
        mark.array[chosen] = 1.0
    shared = [s.entries(blocks) for s in sharings]
    for block, own, of_block, of_own in shared:
        np.maximum.at(marks[of_block].array, of_own, marks[block].array[own])
    for of_block in sorted({entries[2] for entries in shared}):
        marks[of_block].scatter_reverse(la.InsertMode.add)
        marks[of_block].scatter_forward()
    for block, own, of_block, of_own in shared:
        marks[block].array[own] = marks[of_block].array[of_own]
    return [np.flatnonzero(mark.array > 0.0) for mark in marks]


def same_places(mesh: NamedMesh, field: AdditiveField, of: AdditiveField, at: str | None, tolerance: float) -> Sharing:
    """Sharing of all nodes of a field, or of those at a named place, that stand at nodes of another one.

    Parameters
    ----------
    mesh : of the field
    at : group of cells, edge or point of the mesh; None: everywhere
    tolerance : distance that counts as none

    Raises
    ------
    ValueError
        If a node stands at one that only another process knows.
    """
    space, other = field.value.function_space, of.value.function_space
    nodes = nodes_at(mesh, space, at)
    places = space.tabulate_dof_coordinates()[nodes]
    there = cKDTree(other.tabulate_dof_coordinates())
    distances, nearest = there.query(places)
    found = distances <= tolerance
    comm = mesh.comm
    alone = np.concatenate(comm.allgather(places[~found]))
    elsewhere = comm.allreduce(int((there.query(alone)[0] <= tolerance).sum()) if len(alone) else 0)
    if elsewhere:
        raise ValueError(f"Compatible: {elsewhere} nodes stand at nodes that another process has; read both meshes "
                         "with one read_mixed or read_kinds, which keeps such nodes together")
    return Sharing(field, nodes[found], of, nearest[found])


def nodes_at(mesh: NamedMesh, space, at: str | None) -> np.ndarray:
    """Local nodes of a space, ghosts included, at a named place, or everywhere."""
    if at is None:
        return np.arange(space.dofmap.index_map.size_local + space.dofmap.index_map.num_ghosts)
    if at not in mesh.cells:
        return fem.locate_dofs_topological(space, *mesh.at(at)).astype(np.int64)
    marks = la.vector(space.dofmap.index_map, 1)
    marks.array[np.unique(space.dofmap.list[mesh.group(at)])] = 1.0
    marks.scatter_reverse(la.InsertMode.add)
    marks.scatter_forward()
    return np.flatnonzero(marks.array > 0.0)
