"""Steps that lead to another path, in problems that are not smooth."""

from math import pi

import numpy as np
import pytest

import sheetfx as fx

LENGTH, DEPTH, MODULUS = 1000.0, 10.0, 2e5
EULER = pi**2 * MODULUS * DEPTH**4 / 12 / LENGTH**2


def test_step_past_a_bifurcation_does_not_leap_to_the_other_branch():
    """A column that is a millionth of its length off its axis bends away as its load comes to Euler's.

    Beyond, it can also be nearly straight, unstable and bent to the other side. A step from rest to 1.2 times Euler's
    load came to that, and was said to have passed a bifurcation at 1.07; nothing leads from one to the other. The
    contact, with a floor that the column only reaches later, keeps tangents from being trusted.
    """
    ends = {"base": (0.0, 0.0), "tip": (LENGTH, 0.0)}
    mesh = fx.read(lambda: fx.meshes.frame(ends, {"column": ("base", "tip", 20)}), 2)
    mesh = fx.imperfect(mesh, lambda x: np.column_stack((0 * x[:, 0], np.sin(pi * x[:, 0] / LENGTH))), 1e-3)
    beam = fx.Beam(mesh, fx.Rectangle(DEPTH, DEPTH), fx.Elastic(MODULUS, 0.0))
    floor = fx.ObstacleContact(mesh, None, fx.RigidPlane((0.0, -50.0), (0.0, 1.0)), distance=0.0)
    scene = fx.Scene([beam], [fx.pin(mesh, "base"), fx.Support(mesh, "tip", "y")],
                     [fx.PointForce(mesh, "tip", (-1.0, 0.0))], fx.Monitor(mesh, "tip", "x", -1.0), joints=[floor])
    record = fx.trace(fx.Case(scene, fx.LoadControl(step=0.6 * EULER, target=1.5 * EULER), fx.Until(deflection=2.0)))
    assert not record.critical_points
    last = record.states[-1]
    assert last.unstable_modes == 0 and last.load == pytest.approx(EULER, rel=3e-3)
