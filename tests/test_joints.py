"""Springs, hinges, welds, rigid links, uniform motion, foundations, and parts that nothing joins.

Beams of unit length and bending stiffness, shear-rigid and hardly extensible, against beam theory.
"""

from __future__ import annotations

import warnings

import numpy as np
import pytest
from helpers import TURNED_AT_EDGES, distance, move_at_random, on_two_processes, tangents
from scipy.optimize import brentq

import sheetfx as fx
from sheetfx.discrete.discretisation import Discretisation

UNIT = {"section": fx.Rectangle(1.0, 0.001), "material": fx.Elastic(12e9, 0.0), "shear_rigidity": 1e3}
SPATIAL = {"section": fx.Rectangle(0.1, 0.1), "material": fx.Elastic(1.2e5, 0.0)}  # bending stiffness 1


def member(start, end, name="beam", elements=4, dimension=2, order=1):
    """A straight mesh with the points start, middle and end."""
    middle = tuple((np.array(start) + end) / 2)
    nodes = {"start": start, "middle": middle, "end": end}
    members = {f"{name} 1": ("start", "middle", elements // 2), f"{name} 2": ("middle", "end", elements // 2)}
    return fx.read(lambda: fx.meshes.frame(nodes, members), dimension, order)


def settled(beams, supports, loads, monitor, steps=1, **scene):
    """Last state of a scene under dead load control, and its record."""
    record = fx.trace(fx.Case(fx.Scene(beams, supports, loads, monitor, **scene),
                              fx.LoadControl(1 / steps, fixed=True)))
    return record.states[-1], record


def cantilever_with(joint, load=1e-4):
    mesh = member((0.0, 0.0), (1.0, 0.0))
    state, _ = settled([fx.Beam(mesh, **UNIT)], [fx.clamp(mesh, "start")],
                       [fx.PointForce(mesh, "end", (0.0, load))], fx.Monitor(mesh, "end", "y"), joints=[joint(mesh)])
    return state.deflection / load


@pytest.mark.parametrize(("joint", "flexibility"), [
    (lambda m: fx.Spring(m, "end", "y", 4.0), 1 / 7),
    (lambda m: fx.Spring(m, "end", "rz", 1.0), 1 / 3 - 1 / 4 / 2),
    (lambda m: fx.Spring(m, "start", "y", 5.0), 1 / 3),
    (lambda m: fx.Spring(m, "middle", "y", 4.0, (m, "start")), 1 / 3 - (5 / 48) ** 2 * 4 / (1 + 4 / 24)),
], ids=["translation", "rotation", "at a support", "between points"])
@pytest.mark.slow(quick=1)
def test_springs(joint, flexibility):
    assert cantilever_with(joint) == pytest.approx(flexibility, rel=1e-6)


def test_spring_with_a_law():
    """A cubic spring: 3 v + c v^3 = F."""
    def cubic(extension, stiffness):
        return stiffness * extension**3

    load = 1e-3
    found = load * cantilever_with(lambda m: fx.Spring(m, "end", "y", 4e7, law=cubic), load)
    assert 3 * found + 4e7 * found**3 == pytest.approx(load, rel=1e-5)
    assert 4e7 * found**3 > 0.2 * load


def test_spring_between_models():
    """Two cantilevers, tip to tip: the free one is held by k 3 / (k + 3)."""
    meshes = [member((0.0, y), (1.0, y)) for y in (0.0, 0.1)]
    state, _ = settled([fx.Beam(m, **UNIT) for m in meshes], [fx.clamp(m, "start") for m in meshes],
                       [fx.PointForce(meshes[0], "end", (0.0, 1e-4))], fx.Monitor(meshes[0], "end", "y"),
                       joints=[fx.Spring(meshes[0], "end", "y", 6.0, (meshes[1], "end"))])
    assert state.deflection == pytest.approx(1e-4 / (3 + 2), rel=1e-6)


@pytest.mark.parametrize("dimension", [2, 3])
def test_column_on_a_rotational_spring(dimension):
    """A rigid column on a spring buckles at k / L (stable symmetric: P = k angle / (L sin angle))."""
    stiff = {"section": fx.Rectangle(0.1, 0.1), "material": fx.Elastic(1.2e11, 0.0)}
    start, end = ((0.0,) * dimension, (1.0,) + (0.0,) * (dimension - 1))
    mesh = member(start, end, dimension=dimension)
    held = "x y" if dimension == 2 else "x y z rx ry"
    load = (-1.0,) + (0.0,) * (dimension - 1)
    supports = [fx.Support(mesh, "start", held)]
    if dimension == 3:
        supports.append(fx.Support(mesh, "end", "z"))
    scene = fx.Scene([fx.Beam(mesh, **stiff)], supports, [fx.PointForce(mesh, "end", load)],
                     fx.Monitor(mesh, "end", "y"), joints=[fx.Spring(mesh, "start", "rz", 2.0)])
    (point,) = fx.trace(fx.Case(scene, fx.LoadControl(0.7, target=3.0))).critical_points
    assert point.load == pytest.approx(2.0, rel=5e-6), "its own flexibility is a millionth of the spring's"
    assert point.name == "stable symmetric"
    assert point.curvature == pytest.approx(1 / 6, rel=1e-3), "of angle / sin angle, with the tip's way as amplitude"


def test_hinge_between_models():
    """A beam hinged to a cantilever's tip brings half of the force in its middle there."""
    one, two = member((0.0, 0.0), (1.0, 0.0)), member((1.0, 0.0), (2.0, 0.0))
    state, record = settled(
        [fx.Beam(m, **UNIT) for m in (one, two)], [fx.clamp(one, "start"), fx.Support(two, "end", "y")],
        [fx.PointForce(two, "middle", (0.0, 1e-4))], fx.Monitor(one, "end", "y"),
        joints=[fx.hinge(one, "end", (two, "start"))])
    assert state.deflection == pytest.approx(0.5e-4 / 3, rel=1e-6)
    assert record.rotation("start", two) != pytest.approx(record.rotation("end", one), rel=0.1)
    assert state.unstable_modes == 0, "each multiplier has its negative pivot"


def test_release_in_a_frame():
    """The same hinge as a release of a member's end, in one mesh."""
    nodes = {"a": (0.0, 0.0), "b": (1.0, 0.0), "c": (1.5, 0.0), "d": (2.0, 0.0)}
    members = {"left": ("a", "b", 4), "middle": ("b", "c", 2), "right": ("c", "d", 2)}
    mesh = fx.read(lambda: fx.meshes.frame(nodes, members, releases=[("middle", "b")]), 2)
    state, _ = settled([fx.Beam(mesh, **UNIT)], [fx.clamp(mesh, "a"), fx.Support(mesh, "d", "y")],
                       [fx.PointForce(mesh, "c", (0.0, 1e-4))], fx.Monitor(mesh, "b", "y"),
                       joints=[fx.hinge(mesh, "b", (mesh, "b of middle"))])
    assert state.deflection == pytest.approx(0.5e-4 / 3, rel=1e-6)


def bent_in_space(joined: bool):
    """Tip of an L of two arms in space under a large force, in one mesh or welded from two."""
    corner, tip, force = (1.0, 0.0, 0.0), (1.0, 1.0, 0.0), (0.5, 0.3, 2.0)
    if joined:
        nodes = {"start": (0.0, 0.0, 0.0), "corner": corner, "end": tip}
        meshes = [fx.read(lambda: fx.meshes.frame(nodes, {"a": ("start", "corner", 4), "b": ("corner", "end", 4)}), 3)]
        joints = []
    else:
        meshes = [member((0.0, 0.0, 0.0), corner, dimension=3), member(corner, tip, dimension=3)]
        joints = [fx.weld(meshes[0], "end", (meshes[1], "start"))]
    state, record = settled([fx.Beam(m, **SPATIAL) for m in meshes], [fx.clamp(meshes[0], "start")],
                            [fx.PointForce(meshes[-1], "end", force)], fx.Monitor(meshes[-1], "end", "z"), 4,
                            joints=joints)
    return record.displacement("end", meshes[-1]), state


def test_weld_is_as_one_model():
    """Large rotations in space; the tie is exact, so that only the solver's tolerance is left."""
    one, whole = bent_in_space(True)
    two, state = bent_in_space(False)
    assert np.linalg.norm(one) > 0.5
    assert two == pytest.approx(one, rel=1e-7)
    assert state.unstable_modes == whole.unstable_modes == 0


def test_rigid_link_turns_with_its_first_end():
    """An arm of length e across a cantilever's tip under a force F along the beam: the moment F e, bent far.

    The end of the arm stands at the tip plus e times the turned normal, exactly.
    """
    beam, stub = member((0.0, 0.0), (1.0, 0.0)), member((1.0, 0.3), (1.0, 0.5))
    state, record = settled([fx.Beam(m, **SPATIAL) for m in (beam, stub)], [fx.clamp(beam, "start")],
                            [fx.PointForce(stub, "start", (-2.0, 0.0))], fx.Monitor(beam, "end", "y"), 4,
                            joints=[fx.weld(beam, "end", (stub, "start"))])
    angle = record.rotation("end", beam)
    arm = np.array([1.0, 0.3]) + record.displacement("start", stub) - np.array([1.0, 0.0]) - record.displacement(
        "end", beam)
    assert angle > 0.5
    assert arm == pytest.approx([-0.3 * np.sin(angle), 0.3 * np.cos(angle)], abs=1e-9)
    assert record.rotation("start", stub) == pytest.approx(angle, rel=1e-9)


def test_tangents_of_joints_are_derivatives():
    """Springs and ties in space, far from equilibrium and from each other."""
    meshes = [member((0.0, 0.0, 0.0), (1.0, 0.0, 0.0), dimension=3), member((1.0, 0.2, 0.0), (2.0, 0.2, 0.1),
                                                                          dimension=3)]
    joints = [fx.weld(meshes[0], "end", (meshes[1], "start")), fx.Spring(meshes[0], "middle", "rx", 3.0),
              fx.Spring(meshes[0], "middle", "y", 2.0, (meshes[1], "middle")),
              fx.Spring(meshes[0], "middle", "rz", 2.0, (meshes[1], "end"))]
    scene = fx.Scene([fx.Beam(m, **SPATIAL) for m in meshes], [fx.clamp(meshes[0], "start")],
                     [fx.PointForce(meshes[1], "end", (0.0, 0.0, 1.0))], fx.Monitor(meshes[1], "end", "z"),
                     joints=joints)
    discretisation = Discretisation(scene, mixed_points=False)
    x = move_at_random(discretisation)
    assembled, differences = tangents(discretisation.system, x)
    assert distance(assembled, assembled.T) < 1e-13
    assert distance(assembled + assembled.T, differences + differences.T) < 1e-7


def test_edge_that_moves_alike():
    """A plate pulled at one corner of an edge that stays straight and parallel moves as under the mean force."""
    mesh = fx.read(lambda: fx.meshes.rectangle((3, 2)), 3, 2)
    shell = fx.Shell(mesh, fx.Plate(0.01), fx.Elastic(1e4, 0.0), form="naghdi-q2")
    state, record = settled(
        [shell], [fx.Support(mesh, "west", "x y z rx ry rz"), fx.Support(mesh, "north", "y"),
                  fx.Support(mesh, "south", "y"), fx.Support(mesh, "east", "y z rx ry rz")],
        [fx.PointForce(mesh, "south-east", (1e-3, 0.0, 0.0))], fx.Monitor(mesh, "north-east", "x"),
        joints=[fx.Uniform(mesh, "east", "x")])
    u = record.path.discretisation.kinematics(mesh).u
    places = u.function_space.tabulate_dof_coordinates()
    edge = u.x.array.reshape(-1, 3)[places[:, 0] > 1 - 1e-9, 0]
    assert edge == pytest.approx(state.deflection, rel=1e-9)
    assert state.deflection == pytest.approx(1e-3 / (1e4 * 0.01), rel=1e-4), "F L / (E t b), but for its square"


def test_foundation_under_a_shell():
    """A rigid plate sinks by its load over the stiffness of its foundation."""
    mesh = fx.read(lambda: fx.meshes.rectangle((2, 2)), 3)
    shell = fx.Shell(mesh, fx.Plate(0.1), fx.Elastic(1e6, 0.3), form="naghdi-q2")
    state, _ = settled([shell], [fx.Support(mesh, "south-west", "x y rz")],
                       [fx.SurfaceForce(shell, (0.0, 0.0, 2.0))], fx.Monitor(mesh, "north-east", "z"),
                       joints=[fx.Foundation(shell, (0.0, 0.0, 50.0))])
    assert state.deflection == pytest.approx(2.0 / 50.0, rel=1e-6)


def test_models_that_nothing_joins_are_told():
    meshes = [member((0.0, y), (1.0, y), name) for y, name in ((0.0, "plate"), (0.1, "stiffener"))]
    beams = [fx.Beam(m, **UNIT) for m in meshes]

    def scene(joints):
        return fx.Scene(beams, [fx.clamp(m, "start") for m in meshes],
                        [fx.PointForce(meshes[0], "end", (0.0, 1.0))], fx.Monitor(meshes[0], "end", "y"), joints=joints)

    with pytest.warns(UserWarning, match="the piece with 'plate 1'.* and the piece with 'stiffener 1'.*weld"):
        scene([])
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        scene([fx.hinge(meshes[0], "end", (meshes[1], "end"))])


@pytest.mark.parametrize("fused", [False, True])
def test_pieces_of_one_mesh_that_nothing_joins_are_told(fused):
    """Two members that cross, in a model that was not fragmented: each is held, and nothing else would tell."""
    nodes = {"a": (0.0, 0.0), "b": (1.0, 0.0), "c": (0.5, -0.5), "d": (0.5, 0.5), "middle": (0.5, 0.0)}
    members = {"one": ("a", "b", 2), "three": ("c", "d", 1)}
    if fused:
        members = {name: (end, "middle", 1) for name, end in zip(("one", "two", "three", "four"), "abcd", strict=True)}
    mesh = fx.read(lambda: fx.meshes.frame({n: nodes[n] for n in nodes if fused or n != "middle"}, members), 2)
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        fx.Scene([fx.Beam(mesh, **UNIT)], [fx.clamp(mesh, "a"), fx.clamp(mesh, "c")],
                 [fx.PointForce(mesh, "b", (0.0, 1.0))], fx.Monitor(mesh, "b", "y"))
    told = " ".join(str(w.message) for w in caught)
    if fused:
        assert not told
    else:
        assert "nothing joins the piece with 'three', 'c', 'd' and the piece with 'one', 'a', 'b'" in told


@pytest.mark.parametrize(("make", "words"), [
    (lambda m: fx.Spring(m, "end", "z", 1.0), "Spring at 'end': no component 'z'; choose from x y rz"),
    (lambda m: fx.Spring(m, "tip", "y", 1.0), "no point or edge named 'tip'"),
    (lambda m: fx.Spring(m, "end", "y", 1.0, (m, "end")), "Spring at 'end': joins the point to itself"),
    (lambda m: fx.Interface(m, "end", (m, "end"), "x"), "Interface at 'end': ties the point to itself"),
    (lambda m: fx.Interface(m, "end", (m, "start"), "x w"), "Interface at 'end': no component 'w'"),
    (lambda m: fx.Uniform(m, "end", "rz"), "Uniform at 'end': no component 'rz'"),
    (lambda m: fx.Foundation(fx.Beam(m, **UNIT), (1.0,)), "Foundation: stiffness.*has 1 components; give 2"),
    (lambda m: fx.Until(40.0), "Until: event is 40.0; it must be an Event or a function"),
])
def test_wrong_joints_are_named(make, words):
    with pytest.raises(ValueError, match=words):
        make(member((0.0, 0.0), (1.0, 0.0)))


def test_bars_have_no_rotations_to_tie():
    mesh = member((0.0, 0.0), (1.0, 0.0))
    other = member((1.0, 0.0), (2.0, 0.0), elements=2)
    scene = fx.Scene([fx.Bar(other, UNIT["section"], UNIT["material"]), fx.Beam(mesh, **UNIT)],
                     [fx.clamp(mesh, "start"), fx.pin(other, "end"), fx.Support(other, "middle", "y")],
                     [fx.PointForce(mesh, "end", (0.0, 1.0))], fx.Monitor(mesh, "end", "y"),
                     joints=[fx.weld(mesh, "end", (other, "start"))])
    with pytest.raises(ValueError, match="weld at 'end': ties rotations, but bars have none"):
        fx.Path(scene)


def test_springs_on_two_processes():
    """A spring to the ground and an edge of equal motion; points on different processes are refused clearly."""
    lines = on_two_processes('''
import sheetfx as fx
from test_joints import UNIT, member, settled
mesh = member((0.0, 0.0), (1.0, 0.0), elements=8)
state, _ = settled([fx.Beam(mesh, **UNIT)], [fx.clamp(mesh, "start")], [fx.PointForce(mesh, "end", (0.0, 1e-4))],
                   fx.Monitor(mesh, "end", "y"), joints=[fx.Spring(mesh, "end", "y", 4.0)])
print(state.deflection)
try:
    settled([fx.Beam(mesh, **UNIT)], [fx.clamp(mesh, "start")], [fx.PointForce(mesh, "end", (0.0, 1e-4))],
            fx.Monitor(mesh, "end", "y"), joints=[fx.Spring(mesh, "end", "y", 4.0, (mesh, "start"))])
except ValueError as error:
    print(error)
''')
    assert float(lines[0]) == pytest.approx(1e-4 / 7, rel=1e-6)
    assert "different ones of the 2 processes" in lines[1]


def column(welded: bool):
    """A hinged column of two halves, with density: one mesh, or two that are welded."""
    options = {"section": fx.Rectangle(0.01, 0.01), "material": fx.Elastic(1e9, density=1.0)}
    if welded:
        lower, upper = member((0.0, 0.0), (0.5, 0.0), elements=8), member((0.5, 0.0), (1.0, 0.0), elements=8)
        meshes, middle = [lower, upper], fx.Monitor(lower, "end", "y")
        joints = [fx.weld(lower, "end", (upper, "start"))]
    else:
        whole = member((0.0, 0.0), (1.0, 0.0), elements=16)
        meshes, joints, middle = [whole], [], fx.Monitor(whole, "middle", "y")
    return fx.Scene([fx.Beam(m, **options) for m in meshes],
                    [fx.pin(meshes[0], "start"), fx.Support(meshes[-1], "end", "y")],
                    [fx.PointForce(meshes[-1], "end", (-1.0, 0.0))], middle, joints=joints)


def test_welded_column_is_the_whole_one():
    """Bifurcations with Koiter's b, branches, buckling loads and frequencies: multipliers change none of them."""
    found, names = [], []
    for welded in (True, False):
        record = fx.trace(fx.Case(column(welded), fx.LoadControl(3.0, target=36.0)))
        points = record.critical_points
        (branch, _) = record.branches(points[0])
        rise = points[0].curvature * branch.amplitude**2
        assert branch.start.load / points[0].load - 1 == pytest.approx(rise, rel=0.05)
        names.append([p.title for p in points])
        found.append([*(p.load for p in points), *(p.curvature for p in points),
                      *(b.factor for b in record.buckling(record.states[0], count=2)),
                      *(v.squared for v in record.frequencies(record.states[1], 3))])
    assert names[0] == names[1] and len(names[0]) == 2
    assert found[0] == pytest.approx(found[1], rel=2e-6)


def test_hinged_truss_of_two_models_snaps():
    """Two struts on hinges that a hinge ties at their apex: the limit and the fall of a von Mises truss."""
    meshes = [member((-1.0, 0.0), (0.0, 0.2), elements=2), member((1.0, 0.0), (0.0, 0.2), elements=2)]
    stocky = {"section": fx.Rectangle(1.0, 1.0), "material": fx.Elastic(1.0, 0.0)}
    scene = fx.Scene([fx.Beam(m, **stocky) for m in meshes], [fx.pin(m, "start") for m in meshes],
                     [fx.PointForce(meshes[0], "end", (0.0, -1.0))], fx.Monitor(meshes[0], "end", "y", -1.0),
                     joints=[fx.hinge(meshes[0], "end", (meshes[1], "end"))])
    record = fx.trace(fx.Case(scene, fx.ArcLength(0.01), fx.Until(deflection=0.45)))
    length, base = np.hypot(1.0, 0.2), 1.0
    at_limit = (length * base**2) ** (1 / 3)
    exact = 2 * (length - at_limit) / length * np.sqrt(at_limit**2 - base**2) / at_limit
    limit = next(p for p in record.critical_points if p.kind == "limit")
    assert limit.load == pytest.approx(exact, rel=1e-9)
    unstable = next(s for s in record.states if s.unstable_modes)
    fall = record.snap(unstable)
    assert fall.after.unstable_modes == 0 and fall.after.load == pytest.approx(unstable.load, rel=1e-9)
    assert fall.after.deflection > 0.4 and fall.energy_released > 0


@pytest.mark.parametrize(("joint", "load"), [
    (lambda m: [fx.Spring(m, "north-east", "rx", 1.0)], lambda m: fx.PointForce(m, "north-east", (0.0, 0.0, 1.0))),
    (lambda m: [], lambda m: fx.Moment(m, "north-east", (1.0, 0.0, 0.0))),
    (lambda m: [], lambda m: fx.PrescribedRotation(m, "north-east", (0.1, 0.0, 0.0))),
], ids=["spring", "moment", "prescribed rotation"])
def test_rotations_that_are_not_there_are_named(joint, load):
    """Rotations of this form live at the middles of edges: a moment at a corner would act on nothing."""
    mesh = fx.read(lambda: fx.meshes.rectangle((2, 2), triangles=True), 3)
    shell = fx.Shell(mesh, fx.Plate(0.1), fx.Elastic(1e4, 0.3), form=TURNED_AT_EDGES)
    scene = fx.Scene([shell], [fx.clamp(mesh, "west")], [load(mesh)], fx.Monitor(mesh, "north-east", "z"),
                     joints=joint(mesh))
    with pytest.raises(ValueError, match="'north-east' has no node.*rotations at corners"):
        fx.Path(scene)


def test_uniform_edge_that_a_support_holds_is_named():
    mesh = fx.read(lambda: fx.meshes.rectangle((2, 2)), 3)
    shell = fx.Shell(mesh, fx.Plate(0.1), fx.Elastic(1e4, 0.3), form="naghdi-q2")
    scene = fx.Scene([shell], [fx.clamp(mesh, "west"), fx.Support(mesh, "south", "x y")],
                     [fx.PointForce(mesh, "north-east", (1.0, 0.0, 0.0))], fx.Monitor(mesh, "north-east", "x"),
                     joints=[fx.Uniform(mesh, "east", "x")])
    with pytest.raises(ValueError, match="Uniform at 'east': the support at 'south' holds component x"):
        fx.Path(scene)


def test_rigid_end_in_linear_buckling():
    """A cantilever column of length L with a rigid end of length e under an axial force there: k e tan(k L) = 1.

    The force in the link that stands for the end turns with it. Shear lowers the loads by 1e-5 and 2e-4.
    """
    slender = {"section": fx.Rectangle(1.0, 0.01), "material": fx.Elastic(12e6, 0.0)}
    column, stub = member((0.0, 0.0), (1.0, 0.0), elements=8), member((1.5, 0.0), (1.6, 0.0))
    scene = fx.Scene([fx.Beam(m, **slender) for m in (column, stub)], [fx.clamp(column, "start")],
                     [fx.PointForce(stub, "start", (-1.0, 0.0))], fx.Monitor(column, "end", "y"),
                     joints=[fx.weld(column, "end", (stub, "start"))])
    record = fx.trace(fx.Case(scene, until=fx.Until(steps=0)))
    exact = [brentq(lambda x: 0.5 * x * np.tan(x) - 1, low, high) ** 2 for low, high in ((0.1, 1.5), (3.2, 4.7))]
    assert [b.factor for b in record.buckling(record.states[0], count=2)] == pytest.approx(exact, rel=3e-4)


def edge_on_springs(axis: str) -> float:
    """A plate whose loaded edge, nodes of which one process has alone, rests on springs."""
    mesh = fx.read(lambda: fx.meshes.rectangle((4, 3), (1.0, 0.6)), 3, 2)
    shell = fx.Shell(mesh, fx.Plate(0.03), fx.Elastic(2e3, 0.3))
    scene = fx.Scene([shell], [fx.clamp(mesh, "west")], [fx.EdgeForce(mesh, "east", (0.0, 0.0, 0.02))],
                     fx.Monitor(mesh, "north-east", "z"), joints=[fx.Spring(mesh, "east", axis, 0.1)])
    return fx.trace(fx.Case(scene, fx.LoadControl(0.05, target=0.05))).states[-1].deflection


@pytest.mark.silent("q13")
def test_springs_at_the_nodes_of_an_edge_are_told():
    """Their stiffness in all grows with the number of nodes; `test_loads_of_place` has that per length."""
    with pytest.warns(UserWarning, match="is one at each node of the edge, .*give one per length by an EdgeFoundation"):
        edge_on_springs("z")


@pytest.mark.filterwarnings("ignore:Spring at")
@pytest.mark.silent("f06")
@pytest.mark.slow
def test_springs_on_an_edge_on_two_processes():
    """The size of the mesh, which places are compared by, is no longer asked of all by some."""
    lines = on_two_processes("from test_joints import edge_on_springs\nfor a in ('z', 'ry'): print(edge_on_springs(a))")
    assert list(map(float, lines)) == pytest.approx([edge_on_springs("z"), edge_on_springs("ry")], rel=1e-6)


@pytest.mark.parametrize("joint", ["compatible", "hinge"])
@pytest.mark.parametrize("skew", [0.1, 0.0])
def test_bar_in_a_coordinate_plane_is_held_by_its_hinge(joint, skew):
    """A bar without stiffness along z at a node that other bars hold through the joint."""
    nodes = {"a": (-1.0, 0.0, 0.0), "m": (0.0, 0.3, 0.0), "b": (1.0, 0.0, skew), "c": (0.0, 0.3, 1.0),
             "d": (0.0, 0.3, -1.0)}

    def bars(members):
        used = {n: nodes[n] for ends in members.values() for n in ends[:2]}
        return fx.read(lambda: fx.meshes.frame(used, members), 3)

    def settled(meshes, joints):
        scene = fx.Scene([fx.Bar(m, fx.Rectangle(1.0, 1.0), fx.Elastic(1.0)) for m in meshes],
                         [fx.pin(meshes[0], n) for n in "acd"] + [fx.pin(meshes[-1], "b")],
                         [fx.PointForce(meshes[0], "m", (0.0, -1e-3, 0.0))], fx.Monitor(meshes[0], "m", "y", -1.0),
                         joints=joints)
        return fx.trace(fx.Case(scene, fx.LoadControl(1.0))).states[-1].deflection

    left, right = {"1": ("a", "m", 1), "2": ("c", "m", 1), "3": ("d", "m", 1)}, {"4": ("m", "b", 1)}
    parts = bars(left), bars(right)
    joined = fx.hinge(parts[0], "m", (parts[1], "m")) if joint == "hinge" else fx.Compatible(*parts)
    assert settled(parts, [joined]) == pytest.approx(settled([bars(left | right)], []), rel=1e-9)


def test_hinged_bars_that_nothing_holds_across_their_plane_are_told():
    nodes = {"a": (-1.0, 0.0, 0.0), "m": (0.0, 0.3, 0.0), "b": (1.0, 0.0, 0.0)}
    left, right = (fx.read(lambda ends=ends: fx.meshes.frame({n: nodes[n] for n in ends}, {"bar": (*ends, 1)}), 3)
                   for ends in ("am", "mb"))
    scene = fx.Scene([fx.Bar(m, fx.Rectangle(1.0, 1.0), fx.Elastic(1.0)) for m in (left, right)],
                     [fx.pin(left, "a"), fx.pin(right, "b")], [fx.PointForce(left, "m", (0.0, -1e-3, 0.0))],
                     fx.Monitor(left, "m", "y", -1.0), joints=[fx.hinge(left, "m", (right, "m"))])
    with pytest.raises(ValueError, match="can move freely"):
        fx.trace(fx.Case(scene, fx.LoadControl(1.0)))
