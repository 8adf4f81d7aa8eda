"""Beams: published figures, order of convergence, tangent, and what a user may exchange."""

from __future__ import annotations

from math import pi, radians, sqrt

import numpy as np
import pytest
import ufl
from helpers import (
    cantilever,
    displacement,
    distance,
    elastica_under_line_force,
    energy_and_residual,
    follow,
    move_at_random,
    rod_bend,
    shallow_arch,
    straight,
    tangents,
    turn_rigidly,
)

from sheetfx.case import trace
from sheetfx.continuation.control import ArcLength, DisplacementControl, LoadControl
from sheetfx.discrete.discretisation import Discretisation
from sheetfx.model.beam import Beam
from sheetfx.model.contact import Contact
from sheetfx.model.loads import LineForce, Moment, ObstacleForce, PointForce, PrescribedDisplacement
from sheetfx.model.obstacles import RigidCylinder
from sheetfx.model.scene import Monitor, Scene
from sheetfx.model.section import Elastic, Rectangle
from sheetfx.model.supports import clamp
from sheetfx.path import Path
from sheetfx.scenes import bend, deep_arch, lee_frame, roll_up

BENDING = 0.1**4 / 12 * 1.2e5


def test_deep_arch_buckles_at_the_classical_load():
    case = deep_arch.case()
    values = case.quantities(trace(case))
    assert values["load_factor"] == pytest.approx(8.9728, rel=5e-4), "DaDeppo and Schmidt 1975"


def test_deep_arch_path_goes_through_the_limit_point():
    record = trace(deep_arch.case())
    kinds = [p.kind for p in record.critical_points]
    assert kinds[:1] == ["limit"]
    assert record.states[-1].deflection >= 125.0
    assert max(s.load for s in record.states) <= record.critical_points[0].load * (1 + 1e-9)


def test_lee_frame_limits_and_snap_back():
    case = lee_frame.case()
    record = trace(case)
    values = case.quantities(record)
    assert values["limit_load"] == pytest.approx(18556.7, rel=1e-3)
    assert values["lower_limit_load"] == pytest.approx(-9414.4, rel=1e-3)
    deflections = [s.deflection for s in record.states]
    assert min(np.diff(deflections)) < -1.0, "no snap-back"
    assert deflections[-1] >= 95.0
    assert len(record.critical_points) == 2


@pytest.mark.parametrize("degree", [1, 2])
def test_cantilever_rolls_up_to_circles_in_the_plane(degree):
    """Closed polygons are exact after full turns, to Newton's tolerance of 1e-8."""
    case = roll_up.case(turns=2, degree=degree)
    record = trace(case)
    assert case.quantities(record)["tip_angle"] == pytest.approx(4 * pi, rel=1e-8)
    states = record.states
    for turn in (1, 2):
        record.states = states[: 10 * turn + 1]
        assert record.states[-1].factor == pytest.approx(turn / 2)
        assert case.quantities(record)["tip_error"] < 1e-8


def test_cantilever_rolls_up_to_circles_in_space():
    """The error of the fourth order comes from the interpolated quaternions, 30 degrees on an element of 24."""
    errors = []
    for elements in (24, 48):
        case = roll_up.case(turns=2, elements=elements, spatial=True)
        errors.append(case.quantities(trace(case))["tip_error"])
    assert errors[0] < 1e-4
    assert np.log2(errors[0] / errors[1]) == pytest.approx(4.0, abs=0.2)


def test_bend_reaches_the_published_tip():
    """Tolerance: the digits of the published values."""
    case = bend.case()
    values = case.quantities(trace(case))
    tip = [values[f"tip_{c}"] for c in "xyz"]
    assert tip == pytest.approx((15.558, 46.892, 53.61), abs=5e-3)
    assert values["most_iterations"] <= 5


@pytest.mark.slow
def test_bend_agrees_with_the_rod_equations():
    """Tolerance: 32 elements are within 3e-8 of 64."""
    case = bend.case()
    record = trace(case)
    values = case.quantities(record)
    beam = case.scene.parts[0]
    tip = rod_bend(100.0, pi / 4, 600.0, beam.section.stiffness(beam.material, 3))
    assert [values[f"tip_{c}"] for c in "xyz"] == pytest.approx(tip, rel=1e-6)


