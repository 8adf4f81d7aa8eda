"""Interpolation on surfaces whose normal is continuous from cell to cell."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from math import cos, radians

import basix
import numpy as np
from scipy.sparse import coo_matrix, csr_matrix

from .patch import Patch
from .taylor import SIZES, Taylor

SMOOTH = cos(radians(10.0))  # of the angle up to which a bend is one of the cells, not of the surface
ALONG = 0.5 + np.array([-1.0, 0.0, 1.0]) * np.sqrt(0.15)  # points of borders, from 0 to 1, where slopes are made equal
SLOPE = np.array([0.0, 1.0, -3.0, 3.0, -1.0])  # s (1 - s)^3; see `Blends`
FADING = np.array([1.0, 0.0, -3.0, 2.0])
NEAR = 1e-12  # square of the distance from a corner, in reference coordinates, at which blends are regular
NOTHING = 1e-14  # weights that are rounding
REGULAR = 1e-3  # least square of the sine between edges that determine a plane at a vertex

End = tuple[int, int, int]  # of an edge at a vertex: number of a cell, of its border, and 0 or 1


class Blends:
    """Functions in a cell that change slopes at its borders alone; the same for all cells of a kind.

    The first ones, two for each border, change the slope along it at one of its ends by one. The others, three for each
    border, are zero at all borders, and change the slope across theirs at one of three points; near corners they are
    rational (as those of Gregory 1974, Smooth interpolation without twist constraints), so that they change it at this
    border alone. Of s (1 - s)² (1 + c s) that with c = -1 is taken: a force that slides along a thin strip of quadratic
    cells on a foundation finds it about as stiff everywhere, within 0.02 % where s (1 - s)², Hermite's polynomial, has
    0.09 %, that without mean 0.17 %, and the surface as it is 0.15 %.
    """

    def __init__(self, patch: Patch):
        self._patch, quadrilaterals = patch, patch.cells.kind == basix.CellType.quadrilateral
        count = len(patch.slopes)
        at_ends = np.abs(patch.starts + np.einsum("bed,fd->bef", patch.ends, patch.slopes)) < 1e-12
        at_ends[np.arange(count), :, np.arange(count)] = False
        self._beside = at_ends.argmax(axis=2).T
        self._fading = FADING if quadrilaterals else FADING[:1]
        lagrange = np.array([np.poly(np.delete(ALONG, j))[::-1] / np.prod(s - np.delete(ALONG, j)) / (s * (1 - s))
                             for j, s in enumerate(ALONG)])
        self._lagrange = lagrange.T

    def __call__(self, reference: np.ndarray, order: int) -> np.ndarray:
        """Values and derivatives at reference points, shape (rows, n, functions).

        Functions at ends come first, numbered by border, then end; then those across, by border, then point.
        """
        margin = Taylor.linear(self._patch.margins(reference).T, self._patch.slopes, order)
        first, second = (margin[beside] for beside in self._beside)
        bubble, squares = first * second, [f * f for f in (second, first)]
        along = Taylor.several(squares).times(bubble * margin.polynomial(self._fading))
        near = margin * margin + NEAR
        alone = bubble * bubble * ((squares[0] + near) * (squares[1] + near)).reciprocal()
        place = (first + second * -1.0 + 1.0) * 0.5
        across = place.polynomial(self._lagrange).times(bubble * alone * margin.polynomial(SLOPE))
        return np.concatenate([f.derivatives().transpose(0, 3, 2, 1).reshape(SIZES[order], len(reference), -1)
                               for f in (along, across)], axis=2)


class SmoothSurface:
    """Where a surface bends between its cells though it should not, and how that is shared out to these.

    At each vertex there is one plane of slopes, the mean of the edges'; along each border cells have half of
    the jump of the slope across it that then is left. The shares are linear in the values at nodes. Values at
    vertices, and whatever has no jump, stay as they are: a plane stays one. Where a surface is folded by more than
    10 degrees, or more than two cells have a border in common, it stays as it is.

    Parameters
    ----------
    patch : Patch

    Attributes
    ----------
    smooth : shape (cells, borders), whether the surface goes on smoothly beyond a border
    """

    def __init__(self, patch: Patch):
        self.patch, self.blends = patch, Blends(patch)
        count, borders = patch.beyond.shape
        self._count, self._borders, self._every = count, borders, np.arange(count)
        back = patch.beyond[patch.beyond, patch.enters] == self._every[:, None]
        self.smooth = (patch.beyond >= 0) & back & (patch.straight > SMOOTH)
        self._edges = [patch.ends[:, 1] - patch.ends[:, 0], patch.ends[:, 0] - patch.ends[:, 1]]
        self._at_vertices()
        self._at_borders()

    def _at_vertices(self) -> None:
        """Changes of the slopes along edges at their ends, as a matrix on these slopes; and normals there."""
        patch, cells = self.patch, self.patch.cells
        shape = self._count, self._borders, 2
        slopes, normals = np.empty((*shape, 3)), np.empty((*shape, 3))
        for border, end in np.ndindex(shape[1:]):
            reference = np.tile(patch.ends[border, end], (self._count, 1))
            slopes[:, border, end] = cells.derivatives(self._every, reference) @ self._edges[end][border]
            normals[:, border, end] = cells.normals(self._every, reference)
        at: dict[int, list[End]] = {}
        for cell, border, end in np.ndindex(shape):
            at.setdefault(int(patch.vertices[cell, border, end]), []).append((cell, border, end))
        entries: list[tuple[int, int, float]] = []
        self._normals = np.zeros((*shape, 3))
        for meeting in at.values():
            ways = np.sign([normals[m] @ normals[meeting[0]] for m in meeting])
            normal = _unit(ways @ np.array([normals[m] for m in meeting]))
            edges: dict[int, list[End]] = {}
            for cell, border, end in meeting:
                edges.setdefault(int(patch.vertices[cell, border, 1 - end]), []).append((cell, border, end))
            if all(abs(normals[m] @ normal) > SMOOTH for m in meeting) and self._go_round(meeting, edges.values()):
                entries += self._in_one_plane(list(edges.values()), slopes, normal)
                for m, way in zip(meeting, ways, strict=True):
                    self._normals[m] = way * normal
        self._turns = _sparse(entries, (self._count * self._borders * 2,) * 2)

    def _go_round(self, meeting: Sequence[End], edges: Collection[Sequence[End]]) -> bool:
        """Whether cells at a vertex follow on each other without a fold, and are the only ones there."""
        inside = all(self.smooth[m[:2]] for m in meeting if self.patch.beyond[m[:2]] >= 0)
        return inside and len(edges) <= len(meeting) // 2 + 1

    def _in_one_plane(self, edges: Sequence[Sequence[End]], slopes: np.ndarray,
                      normal: np.ndarray) -> list[tuple[int, int, float]]:
        """Entries of the matrix of changes, by which slopes along edges at a vertex become slopes of one plane."""
        flat = np.array([slopes[ends[0]] - (slopes[ends[0]] @ normal) * normal for ends in edges])
        lengths = np.linalg.norm(flat, axis=1)[:, None]
        metric = (flat / lengths).T @ (flat / lengths) + np.outer(normal, normal)
        if np.linalg.det(metric) < REGULAR:
            return []
        shares = flat @ np.linalg.solve(metric, (flat / lengths**2).T) - np.eye(len(edges))
        return [(self._number(end), self._number(others[0]), share) for ends, row in zip(edges, shares, strict=True)
                for end in ends for others, share in zip(edges, row, strict=True)]

    def _number(self, end: End) -> int:
        return (end[0] * self._borders + end[1]) * 2 + end[2]

    def _at_borders(self) -> None:
        """Directions in which slopes across borders are taken, and the changes as a matrix on these slopes."""
        patch, count = self.patch, len(ALONG)
        here, border = np.nonzero(self.smooth)
        other, enters = patch.beyond[here, border], patch.enters[here, border]
        between = [self._between(here, border, float(end)) for end in (0, 1)]
        known = self._normals[here, border].any(axis=2)
        missing = [np.where(known[:, end, None], self._normals[here, border, end] - between[end][1], 0.0)
                   for end in (0, 1)]
        self._across = np.zeros((self._count, self._borders, count, 2))
        rows = count * (here * self._borders + border)
        mirrored = count * (other * self._borders + enters)
        entries = []
        for j, s in enumerate(ALONG):
            slopes, normal = self._between(here, border, s)
            normal = _unit(normal + (1 - s) * missing[0] + s * missing[1])
            edge, inward = (np.einsum("nda,na->nd", slopes, v[border]) for v in (self._edges[0], patch.slopes))
            conormal = np.cross(normal, edge)
            conormal *= (np.sign((conormal * inward).sum(axis=1)) / np.linalg.norm(conormal, axis=1))[:, None]
            flat = slopes - normal[:, :, None] * np.einsum("nd,nda->na", normal, slopes)[:, None]
            self._across[here, border, j] = np.einsum("nad,nd->na", np.linalg.pinv(flat), conormal)
            change = -0.5 / np.einsum("na,na->n", self._across[here, border, j], patch.slopes[border])
            beyond = mirrored + np.where(patch.reversed[here, border], count - 1 - j, j)
            entries += [*zip(rows + j, rows + j, change, strict=True), *zip(rows + j, beyond, change, strict=True)]
        self._shares = _sparse(entries, (self._count * self._borders * count,) * 2)

    def _between(self, here: np.ndarray, border: np.ndarray, s: float) -> tuple[np.ndarray, np.ndarray]:
        """Slopes of cells at a point of their borders, and the normal in the middle between these and those beyond."""
        patch = self.patch
        reference = (1 - s) * patch.ends[border, 0] + s * patch.ends[border, 1]
        slopes, (other, entered, flips) = (patch.cells.derivatives(here, reference),
                                           patch.pass_on(here, border, reference))
        return slopes, _unit(patch.cells.normals(here, reference)
                             + flips[:, None] * patch.cells.normals(other, entered))

    def shapes(self, element, nodes: np.ndarray) -> SmoothShapes:
        """Shape functions of an element, whose nodes in each cell have numbers (cells, k)."""
        ends = [[element.tabulate(1, self.patch.ends[b, e][None])[1:3, 0, :, 0].T @ self._edges[e][b]
                 for e in (0, 1)] for b in range(self._borders)]
        size, count = int(nodes.max(initial=-1)) + 1, len(ALONG)
        slopes = _on_nodes(np.broadcast_to(ends, (self._count, *np.shape(ends))).reshape(-1, element.dim),
                           np.repeat(nodes, self._borders * 2, axis=0), size)
        turns = self._turns @ slopes
        points = ((1 - ALONG[:, None]) * self.patch.ends[:, None, 0] + ALONG[:, None] * self.patch.ends[:, None, 1])
        own = element.tabulate(1, points.reshape(-1, 2))[1:3, :, :, 0].reshape(2, self._borders, count, -1)
        blends = self.blends(points.reshape(-1, 2), 1)[1:3, :, :2 * self._borders]
        rows = np.einsum("cbja,abjk->cbjk", self._across, own).reshape(-1, element.dim)
        of_blends = np.einsum("cbja,abjk->cbjk", self._across, blends.reshape(2, self._borders, count, -1))
        numbers = np.arange(len(turns.indptr) - 1).reshape(self._count, -1)
        across = (_on_nodes(rows, np.repeat(nodes, self._borders * count, axis=0), size)
                  + _on_nodes(of_blends.reshape(-1, 2 * self._borders),
                              np.repeat(numbers, self._borders * count, axis=0), turns.shape[0]) @ turns)
        return SmoothShapes(element, nodes, [turns, self._shares @ across])


class SmoothShapes:
    """Shape functions of nodes in a cell and around it.

    Attributes
    ----------
    nodes : shape (cells, m), numbers of the nodes; the cell's come first, and again where there are fewer
    """

    def __init__(self, element, own: np.ndarray, weights: Sequence[csr_matrix]):
        """From nodes of the cells, and matrices from all nodes to the weights of blends, whose rows go cell by cell."""
        self._element, (count, most), size = element, own.shape, weights[0].shape[1]
        cells, rows, columns, values = _cell_by_cell(weights, count)
        pairs, own_pairs = cells * size + columns, np.arange(count)[:, None] * size + own
        around = np.setdiff1d(pairs, own_pairs)
        first = np.searchsorted(around, np.arange(count) * size)
        every = np.concatenate([own_pairs.ravel(), around])
        place = np.concatenate([np.tile(np.arange(most), count), np.arange(len(around)) - first[around // size] + most])
        self.nodes = np.repeat(own[:, :1], place.max(initial=-1) + 1, axis=1).astype(np.int64)
        self.nodes[every // size, place] = every % size
        self._weights = np.zeros((count, sum(m.shape[0] for m in weights) // max(count, 1), self.nodes.shape[1]))
        order = np.argsort(every)
        self._weights[cells, rows, place[order[np.searchsorted(every, pairs, sorter=order)]]] = values

    def table(self, which: np.ndarray, reference: np.ndarray, blends: np.ndarray, order: int) -> np.ndarray:
        """Values and derivatives at reference points in cells, shape (rows, n, m), from the blends' there."""
        found = np.einsum("onf,nfm->onm", blends, self._weights[which], optimize=True)
        if len(which):
            found[:, :, :self._element.dim] += self._element.tabulate(order, np.ascontiguousarray(reference))[..., 0]
        return found


