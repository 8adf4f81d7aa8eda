"""Contact of parts with rigid obstacles, in the plane and in space, against closed forms and an elastica."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from helpers import distance, move_at_random, tangents
from scipy.integrate import solve_ivp
from scipy.optimize import fsolve

import sheetfx as fx
from sheetfx.continuation.state import CriticalPoint, State
from sheetfx.critical.verdict import doubts
from sheetfx.discrete.discretisation import Discretisation
from sheetfx.discrete.pair_work import pairs_of

LENGTH, DEPTH, WIDTH, MODULUS = 1000.0, 10.0, 10.0, 2e5
BENDING = MODULUS * WIDTH * DEPTH**3 / 12


def bar(dimension, cells=20):
    """A beam along x from a clamped start."""
    end = (LENGTH, 0.0, 0.0)[:dimension]
    places = {"start": (0.0,) * dimension, "middle": tuple(x / 2 for x in end), "end": end}
    lines = {"inner": ("start", "middle", cells // 2), "outer": ("middle", "end", cells // 2)}
    mesh = fx.read(lambda: fx.meshes.frame(places, lines), dimension)
    how = {} if dimension == 2 else {"up": (0.0, 0.0, 1.0)}
    return mesh, fx.Beam(mesh, fx.Rectangle(WIDTH, DEPTH), fx.Elastic(MODULUS, 0.0), **how)


def pressed_by_circle(friction, **how):
    """The cantilever is bent by a circle that travels down at 0.7 of its length, and slides along it."""
    mesh, beam = bar(2)
    punch = fx.RigidCylinder(200.0, (700.0, 300.0), travel=(0.0, -1.0))
    touch = fx.ObstacleContact(mesh, None, punch, distance=0.0, friction=friction, samples=4, **how)
    scene = fx.Scene([beam], [fx.clamp(mesh, "start")], [fx.ObstacleForce(punch, 60.0)],
                     fx.Monitor(mesh, "end", "y", -1.0), joints=[touch])
    return fx.Case(scene, until=fx.Until(deflection=500.0))


def elastica(friction, tip, radius=200.0, centre=700.0):
    """Force of a circle above a place of an inextensible cantilever whose tip has gone down, slipping outwards.

    Force, place and slope of the point of contact are such that the beam is clamped, touches the circle, and has its
    tip there.
    """
    angle = np.arctan(friction)

    def misses(unknown):
        size, place, slope = unknown * np.array([100.0, LENGTH, 1.0])
        force = size * np.array([np.sin(slope + angle), -np.cos(slope + angle)])

        def along(_, y):
            return [np.cos(y[2]), np.sin(y[2]), y[3], (np.sin(y[2]) * force[0] - np.cos(y[2]) * force[1]) / BENDING]

        x, y, start, _ = solve_ivp(along, [place, 0.0], [0.0, 0.0, slope, 0.0], rtol=1e-10, atol=1e-10).y[:, -1]
        return [start, (-x - radius * np.sin(slope) - centre) / LENGTH,
                (-y + (LENGTH - place) * np.sin(slope) + tip) / LENGTH]

    size, _, slope = fsolve(misses, [5.0, 0.65, -0.68], xtol=1e-12)
    return 100 * size * np.cos(slope + angle)


@pytest.mark.parametrize("friction", [pytest.param(0.0, marks=pytest.mark.slow), 0.3])
def test_beam_slides_under_a_circle(friction):
    """To 0.2 %: it touches at samples, 7 to 17 mm apart; in the plane and in space, where it is along z."""
    record = fx.trace(pressed_by_circle(friction))
    assert record.states[-1].load == pytest.approx(elastica(friction, 500.0), rel=2e-3)
    if friction:
        assert any("with friction" in line for line in record.path.searched)


class Floor:
    """An obstacle of one's own: all that is below a height."""

    travel = None
    dimensions = 2, 3

    def __init__(self, height):
        self.height = height

    def gap(self, x, shift):
        return x[x.ufl_shape[0] - 1] - self.height