@pytest.mark.slow
def test_mixed_points_save_iterations_and_leave_the_solution():
    results = [bend.case(plain_tangent=plain) for plain in (False, True)]
    mixed, plain = (case.quantities(trace(case)) for case in results)
    assert mixed["tip_x"] == pytest.approx(plain["tip_x"], rel=1e-7)
    assert mixed["iterations"] < 0.7 * plain["iterations"]


def first_limit(elements, degree):
    record = follow(shallow_arch(elements, degree), ArcLength(), deflection=12.0)
    return next(p.load for p in record.critical_points if p.kind == "limit")


@pytest.mark.parametrize(("degree", "order", "cells", "tolerance"), [
    (3, 6, (3, 6, 12), 0.15), (2, 4, (5, 10, 20), 0.1), (1, 2, (5, 10, 20), 0.25)])
@pytest.mark.slow(quick=1)
def test_limit_load_converges_with_the_theoretical_order(degree, order, cells, tolerance):
    """Reduced integration: order 2 p for elements of degree p (Arnold 1981, for the linear beam).

    The tolerance allows for terms of higher order on the coarse meshes.
    """
    best = first_limit(160, 2)
    errors = [abs(first_limit(n, degree) - best) for n in cells]
    orders = np.log2(np.divide(errors[:-1], errors[1:]))
    assert orders == pytest.approx([order, order], abs=tolerance)


