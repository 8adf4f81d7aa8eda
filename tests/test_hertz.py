"""Line contact of thin structures with a cylinder: a strip that is bent around it, and a layer that is pressed in."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

import sheetfx as fx
from sheetfx import meshes

STIFF = fx.Elastic(1e9, 0.3)


def cylinder(cells, angles, width, radius, top):
    """Panel of a cylinder about y whose highest (or lowest, for a negative radius) line is at a height."""
    def place(x):
        angle = angles[0] + (angles[1] - angles[0]) * x[:, 0]
        return np.column_stack((abs(radius) * np.sin(angle), width * (x[:, 1] - 0.5),
                                top + radius * (np.cos(angle) - 1)))

    return fx.read(lambda: meshes.rectangle((cells, 1)), 3, 3, place)


class BentAroundCylinder:
    """Inextensible strip, clamped on top of a cylinder, whose free end is pulled down: EI theta'' = -P cos theta.

    While it touches its curvature is 1/R, without shear; the contact ends in a concentrated force P cos(theta), and
    presses with P sin(theta) / R before (belt on a drum), theta being the angle where it leaves (Antman 2005, chapter
    4).
    """

    def __init__(self, length, bending, radius, load):
        self._length, self._bending, self._radius, self._load = length, bending, radius, load
        self.arc = brentq(lambda arc: self._end(arc)[1], 0.0, length, xtol=1e-12)
        self.deflection = self._end(self.arc)[2]
        angle = self.arc / radius
        self.force = load * (np.cos(angle) + np.sin(angle) * angle)

    def _end(self, arc):
        """Angle, curvature and deflection of the end, where the strip leaves the cylinder after an arc."""
        angle = arc / self._radius
        return solve_ivp(lambda s, y: [y[1], -self._load / self._bending * np.cos(y[0]), np.sin(y[0])],
                         (arc, self._length), [angle, 1 / self._radius, self._radius * (1 - np.cos(angle))],
                         rtol=1e-10, atol=1e-12).y[:, -1]


@pytest.mark.slow
def test_strip_bent_around_a_cylinder():
    """As far as its curvature asks for, with the thickness of both; contact ends between two of its points."""
    length, depth, width, thickness, cells = 1.0, 0.01, 0.05, 0.02, 20
    steel, radius = fx.Elastic(1.2e9, 0.0), 1.0 + (depth + thickness) / 2
    drum = cylinder(12, (-0.1, 0.9), 0.1, 1.0, 0.0)
    line = fx.read(lambda: meshes.frame({"middle": (0, 0, radius - 1.0), "end": (length, 0, radius - 1.0)},
                                        {"strip": ("middle", "end", cells)}), 3, 2)
    strip = fx.Beam(line, fx.Rectangle(width, depth), steel, up=(0.0, 0.0, 1.0))
    bending = 1.2e9 * width * depth**3 / 12
    contact = fx.SurfaceContact(line, "strip", (drum, None), toward=(0.0, 0.0, -1.0))
    scene = fx.Scene(
        [strip, fx.Shell(drum, fx.Plate(thickness), fx.Elastic(1e15, 0.3))],
        [fx.clamp(line, "middle"), fx.clamp(drum, "south"), fx.clamp(drum, "north")],
        [fx.PointForce(line, "end", (0.0, 0.0, -bending / radius / length))], fx.Monitor(line, "end", "z", -1.0),
        joints=[contact])
    record = fx.trace(fx.Case(scene, fx.LoadControl(step=1.5, target=3.0, fixed=True)))
    for state in record.states[1:]:
        record.show(state)
        pairs, theory = record.pairs(contact), BentAroundCylinder(length, bending, radius, state.load)
        assert state.deflection == pytest.approx(theory.deflection, rel=1e-3)
        touched = radius * np.arcsin(pairs.position[pairs.pressure > 0, 0].max() / radius)
        assert touched == pytest.approx(theory.arc, abs=length / cells / 2)
        assert pairs.weight @ pairs.pressure == pytest.approx(theory.force, rel=3e-2)


@pytest.mark.parametrize("on_plate", [True, False])
@pytest.mark.slow
def test_cylinder_pressed_into_an_elastic_layer(on_plate):
    """Winkler's foundation under a cylinder (Johnson 1985, section 4.3): half-width sqrt(2 R d) and force per length
    4/3 k d sqrt(2 R d), which is (3 F R / 2 k)^(1/3) for the half-width.

    The layer is that of the contact, between bodies that are stiff. Points are those of the cylinder or of the plate.
    """
    radius, depth, stiffness, width = 1.0, 1.25e-3, 1e3, 0.1
    panel = cylinder(16, (-0.1, 0.1), width, -radius, 0.0)
    plate = fx.read(lambda: meshes.rectangle((16, 1), (0.2, width)), 3, 1,
                    lambda x: x - np.array([0.1, width / 2, 0.0]))
    first, second = (panel, plate) if on_plate else (plate, panel)
    contact = fx.SurfaceContact(first, None, (second, None), distance=0.0, samples=6, enforcement="penalty",
                                toward=(0.0, 0.0, -1.0 if on_plate else 1.0), stiffness=stiffness)
    ends, sides = ("west", "east"), ("south", "north")
    scene = fx.Scene(
        [fx.Shell(mesh, fx.Plate(0.05), STIFF) for mesh in (panel, plate)],
        [*(fx.clamp(plate, e) for e in ends + sides), *(fx.Support(panel, e, "x y rx ry rz") for e in ends)],
        [fx.PrescribedDisplacement(panel, e, "z", -depth) for e in ends], fx.Monitor(panel, "south-west", "z"),
        joints=[contact])
    record = fx.trace(fx.Case(scene, fx.LoadControl(step=1.0, fixed=True)))
    record.show(record.states[-1])
    pairs, half = record.pairs(contact), np.sqrt(2 * radius * depth)
    force = pairs.weight @ pairs.pressure / width
    assert force == pytest.approx(4 / 3 * stiffness * depth * half, rel=5e-3)
    assert half == pytest.approx((1.5 * force * radius / stiffness) ** (1 / 3), rel=2e-3)
    assert np.abs(pairs.position[pairs.pressure > 0, 0]).max() == pytest.approx(half, abs=0.2 / 16 / 6)
