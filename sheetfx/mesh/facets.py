"""Smooth patches of surfaces that are known by flat cells: where they fold, and the normals at their vertices.

An edge of two cells is a fold where these meet at an angle above `FOLD`, or at one `SHARP` times as large as those of
all edges beyond them: panels of several cells that meet at a small angle have none inside, a curved surface has
similar ones everywhere. Flat parts with a vertex or a cell inside, and entities of the model that are flat all over,
are panels whatever turns at their other borders. Where a fold so found ends at no other border, the edge that goes on
straightest belongs to it as well if its angle is no less than half as large: at corners of panels all edges are next to
other folds.

The normal at a vertex belongs to a quadratic surface through it, nearest in least squares to the vertices around it, by
weights 1 / distance^2 (Meek and Walton 2000, On surface normal and Gaussian curvature approximations given data sampled
from a smooth surface). A vertex on a fold has one for each patch.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

FOLD = np.radians(40.0)  # angle at which gmsh, too, takes facets for two surfaces; circles of 9 cells are smooth
SHARP = 3.0  # smooth surfaces have at most 2 in gmsh's triangles, panels of several cells any number
TURN = 1e-6  # angle that is rounding of the coordinates
ENOUGH = 7  # vertices around one for a quadratic of 5 coefficients; where there are fewer, those around them as well
RANK = 1e-8  # singular value, over the largest, of coefficients that the vertices around one do not tell
CHUNK = 20000  # vertices at a time: those around each take memory


class Facets:
    """Cells by their sides, each of which goes from a vertex to the next side's.

    Parameters
    ----------
    x : places of vertices
    tables : vertices of cells in order around them, a table for each number of corners
    entities : of the model that each cell is on

    Attributes
    ----------
    vertex, cell, after, edge : of each side: where it begins, the next side, and the number of the edge that it is on
    ends : vertices of each edge, the smaller number first
    smooth : whether each edge is inside a smooth patch
    patch : a number that the sides which begin at one vertex in one patch have in common
    """

    def __init__(self, x: np.ndarray, tables: Sequence[np.ndarray], entities: np.ndarray):
        self.x, self._entities, self.vertex = x, entities, np.concatenate([table.ravel() for table in tables])
        self._corners = np.concatenate([np.full(len(table), table.shape[1]) for table in tables])
        first = np.cumsum(self._corners) - self._corners
        self.cell = np.repeat(np.arange(len(first)), self._corners)
        local = np.arange(len(self.vertex)) - first[self.cell]
        self.after = first[self.cell] + (local + 1) % self._corners[self.cell]
        pairs = np.sort(np.column_stack((self.vertex, self.vertex[self.after])), axis=1)
        self.ends, edge, sides = np.unique(pairs, axis=0, return_inverse=True, return_counts=True)
        self.edge = edge.ravel()
        order = np.argsort(self.edge, kind="stable")
        self._pairs = order[np.repeat(sides == 2, sides)].reshape(-1, 2)
        self._middle = np.add.reduceat(x[self.vertex], first) / self._corners[:, None]
        self.smooth = self._inner = sides == 2
        self.smooth = self._inner & ~self._folds()
        self.patch = self._patches()

    def _angles(self) -> np.ndarray:
        """Angle by which the surface turns at each edge of two cells; zero at others."""
        one, other = (self._inwards(sides) for sides in self._pairs.T)
        angles = np.zeros(len(self.ends))
        angles[self.edge[self._pairs[:, 0]]] = 2 * np.arcsin(np.minimum(np.linalg.norm(one + other, axis=1) / 2, 1.0))
        return angles

    def _inwards(self, sides: np.ndarray) -> np.ndarray:
        """Unit vectors from edges into the cells at them, across the edges."""
        start, end = self.x[self.vertex[sides]], self.x[self.vertex[self.after[sides]]]
        along = unit(end - start)
        ways = self._middle[self.cell[sides]] - (start + end) / 2
        return unit(ways - np.sum(ways * along, axis=1)[:, None] * along)

    def _folds(self) -> np.ndarray:
        """Whether each edge of two cells is a fold."""
        angles = self._angles()
        known, beyond = self._largest_beyond(angles)
        folds = sharp(angles, known, beyond)
        new = np.flatnonzero(folds)
        while len(new):
            new = np.array(self._continued(new, folds | ~self._inner, angles), dtype=np.int64)
            folds[new] = True
        return folds

    def _largest_beyond(self, angles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Whether there are edges of two cells beyond each edge, and the largest angle at these.

        They begin at the other corners of the two cells at it, and do not touch it. Beyond a cell of a flat panel
        nothing turns.
        """
        side = self._pairs.ravel()
        opposite = self.after[self.after[side]]
        last = self.after[opposite]  # the side itself in a triangle, whose vertex has edges that all touch it
        panels = self._panels(angles)
        edge, far = np.tile(self.edge[side], 2), self.vertex[np.concatenate([opposite, last])]
        flat = np.tile(panels[self.cell[side]], 2)
        known, largest = np.zeros(len(angles), dtype=bool), np.zeros(len(angles))
        known[edge[flat]] = True
        edge, far = edge[~flat], far[~flat]
        at = self._at_vertices(self._inner)
        counts = np.diff(at.indptr)[far]
        edge, begin = np.repeat(edge, counts), np.repeat(at.indptr[far] - np.cumsum(counts) + counts, counts)
        other = at.indices[begin + np.arange(len(edge))]
        apart = (self.ends[edge][:, :, None] != self.ends[other][:, None]).all(axis=(1, 2))
        known[edge[apart]] = True
        np.maximum.at(largest, edge[apart], angles[other[apart]])
        return known, largest

    def _panels(self, angles: np.ndarray) -> np.ndarray:
        """Whether each cell is on a flat part that curved surfaces do not have."""
        flat = self._inner & (angles <= TURN)
        one, other = self.cell[self._pairs[flat[self.edge[self._pairs[:, 0]]]]].T
        cells = len(self._entities)
        graph = coo_array((np.ones(len(one), dtype=bool), (one, other)), shape=(cells, cells))
        count, part = connected_components(graph, directed=False)
        found = np.zeros(count, dtype=bool)
        bent = ~flat[self.edge]
        for at in (self.vertex, self.cell):
            found[part[self.cell[~(np.bincount(at, bent) > 0)[at]]]] = True
        entity = np.unique(self._entities, return_inverse=True)[1].ravel()
        first = np.zeros(entity.max() + 1, dtype=np.int64)
        first[entity] = part
        split = np.bincount(entity, part != first[entity]) > 0
        return found[part] | ~split[entity]

    def _at_vertices(self, chosen: np.ndarray):
        """Table of vertices and of the chosen edges that end there, in rows."""
        edges = np.flatnonzero(chosen)
        places = self.ends[edges].ravel(), np.repeat(edges, 2)
        return coo_array((np.ones(2 * len(edges), dtype=bool), places), shape=(len(self.x), len(self.ends))).tocsr()

    def _continued(self, new: np.ndarray, border: np.ndarray, angles: np.ndarray) -> list[int]:
        """Edges by which folds go on where they end at no other border."""
        at, inner, found = self._at_vertices(border), self._at_vertices(self._inner & ~border), []
        alone = np.diff(at.indptr) == 1
        for fold, end in zip(*np.nonzero(alone[self.ends[new]]), strict=True):
            edge, vertex = new[fold], self.ends[new[fold], end]
            others = inner.indices[inner.indptr[vertex]:inner.indptr[vertex + 1]]
            others = others[angles[others] >= angles[edge] / 2]
            ways = unit(self.x[self.ends[others].sum(axis=1) - vertex] - self.x[vertex])
            along = ways @ unit(self.x[vertex] - self.x[self.ends[edge, 1 - end]])
            if len(others) and along.max() > np.cos(FOLD):
                found.append(others[along.argmax()])
        return found

    def _patches(self) -> np.ndarray:
        one, other = self._pairs[self.smooth[self.edge[self._pairs[:, 0]]]].T
        alike = self.vertex[one] == self.vertex[other]
        rows = np.concatenate([one, self.after[one]])
        columns = np.concatenate([np.where(alike, other, self.after[other]), np.where(alike, self.after[other], other)])
        size = len(self.vertex)
        graph = coo_array((np.ones(len(rows), dtype=bool), (rows, columns)), shape=(size, size))
        return connected_components(graph, directed=False)[1]

    @cached_property
    def normals(self) -> np.ndarray:
        """Unit normal of each patch at each of its vertices, of either sign, shape (numbers of `patch`, 3)."""
        count = self.patch.max() + 1
        vertex = np.empty(count, dtype=np.int64)
        vertex[self.patch] = self.vertex
        belongs = coo_array((np.ones(len(self.patch)), (self.patch, self.cell))).tocsr()
        around = (belongs @ belongs.T).tocsr()
        few = np.flatnonzero(np.diff(around.indptr) <= ENOUGH)
        wider = (around[few] @ around).tocsr()
        frames, normals = self._frames(count), np.empty((count, 3))
        many = np.setdiff1d(np.arange(count), few)
        for rows, near in ((many, around[many]), (few, wider)):
            for begin in range(0, len(rows), CHUNK):
                chosen = rows[begin:begin + CHUNK]
                normals[chosen] = _fitted(self.x, vertex, chosen, near[begin:begin + CHUNK], frames[chosen])
        return normals

    def _frames(self, count: int) -> np.ndarray:
        """Two directions along each patch at a vertex and a third one across, of the mean of its cells' planes.

        Shape (patches, 3, directions); the weights are the angles of the cells at the vertex.
        """
        before = np.empty_like(self.after)
        before[self.after] = np.arange(len(self.after))
        here = self.x[self.vertex]
        one, other = unit(self.x[self.vertex[self.after]] - here), unit(self.x[self.vertex[before]] - here)
        across = np.cross(one, other)
        weights = np.arccos(np.clip(np.sum(one * other, axis=1), -1.0, 1.0))
        planes = np.zeros((count, 3, 3))
        np.add.at(planes, self.patch, weights[:, None, None] * unit(across)[:, :, None] * unit(across)[:, None])
        return np.linalg.eigh(planes)[1]


