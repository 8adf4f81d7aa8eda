"""Shells of triangles and quadrilaterals: a mesh of each kind, joined at common nodes."""

from __future__ import annotations

from math import pi

import gmsh
import numpy as np
import pytest
from helpers import on_two_processes
from scipy.spatial.transform import Rotation
from test_raised import cylinder, flat

import sheetfx as fx

MATERIAL = fx.Elastic(1e4, 0.3)


def recombined(size=0.25):
    """A square whose recombination leaves triangles among quadrilaterals."""
    gmsh.option.setNumber("Mesh.RecombineAll", 1)
    gmsh.option.setNumber("Mesh.RecombinationAlgorithm", 0)
    gmsh.option.setNumber("Mesh.MeshSizeMax", size)
    geo = gmsh.model.geo
    points = [geo.addPoint(x, y, 0) for x, y in ((0, 0), (1, 0), (1, 1), (0, 1))]
    sides = [geo.addLine(points[i], points[(i + 1) % 4]) for i in range(4)]
    surface = geo.addPlaneSurface([geo.addCurveLoop(sides)])
    geo.synchronize()
    gmsh.model.addPhysicalGroup(2, [surface], name="shell")
    for name, side in zip(("south", "east", "north", "west"), sides, strict=True):
        gmsh.model.addPhysicalGroup(1, [side], name=name)
    gmsh.model.addPhysicalGroup(0, [points[2]], name="corner")


def halves(n=4, swapped=False):
    """A square of triangles on one side of its middle, quadrilaterals on the other; drawn the other way round."""
    geo = gmsh.model.geo
    p = [geo.addPoint(x, y, 0) for y in (0, 1) for x in (0, 0.5, 1)]
    lines = {k: geo.addLine(p[a], p[b]) for k, (a, b) in {
        "s1": (0, 1), "s2": (1, 2), "n1": (3, 4), "n2": (4, 5), "w": (0, 3), "m": (1, 4), "e": (2, 5)}.items()}
    for line in lines.values():
        geo.mesh.setTransfiniteCurve(line, n + 1)
    for line in (lines[k] for k in ("s1", "s2", "n1", "n2")):
        geo.mesh.setTransfiniteCurve(line, n // 2 + 1)
    loops = [lines["s1"], lines["m"], -lines["n1"], -lines["w"]], [-lines["e"], -lines["s2"], lines["m"], lines["n2"]]
    surfaces = [geo.addPlaneSurface([geo.addCurveLoop(list(loop), reorient=True)]) for loop in loops]
    for surface in surfaces:
        geo.mesh.setTransfiniteSurface(surface)
    geo.mesh.setRecombine(2, surfaces[0 if swapped else 1])
    geo.synchronize()
    gmsh.model.addPhysicalGroup(2, surfaces, name="shell")
    for name, own in {"south": ("s1", "s2"), "north": ("n1", "n2"), "west": "w", "east": "e", "middle": "m"}.items():
        gmsh.model.addPhysicalGroup(1, [lines[k] for k in own], name=name)
    gmsh.model.addPhysicalGroup(0, [p[4]], name="top")
    gmsh.model.addPhysicalGroup(0, [p[5]], name="corner")


def joined(kinds, thickness=0.1, **settings):
    shells = [fx.Shell(mesh, fx.Plate(thickness), MATERIAL, **settings) for mesh in kinds]
    return shells, [fx.Compatible(kinds.triangles, kinds.quadrilaterals)]


def on_each(kinds, name, make):
    return [make(mesh) for mesh in kinds.having(name)]


@pytest.mark.parametrize("build", [recombined, halves, lambda: halves(swapped=True)], ids=["left", "halves", "swapped"])
def test_constant_membrane_and_bending_are_exact(build):
    """A strip in tension and in bending by moments; Poisson's ratio 0.3, free at its sides."""
    kinds = fx.read_kinds(build)
    shells, joints = joined(kinds)
    t = 0.1
    supports = [*on_each(kinds, "west", lambda m: fx.symmetry(m, "west")),
                *on_each(kinds, "south", lambda m: fx.symmetry(m, "south", "y")),
                *on_each(kinds, "west", lambda m: fx.Support(m, "west", "z"))]
    for shift, force in ((1e-6, "pull"),):
        loads = on_each(kinds, "east", lambda m: fx.EdgeForce(m, "east", (shift * 1e4 * t, 0.0, 0.0)))
        scene = fx.Scene(shells, supports, loads, fx.Monitor(kinds.having("corner")[0], "corner", "x"), joints=joints)
        record = fx.trace(fx.Case(scene, fx.LoadControl(1.0)))
        assert record.states[-1].deflection == pytest.approx(shift, rel=1e-4), force
        u = record.displacement("corner", kinds.having("corner")[0])
        assert u[1] == pytest.approx(-0.3 * shift, rel=1e-4)


def test_groups_lie_on_both_kinds():
    """Areas and lengths add up; an edge or point of both is in one mesh."""
    kinds = fx.read_kinds(halves)
    assert sum(m.measure_of("shell") for m in kinds.having("shell")) == pytest.approx(1.0)
    for name, count in {"south": 2, "north": 2, "middle": 1, "west": 1, "east": 1}.items():
        assert len(kinds.having(name)) == count
        assert sum(m.edge_length(name) for m in kinds.having(name)) == pytest.approx(1.0)
    assert kinds.having("top") == [kinds.quadrilaterals]
    with pytest.raises(ValueError, match="having: no group of cells, edge or point named 'nose'; there are corner, ea"):
        kinds.having("nose")


def test_normals_are_on_one_side():
    """Though gmsh draws the two halves opposite ways."""
    with pytest.warns(UserWarning, match="read_kinds: 8 cells of 'shell' ran against .* and are turned"):
        kinds = fx.read_kinds(halves)
    assert not any(m.opposed for m in kinds)


def test_what_cannot_be_read_is_refused():
    with pytest.raises(ValueError, match="read_kinds: all cells are of one kind; read them with read"):
        fx.read_kinds(lambda: fx.meshes.rectangle((2, 2)))
    with pytest.raises(ValueError, match="mixed kinds of cells, .*or read both with read_kinds"):
        fx.read(halves, 3)
