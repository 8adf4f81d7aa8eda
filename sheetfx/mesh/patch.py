"""Surfaces as neighbouring cells, over which points slide from one cell to the next."""

from __future__ import annotations

import basix
import numpy as np

from .projection import Cells


class Patch:
    """Cells of surfaces, and which one is beyond each of their borders.

    Where more than two cells have a border in common, a surface goes on in the cell that bends least.

    Parameters
    ----------
    cells : Cells of a mesh of surfaces

    Attributes
    ----------
    slopes, starts : margins of a cell are starts + slopes . reference, which are positive inside and zero at a border
    beyond : shape (cells, borders), the cell beyond a border; -1: none
    enters : shape (cells, borders), the border of that cell through which it is entered
    flips : shape (cells, borders), -1 where the normal of that cell is on the other side of the surface, else 1
    reversed : shape (cells, borders), whether the border goes the other way in that cell
    straight : shape (cells, borders), cosine of the angle by which the surface bends there
    ends : shape (borders, 2, 2), reference points between which borders go
    vertices : shape (cells, borders, 2), numbers of the mesh's vertices at these
    """

    def __init__(self, cells: Cells):
        self.cells = cells
        corners, borders = basix.geometry(cells.kind), basix.topology(cells.kind)[1]
        self.ends = np.array([corners[b] for b in borders])
        along = self.ends[:, 1] - self.ends[:, 0]
        inward = corners.mean(axis=0) - self.ends[:, 0]
        self._turns = np.sign(along[:, 0] * inward[:, 1] - along[:, 1] * inward[:, 0])
        self.slopes = self._turns[:, None] * np.column_stack((-along[:, 1], along[:, 0]))
        self.starts = -(self.slopes * self.ends[:, 0]).sum(axis=1)
        self._link(np.array(borders))

    def _link(self, borders: np.ndarray) -> None:
        topology, cells = self.cells.mesh.domain.topology, self.cells.cells
        topology.create_connectivity(2, 0)
        vertices = topology.connectivity(2, 0).array.reshape(-1, len(borders))[cells]
        shape = len(cells), len(borders)
        self.beyond, self.enters = np.full(shape, -1), np.zeros(shape, dtype=np.int64)
        self.flips, self.straight = np.ones(shape), np.full(shape, -1.0)
        self.reversed, self.vertices = np.zeros(shape, dtype=bool), vertices[:, borders]
        pairs = np.sort(self.vertices, axis=2)
        inward = self._inward()
        at: dict[tuple[int, int], list[tuple[int, int]]] = {}
        for number in range(len(cells)):
            for border, (one, two) in enumerate(pairs[number]):
                at.setdefault((int(one), int(two)), []).append((number, border))
        for meeting in at.values():
            for here in meeting:
                others = [(-inward[here] @ inward[other], other) for other in meeting if other != here]
                if not others:
                    continue
                self.straight[here], (number, border) = max(others)
                reverse = vertices[here[0], borders[here[1], 0]] != vertices[number, borders[border, 0]]
                self.beyond[here], self.enters[here], self.reversed[here] = number, border, reverse
                ways = self._turns[here[1]] * self._turns[border]
                self.flips[here] = ways if reverse else -ways

    def _inward(self) -> np.ndarray:
        """Unit vectors from the middles of the borders into their cells, shape (cells, borders, dimension)."""
        every, found = np.arange(len(self.cells.cells)), []
        for ends, slope in zip(self.ends, self.slopes, strict=True):
            along = self.cells.derivatives(every, np.tile(ends.mean(axis=0), (len(every), 1)))
            metric = np.einsum("nda,ndb->nab", along, along)
            inward = np.einsum("nda,na->nd", along, np.linalg.solve(metric, np.tile(slope, (len(every), 1))[..., None])[
                ..., 0])
            found.append(inward / np.linalg.norm(inward, axis=1, keepdims=True))
        return np.stack(found, axis=1)

    def margins(self, reference: np.ndarray) -> np.ndarray:
        """How far reference points are inside of each border of a cell, shape (n, borders)."""
        return self.starts + reference @ self.slopes.T

    def along(self, border: np.ndarray) -> np.ndarray:
        """Directions of borders in reference coordinates, shape (n, 2)."""
        return self.ends[border, 1] - self.ends[border, 0]

    def pass_on(self, which: np.ndarray, border: np.ndarray, reference: np.ndarray):
        """Cells beyond borders, the reference points in them that are on the border, and flips of the normal."""
        along = self.along(border)
        share = ((reference - self.ends[border, 0]) * along).sum(axis=1) / (along * along).sum(axis=1)
        share = np.where(self.reversed[which, border], 1 - share, share)[:, None]
        ends = self.ends[self.enters[which, border]]
        return self.beyond[which, border], (1 - share) * ends[:, 0] + share * ends[:, 1], self.flips[which, border]
