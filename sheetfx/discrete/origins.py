"""Where entries of arrays come from: numbers that do not depend on how meshes are distributed over processes.

Cells keep the number that they have in the model that a mesh is read from; a node has the number of its place in the
first of its cells.
"""

from __future__ import annotations

import numpy as np
from dolfinx import la
from dolfinx.fem import FunctionSpace
from dolfinx.mesh import Mesh

from ..communicators import lasting

SEVERAL = 2**40  # above all numbers of entries of one kind, so that those of several kinds stand in one array


def of_cells(domain: Mesh, cells: np.ndarray) -> np.ndarray:
    """Origins of cells that this process knows of."""
    return domain.topology.original_cell_index[cells]


def of_nodes(space: FunctionSpace) -> np.ndarray:
    """Origins of the nodes of a space that this process knows of."""
    dofmap, index_map = space.dofmap.list.astype(np.int64), space.dofmap.index_map
    places = of_cells(space.mesh, np.arange(len(dofmap)))[:, None] * dofmap.shape[1] + np.arange(dofmap.shape[1])
    first = np.full(index_map.size_local + index_map.num_ghosts, np.iinfo(np.int64).max)
    np.minimum.at(first, dofmap, places)
    begin, end = index_map.local_range
    for ghosts, origins in lasting(index_map.comm).allgather((index_map.ghosts, first[index_map.size_local:])):
        own = (ghosts >= begin) & (ghosts < end)
        np.minimum.at(first, ghosts[own] - begin, origins[own])
    shared = la.vector(index_map, 1, dtype=np.float64)
    shared.array[:] = first
    shared.scatter_forward()
    return np.rint(shared.array).astype(np.int64)


def components(origins: np.ndarray, count: int) -> np.ndarray:
    """Origins of the components of quantities that have so many, as a flat array."""
    return (origins[:, None] * count + np.arange(count)).ravel()