def plane(height, dimension):
    up = (0.0, 0.0, 1.0)[-dimension:]
    return fx.RigidPlane(tuple(height * c for c in up), up)


@pytest.mark.parametrize("dimension, floor", [(2, plane), (3, plane), (3, lambda height, _: Floor(height))])
@pytest.mark.slow(quick=1)
def test_beam_meets_a_plane(dimension, floor):
    """A cantilever under a force in its middle whose end meets a plane: 5/16 of the force, less what the gap takes.

    The path turns by nearly a right angle there.
    """
    mesh, beam = bar(dimension)
    up = (0.0, 0.0, 1.0)[-dimension:]
    gap, load = 2.0, 40.0
    touch = fx.ObstacleContact(mesh, "end", floor(-gap - DEPTH / 2, dimension))
    scene = fx.Scene([beam], [fx.clamp(mesh, "start")], [fx.PointForce(mesh, "middle", tuple(-c for c in up))],
                     fx.Monitor(mesh, "middle", "xyz"[dimension - 1], -1.0), joints=[touch])
    record = fx.trace(fx.Case(scene, until=fx.Until(load=load)))
    pairs = record.pairs(touch)
    expected = 5 / 16 * load - 3 * BENDING * gap / LENGTH**3
    assert (pairs.pressure * pairs.weight).sum() == pytest.approx(expected, rel=2e-3), "shear, and small rotations"
    assert abs(pairs.gap).max() < 1e-4


def flat(side):
    """Places of a square of a side in the plane of x and y, from parameters between 0 and 1."""
    return lambda x: np.column_stack((side * x[:, :2], np.zeros(len(x))))


def plate_on_plane(friction):
    """A plate that nothing holds but a plane under it and its weight is pulled along, against a weak spring."""
    mesh = fx.read(lambda: fx.meshes.rectangle((2, 2)), dimension=3, order=2, place=flat(100.0))
    plate = fx.Shell(mesh, fx.Plate(5.0), fx.Elastic(2e5, 0.3), form="naghdi-q2")
    plane = fx.RigidPlane((0.0, 0.0, -2.5), (0.0, 0.0, 1.0))
    touch = fx.ObstacleContact(mesh, None, plane, friction=friction)
    weight = fx.Stage([fx.SurfaceForce(plate, (0.0, 0.0, -0.01))], "weight", fx.LoadControl(1.0, fixed=True))
    return fx.Scene([plate], [fx.Support(mesh, "south", "y")], [fx.EdgeForce(mesh, "east", (1.0, 0.0, 0.0))],
                    fx.Monitor(mesh, "north-east", "x"), joints=[touch, fx.Spring(mesh, "south-west", "x", 1e-3)],
                    stages=[weight]), touch


def test_plate_slides_on_a_plane():
    """It sticks up to friction times its weight of 100, then slips; the spring of 1e-3 N/mm takes what is more."""
    scene, touch = plate_on_plane(0.25)
    record = fx.trace(fx.Case(scene, until=fx.Until(deflection=50.0)))
    last = record.states[-1]
    pairs = record.pairs(touch)
    assert last.load == pytest.approx(0.25 * 100.0 + 1e-3 * last.deflection, rel=1e-3)
    assert set(pairs.status) == {"slip"}
    assert (pairs.weight[:, None] * pairs.traction).sum(axis=0) == pytest.approx([25.0, 0.0, 0.0], abs=0.05)
    assert pairs.slip[:, 0] == pytest.approx(last.deflection, rel=1e-2)


