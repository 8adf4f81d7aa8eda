"""Parts whose meshes do not match: patch tests, finite rotation, tangents, laws, eccentric parts, stability."""

from __future__ import annotations

import warnings
from math import cosh, radians, sinh, sqrt, tan

import numpy as np
import pytest
from helpers import distance, move_at_random, tangents
from scipy.spatial.transform import Rotation

import sheetfx as fx
from sheetfx.discrete.discretisation import Discretisation
from sheetfx.mesh.projection import Cells

STEEL = fx.Elastic(1e4, 0.3, density=1.0)
CORK = fx.Elastic(1e4, 0.0, density=1.0)
PLATE = fx.Plate(0.1)
UNIT = {"section": fx.Rectangle(1.0, 0.001), "material": fx.Elastic(12e9, 0.0), "shear_rigidity": 1e3}
SPATIAL = {"section": fx.Rectangle(0.1, 0.1), "material": fx.Elastic(1.2e5, 0.0)}  # bending stiffness 1


def panel(cells, corner=(0.0, 0.0, 0.0), lengths=(1.0, 1.0), triangles=False):
    """A rectangle across z with a corner at a place."""
    return fx.read(lambda: fx.meshes.rectangle(cells, lengths, triangles), 3, 1, lambda x: x + np.array(corner))


def bar(start, end, elements, dimension=3, name="bar"):
    nodes = {"start": start, "end": end}
    return fx.read(lambda: fx.meshes.frame(nodes, {name: ("start", "end", elements)}), dimension)


def response(scene):
    """Linear motions by a load factor of 1: for each mesh places and motions of displacement and rotation."""
    path = fx.Path(scene)
    discretisation, state = path.discretisation, next(iter(path))
    motions = discretisation.system.motions(discretisation.system.create_vector(state.response))
    motions = dict(zip(discretisation.unknowns.fields, motions, strict=True))
    return {mesh: [(f.value.function_space.tabulate_dof_coordinates(), motions[f].reshape(-1, 3))
                   for f in discretisation.kinematics(mesh).block.fields] for mesh in discretisation.fields.meshes}


def off(fields, polynomial):
    """How far fields on several meshes are off one polynomial of the places, over their size."""
    places, values = (np.concatenate(parts) for parts in zip(*fields, strict=True))
    terms = polynomial(*places.T)
    coefficients = np.linalg.lstsq(terms, values, rcond=None)[0]
    return np.abs(terms @ coefficients - values).max() / np.abs(values).max()


def linear(x, y, z):
    return np.column_stack((np.ones_like(x), x, y))


def quadratic(x, y, z):
    return np.column_stack((np.ones_like(x), x, y, x * x, x * y, y * y))


def two_panels(form="naghdi-q2", material=STEEL):
    """Panels side by side with three and five cells along the edges at which they meet."""
    triangles = form == "naghdi-t2"
    meshes = panel((2, 3), triangles=triangles), panel((3, 5), (1.0, 0.0, 0.0), triangles=triangles)
    return meshes, [fx.Shell(m, PLATE, material, form=form) for m in meshes]


def joined(meshes, between: str):
    """The two panels welded, directly or each to a bar of four elements between them, and the bar."""
    a, b = meshes
    if between == "edges":
        return [fx.weld(a, "east", (b, "west"))], []
    if between == "edges, the finer first":
        return [fx.weld(b, "west", (a, "east"))], []
    middle = bar((1.0, 0.0, 0.0), (1.0, 1.0, 0.0), 4)
    return [fx.weld(middle, "bar", (a, None)), fx.weld(middle, "bar", (b, "west"))], [
        fx.Beam(middle, fx.Rectangle(0.1, 0.2), CORK)]


def held(a, b, *, straight: bool):
    """Supports that leave plane stress and bending free."""
    first = [fx.Support(a, "west", "x ry")] if straight else [fx.Support(a, "south-west", "x y z"),
                                                             fx.Support(a, "north-west", "x z")]
    return [*first, fx.Support(a, "south-west", "y z"), fx.Support(a, "north-west", "z"),
            fx.Support(b, "south-east", "z")]


INTERFACES = ["edges", "edges, the finer first", "bar between"]


