"""Partition of meshes with junctions, where more than two cells meet at a facet.

DOLFINx 0.9 takes a facet with two cells on one process for an inner one and splits it from further cells on another
process, so that structures come apart at junctions.
"""

from __future__ import annotations

import basix
import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from ..compat import adjacency_list, default_partition


def keep_junctions_whole(comm, parts: int, cell_types, cells):
    """DOLFINx's own partition, but with all cells around a junction on one process.

    To be given to `dolfinx.mesh.create_mesh` as its partitioner; process 0 has all cells.
    """
    chosen = default_partition(comm, parts, cell_types, cells)
    joined = _joined(getattr(basix.CellType, cell_types[0].name), cells[0])
    _, first = np.unique(joined, return_index=True)
    return adjacency_list(chosen.array[first[joined]].reshape(-1, 1))


def _joined(cell: basix.CellType, corners: np.ndarray) -> np.ndarray:
    """For each cell the number of its group; cells that meet at a junction are of one group."""
    topology = basix.topology(cell)
    facets = np.sort(corners.reshape(-1, len(topology[0]))[:, topology[-2]], axis=2)
    count = len(facets)
    _, number, cells = np.unique(facets.reshape(-1, facets.shape[2]), axis=0, return_inverse=True, return_counts=True)
    junctions = np.flatnonzero(cells[number] > 2)
    pairs = junctions // facets.shape[1], count + number[junctions]
    graph = coo_array((np.ones(len(junctions)), pairs), shape=(count + len(cells),) * 2)
    return connected_components(graph, directed=False)[1][:count]