def test_way_to_first_touch_is_no_slip():
    """A plane travels aslant by 75 until it touches a beam, and only then sticks to it."""
    mesh, beam = bar(2)
    plate = fx.RigidPlane((0.0, 50.0), (0.0, -1.0), travel=(0.8, -0.6))
    touch = fx.ObstacleContact(mesh, "end", plate, friction=0.5)
    scene = fx.Scene([beam], [fx.clamp(mesh, "start")], [fx.ObstacleForce(plate, 1.0)],
                     fx.Monitor(mesh, "end", "y", -1.0), joints=[touch])
    path = fx.Path(scene, until=fx.Until(steps=1))
    *_, last = path
    pairs, = pairs_of(path.discretisation.system.contributions)
    assert np.linalg.norm(pairs.evaluate().slip) < 10 * last.deflection < 20.0


def test_sphere_on_a_plate():
    """A clamped plate under a small sphere has the stiffness of one under a point force (Timoshenko 1959, table 37)."""
    side, thickness = 100.0, 1.0
    mesh = fx.read(lambda: fx.meshes.rectangle((4, 4)), dimension=3, order=3, place=flat(side / 2))
    plate = fx.Shell(mesh, fx.Plate(thickness), fx.Elastic(2e5, 0.3), form="naghdi-q3")
    ball = fx.RigidSphere(20.0, (0.0, 0.0, 25.0), travel=(0.0, 0.0, -1.0))
    touch = fx.ObstacleContact(mesh, None, ball, samples=4)
    scene = fx.Scene([plate], [fx.symmetry(mesh, "west", "x"), fx.symmetry(mesh, "south", "y"),
                               fx.clamp(mesh, "north"), fx.clamp(mesh, "east")],
                     [fx.ObstacleForce(ball, 0.25)], fx.Monitor(mesh, "south-west", "z", -1.0), joints=[touch],
                     symmetry_factor=4)
    record = fx.trace(fx.Case(scene, until=fx.Until(deflection=0.02)))
    rigidity = 2e5 * thickness**3 / 12 / (1 - 0.3**2)
    assert record.states[-1].load == pytest.approx(0.02 * rigidity / (0.0056 * side**2), rel=0.03)


@pytest.mark.parametrize("friction", [0.0, 1.0])
@pytest.mark.slow(quick=1)
def test_tangent_is_the_derivative(friction):
    """Under a sphere that may travel, far from equilibrium; where something slips it is not symmetric."""
    mesh = fx.read(lambda: fx.meshes.rectangle((2, 2)), dimension=3, order=2, place=flat(1.0))
    plate = fx.Shell(mesh, fx.Plate(0.1), fx.Elastic(1e4, 0.3), form="naghdi-q2")
    ball = fx.RigidSphere(1.0, (0.4, 0.5, 1.1), travel=(0.6, 0.0, -0.8))
    touch = fx.ObstacleContact(mesh, None, ball, friction=friction, stiffness=1e3, tangential=2e2)
    scene = fx.Scene([plate], [fx.Support(mesh, "west", "x y z")], [fx.ObstacleForce(ball, 1.0)], fx.Monitor(ball),
                     joints=[touch])
    discretisation = Discretisation(scene, mixed_points=False)
    x = move_at_random(discretisation, size=0.1)
    work, = pairs_of(discretisation.system.contributions)
    assert set(work.evaluate().status) == ({"open", "slip", "stick"} if friction else {"open", "slip"})
    with discretisation.system.additive_increments():
        assembled, differences = tangents(discretisation.system, x, 1e-5)
    assert distance(assembled, differences) < 1e-7
    assert (distance(assembled.T, differences) > 1e-4) == (friction > 0)


