"""Where two parts meet: points of an interface, the cells of both parts there, and the grid of its multipliers."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import basix
import numpy as np
from scipy.spatial import cKDTree

from .lines import Piece
from .projection import Cells
from .quadrature import gauss
from .segments import Pair, Segment, Side, divided

SHORT = 0.5  # pieces of the multipliers' grid are at least this part of a cell
MOST = 2**20  # above the number of shape functions at one place


@dataclass(frozen=True)
class Line:
    """A line along which two parts meet.

    Attributes
    ----------
    name : of the joint and the place
    length : of the line
    cell : mean length along the line of the cells that it passes, of the part that has the larger ones
    """

    name: str
    length: float
    cell: float

    @property
    def short(self) -> bool:
        """Whether it is shorter than half a cell: the fields of the cell do not tell it from a longer one."""
        return self.length < SHORT * self.cell


@dataclass(frozen=True)
class Meeting:
    """Points of an interface.

    Attributes
    ----------
    sides : of the first and the second part
    weights : length that each point stands for; 1 for single points
    nodes, hats : shape (n, k), at each point the numbers of the shape functions of multipliers, and their values
    origins : numbers that tell the shape functions from each other on any number of processes
    size : of the cells at the interface, of the finer part
    lines : along which they meet; none where they meet at points
    """

    sides: tuple[Side, Side]
    weights: np.ndarray
    nodes: np.ndarray
    hats: np.ndarray
    origins: np.ndarray
    size: float
    lines: tuple[Line, ...] = ()


def at_points(first: Cells, second: Cells, points: np.ndarray, others: np.ndarray | None, reach: float,
              name: str) -> Meeting:
    """Meeting of two parts at single points.

    Parameters
    ----------
    points : places on the first part
    others : places on the second part, one for a single point, or one close to each; None: the closest
    reach : distance that rigid arms may bridge; of a single point with another one it does not matter
    name : of the joint, for messages

    Raises
    ------
    ValueError
        If points are off a part.
    """
    pair = Pair(first, second, reach, name)
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
    pair.check(points, [distances for *_, distances in found])
    sides = (pair.side(n, which, reference) for n, (which, reference, _) in enumerate(found))
    every = np.arange(len(points))[:, None]
    size = min((c.sizes.mean() for c in pair.parts if len(c.cells)), default=1.0)
    return Meeting(tuple(sides), np.ones(len(points)), every, np.ones(every.shape), every[:, 0], float(size))


def over_area(first: Cells, second: Cells, points: np.ndarray, shares: np.ndarray, others: np.ndarray | None,
              reach: float, name: str) -> Meeting:
    """Meeting of two parts in the mean over an area.

    Parameters
    ----------
    points, shares : places on the first part, and their shares of the area
    others : one place on the second part; None: the closest to each
    reach, name : as of `at_points`
    """
    pair = Pair(first, second, reach, name)
    there = points if others is None else np.repeat(others[:1], len(points), axis=0)
    found = [part.closest(p) for part, p in zip(pair.parts, (points, there), strict=True)]
    if others is None:
        pair.check(points, [found[1][2]])
    sides = (pair.side(n, which, reference) for n, (which, reference, _) in enumerate(found))
    size = min((c.sizes.mean() for c in pair.parts if len(c.cells)), default=1.0)
    one = np.zeros((len(points), 1), dtype=np.int64)
    return Meeting(tuple(sides), shares, one, np.ones(one.shape), one[0], float(size))


def along_lines(first: Cells, second: Cells, lines: Sequence[Sequence[Piece]], reach: float, degree: int,
                name: str, tied: bool = False) -> Meeting:
    """Meeting of two parts along lines, at Gauss points of segments that end at the borders of cells of both.

    The multipliers are linear and continuous along each line, on the cells of the part that has the larger ones there
    (Hueeber, Mair and Wohlmuth 2005, for displacements of degree two). Cells of which a line has less than half do not
    count by themselves, but with their neighbours; on a line inside of a cell the multipliers are linear, which came
    nearer to the stiffness of finer meshes than constant ones.

    Parameters
    ----------
    degree : number of Gauss points on a segment
    reach, name : as of `at_points`
    tied : whether places count at which each part is closest to the other, where these are less than half a cell beside
        the line, which the fields of the cell do not tell from it

    Raises
    ------
    ValueError
        If a line is off a part.
    """
    pair, rule, count = Pair(first, second, reach, name), gauss(basix.CellType.interval, degree), 0
    points, weights, nodes, hats, cells, sizes, told = [], [], [], [], [], [], []
    for line in lines:
        segments = divided(line, pair)
        own = np.array([s.cells for s in segments])
        arc = np.concatenate(([0.0], np.cumsum([s.length for s in segments])))
        sizes.append([part.sizes[np.unique(c)].mean() for part, c in zip(pair.parts, own.T, strict=True)])
        coarse = int(np.argmax(sizes[-1]))
        told.append(Line(name, arc[-1], max(_passed(part, segments, n) for n, part in enumerate(pair.parts))))
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
    found = [part.nearest(cells[:, n], places) for n, part in enumerate(pair.parts)]
    if tied:
        _seat(pair, cells, found)
    sides = tuple(pair.side(n, cells[:, n], reference) for n, reference in enumerate(found))
    return Meeting(sides, np.concatenate(weights), np.concatenate(nodes), np.concatenate(hats), np.arange(count),
                   float(np.min(sizes)), tuple(told))


def _seat(pair: Pair, cells: np.ndarray, found: list[np.ndarray]) -> None:
    """Move points of a line, less than half a cell, to where each part is closest to the other.

    Parameters
    ----------
    cells, found : at the points the numbers of the cells of both parts, shape (n, 2), and reference points in them;
        both are changed
    """
    for n, part in enumerate(pair.parts):
        other = pair.parts[1 - n]
        here, there = part.places(cells[:, n], found[n]), other.places(cells[:, 1 - n], found[1 - n])
        which, reference = _beside(part, cells[:, n], there, pair.tolerance)
        place = part.places(which, reference)
        back = other.places(*_beside(other, cells[:, 1 - n], place, pair.tolerance))
        moved, off = np.linalg.norm(place - here, axis=1), np.linalg.norm(back - there, axis=1)
        seated = (off <= pair.tolerance) & (moved < SHORT * part.sizes[which])
        cells[seated, n], found[n][seated] = which[seated], reference[seated]


def _beside(part: Cells, near: np.ndarray, points: np.ndarray, tolerance: float) -> tuple[np.ndarray, np.ndarray]:
    """Of given cells and those around them, not beyond a seam, the closest to points, and reference points in them."""
    which, reference = near.copy(), part.nearest(near, points)
    inside = part.holds(near, points) | (np.linalg.norm(part.places(near, reference) - points, axis=1) <= tolerance)
    for point in np.flatnonzero(~inside):
        around = part.around(which[point])
        along = np.tile(points[point], (len(around), 1))
        which[point] = around[np.argmin(part.distances(around, along))]
        reference[[point]] = part.nearest(which[[point]], along[:1])
    return which, reference


def _passed(part: Cells, segments: Sequence[Segment], number: int) -> float:
    """Mean length of a part's cells along the segments in them; `number` is the part's."""
    middles = [np.array([(s.begin + s.end) / 2]) for s in segments]
    ways = np.array([s.piece.slopes(t)[0] for s, t in zip(segments, middles, strict=True)])
    places = np.array([s.piece.places(t)[0] for s, t in zip(segments, middles, strict=True)])
    cells = np.array([s.cells[number] for s in segments])
    return float(part.passed(cells, places, ways / np.linalg.norm(ways, axis=1, keepdims=True)).mean())


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
    pair, points, weights = Pair(first, second, reach, name), [], []
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
                   min(m.size for m in meetings), tuple(line for m in meetings for line in m.lines))


def _merged_sides(sides: Sequence[Side]) -> Side:
    normals = None if sides[0].normals is None else np.concatenate([s.normals for s in sides])
    return Side(*(np.concatenate([getattr(s, name) for s in sides]) for name in ("cells", "reference", "places")),
                normals)


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
