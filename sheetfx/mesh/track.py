"""Curves as chains of cells, along which points slide from one cell to the next."""

from __future__ import annotations

from math import cos, radians

import basix
import numpy as np

from .projection import Cells

ON = cos(radians(45.0))  # of the angle up to which a chain goes on where it bends
LINE, LINE_WEIGHTS = basix.make_quadrature(basix.CellType.interval, 15)


class Track:
    """Cells of curves, how long they are, and which one follows beyond each of their ends.

    At a junction a chain goes on in the cell that bends least, if it bends by less than 45 degrees.

    Parameters
    ----------
    cells : Cells of a mesh of curves

    Attributes
    ----------
    following : shape (cells, 2), the cell beyond the ends at reference coordinates 0 and 1; -1: none
    enters : shape (cells, 2), reference coordinate at which that cell is entered
    """

    def __init__(self, cells: Cells):
        self.cells = cells
        every = np.arange(len(cells.cells))
        topology = cells.mesh.domain.topology
        topology.create_connectivity(1, 0)
        vertices = topology.connectivity(1, 0).array.reshape(-1, 2)[cells.cells]
        ends = [self.slopes(every, np.full((len(every), 1), float(end))) for end in (0, 1)]
        outward = np.stack([-ends[0], ends[1]], axis=1) if len(every) else np.empty((0, 2, cells.mesh.dimension))
        outward /= np.linalg.norm(outward, axis=2, keepdims=True)
        at: dict[int, list[tuple[int, int]]] = {}
        for number, pair in enumerate(vertices):
            for end, vertex in enumerate(pair):
                at.setdefault(int(vertex), []).append((number, end))
        self.following = np.full((len(every), 2), -1)
        self.enters = np.zeros((len(every), 2))
        for meeting in at.values():
            for number, end in meeting:
                others = [(-outward[number, end] @ outward[other], other) for other in meeting if other[0] != number]
                straight, other = max(others, default=(-1.0, (-1, 0)))
                if straight > ON:
                    self.following[number, end], self.enters[number, end] = other

    def places(self, which: np.ndarray, reference: np.ndarray) -> np.ndarray:
        return self.cells.places(which, reference)

    def slopes(self, which: np.ndarray, reference: np.ndarray, order: int = 1) -> np.ndarray:
        """Derivative of the place by the reference coordinate, of an order, shape (n, dimension)."""
        if not len(which):
            return np.empty((0, self.cells.mesh.dimension))
        table = self.cells.shape.tabulate(order, np.ascontiguousarray(reference))[order, :, :, 0]
        return np.einsum("nk,nkd->nd", table, self.cells.nodes[which])

    def lengths(self, which: np.ndarray, reference: np.ndarray) -> np.ndarray:
        """Length of cells from their beginning to a reference coordinate."""
        parts = [weight * np.linalg.norm(self.slopes(which, point * reference), axis=1)
                 for point, weight in zip(LINE[:, 0], LINE_WEIGHTS, strict=True)]
        return reference[:, 0] * np.sum(parts, axis=0)
