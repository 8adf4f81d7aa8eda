"""Flat panels in blocks of quadrilaterals, one at each corner, whose cells are small at the corners."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import pairwise

import gmsh
import numpy as np

from .surfaces import around


class Blocks:
    """Lines between named points in two halves, and panels in as many blocks as they have corners.

    A block has a corner of the panel, the middles of both edges there, and the panel's centre. From one cell of a line
    to the next towards its middle lengths grow by one factor, and so do those of the block's cells in both directions:
    where panels are welded at their corners alone, forces are those of a mesh that is as fine everywhere.

    Parameters
    ----------
    places : name -> coordinates (3 numbers)
    tags : name -> gmsh's point
    cells : number of cells on each half of a line
    grading : length of the cells in the middle of a line over that of those at its ends
    """

    def __init__(self, places: Mapping[str, Sequence[float]], tags: Mapping[str, int], cells: int, grading: float):
        self._places, self._tags, self._cells = places, tags, cells
        self._growth = grading ** (1 / max(cells - 1, 1))
        self._halves: dict[tuple[str, str], int] = {}
        self._middles: dict[tuple[str, str], int] = {}

    def line(self, a: str, b: str) -> list[int]:
        """gmsh's curves between two points."""
        self._divide(a, b)
        return [abs(self._halves[a, b]), abs(self._halves[b, a])]

    def fill(self, corners: Sequence[str], triangles: bool) -> list[int]:
        """gmsh's surfaces between three or four points."""
        geo, centre = gmsh.model.geo, self._point(corners)
        sides = around(corners)
        for side in sides:
            self._divide(*side)
        spokes = {side: self._graded(self._middles[side], centre, self._growth) for side in sides}
        made = []
        for before, after in pairwise([sides[-1], *sides]):
            corner, last, following = after[0], self._middles[before], self._middles[after]
            loop = [self._halves[after], spokes[after], -spokes[before], -self._halves[before[::-1]]]
            surface = geo.addPlaneSurface([geo.addCurveLoop(loop)])
            geo.mesh.setTransfiniteSurface(surface, "Left", [self._tags[corner], following, centre, last])
            if not triangles:
                geo.mesh.setRecombine(2, surface)
            made.append(surface)
        return made

    def _divide(self, a: str, b: str) -> None:
        """Make the curves from two points to the middle between them, once; both run alike, the second one reversed."""
        if (a, b) not in self._halves:
            middle = self._point((a, b))
            self._middles[a, b] = self._middles[b, a] = middle
            self._halves[a, b] = self._graded(self._tags[a], middle, self._growth)
            self._halves[b, a] = -self._graded(middle, self._tags[b], 1 / self._growth)

    def _graded(self, first: int, last: int, growth: float) -> int:
        curve = gmsh.model.geo.addLine(first, last)
        gmsh.model.geo.mesh.setTransfiniteCurve(curve, self._cells + 1, "Progression", growth)
        return curve

    def _point(self, names: Sequence[str]) -> int:
        """A new point amidst named ones."""
        return gmsh.model.geo.addPoint(*np.mean([self._places[n] for n in names], axis=0))
