"""Imperfect shapes: modes, measured deviations and random fields."""

import warnings

import gmsh
import numpy as np
import pytest
from dolfinx import fem
from helpers import on_two_processes
from scipy.spatial import cKDTree

import sheetfx as fx
from sheetfx import meshes
from sheetfx.discrete.fields import Fields
from sheetfx.discrete.sharing import sharings_of
from sheetfx.mesh.imperfection import imperfect, measured, random_field
from sheetfx.mesh.mixed import read_mixed
from sheetfx.mesh.reader import read

LENGTH, DEVIATION, SAMPLES = 0.3, 2.0, 4000


def arc(elements=12, order=2):
    return read(lambda: meshes.arc(2.0, -1.0, 1.0, elements), 2, order)


def cylinder(cells=(4, 3), order=2):
    def place(x):
        return np.column_stack((x[:, 0], np.sin(x[:, 1]), np.cos(x[:, 1])))

    return read(lambda: meshes.rectangle(cells), 3, order, place)


def shift(mesh, *arguments):
    """Displacement of the nodes by `imperfect`, shape (n, 3)."""
    return imperfect(mesh, *arguments).domain.geometry.x - mesh.domain.geometry.x


def test_statistics_of_random_fields():
    """Mean, deviation, correlation exp(-(d / l)^2) and kurtosis over many samples, at four standard errors."""
    places = np.array([[0.0, 0, 0], [0.5 * LENGTH, 0, 0], [0, LENGTH, 0], [0, 0, 2 * LENGTH]])
    table = np.array([random_field(LENGTH, DEVIATION, seed)(places) for seed in range(SAMPLES)])
    error = 1 / np.sqrt(SAMPLES)
    assert np.abs(table.mean(axis=0)).max() < 4 * DEVIATION * error
    assert table.std(axis=0) == pytest.approx(DEVIATION, rel=4 * error / np.sqrt(2))
    assert np.corrcoef(table.T)[0] == pytest.approx(np.exp(-np.array([0, 0.5, 1, 2]) ** 2), abs=4 * error)
    kurtosis = ((table / DEVIATION) ** 4).mean(axis=0)
    assert kurtosis == pytest.approx(3, abs=4 * np.sqrt(96) * error)


def test_the_same_field_on_any_mesh():
    """Nodes that two meshes share move by the same vector, but for the normals of the coarse one: 1e-5 of 0.017."""
    field = random_field(LENGTH, 0.01, 7)
    coarse, fine = arc(6), arc(12)
    distance, partner = cKDTree(fine.domain.geometry.x).query(coarse.domain.geometry.x)
    shared = distance < 1e-6
    assert shared.sum() == 13
    assert shift(coarse, field)[shared] == pytest.approx(shift(fine, field)[partner[shared]], abs=1e-5)


@pytest.mark.parametrize("mesh, radius", [(arc(), 2.0), (arc(24, 1), 2.0), (cylinder(), 1.0),
                                           (cylinder((6, 6), 3), 1.0)])
def test_deviations_along_the_normal(mesh, radius):
    """They change the radius of a circle and a cylinder; 1e-3: straight cells lean by half their angle at the ends."""
    moved = imperfect(mesh, lambda x: np.full(len(x), 0.1)).domain.geometry.x
    across = moved[:, :2] if mesh.dimension == 2 else moved[:, 1:]
    assert np.abs(np.linalg.norm(across, axis=1) - radius) == pytest.approx(0.1, rel=1e-3)


def test_measured_field_at_its_points():
    """Nodes at which deviations were measured move by them; a linear field is exact everywhere."""
    mesh = cylinder((4, 4), 2)
    x = mesh.domain.geometry.x.copy()
    chosen = np.arange(0, len(x), 3)
    offsets = 0.01 * np.random.default_rng(2).standard_normal((len(chosen), 3))
    assert shift(mesh, measured(x[chosen], offsets))[chosen] == pytest.approx(offsets, abs=1e-12)
    slopes = np.array([[0.1, -0.2, 0.3], [0.0, 0.1, 0.2], [0.3, 0.0, 0.1]])
    assert shift(mesh, measured(x[chosen], x[chosen] @ slopes)) == pytest.approx(x @ slopes, abs=1e-10)


