"""Parts that have cells in common: their stiffness would count twice."""

from __future__ import annotations

from dataclasses import replace

import gmsh
import numpy as np
import pytest

import sheetfx as fx


def squares(**groups):
    """Four squares in a row, each a surface of four cells, with groups of them."""

    def source():
        geo, surfaces = gmsh.model.geo, []
        points = [[geo.addPoint(x, y, 0) for y in (0, 1)] for x in range(5)]
        rungs = [geo.addLine(*pair) for pair in points]
        rails = [[geo.addLine(points[x][y], points[x + 1][y]) for y in (0, 1)] for x in range(4)]
        for x, (low, high) in enumerate(rails):
            surfaces.append(geo.addPlaneSurface([geo.addCurveLoop([low, rungs[x + 1], -high, -rungs[x]])]))
        geo.synchronize()
        for curve in (*rungs, *np.ravel(rails).tolist()):
            gmsh.model.mesh.setTransfiniteCurve(curve, 3)
        for surface in surfaces:
            gmsh.model.mesh.setTransfiniteSurface(surface)
            gmsh.model.mesh.setRecombine(2, surface)
        for name, chosen in groups.items():
            gmsh.model.addPhysicalGroup(2, [surfaces[i] for i in chosen], name=name)
        gmsh.model.addPhysicalGroup(0, [points[groups["one"][0]][0]], name="place")

    return source


@pytest.mark.parametrize("seed", range(8))
def test_parts_of_random_groups(seed):
    random = np.random.default_rng(seed)
    one, two = (sorted(random.choice(4, size=random.integers(1, 4), replace=False).tolist()) for _ in range(2))
    common = 4 * len(set(one) & set(two))
    mesh = fx.read(squares(one=one, two=two), 3)
    first, second = (fx.Shell(mesh, fx.Plate(0.01), fx.Elastic(1e5), group=name) for name in ("one", "two"))

    def scene(*parts):
        return fx.Scene(parts, [fx.clamp(mesh, "place")], [fx.PointForce(mesh, "place", (0.0, 0.0, 1.0))],
                        fx.Monitor(mesh, "place", "z"))

    scene(first, replace(second, offset=0.01))
    if not common:
        scene(first, second)
        return
    for thickness in (0.01, 0.02):
        with pytest.raises(ValueError, match="Scene: Shell on group 'one' and Shell on group 'two' have "
                                             f"{common} cells in common, whose stiffness and loads count twice; give"):
            scene(first, replace(second, section=fx.Plate(thickness)))
    with pytest.raises(ValueError, match=f"all cells and Shell on group 'two' have {4 * len(two)} cells in"):
        scene(replace(first, group=None), second)


def test_layers_on_the_same_cells_are_told():
    mesh = fx.read(lambda: fx.meshes.frame({"a": (0, 0), "b": (1, 0)}, {"one": ("a", "b", 3)}), 2)
    beam = fx.Beam(mesh, fx.Rectangle(0.1, 0.1), fx.Elastic(1e4))
    rest = [fx.clamp(mesh, "a")], [fx.PointForce(mesh, "b", (0.0, 1.0))], fx.Monitor(mesh, "b", "y")
    with pytest.warns(UserWarning, match="Beam on group 'one' have 3 cells in common, .* differ in material alone"):
        fx.Scene([beam, replace(beam, material=fx.Elastic(1e3), group="one")], *rest)
    with pytest.raises(ValueError, match="Beam on all cells and Beam on group 'one' have 3 cells in common"):
        fx.Scene([beam, replace(beam, group="one")], *rest)
