"""Surfaces for shells: rectangles in the plane of parameters, and assemblies of flat panels."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import gmsh


def rectangle(
    cells: tuple[int, int],
    lengths: tuple[float, float] = (1.0, 1.0),
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
        corner = next(corners[c] for c, p in places.items() if p == place)
        gmsh.model.addPhysicalGroup(0, [corner], name=label)


def panels(
    nodes: Mapping[str, Sequence[float]],
    faces: Mapping[str, Sequence[str]],
    cells: int,
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
    cut = not triangles and any(len(corners) == 3 for corners in faces.values())
    if cut:
        if cells % 2:
            raise ValueError(f"panels: {cells} cells along the edges of panels of three nodes; the number must be even")
        gmsh.option.setNumber("Mesh.SubdivisionAlgorithm", 1)
    geo = gmsh.model.geo
    used = {name for corners in faces.values() for name in corners}
    tags = {name: geo.addPoint(*x) for name, x in nodes.items() if name in used}
    lines: dict[tuple[str, str], int] = {}

    def line(a, b):
        if (b, a) in lines:
            return -lines[b, a]
        if (a, b) not in lines:
            lines[a, b] = geo.addLine(tags[a], tags[b])
            geo.mesh.setTransfiniteCurve(lines[a, b], (cells // 2 if cut else cells) + 1)
        return lines[a, b]

    groups = {}
    for name, corners in faces.items():
        loop = geo.addCurveLoop([line(a, b) for a, b in zip(corners, [*corners[1:], corners[0]], strict=True)])
        groups[name] = geo.addPlaneSurface([loop])
        geo.mesh.setTransfiniteSurface(groups[name], "Left", [tags[c] for c in corners])
        if not triangles and len(corners) == 4:
            geo.mesh.setRecombine(2, groups[name])
    geo.synchronize()
    for name, surface in groups.items():
        gmsh.model.addPhysicalGroup(2, [surface], name=name)
    for (a, b), edge in lines.items():
        gmsh.model.addPhysicalGroup(1, [edge], name=f"{a}-{b}")
    for name, tag in tags.items():
        gmsh.model.addPhysicalGroup(0, [tag], name=name)