def _cell_by_cell(matrices: Sequence[csr_matrix], count: int) -> list[np.ndarray]:
    """Entries of matrices whose rows go cell by cell: numbers of the cells, rows in these, columns, values."""
    found, start = [], 0
    for matrix in matrices:
        each, entries = max(matrix.shape[0] // max(count, 1), 1), matrix.tocoo()
        kept = np.abs(entries.data) > NOTHING
        found.append((entries.row[kept] // each, start + entries.row[kept] % each,
                      entries.col[kept].astype(np.int64), entries.data[kept]))
        start += each
    return [np.concatenate(parts) for parts in zip(*found, strict=True)]


def _unit(vectors: np.ndarray) -> np.ndarray:
    return vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)


def _sparse(entries, shape: tuple[int, int]) -> csr_matrix:
    rows, columns, values = np.array(entries, dtype=float).reshape(-1, 3).T
    return csr_matrix(coo_matrix((values, (rows.astype(np.int64), columns.astype(np.int64))), shape=shape))


def _on_nodes(values: np.ndarray, columns: np.ndarray, size: int) -> csr_matrix:
    """Matrix with values (rows, k) in columns (rows, k)."""
    rows = np.repeat(np.arange(len(values)), values.shape[1])
    return csr_matrix(coo_matrix((values.ravel(), (rows, columns.ravel())), shape=(len(values), size)))
