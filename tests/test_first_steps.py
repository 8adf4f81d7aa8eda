"""First steps that are chosen from the structure, and steps with many critical points in them."""

from __future__ import annotations

from math import pi

import numpy as np
import pytest
from helpers import on_two_processes

import sheetfx as fx


def column(depth: float, metre: float = 1.0, newton: float = 1.0, control=None, load: float = 10.0):
    """A hinged column of length 1 and Euler load 1, in units of which a metre and a newton are given."""
    nodes = {"base": (0.0, 0.0), "tip": (metre, 0.0)}
    mesh = fx.read(lambda: fx.meshes.frame(nodes, {"column": ("base", "tip", 10)}), 2)
    section = fx.Rectangle(metre, depth * metre)
    modulus = 12 * newton / (pi**2 * depth**3 * metre**2)
    supports = [fx.Support(mesh, "base", "x y"), fx.Support(mesh, "tip", "y")]
    scene = fx.Scene([fx.Beam(mesh, section, fx.Elastic(modulus))], supports,
                     [fx.PointForce(mesh, "tip", (-newton, 0.0))], fx.Monitor(mesh, "tip", "x", -1.0))
    return fx.Path(scene, control or fx.ArcLength(), fx.Until(load=load * newton))


def found(path):
    return [(p.kind, p.multiplicity, p.name, p.load) for state in path for p in state.critical]


@pytest.mark.parametrize("depth", [1e-1, 1e-2, 1e-3, 1e-4, 1e-5])
def test_first_step_of_columns_of_any_slenderness(depth):
    """It ends before the first of the Euler loads n^2, which are then all found; thick columns squash and shear."""
    path = column(depth)
    states = list(path)
    kept = [p for state in states for p in state.critical]
    assert 0.2 < states[1].load < 1.0
    squash = depth**2 * pi**2 / 12
    assert [p.load for p in kept] == pytest.approx([1.0, 4.0, 9.0], rel=3e-3 + 30 * squash)
    assert [(p.kind, p.multiplicity) for p in kept] == [("bifurcation", 1)] * 3
    assert len(states) <= 8


@pytest.mark.parametrize(("metre", "newton"), [
    (39.37, 0.2248), *(pytest.param(*units, marks=pytest.mark.slow) for units in ((1e3, 1.0), (1e-3, 1e-6)))])
def test_same_answer_in_any_units(metre, newton):
    expected, other = column(1e-2), column(1e-2, metre, newton)
    assert other.tracer.first == pytest.approx(expected.tracer.first, rel=1e-6)
    for one, same in zip(found(expected), found(other), strict=True):
        assert same[:3] == one[:3]
        assert same[3] / newton == pytest.approx(one[3], rel=1e-8)


@pytest.mark.parametrize("control", [fx.ArcLength(step=0.01), fx.LoadControl(10.0, target=45.0)])
@pytest.mark.parametrize("depth", [pytest.param(1e-2, marks=pytest.mark.slow), 1e-4])
def test_first_step_over_many_critical_loads_is_cut(control, depth):
    """A step of a hundredth of the length would pass all loads up to 45; six lie there."""
    path = column(depth, control=control, load=45.0)
    kept = [p for state in path for p in state.critical]
    assert [p.load for p in kept] == pytest.approx([n * n for n in range(1, 7)], rel=4e-2)
    assert all(p.name == "stable symmetric" for p in kept)


@pytest.mark.slow
def test_slender_columns_on_two_processes():
    """Their critical points as on one process.

    Rounding in the axial force of the more slender one moves them: its first load is spread over 3e-5 by ten lengths of
    steps on one process.
    """
    script = """
from test_first_steps import column, found
for depth in (1e-2, 1e-5):
    print(*(f"{load:.9g}" for *_, load in found(column(depth))))
"""
    for line, depth in zip(on_two_processes(script), (1e-2, 1e-5), strict=True):
        both, alone = [float(word) for word in line.split()], [load for *_, load in found(column(depth))]
        assert both == pytest.approx(alone, rel=4e-5)


def test_displacement_control_has_a_first_step_in_any_units():
    scenes = [column(0.1, metre).scene for metre in (1.0, 1e3)]
    paths = [fx.Path(scene, fx.DisplacementControl(), fx.Until(steps=1)) for scene in scenes]
    one, other = (list(path)[1].load for path in paths)
    assert other == pytest.approx(one, rel=1e-8)


def test_paths_end_at_their_bounds():
    """Neither the last state nor critical points lie beyond."""
    for until, attribute, bound in ((fx.Until(load=5.0), "load", 5.0), (fx.Until(deflection=2e-4), "deflection", 2e-4)):
        path = fx.Path(column(1e-2).scene, fx.ArcLength(step=0.01), until)
        states = list(path)
        assert getattr(states[-1], attribute) == pytest.approx(bound, rel=1e-6)
        assert all(p.load <= states[-1].load for state in states for p in state.critical)
        assert path.message == f"{attribute} {bound:g} reached"


def test_refused_steps_keep_their_sound_part():
    """Beside the bifurcation of an arch that is a ten-thousandth off, where the path bends away (215 without).

    The limit load is the one that steps of any length find.
    """
    mesh = fx.read(lambda: fx.meshes.arc(3380.6, -0.128, 0.128, 40, {"crown": 0.0}), dimension=2, order=2)
    mesh = fx.imperfect(mesh, lambda x: 4.7625 * np.sin(pi * x[:, 0] / 431.0), 1e-4)
    scene = fx.Scene([fx.Beam(mesh, fx.Rectangle(25.4, 4.7625), fx.Elastic(72395.0))],
                     [fx.pin(mesh, "start"), fx.pin(mesh, "end")], [fx.PointForce(mesh, "crown", (0.0, -1.0))],
                     fx.Monitor(mesh, "crown", "y", -1.0))
    path = fx.Path(scene, fx.ArcLength(step=0.003), fx.Until(deflection=20.0))
    assert [load for *_, load in found(path)] == [pytest.approx(129.67, abs=0.01)]
    assert path.tracer.total_factorisations < 205
