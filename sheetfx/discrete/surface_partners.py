"""Points of surfaces that are closest to other points, found anew as these slide along."""

from __future__ import annotations

import numpy as np

from ..compat import geometry_nodes
from ..mesh.patch import Patch
from ..mesh.projection import Cells
from ..mesh.smoothing import SmoothSurface
from ..mesh.taylor import SIZES
from ..rounding import SAME
from .nodal_field import AdditiveField
from .points import Trace
from .whole import WholeField

ITERATIONS = 60
LONGEST = 0.5  # step in reference coordinates
EXTENDED = 1e-6, 0.005  # of a cell, as which it goes on beyond a border, or a fold, before the next one takes over
FURTHEST = 1.0  # of a cell, where the next one sends the partner back
SECOND, THIRD = np.array([[3, 4], [4, 5]]), np.array([[[6, 7], [7, 8]], [[7, 8], [8, 9]]])  # rows of derivatives
MARGIN = 5  # column of the history
FLAT = 1e-6  # part of the metric below which the squared distance has no minimum


class SurfacePartners:
    """The closest point of a surface in its present shape to each of some points.

    The surface is smooth over the borders of its cells (`mesh.smoothing.SmoothSurface`), but for folds. Reference
    coordinates of the cells are its coordinates. A partner goes on in the next cell where it leaves one, and in the
    first where the next one sends it back, by rounding, or at a fold: the outside of this has points with a closest one
    in neither cell, and the inside points with one in both, so that there it goes on by half a hundredth of a cell
    late. Beyond the edge of a surface there is no partner.

    Parameters
    ----------
    field : displacement of the surfaces
    number : of this field in `Unknowns.fields`
    cells : of the surfaces
    which, reference : where the partners are in the beginning: numbers in `cells`, and reference points
    side : shape (n,), 1 for points on the side to which the normal points in the cell of their partner, else -1
    overhang : how far beyond its edge a surface goes on (length)

    Attributes
    ----------
    nodes : shape (n, k), nodes of the field in the cells of the partners
    on : shape (n,), whether there is a partner
    side : shape (n,), as above, for the present cell
    """

    def __init__(self, field: AdditiveField | WholeField, number: int, cells: Cells, which: np.ndarray,
                 reference: np.ndarray, side: np.ndarray, overhang: float):
        self._field, self._number, self._patch, self._cells = field, number, Patch(cells), cells
        surface, space, domain = SmoothSurface(self._patch), field.space, cells.mesh.domain
        self._blends, self._extended = surface.blends, np.where(surface.smooth, *EXTENDED)
        self._shapes = surface.shapes(space.ufl_element().basix_element, space.dofmap.list[cells.cells])
        self._undeformed = surface.shapes(cells.shape, geometry_nodes(domain)[cells.cells])
        self._places, self._weighed_at = domain.geometry.x[self._undeformed.nodes], None
        self._which, self._reference, self._overhang = which.copy(), reference.copy(), overhang
        self.side, self.on = side.astype(float), np.ones(len(which), dtype=bool)
        self._left, self._kept = np.full(len(which), -1), np.zeros(len(which), dtype=bool)
        self._start_from_here()

    def begin(self, points: np.ndarray) -> None:
        """Find the first partners of points, on the smooth surface, which those on its cells are beside where it bends.

        Otherwise points would have slipped by as much before anything moves.
        """
        self.follow(points)
        self._start_from_here()

    def _start_from_here(self) -> None:
        """Count travel from where the partners are, along axes of which the first goes along its coordinate lines."""
        self._passed, (self._origin, along, _) = np.zeros((len(self._which), 2)), self.undeformed(1)
        self._axes = self._axes_along(along)

    @property
    def nodes(self) -> np.ndarray:
        return self._shapes.nodes[self._which]

    @property
    def travelled(self) -> np.ndarray:
        """How far the partners have moved on the undeformed surface, along its `axes`, shape (n, 2)."""
        moved = self.undeformed(0)[0] - self._origin
        return self._passed + np.einsum("nid,nd->ni", self._axes, moved)

    @property
    def axes(self) -> np.ndarray:
        """Directions along the undeformed surface at the partners of the last accepted state, shape (n, 2, 3)."""
        return self._axes

    def margins(self) -> np.ndarray:
        """Distance of each partner from the edges of the undeformed surface, infinite where its cell is at none."""
        margins = self._patch.margins(self._reference) / self._steepness()
        return np.where(self._patch.beyond[self._which] < 0, margins, np.inf).min(axis=1)

    def commit(self) -> None:
        """Count travel from here on, along axes that are carried along the surface."""
        self._passed = self.travelled
        self._origin = self.undeformed(0)[0]
        self._axes = self._axes_along(self._axes[:, 0])

    def _axes_along(self, first: np.ndarray) -> np.ndarray:
        """Axes along the undeformed surface of which the first is as close as possible to given directions."""
        normal = np.cross(*self.undeformed(1)[1:])
        normal *= (self.side / np.linalg.norm(normal, axis=1))[:, None]
        first = first - np.einsum("nd,nd->n", first, normal)[:, None] * normal
        first /= np.linalg.norm(first, axis=1, keepdims=True)
        return np.stack([first, np.cross(normal, first)], axis=1)

    def history(self) -> np.ndarray:
        """All that is to be kept of them."""
        return np.column_stack((self._which, self._reference, self.side, self.on, self.margins(), self._passed,
                                self._origin, self._axes.reshape(-1, 6)))

    def restore(self, history: np.ndarray) -> None:
        self._which, self._reference = history[:, 0].astype(np.int64), history[:, 1:3].copy()
        self.side, self.on = history[:, 3].copy(), history[:, 4] > 0
        self._passed, self._origin = history[:, 6:8].copy(), history[:, 8:11].copy()
        self._axes = history[:, 11:17].reshape(-1, 2, 3).copy()

    def follow(self, points: np.ndarray) -> bool:
        """Find the partners of points as they are now, from where these were last; return whether anything changed."""
        changed, before = False, self.on
        self._left[:], self._kept[:] = -1, False
        for _ in range(ITERATIONS):
            place, slopes, curvatures = self.shape()
            apart = points - place
            metric = np.einsum("nad,nbd->nab", slopes, slopes)
            matrix = metric - np.einsum("nabd,nd->nab", curvatures, apart)
            convex = (np.linalg.det(matrix) > FLAT * np.linalg.det(metric)) & (np.trace(matrix, axis1=1, axis2=2) > 0)
            matrix = np.where(convex[:, None, None], matrix, metric)
            if not self._advance(matrix, np.einsum("nad,nd->na", slopes, apart)):
                break
            changed = True
        return changed or not np.array_equal(before, self.on)

    def _advance(self, matrix: np.ndarray, pull: np.ndarray) -> bool:
        """Take a Newton step, on to the next cell at most and along edges of the surface; whether any has moved."""
        step = np.linalg.solve(matrix, pull[..., None])[..., 0]
        margins, edge = self._patch.margins(self._reference), self._patch.beyond[self._which] < 0
        least = np.where(edge, -self._overhang * self._steepness(),
                         np.where(self._kept[:, None], -FURTHEST, -self._extended[self._which]))
        held = edge & (margins <= least + SAME) & (step @ self._patch.slopes.T < 0)
        self.on = ~held.any(axis=1)
        if held.any():
            off = ~self.on
            along = self._patch.along(held[off].argmax(axis=1))
            size = (np.einsum("na,na->n", along, pull[off])
                    / np.einsum("na,nab,nb->n", along, matrix[off], along))[:, None]
            step[off] = np.where(held[off].sum(axis=1)[:, None] > 1, 0.0, size * along)
        step *= np.minimum(1.0, LONGEST / np.maximum(np.abs(step).max(axis=1, initial=SAME), SAME))[:, None]
        change = step @ self._patch.slopes.T
        change[held] = 0.0
        with np.errstate(divide="ignore", invalid="ignore"):
            shares = np.where(change < 0, np.maximum(margins - least, 0.0) / -change, np.inf)
        share = np.minimum(shares.min(axis=1, initial=np.inf), 1.0)
        border = shares.argmin(axis=1)
        self._reference = self._reference + share[:, None] * step
        leaves = np.flatnonzero((share < 1.0) & ~edge[np.arange(len(edge)), border] & ~self._kept)
        if len(leaves):
            left = self._which[leaves]
            self._which[leaves], self._reference[leaves], flips = self._patch.pass_on(
                left, border[leaves], self._reference[leaves])
            self._kept[leaves], self._left[leaves] = self._which[leaves] == self._left[leaves], left
            self.side[leaves] *= flips
        return bool(len(leaves)) or np.abs(share[:, None] * step).max(initial=0.0) > SAME

    def _steepness(self) -> np.ndarray:
        """Change of the margins by length on the undeformed surface, shape (n, borders)."""
        slopes = self._cells.derivatives(self._which, self._reference)
        inverse = np.linalg.inv(np.einsum("nda,ndb->nab", slopes, slopes))
        return np.sqrt(np.einsum("ba,nac,bc->nb", self._patch.slopes, inverse, self._patch.slopes))

    def _weights(self) -> tuple[np.ndarray, np.ndarray]:
        """Shape functions of the displacement and of the undeformed surface at the partners, each (rows, n, k)."""
        here = self._which.tobytes(), self._reference.tobytes()
        if here != self._weighed_at:
            blends = self._blends(self._reference, 3)
            self._weighed_at, self._weighed = here, tuple(
                shapes.table(self._which, self._reference, blends, 3) for shapes in (self._shapes, self._undeformed))
        return self._weighed

    def undeformed(self, order: int = 3) -> np.ndarray:
        """Places on the undeformed surface and their derivatives, shape (rows, n, 3)."""
        return np.einsum("onk,nkd->ond", self._weights()[1][:SIZES[order]], self._places[self._which])

    def _deformed(self, order: int) -> np.ndarray:
        weights = self._weights()[0][:SIZES[order]]
        return self.undeformed(order) + np.einsum("onk,nkd->ond", weights, self._field.table[self.nodes])

    def shape(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Current places, first derivatives (n, 2, 3) and second ones (n, 2, 2, 3)."""
        rows = self._deformed(2)
        return rows[0], rows[1:3].transpose(1, 0, 2), rows[SECOND].transpose(2, 0, 1, 3)

    def third(self) -> np.ndarray:
        """Current third derivatives of the place, shape (n, 2, 2, 2, 3)."""
        return self._deformed(3)[THIRD].transpose(3, 0, 1, 2, 4)

    def traces(self) -> list[Trace]:
        """Rows of the displacement, and of its first and second derivatives."""
        return [Trace(self._number, self.nodes, weights, self._field) for weights in self._weights()[0][:SIZES[2]]]
