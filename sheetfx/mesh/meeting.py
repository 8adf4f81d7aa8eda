"""Where two parts meet: points of an interface, the cells of both parts there, and the grid of its multipliers."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import basix
import numpy as np
from scipy.optimize import brentq
from scipy.spatial import cKDTree

from .lines import SAME, Piece
from .projection import OUTSIDE, Cells
from .quadrature import gauss
from .reader import NamedMesh

AHEAD = 1e-5  # how far ahead of a border the next cell is looked for, over the size of a cell
SHORT = 0.5  # pieces of the multipliers' grid are at least this part of a cell
MOST = 2**20  # above the number of shape functions at one place


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


@dataclass(frozen=True)
class Meeting:
    """Points of an interface that this process answers for.

    Attributes
    ----------
    sides : of the first and the second part
    weights : length that each point stands for; 1 for single points
    nodes, hats : shape (n, k), at each point the numbers of the shape functions of multipliers, and their values
    origins : numbers that tell the shape functions from each other on any number of processes
    size : of the cells at the interface, of the finer part
    """

    sides: tuple[Side, Side]
    weights: np.ndarray
    nodes: np.ndarray
    hats: np.ndarray
    origins: np.ndarray
    size: float


class _Pair:
    """Both parts, and how far they may be apart."""

    def __init__(self, first: Cells, second: Cells, reach: float, name: str):
        self.parts, self._name = (first, second), name
        self._tolerance = SAME * max(c.mesh.size for c in self.parts)
        self._reach = reach

    def check(self, points: np.ndarray, distances: Sequence[np.ndarray]) -> None:
        """Refuse points that are off a part."""
        both = np.sum(distances, axis=0)
        if len(both) and not both.max() <= self._reach + self._tolerance:
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


def at_points(first: Cells, second: Cells, points: np.ndarray, others: np.ndarray | None, reach: float,
              name: str) -> Meeting:
    """Meeting of two parts at single points.

    Parameters
    ----------
    points : places on the first part, the same on all processes
    others : places on the second part, one for a single point, or one close to each; None: the closest
    reach : distance that rigid arms may bridge; of a single point with another one it does not matter
    name : of the joint, for messages

    Raises
    ------
    ValueError
        If points are off a part, or the cells of both parts are on different processes.
    """
    pair, comm = _Pair(first, second, reach, name), first.mesh.domain.comm
    if others is None:
        others = points
    elif not len(points) == len(others) == 1:
        apart, order = cKDTree(others).query(points)
        if len(set(order)) < len(points):
            raise ValueError(f"{name}: its {len(points)} points do not match the {len(others)} that they are joined "
                             "to; name as many")
        pair.check(points, [apart])
        others = others[order]
    found = [part.closest(p) for part, p in zip(pair.parts, (points, others), strict=True)]
    least = [np.min(comm.allgather(distances), axis=0) for *_, distances in found]
    pair.check(points, least)
    here = np.all([f[2] <= d + SAME * first.mesh.size for f, d in zip(found, least, strict=True)], axis=0)
    ranks = np.array(comm.allgather(here))
    if not ranks.any(axis=0).all():
        raise ValueError(f"{name}: its parts stand on different ones of the {comm.size} processes, which is not "
                         "possible yet; take one process")
    own = np.flatnonzero(ranks.argmax(axis=0) == comm.rank)
    sides = tuple(pair.side(n, which[own], reference[own]) for n, (which, reference, _) in enumerate(found))
    every = np.arange(len(own))[:, None]
    size = min((c.sizes.mean() for c in pair.parts if len(c.cells)), default=1.0)
    return Meeting(sides, np.ones(len(own)), every, np.ones(every.shape), own, float(size))


def along_lines(first: Cells, second: Cells, lines: Sequence[Sequence[Piece]], reach: float, degree: int,
                name: str) -> Meeting:
    """Meeting of two parts along lines, at Gauss points of segments that end at the borders of cells of both.

    The multipliers are linear and continuous along each line, on the cells of the part that has the larger ones there
    (Hueeber, Mair and Wohlmuth 2005, for displacements of degree two). Cells of which a line has less than half do not
    count by themselves, but with their neighbours; on a line inside of a cell the multipliers are linear, which came
    nearer to the stiffness of finer meshes than constant ones.

    Parameters
    ----------
    degree : number of Gauss points on a segment
    reach, name : as of `at_points`

    Raises
    ------
    ValueError
        If a line is off a part.
    """
    pair, rule, count = _Pair(first, second, reach, name), gauss(basix.CellType.interval, degree), 0
    points, weights, nodes, hats, cells, sizes = [], [], [], [], [], []
    for line in lines:
        segments = _segments(line, pair)
        own = np.array([s.cells for s in segments])
        arc = np.concatenate(([0.0], np.cumsum([s.length for s in segments])))
        sizes.append([part.sizes[np.unique(c)].mean() for part, c in zip(pair.parts, own.T, strict=True)])
        coarse = int(np.argmax(sizes[-1]))
        borders = arc[1:-1][np.diff(own[:, coarse]) != 0]
        grid = _grid(borders, arc[-1], sizes[-1][coarse])
        for segment, start in zip(segments, arc[:-1], strict=True):
            share = segment.end - segment.begin
            t = segment.begin + share * rule.points[:, 0]
            points.append(segment.piece.places(t))
            weights.append(share * rule.weights * np.linalg.norm(segment.piece.slopes(t), axis=1))
            numbers, values = _hats(grid, start + segment.length * rule.points[:, 0])
            nodes.append(numbers + count)
            hats.append(values)
        cells.append(np.repeat(own, len(rule.weights), axis=0))
        count += len(grid)
    places, cells = np.concatenate(points), np.concatenate(cells)
    sides = tuple(pair.side(n, cells[:, n], part.nearest(cells[:, n], places)) for n, part in enumerate(pair.parts))
    return Meeting(sides, np.concatenate(weights), np.concatenate(nodes), np.concatenate(hats), np.arange(count),
                   float(np.min(sizes)))


def at_pairs(first: Cells, second: Cells, lines: Sequence[Sequence[Piece]], count: int, reach: float,
             name: str) -> Meeting:
    """Meeting of two parts at points that divide each line evenly, in the middles of equal lengths.

    Parameters
    ----------
    count : number of points on each line
    reach, name : as of `at_points`

    Raises
    ------
    ValueError
        If a point is off a part.
    """
    pair, points, weights = _Pair(first, second, reach, name), [], []
    for line in lines:
        ends = np.cumsum([piece.length() for piece in line])
        for wanted in ends[-1] * (np.arange(count) + 0.5) / count:
            n = int(np.searchsorted(ends, wanted))
            part = line[n].until(wanted - (ends[n - 1] if n else 0.0))
            points.append(part.places(np.array([1.0]))[0])
        weights.append(np.full(count, ends[-1] / count))
    places = np.array(points)
    sides = []
    for number, part in enumerate(pair.parts):
        which, reference, distances = part.closest(places)
        pair.check(places, [distances])
        sides.append(pair.side(number, which, reference))
    every = np.arange(len(places))[:, None]
    size = float(min(part.sizes.mean() for part in pair.parts))
    return Meeting((sides[0], sides[1]), np.concatenate(weights), every, np.ones(every.shape), every[:, 0], size)


def merged(meetings: Sequence[Meeting]) -> Meeting:
    """One meeting of the same two parts at several places, which all are lines or all are points."""
    counts = np.cumsum([0, *(len(m.origins) for m in meetings)])
    sides = [_merged_sides([m.sides[n] for m in meetings]) for n in (0, 1)]
    return Meeting((sides[0], sides[1]), np.concatenate([m.weights for m in meetings]),
                   np.concatenate([m.nodes + before for m, before in zip(meetings, counts, strict=False)]),
                   np.concatenate([m.hats for m in meetings]),
                   np.concatenate([m.origins + n * MOST for n, m in enumerate(meetings)]),
                   min(m.size for m in meetings))


def _merged_sides(sides: Sequence[Side]) -> Side:
    normals = None if sides[0].normals is None else np.concatenate([s.normals for s in sides])
    return Side(*(np.concatenate([getattr(s, name) for s in sides]) for name in ("cells", "reference", "places")),
                normals)


def refuse_processes(mesh: NamedMesh, name: str) -> None:
    """Refuse a joint along a line, of which each process would have a part."""
    comm = mesh.domain.comm
    if comm.size > 1:
        raise ValueError(f"{name}: a joint along a line on {comm.size} processes is not possible yet; take one process")


@dataclass(frozen=True)
class _Segment:
    """Part of a piece, between two parameters, that is in one cell of each part."""

    piece: Piece
    begin: float
    end: float
    length: float
    cells: tuple[int, ...]


def _segments(line: Sequence[Piece], pair: _Pair) -> list[_Segment]:
    segments = []
    for piece, *ways in zip(line, *(_ways(part, line, pair) for part in pair.parts), strict=True):
        begin = 0.0
        for end in sorted({t for way in ways for t, _ in way}):
            if end - begin > OUTSIDE:
                cells = tuple(next(cell for t, cell in way if t > (begin + end) / 2) for way in ways)
                segments.append(_Segment(piece, begin, end, piece.length(end) - piece.length(begin), cells))
                begin = end
    return segments


def _ways(part: Cells, line: Sequence[Piece], pair: _Pair) -> list[list[tuple[float, int]]]:
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


def _way(part: Cells, piece: Piece, pair: _Pair) -> list[tuple[float, int]]:
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


def _grid(borders: np.ndarray, length: float, size: float) -> np.ndarray:
    """Ends of a line, and those borders between which multipliers are linear."""
    grid = [0.0]
    for border in borders:
        if min(border - grid[-1], length - border) >= SHORT * size:
            grid.append(border)
    return np.array([*grid, length])


def _hats(grid: np.ndarray, arc: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """At points of a line the two shape functions of its grid that are not zero."""
    place = np.clip(np.searchsorted(grid, arc) - 1, 0, len(grid) - 2)
    share = (arc - grid[place]) / (grid[place + 1] - grid[place])
    return np.column_stack((place, place + 1)), np.column_stack((1 - share, share))
