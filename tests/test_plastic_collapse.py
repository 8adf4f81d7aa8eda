"""Collapse of frames, of bars that touch and of welded sections by plastic hinges, against limit analysis."""

from __future__ import annotations

from dataclasses import replace
from math import asin, sqrt

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
@pytest.mark.slow(quick=1)
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
@pytest.mark.slow(quick=1)
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


def plastic_bar(deflection, diameter):
    """Force on the middle of a bar held at both ends over that of three hinges, which also stretch as it sags.

    Its neutral axis is half the deflection off the middle of each hinge; moment and force of the rest of a circle about
    that chord (rigid, perfectly plastic).
    """
    h = deflection / diameter
    moment, force = (1 - h**2) ** 1.5, 1.5 * (asin(h) + h * sqrt(1 - h**2))
    return moment + force * h


@pytest.mark.slow
def test_two_round_bars_that_touch_collapse_together():
    """The tip of a cantilever comes down on the middle of a clamped bar: M_p / L_1 + 4 M_p / L_2, then a catenary.

    Hinges lie 0.21 cells from clamps and contact, which makes bars 1.0 % shorter, the lower one at both ends.
    """
    length, half, diameter, gap, cells = 600.0, 800.0, 20.0, 0.5, 20
    upper = fx.read(lambda: meshes.frame({"clamp": (-length, diameter), "tip": (0, diameter)},
                                         {"bar": ("clamp", "tip", cells)}), 2)
    lower = fx.read(lambda: meshes.frame({"left": (-half, 0), "middle": (0, 0), "right": (half, 0)},
                                         {"one": ("left", "middle", cells), "other": ("middle", "right", cells)}), 2)
    steel = fx.Plastic(200e3, 0.3, yield_stress=2.35)
    beams = [fx.Beam(mesh, fx.round_bar(diameter, 20), steel) for mesh in (upper, lower)]
    touch = fx.PairContact(upper, "tip", (lower, None), toward=(0.0, -1.0), gap=gap, reach=diameter, stiffness=1e6)
    moment = 2.35 * diameter**3 / 6
    scene = fx.Scene(beams, [fx.clamp(upper, "clamp"), fx.clamp(lower, "left"), fx.clamp(lower, "right")],
                     [fx.PointForce(upper, "tip", (0.0, -1.0))], fx.Monitor(upper, "tip", "y", -1.0), joints=[touch])
    states = list(fx.Path(scene, fx.DisplacementControl(0.1), fx.Until(deflection=12.0)))
    shorter = 1 - 0.21 / cells
    alone = [s.load for s in states if 0.45 < s.deflection < gap]
    assert alone[-1] == pytest.approx(moment / length / shorter, rel=1e-2)
    for state in (s for s in states if s.deflection > 1.0):
        sag = state.deflection - gap
        expected = moment / length / shorter + 4 * moment / half / shorter * plastic_bar(sag, diameter)
        assert state.load == pytest.approx(expected, rel=1.5e-2)


@pytest.mark.slow
def test_a_tee_of_two_welded_shells_collapses():
    """A cantilever, free to contract across at its clamp: M_p / L about the axis that halves the area of both shells.

    The first of Gauss's points lie 0.21 cells, 1.1 % of the length, from the clamp; cells half as long leave 1.1 %,
    twice as many across of degree 3 0.8 %.
    """
    length, width, depth, thickness, strength = 1000.0, 80.0, 80.0, 4.0, 2.35
    flange = fx.read(lambda: meshes.rectangle((20, 8), (length, width)), 3, 2,
                     lambda x: np.column_stack((x[:, 0], x[:, 1] - width / 2, 0 * x[:, 0])))
    web = fx.read(lambda: meshes.rectangle((20, 4), (length, depth)), 3, 2,
                  lambda x: np.column_stack((x[:, 0], 0 * x[:, 0], x[:, 1] - depth)))
    steel, plate = fx.Plastic(200e3, 0.3, yield_stress=strength), fx.Plate(thickness, points=5, rule="simpson")
    shells = [fx.Shell(mesh, plate, steel, form="naghdi-q2") for mesh in (flange, web)]
    supports = [fx.Support(flange, "west", "x ry rz"), fx.Support(web, "west", "x ry rz"),
                fx.Support(web, "north-west", "y z"), fx.Support(web, "south-west", "y")]
    scene = fx.Scene(shells, supports, [fx.EdgeForce(web, "east", (0.0, 0.0, -1.0 / depth))],
                     fx.Monitor(web, "north-east", "z", -1.0), joints=[fx.weld(web, "north", (flange, None))])
    *_, before, last = fx.Path(scene, fx.DisplacementControl(0.03), fx.Until(deflection=0.6))
    z = np.linspace(-depth, thickness / 2, 200_001)
    widths = width * (np.abs(z) <= thickness / 2) + thickness * (z <= 0)
    axis = z[np.searchsorted(np.cumsum(widths), widths.sum() / 2)]
    moment = strength * np.trapezoid(widths * np.abs(z - axis), z)
    assert last.load == pytest.approx(before.load, rel=5e-3)
    assert moment / length < last.load < 1.025 * moment / length