@pytest.mark.parametrize("degree", [1, 2])
def test_slender_cantilevers_do_not_lock(degree):
    """Same dimensionless tip deflection with slenderness 1e2 and 1e5.

    Tolerance: at 1e2 shear and extension matter by (depth / length)^2 = 1e-4. At 1e5 roundoff keeps
    the residual above 1e-5 of the load, which the iteration has to notice.
    """
    tips = []
    for depth in (1e-2, 1e-5):
        section, material = Rectangle(1.0, depth), Elastic(1.0, 0.0)
        force = 2 * section.stiffness(material, 2)[2]
        scene = cantilever(straight(40 // degree**2), lambda b, f=force: [PointForce(b.mesh, "tip", (0.0, f))],
                           section=section, material=material, degree=degree)
        *_, last = Path(scene, LoadControl(step=0.25, fixed=True))
        tips.append(last.deflection)
    assert tips[1] == pytest.approx(tips[0], rel=2e-4)
    assert tips[1] == pytest.approx(0.49346, rel=1e-3), "Mattiasson (1981), table 1: P L^2 / EI = 2"


def contact_scene(points, enforcement, layer, friction):
    mesh = straight(4)
    beam = Beam(mesh, Rectangle(0.1, 0.1), Elastic(1.2e5, 0.3))
    punch = RigidCylinder(0.5, (0.6, 0.5), travel=(0.0, -1.0))
    contact = Contact(beam, punch, points, friction, distance=0.0, enforcement=enforcement, layer=layer)
    return Scene([beam], [clamp(mesh, "base")], [ObstacleForce(punch, 1.0)], Monitor(mesh, "tip", "y"),
                 contacts=[contact])


def beam_scene(dimension):
    mesh = straight(3, dimension=dimension)

    def loads(beam):
        force = (1.0, 2.0, 3.0)[:dimension]
        moment = 2.0 if dimension == 2 else (1.0, 2.0, 3.0)
        return [PointForce(mesh, "tip", force), Moment(mesh, "tip", moment),
                LineForce(beam, force, follower=dimension == 2)]

    return cantilever(mesh, loads, section=Rectangle(0.2, 0.1), up=(0.0, 1.0, 0.0))


SCENES = {
    "planar": lambda: beam_scene(2),
    "frictionless layer": lambda: contact_scene("quadrature", "penalty", 0.1, 0.0),
    "semismooth layer": lambda: contact_scene("quadrature", "semismooth", 0.1, 0.0),
    "semismooth friction": lambda: contact_scene("nodes", "semismooth", None, 0.3),
}


@pytest.mark.parametrize("mixed_points", [True, False])
@pytest.mark.parametrize("name", SCENES)
@pytest.mark.slow(quick=1)
def test_tangent_is_the_derivative_of_the_residual(name, mixed_points):
    """Where the mixed stress is the current stress; the bound is the error of central differences."""
    discretisation = Discretisation(SCENES[name](), mixed_points)
    x = move_until_partly_touching(discretisation) if discretisation.contacts else move_at_random(discretisation)
    assembled, differences = tangents(discretisation.system, x)
    assert distance(assembled, differences) < 1e-7


def move_until_partly_touching(discretisation):
    for seed in range(20):
        x = move_at_random(discretisation, seed)
        status = discretisation.contacts[0].evaluate().status
        if 0 < (status != "open").sum() < len(status):
            return x
    pytest.fail("no configuration in which some points touch and some do not")


def rotate_all_alike(discretisation, x):
    """Give all nodes the same rotation; displacements stay."""
    field = discretisation.unknowns.fields[1]
    x.array[field.dofs] = np.tile([0.3, -0.2, 0.4], len(field.dofs) // 3)
    discretisation.system.configure(x, discretisation.system.factor)
    discretisation.system.extrapolate_stress()


@pytest.mark.parametrize("mixed_points", [True, False])
def test_spatial_tangent_with_equal_rotations(mixed_points):
    """The assembled tangent is the symmetric part of the residual's derivative, which is not symmetric.

    The rest is proportional to the moments of the residual: a rotation a followed by b is
    a + b + b x a / 2 to the second order.
    """
    mesh = straight(3, dimension=3)
    scene = cantilever(mesh, lambda b: [PointForce(mesh, "tip", (1.0, 2.0, 3.0))], section=Rectangle(0.2, 0.1),
                       up=(0.0, 1.0, 0.0))
    discretisation = Discretisation(scene, mixed_points)
    system, x = discretisation.system, move_at_random(discretisation)
    rotate_all_alike(discretisation, x)
    assembled, differences = tangents(system, x)
    assert distance(assembled + assembled.T, differences + differences.T) < 1e-6
    assert distance(assembled, differences) > 1e-4


@pytest.mark.parametrize("mixed_points", [True, False])
def test_spatial_tangent_is_the_symmetric_derivative_of_the_residual(mixed_points):
    discretisation = Discretisation(beam_scene(3), mixed_points)
    x = move_at_random(discretisation)
    assembled, differences = tangents(discretisation.system, x)
    assert distance(assembled + assembled.T, differences + differences.T) < 1e-7


def test_spatial_tangent_at_equilibrium_is_the_derivative_of_the_residual():
    scene = cantilever(straight(3, dimension=3), lambda b: [PointForce(b.mesh, "tip", (1.0, 5.0, 20.0))],
                       section=Rectangle(0.2, 0.1), up=(0.0, 1.0, 0.0), component="z")
    record = follow(scene)
    system = record.path.discretisation.system
    x = system.create_vector()
    system.configure(x, system.factor)
    system.extrapolate_stress()
    assert distance(*tangents(system, x)) < 1e-7
    assert record.states[-1].deflection > 0.5


def small_strain(u, rotation, frame):
    """Linear theory (Timoshenko 1921): no coupling of displacement and rotation."""
    rate = frame.along(u)
    shear = ufl.dot(rate, frame.normal) - rotation.angle
    return ufl.as_vector([ufl.dot(rate, frame.tangent), shear, frame.along(rotation.angle)])


def test_strain_measure_of_the_user():
    """With linear strains the tip moves by P L^3 / 3 EI + P L / k GA under any load."""
    force = 30.0
    scene = cantilever(straight(4), lambda b: [PointForce(b.mesh, "tip", (0.0, force))], strains=small_strain)
    states = follow(scene).states
    exact = force / 3 / BENDING + force / (5 / 6 * 0.6e5 * 0.01)
    assert states[-1].deflection == pytest.approx(exact, rel=1e-9)
    assert exact > 5.0, "far beyond what finite strains would allow"


def test_section_law_of_the_user():
    """A law M = EI k / sqrt(1 + (k / limit)^2) bends to k = (M / EI) / sqrt(1 - (M / EI limit)^2)."""
    limit, part = 3.0, 0.9

    def softening(strains, stiffness):
        n, q, m = (stiffness[i] * strains[i] for i in range(3))
        return ufl.as_vector([n, q, m / ufl.sqrt(1 + (strains[2] / limit) ** 2)])

    moment = part * BENDING * limit
    scene = cantilever(straight(4), lambda b: [Moment(b.mesh, "tip", moment)], law=softening)
    record = follow(scene)
    displacement(record)
    angle = record.rotation("tip")
    assert angle == pytest.approx(part * limit / sqrt(1 - part**2), rel=1e-9)


@pytest.mark.parametrize("size", [0.0, 0.1])
def test_rigid_rotation_beyond_a_turn_changes_nothing(size):
    """Energy and residual norm are those before, to roundoff of the stiffness 1e5 over the cell length."""
    mesh = straight(4, dimension=3)
    scene = cantilever(mesh, lambda b: [PointForce(mesh, "tip", (0.0, 0.0, 1.0))], section=Rectangle(0.2, 0.1),
                       up=(0.0, 1.0, 0.0))
    discretisation = Discretisation(scene)
    discretisation.system.fixed_rows = np.empty(0, dtype=np.int32)
    move_at_random(discretisation, size=size)
    discretisation.system.factors.set(0.0)
    discretisation.system.history.commit()
    before = energy_and_residual(discretisation)
    assert before[0] > 1.0 or size == 0.0
    turn_rigidly(discretisation, radians(800.0), (1.0, 2.0, 3.0), steps=7)
    assert np.abs(discretisation.kinematics(mesh).displacement(mesh, "tip")).max() > 0.1
    assert energy_and_residual(discretisation) == pytest.approx(before, rel=1e-10, abs=1e-8)


@pytest.mark.parametrize("follower", [True, False])
def test_line_force_dead_and_follower(follower):
    """Against the elastica; tolerance: extension and shear matter by (depth / length)^2 = 1e-4."""
    section, material = Rectangle(1.0, 1e-2), Elastic(1.2e7, 0.0)
    force = 10 * section.stiffness(material, 2)[2]
    scene = cantilever(straight(20), lambda b: [LineForce(b, (0.0, force), follower)], section=section,
                       material=material)
    tip = displacement(follow(scene)) + np.array([1.0, 0.0])
    assert tip == pytest.approx(elastica_under_line_force(1.0, 10.0, follower), abs=2e-4)


def exact_steps(**settings):
    """Steps that never change their length."""
    return {"largest": 1.0, "iterations": 15} | settings


def test_prescribed_motion_gives_the_path_of_the_load():
    """Reaction and load are the same function of the deflection, beyond the limit point too, downwards both."""
    loaded = shallow_arch(10)
    moved = Scene(loaded.parts, loaded.supports, [PrescribedDisplacement(loaded.parts[0].mesh, "crown", "y", -20.0)],
                  loaded.monitor, symmetry_factor=2)
    by_load = follow(loaded, DisplacementControl(**exact_steps(step=1.0)), deflection=20.0).states
    by_motion = follow(moved, LoadControl(step=0.05, fixed=True)).states
    assert [s.deflection for s in by_motion] == pytest.approx([s.deflection for s in by_load], abs=1e-9)
    assert [s.load for s in by_motion] == pytest.approx([s.load for s in by_load], rel=1e-6, abs=1e-6)
    assert min(np.diff([s.load for s in by_load])) < 0, "beyond the limit point"


CONTROLS = {
    "cylindrical": ArcLength(shape="cylindrical"),
    "spherical": ArcLength(shape="spherical"),
    "elliptical": ArcLength(shape="elliptical"),
    "load": LoadControl(step=5.0, target=25.0),
    "displacement": DisplacementControl(step=1.0),
}


@pytest.mark.parametrize("name", CONTROLS)
def test_controls_follow_the_same_path(name):
    """The load at the last deflection, also beyond the limit point, is that of displacement control."""
    last = follow(shallow_arch(10), CONTROLS[name], deflection=14.0).states[-1]
    again = follow(shallow_arch(10), DisplacementControl(**exact_steps(step=last.deflection / 8)),
                   deflection=last.deflection).states[-1]
    assert again.deflection == pytest.approx(last.deflection, rel=1e-9)
    assert again.load == pytest.approx(last.load, rel=1e-6)


@pytest.mark.parametrize(("build", "message"), [
    (lambda: deep_arch.case(elements=1), "elements is 1"),
    (lambda: deep_arch.case(depth=50.0), "depth is 50"),
    (lambda: lee_frame.case(elements=7), "multiple of 5"),
    (lambda: roll_up.case(turns=0), "turns is 0"),
    (lambda: bend.case(steps=0), "steps is 0"),
])
def test_scenes_refuse_wrong_parameters(build, message):
    with pytest.raises(ValueError, match=message):
        build()
