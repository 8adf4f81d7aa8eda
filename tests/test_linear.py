"""Linear solutions of records: displacements, rotations, forces, stresses and reactions."""

from __future__ import annotations

import numpy as np
import pytest

import sheetfx as fx

E, LENGTH, FORCE = 2.1e5, 100.0, 5000.0  # so large that the nonlinear deflection is another one


@pytest.mark.parametrize("dimension", [2, 3])
def test_cantilever(dimension):
    """F L^3 / 3EI + F L / GA, F L^2 / 2EI; moments F (L - x), stresses by them, and the reaction."""
    ends = {"a": (0, 0, 0)[:dimension], "b": (LENGTH, 0, 0)[:dimension]}
    mesh = fx.read(lambda: fx.meshes.frame(ends, {"l": ("a", "b", 4)}), dimension)
    beam = fx.Beam(mesh, fx.Rectangle(10.0, 5.0), fx.Elastic(E, 0.3), **({"up": (0, 1, 0)} if dimension == 3 else {}))
    support = fx.clamp(mesh, "a")
    force = fx.PointForce(mesh, "b", (0, FORCE, 0)[:dimension])
    scene = fx.Scene([beam], [support], [force], fx.Monitor(mesh, "b", "y"))
    record = fx.trace(fx.Case(scene, until=fx.Until(steps=1)))
    before = record.displacement("b")
    linear, half = record.linear(), record.linear(0.5)
    second, shear = 10 * 5**3 / 12, 5 / 6 * E / 2.6 * 50
    tip = FORCE * LENGTH**3 / (3 * E * second) + FORCE * LENGTH / shear
    assert linear.displacement("b")[1] == pytest.approx(tip, rel=1e-6) and linear.deflection == pytest.approx(tip)
    assert np.ravel(linear.rotation("b"))[-1] == pytest.approx(FORCE * LENGTH**2 / (2 * E * second), rel=1e-6)
    places = record.section_points(beam).reference[..., 0]
    assert linear.forces(beam)[..., -1] == pytest.approx(FORCE * (LENGTH - places), rel=1e-6)
    at = 2.5 if dimension == 2 else (2.5, 0.0)
    assert linear.stresses(beam, at)[..., 0] == pytest.approx(-FORCE * (LENGTH - places) * 2.5 / second, rel=1e-6)
    assert linear.reaction(support)[:2] == pytest.approx([0, -FORCE], abs=1e-6 * FORCE)
    assert half.forces(beam) == pytest.approx(linear.forces(beam) / 2, rel=1e-9, abs=1e-6)
    assert linear.load == pytest.approx(FORCE) and str(half) == "linear solution at load factor 0.5"
    assert record.displacement("b") == pytest.approx(before, rel=1e-12)
    with pytest.raises(ValueError, match="is no support or prescribed motion"):
        linear.reaction("b")


def test_behind_a_stage_it_is_about_that():
    """A prestressed string: P L / (2 N) at its middle for a force across, whose first state has no stiffness."""
    mesh = fx.read(lambda: fx.meshes.frame({"a": (0, 0), "m": (1, 0), "b": (2, 0)},
                                           {"l": ("a", "m", 1), "r": ("m", "b", 1)}), 2)
    bars = fx.Bar(mesh, fx.Rectangle(1.0, 1.0), fx.Elastic(1e6))
    scene = fx.Scene([bars], [fx.pin(mesh, "a"), fx.pin(mesh, "b")], [fx.PointForce(mesh, "m", (0.0, 10.0))],
                     fx.Monitor(mesh, "m", "y"), stages=[fx.Stage([fx.InitialStrain(bars, -1e-3)], at_once=True)])
    record = fx.trace(fx.Case(scene, fx.LoadControl()))
    assert record.linear().deflection == pytest.approx(10.0 / (2 * 1000.0), rel=1e-6)
    assert record.states[-1].deflection < 0.99 * record.linear().deflection


def test_plate_and_free_body():
    mesh = fx.read(lambda: fx.meshes.rectangle((2, 2)), 3, 2)
    plate = fx.Shell(mesh, fx.Plate(0.01), fx.Elastic(E, 0.3))
    pull = [fx.EdgeForce(mesh, "west", (-1.0, 0, 0)), fx.EdgeForce(mesh, "east", (1.0, 0, 0))]
    record = fx.trace(fx.Case(fx.Scene([plate], [], pull, fx.Monitor(mesh, "north-east", "x")),
                              until=fx.Until(steps=0)))
    assert record.linear(100.0).stresses(plate)[..., 0] == pytest.approx(100 / 0.01, rel=1e-6)
    lost = fx.trace(fx.Case(fx.Scene([plate], [], pull[:1], fx.Monitor(mesh, "north-east", "x")),
                            until=fx.Until(steps=0)))
    with pytest.raises(ValueError, match="not in equilibrium"):
        lost.linear()
