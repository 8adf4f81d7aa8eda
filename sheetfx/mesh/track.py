"""Curves as chains of cells, along which points slide from one cell to the next."""

from __future__ import annotations

from math import cos, radians

import basix
import numpy as np
from numpy.polynomial import Polynomial

from .projection import OUTSIDE, Cells

ON = cos(radians(45.0))  # of the angle up to which a chain goes on where it bends
SMOOTH = cos(radians(10.0))  # of that up to which a bend is one of the cells, not of the curve
SMOOTHING = Polynomial([0, 1, -4.5, 6, -2.5]), Polynomial([0, 0, 1.5, -4, 2.5])  # slopes 1 at 0, at 1; without mean
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
    smooth : shape (cells, 2), whether the curve has no corner there
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
        self.enters = np.zeros((len(every), 2), dtype=np.int64)
        self.smooth = np.zeros((len(every), 2), dtype=bool)
        for meeting in at.values():
            for number, end in meeting:
                others = [(-outward[number, end] @ outward[other], other) for other in meeting if other[0] != number]
                straight, other = max(others, default=(-1.0, (-1, 0)))
                if straight > ON:
                    self.following[number, end], self.enters[number, end] = other
                    self.smooth[number, end] = straight > SMOOTH
        back = self.following[self.following, self.enters]
        self.smooth &= back == every[:, None]

    def slopes(self, which: np.ndarray, reference: np.ndarray, order: int = 1) -> np.ndarray:
        """Derivative of the place by the reference coordinate, of an order, shape (n, dimension)."""
        if not len(which):
            return np.empty((0, self.cells.mesh.dimension))
        table = self.cells.shape.tabulate(order, np.ascontiguousarray(reference))[order, :, :, 0]
        return np.einsum("nk,nkd->nd", table, self.cells.nodes[which])

    def tangents(self, which: np.ndarray, reference: np.ndarray) -> np.ndarray:
        """Unit tangents, at nodes where the curve has no corner midway between both cells' tangents."""
        found = self.cells.tangents(which, reference)
        for end in (0, 1):
            at = np.flatnonzero((np.abs(reference[:, 0] - end) <= OUTSIDE) & self.smooth[which, end])
            other, enters = self.following[which[at], end], self.enters[which[at], end]
            beyond = self.cells.tangents(other, enters[:, None].astype(float))
            both = found[at] + np.where(enters == end, -1.0, 1.0)[:, None] * beyond
            found[at] = both / np.linalg.norm(both, axis=1, keepdims=True)
        return found

    def lengths(self, which: np.ndarray, reference: np.ndarray) -> np.ndarray:
        """Length of cells from their beginning to a reference coordinate."""
        parts = [weight * np.linalg.norm(self.slopes(which, point * reference), axis=1)
                 for point, weight in zip(LINE[:, 0], LINE_WEIGHTS, strict=True)]
        return reference[:, 0] * np.sum(parts, axis=0)


class SmoothRows:
    """Interpolation along a track whose slope is continuous from cell to cell, unless the curve has a corner there.

    To the shape functions of a cell others are added that are zero at its ends, change the slope by arc length at one
    of them by half of its jump there, and have no mean. Values between cells, the mean over each cell, and fields that
    have no jump stay as they are, so that a constant pressure makes the same nodal forces; what touches such a curve
    feels a force that does not jump as it slides over a node. (Hermite's cubic functions, with which contact surfaces
    are smoothed in Wriggers 2006, section 9.6, have a mean.)

    Parameters
    ----------
    track : Track
    element : basix element of an interval, whose first two nodes are at its ends
    """

    def __init__(self, track: Track, element):
        k = element.dim
        ends = element.tabulate(1, np.array([[0.0], [1.0]]))[1, :, :, 0]
        count = len(track.following)
        every = np.arange(count)
        paces = np.column_stack([np.linalg.norm(track.slopes(every, np.full((count, 1), float(end))), axis=1)
                                 for end in (0, 1)])
        self._next = np.where(track.smooth, track.following, every[:, None])
        self._others = np.array([np.delete(np.arange(k), end) for end in (0, 1)])[track.enters]
        jumps = np.zeros((2, count, 3 * k - 2))
        for end in (0, 1):
            enters, jump = track.enters[:, end], jumps[end]
            ratio = paces[:, end] / paces[self._next[:, end], enters] * np.where(enters == end, -1, 1)
            beyond = ratio[:, None] * ends[enters]
            jump[:, :k] = -ends[end]
            jump[:, end] += beyond[every, enters]
            columns = slice(k + end * (k - 1), k + (end + 1) * (k - 1))
            jump[:, columns] = np.take_along_axis(beyond, self._others[:, end], axis=1)
            jump *= track.smooth[:, end, None] / 2
        degree = max(element.degree, *(p.degree() for p in SMOOTHING))
        at = np.linspace(0.0, 1.0, degree + 1)
        values = np.einsum("eq,ecm->cqm", [p(at) for p in SMOOTHING], jumps)
        values[:, :, :k] += element.tabulate(0, at[:, None])[0, :, :, 0]
        self._coefficients = np.linalg.solve(np.vander(at, increasing=True), values)

    def gathered(self, values: np.ndarray) -> np.ndarray:
        """Of values at nodes of cells, shape (cells, k, ...), those in the rows of each cell, (cells, 3 k - 2, ...)."""
        beyond = [values[self._next[:, end][:, None], self._others[:, end]] for end in (0, 1)]
        return np.concatenate([values, *beyond], axis=1)

    def table(self, which: np.ndarray, reference: np.ndarray) -> np.ndarray:
        """Weights of gathered values, and their first and second derivative by the reference coordinate, (3, n, m)."""
        return at_places(self._coefficients[which], reference)

    def polynomials(self, values: np.ndarray) -> np.ndarray:
        """Coefficients of what gathered values interpolate in each cell, (cells, degree + 1, components)."""
        return self._coefficients @ values


def at_places(polynomials: np.ndarray, places: np.ndarray) -> np.ndarray:
    """Values of polynomials, and their first and second derivative, by Horner's scheme.

    Parameters
    ----------
    polynomials : coefficients from the lowest power on, shape (n, degree + 1, components)
    places : of each, shape (n, 1)

    Returns
    -------
    array, shape (3, n, components)
    """
    found = np.zeros((3, len(polynomials), polynomials.shape[2]))
    for power in reversed(range(polynomials.shape[1])):
        for order in (2, 1):
            found[order] = found[order] * places + found[order - 1]
        found[0] = found[0] * places + polynomials[:, power]
    found[2] *= 2
    return found
