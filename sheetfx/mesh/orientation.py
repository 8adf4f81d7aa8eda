"""Cells of a gmsh model that run alike: normals on one side of a surface, tangents in one direction of a curve.

Pressure, offsets, the order of layers and faces of contact go by them. gmsh has a direction for each curve and surface,
which follows from how it was drawn.

Two cells that meet at an edge run alike where they pass it in opposite directions, two cells of curves at a node where
one ends and the other begins. Which pairs are compared:

- those of one group where it has no third cell there, as at the flanges of an I-section; of curves those that have the
  same smallest group, so that bars with names of their own keep their direction;
- of surfaces also those of two groups where no third cell is;
- of three and more surfaces that meet at an edge those two that go on straightest.

Cells then run like the first of all that are connected so. A Möbius strip has no two sides: its cells stay as they are.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from ..compat import gmsh_cells
from ..notices import listed
from .cells import KINDS, Cells
from .gmsh_model import DIMENSIONS, Model

SHOWN = 5  # names in a message
ROUNDING = 1e-6  # difference of cosines that is rounding of the coordinates
GOES_BY_IT = {1: "LinePressure, offsets and the axes of sections", 2: "pressure, offsets, layers and faces of contact"}


@dataclass(frozen=True)
class Alike:
    """Cells of a gmsh model that run alike as far as they can.

    Attributes
    ----------
    nodes : of all cells, those that ran against their neighbours turned; shape (cells, nodes)
    said : what has been turned, for a warning; empty where all ran alike
    opposed : group (None: all cells) -> a place where two of its cells run against each other
    """

    nodes: np.ndarray
    said: str
    opposed: dict[str | None, np.ndarray]


def run_alike(model: Model, cells: Cells) -> Alike:
    """Turn cells that run against their neighbours."""
    nodes, source = cells.table(), cells.source()
    groups: dict[str | None, np.ndarray] = {name: np.isin(source, on) for name, on in cells.groups.items()}
    meets = _Meetings(model, cells)
    pairs = {name: meets.pairs(inside) for name, inside in sorted(groups.items(), key=lambda item: item[1].sum())}
    pairs[None] = meets.pairs(np.ones(len(nodes), dtype=bool))
    if meets.surfaces:
        compared = [*pairs.values(), meets.straightest()]
    else:
        own = _smallest(groups)
        compared = [found[own[found[:, 0]] == own[found[:, 1]]] for found in pairs.values()]
    first, turned = _turned(len(nodes), compared)
    opposed = {name: model.x[nodes[wrong[0, 0]]].mean(axis=0) for name, found in pairs.items()
               if len(wrong := found[_against(found, turned)])}
    nodes[turned] = nodes[turned][:, _reversal(cells.kind, nodes.shape[1])]
    return Alike(nodes, _said(model, cells, source[turned], source[first[turned]]), opposed)


class _Meetings:
    """Where cells meet; pairs of them have rows (cell, cell, whether they run against each other)."""

    def __init__(self, model: Model, cells: Cells):
        self._corners, self._model = cells.corners(), model
        self.surfaces = self._corners.shape[1] > 2
        following = np.roll(self._corners, -1, axis=1)
        facets = model.edges() if self.surfaces else self._corners
        up = self._corners < following if self.surfaces else np.broadcast_to([True, False], facets.shape)
        self._width, self._facets, self._up = facets.shape[1], facets.ravel(), up.ravel()

    def pairs(self, inside: np.ndarray) -> np.ndarray:
        """Those at facets where just two of some cells meet."""
        order, starts, counts = self._at_facets(inside)
        begin = starts[counts == 2]
        return self._rows(order[np.column_stack((begin, begin + 1))])

    def straightest(self) -> np.ndarray:
        """Of three and more cells at an edge the two that go on straightest, and so on with the rest."""
        found = []
        order, starts, counts = self._at_facets(np.ones(len(self._corners), dtype=bool))
        for start, count in zip(starts[counts > 2], counts[counts > 2], strict=True):
            places = order[start:start + count]
            ways = self._ways(places)
            straight = sorted((-float(ways[i] @ ways[j]), i, j) for i, j in combinations(range(count), 2))
            while straight:
                best, *both = straight.pop()
                rivals = [value for value, *two in straight if set(two) & set(both)]
                if best <= ROUNDING or best - max(rivals, default=-1.0) < ROUNDING:
                    break
                found.append(places[both])
                straight = [(value, *two) for value, *two in straight if not set(two) & set(both)]
        return self._rows(np.array(found, dtype=np.int64).reshape(-1, 2))

    def _at_facets(self, inside: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Places of chosen cells in the table of facets, facet by facet, and where those of each begin and how many."""
        chosen = np.flatnonzero(np.repeat(inside, self._width))
        order = chosen[np.argsort(self._facets[chosen], kind="stable")]
        return order, *np.unique(self._facets[order], return_index=True, return_counts=True)[1:]

    def _rows(self, places: np.ndarray) -> np.ndarray:
        return np.column_stack((places // self._width, self._up[places[:, 0]] == self._up[places[:, 1]]))

    def _ways(self, places: np.ndarray) -> np.ndarray:
        """Unit vectors from an edge into the cells at it, across the edge."""
        cells, sides = np.divmod(places, self._width)
        x = self._model.x[self._corners[cells]]
        start, end = x[0, sides[0]], x[0, (sides[0] + 1) % self._width]
        along = (end - start) / np.linalg.norm(end - start)
        ways = x.mean(axis=1) - (start + end) / 2
        ways -= np.outer(ways @ along, along)
        return ways / np.linalg.norm(ways, axis=1, keepdims=True)


def _smallest(groups: dict[str | None, np.ndarray]) -> np.ndarray:
    """Number of the smallest group that each cell is in."""
    inside = np.array(list(groups.values()))
    return np.where(inside, inside.sum(axis=1, keepdims=True), inside.shape[1] + 1).argmin(axis=0)


def _against(pairs: np.ndarray, turned: np.ndarray) -> np.ndarray:
    """Whether the two of each pair run against each other once some cells are turned."""
    return (pairs[:, 2] != 0) ^ turned[pairs[:, 0]] ^ turned[pairs[:, 1]]


def _turned(count: int, compared: list[np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
    """The first of the cells that each is connected with, and whether it is to be turned.

    Pairs that make a Möbius strip of those before them are left out.
    """
    taken = compared
    if _twisted(count, taken):
        taken = []
        for pairs in compared:
            taken = taken if _twisted(count, [*taken, pairs]) else [*taken, pairs]
    as_it_is, other_way = _pieces(count, taken)
    _, first, which = np.unique(np.minimum(as_it_is, other_way), return_index=True, return_inverse=True)
    first = first[which.ravel()]
    return first, as_it_is != as_it_is[first]


def _twisted(count: int, compared: list[np.ndarray]) -> bool:
    as_it_is, other_way = _pieces(count, compared)
    return bool((as_it_is == other_way).any())


def _pieces(count: int, compared: list[np.ndarray]) -> np.ndarray:
    """Pieces of a graph in which each cell stands twice: as it is, and turned; shape (2, cells)."""
    one, other, against = np.concatenate([np.empty((0, 3), dtype=np.int64), *compared]).T
    rows = np.concatenate([one, one + count])
    columns = np.concatenate([other + count * against, other + count * (1 - against)])
    graph = coo_array((np.ones(len(rows)), (rows, columns)), shape=(2 * count, 2 * count))
    return connected_components(graph, directed=False)[1].reshape(2, count)


def _reversal(kind: int, count: int) -> np.ndarray:
    """Which of gmsh's nodes of a cell stands at each place once the cell runs the other way."""
    element, order = gmsh_cells(kind, np.arange(count)[None])
    points = element.points
    mirrored = 1 - points if points.shape[1] == 1 else points[:, ::-1]
    swapped = np.abs(points[None] - mirrored[:, None]).sum(axis=2).argmin(axis=1)
    nodes = np.empty(count, dtype=np.int64)
    nodes[order[0]] = order[0][swapped]
    return nodes


def _said(model: Model, cells: Cells, turned: np.ndarray, like: np.ndarray) -> str:
    """What has been turned, from the entities of turned cells and of those that they now run like."""
    if not len(turned):
        return ""
    dimension = 1 if KINDS[cells.kind][1] == 2 else 2
    names = listed([repr(name) for name, on in cells.groups.items() if np.isin(turned, on).any()], SHOWN)
    return (f"{model.what}: {len(turned)} cells of {names} ran against their neighbours and are turned, to run like "
            f"those of {DIMENSIONS[dimension][:-1]} {listed(list(map(str, np.unique(like))), SHOWN)}; "
            f"{GOES_BY_IT[dimension]} go by it")
