"""Lines in space along which parts meet: named edges and curves, and stretches of these."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import cos, radians
from typing import Annotated

import basix
import numpy as np

from ..checks import NONZERO, NotNegative, Positive, check
from ..compat import geometry_nodes
from .reader import NamedMesh

CORNER = cos(radians(30.0))  # of the angle by which a line turns where one ends and the next begins
ROUNDING = 1e-14  # relative error of a length
LONGER = 1e-9  # by what part a stretch may be longer than its line
INTERVAL = basix.create_element(basix.ElementFamily.P, basix.CellType.interval, 1)
FINE = basix.make_quadrature(basix.CellType.interval, 15)


@dataclass(frozen=True)
class Piece:
    """A smooth piece of a line: the straight way between two reference points of a cell.

    Attributes
    ----------
    shape : basix element of the cell's geometry
    nodes : shape (k, dimension), places of its nodes
    ends : shape (2, reference dimension)
    """

    shape: object
    nodes: np.ndarray
    ends: np.ndarray

    @property
    def straight(self) -> bool:
        """Whether it is, as edges of cells whose geometry is linear are."""
        return self.shape.degree == 1

    @classmethod
    def between(cls, first: np.ndarray, last: np.ndarray) -> Piece:
        return cls(INTERVAL, np.array([first, last]), np.array([[0.0], [1.0]]))

    def _reference(self, t: np.ndarray) -> np.ndarray:
        return self.ends[0] + np.asarray(t)[:, None] * (self.ends[1] - self.ends[0])

    def places(self, t: np.ndarray) -> np.ndarray:
        """Places at parameters between 0 and 1."""
        return self.shape.tabulate(0, self._reference(t))[0, :, :, 0] @ self.nodes

    def slopes(self, t: np.ndarray) -> np.ndarray:
        """Derivatives of the places."""
        table = self.shape.tabulate(1, self._reference(t))[1:, :, :, 0]
        return np.einsum("tnk,kd,t->nd", table, self.nodes, self.ends[1] - self.ends[0])

    def length(self, end: float = 1.0) -> float:
        """Length from its beginning to a parameter."""
        return float(end * FINE[1] @ np.linalg.norm(self.slopes(end * FINE[0][:, 0]), axis=1))

    def until(self, length: float) -> Piece:
        """Its beginning, of a given length."""
        t = length / self.length()
        for _ in range(50):
            off = self.length(t) - length
            t -= off / np.linalg.norm(self.slopes(np.array([t]))[0])
            if abs(off) <= ROUNDING * length:
                break
        return Piece(self.shape, self.nodes, np.array([self.ends[0], self._reference(np.array([t]))[0]]))

    def turned(self) -> Piece:
        """The same from its end to its beginning."""
        return Piece(self.shape, self.nodes, self.ends[::-1])


Vector = tuple[float, float] | tuple[float, float, float]


@dataclass(frozen=True)
class Stretch:
    """A stretch of a line: a weld that is shorter than an edge or a bar.

    It goes straight from `start` to `end`, or for a `length` from `start` in a direction, or for that length from
    `start`, or from where is a length `after` it, along an edge or group of curves of the first part that begins there.

    Attributes
    ----------
    start, end : names of points of the first part's mesh, or places
    along : name of an edge or group of curves, or a direction
    length : length
    after : length between `start` and its beginning, along a name
    """

    start: str | Vector
    end: str | Vector | None = None
    along: str | Annotated[Vector, NONZERO] | None = None
    length: Positive | None = None
    after: NotNegative = 0.0

    def __post_init__(self):
        check(self)
        if (self.end is None) == (self.along is None) or (self.along is None) != (self.length is None):
            raise ValueError(f"Stretch from {self.start!r}: give either its end, or what it goes along and its length")
        if self.after and not isinstance(self.along, str):
            raise ValueError(f"Stretch from {self.start!r}: after is {self.after:g} along no edge or curves; name "
                             "them in along")

    def lines(self, mesh: NamedMesh) -> list[list[Piece]]:
        """Its line, as `lines_of` gives them.

        Raises
        ------
        ValueError
            If it has no length, is longer than what it goes along, or does not begin at its end.
        """
        start = place_of(mesh, self.start)
        if isinstance(self.along, str):
            return [self._part(lines_of(mesh, self.along), start, SAME * mesh.size)]
        if self.end is not None:
            way = place_of(mesh, self.end) - start
        else:
            size = np.linalg.norm(self.along)
            way = np.asarray(self.along, dtype=float) * (self.length / size if size else 0.0)
        if not np.linalg.norm(way) > SAME * mesh.size:
            raise ValueError(f"Stretch from {self.start!r}: has no length; give an end elsewhere, or a direction")
        return [[Piece.between(start, start + way)]]

    def _part(self, lines: Sequence[Sequence[Piece]], start: np.ndarray, near: float) -> list[Piece]:
        """Of lines the part that begins at a place and has the length."""
        zero, one = np.array([0.0]), np.array([1.0])
        both = [*lines, *([p.turned() for p in reversed(line)] for line in lines)]
        begin = [line for line in both if np.linalg.norm(line[0].places(zero)[0] - start) <= near]
        if not begin:
            for line in both:
                for n, piece in enumerate(line[:-1]):
                    if np.linalg.norm(piece.places(one)[0] - start) <= near:
                        begin.append(list(line[n + 1:]))
        if len(begin) != 1:
            found = "does not touch its start" if not begin else f"leaves its start in {len(begin)} directions"
            raise ValueError(f"Stretch from {self.start!r}: {self.along!r} {found}; give a direction, or an end")
        part, before, left = [], self.after, self.length
        for piece in begin[0]:
            length = piece.length()
            if length <= before * (1 + LONGER):
                before -= length
                continue
            if before > length * LONGER:
                piece = piece.turned().until(length - before).turned()
                length -= before
            before = 0.0
            if length >= left * (1 - LONGER):
                return [*part, piece if length <= left * (1 + LONGER) else piece.until(left)]
            part.append(piece)
            left -= length
        there = self.after + self.length - left - before
        raise ValueError(f"Stretch from {self.start!r}: its length {self.after + self.length:.6g} is more than the "
                         f"{there:.6g} of {self.along!r}; shorten it")


SAME = 1e-6  # distance of places that count as one, over the size of the mesh


def place_of(mesh: NamedMesh, at: str | Sequence[float]) -> np.ndarray:
    """A place, or a named point's.

    Raises
    ------
    ValueError
        If it has another number of components, or the name stands for several points.
    """
    if not isinstance(at, str):
        if len(at) != mesh.dimension:
            raise ValueError(f"place {tuple(at)} has {len(at)} components; give {mesh.dimension}")
        return np.asarray(at, dtype=float)
    places = places_of(mesh, at)
    if len(places) != 1:
        raise ValueError(f"{at!r} stands for {len(places)} points; name a single one")
    return places[0]


def places_of(mesh: NamedMesh, at: str) -> np.ndarray:
    """Places of a named point's vertices, the same on all processes."""
    if at not in mesh.points:
        raise ValueError(f"the mesh has no point named {at!r}; it has {', '.join(mesh.points)}")
    topology = mesh.domain.topology
    vertices = mesh.points[at]
    vertices = vertices[vertices < topology.index_map(0).size_local]
    topology.create_connectivity(0, topology.dim)
    topology.create_connectivity(topology.dim, 0)
    to_cells, corners = topology.connectivity(0, topology.dim), topology.connectivity(topology.dim, 0)
    nodes = geometry_nodes(mesh.domain)
    found = [np.empty((0, mesh.dimension))]
    for vertex in vertices:
        cell = to_cells.links(vertex)[0]
        corner = np.flatnonzero(corners.links(cell) == vertex)[0]
        found.append(mesh.domain.geometry.x[nodes[cell, corner], : mesh.dimension][None])
    return np.concatenate(mesh.comm.allgather(np.concatenate(found)))


