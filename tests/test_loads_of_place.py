"""Loads that are functions of the place, springs per length of an edge, and masses, against closed forms."""

from __future__ import annotations

from math import pi, sqrt

import numpy as np
import pytest
from helpers import on_two_processes

import sheetfx as fx
from sheetfx import meshes

RADIUS, THICKNESS, HEIGHT, MODULUS, WEIGHT = 10.0, 0.1, 10.0, 2e11, 9810.0


def tank(pressure, side="negative"):
    """A quarter of an open tank on a frictionless floor: the radial displacement of its foot."""
    mesh = fx.read(lambda: meshes.rectangle((4, 4)), 3, 3, lambda x: np.column_stack(
        (RADIUS * np.cos(x[:, 0] * pi / 2), RADIUS * np.sin(x[:, 0] * pi / 2), HEIGHT * x[:, 1])))
    shell = fx.Shell(mesh, fx.Plate(THICKNESS), fx.Elastic(MODULUS, 0.0), form="naghdi-q3")
    scene = fx.Scene([shell], [fx.symmetry(mesh, "west", "y"), fx.symmetry(mesh, "east", "x"),
                               fx.Support(mesh, "south", "z")],
                     [fx.Pressure(shell, pressure, side)], fx.Monitor(mesh, "south-west", "x"))
    last = fx.trace(fx.Case(scene, fx.LoadControl(1.0, fixed=True))).states[-1]
    return last.deflection, last.load


def test_water_in_a_tank():
    """Membrane theory, w = p R^2 / (E t): exact for a pressure that is linear in the height."""
    deflection, load = tank(lambda x: WEIGHT * (HEIGHT - x[2]))
    assert deflection == pytest.approx(WEIGHT * HEIGHT * RADIUS**2 / (MODULUS * THICKNESS), rel=2e-3)
    assert load == pytest.approx(WEIGHT * HEIGHT)
    assert tank(lambda x: WEIGHT * (HEIGHT - x[2]), "positive")[0] == pytest.approx(-deflection, rel=2e-2)


def test_a_constant_function_is_a_number():
    assert tank(lambda x: 5e3 + 0 * x[2]) == pytest.approx(tank(5e3), rel=1e-9)


def ring_section(pressure):
    """A beam on two supports under a pressure across it: the deflection of its middle."""
    members = {"l": ("a", "m", 8), "r": ("m", "b", 8)}
    mesh = fx.read(lambda: meshes.frame({"a": (0, 0), "m": (1, 0), "b": (2, 0)}, members), 2)
    beam = fx.Beam(mesh, fx.Rectangle(1.0, 0.01), fx.Elastic(1e6))
    scene = fx.Scene([beam], [fx.pin(mesh, "a"), fx.Support(mesh, "b", "y")], [fx.LinePressure(beam, pressure)],
                     fx.Monitor(mesh, "m", "y"))
    return fx.trace(fx.Case(scene, fx.LoadControl(1.0, fixed=True))).states[-1].deflection


def test_line_pressure_of_the_place():
    """Symmetric triangular load q on two supports: q L^4 / (120 E I)."""
    q, stiffness = 1e-6, 1e6 * 0.01**3 / 12
    found = ring_section(lambda x: q * (1 - abs(x[0] - 1)))
    assert found == pytest.approx(q * 2.0**4 / (120 * stiffness), rel=2e-3)


def strip(cells, loads, joints=lambda mesh: ()):
    """Cantilever strip of 100 x 20 x 2 along x: its tip."""
    mesh = fx.read(lambda: meshes.rectangle((6, cells), (100.0, 20.0)), 3, 2)
    shell = fx.Shell(mesh, fx.Plate(2.0), fx.Elastic(2e5, 0.0), form="naghdi-q2")
    scene = fx.Scene([shell], [fx.clamp(mesh, "west")], loads(mesh), fx.Monitor(mesh, "south-east", "z", -1.0),
                     joints=joints(mesh))
    state = fx.trace(fx.Case(scene, fx.LoadControl(1.0, fixed=True))).states[-1]
    return state.deflection, state.load


@pytest.mark.slow
def test_forces_and_moments_along_an_edge():
    """Linear ones about the middle, of the same sum and size as constant ones, with nothing to twist by symmetry."""
    def tent(x):
        return 2e-3 * (1 - abs(x[1] - 10.0) / 10.0)

    constant, size = strip(4, lambda m: [fx.EdgeForce(m, "east", (0.0, 0.0, -1e-3))])
    found, load = strip(4, lambda m: [fx.EdgeForce(m, "east", lambda x: (0.0, 0.0, -tent(x)))])
    assert load == pytest.approx(size) and found == pytest.approx(constant, rel=1e-2)
    constant, size = strip(4, lambda m: [fx.Moment(m, "east", (0.0, 1e-2, 0.0))])
    found, load = strip(4, lambda m: [fx.Moment(m, "east", lambda x: (0.0, 10 * tent(x), 0.0))])
    assert load == pytest.approx(size) and found == pytest.approx(constant, rel=1e-2)


