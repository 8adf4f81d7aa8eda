"""First-order cells of curved surfaces raised to second or third order.

Flat facets of a thin shell are too stiff in waves of their size, whatever the form. Of each edge there is made a cubic
curve that leaves its ends along tangents t_i and t_j; its middle is (t_i - t_j) / 8 off the chord's. Where the
tangents come from:

- inside a smooth patch (`facets`) the chord is turned into the tangent plane of each end;
- at the border of patches, and at free edges, tangents touch the circle through a vertex and the two beside it along
  the border, so that all cells there have one curve. Corners and junctions of borders stop it; the last edge before one
  is a circle's arc.

Tangents have the length by which the middle is a circle's arc's. Inner nodes follow from nodes on edges (Coons;
of cubic triangles by precision for quadratic surfaces).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..compat import gmsh_cells
from ..notices import listed
from .cells import Cells
from .facets import Facets, sharp, unit
from .quality import STRAIGHT, scaled_jacobians

RAISED = {1: {2: 8, 3: 26}, 2: {2: 9, 3: 21}, 3: {2: 10, 3: 36}}  # gmsh's numbers of kinds of cells, by order
NONE = 1e-9  # rise, over the size of the structure, that is rounding
SHOWN = 5  # names in a message


@dataclass(frozen=True)
class Raised:
    """Cells of a higher order.

    Attributes
    ----------
    x : places of all nodes, those that there were first
    curves, surfaces : their cells; of surfaces of each kind
    said : what was done, for a warning; empty where all are straight
    """

    x: np.ndarray
    curves: Cells
    surfaces: list[Cells]
    said: str


def raise_order(x: np.ndarray, surfaces: Sequence[Cells], curves: Cells, order: int | None) -> Raised | None:
    """Raise cells of first order.

    Parameters
    ----------
    x : places of nodes, shape (n, 3)
    surfaces : of each kind
    order : 2 or 3; None: 2 where a surface is curved, and of curves only where they are edges of that; nothing where
        all surfaces are flat between folds
    """
    facets = Facets(x, [cells.table() for cells in surfaces], np.concatenate([cells.source() for cells in surfaces]))
    degree = order or 2
    size = float(np.linalg.norm(np.nanmax(x, axis=0) - np.nanmin(x, axis=0)))
    edges = _Curves(facets)
    edges.straighten(edges.rises <= NONE * size)
    if not edges.rises[facets.smooth].any():
        edges.straighten(edges.rises > 0)
        if order is None:
            return None
    nodes = _Nodes(edges, degree)
    raised = nodes.surfaces(surfaces)
    while (bad := edges.rises.astype(bool) & edges.of_cells(_bad(nodes.x, raised, size))).any():
        edges.straighten(bad)
        nodes = _Nodes(edges, degree)
        raised = nodes.surfaces(surfaces)
    if order or (curves.nodes and edges.rises[nodes.on_edges(curves.table())].any()):
        curves = nodes.curves(curves)
    return Raised(nodes.x, curves, raised, _said(edges, surfaces, degree))


class _Curves:
    """Curves of the edges of cells, from the smaller to the larger number of their ends.

    Attributes
    ----------
    tangents : at both ends, shape (edges, 2, 3)
    """

    def __init__(self, facets: Facets):
        self.facets = facets
        ends = facets.x[facets.ends]
        self.chords = ends[:, 1] - ends[:, 0]
        self.tangents = _along(self.chords[:, None], self._within_patches())
        border = np.flatnonzero(~facets.smooth)
        along = _along_borders(facets.x, facets.ends[border], unit(self.chords[border]))
        known = np.isfinite(along).all(axis=(1, 2))
        self.tangents[border[known]] = _along(self.chords[border[known], None], along[known])

    def _within_patches(self) -> np.ndarray:
        """Chords turned into the tangent planes at their ends, the mean of the cells at each edge."""
        facets = self.facets
        begin, end = facets.patch, facets.patch[facets.after]
        upward = facets.vertex < facets.vertex[facets.after]
        patches = np.where(upward[:, None], np.column_stack((begin, end)), np.column_stack((end, begin)))
        normals, chords = facets.normals[patches], self.chords[facets.edge][:, None]
        turned = unit(chords - np.sum(chords * normals, axis=2, keepdims=True) * normals)
        sums = np.zeros((len(facets.ends), 2, 3))
        np.add.at(sums, facets.edge, turned)
        return unit(sums)

    @property
    def rises(self) -> np.ndarray:
        """Distance of the middle of each edge from its chord's."""
        return np.linalg.norm(self.tangents[:, 0] - self.tangents[:, 1], axis=1) / 8

    def straighten(self, chosen: np.ndarray) -> None:
        """Make some edges straight."""
        self.tangents[chosen] = self.chords[chosen, None]

    def of_cells(self, chosen: np.ndarray) -> np.ndarray:
        """Whether each edge is one of some cells."""
        found = np.zeros(len(self.chords), dtype=bool)
        found[self.facets.edge[chosen[self.facets.cell]]] = True
        return found

    def at(self, share: float) -> np.ndarray:
        """Places at a share of the way along each edge."""
        begin, end = np.moveaxis(self.tangents - self.chords[:, None], 1, 0)
        off = share * (1 - share) * ((1 - share) * begin - share * end)
        return self.facets.x[self.facets.ends[:, 0]] + share * self.chords + off


