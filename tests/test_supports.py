"""Supports along axes of their own."""

from __future__ import annotations

from math import pi, radians

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import sheetfx as fx
from sheetfx.case import Case, trace
from sheetfx.continuation.control import LoadControl

RADIUS = 10.0


def pinched_hemisphere(turn: np.ndarray, pressure: float) -> tuple[np.ndarray, list[int]]:
    """Displacement of the loaded corner in the frame of the structure, which stands in space turned by `turn`."""
    def place(x):
        azimuth, height = pi / 2 * x[:, 0], radians(72.0) * x[:, 1]
        places = np.column_stack((np.cos(height) * np.cos(azimuth), np.cos(height) * np.sin(azimuth), np.sin(height)))
        return RADIUS * places @ turn.T

    mesh = fx.read(lambda: fx.meshes.rectangle((2, 2), points={"A": (0, 0)}), 3, 2, place)
    shell = fx.Shell(mesh, fx.Plate(0.4), fx.Elastic(6.825e7, 0.3), form="naghdi-q2")
    axes = None if np.array_equal(turn, np.eye(3)) else turn.T
    supports = [fx.Support(mesh, "west", "y rx rz", axes), fx.Support(mesh, "east", "x ry rz", axes),
                fx.Support(mesh, "A", "z", axes)]
    loads = [fx.PointForce(mesh, "A", tuple(4e4 * turn[:, 0])), fx.Pressure(shell, pressure)]
    record = trace(Case(fx.Scene([shell], supports, loads, fx.Monitor(mesh, "A", "x")), LoadControl(0.5, fixed=True)))
    record.show(record.states[-1])
    return turn.T @ record.displacement("A"), [
        s.iterations for s in record.states]


@pytest.mark.parametrize("pressure", [0.0, 100.0])
def test_turned_structure_moves_as_the_upright_one(pressure):
    """With loads of fixed direction, and with pressure, whose tangent is assembled along space and turned."""
    upright, iterations = pinched_hemisphere(np.eye(3), pressure)
    turned, again = pinched_hemisphere(Rotation.from_rotvec([0.3, -0.5, 0.9]).as_matrix(), pressure)
    assert np.linalg.norm(upright) > 0.05 * RADIUS
    assert turned == pytest.approx(upright, rel=1e-7, abs=1e-9)
    assert iterations == again


def test_symmetry_about_any_plane():
    """A plate cut along its diagonal bends as the whole does."""
    def deflection(build, supports):
        mesh = fx.read(build, 3)
        shell = fx.Shell(mesh, fx.Plate(0.1), fx.Elastic(1e4), form="naghdi-q2")
        scene = fx.Scene([shell], supports(mesh), [fx.SurfaceForce(shell, (0.0, 0.0, 1.0))],
                         fx.Monitor(mesh, "c", "z"))
        return trace(Case(scene, LoadControl(1.0))).states[-1].deflection

    nodes = {"a": (0, 0, 0), "b": (1, 0, 0), "c": (1, 1, 0), "d": (0, 1, 0)}
    whole = deflection(lambda: fx.meshes.panels(nodes, {"plate": "abcd"}, 8),
                       lambda m: [fx.clamp(m, "a-b"), fx.clamp(m, "d-a")])
    half = deflection(lambda: fx.meshes.panels(nodes, {"plate": "abc"}, 8),
                      lambda m: [fx.clamp(m, "a-b"), fx.symmetry(m, "c-a", (1.0, -1.0, 0.0))])
    assert half == pytest.approx(whole, rel=5e-3), "other mesh, same plate: both are within 0.5 % of convergence"


def test_bad_axes_are_named():
    mesh = fx.read(lambda: fx.meshes.rectangle((1, 1)), 3)
    skew = fx.Support(mesh, "west", "x", ((1.0, 0.0, 0.0), (1.0, 1.0, 0.0), (0.0, 0.0, 1.0)))
    shell = fx.Shell(mesh, fx.Plate(0.1), fx.Elastic(1e4), form="naghdi-q2")
    scene = fx.Scene([shell], [skew], [fx.SurfaceForce(shell, (0.0, 0.0, 1.0))], fx.Monitor(mesh, "north-east", "z"))
    with pytest.raises(ValueError, match="west.*orthonormal"):
        fx.Path(scene)