def test_measured_on_a_line_and_between_points():
    """On a straight line the natural spline through samples of sin(pi x), which has no curvature at its ends either."""
    mesh = read(lambda: meshes.frame({"a": (0, 0), "b": (1, 0)}, {"beam": ("a", "b", 33)}), 2)
    stations = np.linspace(0, 1, 9)
    points = np.column_stack((stations, 0 * stations))
    moved = shift(mesh, measured(points, np.sin(np.pi * stations)), 0.1)
    assert moved[:, 1] == pytest.approx(0.1 * np.sin(np.pi * mesh.domain.geometry.x[:, 0]), abs=3e-5)


def test_combination_of_modes():
    """A sum of functions of the mesh and of places, each with its amplitude."""
    mesh = arc()
    mode = fem.Function(fem.functionspace(mesh.domain, ("P", 2, (2,))))
    mode.interpolate(lambda x: (x[1], x[0] ** 2))
    x = mesh.domain.geometry.x
    expected = 0.5 * np.column_stack((x[:, 1], x[:, 0] ** 2)) + 0.2 * x[:, :2]
    assert shift(mesh, [mode, lambda x: x], [0.5, 0.2])[:, :2] == pytest.approx(expected, abs=1e-12)


def summed_shift():
    """A sum over the nodes of a cylinder, each counted once, that tells where they move."""
    mesh = cylinder()
    moved = shift(mesh, [random_field(0.3, seed=4), lambda x: x], [0.1, 0.2])
    own = mesh.domain.geometry.index_map().size_local
    return mesh.domain.comm.allreduce(float((moved**2 * (1 + mesh.domain.geometry.x))[:own].sum()))


def test_the_same_shape_on_two_processes():
    lines = on_two_processes("import test_imperfection\nprint(test_imperfection.summed_shift())")
    assert float(lines[-1]) == pytest.approx(summed_shift(), rel=1e-12)


@pytest.mark.parametrize("build, message", [
    (lambda: random_field(0.0), "correlation_length is 0.0"),
    (lambda: measured(np.zeros((2, 3)), np.zeros(3)), "an offset for each point"),
    (lambda: measured(np.ones((2, 3)), np.zeros(2)), r"\[1. 1. 1.\] stands twice"),
    (lambda: measured(np.eye(3)[:1], np.zeros(1)), "too few"),
    (lambda: imperfect(arc(), [lambda x: x], [1.0, 2.0]), "2 amplitudes for 1"),
    (lambda: imperfect(arc(3, 1), lambda x: x[:, :1]), r"shape \(4, 1\) at 4 nodes; give \(4, 2\), or \(4,\)"),
    (lambda: imperfect(arc(), fem.Function(fem.functionspace(arc().domain, ("P", 2, (2,))), name="bow")),
     "'bow' is a field on another mesh"),
    (lambda: imperfect(read(lambda: meshes.frame({"a": (0, 0, 0), "b": (1, 0, 0)}, {"c": ("a", "b", 2)}), 3),
                       random_field(1.0)), "no normal"),
    (lambda: imperfect(read(lambda: meshes.frame({"a": (0, 0), "b": (1, 0)}, {"c": ("a", "b", 2), "d": ("b", "a", 3)}),
                            2), random_field(1.0)), "cancel"),
])
def test_bad_input(build, message):
    with pytest.raises(ValueError, match=message):
        build()


def stiffened(free=False):
    """Two panels with a rib between them, and where asked a bar that goes on beyond the panels."""

    def source():
        geo = gmsh.model.geo
        points = [geo.addPoint(x, y, 0) for y in (0, 0.5, 1.0) for x in (0, 2.0)]
        rows = [geo.addLine(points[2 * i], points[2 * i + 1]) for i in range(3)]
        sides = [[geo.addLine(points[2 * i + j], points[2 * i + 2 + j]) for j in (0, 1)] for i in range(2)]
        panels = [geo.addPlaneSurface([geo.addCurveLoop([rows[i], sides[i][1], -rows[i + 1], -sides[i][0]])])
                  for i in range(2)]
        arm = [geo.addLine(points[3], geo.addPoint(2.5, 0.5, 0))] if free else []
        geo.synchronize()
        for curve in (*rows, *sides[0], *sides[1], *arm):
            gmsh.model.mesh.setTransfiniteCurve(curve, 3)
        for panel in panels:
            gmsh.model.mesh.setTransfiniteSurface(panel)
            gmsh.model.mesh.setRecombine(2, panel)
        gmsh.model.addPhysicalGroup(2, panels, name="skin")
        gmsh.model.addPhysicalGroup(1, [rows[1], *arm], name="rib")
        gmsh.model.addPhysicalGroup(1, [sides[0][0], sides[1][0]], name="west")
        gmsh.model.addPhysicalGroup(0, [points[1]], name="tip")

    return source


