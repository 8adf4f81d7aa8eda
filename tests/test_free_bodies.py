"""Structures without supports: frequencies with their rigid motions, and loads in equilibrium."""

from __future__ import annotations

from math import pi, sqrt

import numpy as np
import pytest
from helpers import on_two_processes

import sheetfx as fx

STEEL = fx.Elastic(2.1e11, 0.3, 7850.0)


def free_beam(dimension=2, loads=None):
    rest = (0.0,) * (dimension - 1)
    mesh = fx.read(lambda: fx.meshes.frame({"a": (0.0, *rest), "b": (1.0, *rest)}, {"l": ("a", "b", 10)}), dimension)
    beam = fx.Beam(mesh, fx.Rectangle(0.01, 0.01), STEEL)
    given = loads or {"a": (1000.0, *rest), "b": (-1000.0, *rest)}
    return fx.Scene([beam], [], [fx.PointForce(mesh, at, force) for at, force in given.items()],
                    fx.Monitor(mesh, "b", "x"))


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.slow(quick=1)
def test_free_beam(dimension):
    """(4.7300 / L)^2 sqrt(EI / rho A) (Blevins 1979), each twice in space; it buckles as on hinges."""
    record = fx.trace(fx.Case(free_beam(dimension), fx.LoadControl(), fx.Until(steps=1)))
    count = dimension * (dimension + 1) // 2
    found = record.frequencies(record.states[0], count + 4)
    assert all(v.rigid and v.frequency == 0 for v in found[:count]) and not any(v.rigid for v in found[count:])
    assert str(found[count - 1]) == "rigid motion about z"
    first = 4.7300407**2 / (2 * pi) * sqrt(2.1e11 * 0.01**2 / 12 / 7850.0)
    bent = [v.frequency for v in found[count:count + dimension - 1]]
    assert bent == pytest.approx([first] * (dimension - 1), rel=5e-4)
    assert record.states[-1].deflection == pytest.approx(-record.states[-1].factor * 500 / (2.1e11 * 1e-4), rel=1e-6)
    euler = pi**2 * 2.1e11 * 0.01**4 / 12
    assert record.buckling(record.states[0])[0].factor * 1000 == pytest.approx(euler, rel=3e-4)
    with pytest.raises(ValueError, match="do not move with the free body about"):
        record.frequencies(record.states[-1])


@pytest.mark.parametrize("degree", [2, 3])
@pytest.mark.slow(quick=1)
def test_free_square_plate(degree):
    """NAFEMS FV12: six rigid motions, then 1.622, 2.360, 2.922, 4.190 twice, and 7.356 Hz."""
    mesh = fx.read(lambda: fx.meshes.rectangle((6, 6), (10.0, 10.0)), 3, degree)
    plate = fx.Shell(mesh, fx.Plate(0.05), fx.Elastic(200e9, 0.3, 8000.0), form=f"naghdi-q{degree}")
    scene = fx.Scene([plate], [], [fx.SurfaceForce(plate, (0.0, 0.0, 1.0))], fx.Monitor(mesh, "north-east", "z"))
    record = fx.trace(fx.Case(scene, until=fx.Until(steps=0)))
    found = record.frequencies(record.states[0], 12)
    assert [v.rigid for v in found[:6]] == ["along x", "along y", "along z", "about x", "about y", "about z"]
    assert [v.frequency for v in found[6:]] == pytest.approx([1.622, 2.360, 2.922, 4.190, 4.190, 7.356], rel=8e-3)
    with pytest.raises(ValueError, match="not in equilibrium: there is a force along z"):
        fx.trace(fx.Case(scene))


def test_pinched_ring_is_that_on_its_own_axes():
    """Two forces on a free ring, far beyond small motions, beside the same with supports that hold nothing else."""
    def ring(free):
        mesh = fx.read(lambda: fx.meshes.frame(
            {f"{i}": (np.cos(pi * i / 16), np.sin(pi * i / 16)) for i in range(32)},
            {f"{i}-{(i + 1) % 32}": (f"{i}", f"{(i + 1) % 32}", 1) for i in range(32)}), 2)
        beam = fx.Beam(mesh, fx.Rectangle(0.05, 0.02), STEEL)
        held = [] if free else [fx.Support(mesh, "0", "y rz"), fx.Support(mesh, "16", "y"),
                                fx.Support(mesh, "8", "x rz"), fx.Support(mesh, "24", "x")]
        return fx.Scene([beam], held, [fx.PointForce(mesh, "0", (2e4, 0.0)), fx.PointForce(mesh, "16", (-2e4, 0.0))],
                        fx.Monitor(mesh, "0", "x"))

    ends = [fx.trace(fx.Case(ring(free), fx.LoadControl(0.25, fixed=True))).states[-1] for free in (True, False)]
    assert ends[0].deflection == pytest.approx(ends[1].deflection, rel=1e-6) and ends[0].deflection > 0.15


