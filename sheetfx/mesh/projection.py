"""Closest points of curves and surfaces: in which cell a point of space lies, and where in it.

DOLFINx finds cells that contain a point, which those of surfaces in space do only up to rounding, and distances to
cells as if these were straight; so that the closest points of curved cells are found here, by Gauss-Newton iteration.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property

import basix
import numpy as np
from scipy.optimize import bisect, brentq
from scipy.spatial import cKDTree

from ..compat import geometry_nodes
from .reader import NamedMesh

ITERATIONS = 60
CONVERGED = 1e-13  # step in reference coordinates
BEYOND = 1.0  # how far beyond its borders a cell goes on, in reference coordinates
OUTSIDE = 1e-9  # reference coordinate beyond a border that counts as outside
AS_CLOSE, EVIDENT = 1e-13, 1e-9  # differences of distances that count as none, and as one, over the size of the mesh


class Cells:
    """Cells of a mesh on this process, on which closest points are looked for.

    Parameters
    ----------
    mesh : NamedMesh
    cells : numbers of the cells

    Attributes
    ----------
    sizes : length of each cell, of surfaces the root of its area
    middles : of the cells, shape (cells, dimension)
    flat : of each cell whether it is straight or plane, with straight edges
    """

    def __init__(self, mesh: NamedMesh, cells: np.ndarray):
        self.mesh, self.cells = mesh, np.asarray(cells, dtype=np.int32)
        domain = mesh.domain
        self.kind = domain.basix_cell()
        self.shape = domain.ufl_domain().ufl_coordinate_element().basix_element
        self.nodes = domain.geometry.x[geometry_nodes(domain)[self.cells]][:, :, : mesh.dimension]
        corners = basix.geometry(self.kind)
        self._start, self._axes = corners.mean(axis=0), np.eye(corners.shape[1])
        self._borders = [(corners[b[0]], corners[b[1:]] - corners[b[0]]) for b in basix.topology(self.kind)[-2]]
        middles = np.broadcast_to(self._start, (len(self.cells), len(self._start)))
        every = np.arange(len(self.cells))
        self.middles, slopes = self._map(every, middles)
        self.sizes = np.linalg.det(np.einsum("nai,naj->nij", slopes, slopes)) ** (0.5 / len(self._start))
        self.flat = self._flat()
        self._radius = np.linalg.norm(self.nodes - self.middles[:, None], axis=2).max(initial=0.0)
        self._tree = cKDTree(self.middles) if len(self.cells) else None

    def _flat(self) -> np.ndarray:
        if self.shape.degree > 1:
            return np.zeros(len(self.cells), dtype=bool)
        across = self.nodes[:, 1:] - self.nodes[:, :1]
        off = np.linalg.svd(across, compute_uv=False)[:, len(self._start):].max(axis=1, initial=0.0)
        return off <= OUTSIDE * self.sizes

    def _map(self, which: np.ndarray, reference: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Places of reference points in cells, and their derivatives, shape (n, dimension, reference dimension)."""
        nodes = self.nodes[which]
        if not len(which):  # which basix refuses
            return np.empty((0, nodes.shape[2])), np.empty((0, nodes.shape[2], len(self._start)))
        table = self.shape.tabulate(1, np.ascontiguousarray(reference))[..., 0]
        return np.einsum("nk,nkd->nd", table[0], nodes), np.einsum("tnk,nkd->ndt", table[1:], nodes)

    def places(self, which: np.ndarray, reference: np.ndarray) -> np.ndarray:
        """Places of reference points in cells; `which` are numbers in `cells`."""
        return self._map(which, reference)[0]

    def derivatives(self, which: np.ndarray, reference: np.ndarray) -> np.ndarray:
        """Derivatives of the place by the reference coordinates, shape (n, dimension, reference dimension)."""
        return self._map(which, reference)[1]

    def normals(self, which: np.ndarray, reference: np.ndarray) -> np.ndarray:
        """Unit normals of a surface."""
        slopes = self.derivatives(which, reference)
        normal = np.cross(slopes[:, :, 0], slopes[:, :, 1])
        return normal / np.linalg.norm(normal, axis=1, keepdims=True)

    def tangents(self, which: np.ndarray, reference: np.ndarray) -> np.ndarray:
        """Unit tangents of curves."""
        slope = self._map(which, reference)[1][:, :, 0]
        return slope / np.linalg.norm(slope, axis=1, keepdims=True)

    def holds(self, which: np.ndarray, points: np.ndarray) -> np.ndarray:
        """Whether points are over given cells, one for each, and not off their borders."""
        return self._margins(self._project(which, points, self._start, self._axes)).min(axis=1) >= -OUTSIDE

    def nearest(self, which: np.ndarray, points: np.ndarray) -> np.ndarray:
        """Reference points of given cells that are closest to points, one for each."""
        reference = self._project(which, points, self._start, self._axes)
        outside = np.flatnonzero(self._margins(reference).min(axis=1) < -OUTSIDE)
        if len(outside):
            _, reference[outside] = self._on_borders(which[outside], points[outside])
        return np.clip(reference, 0.0, 1.0)

    def _on_borders(self, which: np.ndarray, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Number of the border of a cell that is closest to a point, and the closest reference point on it."""
        found, distances = [], []
        for origin, axes in self._borders:
            along = (self._project(which, points, origin, axes) - origin) @ axes.T
            along = np.clip(along / (axes * axes).sum(axis=1), 0.0, 1.0)
            found.append(origin + along @ axes)
            distances.append(np.linalg.norm(self.places(which, found[-1]) - points, axis=1))
        border = np.argmin(distances, axis=0)
        return border, np.array(found)[border, np.arange(len(points))]

    def _project(self, which: np.ndarray, points: np.ndarray, start: np.ndarray,
                 axes: np.ndarray) -> np.ndarray:
        """Reference points of the closest points on given cells, or on lines in these, beyond whose borders they go on.

        Parameters
        ----------
        start : reference point where the iteration starts
        axes : directions in which reference points are looked for, one in each row
        """
        reference, left = np.tile(start, (len(points), 1)), np.arange(len(points))
        if not len(axes):
            return reference
        for _ in range(ITERATIONS):
            place, slopes = self._map(which[left], reference[left])
            slopes = slopes @ axes.T
            matrix = np.einsum("nai,naj->nij", slopes, slopes)
            right = np.einsum("nai,na->ni", slopes, points[left] - place)
            step = np.linalg.solve(matrix, right[:, :, None])[:, :, 0] @ axes
            moved = np.clip(reference[left] + step, -BEYOND, 1 + BEYOND)
            going = np.abs(moved - reference[left]).max(axis=1) > CONVERGED
            reference[left], left = moved, left[going]
            if not len(left):
                break
        return reference

    def _margins(self, reference: np.ndarray) -> np.ndarray:
        """How far reference points are inside of each border of a cell, shape (n, borders); negative: outside."""
        if self.kind == basix.CellType.triangle:
            return np.column_stack((reference, 1 - reference.sum(axis=1)))
        return np.column_stack((reference, 1 - reference))

    def margins(self, cell: int, point: np.ndarray) -> tuple[bool, Callable[[np.ndarray], np.ndarray]]:
        """Whether a point is off the border of a cell, and how far points near it are inside, as a function.

        It is positive where the cell is the closest one. Of points off the border it is how far they are inside of the
        ends of the closest border.
        """
        which = np.array([cell])
        reference = self._project(which, point[None], self._start, self._axes)
        if self._margins(reference).min() >= -OUTSIDE:
            return False, lambda p: self._margins(self._project(which, p[None], self._start, self._axes))[0]
        origin, axes = self._borders[self._on_borders(which, point[None])[0][0]]
        if not len(axes):
            return True, lambda p: np.ones(1)

        def along(p):
            s = ((self._project(which, p[None], origin, axes)[0] - origin) @ axes[0]) / (axes[0] @ axes[0])
            return np.array([s, 1 - s])
        return True, along

    def passed(self, which: np.ndarray, points: np.ndarray, ways: np.ndarray) -> np.ndarray:
        """Lengths of straight lines within given cells, through points on them and along unit vectors, one for each.

        Lines across a cell, as of a post on a bar, have no length in it.
        """
        reference = self.nearest(which, points)
        along = np.einsum("nia,na->ni", np.linalg.pinv(self.derivatives(which, reference)), ways)
        margins = self._margins(reference)
        slopes = self._margins(reference + along) - margins
        size = np.abs(slopes).max(axis=1, keepdims=True)
        crossed = np.abs(slopes) > OUTSIDE * size
        ends = margins / np.where(crossed, slopes, 1.0)
        ahead, behind = (np.where(crossed & (sign * slopes < 0), sign * -ends, np.inf).min(axis=1) for sign in (1, -1))
        return np.where(crossed.any(axis=1) & (size[:, 0] > 0), ahead + behind, 0.0)

    def distances(self, which: np.ndarray, points: np.ndarray) -> np.ndarray:
        """Of points from given cells, one for each."""
        return np.linalg.norm(self.places(which, self.nearest(which, points)) - points, axis=1)

    def are_closest(self, which: np.ndarray, points: np.ndarray) -> np.ndarray:
        """Whether no other cells are closer to points than given ones, one for each."""
        beyond = self.distances(which, points) - EVIDENT * self.mesh.size
        found = beyond <= 0
        found[~found] = beyond[~found] <= self.closest(points[~found])[2]
        return found

    def around(self, which: int) -> np.ndarray:
        """Numbers of the cells that have a corner in common with a given one, which is one of them."""
        corners = self._corners
        return np.flatnonzero(np.isin(corners, corners[which]).any(axis=1))

    @cached_property
    def _corners(self) -> np.ndarray:
        topology = self.mesh.domain.topology
        topology.create_connectivity(topology.dim, 0)
        corners = topology.connectivity(topology.dim, 0)
        return np.array([corners.links(cell) for cell in self.cells])

    def given_over(self, cell: int, place: Callable[[float], np.ndarray], low: float, high: float) -> float:
        """Parameter of a line at which the next cell is closer than one that is closest at `low`, but not at `high`.

        Where the line is beside the cell, over a fold that points to it, both are as close, and then nearly so, until
        it is over the next one: that begins there.
        """
        own = np.array([cell])
        high = bisect(lambda at: 0.5 - self.are_closest(own, place(at)[None])[0], low, high, xtol=OUTSIDE)
        following = self.closest(place(high)[None])[0]
        beside, _ = self.margins(cell, place(high))
        _, margins = self.margins(int(following[0]), place(high))

        def ahead(at: float) -> float:
            if beside:
                return float(margins(place(at)).min())
            return float(np.subtract(*(self.distances(which, place(at)[None])[0] for which in (own, following))))

        return float(brentq(ahead, low, high, xtol=1e-15, rtol=1e-14)) if ahead(low) < 0 < ahead(high) else high

    def closest(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Of each point the closest cell (a number in `cells`), the reference point in it, and the distance.

        Without cells the distance is infinite.
        """
        count = len(points)
        if self._tree is None or not count:
            return (np.zeros(count, dtype=np.int64), np.tile(self._start, (count, 1)), np.full(count, np.inf))
        nearest = self._tree.query(points)[0]
        candidates = self._tree.query_ball_point(points, (nearest + 2 * self._radius) * (1 + 1e-9))
        lengths = np.array([len(c) for c in candidates])
        starts = np.concatenate(([0], np.cumsum(lengths)[:-1]))
        which, owner = np.concatenate(candidates).astype(np.int64), np.repeat(np.arange(count), lengths)
        reference = self.nearest(which, points[owner])
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
