"""Closest points of curves and surfaces: in which cell a point of space lies, and where in it.

DOLFINx finds cells that contain a point, which those of surfaces in space do only up to rounding, and distances to
cells as if these were straight; so that the closest points of curved cells are found here, by Gauss-Newton iteration.
"""

from __future__ import annotations

import basix
import numpy as np
from scipy.spatial import cKDTree

from ..compat import geometry_nodes
from .reader import NamedMesh

ITERATIONS = 60
CONVERGED = 1e-13  # step in reference coordinates
AS_CLOSE = 1e-9  # difference of distances that counts as none, over the size of the mesh


class Cells:
    """Cells of a mesh on this process, on which closest points are looked for.

    Parameters
    ----------
    mesh : NamedMesh
    cells : numbers of the cells

    Attributes
    ----------
    sizes : length of each cell, of surfaces the root of its area
    """

    def __init__(self, mesh: NamedMesh, cells: np.ndarray):
        self.mesh, self.cells = mesh, np.asarray(cells, dtype=np.int32)
        domain = mesh.domain
        self.kind = domain.basix_cell()
        self.shape = domain.ufl_domain().ufl_coordinate_element().basix_element
        self.nodes = domain.geometry.x[geometry_nodes(domain)[self.cells]][:, :, : mesh.dimension]
        self._centre = basix.geometry(self.kind).mean(axis=0)
        middles = np.broadcast_to(self._centre, (len(self.cells), len(self._centre)))
        every = np.arange(len(self.cells))
        self._middles, slopes = self._map(every, middles)
        self.sizes = np.linalg.det(np.einsum("nai,naj->nij", slopes, slopes)) ** (0.5 / len(self._centre))
        self._radius = np.linalg.norm(self.nodes - self._middles[:, None], axis=2).max(initial=0.0)
        self._tree = cKDTree(self._middles)

    def _map(self, which: np.ndarray, reference: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Places of reference points in cells, and their derivatives, shape (n, dimension, reference dimension)."""
        table = self.shape.tabulate(1, np.ascontiguousarray(reference))[..., 0]
        nodes = self.nodes[which]
        return np.einsum("nk,nkd->nd", table[0], nodes), np.einsum("tnk,nkd->ndt", table[1:], nodes)

    def places(self, which: np.ndarray, reference: np.ndarray) -> np.ndarray:
        """Places of reference points in cells; `which` are numbers in `cells`."""
        return self._map(which, reference)[0]

    def normals(self, which: np.ndarray, reference: np.ndarray) -> np.ndarray:
        """Unit normals of a surface."""
        slopes = self._map(which, reference)[1]
        normal = np.cross(slopes[:, :, 0], slopes[:, :, 1])
        return normal / np.linalg.norm(normal, axis=1, keepdims=True)

    def project(self, which: np.ndarray, points: np.ndarray) -> np.ndarray:
        """Reference points of the closest points of given cells, which go on beyond their borders by their size."""
        reference = np.tile(self._centre, (len(points), 1))
        for _ in range(ITERATIONS):
            place, slopes = self._map(which, reference)
            matrix = np.einsum("nai,naj->nij", slopes, slopes)
            right = np.einsum("nai,na->ni", slopes, points - place)
            step = np.linalg.solve(matrix, right[:, :, None])[:, :, 0]
            moved = np.clip(reference + step, -1.0, 2.0)
            done = np.abs(moved - reference).max(initial=0.0) <= CONVERGED
            reference = moved
            if done:
                break
        return reference

    def margins(self, reference: np.ndarray) -> np.ndarray:
        """How far reference points are inside of each border of a cell, shape (n, borders); negative: outside."""
        if self.kind == basix.CellType.triangle:
            return np.column_stack((reference, 1 - reference.sum(axis=1)))
        return np.column_stack((reference, 1 - reference))

    def _clamp(self, reference: np.ndarray) -> np.ndarray:
        """Reference points moved to the border where they are outside of their cell."""
        inside = np.clip(reference, 0.0, 1.0)
        if self.kind == basix.CellType.triangle:
            beyond = np.maximum(inside.sum(axis=1) - 1, 0.0)[:, None]
            inside = np.clip(inside - beyond / 2, 0.0, 1.0)
            inside = inside / np.maximum(inside.sum(axis=1), 1.0)[:, None]
        return inside

    def closest(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Of each point the closest cell (a number in `cells`), the reference point in it, and the distance.

        Distances of points beyond the borders of all cells are upper bounds; without cells they are infinite.
        """
        count = len(points)
        if not len(self.cells) or not count:
            return (np.zeros(count, dtype=np.int64), np.tile(self._centre, (count, 1)), np.full(count, np.inf))
        nearest = self._tree.query(points)[0]
        candidates = self._tree.query_ball_point(points, (nearest + 2 * self._radius) * (1 + 1e-9))
        lengths = np.array([len(c) for c in candidates])
        starts = np.concatenate(([0], np.cumsum(lengths)[:-1]))
        which, owner = np.concatenate(candidates).astype(np.int64), np.repeat(np.arange(count), lengths)
        reference = self._clamp(self.project(which, points[owner]))
        distances = np.linalg.norm(self.places(which, reference) - points[owner], axis=1)
        least = np.minimum.reduceat(distances, starts)
        good = np.flatnonzero(distances <= least[owner] + AS_CLOSE * self.mesh.size)
        chosen = good[np.unique(owner[good], return_index=True)[1]]
        return which[chosen], reference[chosen], distances[chosen]


def cells_at(mesh: NamedMesh, name: str | None) -> np.ndarray:
    """Cells of this process at a named point, edge or group of cells; None: all.

    Raises
    ------
    ValueError
        If nothing has the name.
    """
    if name is None or (name in mesh.cells and name not in mesh.points and name not in mesh.edges):
        return mesh.group(name)
    if name not in mesh.points and name not in mesh.edges:
        known = ", ".join([*mesh.points, *mesh.edges, *mesh.cells])
        raise ValueError(f"the mesh has no point, edge or group of cells named {name!r}; it has {known}")
    dimension, entities = mesh.at(name)
    topology = mesh.domain.topology
    topology.create_connectivity(dimension, topology.dim)
    links = topology.connectivity(dimension, topology.dim)
    cells = np.unique(np.concatenate([np.empty(0, dtype=np.int32), *(links.links(e) for e in entities)]))
    return cells[cells < topology.index_map(topology.dim).size_local]