def _fitted(x: np.ndarray, vertex: np.ndarray, rows: np.ndarray, near, frames: np.ndarray) -> np.ndarray:
    """Unit normals of quadratic surfaces at the vertices of some rows, by the patches near each."""
    counts = np.diff(near.indptr)
    filled = np.arange(counts.max()) < counts[:, None]
    others = np.repeat(vertex[rows][:, None], counts.max(), axis=1)
    others[filled] = vertex[near.indices]
    filled = others != vertex[rows][:, None]
    offsets = x[others] - x[vertex[rows]][:, None]
    lengths = np.linalg.norm(offsets, axis=2)
    scale = (lengths.sum(axis=1) / filled.sum(axis=1))[:, None]
    a, b, height = np.moveaxis(offsets @ frames, 2, 0) / scale
    weights = np.where(filled, (scale / np.where(filled, lengths, 1.0)) ** 2, 0.0)
    table = np.stack([a, b, a**2, a * b, b**2], axis=2) * weights[..., None]
    slopes = (np.linalg.pinv(table, rcond=RANK) @ (height * weights)[..., None])[:, :2, 0]
    one, other, across = np.moveaxis(frames, 2, 0)
    return unit(across - slopes[:, :1] * one - slopes[:, 1:] * other)


def sharp(angles: np.ndarray, known: np.ndarray, beyond: np.ndarray) -> np.ndarray:
    """Whether something turns too far for a smooth one, or much farther than it is known to turn beyond."""
    return (angles > FOLD) | (known & (angles > TURN) & (angles > SHARP * beyond))


def unit(vectors: np.ndarray) -> np.ndarray:
    """Vectors of length 1; those without length stay."""
    length = np.linalg.norm(vectors, axis=-1, keepdims=True)
    return vectors / np.where(length > 0, length, 1.0)
