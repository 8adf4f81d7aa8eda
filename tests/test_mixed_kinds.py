"""Shells of triangles and quadrilaterals: a mesh of each kind, joined at common nodes."""

from __future__ import annotations

from math import pi

import gmsh
import numpy as np
import pytest
from helpers import on_two_processes
from test_raised import cylinder, flat

import sheetfx as fx
from sheetfx.discrete.discretisation import Discretisation

MATERIAL, THICKNESS = fx.Elastic(1e4, 0.3), 0.1
pytestmark = pytest.mark.filterwarnings("ignore:.* ran against their neighbours")


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


def joined(kinds, material=MATERIAL, t=THICKNESS):
    shells = [fx.Shell(mesh, fx.Plate(t), material) for mesh in kinds]
    return shells, [fx.Compatible(kinds.triangles, kinds.quadrilaterals)]


def scene_of(kinds, shells_and_joints, supports, loads, component, sign=1.0, **scene):
    """Supports and loads are (name, what is made of a mesh and the name)."""
    made = [[make(m, name) for name, make in given for m in kinds.having(name)] for given in (supports, loads)]
    shells, joints = shells_and_joints
    return fx.Scene(shells, *made, fx.Monitor(kinds.having("corner")[0], "corner", component, sign), joints=joints,
                    **scene)


ROLLED = [("west", lambda m, at: fx.symmetry(m, at)), ("west", lambda m, at: fx.Support(m, at, "z")),
          ("south", lambda m, at: fx.symmetry(m, at, "y"))]
KINDS = pytest.mark.parametrize("build", [recombined, halves, lambda: halves(swapped=True)],
                                ids=["recombined", "halves", "swapped"])


@KINDS
@pytest.mark.slow(quick=1)
def test_constant_membrane_strain_is_exact(build):
    """A plate in tension contracts by Poisson's ratio."""
    kinds = fx.read_kinds(build)
    scene = scene_of(kinds, joined(kinds), ROLLED, [("east", lambda m, at: fx.EdgeForce(m, at, (1e-5, 0, 0)))], "y")
    record = fx.trace(fx.Case(scene, fx.LoadControl(1.0)))
    strain = 1e-5 / (1e4 * THICKNESS)
    found = record.displacement("corner", scene.monitor.on)
    assert found == pytest.approx([strain, -0.3 * strain, 0.0], abs=1e-5 * strain)


@KINDS
@pytest.mark.slow(quick=1)
def test_constant_bending_is_exact(build):
    """Without Poisson's ratio moments at one end bend a strip to an arc of a circle."""
    kinds = fx.read_kinds(build)
    stiffness = 1e4 * THICKNESS**3 / 12
    scene = scene_of(kinds, joined(kinds, fx.Elastic(1e4, 0.0)), ROLLED,
                     [("east", lambda m, at: fx.Moment(m, at, (0, 1e-6 * stiffness, 0)))], "z", -1.0)
    assert fx.trace(fx.Case(scene, fx.LoadControl(1.0))).states[-1].deflection == pytest.approx(5e-7, rel=1e-5)


@KINDS
@pytest.mark.slow(quick=1)
def test_large_rotations(build):
    """The strip rolls up to a quarter of a circle; 4 x 4 cells of triangles alone are 3.9e-3 off."""
    kinds = fx.read_kinds(build)
    moment = pi / 2 * 1e4 * THICKNESS**3 / 12
    scene = scene_of(kinds, joined(kinds, fx.Elastic(1e4, 0.0)), ROLLED,
                     [("east", lambda m, at: fx.Moment(m, at, (0, moment, 0)))], "z", -1.0)
    record = fx.trace(fx.Case(scene, fx.LoadControl(0.25)))
    assert record.displacement("corner", scene.monitor.on) == pytest.approx([2 / pi - 1, 0, -2 / pi], abs=4e-3)


def test_plate_buckles_at_its_load():
    """The hinged square plate at 4 pi^2 D / b^2 (Timoshenko and Gere 1961), with a mode over both kinds."""
    kinds = fx.read_kinds(recombined)
    t = 0.01
    held = [(name, lambda m, at: fx.Support(m, at, "z")) for name in ("west", "south", "east", "north")]
    loads = [("east", lambda m, at: fx.EdgeForce(m, at, (-1.0, 0, 0)))]
    supports = [*held, ("west", lambda m, at: fx.Support(m, at, "x")), ("south", lambda m, at: fx.Support(m, at, "y"))]
    scene = scene_of(kinds, joined(kinds, t=t), supports, loads, "x", -1.0)
    record = fx.trace(fx.Case(scene, fx.LoadControl(0.01, target=0.01)))
    (found,) = record.buckling(record.states[0], count=1)
    assert found.factor == pytest.approx(4 * pi**2 * 1e4 * t**3 / (12 * (1 - 0.3**2)), rel=1e-2)


@pytest.mark.slow
def test_flat_cells_of_both_kinds_are_raised_to_one_surface(tmp_path):
    """A recombined panel as a first-order file; common nodes, which `Compatible` looks at, stand at one place."""
    file = flat(tmp_path / "panel.msh", cylinder, recombined)
    with pytest.warns(UserWarning, match="raised .* flat cells of 'shell' to order 2, by normals"):
        kinds = fx.read_kinds(file)
    for mesh in kinds:
        assert np.hypot(*mesh.domain.geometry.x[:, 1:].T) == pytest.approx(1, abs=1e-3)
    assert sum(mesh.measure for mesh in kinds) == pytest.approx(pi / 2, rel=1e-4)
    scene = scene_of(kinds, joined(kinds), [], [("corner", lambda m, at: fx.PointForce(m, at, (0, 0, 1)))], "z")
    system = Discretisation(scene, mixed_points=False).system
    system.configure(system.create_vector(), system.factor)
    matrix = system.tangent().copy().convert("dense")
    free = np.setdiff1d(np.arange(matrix.size[0]), np.union1d(system.fixed_rows, system.multiplier_rows))
    values = np.linalg.eigvalsh(matrix.getDenseArray()[np.ix_(free, free)])
    assert np.abs(values[:6]).max() < 1e-11 * values[-1]
    assert values[6] > 1e3 * np.abs(values[:6]).max()


TWO = """
import warnings
import sheetfx as fx
from test_mixed_kinds import halves, joined, pulled, recombined
warnings.simplefilter("ignore")
for build in (recombined, halves):
    print(*pulled(build))
"""


def pulled(build):
    """Deflections of a clamped plate under a load on all of its cells, and its area and the length of its north."""
    kinds = fx.read_kinds(build)
    parts = joined(kinds)
    shells = dict(zip(kinds, parts[0], strict=True))
    clamped = [(name, lambda m, at: fx.clamp(m, at)) for name in ("west", "south")]
    scene = scene_of(kinds, parts, clamped, [("shell", lambda m, at: fx.SurfaceForce(shells[m], (0, 0, 20.0)))], "z")
    states = fx.trace(fx.Case(scene, fx.LoadControl(0.5))).states
    return [*(state.deflection for state in states), sum(m.measure for m in kinds),
            sum(m.edge_length("north") for m in kinds.having("north"))]


@pytest.mark.slow
def test_two_processes_find_the_same():
    lines = on_two_processes(TWO)
    for build, line in zip((recombined, halves), lines, strict=True):
        assert [float(value) for value in line.split()] == pytest.approx(pulled(build), rel=1e-8)


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
