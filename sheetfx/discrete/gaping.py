"""Nodes that stand on another mesh where it has none: between common nodes the parts gape or overlap."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.spatial import cKDTree

from ..compat import geometry_nodes
from ..mesh.projection import Cells, cells_at
from ..mesh.reader import NamedMesh
from ..notices import warn
from .sharing import Sharing, nodes_at

REACH = 2.0  # sizes of the largest cell from a node of the other mesh, within which cells of it are looked at


def tell_gaping(meshes: Sequence[NamedMesh], at: str | None, shared: Sharing, tolerance: float) -> None:
    """Warn where displacements that share nodes do not share all that stand on the other mesh.

    Parameters
    ----------
    meshes : of the field, and that whose unknowns it shares
    at : where on the first mesh nodes are shared
    shared : of the displacements
    tolerance : distance that counts as none
    """
    mesh, to = meshes
    sides = [(shared.field, nodes_at(mesh, shared.field.value.function_space, at), shared.nodes, to, None)]
    if at not in mesh.points:
        of = shared.of.value.function_space
        sides.append((shared.of, nodes_at(to, of, None), shared.of_nodes, mesh, at))
    found = [_alone(*side, tolerance) for side in sides]
    places = [np.concatenate(mesh.comm.allgather(one)) for one in found]
    if any(map(len, places)):
        own, other = (", ".join(m.cells) for m in (meshes if len(places[0]) else reversed(meshes)))
        first = next(p for p in places if len(p))
        where = ", ".join(f"{x:.6g}" for x in first[0])
        warn(f"Compatible: {len(first)} nodes of {own} stand on {other} where it has no node, the first at ({where}), "
             "so that the parts gape between common nodes; give both cells of one degree and size there, or weld them")


def refuse_apart(mesh: NamedMesh, to: NamedMesh, at: str | None, tolerance: float) -> None:
    """Refuse nodes of two meshes that are one in their gmsh model and stand apart.

    Raises
    ------
    ValueError
    """
    if mesh.model is None or mesh.model is not to.model or not (at is None or at in mesh.cells):
        return
    nodes = np.unique(geometry_nodes(mesh.domain)[cells_at(mesh, at)])
    one, other = (m.domain.geometry for m in (mesh, to))
    _, own, others = np.intersect1d(one.input_global_indices[nodes], other.input_global_indices, return_indices=True)
    distances = np.linalg.norm(one.x[nodes[own]] - other.x[others], axis=1)
    found = mesh.comm.allgather((int((distances > tolerance).sum()), distances.max(initial=0.0)))
    if count := sum(n for n, _ in found):
        names = " and ".join(", ".join(m.cells) for m in (mesh, to))
        raise ValueError(f"Compatible: {count} common nodes of {names} in their gmsh model stand apart, by up to "
                         f"{max(d for _, d in found):.3g}; give fx.imperfect the mixed mesh whole")


def _alone(field, nodes: np.ndarray, shared: np.ndarray, other: NamedMesh, at: str | None,
           tolerance: float) -> np.ndarray:
    """Places of this process's nodes that are not shared and stand on cells of the other mesh."""
    space, cells = field.value.function_space, Cells(other, cells_at(other, at))
    places = space.tabulate_dof_coordinates()[np.setdiff1d(nodes, shared)][:, :other.dimension]
    if not len(places) or not len(cells.cells):
        return places[:0]
    corners = np.unique(cells.nodes.reshape(-1, other.dimension), axis=0)
    near = places[cKDTree(corners).query(places)[0] <= REACH * cells.sizes.max()]
    return near[cells.closest(near)[2] <= tolerance]