@pytest.mark.parametrize("between", INTERFACES)
@pytest.mark.parametrize("form", ["naghdi-q2", pytest.param("naghdi-t2", marks=pytest.mark.slow)])
def test_constant_membrane_stress_passes(form, between):
    """Large uniform stretch; along the bar there is none, with Poisson's ratio zero, since the bar would hinder it."""
    (a, b), parts = two_panels(form, CORK if between == "bar between" else STEEL)
    joints, bars = joined((a, b), between)
    scene = fx.Scene([*parts, *bars], held(a, b, straight=True), [fx.EdgeForce(b, "east", (200.0, 0.0, 0.0))],
                     fx.Monitor(b, "north-east", "x"), joints=joints)
    record = fx.trace(fx.Case(scene, fx.LoadControl(1.0, fixed=True)))
    fields = [record.path.discretisation.kinematics(m).u for m in (a, b)]
    assert record.states[-1].deflection > 0.3
    assert off([(u.function_space.tabulate_dof_coordinates(), u.x.array.reshape(-1, 3)) for u in fields],
               linear) < 1e-10
    assert record.states[-1].unstable_modes == 0


@pytest.mark.parametrize("between", INTERFACES)
@pytest.mark.parametrize("form", ["naghdi-q2", pytest.param("naghdi-t2", marks=pytest.mark.slow)])
@pytest.mark.slow(quick=1)
def test_constant_bending_passes(form, between):
    """Moments on opposite edges: curvature m / (D (1 - nu^2)) everywhere, and minus nu of it across."""
    material = CORK if between == "bar between" else STEEL
    (a, b), parts = two_panels(form, material)
    joints, bars = joined((a, b), between)
    found = response(fx.Scene(
        [*parts, *bars], held(a, b, straight=False),
        [fx.Moment(a, "west", (0.0, -1.0, 0.0)), fx.Moment(b, "east", (0.0, 1.0, 0.0))],
        fx.Monitor(b, "north-east", "z"), joints=joints))
    assert off([found[m][0] for m in (a, b)], quadratic) < 1e-10
    assert off([found[m][1] for m in (a, b)], linear) < 1e-10
    places, turns = (np.concatenate([found[m][1][i] for m in (a, b)]) for i in (0, 1))
    slope = np.polyfit(places[:, 0], turns[:, 1], 1)[0]
    assert slope == pytest.approx(12 / (material.modulus * PLATE.thickness**3), rel=1e-9)


def structure(enforcement="multiplier"):
    """Two welded panels, a bar under the first on arms, another one bolted to the second, a spring and a hinge."""
    a, b = panel((1, 2)), panel((1, 3), (1.0, 0.0, 0.0))
    under = bar((0.1, 0.45, -0.2), (0.9, 0.55, -0.2), 2)
    post = bar((1.4, 0.4, 0.0), (1.4, 0.4, 0.7), 1)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)
        joints = [fx.weld(a, "east", (b, "west"), enforcement=enforcement),
                  fx.link(under, "bar", (a, None), 0.2, enforcement=enforcement),
                  fx.bolt(post, "start", (b, None), enforcement=enforcement),
                  fx.Interface(post, "end", (under, "end"), fx.forms.interface.stiff(np.diag([1.0, 2, 3, 4, 5, 6]))),
                  fx.hinge(post, fx.Stretch("start", along="bar", length=0.3), (under, None), reach=1.0,
                           enforcement=enforcement)]
    parts = [*(fx.Shell(m, PLATE, STEEL) for m in (a, b)), *(fx.Beam(m, up=(0.0, 1.0, 0.0), **SPATIAL) for m in (
        under, post))]
    return fx.Scene(parts, [fx.Support(a, "south-west", "x")], [fx.PointForce(under, "end", (0.0, 0.0, 1.0))],
                    fx.Monitor(under, "end", "z"), joints=joints)


def turn(discretisation, angle, steps):
    """Turn all that has nodes rigidly about an axis through the origin, in steps that are committed."""
    system, axis = discretisation.system, np.array([1.0, 2.0, -0.5]) / np.linalg.norm([1.0, 2.0, -0.5])
    rotation = Rotation.from_rotvec(angle / steps * axis).as_matrix()
    for _ in range(steps):
        motions = []
        for field in discretisation.unknowns.fields:
            if field.multiplier:
                motions.append(np.zeros((field.count, 1)))
            elif field.curved:
                motions.append(np.tile(2 * tan(angle / steps / 2) * axis, (field.count, 1)))
            else:
                places = field.value.function_space.tabulate_dof_coordinates() + field.table
                motions.append(places @ rotation.T - places)
        system.configure(system.step_by(motions), 0.0)
        system.history.commit()
        system.history.rebase()
    return rotation


