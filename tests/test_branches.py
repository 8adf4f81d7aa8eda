"""Branches of simple bifurcations, and of a symmetric double one, against closed forms."""

from dataclasses import replace
from math import pi, radians

import numpy as np
import pytest
from helpers import buckled_column, follow, hinged_arch, on_two_processes, ring_under_pressure, started, whole_arch
from scipy.integrate import solve_bvp
from scipy.interpolate import CubicSpline
from scipy.optimize import minimize_scalar
from scipy.special import ellipk

from sheetfx import meshes
from sheetfx.case import trace
from sheetfx.continuation.control import ArcLength, LoadControl
from sheetfx.critical.branches import branches
from sheetfx.critical.modes import mode_displacement
from sheetfx.mesh.imperfection import imperfect
from sheetfx.mesh.reader import read
from sheetfx.model.beam import Bar
from sheetfx.model.loads import PointForce
from sheetfx.model.scene import Monitor, Scene
from sheetfx.model.section import Elastic, Rectangle
from sheetfx.model.supports import Support, pin
from sheetfx.path import Path, Until
from sheetfx.scenes import plate_buckling, roorda_frame, sinusoidal_arch
from sheetfx.show.curves import draw_branches


def swaying_arch(mesh):
    return follow(hinged_arch(mesh), ArcLength(step=0.003), 8.0)


@pytest.fixture(scope="module")
def planar_column():
    return buckled_column(2)


@pytest.fixture(scope="module")
def perfect_arch():
    return swaying_arch(whole_arch(20))


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
        assert [s.unstable_modes for s in states] == [0, 0]
        assert states[0].deflection == pytest.approx(-states[1].deflection, rel=1e-9)
        assert states[0].load == pytest.approx(states[1].load, rel=1e-12)
        quotients.append((states[0].load / point.load - 1) / states[0].deflection**2)
    assert (4 * quotients[1] - quotients[0]) / 3 == pytest.approx(pi**2 / 8, rel=1e-3)


def test_halves_of_an_unstable_bifurcation(perfect_arch):
    """The arch sways to either side with one unstable mode, under a falling load, and equally."""
    point, found = started(perfect_arch, 0.02)
    left, right = (branch.start for branch in found)
    assert left.load == pytest.approx(right.load, rel=1e-5)
    assert left.unstable_modes == right.unstable_modes == 1
    assert left.load < point.load and left.load_rate < 0 and right.load_rate < 0
    assert found[0].mode == pytest.approx(-found[1].mode)


@pytest.mark.parametrize("record, amplitude", [("planar_column", 0.05), ("perfect_arch", 0.01)])
def test_initial_curvature_of_branches(record, amplitude, request):
    """Koiter's a and b of the critical point, from states on both halves; the extrapolation leaves O(xi^4)."""
    record, slopes, curvatures = request.getfixturevalue(record), [], []
    for size in (amplitude, amplitude / 2):
        point, found = started(record, size)
        xi = found[0].amplitude
        ahead, behind = (branch.start.load / point.load - 1 for branch in found)
        slopes.append((ahead - behind) / (2 * xi))
        curvatures.append((ahead + behind) / (2 * xi**2))
    assert (4 * curvatures[1] - curvatures[0]) / 3 == pytest.approx(point.curvature, rel=1e-4)
    assert slopes[1] == pytest.approx(point.slope, abs=1e-3 * abs(curvatures[1]) * xi)


def test_limit_loads_of_imperfect_arches(perfect_arch):
    """With the mode as imperfection they fall by its power 2/3 (Koiter 1945); the next term is smaller by 2 %."""
    point, found = started(perfect_arch)
    mesh = perfect_arch.case.scene.parts[0].mesh
    shape = mode_displacement(perfect_arch.path, mesh, found[0])
    losses = []
    for amplitude in (0.01, 0.08):
        limit = swaying_arch(imperfect(mesh, shape, amplitude)).critical_points[0]
        assert limit.kind == "limit"
        losses.append(1 - limit.load / point.load)
    assert np.log(losses[1] / losses[0]) / np.log(8) == pytest.approx(2 / 3, abs=0.01)


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