class _Nodes:
    """Places of the nodes of raised cells, and cells with these: first those that there are, then those on edges."""

    def __init__(self, edges: _Curves, order: int):
        self._edges, self._order = edges.facets, order
        self._width = order - 1
        self._first, self._keys = len(edges.facets.x), edges.facets.ends @ [len(edges.facets.x), 1]
        self.x = np.concatenate([edges.facets.x, np.stack(
            [edges.at(k / order) for k in range(1, order)], axis=1).reshape(-1, 3)])

    def _add(self, places: np.ndarray) -> np.ndarray:
        """Numbers of new nodes at places, shape (cells, nodes, 3)."""
        numbers = len(self.x) + np.arange(places.shape[0] * places.shape[1])
        self.x = np.concatenate([self.x, places.reshape(-1, 3)])
        return numbers.reshape(places.shape[:2])

    def _on_edges(self, edge: np.ndarray, upward: np.ndarray) -> np.ndarray:
        numbers = self._first + self._width * edge[:, None] + np.arange(self._width)
        return np.where(upward[:, None], numbers, numbers[:, ::-1])

    def surfaces(self, kinds: Sequence[Cells]) -> list[Cells]:
        """Cells of each kind with nodes at their corners, then on their edges in order around them, then inside."""
        facets, found, begin = self._edges, [], 0
        sides = self._on_edges(facets.edge, facets.vertex < facets.vertex[facets.after])
        for cells in kinds:
            table = cells.table()
            around = sides[begin:begin + table.size].reshape(*table.shape, self._width)
            inner = self._add(_inner(self.x[table], self.x[around]))
            found.append(_replaced(cells, np.column_stack((table, around.reshape(len(table), -1), inner)), self._order))
            begin += table.size
        return found

    def on_edges(self, curves: np.ndarray) -> np.ndarray:
        """Numbers of the edges that some curves lie on, without those that lie on none."""
        keys = np.sort(curves, axis=1) @ [self._first, 1]
        return np.flatnonzero(np.isin(self._keys, keys))

    def curves(self, cells: Cells) -> Cells:
        """Curves with the nodes of the edges that they lie on, and others that stay straight."""
        if not cells.nodes:
            return cells
        table = cells.table()
        keys = np.sort(table, axis=1) @ [self._first, 1]
        edge = np.minimum(np.searchsorted(self._keys, keys), len(self._keys) - 1)
        nodes, free = self._on_edges(edge, table[:, 0] < table[:, 1]), self._keys[edge] != keys
        begin, end = np.moveaxis(self.x[table[free]], 1, 0)
        shares = np.arange(1, self._order) / self._order
        nodes[free] = self._add(begin[:, None] + shares[:, None] * (end - begin)[:, None])
        return _replaced(cells, np.column_stack((table, nodes)), self._order)


def _replaced(cells: Cells, table: np.ndarray, order: int) -> Cells:
    """Cells with other nodes."""
    entities = sorted(cells.nodes)
    parts = np.split(table, np.cumsum([len(cells.nodes[e]) for e in entities])[:-1])
    return replace(cells, nodes=dict(zip(entities, parts, strict=True)), kind=RAISED[cells.kind][order])