@pytest.mark.parametrize("enforcement", ["multiplier", "penalty"])
@pytest.mark.slow(quick=1)
def test_rigid_motion_does_no_work(enforcement):
    """Welds, links, bolts, hinges and springs turned by 100 degrees: no residual, against that of a small strain."""
    scene = structure(enforcement)
    nothing = fx.Spring(scene.monitor.on, "end", "x", 0.0)  # which makes it no free body, whose mean motion is held
    scene = fx.Scene(scene.parts, [], scene.loads, scene.monitor, joints=[*scene.joints, nothing])
    discretisation = Discretisation(scene, mixed_points=False)
    system, out = discretisation.system, discretisation.system.create_vector()
    turn(discretisation, radians(100), 5)
    tip = discretisation.kinematics(scene.monitor.on).displacement(scene.monitor.on, "end")
    system.residual(out)
    assert np.linalg.norm(tip) > 0.5
    rigid = np.abs(out.array).max()
    x = system.create_vector(1e-3 * np.cos(np.arange(len(out.array))))
    system.configure(x, 0.0)
    system.residual(out)
    assert rigid < 1e-12 * np.abs(out.array).max() / 1e-3


@pytest.mark.parametrize("enforcement", ["multiplier", "penalty"])
@pytest.mark.slow(quick=1)
def test_tangents_are_derivatives(enforcement):
    """Far from equilibrium, with all kinds of joints."""
    discretisation = Discretisation(structure(enforcement), mixed_points=False)
    x = move_at_random(discretisation, size=0.1)
    assembled, differences = tangents(discretisation.system, x, 1e-4)
    assert distance(assembled, assembled.T) < 1e-13
    assert distance(assembled + assembled.T, differences + differences.T) < 1e-7


def lap(elements, others, stiffness, length):
    """Two beams side by side along a length, joined by springs along it; the end of the second is pulled by 1."""
    first, second = bar((0.0, 0.0), (length, 0.0), elements, 2), bar((0.0, 0.0), (length, 0.0), others, 2)
    joint = fx.Interface(first, "bar", (second, "bar"), fx.forms.interface.stiff(np.diag([stiffness, 10.0, 10.0])))
    beams = [fx.Beam(m, fx.Rectangle(1.0, 1e-3), fx.Elastic(1e3, 0.0)) for m in (second, first)]
    scene = fx.Scene(beams, [fx.clamp(first, "start")], [fx.PointForce(second, "end", (1e-6, 0.0))],
                     fx.Monitor(second, "end", "x"), joints=[joint])
    record = fx.trace(fx.Case(scene, fx.LoadControl(1.0, fixed=True)))
    return record.states[-1].deflection / 1e-6


@pytest.mark.parametrize("triangles", [False, True])
def test_pieces_found_at_once_are_those_found_on_the_way(monkeypatch, triangles):
    """Straight pieces within flat cells, and those that leave one, as where every cell is taken for a curved one."""
    def meetings():
        one, other = panel((3, 2), triangles=triangles), panel((5, 4), (0.2, 1.0, 0.0), triangles=triangles)
        across = fx.Stretch((0.1, 1.0, 0.0), (0.9, 1.0, 0.0))
        on_bar = fx.weld(bar((0.0, 1.0, 0.0), (1.0, 1.0, 0.0), 3), "bar", (one, "north"))
        return fx.weld(one, across, (other, None), reach=0.2).meeting, on_bar.meeting

    found = meetings()
    monkeypatch.setattr(Cells, "_flat", lambda self: np.zeros(len(self.cells), dtype=bool))
    for one, other in zip(found, meetings(), strict=True):
        assert np.allclose(one.weights, other.weights, rtol=1e-12)
        for side, same in zip(one.sides, other.sides, strict=True):
            assert np.array_equal(side.cells, same.cells)
            assert np.allclose(side.reference, same.reference, atol=1e-9)


def test_lap_joint_of_volkersen():
    """Elongation P L / (2 EA) + P coth(w L / 2) / (EA w), w^2 = 2 k / EA (Volkersen 1938)."""
    length, stiffness = 2.0, 3.0
    rate = sqrt(2 * stiffness)
    exact = length / 2 + cosh(rate * length / 2) / sinh(rate * length / 2) / rate
    errors = [abs(lap(n, m, stiffness, length) / exact - 1) for n, m in ((5, 7), (10, 14))]
    assert errors[1] < 1e-5
    assert errors[0] / errors[1] > 12, "the order of the energy of quadratic elements is four"