@pytest.mark.slow
def test_parts_that_are_joined_are_one_free_body():
    """Two beams that are welded, and masses on them, beside one; a spring to the ground makes them held."""
    mesh = fx.read(lambda: fx.meshes.frame({"a": (0, 0), "m": (0.5, 0)}, {"l": ("a", "m", 5)}), 2)
    other = fx.read(lambda: fx.meshes.frame({"m": (0.5, 0), "b": (1.0, 0)}, {"r": ("m", "b", 5)}), 2)
    beams = [fx.Beam(m, fx.Rectangle(0.01, 0.01), STEEL) for m in (mesh, other)]
    forces = [fx.PointForce(mesh, "a", (1000.0, 0.0)), fx.PointForce(other, "b", (-1000.0, 0.0))]
    scene = fx.Scene(beams, [], forces, fx.Monitor(other, "b", "x"), joints=[fx.weld(mesh, "m", (other, "m"))])
    record = fx.trace(fx.Case(scene, fx.LoadControl(), fx.Until(steps=1)))
    one = fx.trace(fx.Case(free_beam(), fx.LoadControl(), fx.Until(steps=1)))
    two, whole = (r.frequencies(r.states[0], 6) for r in (record, one))
    assert [v.frequency for v in two] == pytest.approx([v.frequency for v in whole], rel=1e-6)
    held = fx.Scene(beams, [], forces, fx.Monitor(other, "b", "x"), joints=[
        *scene.joints, *(fx.Spring(mesh, "a", c, 1e6) for c in ("x", "y", "rz"))])
    assert scene.free and not held.free


@pytest.mark.slow
def test_free_truss_and_heat():
    """Bars alone; a free plate that is heated expands without forces."""
    ends = {"a": (0, 0), "b": (1, 0), "c": (0, 1)}
    mesh = fx.read(lambda: fx.meshes.frame(ends, {p: (*p, 1) for p in ("ab", "bc", "ca")}), 2)
    bars = fx.Bar(mesh, fx.Rectangle(0.01, 0.01), STEEL)
    scene = fx.Scene([bars], [], [fx.PointForce(mesh, "b", (100.0, 0.0)), fx.PointForce(mesh, "a", (-100.0, 0.0))],
                     fx.Monitor(mesh, "b", "x"))
    record = fx.trace(fx.Case(scene, fx.LoadControl()))
    assert record.forces(bars).ravel() == pytest.approx([100.0, 0.0, 0.0], abs=1e-3)
    assert len([v for v in record.frequencies(record.states[0], 6) if v.rigid]) == 3
    plate = fx.read(lambda: fx.meshes.rectangle((2, 2)), 3, 2)
    shell = fx.Shell(plate, fx.Plate(0.01), STEEL)
    hot = fx.trace(fx.Case(fx.Scene([shell], [], [fx.Temperature(shell, 100.0, 1e-5)],
                                    fx.Monitor(plate, "north-east", "x")), fx.LoadControl()))
    assert hot.states[-1].deflection == pytest.approx((sqrt(1 + 2e-3) - 1) / 2, rel=1e-6)
    assert np.abs(hot.forces(shell)).max() < 1e-6 * 2.1e11 * 0.01 * 1e-3


@pytest.mark.slow
def test_on_two_processes():
    script = """
from test_free_bodies import free_beam, fx
record = fx.trace(fx.Case(free_beam(3), fx.LoadControl(), fx.Until(steps=1)))
print(record.states[-1].deflection, *(v.frequency for v in record.frequencies(record.states[0], 8)))
"""
    moved, *found = map(float, on_two_processes(script)[0].split())
    record = fx.trace(fx.Case(free_beam(3), fx.LoadControl(), fx.Until(steps=1)))
    assert moved == pytest.approx(record.states[-1].deflection, rel=1e-9)
    assert found == pytest.approx([v.frequency for v in record.frequencies(record.states[0], 8)], rel=1e-8)


def test_moment_out_of_balance_is_named():
    scene = free_beam(2, {"a": (0.0, 1.0), "b": (0.0, -1.0)})
    with pytest.raises(ValueError, match="there is a moment about z"):
        fx.trace(fx.Case(scene, fx.LoadControl()))
