"""Branches of bifurcations against closed forms."""

from math import pi, radians

import numpy as np
import pytest
from helpers import follow
from scipy.interpolate import CubicSpline
from scipy.special import ellipk

from sheetfx import meshes
from sheetfx.mesh.reader import read
from sheetfx.path import Path, Until
from sheetfx.scene import Beam, Monitor, PointForce, Scene, Support, pin
from sheetfx.section import Elastic, Rectangle
from sheetfx.solve.branches import branches
from sheetfx.solve.control import ArcLength, LoadControl


def column(dimension: int, width: float = 0.01, elements: int = 8):
    """Pinned column of length 1 with its first bifurcation, at about 8.2."""
    nodes = {"base": (0, 0), "middle": (0.5, 0), "tip": (1, 0)}
    members = {"lower": ("base", "middle", elements), "upper": ("middle", "tip", elements)}
    model = read(lambda: meshes.frame(nodes, members), dimension)
    beam = Beam(model, Rectangle(width, 0.01), Elastic(1e9), shear_rigidity=1e3)
    supports = [pin(model, "base"), Support(model, "tip", "y")]
    if dimension == 3:
        supports = [Support(model, "base", "x y z rx"), Support(model, "tip", "y z")]
    force = (-1.0, 0.0, 0.0)[:dimension]
    scene = Scene([beam], supports, [PointForce(model, "tip", force)], Monitor(model, "middle", "y"))
    return follow(scene, LoadControl(step=3.0, target=10.0))


@pytest.fixture(scope="module")
def planar_column():
    return column(2)


def started(record, amplitude=0.05, number=0):
    bifurcations = [p for p in record.critical_points if p.kind == "bifurcation"]
    point = bifurcations[number]
    return point, branches(record.path, record.states, point, amplitude)


def test_both_halves_of_a_pitchfork(planar_column):
    """The column bends to either side, stable, with P = Pc (1 + pi^2/8 (w / L)^2 + ...) of the elastica.

    The error of the quotient is of the order w^2 and vanishes in the extrapolation; 0.1 %: axial strain (8e-5) and
    elements.
    """
    quotients = []
    for amplitude in (0.1, 0.05):
        point, found = started(planar_column, amplitude)
        states = [branch.start for branch in found]
        assert [branch.family for branch in found] == [False, False]
        assert [s.unstable for s in states] == [0, 0]
        assert states[0].deflection == pytest.approx(-states[1].deflection, rel=1e-9)
        assert states[0].load == pytest.approx(states[1].load, rel=1e-12)
        quotients.append((states[0].load / point.load - 1) / states[0].deflection**2)
    assert (4 * quotients[1] - quotients[0]) / 3 == pytest.approx(pi**2 / 8, rel=1e-3)


def test_paths_go_on_from_branches(planar_column):
    """Away from the bifurcation, to the deflection of the elastica; w / L = 0.3597 at end angles of 80 degrees.

    Timoshenko and Gere 1961, section 2.7: the sine of half the end angle is the modulus p of P / Pc = (2 K / pi)^2 and
    w / L = p / K.
    """
    modulus = np.sin(radians(40))
    quarter = ellipk(modulus**2)
    point, found = started(planar_column)
    for branch in found:
        path = Path(planar_column.case.scene, ArcLength(0.03, largest=1.0), Until(deflection=modulus / quarter),
                    start=[branch.start])
        states = [branch.start, *path]
        curve = CubicSpline([abs(s.deflection) for s in states], [s.load for s in states])
        assert curve(modulus / quarter) / point.load == pytest.approx((2 * quarter / pi) ** 2, rel=1e-4)


def test_column_that_may_bend_in_any_direction():
    """The double bifurcation of a square column has one family of branches, in all directions."""
    record = column(3)
    point, found = started(record)
    assert point.multiplicity == 2
    assert len(found) == 1 and found[0].family
    loads = [started(column(2))[1][0].start.load, found[0].start.load]
    assert loads[0] == pytest.approx(loads[1], rel=1e-5)


def test_limit_points_have_no_branches(planar_column):
    point = planar_column.critical_points[0]
    with pytest.raises(ValueError, match="the path itself goes on"):
        branches(planar_column.path, planar_column.states, type(point)("limit", 1.0, 0.0, 1))
    with pytest.raises(ValueError, match="give the states of the whole path"):
        branches(planar_column.path, planar_column.states[:1], point)
