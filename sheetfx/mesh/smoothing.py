"""Interpolation on surfaces whose normal is continuous from cell to cell."""

from __future__ import annotations

from math import cos, radians

import basix
import numpy as np
from scipy.sparse import coo_matrix, csr_matrix

from .patch import Patch
from .taylor import SIZES, Taylor

SMOOTH = cos(radians(10.0))  # of the angle up to which a bend is one of the cells, not of the surface
ALONG = 0.5 + np.array([-1.0, 0.0, 1.0]) * np.sqrt(0.15)  # points of borders, from 0 to 1, at which cells have one slope
SLOPE = np.array([0.0, 1.0, -3.0, 3.0, -1.0])  # s (1 - s)^3, by which surfaces of plates are as stiff all over cells
FADING = np.array([1.0, 0.0, -3.0, 2.0])
NEAR = 1e-12  # square of the distance from a corner, in reference coordinates, at which blends are regular
REGULAR = 1e-3  # least square of the sine between edges that determines a slope at a vertex


class Blends:
    """Functions in a cell that change slopes at its borders alone; the same for all cells of a kind.

    The first ones, two for each border, change the slope along it at one of its ends by one. The others, three for each
    border, are zero at all borders, and change the slope across theirs at one of three points; near corners they are
    rational (as those of Gregory 1974, Smooth interpolation without twist constraints), so that they change it at this
    border alone.
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
        self.count = (2 + len(ALONG)) * count

    def __call__(self, reference: np.ndarray, order: int) -> np.ndarray:
        """Values and derivatives at reference points, shape (rows, n, functions).

        Functions at ends come first, numbered by border, then end; then those across, by border, then point.
        """
        margin = Taylor.linear(self._patch.margins(reference).T, self._patch.slopes, order)
        first, second = (margin[beside] for beside in self._beside)
        bubble, place = first * second, ((first + second * -1.0 + 1.0) * 0.5).polynomial(self._lagrange)
        square, blend = margin * margin + NEAR, bubble * bubble
        blend = blend * ((first * first + square) * (second * second + square)).reciprocal()
        both = Taylor(np.stack([(second * second).terms, (first * first).terms], axis=1))
        found = [f.derivatives().transpose(0, 3, 2, 1).reshape(SIZES[order], len(reference), -1) for f in (
            both.times(bubble * margin.polynomial(self._fading)), place.times(bubble * blend * margin.polynomial(SLOPE)))]
        return np.concatenate(found, axis=2)


class SmoothSurface:
    """Where a surface bends between its cells though it should not, and how that is shared out to these.

    At each vertex there is one plane of slopes, the mean of those of the edges; along each border cells have half of
    the jump of the slope across it that then is left. What is shared out is linear in the values at nodes. Values at
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
            along = cells.derivatives(self._every, np.tile(patch.ends[border, end], (self._count, 1)))
            slopes[:, border, end] = along @ self._edges[end][border]
            normals[:, border, end] = _unit(np.cross(along[:, :, 0], along[:, :, 1]))
        at: dict[int, list[tuple[int, int, int]]] = {}
        for cell, border, end in np.ndindex(shape):
            at.setdefault(int(patch.vertices[cell, border, end]), []).append((cell, border, end))
        entries: list[tuple[int, int, float]] = []
        self._normals = np.zeros((*shape, 3))
        for meeting in at.values():
            edges: dict[int, list[tuple[int, int, int]]] = {}
            for cell, border, end in meeting:
                edges.setdefault(int(patch.vertices[cell, border, 1 - end]), []).append((cell, border, end))
            ways = np.sign([normals[m] @ normals[meeting[0]] for m in meeting])
            normal = _unit((ways[:, None] * np.array([normals[m] for m in meeting])).sum(axis=0))
            inside = [m[:2] for m in meeting if patch.beyond[m[:2]] >= 0]
            bends = any(abs(normals[m] @ normal) < SMOOTH for m in meeting) or not all(self.smooth[m] for m in inside)
            if bends or len(edges) > len(meeting) // 2 + 1:
                continue
            flat = np.array([_within(slopes[ends[0]], normal) for ends in edges.values()])
            unit = _unit(flat)
            metric = unit.T @ unit + np.outer(normal, normal)
            if np.linalg.det(metric) < REGULAR:
                continue
            shares = flat @ np.linalg.solve(metric, (unit / np.linalg.norm(flat, axis=1)[:, None]).T)
            shares -= np.eye(len(edges))
            for items, row in zip(edges.values(), shares, strict=True):
                for item in items:
                    entries += [(self._number(item), self._number(ends[0]), share)
                                for ends, share in zip(edges.values(), row, strict=True)]
            for m, way in zip(meeting, ways, strict=True):
                self._normals[m] = way * normal
        self._turns = _sparse(entries, (self._count * self._borders * 2,) * 2)

    def _number(self, item: tuple[int, int, int]) -> int:
        return (item[0] * self._borders + item[1]) * 2 + item[2]

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
        return SmoothShapes(element, nodes, self.blends, turns, self._shares @ across)


class SmoothShapes:
    """Shape functions of nodes in a cell and around it.

    Attributes
    ----------
    nodes : shape (cells, m), numbers of the nodes; those of the cell come first, and again where there are fewer
    """

    def __init__(self, element, nodes: np.ndarray, blends: Blends, along: csr_matrix, across: csr_matrix):
        self._element, found = element, []
        for cell, own in enumerate(nodes):
            rows = [m[cell * n:(cell + 1) * n] for m, n in ((along, along.shape[0] // len(nodes)),
                                                            (across, across.shape[0] // len(nodes)))]
            near = np.unique(np.concatenate([r.indices[np.abs(r.data) > 1e-14] for r in rows]))
            every = np.concatenate([own, np.setdiff1d(near, own)])
            found.append((every, np.concatenate([r[:, every].toarray() for r in rows])))
        most = max((len(every) for every, _ in found), default=element.dim)
        self.nodes = np.array([np.pad(every, (0, most - len(every)), constant_values=every[0]) for every, _ in found])
        self._weights = np.array([np.pad(w, ((0, 0), (0, most - w.shape[1]))) for _, w in found])

    def table(self, which: np.ndarray, reference: np.ndarray, blends: np.ndarray, order: int) -> np.ndarray:
        """Values and derivatives at reference points in cells, shape (rows, n, m), from those of the blends there."""
        found = np.einsum("onf,nfm->onm", blends, self._weights[which], optimize=True)
        if len(which):
            found[:, :, :self._element.dim] += self._element.tabulate(order, np.ascontiguousarray(reference))[..., 0]
        return found


def _unit(vectors: np.ndarray) -> np.ndarray:
    return vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)


def _within(vectors: np.ndarray, normal: np.ndarray) -> np.ndarray:
    """Parts of vectors in the plane with a normal."""
    return vectors - (vectors @ normal)[..., None] * normal


def _sparse(entries, shape: tuple[int, int]) -> csr_matrix:
    rows, columns, values = np.array(entries, dtype=float).reshape(-1, 3).T
    return csr_matrix(coo_matrix((values, (rows.astype(np.int64), columns.astype(np.int64))), shape=shape))


def _on_nodes(values: np.ndarray, columns: np.ndarray, size: int) -> csr_matrix:
    """Matrix with values (rows, k) in columns (rows, k)."""
    rows = np.repeat(np.arange(len(values)), values.shape[1])
    return csr_matrix(coo_matrix((values.ravel(), (rows, columns.ravel())), shape=(len(values), size)))
