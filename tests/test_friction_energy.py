"""Friction in the balance of energy: what it dissipates, by hand, by the work of the loads, and on two processes."""

from __future__ import annotations

import json
import sys
from pathlib import Path

import pytest
from helpers import on_two_processes

import sheetfx as fx

sys.path.append(str(Path(__file__).parent / "golden"))
import untried

PRESSED, MU, DRAWN, STICKS = 2.0, 0.3, 0.1, 0.01  # force, coefficient, way, and the elastic part of it


def drawn_node(**how) -> fx.Record:
    """A node that is pressed on a floor and drawn over it by 0.1."""
    mesh = fx.read(lambda: fx.meshes.frame({"n": (0.0, 0.0), "far": (10.0, 0.0)}, {"bar": ("n", "far", 1)}), 2, 1)
    bar = fx.Bar(mesh, fx.Rectangle(1.0, 1.0), fx.Elastic(1e-9))
    touch = fx.ObstacleContact(mesh, "n", fx.RigidPlane((0.0, 0.0), (0.0, 1.0)), distance=0.0, friction=MU, **how)
    press = fx.Stage([fx.PointForce(mesh, "n", (0.0, -PRESSED))], control=fx.LoadControl(1.0, fixed=True))
    scene = fx.Scene([bar], [fx.pin(mesh, "far")], [fx.PrescribedDisplacement(mesh, "n", "x", DRAWN)],
                     fx.Monitor(mesh, "n", "x"), joints=[touch, fx.Spring(mesh, "n", "y", 1e-4)], stages=[press])
    return fx.trace(fx.Case(scene, fx.LoadControl(0.1)))


def test_friction_dissipates_its_traction_times_slip():
    """The traction is the bound but for elastic slip, which is stored."""
    bound = MU * PRESSED
    balance = drawn_node(enforcement="penalty", stiffness=1e4, tangential=bound / STICKS).balance(1e-4)
    assert balance.dissipated[-1] == pytest.approx(bound * (DRAWN - STICKS), rel=1e-6)
    assert balance.joints[-1] == pytest.approx(bound * STICKS / 2 + PRESSED**2 / 2e4, rel=1e-6)
    assert not balance.untold and balance.off < 1e-4 and not balance.broken


def test_friction_that_sticks_exactly_dissipates_along_all_of_the_slip():
    """The traction jumps as the node begins to move, so that the work is known the less exactly."""
    balance = drawn_node(enforcement="uzawa", stiffness=1e4, tangential=1e4).balance(1e-4)
    assert balance.dissipated[-1] == pytest.approx(MU * PRESSED * DRAWN, rel=1e-4)
    assert not balance.untold and balance.off < 3e-4 and not balance.broken


@pytest.mark.parametrize(("name", "accuracy"), [
    ("leaves", 1e-4), *(pytest.param(name, 1e-6, marks=pytest.mark.slow)
                        for name in ("leaves", "drawn-tip", "drawn-tip-uzawa", "tip-slides", "leaves-in-line"))])
def test_work_of_loads_is_stored_or_rubbed_away(name, accuracy):
    """Of leaves and of tips that slide along beams; the balance is as exact as it is asked to be."""
    balance = fx.trace(untried.CASES[name]()).balance(accuracy)
    assert balance.dissipated[-1] > 0 and not balance.untold
    assert balance.tolerance <= accuracy and balance.off <= accuracy and not balance.broken


def energies() -> list[float]:
    balance = fx.trace(untried.CASES["leaves"]()).balance()
    return [balance.joints[-1], balance.dissipated[-1], balance.off]


@pytest.mark.slow
def test_two_processes_balance_as_one():
    lines = on_two_processes("""
import json
from mpi4py import MPI
from test_friction_energy import energies
found = energies()
if MPI.COMM_WORLD.rank == 0:
    print(json.dumps(found))
""")
    assert json.loads(lines[-1]) == pytest.approx(energies(), rel=1e-6)
