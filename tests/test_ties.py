"""Ties at random places: never stiffer than full compatibility, and with more of them never softer."""

from __future__ import annotations

import warnings

import gmsh
import numpy as np
import pytest
from test_interface import bar, panel, response

import sheetfx as fx

MAKERS = fx.weld, fx.hinge, fx.bolt
FORCE = np.array([0.2, -0.5, 1.0])


def compliance(joints, curved=False, cells=2):
    """Work of a force at the end of a rib along the edge of a panel whose other end is clamped."""
    def place(x):
        return x + np.outer(x[:, 0] * (1 - x[:, 0]), (0.0, 0.1, 0.2)) if curved else x

    order = 1 + curved
    skin = fx.read(lambda: fx.meshes.rectangle((cells, cells), (1.0, 1.0)), 3, order, place)
    ends = {"a": (0, 0, 0), "b": (1, 0, 0)}
    rib = fx.read(lambda: fx.meshes.frame(ends, {"rib": ("a", "b", cells)}), 3, order, place)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)
        scene = fx.Scene([fx.Shell(skin, fx.Plate(0.05), fx.Elastic(1.0, 0.3), form="naghdi-q2"),
                          fx.Beam(rib, fx.Rectangle(0.05, 0.1), fx.Elastic(2.0, 0.3), degree=2, up=(0.0, 0.0, 1.0))],
                         [fx.clamp(skin, "west")], [fx.PointForce(rib, "b", tuple(FORCE))],
                         fx.Monitor(rib, "b", "z"), joints=joints(skin, rib))
    places, motions = response(scene)[rib][0]
    return motions[np.argmin(np.linalg.norm(places - np.array([1.0, 0.0, 0.0]), axis=1))] @ FORCE


def ties(seed, curved):
    """Joints of random numbers of ties: places along the edge, lengths from a thousandth of it, distances from it."""
    random = np.random.default_rng(seed)
    count = 7
    lengths = 10 ** random.uniform(-3, -0.3, count)
    starts = random.uniform(0, 1, count) * (1 - lengths)
    inside = random.choice([0.0, 1e-7, 1e-4, 1e-2, 0.1], count)
    make = MAKERS[seed % 3]

    def place(x, y):
        bow = x * (1 - x)
        return (x, y + 0.1 * bow, 0.2 * bow) if curved else (x, y, 0.0)

    def joints(m, skin, rib):
        ways = zip(starts, inside, lengths, strict=True)
        at = [fx.Stretch(place(x, y), place(x + length, y)) for x, y, length in ways]
        return [fx.weld(skin, at[:1], (rib, None), reach=1.0),
                *([make(skin, at[1:m], (rib, None), reach=1.0)] if m > 1 else [])]

    return [lambda skin, rib, m=m: joints(m, skin, rib) for m in (1, 2, 4, 7)]


@pytest.mark.silent("stiff")
@pytest.mark.parametrize(("seed", "curved"), [(0, False), (1, True), *(pytest.param(
    seed, curved, marks=pytest.mark.slow) for seed in range(2, 12) for curved in (False, True))])
@pytest.mark.slow(quick=1)
def test_more_ties_are_stiffer_and_none_more_than_one_mesh(seed, curved):
    """Rounding: what the ends of a tie of a hundredth of a cell hold differs by so much, and others stand for them."""
    full = compliance(lambda skin, rib: [fx.Compatible(rib, skin)], curved)
    found = [compliance(joints, curved) for joints in ties(seed, curved)]
    assert np.all(np.diff(found) <= 1e-4 * full), "softer by a further tie"
    assert np.min(found) >= full * (1 - 1e-6), "stiffer than with all nodes in common"


def test_ties_on_what_is_shared_or_held_hold_nothing_more():
    """Beside nodes that two meshes have in common, and beside clamps, by a millionth of the panel."""
    def both(skin, rib):
        near = fx.Stretch((0.3, 1e-6, 0.0), (0.6, 1e-6, 0.0))
        return [fx.Compatible(rib, skin), fx.weld(skin, near, (rib, None), reach=1e-5)]

    assert compliance(both) == pytest.approx(compliance(lambda skin, rib: [fx.Compatible(rib, skin)]), rel=1e-9)


def test_ties_beside_a_seam_stay_on_their_panel():
    """Two panels of one mesh whose edges are at one place, with nothing in common, on a bar that runs along these."""
    def panels():
        geo = gmsh.model.geo
        for side in (1, -1):
            points = [geo.addPoint(x, y * side, 0) for x, y in ((0, 0), (1, 0), (1, 1), (0, 1))]
            lines = [geo.addLine(points[i], points[(i + 1) % 4]) for i in range(4)]
            panel = geo.addPlaneSurface([geo.addCurveLoop(lines)])
            geo.synchronize()
            for line in lines:
                gmsh.model.mesh.setTransfiniteCurve(line, 4)
            gmsh.model.mesh.setTransfiniteSurface(panel)
            gmsh.model.addPhysicalGroup(2, [panel], name=f"panel {side}")

    skins, rib = fx.read(panels, 3), bar((0.0, 0.0, 0.0), (1.0, 0.0, 0.0), 4)
    for side in (1, -1):
        way = fx.Stretch((0.1, 1e-3 * side, 0.0), (0.9, 3e-3 * side, 0.0))
        one, two = fx.weld(skins, way, (rib, None), reach=0.01).meeting.sides
        assert one.places == pytest.approx(two.places, abs=1e-12)
        assert np.isin(one.cells, skins.group(f"panel {side}")).all()


def test_ties_shorter_than_half_a_cell_are_told():
    """Once for each kind, at the line that makes the scene; of two parts the larger cells count."""
    skin, rib = panel((2, 2)), bar((0.0, 0.5, 0.0), (1.0, 0.5, 0.0), 10)
    parts = [fx.Shell(skin, fx.Plate(0.1), fx.Elastic(1.0)), fx.Beam(rib, fx.Rectangle(0.1, 0.1), fx.Elastic(1.0))]
    rest = [fx.clamp(skin, "west")], [fx.PointForce(rib, "end", (0.0, 0.0, 1.0))], fx.Monitor(rib, "end", "z")

    def told(make, *lengths):
        at = [fx.Stretch((0.1, 0.5, 0.0), (0.1 + length, 0.5, 0.0)) for length in lengths]
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            fx.Scene(parts, *rest, joints=[make(skin, at, (rib, None))])
        assert all(w.filename == __file__ for w in caught)
        return [str(w.message) for w in caught]

    assert told(fx.weld, 0.26) == []
    (one,) = told(fx.hinge, 0.2)
    assert one.startswith("hinge from (0.1, 0.5, 0.0): its length 0.2 is less than half of the cell of 0.5 that")
    assert "Give cells of at most 0.4 there" in one
    (two,) = told(fx.weld, 0.2, 0.3, 0.24)
    assert "weld from (0.1, 0.5, 0.0) (the shortest of 2): its length 0.2 is less" in two
