"""Points of curves that other points are opposite to, found anew as these slide along."""

from __future__ import annotations

import numpy as np

from ..mesh.projection import Cells
from ..mesh.track import SmoothRows, Track, at_places
from ..rounding import SAME
from .nodal_field import AdditiveField
from .points import Trace
from .whole import WholeField

ITERATIONS = 60
STEEP = 1e-3  # cosine of the angle between a curve and the direction in which its point is looked for


class Partners:
    """The point of a curve that lies in the plane through each of some points, normal to a direction.

    The curve is smooth over the nodes of its cells (`mesh.track.SmoothRows`).

    Parameters
    ----------
    field : displacement of the curves
    number : of this field in `Unknowns.fields`
    cells : of the curves
    which, reference : where the partners are in the beginning: numbers in `cells`, and reference points

    Attributes
    ----------
    nodes : shape (n, k), nodes of the field in the cells of the partners
    on : shape (n,), whether there is a partner; those that slid off the end of a curve have none
    travelled : shape (n,), arc length in the reference configuration from the first partners
    """

    def __init__(self, field: AdditiveField | WholeField, number: int, cells: Cells, which: np.ndarray,
                 reference: np.ndarray):
        self._field, self._number, self._track = field, number, Track(cells)
        space = field.space
        self._rows = SmoothRows(self._track, space.ufl_element().basix_element)
        shape = SmoothRows(self._track, cells.shape)
        self._nodes = self._rows.gathered(space.dofmap.list[cells.cells].astype(np.int64))
        self._undeformed = shape.polynomials(shape.gathered(cells.nodes))
        self._which, self._reference = which.copy(), np.ascontiguousarray(reference[:, :1])
        self._sense = np.ones(len(which))
        self._base = -self._track.lengths(self._which, self._reference)
        self.on = np.ones(len(which), dtype=bool)

    @property
    def nodes(self) -> np.ndarray:
        return self._nodes[self._which]

    @property
    def travelled(self) -> np.ndarray:
        return self._base + self._sense * self._track.lengths(self._which, self._reference)

    def begin(self, points: np.ndarray, directions: np.ndarray) -> None:
        """Find the first partners of points, on the smooth curve, which those on its cells are beside where it is bent.

        Otherwise pairs would have slipped by as much before anything moves.
        """
        self.follow(points, directions)
        self._sense = np.ones(len(points))
        self._base = -self._track.lengths(self._which, self._reference)

    def commit(self) -> None:
        """The present state is accepted; what has been travelled goes on counting."""

    def history(self) -> np.ndarray:
        """All that is to be kept of them, shape (n, 4)."""
        return np.column_stack((self._which, self._reference, self._sense, self._base))

    def restore(self, history: np.ndarray) -> None:
        self._which = history[:, 0].astype(np.int64)
        self._reference = np.ascontiguousarray(history[:, 1:2])
        self._sense, self._base = history[:, 2].copy(), history[:, 3].copy()

    def follow(self, points: np.ndarray, directions: np.ndarray) -> bool:
        """Find the partners of points as they are now, from where these were last; return whether anything changed.

        Parameters
        ----------
        points : shape (n, dimension), current places
        directions : shape (n, dimension), normals of the planes in which partners are
        """
        changed, before = False, self.on
        moved = self._rows.polynomials(self._field.table[self._nodes])
        for _ in range(ITERATIONS):
            place, slope, curvature = self._before() + at_places(moved[self._which], self._reference)
            a, b, c = (np.einsum("nd,nd->n", directions, v) for v in (place - points, slope, curvature))
            flat = np.abs(b) < STEEP * np.linalg.norm(slope, axis=1)
            b = np.where(flat, 1.0, b)
            step = np.where(flat, 0.0, -2 * a / (b + np.sign(b) * np.sqrt(np.maximum(b * b - 2 * a * c, 0.0))))
            self.on = ~flat
            if not self._advance(np.clip(step, -1.0, 1.0)):
                break
            changed = True
        return changed or not np.array_equal(before, self.on)

    def _advance(self, step: np.ndarray) -> bool:
        """Take a step along the curves, on to the next cell at most; whether any partner has moved."""
        wanted = self._reference[:, 0] + step
        end = (wanted > 0.5).astype(int)
        beyond = (wanted < -SAME) | (wanted > 1 + SAME)
        following = self._track.following[self._which, end]
        last, leaves = beyond & (following < 0), np.flatnonzero(beyond & (following >= 0))
        self.on &= ~last
        moved = np.abs(np.where(last, end, wanted) - self._reference[:, 0]).max(initial=0.0) > SAME
        if not (moved or len(leaves)):
            return False
        self._reference = np.where(beyond, end, wanted)[:, None].astype(float)
        if len(leaves):
            reached = self.travelled[leaves]
            ahead = self._sense[leaves] * (2 * end[leaves] - 1)
            enters = self._track.enters[self._which[leaves], end[leaves]]
            self._which[leaves], self._reference[leaves, 0] = following[leaves], enters
            self._sense[leaves] = ahead * np.where(enters == 0, 1.0, -1.0)
            lengths = self._track.lengths(self._which[leaves], self._reference[leaves])
            self._base[leaves] = reached - self._sense[leaves] * lengths
        return True

    def _before(self) -> np.ndarray:
        """Places before any displacement, and their two derivatives by the reference coordinate, (3, n, dimension)."""
        return at_places(self._undeformed[self._which], self._reference)

    def _by_length(self, first: np.ndarray, second: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Derivatives by arc length from those by the reference coordinate."""
        slope, curvature = (self._track.slopes(self._which, self._reference, order) for order in (1, 2))
        pace = np.linalg.norm(slope, axis=1)[:, None]
        change = np.einsum("nd,nd->n", slope, curvature)[:, None] / pace
        return self._sense[:, None] * first / pace, (second - first * change / pace) / pace**2

    def traces(self) -> list[Trace]:
        """Rows of the displacement, and of its first and second derivative by arc length."""
        table = self._rows.table(self._which, self._reference)
        return [Trace(self._number, self.nodes, weights, self._field)
                for weights in (table[0], *self._by_length(*table[1:]))]

    def geometry(self) -> list[np.ndarray]:
        """Places in the reference configuration, and their first and second derivative by arc length."""
        place, *slopes = self._before()
        return [place, *self._by_length(*slopes)]


def turned(rotations: np.ndarray, vectors: np.ndarray) -> np.ndarray:
    """Vectors turned by angles of shape (n, 1), or by quaternions of shape (n, 4) and any length."""
    if rotations.shape[1] == 1:
        cosine, sine = np.cos(rotations[:, 0]), np.sin(rotations[:, 0])
        return np.column_stack((cosine * vectors[:, 0] - sine * vectors[:, 1],
                                sine * vectors[:, 0] + cosine * vectors[:, 1]))
    scalar, vector = rotations[:, :1], rotations[:, 1:]
    turn = np.cross(vector, vectors)
    length2 = (rotations**2).sum(axis=1, keepdims=True)
    return vectors + 2 * (scalar * turn + np.cross(vector, turn)) / length2
