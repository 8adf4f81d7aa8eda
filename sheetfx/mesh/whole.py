"""A distributed mesh as one process would have it: where parts meet, each process knows all cells of both."""

from __future__ import annotations

import numpy as np

from ..compat import geometry_nodes, serial_mesh
from .reader import NamedMesh
from .tagged import nodes_of_vertices


def whole(mesh: NamedMesh) -> NamedMesh:
    """The mesh with the cells of all processes, on this one alone; itself where there is one process.

    Cells keep their origins. The first call for a mesh is one of all processes.
    """
    if mesh.comm.size == 1:
        return mesh
    if mesh.gathered is None:
        mesh.gathered = _gathered(mesh)
    return mesh.gathered


def _gathered(mesh: NamedMesh) -> NamedMesh:
    domain, comm = mesh.domain, mesh.comm
    topology, geometry, cells = domain.topology, domain.geometry, geometry_nodes(domain)
    owned, origins = topology.index_map(topology.dim).size_local, topology.original_cell_index
    parts = comm.allgather((geometry.input_global_indices, geometry.x[:, :mesh.dimension],
                            geometry.input_global_indices[cells[:owned]], origins[:owned]))
    nodes, x, cells, numbers = (np.concatenate(part) for part in zip(*parts, strict=True))
    places = np.zeros((nodes.max() + 1, mesh.dimension))  # by numbers in the model, so that it is one process's mesh
    places[nodes] = x
    made = serial_mesh(domain, cells[np.argsort(numbers)], places)
    of_vertices = made.geometry.input_global_indices[nodes_of_vertices(made)]
    vertices = np.empty(len(places), dtype=np.int32)
    vertices[of_vertices] = np.arange(len(of_vertices))
    of_origins = np.argsort(made.topology.original_cell_index).astype(np.int32)
    own = geometry.input_global_indices[nodes_of_vertices(domain)]

    def everywhere(local: np.ndarray) -> np.ndarray:
        return np.unique(np.concatenate(comm.allgather(local)), axis=0)

    topology.create_connectivity(1, 0)
    made.topology.create_connectivity(1, 0)
    ends, all_ends = (t.connectivity(1, 0).array.reshape(-1, 2) for t in (topology, made.topology))
    facets = {tuple(sorted(pair)): n for n, pair in enumerate(all_ends.tolist())} if mesh.edges else {}

    def edge(local: np.ndarray) -> np.ndarray:
        pairs = vertices[everywhere(own[ends[local]])]
        return np.sort(np.array([facets[tuple(sorted(pair))] for pair in pairs.tolist()], dtype=np.int32))

    return NamedMesh(
        made,
        {name: np.sort(of_origins[everywhere(origins[local])]) for name, local in mesh.cells.items()},
        {name: edge(local) for name, local in mesh.edges.items()},
        {name: np.sort(vertices[everywhere(own[local])]) for name, local in mesh.points.items()},
        mesh.opposed, mesh.model)