def test_motion_of_an_edge_moves_all_of_it():
    """A plate that is shortened uniformly and held sideways: force E / (1 - nu^2) times strain, but for its square."""
    mesh = fx.read(lambda: fx.meshes.rectangle((3, 2)), 3, 2)
    shell = fx.Shell(mesh, fx.Plate(0.01), fx.Elastic(1e4, 0.3), form="naghdi-q2")
    supports = [fx.Support(mesh, "west", "x y z rx ry rz"), fx.Support(mesh, "north", "y"),
                fx.Support(mesh, "south", "y"), fx.Support(mesh, "east", "y z rx ry rz")]
    scene = fx.Scene([shell], supports, [fx.PrescribedDisplacement(mesh, "east", "x", 1e-4)],
                     fx.Monitor(mesh, "south-east", "x"))
    path = fx.Path(scene, LoadControl(1.0))
    *_, state = path
    assert state.load == pytest.approx(1e4 / 0.91 * 0.01 * 1e-4, rel=2e-4)
    assert state.unstable_modes == 0
    x = path.discretisation.kinematics(mesh).u
    places = x.function_space.tabulate_dof_coordinates()
    edge = x.x.array.reshape(-1, 3)[places[:, 0] > 1 - 1e-9]
    assert edge[:, 0] == pytest.approx(1e-4, rel=1e-9)


@pytest.mark.parametrize("slant", [0.0, 1e-3, 0.6, 1.2])
@pytest.mark.slow(quick=1)
def test_a_corner_of_two_supports_has_what_both_hold(slant):
    """As with the corner held besides in all directions of the plane; the reactions are in balance with the load."""
    mesh = fx.read(lambda: fx.meshes.rectangle((2, 2)), 3)
    shell = fx.Shell(mesh, fx.Plate(0.1), fx.Elastic(1e4, 0.3), form="naghdi-q2")
    across = Rotation.from_rotvec((0, 0, slant)).as_matrix().T
    edges = [fx.Support(mesh, "south", "y z ry"), fx.Support(mesh, "west", "x z rx", across)]
    load, monitor = fx.EdgeForce(mesh, "east", (30.0, 20.0, 5.0)), fx.Monitor(mesh, "north-east", "z")

    def moved(*more, turn=1):
        record = trace(Case(fx.Scene([shell], [*edges[::turn], *more], [load], monitor), LoadControl(1.0, fixed=True)))
        forces = sum(record.reactions(at).force[-1] for at in ("south", "west"))
        assert more or forces == pytest.approx((-30.0, -20.0, -5.0), rel=1e-6)
        record.show(record.states[-1])
        return [*record.displacement("north-east"), *record.displacement("south-west")]

    alone, besides = moved(), moved(fx.Support(mesh, "south-west", "x y rx ry"))
    assert abs(alone[2]) > 0.01
    assert alone == pytest.approx(besides, rel=1e-8, abs=1e-10) == moved(turn=-1)
    assert alone[3:] == pytest.approx([0, 0, 0], abs=1e-12)


@pytest.mark.parametrize("turn", [(0, 0, 0.5), (0.3, 0.2, 0.5)])
@pytest.mark.slow(quick=1)
def test_a_motion_leaves_nodes_that_supports_hold_on_axes_of_their_own(turn):
    """As it does nodes that are held along the axes of space; prescribed as well, they made the tangent singular."""
    mesh = fx.read(lambda: fx.meshes.rectangle((2, 2)), 3)
    shell = fx.Shell(mesh, fx.Plate(0.05), fx.Elastic(1e4, 0.3))
    loads = []
    for axes in (None, Rotation.from_rotvec(turn).as_matrix()):
        supports = [fx.Support(mesh, "south", "x y z", axes), fx.clamp(mesh, "west")]
        scene = fx.Scene([shell], supports, [fx.PrescribedDisplacement(mesh, "east", "x", 1e-3)],
                         fx.Monitor(mesh, "north-east", "x"))
        loads.append(trace(Case(scene, LoadControl(1.0, fixed=True))).states[-1].load)
    assert loads[0] == pytest.approx(loads[1], rel=1e-9)