def stayed_column(planar: bool, offset: float = 0.0):
    """Upright bar of length 1 with three horizontal stays of length 1 and stiffness 1 at equal angles.

    With a rigid bar the energy at a sideways displacement x towards one anchor is 3/4 x^2 + 3/8 x^3 - P x^2 / 2 to
    the third order: the branch P = 3/2 (1 + 3/4 x) is asymmetric, and the bifurcation double unless it is planar.
    """
    nodes = {"base": (0, 0, 0), "top": (0, 0, 1)}
    nodes |= {f"anchor{i}": (np.cos(turn), np.sin(turn), 1) for i, turn in enumerate(np.radians([0, 120, 240]))}
    members = {"column": ("base", "top", 1)} | {f"stay{i}": ("top", f"anchor{i}", 1) for i in range(3)}
    mesh = read(lambda: meshes.frame(nodes, members), 3)
    if offset:
        mesh = imperfect(mesh, lambda x: np.outer(np.all(np.isclose(x, (0, 0, 1)), axis=1), (1, 0, 0)), offset)
    bars = [Bar(mesh, Rectangle(1.0, 1.0), Elastic(1e4 if name == "column" else 1.0), group=name) for name in members]
    supports = [pin(mesh, name) for name in nodes if name != "top"] + [Support(mesh, "top", "y")] * planar
    scene = Scene(bars, supports, [PointForce(mesh, "top", (0.0, 0.0, -1.0))], Monitor(mesh, "top", "x"))
    return follow(scene, ArcLength(0.01) if offset else LoadControl(step=0.7, target=1.9), 0.2 if offset else None)


@pytest.mark.parametrize("planar, ways", [(True, 1), (False, 3)])
def test_initial_slope_of_branches(planar, ways):
    """3/4 by the closed form but for the strain of the bar, 1.5e-4; the mean of both halves leaves O(x^2)."""
    point, found = started(stayed_column(planar), 0.002)
    slopes = np.sort([(branch.start.load / point.load - 1) / branch.amplitude for branch in found])
    assert len(slopes) == 2 * ways
    assert (slopes[ways:] - slopes[:ways]) / 2 == pytest.approx(0.75, rel=1e-3)
    if planar:
        assert point.name == "asymmetric" and abs(point.slope) == pytest.approx(0.75, rel=3e-4)
        assert sorted(branch.start.unstable_modes for branch in found) == [0, 1]


def test_branch_between_two_bifurcations_of_an_arch():
    """On it the thrust stays that of buckling in two half waves: load = alpha + 3 b is linear in the crown's height b.

    See the scene for the units. With b^2 + 4 a^2 = alpha^2 - 4 the sway a grows, then falls to the second bifurcation,
    where the load is least. 1e-3: the arch is shallow, not flat.
    """
    alpha, depth = 2.8, 0.1
    case = sinusoidal_arch.case(alpha, depth)
    record = trace(case)
    first, second = (p.load for p in record.critical_points if p.kind == "bifurcation")
    _, found = started(record)
    states = [found[0].start]
    for state in Path(case.scene, case.control, start=states):
        states.append(state)
        height = alpha - state.deflection * np.sqrt(12) / (2 * depth)
        assert state.load == pytest.approx(alpha + 3 * height, abs=1e-3 * first)
        if height < -np.sqrt(alpha**2 - 4) + 0.05:
            break
    assert len(states) > 5 and all(np.diff([s.load for s in states]) < 0)
    assert states[-1].load == pytest.approx(second, abs=0.2)


def test_branches_of_roordas_frame():
    """One half rises and is stable, the other falls and is not; the slope is Koiter's a of the critical point."""
    record = trace(roorda_frame.case())
    point, found = started(record, 0.01)
    rises = [(branch.start.load / point.load - 1) / branch.amplitude for branch in found]
    assert (rises[0] - rises[1]) / 2 == pytest.approx(np.sign(rises[0]) * abs(point.slope), rel=1e-3)
    assert [branch.start.unstable_modes for branch in found] == [int(rise < 0) for rise in rises]


def pressure_on_ring(deflection: float) -> float:
    """Pressure on a ring of radius 1 and bending stiffness 1 whose crown has moved inwards, by collocation.

    Balance of an inextensible bar of curvature k under a pressure p that follows it: k'' = k (c - k^2 / 2) + p.
    """
    def rates(s, y, constants):
        k, slope, angle = y[:3]
        c, pressure = constants
        return np.vstack([slope, k * (c - k * k / 2) + pressure, k, np.cos(angle), -np.sin(angle)])

    def ends(a, b, constants):
        return np.array([a[1], b[1], a[2], b[2] - pi / 2, a[3], b[4], a[4] - (1 - deflection)])

    s = np.linspace(0, pi / 2, 40)
    bend = 3 * deflection
    guess = np.vstack([1 - bend * np.cos(2 * s), 2 * bend * np.sin(2 * s), s - bend * np.sin(2 * s) / 2, np.sin(s),
                       np.cos(s)])
    solution = solve_bvp(rates, ends, s, guess, p=[-2.5, 3.0], tol=1e-9, max_nodes=20000)
    assert solution.success
    return solution.p[1]


