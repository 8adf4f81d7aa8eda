"""Steps that lead to another path, and critical points that do not converge again, in problems that are not smooth."""

from dataclasses import replace
from math import pi

import numpy as np
import pytest

import sheetfx as fx
from sheetfx.scenes import load_case

LENGTH, DEPTH, MODULUS = 1000.0, 10.0, 2e5
EULER = pi**2 * MODULUS * DEPTH**4 / 12 / LENGTH**2


def column_above_a_floor(crooked):
    """A column whose middle is so far off its axis, and a floor that it only reaches later."""
    ends = {"base": (0.0, 0.0), "tip": (LENGTH, 0.0)}
    mesh = fx.read(lambda: fx.meshes.frame(ends, {"column": ("base", "tip", 20)}), 2)
    mesh = fx.imperfect(mesh, lambda x: np.column_stack((0 * x[:, 0], np.sin(pi * x[:, 0] / LENGTH))), crooked)
    beam = fx.Beam(mesh, fx.Rectangle(DEPTH, DEPTH), fx.Elastic(MODULUS, 0.0))
    floor = fx.ObstacleContact(mesh, None, fx.RigidPlane((0.0, -50.0), (0.0, 1.0)), distance=0.0)
    return fx.Scene([beam], [fx.pin(mesh, "base"), fx.Support(mesh, "tip", "y")],
                    [fx.PointForce(mesh, "tip", (-1.0, 0.0))], fx.Monitor(mesh, "tip", "x", -1.0), joints=[floor])


def test_step_past_a_bifurcation_does_not_leap_to_the_other_branch():
    """A column that is a millionth of its length off its axis bends away as its load comes to Euler's.

    Beyond, it can also be nearly straight, unstable and bent to the other side. A step from rest to 1.2 times Euler's
    load came to that, and was said to have passed a bifurcation at 1.07; nothing leads from one to the other. The
    contact keeps tangents from being trusted.
    """
    control = fx.LoadControl(step=0.6 * EULER, target=1.5 * EULER)
    record = fx.trace(fx.Case(column_above_a_floor(1e-3), control, fx.Until(deflection=2.0)))
    assert not record.critical_points
    last = record.states[-1]
    assert last.unstable_modes == 0 and last.load == pytest.approx(EULER, rel=3e-3)


def test_contact_that_touches_nothing_keeps_no_step_from_being_guarded():
    """A tenth as crooked, the column leapt to the straight path and was said to bifurcate at 0.9999 of Euler's load."""
    control = fx.LoadControl(step=0.3 * EULER, target=1.5 * EULER)
    record = fx.trace(fx.Case(column_above_a_floor(1e-4), control, fx.Until(deflection=2.0)))
    assert not record.critical_points
    assert record.states[-1].unstable_modes == 0 and record.states[-1].load == pytest.approx(1.0008 * EULER, rel=1e-4)


@pytest.mark.parametrize("step", [0.03, 0.08])
@pytest.mark.slow(quick=1)
def test_crooked_arch_sways_whatever_it_does_not_touch(step):
    """A deep arch a ten-thousandth of its radius off sways at 968.7; the perfect one's limit, past its bifurcation at
    969.6, is 1223, which the path leapt to where there was a stop below. Without the stop nothing leaps.
    """
    mesh = fx.read(lambda: fx.meshes.arc(100.0, -1.2, 1.2, 40, {"crown": 0.0}), dimension=2, order=2)
    mesh = fx.imperfect(mesh, lambda x: np.column_stack((0 * x[:, 0], np.sin(pi * x[:, 0] / 93.0))), 0.01)
    arch = fx.Beam(mesh, fx.Rectangle(1.0, 1.0), fx.Elastic(12e6))
    stop = fx.ObstacleContact(mesh, None, fx.RigidPlane((0.0, -300.0), (0.0, 1.0)), distance=0.0)
    found = []
    for joints in ([], [stop]):
        scene = fx.Scene([arch], [fx.pin(mesh, "start"), fx.pin(mesh, "end")],
                         [fx.PointForce(mesh, "crown", (0.0, -1.0))], fx.Monitor(mesh, "crown", "y", -1.0),
                         joints=joints)
        record = fx.trace(fx.Case(scene, fx.ArcLength(step), fx.Until(deflection=30.0)))
        found.append([(p.kind, p.load) for p in record.critical_points])
    (kind, load), = found[1]
    assert found[0] == [("limit", pytest.approx(load, rel=1e-4))] and kind == "limit"
    assert load == pytest.approx(968.7, rel=1e-3)


def test_mode_of_a_point_that_does_not_converge_again_is_that_at_the_end_of_its_step(monkeypatch):
    """As can happen at a corner of a path with contact, whose run then had no pictures and no quantities."""
    def fails(*_):
        raise ArithmeticError

    record = fx.trace(fx.Case(column_above_a_floor(0.0), fx.LoadControl(step=0.45 * EULER, target=1.2 * EULER)))
    (point,) = record.critical_points
    assert point.load == pytest.approx(EULER, rel=1e-3)
    exact, = record.critical_modes(point)
    monkeypatch.setattr("sheetfx.critical.shares.state_at", fails)
    near, = record.critical_modes(point)
    assert abs(near @ exact) == pytest.approx(np.linalg.norm(near) * np.linalg.norm(exact), rel=1e-3)


@pytest.mark.parametrize("name", ["von-mises-truss", "roorda-frame"])
def test_points_are_found_and_named_as_without_a_floor_that_is_never_reached(name):
    """Limits were the highest states found, off by 1e-5 and more, and bifurcations had no names."""
    case = load_case(name)()
    mesh = case.scene.parts[0].mesh
    floor = fx.ObstacleContact(mesh, None, fx.RigidPlane((0.0, -9.0 * mesh.size), (0.0, 1.0)), distance=0.0)
    alone, beside = (fx.trace(replace(case, scene=replace(case.scene, joints=joints))) for joints in ([], [floor]))
    assert [(p.kind, p.name, p.multiplicity) for p in beside.critical_points] == [
        (p.kind, p.name, p.multiplicity) for p in alone.critical_points] != []
    assert [p.load for p in beside.critical_points] == pytest.approx([p.load for p in alone.critical_points], rel=1e-7)