def test_bolt_turns_about_its_axis_alone():
    """Two beams in line, bolted: a hinge in one plane, as one beam in the other."""
    one, two = bar((0.0, 0.0, 0.0), (1.0, 0.0, 0.0), 4), bar((1.0, 0.0, 0.0), (2.0, 0.0, 0.0), 4)

    def tip(direction):
        force = np.array([0.0, 0.0, 0.0])
        force["xyz".index(direction)] = 1.0
        found = response(fx.Scene([fx.Beam(m, **SPATIAL, shear_rigidity=1e3) for m in (one, two)],
                                  [fx.clamp(one, "start"), fx.Support(two, "end", "y")],
                                  [fx.PointForce(two, "start", tuple(force))], fx.Monitor(two, "end", "z"),
                                  joints=[fx.bolt(one, "end", (two, "start"), axis=(0.0, 0.0, 1.0))]))
        places, motions = found[two][0]
        return {x: motions[np.isclose(places[:, 0], x)][0]["xyz".index(direction)] for x in (1.0, 2.0)}

    assert tip("y")[1.0] == pytest.approx(1 / 3, rel=1e-4), "the second beam hangs on it and takes nothing"
    assert tip("z")[2.0] == pytest.approx(1 / 3 + 1 / 2, rel=1e-4), "it goes straight on"


def stiffened(as_offset: bool, cells=(4, 3), elements=5, force=(0.02, 0.03, 0.05)):
    """A cantilever plate with a bar 0.15 under its middle line: on arms, or as an offset of the plate's mesh."""
    height = 0.15
    mesh = panel(cells, (0.0, -0.2, 0.0 if as_offset else height), (1.0, 0.4))
    beam = bar((0.0, 0.0, 0.0), (1.0, 0.0, 0.0), elements)
    shell = fx.Shell(mesh, fx.Plate(0.02), STEEL, offset=height if as_offset else 0.0)
    joint = fx.link(beam, "bar", (mesh, "shell"), 0.0 if as_offset else height)
    return beam, fx.Scene([fx.Beam(beam, fx.Rectangle(0.02, 0.1), STEEL), shell],
                          [fx.clamp(mesh, "west"), fx.clamp(beam, "start")], [fx.PointForce(beam, "end", force)],
                          fx.Monitor(beam, "end", "z"), joints=[joint])


def tip_of(found):
    places, motions = found
    return motions[np.argmax(places[:, 0])]


@pytest.mark.slow
def test_arms_are_an_offset():
    """Linear theory: the same to rounding, as displacement plus arm times rotation is in the space of displacements."""
    tips = []
    for as_offset in (True, False):
        beam, scene = stiffened(as_offset)
        tips.append(tip_of(response(scene)[beam][0]))
    assert tips[0] == pytest.approx(tips[1], rel=1e-9)


@pytest.mark.slow
def test_arms_are_an_offset_far_away():
    """Twisted and bent by a fifth of its length: the difference falls with the cells as their error does."""
    differences = []
    for n in (1, 2):
        tips = []
        for as_offset in (True, False):
            beam, scene = stiffened(as_offset, (4 * n, 3 * n), 5 * n, (0.0, 0.02, 0.07))
            tips.append(fx.trace(fx.Case(scene, fx.LoadControl(0.25))).displacement("end", beam))
        assert np.linalg.norm(tips[0]) > 0.19
        differences.append(np.linalg.norm(tips[1] - tips[0]) / np.linalg.norm(tips[0]))
    assert differences[1] < 0.015
    assert differences[0] / differences[1] > 3


def test_link_does_not_depend_on_cells_under_it():
    """Twisted, with the bar along the borders of the plate's cells and inside of them.

    A weld, which holds the turn about the plate's normal too, differs by a factor, and is stiffer than any limit.
    """
    tips, welded = [], []
    for cells in ((8, 6), (8, 5)):
        beam, scene = stiffened(False, cells, 10, (0.0, 0.05, 0.0))
        tips.append(tip_of(response(scene)[beam][0])[1])
        scene = fx.Scene(scene.parts, scene.supports, scene.loads, scene.monitor, joints=[
            fx.weld(beam, "bar", (scene.parts[1].mesh, "shell"), reach=0.15)])
        welded.append(tip_of(response(scene)[beam][0])[1])
    assert tips[0] == pytest.approx(tips[1], rel=0.03)
    assert welded[1] < 0.7 * welded[0] < 0.7 * tips[0]


