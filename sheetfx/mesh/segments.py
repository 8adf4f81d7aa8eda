"""Lines cut where they leave cells of two parts: segments that are in one cell of each."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq

from .lines import SAME, Piece
from .projection import OUTSIDE, Cells

AHEAD = 1e-5  # how far ahead of a border the next cell is looked for, over the size of a cell


@dataclass(frozen=True)
class Side:
    """Places of one part at the points of an interface.

    Attributes
    ----------
    cells : numbers of the mesh's cells on this process, shape (n,)
    reference : reference points in these, shape (n, reference dimension)
    places : in the reference configuration, shape (n, dimension)
    normals : unit normals of a surface, shape (n, 3); None: it is a curve
    """

    cells: np.ndarray
    reference: np.ndarray
    places: np.ndarray
    normals: np.ndarray | None


class Pair:
    """Both parts, and how far they may be apart."""

    def __init__(self, first: Cells, second: Cells, reach: float, name: str):
        self.parts, self._name = (first, second), name
        self.tolerance = SAME * max(c.mesh.size for c in self.parts)
        self._reach = reach

    def check(self, points: np.ndarray, distances: Sequence[np.ndarray]) -> None:
        """Refuse points that are off a part."""
        both = np.sum(distances, axis=0)
        if len(both) and not both.max() <= self._reach + self.tolerance:
            worst = int(both.argmax())
            place = ", ".join(f"{c:.6g}" for c in points[worst])
            beyond = f"more than the reach of {self._reach:.6g}" if self._reach else "and it has no reach"
            raise ValueError(
                f"{self._name}: the point ({place}) is {both[worst]:.6g} off the part that it is joined to, {beyond}; "
                f"move or shorten it, or give a reach of {both[worst]:.6g}, which rigid arms bridge")

    def side(self, number: int, which: np.ndarray, reference: np.ndarray) -> Side:
        part = self.parts[number]
        normals = part.normals(which, reference) if part.mesh.domain.topology.dim == 2 else None
        return Side(part.cells[which], reference, part.places(which, reference), normals)


@dataclass(frozen=True)
class Segment:
    """Part of a piece, between two parameters, that is in one cell of each part."""

    piece: Piece
    begin: float
    end: float
    length: float
    cells: tuple[int, ...]


def divided(line: Sequence[Piece], pair: Pair) -> list[Segment]:
    """Segments of a line, one behind the other."""
    segments: list[Segment] = []
    for piece, *ways in zip(line, *(_ways(part, line, pair) for part in pair.parts), strict=True):
        begin = 0.0
        for end in sorted({t for way in ways for t, _ in way}):
            if end - begin > OUTSIDE:
                cells = tuple(next(cell for t, cell in way if t > (begin + end) / 2) for way in ways)
                segments.append(Segment(piece, begin, end, piece.length(end) - piece.length(begin), cells))
                begin = end
    return segments


def _ways(part: Cells, line: Sequence[Piece], pair: Pair) -> list[list[tuple[float, int]]]:
    """For each piece of a line the parameters at which it leaves cells of a part, and these cells.

    A straight piece that ends closest to the flat cell that it begins over does not leave it in between.
    """
    starts = np.concatenate([piece.places(np.array([_just_ahead(part, piece, 0.0)])) for piece in line])
    ends = np.concatenate([piece.places(np.array([1.0])) for piece in line])
    cells, _, distances = part.closest(starts)
    pair.check(starts, [distances])
    stays = np.array([piece.straight for piece in line]) & part.flat[cells]
    stays &= part.holds(cells, starts) & part.holds(cells, ends)
    pair.check(ends[stays], [part.distances(cells[stays], ends[stays])])
    stays[stays] = part.are_closest(cells[stays], ends[stays])
    return [[(1.0, int(cell))] if only else _way(part, piece, pair)
            for piece, cell, only in zip(line, cells, stays, strict=True)]


def _just_ahead(part: Cells, piece: Piece, t: float) -> float:
    """Parameter a little further on a piece, where the cell tells that comes next."""
    pace = np.linalg.norm(piece.slopes(np.array([0.5]))[0])
    return min(t + AHEAD * part.sizes.min() / pace, (t + 1.0) / 2)


def _way(part: Cells, piece: Piece, pair: Pair) -> list[tuple[float, int]]:
    """Parameters at which a piece leaves cells of a part, one after the other, and these cells."""
    way, t = [], 0.0
    pace = np.linalg.norm(piece.slopes(np.array([0.5]))[0])
    while t < 1.0:
        ahead = _just_ahead(part, piece, t)
        point = piece.places(np.array([ahead]))
        cells, _, distances = part.closest(point)
        pair.check(point, [distances])
        t = _leaves(part, int(cells[0]), piece, ahead, part.sizes[cells[0]] / pace / 2)
        way.append((t, int(cells[0])))
    end = piece.places(np.array([1.0]))
    pair.check(end, [part.distances(cells, end)])
    return way


def _leaves(part: Cells, cell: int, piece: Piece, t: float, step: float) -> float:
    """Parameter at which a piece leaves a cell that it is in, or closest to; 1 at its end."""
    def place(at: float) -> np.ndarray:
        return piece.places(np.array([at]))[0]

    start = t
    while t < 1.0:
        further = min(t + step, 1.0)
        beside, margins = part.margins(cell, place(t))
        left = np.flatnonzero((margins(place(further)) < -OUTSIDE) & (margins(place(t)) >= -OUTSIDE))
        ends = [_zero(lambda at, n=n, margins=margins: margins(place(at))[n], t, further) for n in left]
        last = min(ends, default=further)
        may_be_left = not ends if beside else last in (1.0, *ends)
        if may_be_left and not part.are_closest(np.array([cell]), place(last)[None])[0]:
            ends = [part.given_over(cell, place, start, last)]
        if ends:
            return 1.0 if min(ends) > 1.0 - OUTSIDE else min(ends)
        t = further
    return 1.0


def _zero(function, low: float, high: float) -> float:
    return low if function(low) <= 0 else brentq(function, low, high, xtol=1e-15, rtol=1e-14)
