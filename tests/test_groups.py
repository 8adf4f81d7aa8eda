"""Groups of a mesh: parts that have cells in common, names where gmsh has none, and any number of them."""

from __future__ import annotations

from dataclasses import replace
from itertools import combinations

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


@pytest.mark.silent("b10", "b14")
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


@pytest.mark.silent("b13")
@pytest.mark.parametrize("named", [False, True])
def test_groups_without_names_are_told_by_their_dimension(named, tmp_path):
    """gmsh counts groups of each dimension from 1."""
    gmsh.initialize()
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        squares(one=[0, 1], two=[2, 3])()
        gmsh.model.removePhysicalGroups()
        for name in ("one", "two", "place"):
            gmsh.model.removePhysicalName(name)
        for dimension, tags in ((2, [1, 2]), (2, [3, 4]), (1, [1]), (0, [1])):
            gmsh.model.addPhysicalGroup(dimension, tags, 1 + (tags == [3, 4]))
        if named:
            gmsh.model.setPhysicalName(2, 1, "plate")
        gmsh.model.mesh.generate(2)
        gmsh.write(str(tmp_path / "groups.msh"))
    finally:
        gmsh.finalize()
    mesh = fx.read(str(tmp_path / "groups.msh"), 3)
    assert list(mesh.cells) == ["plate" if named else "surface 1", "surface 2"]
    assert (list(mesh.edges), list(mesh.points)) == (["curve 1"], ["point 1"])


@pytest.mark.silent("b05")
@pytest.mark.slow
def test_any_number_of_groups_carry_loads():
    """Twelve members with a load each bend as one part with one load does."""
    nodes = {f"p{i}": (float(i), 0.1 * (i % 2)) for i in range(13)}
    mesh = fx.read(lambda: fx.meshes.frame(nodes, {f"m{i}": (f"p{i}", f"p{i + 1}", 1) for i in range(12)}), 2)
    found = []
    for groups in ([None], [f"m{i}" for i in range(12)]):
        parts = [fx.Beam(mesh, fx.Rectangle(0.1, 0.1), fx.Elastic(2e11), group=g) for g in groups]
        scene = fx.Scene(parts, [fx.clamp(mesh, "p0"), fx.clamp(mesh, "p12")],
                         [fx.LineForce(p, (0.0, -7.7e2)) for p in parts], fx.Monitor(mesh, "p6", "y", -1.0))
        found.append(fx.trace(fx.Case(scene, fx.LoadControl(1.0, fixed=True))).states[-1].deflection)
    assert found[1] == pytest.approx(found[0], rel=1e-8)


def chain(nodes=None, **groups):
    """Six members in a row, and groups of some of them; `nodes` names groups of nodes."""

    def source():
        geo = gmsh.model.geo
        points = [geo.addPoint(float(i), 0.1 * (i % 2), 0) for i in range(7)]
        lines = [geo.addLine(points[i], points[i + 1]) for i in range(6)]
        geo.synchronize()
        for line in lines:
            gmsh.model.mesh.setTransfiniteCurve(line, 2)
        for name, chosen in groups.items():
            gmsh.model.addPhysicalGroup(1, [lines[i] for i in chosen], name=name)
        for name, chosen in ({"first": [0], "middle": [3], "last": [6]} | (nodes or {})).items():
            gmsh.model.addPhysicalGroup(0, [points[i] for i in chosen], name=name)

    return source


def bent(mesh, names):
    """Deflection of beams on groups of a chain, each with a load of its own."""
    parts = [fx.Beam(mesh, fx.Rectangle(0.1, 0.1), fx.Elastic(2e11), group=name) for name in names]
    scene = fx.Scene(parts, [fx.clamp(mesh, "first"), fx.clamp(mesh, "last")],
                     [fx.LineForce(part, (1e2, -7.7e2)) for part in parts], fx.Monitor(mesh, "middle", "y", -1.0))
    return fx.trace(fx.Case(scene, fx.LoadControl(1.0, fixed=True))).states[-1].deflection


@pytest.mark.silent("b10", "b14")
@pytest.mark.parametrize("seed", range(8))
def test_beams_on_random_groups_are_one_or_refused(seed):
    """Groups that share no member bend as one part; of others the first two that meet are named with their members."""
    random = np.random.default_rng(seed)
    owner = random.permutation([0, 1, 2, *random.integers(3, size=3)])
    groups = {f"g{k}": np.flatnonzero(owner == k).tolist() for k in range(3)}
    if seed % 2:
        groups["g1"] = sorted({*groups["g1"], *random.choice(6, size=2, replace=False).tolist()})
    mesh = fx.read(chain(whole=range(6), **groups), 2)
    names = [str(name) for name in random.permutation(list(groups))]
    shared = [(a, b, n) for a, b in combinations(names, 2) if (n := len({*groups[a]} & {*groups[b]}))]
    if not shared:
        assert bent(mesh, names) == pytest.approx(bent(mesh, ["whole"]), rel=1e-8)
        return
    (one, two, count), *_ = shared
    cells = "cell" if count == 1 else "cells"
    with pytest.raises(ValueError, match=f"on group '{one}' and Beam on group '{two}' have {count} {cells} in common"):
        bent(mesh, names)


@pytest.mark.parametrize("seed", range(4))
def test_random_groups_of_nodes_that_overlap(seed):
    """Forces act at each node once for each load; displacements that differ at a common node are refused."""
    random = np.random.default_rng(seed)
    nodes = {name: random.choice(np.arange(1, 6), size=3, replace=False).tolist() for name in ("one", "two")}
    mesh = fx.read(chain(nodes, whole=range(6)), 2)
    beam = fx.Beam(mesh, fx.Rectangle(0.1, 0.1), fx.Elastic(2e11))

    def scene(*loads):
        held = [fx.clamp(mesh, "first"), fx.clamp(mesh, "last")]
        return fx.Scene([beam], held, loads, fx.Monitor(mesh, "middle", "y"))

    both = scene(fx.PointForce(mesh, "one", (0.0, -1.0)), fx.PointForce(mesh, "two", (0.0, -2.0)))
    record = fx.trace(fx.Case(both, fx.LoadControl(1.0, fixed=True)))
    assert sum(record.reactions(name).force[-1, 1] for name in ("first", "last")) == pytest.approx(9.0, rel=1e-8)
    assert record.states[-1].load == pytest.approx(9.0)
    with pytest.raises(ValueError, match="component y is -0.2 where that of 'one', with which it has points in common"):
        scene(*(fx.PrescribedDisplacement(mesh, name, "y", d) for name, d in (("one", -0.1), ("two", -0.2))))