def strip(welded: bool):
    """A strip clamped at one end and compressed at the other, in one mesh or in two that do not match."""
    width = 0.3
    if welded:
        meshes = panel((6, 4), lengths=(1.0, width)), panel((4, 6), (1.0, 0.0, 0.0), (1.0, width))
        joints = [fx.weld(meshes[0], "east", (meshes[1], "west"))]
    else:
        meshes, joints = [panel((10, 4), lengths=(2.0, width))], []
    parts = [fx.Shell(m, fx.Plate(0.02), CORK) for m in meshes]
    return fx.Scene(parts, [fx.clamp(meshes[0], "west")], [fx.EdgeForce(meshes[-1], "east", (-1.0, 0.0, 0.0))],
                    fx.Monitor(meshes[-1], "north-east", "z"), joints=joints)


@pytest.mark.slow
def test_stability_of_welded_strip_is_that_of_the_whole():
    """Bifurcation with Koiter's b, buckling load and frequencies; Euler's load is pi^2 E I / (4 L^2).

    With half of the cells in each direction the differences are three to five times as large.
    """
    found = []
    for welded in (True, False):
        record = fx.trace(fx.Case(strip(welded), fx.LoadControl(2e-3, target=6e-3)))
        (point,) = record.critical_points
        assert point.name == "stable symmetric"
        found.append([point.load / 0.3, record.buckling(record.states[0], count=1)[0].load / 0.3,
                      *(v.frequency for v in record.frequencies(record.states[0], 4)), point.curvature])
    assert found[0][:-1] == pytest.approx(found[1][:-1], rel=1e-3)
    assert found[0][-1] == pytest.approx(found[1][-1], rel=5e-3)
    assert found[0][0] == pytest.approx(np.pi**2 * 1e4 * 0.02**3 / 12 / 16, rel=2e-3)


def pulled(cells: int, at):
    """Stiffness of a bar on a clamped plate against a force along the bar at its beginning, in the plate's plane."""
    mesh, stub = panel((cells, cells)), bar((0.47, 0.53, 0.0), (0.67, 0.53, 0.0), 4)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)
        joint = fx.weld(stub, at, (mesh, None))
    found = response(fx.Scene(
        [fx.Beam(stub, fx.Rectangle(0.02, 0.02), fx.Elastic(1e6)), fx.Shell(mesh, fx.Plate(0.01), fx.Elastic(1e6))],
        [fx.clamp(mesh, edge) for edge in ("north", "south", "east", "west")],
        [fx.PointForce(stub, "start", (1.0, 0.0, 0.0))], fx.Monitor(stub, "start", "x"), joints=[joint]))
    places, motions = found[stub][0]
    return 1 / motions[np.argmin(places[:, 0]), 0]


@pytest.mark.slow
def test_point_weld_has_no_mesh_limit():
    """Its stiffness falls with each refinement by the same, as 1 / log; a weld of finite length converges."""
    cells = 5, 10, 20
    point, line = ([pulled(n, at) for n in cells] for at in ("start", "bar"))
    compliances = 1 / np.array(point)
    assert np.all(np.diff(compliances) > 1e-5), "each halving of the cells adds as much"
    assert np.diff(compliances)[1] > np.diff(compliances)[0] / 2
    assert np.abs(np.diff(1 / np.array(line)))[1] < np.abs(np.diff(compliances))[1]


def test_point_weld_on_a_shell_is_told():
    """Once for all joints of a kind, at the line of the user that makes the scene."""
    mesh, stubs = panel((2, 2)), [bar((x, 0.4, 0.0), (x, 0.4, 1.0), 1) for x in (0.4, 0.6)]
    beams = [fx.Beam(stub, **SPATIAL, up=(1.0, 0.0, 0.0)) for stub in stubs]
    parts = [fx.Shell(mesh, fx.Plate(0.1), UNIT["material"]), *beams]
    joints = [fx.weld(stub, "start", (mesh, None)) for stub in stubs]
    for count, words in ((1, "weld at 'start': joins a single point of a shell.*over a length"),
                         (2, r"welds at 'start', 'start' \(2\): each join a single point")):
        with pytest.warns(UserWarning, match=words) as told:
            fx.Scene(parts[:1 + count], [fx.clamp(mesh, "south")], [fx.PointForce(stubs[0], "end", (0.0, 0.0, 1.0))],
                     fx.Monitor(stubs[0], "end", "z"), joints=joints[:count])
        assert [w.filename for w in told if "single point" in str(w.message)] == [__file__]


