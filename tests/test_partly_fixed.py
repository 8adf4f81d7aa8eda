"""Rotations of which one or two components are fixed: conditions on the rotation, whatever the steps."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from helpers import displacement, distance, follow, move_at_random, on_two_processes, started, tangents
from scipy.interpolate import CubicSpline
from scipy.spatial.transform import Rotation

import sheetfx as fx
from sheetfx.case import trace
from sheetfx.discrete.discretisation import Discretisation
from sheetfx.discrete.kinematics import kinematics_of
from sheetfx.discrete.partly_fixed import directions_of_edges
from sheetfx.scenes import plate_buckling

TURN = Rotation.from_rotvec([0.3, -0.5, 0.9]).as_matrix()  # its rows are axes of supports


def bent_beam(fixed: str, axes: np.ndarray = TURN) -> fx.Scene:
    """Beam on a joint at its base, with a tip that slides along it, bent about both axes of its section.

    The beam, its supports and its forces are given along axes of its own.
    """
    nodes = {"base": (0, 0, 0), "middle": tuple(axes[0] / 2), "tip": tuple(axes[0])}
    members = {"lower": ("base", "middle", 2), "upper": ("middle", "tip", 2)}
    mesh = fx.read(lambda: fx.meshes.frame(nodes, members), 3)
    beam = fx.Beam(mesh, fx.Rectangle(0.02, 0.01), fx.Elastic(1e9, 0.3), up=tuple(axes[2]))
    supports = [fx.Support(mesh, "base", "x y z", axes), fx.Support(mesh, "base", fixed, axes),
                fx.Support(mesh, "tip", "y z", axes)]
    return fx.Scene([beam], supports, [fx.PointForce(mesh, "middle", tuple(axes.T @ (0.0, 60.0, 30.0))),
                                       fx.PointForce(mesh, "tip", tuple(axes.T @ (-5.0, 0.0, 0.0)))],
                    fx.Monitor(mesh, "tip", "x"))


def bent(fixed: str, steps: int, axes: np.ndarray = TURN) -> tuple[np.ndarray, np.ndarray]:
    """Rotation of the base and displacement of the tip, on the axes of the beam."""
    record = follow(bent_beam(fixed, axes), fx.LoadControl(1 / steps, fixed=True))
    moved, quaternion = displacement(record), record.rotation("base")
    return axes @ Rotation.from_quat(np.roll(quaternion, -1)).as_matrix() @ axes.T, axes @ moved


@pytest.mark.parametrize("steps", [32, pytest.param(256, marks=pytest.mark.slow)])
@pytest.mark.parametrize("fixed", ["rx", "rx ry"])
@pytest.mark.slow(quick=1)
def test_state_does_not_depend_on_the_steps(fixed, steps):
    """The bound is that of the solver; fixed increments turned the base by degrees."""
    few, many = bent(fixed, 8), bent(fixed, steps)
    assert np.degrees(Rotation.from_matrix(few[0]).magnitude()) > 40
    for one, other in zip(few, many, strict=True):
        assert other == pytest.approx(one, abs=1e-8)


@pytest.mark.parametrize("axes", [np.eye(3), TURN], ids=["space", "turned"])
def test_reactions_balance_the_forces(axes):
    """Where they act now, in sum and in moment; the moment at the base is along the axis that turns with it."""
    record = follow(bent_beam("rx", axes), fx.LoadControl(0.125, fixed=True))
    base, tip = (record.reactions(at, about=(0.0, 0.0, 0.0)) for at in ("base", "tip"))
    record.show(record.states[-1])
    forces, turning = base.force[-1] + tip.force[-1], base.moment[-1] + tip.moment[-1]
    for load, place in zip(record.case.scene.loads, (axes[0] / 2, axes[0]), strict=True):
        forces = forces + load.force
        turning = turning + np.cross(place + record.displacement(load.at), load.force)
    assert np.abs(forces).max() < 1e-6 * 67 and np.abs(turning).max() < 1e-6 * 67


def test_rotation_of_a_point_is_about_an_axis_across_the_fixed_one():
    turned = Rotation.from_matrix(bent("rx", 8)[0]).as_rotvec()
    assert abs(turned[0]) < 1e-12 and min(abs(turned[1:])) > 0.3


def test_rotation_with_two_fixed_components_leaves_the_third_axis_as_it_is():
    turned = bent("rx ry", 8)[0]
    assert turned[:, 2] == pytest.approx((0.0, 0.0, 1.0), abs=1e-12)
    assert turned[0, 0] < 0.8


def test_turned_structure_turns_as_the_upright_one():
    """With its supports along axes of their own, and along those of space."""
    for one, other in zip(bent("rx", 8), bent("rx", 8, np.eye(3)), strict=True):
        assert one == pytest.approx(other, abs=1e-8)


def held_plate(axes: np.ndarray | None = None, moment: bool = False) -> fx.Scene:
    """One cell of a shell; two edges do not turn about their normals, nor move across the plate."""
    turn = np.eye(3) if axes is None else axes
    mesh = fx.read(lambda: fx.meshes.rectangle((1, 1)), 3, 1, lambda x: x @ turn)
    shell = fx.Shell(mesh, fx.Plate(0.1), fx.Elastic(1e4, 0.3), form="naghdi-q2")
    supports = [fx.Support(mesh, "west", "z rx", axes), fx.Support(mesh, "north", "z ry", axes)]
    loads = [fx.SurfaceForce(shell, (0.0, 0.0, 1.0))]
    moments = [fx.Moment(mesh, "west", (3.0, 7.0, 5.0)), fx.Moment(mesh, "south-west", (2.0, 1.0, 4.0))]
    return fx.Scene([shell], supports, [*loads, *moments * moment], fx.Monitor(mesh, "north-east", "x"))


@pytest.mark.parametrize("axes", [None, TURN], ids=["along space", "along axes of their own"])
@pytest.mark.parametrize("moment", [False, True])
def test_tangent_is_the_derivative_of_the_residual(moment, axes):
    """After steps by which the edge has turned far, and with moments on it; the bound is that of the differences.

    Without moments the residual is the gradient of an energy if all increments add.
    """
    discretisation = Discretisation(held_plate(axes, moment), mixed_points=False)
    system, field = discretisation.system, discretisation.unknowns.fields[1]
    for seed in (1, 2):
        move_at_random(discretisation, seed, 0.3)
        system.history.commit()
    x = move_at_random(discretisation, 3, 0.3)
    nodes = np.flatnonzero(field.charted)
    turns = Rotation.from_quat(np.roll(field.table[nodes], -1, axis=1)).as_matrix()
    x_axis, y_axis, across = np.eye(3) if axes is None else axes
    north = np.isclose(field.value.function_space.tabulate_dof_coordinates()[nodes] @ y_axis, 1.0)
    start = np.where(north[:, None], x_axis, y_axis)
    edge = np.einsum("nij,nj->ni", turns, start)
    assert list(np.sort(north)) == [False, False, True, True], "the corner has two fixed components"
    assert np.linalg.norm(edge - start, axis=1).max() > 0.1
    assert np.abs(edge @ across).max() < 1e-14, "edges stay in their plane"
    if moment:
        assert distance(*tangents(system, x, 1e-3)) < 1e-10
    with system.additive_increments():
        assembled, differences = tangents(system, x, 1e-3)
    assert distance(assembled, differences) < 1e-10
    assert moment or distance(assembled.T, assembled) < 1e-14


@pytest.mark.parametrize(("form", "order", "geometry"), [("naghdi-q3", 3, 1e-4), ("naghdi-t2", 2, 3e-3)])
def test_directions_of_a_circular_edge(form, order, geometry):
    """The error of the geometry: 2e-5 of a quarter of a circle by two cubics, 3e-3 by two parabolas."""
    def place(x):
        angle = np.pi / 2 * x[:, 0]
        return np.column_stack((np.cos(angle), np.sin(angle), x[:, 1]))

    mesh = fx.read(lambda: fx.meshes.rectangle((2, 1), triangles=form == "naghdi-t2"), 3, order, place)
    space = kinematics_of(mesh, *fx.Shell(mesh, fx.Plate(0.1), fx.Elastic(1.0), form=form).spaces).block.fields[1]
    space = space.value.function_space
    sums, (x, y, z) = directions_of_edges(mesh, ["south"], space), space.tabulate_dof_coordinates().T
    there = np.isclose(z, 0.0)
    tangents = np.column_stack((-y, x, 0 * x))[there] / np.hypot(x, y)[there, None]
    assert np.all(sums[~there] == 0)
    shares = np.trace(sums[there], axis1=1, axis2=2)
    assert np.einsum("ni,nij,nj->n", tangents, sums[there], tangents) == pytest.approx(
        shares, abs=geometry)
    assert sorted({*shares.round(6)}) == [1.0, 2.0]


def sheared_and_bent_plate() -> np.ndarray:
    """Displacement of a corner of a plate between two edges that do not turn about their normals."""
    mesh = fx.read(lambda: fx.meshes.rectangle((2, 2)), 3)
    shell = fx.Shell(mesh, fx.Plate(0.1), fx.Elastic(1e4, 0.3), form="naghdi-q2")
    supports = [fx.Support(mesh, "west", "z rx"), fx.Support(mesh, "south-west", "x y"),
                fx.Support(mesh, "east", "z rx"), fx.Support(mesh, "south-east", "y")]
    loads = [fx.PointForce(mesh, "north-east", (4.0, 15.0, 0.0)), fx.SurfaceForce(shell, (0.0, 0.0, 60.0))]
    return displacement(follow(fx.Scene([shell], supports, loads, fx.Monitor(mesh, "north-east", "x")),
                               fx.LoadControl(0.5)), "north-east")


@pytest.mark.slow
def test_edges_on_two_processes():
    lines = on_two_processes("from test_partly_fixed import sheared_and_bent_plate\nprint(*sheared_and_bent_plate())")
    alone = sheared_and_bent_plate()
    assert np.linalg.norm(alone) > 0.05
    assert [float(c) for c in lines[0].split()] == pytest.approx(list(alone), rel=1e-8, abs=1e-12)


def plate_and_branch(edges: str = "z rx") -> tuple[fx.Case, fx.CriticalPoint, fx.State]:
    """Square plate on four simply supported edges, its first bifurcation, and a state behind it."""
    case = plate_buckling.case(cells=3, slenderness=100.0)
    supports = [replace(s, fixed="z") if edges == "z" and s.fixed.startswith("z r") else s for s in case.scene.supports]
    case = replace(case, scene=replace(case.scene, supports=supports))
    record = trace(replace(case, control=fx.LoadControl(step=2.6, target=5.2), until=fx.Until()))
    point, found = started(record, 0.004)
    return case, point, found[0].start


def follow_deflection(case: fx.Case, start: fx.State, control, done) -> tuple[list[fx.State], np.ndarray]:
    """States of a path until the deflection of the plate's middle satisfies `done`, and this deflection there."""
    path = fx.Path(case.scene, control, start=[start])
    u = path.discretisation.kinematics(case.scene.parts[0].mesh).u
    far = np.linalg.norm(u.function_space.tabulate_dof_coordinates() - (500.0, 500.0, 0.0), axis=1)
    states, deflections = [], []
    for state in path:
        states.append(state)
        nearest = path.discretisation.system.comm.allgather((far.min(), u.x.array[3 * far.argmin() + 2]))
        deflections.append(min(nearest)[1])
        if done(deflections[-1]):
            return states, np.array(deflections)
    raise AssertionError(path.message)