@pytest.mark.slow
def test_planes_of_symmetry_that_meet_at_a_corner():
    """A patch of a compressed cylinder between four planes, one along no axis of space: it stays a cylinder."""
    angle, radius = 0.35, 1.0

    def place(x):
        return np.column_stack((0.3 * x[:, 0], radius * np.sin(angle * x[:, 1]), radius * np.cos(angle * x[:, 1])))

    mesh = fx.read(lambda: fx.meshes.rectangle((2, 2)), 3, 3, place)
    shell = fx.Shell(mesh, fx.Plate(0.01), fx.Elastic(1e4, 0.3), form="naghdi-q3")
    planes = [fx.symmetry(mesh, "west", "x"), fx.symmetry(mesh, "south", "y"),
              fx.symmetry(mesh, "north", (0.0, np.cos(angle), -np.sin(angle))), fx.Support(mesh, "east", "ry rz")]
    scene = fx.Scene([shell], planes, [fx.PrescribedDisplacement(mesh, "east", "x", -1e-4)],
                     fx.Monitor(mesh, "south-east", "x"))
    path = fx.Path(scene, LoadControl(1.0))
    *_, _ = path
    u = path.discretisation.kinematics(mesh).u
    places, moved = u.function_space.tabulate_dof_coordinates(), u.x.array.reshape(-1, 3)
    radial = np.hypot(*(places + moved)[:, 1:].T) - np.hypot(*places[:, 1:].T)
    assert radial.mean() == pytest.approx(0.3 * 1e-4 / 0.3, rel=0.01)
    assert np.ptp(radial) < 1e-4 * radial.mean()


def test_hard_simple_support_of_a_skew_plate():
    """Morley's plate of 30 degrees: 0.417 q a^4 / 1000 D in the middle (0.424 with soft supports).

    Both edges hold the director at the corners, as it must be: it is continuous. Slopes go as r^0.2 at the corner of
    150 degrees, so that 8 cells that become smaller towards it are 4 % stiff, and as many equal ones 14 %.
    """
    sine, cosine = np.sin(pi / 6), np.cos(pi / 6)

    def place(x):
        s, t = (x[:, i]**3 / (x[:, i]**3 + (1 - x[:, i])**3) for i in (0, 1))
        return np.column_stack((s + t * cosine, t * sine, 0 * t))

    mesh = fx.read(lambda: fx.meshes.rectangle((8, 8)), 3, 3, place)
    shell = fx.Shell(mesh, fx.Plate(0.01), fx.Elastic(1e6, 0.3), form="naghdi-q3")
    slanted = ((sine, -cosine, 0.0), (cosine, sine, 0.0), (0.0, 0.0, 1.0))
    edges = [*(fx.Support(mesh, e, "z ry") for e in ("south", "north")),
             *(fx.Support(mesh, e, "z rx", slanted) for e in ("west", "east"))]
    supports = [*edges, fx.Support(mesh, "south-west", "x y"), fx.Support(mesh, "south-east", "y")]
    unit = 1e-3 * 1e6 * 0.01**3 / 12 / 0.91
    scene = fx.Scene([shell], supports, [fx.SurfaceForce(shell, (0.0, 0.0, unit))], fx.Monitor(mesh, "north-east", "x"))
    record = trace(Case(scene, LoadControl(1.0, fixed=True)))
    record.show(record.states[-1])
    u = record.path.discretisation.kinematics(mesh).u
    off = u.function_space.tabulate_dof_coordinates() - ((1 + cosine) / 2, sine / 2, 0)
    assert 0.39 < 1e6 * u.x.array[3 * np.linalg.norm(off, axis=1).argmin() + 2] < 0.417
