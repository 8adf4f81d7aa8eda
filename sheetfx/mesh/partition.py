"""Partition of meshes with junctions, where more than two cells meet at a facet, and of two meshes with common nodes.

DOLFINx 0.9 takes a facet with two cells on one process for an inner one and splits it from further cells on another
process, so that structures come apart at junctions.
"""

from __future__ import annotations

from collections import Counter
from itertools import chain, combinations

import basix
import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from ..compat import adjacency_list, default_partition

CELLS = {2: basix.CellType.interval, 3: basix.CellType.triangle}  # by corners
Pairs = tuple[np.ndarray, np.ndarray]


def keep_junctions_whole(comm, parts: int, cell_types, cells):
    """DOLFINx's own partition, but with all cells around a junction on one process.

    To be given to `dolfinx.mesh.create_mesh` as its partitioner; process 0 has all cells.
    """
    chosen = default_partition(comm, parts, cell_types, cells)
    first = _first(len(chosen.array), _junctions(getattr(basix.CellType, cell_types[0].name), cells[0]))
    return adjacency_list(chosen.array[first].reshape(-1, 1))


class Hosted:
    """Partitions of a mesh of surfaces, the hosts, and after it of a mesh of guests that share nodes with them.

    Each guest is on a process that has a host at each node and edge that they share.

    Parameters
    ----------
    guests : nodes at the corners of cells, bars or other surfaces, shape (cells, corners)
    """

    def __init__(self, guests: np.ndarray):
        self._guests = guests
        self._processes: dict[tuple[int, ...], int] = {}

    def hosts(self, comm, parts: int, cell_types, cells):
        """To be given to `create_mesh` for the hosts, as `keep_junctions_whole`."""
        chosen = default_partition(comm, parts, cell_types, cells).array
        cell, count, guests = getattr(basix.CellType, cell_types[0].name), len(chosen), len(self._guests)
        joined_guests, junctions = _junctions(CELLS[self._guests.shape[1]], self._guests)
        hosts, hosted = _hosts(cells[0].reshape(count, len(basix.topology(cell)[0])), self._guests)
        meetings = np.concatenate([hosts, count + np.arange(guests)]), np.concatenate([hosted, np.arange(guests)])
        first = _first(count + guests, _junctions(cell, cells[0]), (count + joined_guests, junctions), meetings)
        self._processes = {tuple(sorted(nodes)): int(chosen[c])
                           for nodes, c in zip(self._guests.tolist(), first[count:], strict=True) if c < count}
        return adjacency_list(chosen[first[:count]].reshape(-1, 1))

    def guests(self, comm, parts: int, cell_types, cells):
        """To be given to `create_mesh` for the guests; DOLFINx chooses for those that meet no host."""
        chosen = keep_junctions_whole(comm, parts, cell_types, cells).array
        followed = [self._processes.get(tuple(sorted(nodes)), own) for nodes, own in
                    zip(cells[0].reshape(-1, self._guests.shape[1]).tolist(), chosen.tolist(), strict=True)]
        return adjacency_list(np.array(followed, dtype=chosen.dtype).reshape(-1, 1))


def _junctions(cell: basix.CellType, corners: np.ndarray) -> Pairs:
    """Numbers of cells and of the junctions that they meet at, a pair for each side of a cell at a junction."""
    topology = basix.topology(cell)
    facets = np.sort(corners.reshape(-1, len(topology[0]))[:, topology[-2]], axis=2)
    _, number, cells = np.unique(facets.reshape(-1, facets.shape[2]), axis=0, return_inverse=True, return_counts=True)
    sides = np.flatnonzero(cells[number] > 2)
    return sides // facets.shape[1], number[sides]


def _hosts(corners: np.ndarray, guests: np.ndarray) -> Pairs:
    """Numbers of cells of surfaces and of the guests that they host.

    Each guest has hosts at all nodes and edges that it shares: first the one at most of these, then that at most of
    the rest.
    """
    at: dict[int, set[int]] = {node: set() for node in guests.ravel().tolist()}
    for cell, node in np.argwhere(np.isin(corners, guests)).tolist():
        at[int(corners[cell, node])].add(cell)
    pairs = []
    for guest, nodes in enumerate(guests.tolist()):
        left = [near for near in (*(at[node] for node in nodes), *(at[a] & at[b] for a, b in combinations(nodes, 2)))
                if near]
        while left:
            shared = Counter(chain.from_iterable(left))
            host = min(shared, key=lambda cell: (-shared[cell], cell))
            left = [near for near in left if host not in near]
            pairs.append((host, guest))
    hosts, hosted = np.array(pairs, dtype=np.int64).reshape(-1, 2).T
    return hosts, hosted


def _first(count: int, *meetings: Pairs) -> np.ndarray:
    """For each of so many cells the first one of its group; cells that meet are of one group.

    Each item of `meetings` has pairs of a cell and the number of the place at which it meets others.
    """
    cells, places, size = [], [], count
    for of, at in meetings:
        cells.append(of)
        places.append(size + at)
        size += int(at.max(initial=-1)) + 1
    pairs = np.concatenate(cells), np.concatenate(places)
    groups = connected_components(coo_array((np.ones(len(pairs[0])), pairs), shape=(size, size)), directed=False)[1]
    _, first, group = np.unique(groups[:count], return_index=True, return_inverse=True)
    return first[group]
