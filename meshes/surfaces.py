"""Surfaces for shells: rectangles in the plane of parameters, and assemblies of flat panels."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from itertools import pairwise

import gmsh

from ..checks import Count, Positive, checked, require_known


@checked
def rectangle(
    cells: tuple[Count, Count],
    lengths: tuple[Positive, Positive] = (1.0, 1.0),
    triangles: bool = False,
    points: Mapping[str, tuple[float, float]] | None = None,
    name: str = "shell",
) -> None:
    """Rectangle from the origin in the x-y plane in equal cells, to be placed in space by `read(place=...)`.

    Its edges are named west (x = 0), east, south (y = 0) and north, its corners south-west and so on.

    Parameters
    ----------
    cells : number of cells along x and y
    lengths : length
    triangles : cut each quadrilateral in two
    points : further names for corners
    name : physical group of the surface
    """
    geo, (a, b) = gmsh.model.geo, lengths
    places = {"south-west": (0, 0), "south-east": (a, 0), "north-east": (a, b), "north-west": (0, b)}
    corners = {label: geo.addPoint(x, y, 0) for label, (x, y) in places.items()}
    tags = list(corners.values())
    edges = {label: geo.addLine(tags[i], tags[(i + 1) % 4])
             for i, label in enumerate(("south", "east", "north", "west"))}
    surface = geo.addPlaneSurface([geo.addCurveLoop(list(edges.values()))])
    for label, edge in edges.items():
        geo.mesh.setTransfiniteCurve(edge, cells[label in ("east", "west")] + 1)
    geo.mesh.setTransfiniteSurface(surface, "Left", tags)
    if not triangles:
        geo.mesh.setRecombine(2, surface)
    geo.synchronize()
    gmsh.model.addPhysicalGroup(2, [surface], name=name)
    for label, edge in edges.items():
        gmsh.model.addPhysicalGroup(1, [edge], name=label)
    for label, corner in corners.items():
        gmsh.model.addPhysicalGroup(0, [corner], name=label)
    for label, place in (points or {}).items():
        if tuple(place) not in places.values():
            raise ValueError(f"rectangle: the point {label!r} is at {tuple(place)}; it must be at a corner, one of "
                             f"{', '.join(map(str, places.values()))}")
        corner = next(corners[c] for c, p in places.items() if p == tuple(place))
        gmsh.model.addPhysicalGroup(0, [corner], name=label)


@checked
def panels(
    nodes: Mapping[str, tuple[float, float, float]],
    faces: Mapping[str, str | Sequence[str]],
    cells: Count,
    triangles: bool = False,
) -> None:
    """Flat panels between named nodes, joined along shared edges.

    Parameters
    ----------
    nodes : name -> coordinates (3 numbers)
    faces : name -> names of 3 or 4 nodes around the panel; each panel is a physical group
    cells : number of cells along each edge; even where quadrilaterals fill panels of three nodes, whose triangles
        are cut in three
    triangles : triangular cells
    """
    for name, corners in faces.items():
        require_known(f"panels: node of panel {name!r}", corners, nodes)
    geo = gmsh.model.geo
    used = {name for corners in faces.values() for name in corners}
    tags = {name: geo.addPoint(*x) for name, x in nodes.items() if name in used}
    lines = Lines(tags, pieces(faces.values(), cells, triangles))
    groups = {name: lines.fill(corners, triangles) for name, corners in faces.items()}
    geo.synchronize()
    for name, surface in groups.items():
        gmsh.model.addPhysicalGroup(2, surface, name=name)
    for (a, b), edge in lines.made.items():
        gmsh.model.addPhysicalGroup(1, [edge], name=f"{a}-{b}")
    for name, tag in tags.items():
        gmsh.model.addPhysicalGroup(0, [tag], name=name)


def pieces(faces: Iterable[Sequence[str]], cells: int, triangles: bool) -> int:
    """Number of pieces to give lines, for so many cells along the edges of panels of three or four nodes."""
    gmsh.option.setNumber("Mesh.TransfiniteTri", 1)
    if cells < 1:
        raise ValueError(f"panels: {cells} cells along their edges; the number must be 1 or more")
    if triangles or all(len(corners) == 4 for corners in faces):
        return cells
    if cells % 2:
        raise ValueError(f"panels: {cells} cells along the edges of panels of three nodes, in quadrilaterals; the "
                         "number must be even, or the cells triangles")
    gmsh.option.setNumber("Mesh.SubdivisionAlgorithm", 1)
    return cells // 2


class Lines:
    """Straight lines between named points, each made once, and flat surfaces between them.

    Parameters
    ----------
    tags : name -> gmsh's point
    pieces : number of cells on each line
    """

    def __init__(self, tags: Mapping[str, int], pieces: int):
        self._tags, self._pieces = tags, pieces
        self.made: dict[tuple[str, str], int] = {}

    def line(self, a: str, b: str) -> list[int]:
        """gmsh's curve from one point to another, negative where it is made the other way."""
        if (b, a) in self.made:
            return [-self.made[b, a]]
        if (a, b) not in self.made:
            self.made[a, b] = gmsh.model.geo.addLine(self._tags[a], self._tags[b])
            gmsh.model.geo.mesh.setTransfiniteCurve(self.made[a, b], self._pieces + 1)
        return [self.made[a, b]]

    def fill(self, corners: Sequence[str], triangles: bool) -> list[int]:
        """gmsh's surface between three or four points, in regular cells."""
        geo = gmsh.model.geo
        loop = [curve for ends in around(corners) for curve in self.line(*ends)]
        surface = geo.addPlaneSurface([geo.addCurveLoop(loop)])
        geo.mesh.setTransfiniteSurface(surface, "Left", [self._tags[c] for c in corners])
        if not triangles and len(corners) == 4:
            geo.mesh.setRecombine(2, surface)
        return [surface]


def around(corners: Sequence[str]) -> list[tuple[str, str]]:
    """Pairs of nodes at the ends of the edges of a panel."""
    return list(pairwise([*corners, corners[0]]))