def test_branches_under_a_load_that_follows():
    """A ring in two half waves under pressure: the rise of the load above 3 EI / R^3.

    2e-3: the ring is strained by 2.5e-5 before it buckles, which is 3e-4 of its deflection and 6e-4 of the rise.
    """
    record = follow(ring_under_pressure(), LoadControl(1.7, target=5.0))
    point, found = started(record, 0.1)
    assert sorted(np.sign(branch.start.deflection) for branch in found) == [-1, 1]
    for branch in found:
        rise = pressure_on_ring(branch.start.deflection) / 3 - 1
        assert branch.start.load / point.load - 1 == pytest.approx(rise, rel=2e-3)


def limit_of_stayed_column(offset: float) -> float:
    """Limit load of a rigid bar whose top stands `offset` further from one anchor, by its exact geometry."""
    anchors = np.array([(np.cos(turn), np.sin(turn)) for turn in np.radians([0, 120, 240])])
    whole = np.linalg.norm(anchors + (offset, 0), axis=1)

    def load(x):
        height = np.sqrt(1 + offset**2 - x * x)
        lengths = np.sqrt(((anchors + (x, 0)) ** 2).sum(axis=1) + (height - 1) ** 2)
        rates = (x + anchors[:, 0] - (height - 1) * x / height) / lengths
        return float(((lengths - whole) / whole * rates).sum()) * height / x

    return -minimize_scalar(lambda x: -load(x), bounds=(offset, 0.3), method="bounded", options={"xatol": 1e-9}).fun


@pytest.mark.parametrize("offset", [1e-3, 4e-3])
def test_limit_load_of_an_imperfect_asymmetric_structure(offset):
    """By the exact geometry of a rigid bar; asymptotically Koiter's half-power law 1 - 2 (3/4 offset)^(1/2)."""
    limit = next(p for p in stayed_column(True, -offset).critical_points if p.kind == "limit")
    assert limit.load == pytest.approx(limit_of_stayed_column(offset), rel=3e-4)
    assert 1 - limit.load / 1.5 == pytest.approx(2 * np.sqrt(0.75 * offset), rel=0.03)


def test_branches_of_a_plate():
    """A square plate in compression: Koiter's b from states on the branch of a shell."""
    case = plate_buckling.case(cells=3, slenderness=100.0)
    record = trace(replace(case, control=LoadControl(step=2.6, target=5.2), until=Until()))
    values = []
    for amplitude in (0.004, 0.002):
        point, found = started(record, amplitude)
        assert [branch.start.unstable_modes for branch in found] == [0, 0]
        values.append((found[0].start.load / point.load - 1) / found[0].amplitude**2)
    assert (4 * values[1] - values[0]) / 3 == pytest.approx(point.curvature, rel=2e-4)


def test_picture_of_branches(planar_column):
    """Branches begin at the bifurcation; stable pieces are drawn apart from unstable ones."""
    point, found = started(planar_column)
    control = ArcLength(0.05)
    paths = [(point, [b.start, *Path(planar_column.case.scene, control, Until(deflection=0.2), start=[b.start])])
             for b in found]
    lines = [line for line in draw_branches(planar_column, paths).axes[0].lines if len(line.get_xdata()) > 1]
    starts = [line.get_xydata()[0] for line in lines]
    assert np.allclose(starts[0], (point.deflection, point.load)) and np.allclose(starts[1], starts[0])
    assert len({line.get_color() for line in lines}) == 2


def test_branches_on_two_processes(planar_column):
    lines = on_two_processes("""
from helpers import buckled_column, started
for branch in started(buckled_column(2))[1]:
    print(branch.start.load, abs(branch.start.deflection), branch.start.unstable_modes)""")
    _, found = started(planar_column)
    expected = [[b.start.load, abs(b.start.deflection), b.start.unstable_modes] for b in found]
    assert [[float(c) for c in line.split()] for line in lines] == [pytest.approx(row, rel=1e-8) for row in expected]


def test_limit_points_have_no_branches(planar_column):
    point = planar_column.critical_points[0]
    with pytest.raises(ValueError, match="the path itself goes on"):
        branches(planar_column.path, planar_column.states, type(point)("limit", 1.0, 0.0, 1))
    with pytest.raises(ValueError, match="give the states of the whole path"):
        branches(planar_column.path, planar_column.states[:1], point)
    with pytest.raises(ValueError, match="amplitude is -1"):
        branches(planar_column.path, planar_column.states, point, amplitude=-1.0)
    short = [replace(state, increment=state.increment[:-1]) for state in planar_column.states]
    with pytest.raises(ValueError, match="give states of this path"):
        branches(planar_column.path, short, point)

