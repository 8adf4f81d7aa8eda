"""Where points of one mesh lie in the cells of another, on any number of processes."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

import numpy as np

from .projection import EVIDENT, Cells
from .reader import NamedMesh

PULLED = 1e-3  # of the way to the middle of its cell, by which a point shows on which side of a slit it is


class Places:
    """The closest places in one mesh to points in cells of another mesh.

    A point is looked for in cells of the groups that both meshes have and that its own cell is in, and from the side of
    its own cell: leaves and edges of slits that lie upon each other are told apart.

    Parameters
    ----------
    mesh : to look in
    other : mesh of the points
    cells, points : of each point of this process a cell of `other` that it is in, and the point, shape (n, dimension)
    """

    def __init__(self, mesh: NamedMesh, other: NamedMesh, cells: np.ndarray, points: np.ndarray):
        self._comm = mesh.comm
        names = sorted(mesh.cells.keys() & other.cells.keys())
        middles = Cells(other, np.arange(_known(other))).middles[cells]
        asked = self._comm.allgather((points, points + PULLED * (middles - points), _marks(other, names)[cells]))
        self._starts = np.cumsum([0, *(len(one[0]) for one in asked)])
        places, pulled, marks = (np.concatenate(part) for part in zip(*asked, strict=True))
        own = _marks(mesh, names)[:len(mesh.group(None))]
        self._cells, self._reference = np.zeros(len(places), dtype=np.int64), np.zeros((len(places), _width(mesh)))
        distances = np.full(len(places), np.inf)
        for wanted, chosen in self._groups(marks, own):
            part = Cells(mesh, chosen)
            if len(chosen):
                which, self._reference[wanted], distances[wanted] = _closest(part, places[wanted], pulled[wanted])
                self._cells[wanted] = chosen[which]
        winners = np.argmin(self._comm.allgather(distances), axis=0)
        self._mine = winners == self._comm.rank

    def _groups(self, marks: np.ndarray, own: np.ndarray) -> Iterator[tuple[np.ndarray, np.ndarray]]:
        """Points of one set of groups after the other, and the cells of this process to look in."""
        for mark in np.unique(marks):
            chosen = np.flatnonzero(own == mark)
            if not self._comm.allreduce(len(chosen)):
                chosen = np.arange(len(own))
            yield np.flatnonzero(marks == mark), chosen

    def values(self, of: Callable[[np.ndarray, np.ndarray], np.ndarray]) -> np.ndarray:
        """Values at the points of this process.

        Parameters
        ----------
        of : values in cells of this process at reference points in them, one row for each
        """
        ranks = [np.arange(start, end)[self._mine[start:end]] for start, end in zip(
            self._starts[:-1], self._starts[1:], strict=True)]
        every = np.concatenate(ranks)
        found = of(self._cells[every], np.ascontiguousarray(self._reference[every]))
        ends = np.cumsum([len(rows) for rows in ranks])[:-1]
        sent = [(rows - start, values) for rows, start, values in zip(
            ranks, self._starts[:-1], np.split(found, ends), strict=True)]
        count = self._starts[self._comm.rank + 1] - self._starts[self._comm.rank]
        out = np.zeros((count, *found.shape[1:]))
        for rows, values in self._comm.alltoall(sent):
            out[rows] = values
        return out


def _known(mesh: NamedMesh) -> int:
    """Number of cells that this process has or has as ghosts."""
    index_map = mesh.domain.topology.index_map(mesh.domain.topology.dim)
    return int(index_map.size_local + index_map.num_ghosts)


def _width(mesh: NamedMesh) -> int:
    return int(mesh.domain.topology.dim)


def _marks(mesh: NamedMesh, names: Sequence[str]) -> np.ndarray:
    """Of each cell a number that tells which of the named groups it is in; ghosts are in none."""
    marks = np.zeros(_known(mesh), dtype=object)
    for n, name in enumerate(names):
        marks[mesh.cells[name]] += 1 << n
    return marks


def _closest(part: Cells, points: np.ndarray, pulled: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Cells closest to points, on the side that these are pulled to, with reference points and distances."""
    which = part.closest(pulled)[0]
    reference = part.nearest(which, points)
    distances = np.linalg.norm(part.places(which, reference) - points, axis=1)
    off = np.flatnonzero(distances > EVIDENT * part.mesh.size)
    if len(off):
        others = part.closest(points[off])
        nearer = others[2] < distances[off] - EVIDENT * part.mesh.size
        for values, found in zip((which, reference, distances), others, strict=True):
            values[off[nearer]] = found[nearer]
    return which, reference, distances
