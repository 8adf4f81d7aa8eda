"""Partition of meshes with junctions, where more than two cells meet at a facet, and of bars on surfaces.

DOLFINx 0.9 takes a facet with two cells on one process for an inner one and splits it from further cells on another
process, so that structures come apart at junctions.
"""

from __future__ import annotations

import basix
import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from ..compat import adjacency_list, default_partition

Pairs = tuple[np.ndarray, np.ndarray]


def keep_junctions_whole(comm, parts: int, cell_types, cells):
    """DOLFINx's own partition, but with all cells around a junction on one process.

    To be given to `dolfinx.mesh.create_mesh` as its partitioner; process 0 has all cells.
    """
    chosen = default_partition(comm, parts, cell_types, cells)
    first = _first(len(chosen.array), _junctions(getattr(basix.CellType, cell_types[0].name), cells[0]))
    return adjacency_list(chosen.array[first].reshape(-1, 1))


class BarsOnSurfaces:
    """Partitions of a mesh of surfaces, and after it of a mesh of bars that share nodes with them.

    Each cell of a bar is on a process that has a cell of the surfaces at each node that they share.

    Parameters
    ----------
    bars : nodes at the ends of the cells of bars, shape (cells, 2)
    """

    def __init__(self, bars: np.ndarray):
        self._bars = bars
        self._processes: dict[tuple[int, ...], int] = {}

    def surfaces(self, comm, parts: int, cell_types, cells):
        """To be given to `create_mesh` for the surfaces, as `keep_junctions_whole`."""
        chosen = default_partition(comm, parts, cell_types, cells).array
        cell, count, bars = getattr(basix.CellType, cell_types[0].name), len(chosen), len(self._bars)
        joined_bars, junctions = _junctions(basix.CellType.interval, self._bars)
        hosts, hosted = _hosts(cells[0].reshape(count, len(basix.topology(cell)[0])), self._bars)
        meetings = np.concatenate([hosts, count + np.arange(bars)]), np.concatenate([hosted, np.arange(bars)])
        first = _first(count + bars, _junctions(cell, cells[0]), (count + joined_bars, junctions), meetings)
        self._processes = {tuple(sorted(nodes)): int(chosen[c])
                           for nodes, c in zip(self._bars.tolist(), first[count:], strict=True) if c < count}
        return adjacency_list(chosen[first[:count]].reshape(-1, 1))

    def bars(self, comm, parts: int, cell_types, cells):
        """To be given to `create_mesh` for the bars; DOLFINx chooses for those that meet no surface."""
        chosen = keep_junctions_whole(comm, parts, cell_types, cells).array
        followed = [self._processes.get(tuple(sorted(nodes)), own)
                    for nodes, own in zip(cells[0].reshape(-1, 2).tolist(), chosen.tolist(), strict=True)]
        return adjacency_list(np.array(followed, dtype=chosen.dtype).reshape(-1, 1))


def _junctions(cell: basix.CellType, corners: np.ndarray) -> Pairs:
    """Numbers of cells and of the junctions that they meet at, a pair for each side of a cell at a junction."""
    topology = basix.topology(cell)
    facets = np.sort(corners.reshape(-1, len(topology[0]))[:, topology[-2]], axis=2)
    _, number, cells = np.unique(facets.reshape(-1, facets.shape[2]), axis=0, return_inverse=True, return_counts=True)
    sides = np.flatnonzero(cells[number] > 2)
    return sides // facets.shape[1], number[sides]


def _hosts(corners: np.ndarray, bars: np.ndarray) -> Pairs:
    """Numbers of cells of surfaces and of the bars that they host.

    A bar is hosted by a cell at both its ends, or else by one at each end that is on the surfaces.
    """
    at: dict[int, set[int]] = {node: set() for node in bars.ravel().tolist()}
    for cell, node in np.argwhere(np.isin(corners, bars)).tolist():
        at[int(corners[cell, node])].add(cell)
    pairs = []
    for bar, (a, b) in enumerate(bars.tolist()):
        common = at[a] & at[b]
        pairs += [(min(cells), bar) for cells in ([common] if common else [at[a], at[b]]) if cells]
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