def plate_led_back(times: float = 1.0) -> tuple[fx.CriticalPoint, list[fx.State], list[fx.CriticalPoint]]:
    """First bifurcation of the flat plate, and states and bifurcations from one side of its branch to the other."""
    case, point, start = plate_and_branch()
    states, out = follow_deflection(case, start, fx.ArcLength(0.02), lambda w: abs(w) > 20)
    back = replace(states[-1], load_rate=-states[-1].load_rate, next_length=times * 0.02)
    states, _ = follow_deflection(case, back, fx.ArcLength(times * 0.02), lambda w: w * out[-1] < 0 and abs(w) > 20)
    return point, states, [p for s in states for p in s.critical if p.kind == "bifurcation"]


@pytest.mark.slow
@pytest.mark.parametrize("times", [1 / 16, 1 / 4, 1.0, 4.0, 16.0])
def test_plate_passes_its_flat_state_by_a_pitchfork(times):
    """Back along its branch to the mirror image; the bifurcation is that of the flat plate.

    It is located to 1e-5, and from a curved path less well than on the flat one.
    """
    point, states, found = plate_led_back(times)
    assert [p.load for p in found] == [pytest.approx(point.load, rel=1e-5)]
    assert all(s.unstable_modes == 0 for s in states)


@pytest.mark.slow
def test_plate_passes_its_flat_state_on_two_processes():
    """The same bifurcation, and the same end beyond it; rounding over the plate's softness moves the return by 2e-8."""
    lines = on_two_processes("""
from test_partly_fixed import plate_led_back
point, states, found = plate_led_back()
print(len(found), len(states), *(f"{value:.12g}" for value in (point.load, states[-1].load, found[0].load)))""")
    point, states, found = plate_led_back()
    *both, returned = (float(word) for word in lines[0].split())
    assert both == pytest.approx([len(found), len(states), point.load, states[-1].load], rel=1e-8)
    assert returned == pytest.approx(found[0].load, rel=5e-8)


