"""Curves for beams: circular arcs and frames of straight members."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import cos, sin

import gmsh

from ..checks import Count, Positive, checked, require_known


@checked
def arc(
    radius: Positive,
    start: float,
    end: float,
    elements: Count,
    points: Mapping[str, float] | None = None,
    name: str = "arch",
) -> None:
    """Circular arc about the origin in the x-y plane, in equal elements.

    Parameters
    ----------
    radius : length
    start, end : angles in radians from the y axis towards x
    elements : number of elements on the whole arc
    points : names of points and their angles; each cuts the arc, and the elements are shared out
        between the pieces in proportion to their length
    name : physical group of the curve
    """
    if start == end:
        raise ValueError(f"arc: start and end are both {start}; give two angles")
    named = {"start": start, "end": end, **(points or {})}
    angles = sorted(set(named.values()))
    geo = gmsh.model.geo
    centre = geo.addPoint(0, 0, 0)
    tags = {a: geo.addPoint(radius * sin(a), radius * cos(a), 0) for a in angles}
    curves = []
    for a, b in zip(angles[:-1], angles[1:], strict=True):
        pieces = max(1, round(elements * (b - a) / (angles[-1] - angles[0])))
        halves = max(1, int((b - a) / 3.0) + 1)
        curves += _circle_pieces(radius, centre, tags, a, b, pieces, halves)
    geo.synchronize()
    gmsh.model.addPhysicalGroup(1, curves, name=name)
    for label, angle in named.items():
        gmsh.model.addPhysicalGroup(0, [tags[angle]], name=label)


def _circle_pieces(radius, centre, tags, a, b, elements, parts):
    """Arcs of less than half a turn between the angles a and b, as gmsh demands."""
    geo = gmsh.model.geo
    inner = [a + (b - a) * (elements * k // parts) / elements for k in range(1, parts)]
    ends = [tags[a]] + [geo.addPoint(radius * sin(c), radius * cos(c), 0) for c in inner]
    ends.append(tags[b])
    counts = [elements * (k + 1) // parts - elements * k // parts for k in range(parts)]
    curves = []
    for first, last, count in zip(ends[:-1], ends[1:], counts, strict=True):
        curve = geo.addCircleArc(first, centre, last)
        geo.mesh.setTransfiniteCurve(curve, count + 1)
        curves.append(curve)
    return curves


@checked
def frame(
    nodes: Mapping[str, tuple[float, float] | tuple[float, float, float]],
    members: Mapping[str, tuple[str, str, Count]],
    releases: Sequence[tuple[str, str]] = (),
) -> None:
    """Straight members between named nodes.

    Parameters
    ----------
    nodes : name -> coordinates (2 or 3 numbers)
    members : name -> (first node, last node, number of elements); members that share a node are
        rigidly joined there
    releases : pairs of a member and a node of it, where its end is a point of its own, named "NODE of MEMBER", that
        a joint connects with the node
    """
    for member, ends_of_member in members.items():
        require_known(f"frame: node of member {member!r}", ends_of_member[:2], nodes)
    geo = gmsh.model.geo
    tags = {name: geo.addPoint(*x, *([0.0] * (3 - len(x)))) for name, x in nodes.items()}
    for member, node in releases:
        if node not in members.get(member, ())[:2]:
            raise ValueError(f"frame: no end of a member {member!r} at a node {node!r} to release")
        tags[f"{node} of {member}"] = geo.addPoint(*nodes[node], *([0.0] * (3 - len(nodes[node]))))
    groups: dict[str, int] = {}
    for name, (first, last, elements) in members.items():
        ends = (tags.get(f"{node} of {name}", tags[node]) for node in (first, last))
        groups[name] = geo.addLine(*ends)
        geo.mesh.setTransfiniteCurve(groups[name], elements + 1)
    geo.synchronize()
    for name, curve in groups.items():
        gmsh.model.addPhysicalGroup(1, [curve], name=name)
    for name, tag in tags.items():
        gmsh.model.addPhysicalGroup(0, [tag], name=name)
