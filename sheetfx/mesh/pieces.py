"""Connected pieces of a mesh, by the names of what is on them."""

from __future__ import annotations

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from ..compat import geometry_nodes
from .reader import NamedMesh


def pieces_without(mesh: NamedMesh, places: list[str | None]) -> list[str]:
    """Names of groups and points on each connected piece of a mesh that has none of the named places.

    None among them stands for the whole mesh.
    """
    if None in places:
        return []
    topology, comm = mesh.domain.topology, mesh.domain.comm
    vertices, corners = topology.index_map(0), topology.connectivity(topology.dim, 0)
    cells = corners.array.reshape(corners.num_nodes, -1) if corners.num_nodes else np.empty((0, 2), dtype=np.int32)
    pairs = [vertices.local_to_global(np.repeat(cells[:, 0], cells.shape[1])), vertices.local_to_global(cells.ravel())]
    rows, columns = (np.concatenate(comm.allgather(p)) for p in pairs)
    graph = coo_array((np.ones(len(rows)), (rows, columns)), shape=(vertices.size_global,) * 2)
    pieces = connected_components(graph, directed=False)[1]

    def pieces_of(local: np.ndarray) -> set[int]:
        found = pieces[vertices.local_to_global(np.unique(local).astype(np.int32))]
        return set().union(*comm.allgather(set(found.tolist())))

    def at(name: str) -> set[int]:
        dimension, entities = mesh.at(name)
        topology.create_connectivity(dimension, 0)
        links = topology.connectivity(dimension, 0)
        return pieces_of(np.concatenate([links.links(e) for e in entities] or [np.empty(0)]))

    names = {repr(n): pieces_of(cells[c].ravel()) for n, c in mesh.cells.items()}
    names |= {repr(n): at(n) for n in (*mesh.edges, *mesh.points)}
    held = set().union(*(at(place) for place in places if place is not None))
    return [", ".join(n for n, on in names.items() if piece in on) for piece in sorted(set(pieces.tolist()) - held)]


def straight_joints(mesh: NamedMesh) -> int:
    """Number of nodes at which two straight cells and no others meet in one line, on all processes."""
    met: dict[int, list[np.ndarray]] = {}
    for nodes, along in zip(geometry_nodes(mesh.domain)[mesh.group(None), :2], mesh.chords(None), strict=True):
        for node in nodes:
            met.setdefault(int(node), []).append(along)
    straight = [len(chords) == 2 and abs(chords[0] @ chords[1]) > 1 - 1e-9 for chords in met.values()]
    return mesh.domain.comm.allreduce(sum(straight))