@pytest.mark.slow
def test_edges_that_do_not_turn_about_their_normal_are_no_stiffer_than_free_ones():
    """A thin plate's director stays across the edge by itself, while this turns in its plane as it is drawn inwards.

    At eight thicknesses, where the edge has turned by degrees; the bound is the share of the shear in a boundary layer
    of the width of the thickness. Rotations about axes across the fixed one would be 1.9 % stiffer.
    """
    loads = []
    for edges in ("z rx", "z"):
        case, point, start = plate_and_branch(edges)
        states, deflections = follow_deflection(case, start, fx.ArcLength(0.02), lambda w: abs(w) > 80)
        loads.append(CubicSpline(np.abs(deflections), [s.load / point.load for s in states])(80.0))
    assert loads[0] == pytest.approx(loads[1], rel=2e-3)


def tilting_beam(rigidity: float) -> fx.Scene:
    """Narrow beam between forks, which hold the twist at its ends, under a force in the middle: it tilts sideways."""
    nodes = {"a": (0, 0, 0), "middle": (500, 0, 0), "b": (1000, 0, 0)}
    mesh = fx.read(lambda: fx.meshes.frame(nodes, {"left": ("a", "middle", 6), "right": ("middle", "b", 6)}), 3)
    beam = fx.Beam(mesh, fx.Rectangle(2.0, 40.0), fx.Elastic(2e5), shear_rigidity=rigidity)
    return fx.Scene([beam], [fx.Support(mesh, "a", "x y z rx"), fx.Support(mesh, "b", "y z rx")],
                    [fx.PointForce(mesh, "middle", (0.0, 0.0, -1.0))], fx.Monitor(mesh, "middle", "z", -1.0))


@pytest.mark.parametrize("step", [13.0, 33.0, pytest.param(3.0, marks=pytest.mark.slow)])
def test_modes_are_those_on_the_axes_of_their_state(step):
    """Koiter's b of a slender beam depends neither on the steps nor on how rigid it is in shear.

    Axes at the forks turn from one state to the next. A mode on those of the state before shears the elements there,
    which made b 25 to 60 % smaller where shear is rigid, and another one with every step. 1e-3: what shear changes.
    """
    until = fx.Until(load=200.0)
    softer = trace(fx.Case(tilting_beam(1.0), fx.LoadControl(30.0, target=200.0), until)).critical_points[0]
    rigid = trace(fx.Case(tilting_beam(1e3), fx.LoadControl(step, target=200.0), until)).critical_points[0]
    assert softer.name == rigid.name == "stable symmetric"
    assert rigid.load == pytest.approx(softer.load, rel=1e-4)
    assert rigid.curvature == pytest.approx(softer.curvature, rel=1e-3)
