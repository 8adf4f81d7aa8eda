"""Collapse of frames by plastic hinges against the mechanisms of limit analysis."""

from __future__ import annotations

from dataclasses import replace
from math import sqrt

import numpy as np
import pytest
from helpers import follow

import sheetfx as fx
from sheetfx import meshes

HEIGHT, SPAN, DEPTH, YIELD = 1.0, 2.0, 0.02, 1e-5  # yield strain: geometry hardly changes before collapse
PLASTIC_MOMENT = YIELD * DEPTH**3 / 4  # modulus 1


def portal(horizontal, vertical, cells=20):
    """A portal frame on clamps, under a force at its left corner and one in the middle of its beam."""
    nodes = {"left": (0, 0), "corner": (0, HEIGHT), "middle": (SPAN / 2, HEIGHT), "other": (SPAN, HEIGHT),
             "right": (SPAN, 0)}
    names = list(nodes)
    mesh = fx.read(lambda: meshes.frame(nodes, {
        f"{one} to {two}": (one, two, cells) for one, two in zip(names, names[1:], strict=False)}), 2)
    beam = fx.Beam(mesh, fx.Rectangle(DEPTH, DEPTH, points=20), fx.Plastic(1.0, 0.0, yield_stress=YIELD))
    forces = {"corner": (horizontal, 0), "middle": (0, -vertical)}
    loads = [fx.PointForce(mesh, at, tuple(PLASTIC_MOMENT / HEIGHT * c for c in f)) for at, f in forces.items()]
    monitor = fx.Monitor(mesh, "corner", "x") if horizontal else fx.Monitor(mesh, "middle", "y", -1.0)
    return fx.Scene([beam], [fx.clamp(mesh, "left"), fx.clamp(mesh, "right")], loads, monitor)


@pytest.mark.parametrize(("horizontal", "vertical", "factor"), [
    pytest.param(0, 1, 4.0, marks=pytest.mark.slow, id="beam"),
    pytest.param(1, 0, 4.0, marks=pytest.mark.slow, id="sway"),
    pytest.param(1, 1, 3.0, id="combined")])
def test_portal_frame_collapses(horizontal, vertical, factor):
    """Beam V L / 2 = 4 M_p, sway H h = 4 M_p, both H h + V L / 2 = 6 M_p (Neal 1977, chapter 3), for L = 2 h.

    Hinges form at points of quadrature, up to 0.2 cells from corners and force: as if members were 2 % shorter at most;
    twenty fibres give a moment that is 0.2 % too large.
    """
    record = follow(portal(horizontal, vertical), fx.DisplacementControl(step=1e-3), deflection=2e-3)
    *_, before, last = record.states
    assert last.factor == pytest.approx(before.factor, rel=2e-3)
    assert factor < last.factor < factor * 1.025


def steel(points, nodes, supports, at, force, monitor, section=None, cells=12):
    """Members from node to node of a perfectly plastic material, a metre long (N, mm)."""
    names = list(nodes)
    mesh = fx.read(lambda: meshes.frame(nodes, {
        f"{one} to {two}": (one, two, cells) for one, two in zip(names, names[1:], strict=False)}), 2)
    section = replace(section or fx.Rectangle(10.0, 40.0), points=points)
    beam = fx.Beam(mesh, section, fx.Plastic(200e3, 0.3, yield_stress=235.0))
    return fx.Scene([beam], [support(mesh, name) for name, support in supports.items()],
                    [fx.PointForce(mesh, at, force)], fx.Monitor(mesh, at, *monitor))


def held_across(mesh, name):
    return fx.Support(mesh, name, "y")


@pytest.mark.parametrize("points", [3, 5, 6, 10, 20])
def test_propped_cantilever_collapses_with_any_number_of_fibres(points):
    """A hinge at the clamp, one under the force: P L / 2 = 3 M_p (Neal 1977) for hinges there, with M_p of the fibres.

    They lie 0.21 cells towards the other support. The slope of the beam in the end adds 0.7 %. With an even number all
    fibres of a hinge flow, with an odd one that in the middle does not.
    """
    cells, half = 6, 500.0
    scene = steel(points, {"clamp": (0, 0), "middle": (half, 0), "end": (2 * half, 0)},
                  {"clamp": fx.clamp, "end": held_across}, "middle", (0.0, -1.0), ("y", -1.0), cells=cells)
    *_, last = fx.Path(scene, fx.DisplacementControl(1.5), fx.Until(deflection=60.0))
    places, weights = np.polynomial.legendre.leggauss(points)
    moment = 235.0 * 10 * 40**2 / 4 * (weights @ np.abs(places))
    arm = half * (1 - 0.21 / cells)
    assert last.deflection == pytest.approx(60.0)
    assert last.load == pytest.approx(moment * (2 + half / arm) / arm, rel=1.5e-2)


@pytest.mark.parametrize("points", [3, 5])
def test_a_column_folds_at_its_foot(points):
    """Of a tube: P = M_p / w, w the deflection across of a rigid member of the length above the hinge.

    The hinge lies 0.21 cells above the clamp; fibres of three and five on a quarter give M_p within 1 %.
    """
    scene = steel(points, {"foot": (0, 0), "tip": (3, 1000)}, {"foot": fx.clamp}, "tip", (0.0, -1.0), ("y", -1.0),
                  fx.Tube(60.0, 5.0), cells=8)
    *_, last = fx.Path(scene, fx.ArcLength(0.02), fx.Until(deflection=200.0))
    moment, length = 235.0 * (60.0**3 - 50.0**3) / 6, 1000 * (1 - 0.21 / 8)
    assert last.deflection == pytest.approx(200.0)
    assert last.load == pytest.approx(moment / sqrt(length**2 - (length - 200.0) ** 2), rel=2e-2)


def test_a_bar_flows_as_a_whole():
    """Its length grows at the yield force, though each cell could grow alone."""
    scene = steel(5, {"clamp": (0, 0), "tip": (1000, 0)}, {"clamp": fx.clamp}, "tip", (1.0, 0.0), ("x",))
    *_, last = fx.Path(scene, fx.DisplacementControl(0.5), fx.Until(deflection=20.0))
    assert last.load == pytest.approx(235.0 * 400, rel=1e-3) and last.deflection == pytest.approx(20.0)
