"""Thin-walled profiles: flat walls between the corners of a section, along a straight length."""

from __future__ import annotations

from collections.abc import Mapping

import gmsh

from ..checks import Count, Positive, checked, require_known


@checked
def profile(
    corners: Mapping[str, tuple[float, float]],
    walls: Mapping[str, tuple[str, str, Count]],
    length: Positive,
    cells: Count,
    triangles: bool = False,
) -> None:
    """Walls of a section in the y-z plane, along x from 0 to a length, joined where they share corners.

    Each wall is a physical group; so are the lines along the corners by the corners' names, the ends of walls, named
    "WALL at start" and "WALL at end", and the ends of these lines, "CORNER at start" and "CORNER at end".

    Parameters
    ----------
    corners : name -> (y, z) of the section
    walls : name -> (first corner, last corner, number of cells between them); any number of walls may meet in a corner
    length : along x
    cells : number of cells along the length
    triangles : triangular cells
    """
    for wall, ends_of_wall in walls.items():
        require_known(f"profile: corner of wall {wall!r}", ends_of_wall[:2], corners)
    geo, ends = gmsh.model.geo, {"start": 0.0, "end": length}
    points = {(name, end): geo.addPoint(x, *corners[name]) for name in corners for end, x in ends.items()}
    lines = {name: geo.addLine(points[name, "start"], points[name, "end"]) for name in corners}
    edges, surfaces = {}, {}
    for line in lines.values():
        geo.mesh.setTransfiniteCurve(line, cells + 1)
    for wall, (first, last, across) in walls.items():
        for end in ends:
            edges[f"{wall} at {end}"] = edge = geo.addLine(points[first, end], points[last, end])
            geo.mesh.setTransfiniteCurve(edge, across + 1)
        loop = geo.addCurveLoop([lines[first], edges[f"{wall} at end"], -lines[last], -edges[f"{wall} at start"]])
        surfaces[wall] = geo.addPlaneSurface([loop])
        geo.mesh.setTransfiniteSurface(surfaces[wall], "Left")
        if not triangles:
            geo.mesh.setRecombine(2, surfaces[wall])
    geo.synchronize()
    for name, surface in surfaces.items():
        gmsh.model.addPhysicalGroup(2, [surface], name=name)
    for name, line in (lines | edges).items():
        gmsh.model.addPhysicalGroup(1, [line], name=name)
    for (name, end), point in points.items():
        gmsh.model.addPhysicalGroup(0, [point], name=f"{name} at {end}")
