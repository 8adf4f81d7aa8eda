"""Structures of panels on bars, from tables of nodes."""

from __future__ import annotations

from typing import Annotated

import gmsh
import numpy as np

from ..checks import AT_LEAST_1, Choice, Count, checked
from .blocks import Blocks
from .surfaces import Lines, around, pieces
from .tables import SAME_PLACE, Table

BARS = "bars"  # what panels that share nodes with each other are separate from


@checked
def structure(table: Table, divisions: Count, triangles: bool = True,
              separate: bool | Annotated[str, Choice((BARS,))] = False,
              grading: Annotated[float, AT_LEAST_1] = 1.0) -> None:
    """Straight bars and flat panels of a table, which share nodes where they meet.

    Groups of curves: each bar ("bar 1-2"), all "bars", and edges of panels without a bar ("edge 1-2"). Groups of
    surfaces: each panel ("panel 1-2-3") and all "panels"; of both those of the table. Points: the nodes and sets of
    nodes of the table. To be read by `read_mixed(lambda: structure(table, 5), bars=["bars"])`; without bars by `read`.

    Parameters
    ----------
    table : Table
    divisions : number of cells along each bar and edge; even where quadrilaterals fill panels of three nodes
    triangles : cells of panels are triangles
    separate : True: panels share nodes neither with each other nor with bars; their corners are points "1 of panel
        1-2-3", their edges "edge 1-2 of panel 1-2-3", with nodes in the order of the bar there is. "bars": panels share
        nodes with each other, but not with bars; corners are "1 of panels", edges "edge 1-2 of panels"
    grading : length of the cells in the middle of each bar and edge over that of those at its ends; where it is not 1,
        divisions are even

    Raises
    ------
    ValueError
        If a node is on a bar or edge between the ends of it.
    """
    bars, panels = table.named_bars, table.named_panels
    edges = edges_of(table, separate)
    _check_meeting(table, bars if separate else bars | edges)
    corners = {name: [_corner(n, name, separate) for n in row] for name, row in panels.items()}
    places = {n: table.nodes[n] for row in bars.values() for n in row}
    places |= {n: table.nodes[node] for name, row in panels.items() for node, n in zip(row, corners[name], strict=True)}
    geo = gmsh.model.geo
    points = {name: geo.addPoint(*x) for name, x in places.items()}
    lines: Lines | Blocks
    if grading == 1:
        lines = Lines(points, pieces(panels.values(), divisions, triangles))
    elif divisions % 2:
        raise ValueError(f"structure: {divisions} divisions with a grading of {grading}; the number must be even")
    else:
        lines = Blocks(places, points, divisions // 2, grading)
    curves = {name: lines.line(*ends) for name, ends in (bars | edges).items()}
    surfaces = {name: lines.fill(row, triangles) for name, row in corners.items()}
    geo.synchronize()
    sets = {name: [points[n] for n in row if n in points] for name, row in table.sets.items()}
    _name(0, {name: [tag] for name, tag in points.items()} | sets)
    for dimension, members, all_of_them in ((1, curves, {"bars": list(bars)}), (2, surfaces, {"panels": list(panels)})):
        _name(dimension, members | {name: [tag for one in among for tag in members[one]] for name, among in
                                    (all_of_them | dict(table.groups)).items() if set(among) <= set(members)})


def _corner(node: str, panel: str, separate: bool | str) -> str:
    return f"{node} of {'panels' if separate == BARS else panel}" if separate else node


def edges_of(table: Table, separate: bool | str = False) -> dict[str, tuple[str, ...]]:
    """Points at the ends of edges of panels, but for those along bars that share their nodes; see `structure`."""
    sides = [ends for row in table.panels for ends in around(row)]
    order = {frozenset(ends): ends for ends in reversed([*table.bars, *sides])}
    bars = {frozenset(ends) for ends in table.bars}
    edges = {}
    for name, row in table.named_panels.items():
        for side in map(frozenset, around(row)):
            if separate or side not in bars:
                label = _corner(f"edge {'-'.join(order[side])}", name, separate)
                edges[label] = tuple(_corner(n, name, separate) for n in order[side])
    return edges


def _check_meeting(table: Table, members: dict) -> None:
    """Refuse nodes on a straight member between its ends, where it would pass them by."""
    names = sorted({node for ends in members.values() for node in ends})
    small = SAME_PLACE * table.size
    x = np.array([table.nodes[node] for node in names], dtype=float)
    for name, ends in members.items():
        a, b = (np.array(table.nodes[node], dtype=float) for node in ends)
        along = (b - a) / np.linalg.norm(b - a)
        reach = (x - a) @ along
        beside = np.linalg.norm(x - a - np.outer(reach, along), axis=1)
        for on in np.flatnonzero((beside <= small) & (reach > small) & (reach < np.linalg.norm(b - a) - small)):
            raise ValueError(f"{name} passes the node {names[on]} and does not meet it; divide it there")


def _name(dimension: int, groups: dict[str, list[int]]) -> None:
    for name, tags in groups.items():
        if tags:
            gmsh.model.addPhysicalGroup(dimension, tags, name=name)