def test_functions_at_points_are_refused():
    mesh = fx.read(lambda: meshes.rectangle((1, 1)), 3)
    with pytest.raises(ValueError, match="Moment at 'south-west': is a function of the place, but acts at a point"):
        fx.Moment(mesh, "south-west", lambda x: (0.0, 0.0, x[0]))


@pytest.mark.parametrize("cells", [1, 2, 4])
def test_springs_per_length_do_not_depend_on_cells(cells):
    """F / (3 E I / L^3 + k b); per node of the edge they would be twice and three times as stiff."""
    found, _ = strip(cells, lambda m: [fx.EdgeForce(m, "east", (0.0, 0.0, -1e-3))],
                     lambda m: [fx.EdgeFoundation(m, "east", (0.0, 0.0, 0.5))])
    assert found == pytest.approx(20e-3 / (3 * 2e5 * 20 * 2**3 / 12 / 100**3 + 0.5 * 20), rel=1e-3)


MASSES = """
import sheetfx as fx
from sheetfx import meshes
from mpi4py import MPI

MASS = 7850.0 * 0.02 * 0.02

def lowest(masses, shell=True):
    if shell:
        mesh = fx.read(lambda: meshes.rectangle((8, 2), (1.0, 0.02)), 3, 2)
        part = fx.Shell(mesh, fx.Plate(0.02), fx.Elastic(2e11, 0.0, 7850.0), form="naghdi-q2")
        held, load = fx.clamp(mesh, "west"), fx.EdgeForce(mesh, "east", (0.0, 0.0, 1.0))
        monitor = fx.Monitor(mesh, "south-east", "z")
    else:
        mesh = fx.read(lambda: meshes.frame({"a": (0, 0), "b": (1, 0)}, {"beam": ("a", "b", 8)}), 2)
        part = fx.Beam(mesh, fx.Rectangle(0.02, 0.02), fx.Elastic(2e11, 0.3, 7850.0))
        held, load, monitor = fx.clamp(mesh, "a"), fx.PointForce(mesh, "b", (0.0, 1.0)), fx.Monitor(mesh, "b", "y")
    scene = fx.Scene([part], [held], [load], monitor, joints=masses(mesh))
    record = fx.trace(fx.Case(scene, until=fx.Until(steps=0)))
    return record.frequencies(record.states[0], 1)[0].frequency

def corners(mesh):
    return [fx.Mass(mesh, name, MASS / 2) for name in ("south-east", "north-east")]
"""
exec(MASSES)  # two processes run it as well
TIP = 1.24792**2 / (2 * pi) * sqrt(2e11 * 0.02**4 / 12 / (7850 * 4e-4))  # cantilever with its own mass at its tip


@pytest.mark.parametrize(("masses", "shell"), [
    (lambda m: [fx.Mass(m, "b", MASS)], False), (lambda m: corners(m), True),  # noqa: F821
    (lambda m: [fx.Mass(m, "east", MASS / 0.02)], True)], ids=["beam", "corners", "edge"])  # noqa: F821
def test_a_mass_at_the_tip(masses, shell):
    """Bernoulli's beam; shear softens this one by 2e-4, and the shell's clamped edge stiffens it by a thousandth."""
    assert lowest(masses, shell) == pytest.approx(TIP, rel=1.5e-3)  # noqa: F821


def test_rotary_inertia_of_a_mass():
    """The tip turns, by 1.4 of its deflection over the length: a hundredth more of the kinetic energy."""
    plain = lowest(lambda m: [fx.Mass(m, "b", MASS)], False)  # noqa: F821
    slower = lowest(lambda m: [fx.Mass(m, "b", MASS, inertia=MASS * 0.1**2)], False)  # noqa: F821
    assert 0.95 * plain < slower < 0.999 * plain


def test_masses_on_two_processes():
    (line,) = on_two_processes(MASSES + "\nfound = lowest(corners)\nif not MPI.COMM_WORLD.rank:\n    print(found)\n")
    assert float(line) == pytest.approx(lowest(corners), rel=1e-8)  # noqa: F821


def test_a_mass_of_nothing_is_refused():
    mesh = fx.read(lambda: meshes.rectangle((1, 1)), 3)
    with pytest.raises(ValueError, match="Mass at 'south-west': mass and inertia are 0; give one of them"):
        fx.Mass(mesh, "south-west", 0.0)