def _inner(corners: np.ndarray, around: np.ndarray) -> np.ndarray:
    """Places of the inner nodes of cells, shape (cells, nodes, 3).

    Parameters
    ----------
    corners : shape (cells, corners, 3)
    around : those on the edges in order around the cells, shape (cells, corners, nodes of an edge, 3)
    """
    inside = around.shape[2]
    if corners.shape[1] == 3:
        return (around.sum(axis=(1, 2)) / 4 - corners.sum(axis=1) / 6)[:, None][:, :inside - 1]
    near, far = 1 / (inside + 1), inside / (inside + 1)

    def at(k):
        return corners[:, k % 4]

    def by(k, n):
        return around[:, k % 4, n]

    return np.stack([far * by(k, 0) + near * by(k + 2, -1) + far * by(k - 1, -1) + near * by(k + 1, 0)
                     - far * far * at(k) - far * near * (at(k + 1) + at(k - 1)) - near * near * at(k + 2)
                     for k in range(4)], axis=1)[:, :inside**2]


def _along(chords: np.ndarray, directions: np.ndarray) -> np.ndarray:
    """Tangents of unit directions with the length by which an arc's middle is right: 2 |d| / (1 + cos)."""
    length = np.linalg.norm(chords, axis=-1, keepdims=True)
    return 2 * length**2 * directions / (length + np.sum(chords * directions, axis=-1, keepdims=True))


def _along_borders(x: np.ndarray, ends: np.ndarray, chords: np.ndarray) -> np.ndarray:
    """Unit tangents at both ends of the edges of borders, shape (edges, 2, 3); not numbers where no other edge tells.

    Parameters
    ----------
    ends : numbers of vertices, shape (edges, 2)
    chords : unit vectors from the first to the second
    """
    vertices = ends.ravel()
    order = np.argsort(vertices, kind="stable")
    _, begin, counts = np.unique(vertices[order], return_index=True, return_counts=True)
    pairs = order[begin[counts == 2][:, None] + [0, 1]]  # numbers of ends that meet with one other
    edge, end = np.divmod(pairs, 2)
    out = np.where(end == 0, 1.0, -1.0)[..., None] * chords[edge]  # away from the vertex
    length = np.linalg.norm(x[ends[edge, 1]] - x[ends[edge, 0]], axis=2, keepdims=True)
    angles = 2 * np.arcsin(np.minimum(np.linalg.norm(out.sum(axis=1), axis=1) / 2, 1.0))
    turns = np.full(len(x), np.nan)
    turns[vertices[pairs[:, 0]]] = angles
    beyond = turns[ends[edge, 1 - end]]
    known = np.isfinite(beyond).any(axis=1)
    largest = np.nanmax(np.where(known[:, None], beyond, 0.0), axis=1)
    through = ~sharp(angles, known, largest)
    pairs, out, length = pairs[through], out[through], length[through]
    tangents = np.full((ends.size, 3), np.nan)
    from_one_to_other = unit(out[:, 1] / length[:, 1] - out[:, 0] / length[:, 0])
    for k, sign in ((0, -1.0), (1, 1.0)):
        upward = np.where(pairs[:, k] % 2 == 0, sign, -sign)
        tangents[pairs[:, k]] = upward[:, None] * from_one_to_other
    tangents = tangents.reshape(-1, 2, 3)
    mirrored = 2 * np.sum(tangents * chords[:, None], axis=2, keepdims=True) * chords[:, None] - tangents
    return np.where(np.isfinite(tangents), tangents, mirrored[:, ::-1])


def _bad(x: np.ndarray, kinds: Sequence[Cells], size: float) -> np.ndarray:
    """Whether each cell is folded over."""
    found = [gmsh_cells(cells.kind, cells.table()) for cells in kinds]
    return np.concatenate([scaled_jacobians(element, x[nodes], size)[0] <= STRAIGHT for element, nodes in found])


def _said(edges: _Curves, kinds: Sequence[Cells], order: int) -> str:
    bent = edges.rises > 0
    raised = np.unique(edges.facets.cell[bent[edges.facets.edge]])
    if not len(raised):
        return ""
    on = np.concatenate([cells.source() for cells in kinds])[raised]
    groups = dict.fromkeys(item for cells in kinds for name, entities in cells.groups.items()
                           for item in [repr(name)] if np.isin(on, entities).any())
    names = listed(list(groups), SHOWN)
    return (f"raised {len(raised)} flat cells of {names} to order {order}, by normals fitted to their neighbours; "
            f"largest rise {edges.rises.max():.3g} (order=1 leaves them flat)")