def test_run_killed_as_it_slides_resumes_to_the_same_path(tmp_path):
    whole = fx.trace(pressed_by_circle(0.3))
    kept = []
    for state in whole.states[: len(whole.states) // 2]:
        state.save(tmp_path / "state.npz")
        kept.append(State.load_from(tmp_path / "state.npz"))
    again = pressed_by_circle(0.3)
    for state in fx.Path(again.scene, again.control, again.until, start=kept):
        assert state.load == pytest.approx(whole.states[state.step].load, rel=1e-9)


def test_open_contact_that_holds_nothing_is_named():
    """A beam that only lies on a plane, a tenth above it at the start, falls before it touches."""
    mesh, beam = bar(2)
    touch = fx.ObstacleContact(mesh, None, plane(-0.1 - DEPTH / 2, 2))
    scene = fx.Scene([beam], [fx.Support(mesh, "start", "x")], [fx.PointForce(mesh, "middle", (0.0, -1.0))],
                     fx.Monitor(mesh, "middle", "y", -1.0), joints=[touch])
    with pytest.raises(ValueError, match="move freely.*contact holds nothing where it is open: begin with parts that"):
        fx.Path(scene)


def test_wrong_input_is_named():
    mesh, beam = bar(2)
    inside = fx.ObstacleContact(mesh, None, fx.RigidPlane((0.0, -1.0), (0.0, 1.0)))
    away = fx.RigidCylinder(10.0, (500.0, 50.0), travel=(0.0, 1.0))
    passing = fx.ObstacleContact(mesh, None, away)
    for touch, more, message in ((inside, [], "starts 4 inside the RigidPlane; move one of them"),
                                 (passing, [fx.ObstacleForce(away, 1.0)], "turn its travel, or take more samples")):
        scene = fx.Scene([beam], [fx.clamp(mesh, "start")], [fx.PointForce(mesh, "end", (0.0, -1.0)), *more],
                         fx.Monitor(mesh, "end", "y"), joints=[touch])
        with pytest.raises(ValueError, match=message):
            fx.Path(scene)
    with pytest.raises(ValueError, match="RigidPlane is not one in 2 dimensions"):
        fx.ObstacleContact(mesh, None, fx.RigidPlane((0.0, 0.0, 0.0), (0.0, 0.0, 1.0)))
    with pytest.raises(ValueError, match="two components to each in the plane, three in space"):
        fx.RigidPlane((0.0, 0.0), (0.0, 0.0, 1.0))
    with pytest.raises(ValueError, match="obstacle is 3; it must be an Obstacle"):
        fx.ObstacleContact(mesh, None, 3)


@pytest.mark.silent("f04")
@pytest.mark.parametrize(("touch", "way"), [("layer", (0.0, -1.0)), ("augmented", (0.0, -1.0)),
                                            ("augmented", (0.3, -0.9))])
@pytest.mark.slow(quick=1)
def test_length_of_the_travel_is_nothing(touch, way):
    """It is a direction: clamps carry the force on the punch, whose monitored way is a length."""
    found = []
    for length in (0.5, 3.0):
        mesh, beam = bar(2)
        punch = fx.RigidCylinder(200.0, (500.0, 250.0), travel=tuple(length * c for c in way))
        contacts, joints = ([fx.Contact(beam, punch, distance=0.0)], []) if touch == "layer" else (
            [], [fx.ObstacleContact(mesh, None, punch, distance=0.0, samples=4)])
        scene = fx.Scene([beam], [fx.clamp(mesh, "start"), fx.clamp(mesh, "end")], [fx.ObstacleForce(punch, 60.0)],
                         fx.Monitor(punch), contacts=contacts, joints=joints)
        record = fx.trace(fx.Case(scene, fx.LoadControl(0.5, target=0.5)))
        last = record.states[-1]
        record.show(last)
        carried = sum(record.reactions(end).force[-1] for end in ("start", "end"))
        assert carried @ way / np.linalg.norm(way) == pytest.approx(-last.load, rel=1e-5)
        found.append(last.deflection)
    assert found[1] == pytest.approx(found[0], rel=1e-6)


@pytest.mark.silent("b12")
def test_faces_touch_whatever_the_class():
    """A cantilever on a plane 10 mm below its face: the closed form of a beam that is clamped and supported."""
    length, modulus, depth, gap = 1.0, 2.1e11, 0.02, 0.01
    bending = modulus * depth**4 / 12
    force = 144 * bending * gap / 5 / length**3  # three times what lets the end touch
    reaction = 5 * force / 16 - 3 * bending * gap / length**3
    wanted = force - reaction, 7 * force * length**3 / 768 / bending + 5 * gap / 16
    found = []
    for how in ({"distance": depth / 2}, {"side": -1}, None, {}):
        mesh = fx.read(lambda: fx.meshes.frame({"a": (0, 0), "q": (0.5, 0), "b": (length, 0)},
                                               {"l": ("a", "q", 4), "r": ("q", "b", 4)}), 2, order=2)
        beam = fx.Beam(mesh, fx.Rectangle(depth, depth), fx.Elastic(modulus), shear_rigidity=1e3)
        plane = fx.RigidPlane((0.0, -gap - depth / 2), (0.0, 1.0))
        touch = ({"joints": [fx.ObstacleContact(mesh, "b", plane)]} if how is None else
                 {"contacts": [fx.Contact(beam, plane, **how)]})
        scene = fx.Scene([beam], [fx.clamp(mesh, "a")], [fx.PointForce(mesh, "q", (0.0, -1.0))],
                         fx.Monitor(mesh, "q", "y", -1.0), **touch)
        record = fx.trace(fx.Case(scene, fx.LoadControl(force / 4, target=force)))
        found.append((record.reactions("a").force[-1][1], record.states[-1].deflection))
    assert np.array(found) == pytest.approx(np.tile(wanted, (4, 1)), rel=5e-3)


def test_bifurcations_on_augmented_contact_are_doubted():
    """Once for a path, with what tells: modes are counted with the stiffness of augmentation."""
    mesh, beam = bar(2)

    def doubted(enforcement, touching, kind="bifurcation"):
        touch = fx.ObstacleContact(mesh, None, fx.RigidPlane((0.0, -50.0), (0.0, 1.0)), enforcement=enforcement)
        scene = fx.Scene([beam], [fx.clamp(mesh, "start")], [fx.PointForce(mesh, "end", (0.0, -1.0))],
                         fx.Monitor(mesh, "end", "y"), joints=[touch])
        path = fx.Path(scene)
        points = tuple(CriticalPoint(kind, load, 0.1, 1) for load in (2.0, 3.0))
        return doubts(path.discretisation, [replace(path.tracer.state, critical=points, contact_points=touching)])

    (words,) = doubted("uzawa", 2)
    assert words.startswith("bifurcation at load 2 and 1 more: where something touches by ObstacleContact unstable ")
    assert doubted("uzawa", 0) == doubted("penalty", 2) == doubted("uzawa", 2, "limit") == []


@pytest.mark.slow
def test_a_load_on_what_rests_is_followed_by_the_load():
    """Displacements do not grow any more: a cylindrical arc length says so, and what measures the load too goes on."""
    mesh = fx.read(lambda: fx.meshes.arc(3380.6, -0.128, 0.128, 20, {"crown": 0.0}), dimension=2, order=2)
    arch = fx.Beam(mesh, fx.Rectangle(25.4, 4.7625), fx.Elastic(72395.0))
    floor = fx.RigidPlane((0.0, 3380.6 - 4.7625 / 2 - 8.0), (0.0, 1.0))
    scene = fx.Scene([arch], [fx.clamp(mesh, "start"), fx.clamp(mesh, "end")],
                     [fx.PointForce(mesh, "crown", (0.0, -1.0))], fx.Monitor(mesh, "crown", "y", -1.0),
                     joints=[fx.ObstacleContact(mesh, "crown", floor)])
    with pytest.raises(fx.PathFailure, match=r"rests against something.*ArcLength\(shape='elliptical'\)"):
        list(fx.Path(scene, fx.ArcLength(), fx.Until(load=400.0)))
    last = list(fx.Path(scene, fx.ArcLength(shape="elliptical"), fx.Until(load=400.0)))[-1]
    assert last.load == pytest.approx(400.0) and last.deflection == pytest.approx(8.0, abs=1e-4)