@pytest.mark.silent("b03")
@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize("shape", ["place", "normal", "random"])
def test_nodes_of_a_mixed_mesh_that_were_one_stay_one(order, shape):
    mesh = read_mixed(stiffened(), ["rib"], order)
    bow = {"place": lambda x: np.outer(np.sin(x[:, 0]) * x[:, 1], (0.1, 0.2, 0.3)), "normal": lambda x: np.sin(x[:, 0]),
           "random": random_field(0.5, seed=3)}[shape]
    moved = imperfect(mesh, [bow, lambda x: 0.1 * x], [0.1, 1.0])
    bars, panels = moved.shared_nodes().T
    assert len(bars) == 2 * order + 1
    x, y = moved.curves.domain.geometry.x[bars], moved.surfaces.domain.geometry.x[panels]
    assert np.array_equal(x, y)
    assert y == pytest.approx(imperfect(mesh.surfaces, [bow, lambda x: 0.1 * x], [0.1, 1.0]).domain.geometry.x[panels])


def test_bars_on_no_surface_need_a_displacement_of_their_own():
    mesh = read_mixed(stiffened(free=True), ["rib"])
    with pytest.raises(ValueError, match="imperfect: 2 nodes of rib that move with no surface have no displ"):
        imperfect(mesh, lambda x: x[:, 0])
    moved = imperfect(mesh, lambda x: np.outer(x[:, 0], (0.0, 0.0, 1.0))).curves.domain.geometry.x
    assert moved[:, 2] == pytest.approx(moved[:, 0])


@pytest.mark.silent("b03")
def test_skin_alone_is_not_moved_off_its_rib():
    mesh = read_mixed(stiffened(), ["rib"])
    shape = lambda x: np.outer(np.sin(np.pi * x[:, 0] / 2), (0.0, 0.0, 1e-3))  # noqa: E731
    for surfaces, curves in ((imperfect(mesh.surfaces, shape), mesh.curves), (mesh.surfaces, mesh.curves),
                             (imperfect(mesh, shape).surfaces, imperfect(mesh, shape).curves)):
        skin = fx.Shell(surfaces, fx.Plate(0.01), fx.Elastic(7e10, 0.3))
        rib = fx.Beam(curves, fx.Rectangle(0.01, 0.03), fx.Elastic(7e10, 0.3))
        scene = fx.Scene([skin, rib], [fx.clamp(surfaces, "west")], [fx.SurfaceForce(skin, (0.0, 0.0, 1.0))],
                         fx.Monitor(surfaces, "tip", "z"), joints=[fx.Compatible(curves, surfaces)])
        fields = Fields(scene)
        if curves is mesh.curves and surfaces is not mesh.surfaces:
            with pytest.raises(ValueError, match="Compatible: 1 common nodes of rib and skin in their gmsh model "):
                sharings_of(scene.joints, fields)
        else:
            assert sharings_of(scene.joints, fields)


class Sideways(fx.Load):
    """A load of one's own, without a dataclass."""

    def __init__(self, part):
        self.part = part

    def work(self, fields):
        return fields.factor * fields.vary(fields.displacement(self.part.mesh)[1]) * self.part.measure()


def panel_with_rib(surfaces, curves, joint=fx.Compatible):
    """A panel that bears on its sides, with a rib, and an obstacle beside it."""
    skin = fx.Shell(surfaces, fx.Plate(0.01), fx.Elastic(7e10, 0.3))
    rib = fx.Beam(curves, fx.Rectangle(0.01, 0.03), fx.Elastic(7e10, 0.3))
    return fx.Scene([skin, rib], [fx.Support(surfaces, "west", "x y z"), fx.Support(surfaces, "tip", "z")],
                    [fx.SurfaceForce(skin, (-1e3, 0.0, 0.0)), Sideways(rib)], fx.Monitor(surfaces, "tip", "x"),
                    joints=[joint(curves, surfaces), fx.Foundation(skin, (0.0, 0.0, 1.0)),
                            fx.ObstacleContact(surfaces, "west", fx.RigidPlane((0.0, 0.0, 9.0), (0.0, 0.0, -1.0)))],
                    stages=[fx.Stage([fx.LineForce(rib, (0.0, 0.0, 1.0))], "weight")])


