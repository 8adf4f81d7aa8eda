"""Cells that belong to no part: their nodes have unknowns, but no stiffness."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from dolfinx import fem, la
from dolfinx.mesh import compute_midpoints

from ..mesh.reader import NamedMesh
from .fields import Fields
from .kinematics import Kinematics
from .sharing import Sharing


def refuse_cells_without_part(fields: Fields, fixed: Sequence[np.ndarray], sharings: Sequence[Sharing]) -> None:
    """Refuse cells of no part, if one of their nodes has no part, is not held, and meets no joint.

    Parameters
    ----------
    fixed : local dofs of each block of the fields that are held

    Raises
    ------
    ValueError
        On all processes, where one has such cells.
    """
    for mesh in fields.meshes:
        groups = [part.group for part in fields.scene.parts if part.mesh is mesh]
        if None in groups:
            continue
        with_part = np.unique(np.concatenate([mesh.group(name) for name in groups]))
        without = np.setdiff1d(mesh.group(None), with_part)
        kinematics = fields.kinematics(mesh)
        held = fixed[fields.blocks.index(kinematics.block)]
        bare = _cells_of_bare_nodes(fields, mesh, kinematics, with_part, held, sharings)
        bare = np.intersect1d(without, bare).astype(np.int32)
        here = [name for name, cells in mesh.cells.items() if np.isin(bare, cells).any() and name not in groups]
        place = compute_midpoints(mesh.domain, mesh.domain.topology.dim, bare[:1])
        found = [one for one in mesh.comm.allgather((here, place, len(bare))) if one[2]]
        if found:
            names = ", ".join(repr(n) for n in dict.fromkeys(name for names, *_ in found for name in names))
            cells = f"{sum(count for *_, count in found)} cells" + (f" of the group {names}" if names else "")
            at = tuple(float(f"{c:.6g}") for c in found[0][1][0] + 0.0)
            raise ValueError(f"Scene: {cells} belong to no part, the first at {at}; give them one, or leave them out "
                             "of the groups that are read")


def _cells_of_bare_nodes(fields: Fields, mesh: NamedMesh, kinematics: Kinematics, with_part: np.ndarray,
                         held: np.ndarray, sharings: Sequence[Sharing]) -> np.ndarray:
    """Owned cells with a node that has no part, is not held and meets no joint."""
    cells, found = mesh.group(None), [np.empty(0, dtype=np.int32)]
    joined = [at for joint in fields.scene.joints for other, at in joint.points if other is mesh]
    if None in joined or any(not joint.points for joint in fields.scene.joints):
        return found[0]
    for field in kinematics.block.fields:
        space = field.value.function_space
        table, marks = space.dofmap.list, la.vector(space.dofmap.index_map, 1)
        marks.array[np.unique(table[with_part])] = 1.0
        for at in joined:
            nodes = table[mesh.cells[at]].ravel() if at in mesh.cells else fem.locate_dofs_topological(
                space, *mesh.at(at))
            marks.array[nodes] = 1.0
        for sharing in sharings:
            for one, nodes in ((sharing.field, sharing.nodes), (sharing.of, sharing.of_nodes)):
                if one is field:
                    marks.array[nodes] = 1.0
        marks.array[np.isin(field.dofs, held).reshape(-1, field.width).all(axis=1)] = 1.0
        marks.scatter_reverse(la.InsertMode.add)
        marks.scatter_forward()
        found.append(cells[(marks.array[table[: len(cells)]] == 0.0).any(axis=1)])
    return np.unique(np.concatenate(found))