def test_supports_that_hold_a_weld_leave_it_regular():
    """Two clamped beams tied once more at the clamp, and two welds on one another, are as without."""
    def loops(joints):
        one, two = bar((0.0, 0.0), (1.0, 0.0), 4, 2), bar((0.0, 0.0), (1.0, 0.0), 4, 2)
        scene = fx.Scene([fx.Beam(m, **UNIT) for m in (one, two)], [fx.clamp(m, "start") for m in (one, two)],
                         [fx.PointForce(one, "end", (0.0, 1e-4))], fx.Monitor(one, "end", "y"),
                         joints=[fx.weld(one, at, (two, to)) for at, to in joints])
        record = fx.trace(fx.Case(scene, fx.LoadControl(1.0, fixed=True)))
        return record.states[-1].deflection, record.states[-1].unstable_modes

    plain = loops([("end", "end")])
    assert plain[0] == pytest.approx(1e-4 / 6, rel=1e-6)
    again = loops([("end", "end"), ("start", "start"), ("end", "end")])
    assert again == pytest.approx(plain, rel=1e-9)
    assert loops([("bar", "bar")]) == pytest.approx(plain, rel=1e-6)


def flat():
    return panel((2, 2))


@pytest.mark.parametrize(("make", "words"), [
    (lambda m, b: fx.weld(b, "bar", (m, None)),
     r"weld at 'bar': the point \(.*0.5, 0.3\) is 0.3 off the part.*no reach; move.*reach of 0.3"),
    (lambda m, b: fx.link(b, "bar", (m, None), 0.2), "is 0.3 off the part.*more than the reach of 0.2"),
    (lambda m, b: fx.weld(b, "bar", (m, "roof")), "no point, edge or group of cells named 'roof'; it has.*west.*shell"),
    (lambda m, b: fx.weld(b, "rod", (m, None)), "no point, edge or group of cells named 'rod'; it has start, end, bar"),
    (lambda m, b: fx.weld(m, "shell", (b, "bar")), "weld at 'shell': is a surface; give an edge, or a Stretch"),
    (lambda m, b: fx.weld(m, "east", (b, "start")), "a line cannot be joined to the point 'start'"),
    (lambda m, b: fx.weld(m, fx.Stretch("south-west", along="south", length=1.2), (b, None), reach=2.0),
     "Stretch from 'south-west': its length 1.2 is more than the 1 of 'south'; shorten it"),
    (lambda m, b: fx.weld(m, fx.Stretch("north-east", along="south", length=0.2), (b, None)),
     "Stretch from 'north-east': 'south' does not touch its start"),
    (lambda m, b: fx.weld(m, fx.Stretch("south-west", end=(0.0, 0.0, 0.0)), (b, None)), "has no length"),
    (lambda m, b: fx.Stretch("south-west", along="south", length=0.0), "length is 0.0; it must be positive"),
    (lambda m, b: fx.Stretch("south-west"), "give either its end, or what it goes along and its length"),
    (lambda m, b: fx.Interface(b, "bar", (m, None), "x q"), "Interface at 'bar': no component 'q'"),
    (lambda m, b: fx.Interface(b, "bar", (m, None), ""), "Interface at 'bar': law is ''; it must be a text that"),
    (lambda m, b: fx.weld(b, "bar", (m, None), enforcement="glue"), "enforcement is 'glue'; it must be one of"),
    (lambda m, b: fx.weld(b, "bar", (bar((0.0, 0.0), (1.0, 0.0), 1, 2), "bar")),
     "weld at 'bar': joins a mesh in 3 with one in 2 dimensions"),
    (lambda m, b: fx.bolt(b, "start", (b, "end")), "axes are 'normal'; give three directions"),
    (lambda m, b: fx.bolt(b, "start", (b, "end"), axis=(0.0, 0.0, 0.0)), "bolt: axis is"),
], ids=lambda value: value[:24] if isinstance(value, str) else "")
def test_wrong_interfaces_are_named(make, words):
    with pytest.raises(ValueError, match=words):
        make(flat(), bar((0.2, 0.5, 0.3), (0.8, 0.5, 0.3), 2))