def on(scene):
    """All meshes that something of a scene is on."""
    parts = scene.parts
    return [*scene.meshes, *(s.mesh for s in scene.supports), scene.loads[0].shell.mesh, scene.loads[1].part.mesh,
            scene.monitor.on, scene.joints[0].mesh, scene.joints[0].to, scene.joints[1].part.mesh,
            scene.joints[2].mesh, scene.stages[0].loads[0].beam.mesh, *(p.mesh for p in parts)]


@pytest.mark.silent("b03")
@pytest.mark.parametrize("shape", ["place", "normal", "mode", "fields"])
@pytest.mark.slow(quick=1)
def test_whole_scenes(shape):
    """All of a scene stands on moved meshes whose common nodes stay one, as of the meshes that are moved alone."""
    mesh = read_mixed(stiffened(), ["rib"])
    scene = panel_with_rib(mesh.surfaces, mesh.curves)
    bow = {"place": lambda x: np.outer(np.sin(x[:, 0]) * x[:, 1], (0.1, 0.2, 0.3)), "normal": lambda x: np.sin(x[:, 0]),
           "fields": None, "mode": None}[shape]
    if shape in ("mode", "fields"):
        record = fx.trace(fx.Case(scene, fx.LoadControl(1e-3, fixed=True), fx.Until(steps=1)))
        mode = record.buckling(record.states[0], count=1)[0]
        fields = [fx.mode_displacement(record.path, m, mode) for m in scene.meshes]
        bow = mode if shape == "mode" else fields
    made = fx.imperfect(scene, bow, 0.05)
    assert {id(m) for m in on(made)} == {id(m) for m in made.meshes}
    assert not {id(m) for m in made.meshes} & {id(m) for m in scene.meshes}
    assert made.loads[0].shell is made.parts[0]
    assert made.loads[1].part is made.stages[0].loads[0].beam is made.parts[1]
    assert made.joints[2].obstacle is scene.joints[2].obstacle
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert sharings_of(made.joints, Fields(made))
    alone = imperfect(mesh.surfaces, fields[0] if shape in ("mode", "fields") else bow, 0.05)
    assert made.meshes[0].domain.geometry.x == pytest.approx(alone.domain.geometry.x, abs=1e-12)
    assert np.abs(shift(mesh.surfaces, fields[0] if shape in ("mode", "fields") else bow, 0.05)).max() > 0.01


def test_ties_at_places_go_along():
    """Stretches between places and along edges, on one part and on the other, of a scene that is bowed."""
    skin = read(lambda: meshes.rectangle((4, 4)), 3)
    rib = read(lambda: meshes.frame({"a": (0, 0.5, 0), "b": (1, 0.5, 0)}, {"rib": ("a", "b", 6)}), 3)
    parts = [fx.Shell(skin, fx.Plate(0.01), fx.Elastic(7e10)), fx.Beam(rib, fx.Rectangle(0.01, 0.03), fx.Elastic(7e10))]
    joints = [fx.weld(skin, fx.Stretch((0.1, 0.5, 0.0), (0.4, 0.5, 0.0)), (rib, None)),
              fx.hinge(rib, fx.Stretch("b", along="rib", length=0.3), (skin, None)),
              fx.bolt(rib, fx.Stretch("b", along=(-1.0, 0.0, 0.0), length=0.9), (skin, None))]
    scene = fx.Scene(parts, [fx.clamp(skin, "west")], [fx.PointForce(rib, "b", (0.0, 0.0, 1.0))],
                     fx.Monitor(rib, "b", "z"), joints=joints)
    made = fx.imperfect(scene, lambda x: np.outer(np.sin(np.pi * x[:, 0]), (0.0, 0.1, 1.0)), 0.02)
    for joint in made.joints:
        one, two = joint.meeting.sides
        assert np.linalg.norm(one.places - two.places, axis=1).max() < 4e-3, "of 0.02, which cells of both follow"
    assert made.joints[0].meeting.sides[0].places[:, 2].min() > 0.005


@pytest.mark.slow
def test_modes_of_other_scenes_are_refused():
    mesh = read_mixed(stiffened(), ["rib"])
    scene = panel_with_rib(mesh.surfaces, mesh.curves)
    with pytest.raises(ValueError, match="imperfect: the mode has 7 increments and the scene .*of this scene"):
        fx.imperfect(scene, np.zeros(7))
    with pytest.raises(ValueError, match="imperfect: 2 nodes of rib that move with no surface"):
        free = read_mixed(stiffened(free=True), ["rib"])
        fx.imperfect(panel_with_rib(free.surfaces, free.curves), lambda x: x[:, 0])