def lines_of(mesh: NamedMesh, name: str) -> list[list[Piece]]:
    """Lines of a named edge of a surface, or of a group of curves: pieces one behind the other.

    A line ends where others meet it, and where it turns by more than 30 degrees.
    """
    topology, nodes = mesh.domain.topology, geometry_nodes(mesh.domain)
    kind = mesh.domain.basix_cell()
    shape = mesh.domain.ufl_domain().ufl_coordinate_element().basix_element
    topology.create_connectivity(topology.dim, 0)
    corners = topology.connectivity(topology.dim, 0)
    if topology.dim == 1:
        sides = [(cell, [0, 1]) for cell in mesh.group(name)]
    else:
        facets = basix.topology(kind)[1]
        sides = [(cell, facets[facet]) for cell, facet in mesh.sides(mesh.edges[name]).reshape(-1, 2)]
    geometry = basix.geometry(kind)
    pieces = [Piece(shape, mesh.domain.geometry.x[nodes[cell], : mesh.dimension], geometry[list(ends)])
              for cell, ends in sides]
    return _joined(pieces, [tuple(corners.links(cell)[list(ends)].tolist()) for cell, ends in sides])


def _joined(pieces: Sequence[Piece], vertices: Sequence[tuple[int, int]]) -> list[list[Piece]]:
    """Pieces between pairs of vertices, in lines."""
    at: dict[int, list[tuple[int, bool]]] = {}
    for number, (first, last) in enumerate(vertices):
        at.setdefault(first, []).append((number, False))
        at.setdefault(last, []).append((number, True))

    def directed(number: int, turned: bool) -> Piece:
        return pieces[number].turned() if turned else pieces[number]

    def goes_on(vertex: int) -> bool:
        if len(at[vertex]) != 2:
            return False
        one, two = (directed(*end).slopes(np.array([0.0]))[0] for end in at[vertex])
        return -one @ two > CORNER * np.linalg.norm(one) * np.linalg.norm(two)

    lines: list[list[Piece]] = []
    left = set(range(len(pieces)))
    starts = [(end, vertex) for vertex in at if not goes_on(vertex) for end in at[vertex]]
    for (number, turned), _ in [*starts, *(((n, False), None) for n in range(len(pieces)))]:
        line = []
        while number in left:
            left.remove(number)
            line.append(directed(number, turned))
            vertex = vertices[number][0 if turned else 1]
            if not goes_on(vertex):
                break
            number, turned = next(end for end in at[vertex] if end[0] != number)
        if line:
            lines.append(line)
    return lines
