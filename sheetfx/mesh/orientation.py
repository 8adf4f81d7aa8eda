"""Cells of a gmsh model that run alike: normals on one side of a surface, tangents in one direction of a curve.

Pressure, offsets, the order of layers and faces of contact go by them. gmsh has a direction for each curve and surface,
which follows from how it was drawn.

Two cells that meet at an edge run alike where they pass it in opposite directions, two cells of curves at a node where
one ends and the other begins. Which pairs are compared:

- cells of one group where it has no third cell there, as at the flanges of an I-section; of curves cells that have the
  same smallest group, so that bars with names of their own keep their direction;
- of surfaces also cells of two groups where no third cell is;
- of three and more surfaces that meet at an edge those two that go on straightest.

Cells then run like the first of all that are connected so. A Möbius strip has no two sides: its cells stay as they are.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from ..compat import gmsh_cells
from ..notices import listed
from .cells import Cells
from .gmsh_model import Model
from .groups import DIMENSIONS

SHOWN = 5  # names in a message
ROUNDING = 1e-6  # difference of cosines that is rounding of the coordinates
GOES_BY_IT = {1: "LinePressure, offsets and the axes of sections", 2: "pressure, offsets, layers and faces of contact"}


@dataclass(frozen=True)
class Alike:
    """Cells of a gmsh model that run alike as far as they can.

    Attributes
    ----------
    nodes : of the cells of each kind, those that ran against their neighbours turned; shapes (cells, nodes)
    said : what has been turned, for a warning; empty where all ran alike
    opposed : group (None: all cells) -> a place where two of its cells run against each other
    """

    nodes: list[np.ndarray]
    said: str
    opposed: dict[str | None, np.ndarray]


def run_alike(model: Model, *kinds: Cells) -> Alike:
    """Turn cells that run against their neighbours, whatever kind these are of."""
    tables, source = [cells.table() for cells in kinds], np.concatenate([cells.source() for cells in kinds])
    names: dict[str, list[int]] = {}
    for cells in kinds:
        for name, on in cells.groups.items():
            names[name] = names.get(name, []) + on
    groups: dict[str | None, np.ndarray] = {name: np.isin(source, on) for name, on in names.items()}
    meets = _Meetings(model, kinds)
    pairs = {name: meets.pairs(inside) for name, inside in sorted(groups.items(), key=lambda item: item[1].sum())}
    pairs[None] = meets.pairs(np.ones(len(source), dtype=bool))
    if meets.surfaces:
        compared = [*pairs.values(), meets.straightest()]
    else:
        own = _smallest(groups)
        compared = [found[own[found[:, 0]] == own[found[:, 1]]] for found in pairs.values()]
    first, turned = _turned(len(source), compared)
    opposed = {name: meets.middle[wrong[0, 0]] for name, found in pairs.items()
               if len(wrong := found[_against(found, turned)])}
    begin = 0
    for cells, nodes in zip(kinds, tables, strict=True):
        own = turned[begin:begin + len(nodes)]
        nodes[own] = nodes[own][:, _reversal(cells.kind, nodes.shape[1])]
        begin += len(nodes)
    return Alike(tables, _said(model, names, meets.surfaces, source[turned], source[first[turned]]), opposed)


class _Meetings:
    """Where cells meet; pairs of them have rows (cell, cell, whether they run against each other).

    Attributes
    ----------
    surfaces : whether cells are of surfaces
    middle : mean place of the corners of each cell
    """

    def __init__(self, model: Model, kinds: Sequence[Cells]):
        corners, self._x = [cells.corners() for cells in kinds], model.x
        self.surfaces = corners[0].shape[1] > 2
        self.middle = np.concatenate([model.x[nodes].mean(axis=1) for nodes in corners])
        self._cell = np.repeat(np.arange(len(self.middle)),
                               np.concatenate([np.full(len(nodes), nodes.shape[1]) for nodes in corners]))
        self._ends = np.concatenate([cells.sides() for cells in kinds])
        if self.surfaces:
            self._facets, self._up = model.pairs(self._ends), self._ends[:, 0] < self._ends[:, 1]
        else:
            self._facets, self._up = corners[0].ravel(), np.tile([True, False], len(corners[0]))

    def pairs(self, inside: np.ndarray) -> np.ndarray:
        """Those at facets where just two of some cells meet."""
        order, starts, counts = self._at_facets(inside)
        begin = starts[counts == 2]
        return self._rows(order[np.column_stack((begin, begin + 1))])

    def straightest(self) -> np.ndarray:
        """Of three and more cells at an edge the two that go on straightest, and so on with the rest."""
        found = []
        order, starts, counts = self._at_facets(np.ones(len(self.middle), dtype=bool))
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
        chosen = np.flatnonzero(inside[self._cell])
        order = chosen[np.argsort(self._facets[chosen], kind="stable")]
        return order, *np.unique(self._facets[order], return_index=True, return_counts=True)[1:]

    def _rows(self, places: np.ndarray) -> np.ndarray:
        return np.column_stack((self._cell[places], self._up[places[:, 0]] == self._up[places[:, 1]]))

    def _ways(self, places: np.ndarray) -> np.ndarray:
        """Unit vectors from an edge into the cells at it, across the edge."""
        start, end = self._x[self._ends[places[0]]]
        along = (end - start) / np.linalg.norm(end - start)
        ways = self.middle[self._cell[places]] - (start + end) / 2
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


def _said(model: Model, groups: dict[str, list[int]], surfaces: bool, turned: np.ndarray, like: np.ndarray) -> str:
    """What has been turned, from the entities of turned cells and of those that they now run like."""
    if not len(turned):
        return ""
    dimension = 2 if surfaces else 1
    names = listed([repr(name) for name, on in groups.items() if np.isin(turned, on).any()], SHOWN)
    return (f"{model.what}: {len(turned)} cells of {names} ran against their neighbours and are turned, to run like "
            f"those of {DIMENSIONS[dimension][:-1]} {listed(list(map(str, np.unique(like))), SHOWN)}; "
            f"{GOES_BY_IT[dimension]} go by it")
