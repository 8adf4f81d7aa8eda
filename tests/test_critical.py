"""Critical points are found wherever they lie in a step, to 1e-8, and named."""

from dataclasses import replace
from math import pi, sqrt

import numpy as np
import pytest
from helpers import hinged_arch, on_two_processes, ring_under_pressure, whole_arch

from sheetfx import meshes
from sheetfx.case import Case, trace
from sheetfx.continuation.control import ArcLength, LoadControl
from sheetfx.mesh.reader import read
from sheetfx.model.beam import Beam
from sheetfx.model.loads import PointForce
from sheetfx.model.scene import Monitor, Scene
from sheetfx.model.section import Elastic, Rectangle
from sheetfx.model.supports import Support, pin
from sheetfx.path import PathFailure, Until

STEPS = (*(pytest.param(times, marks=pytest.mark.slow) for times in (1 / 16, 1 / 4)), 1, 4, 16)


def pinned_arch(steps=12, step=0.01):
    """The shallow arch of the thesis on hinges, whole: bifurcations before limits, on a path that winds."""
    return Case(hinged_arch(whole_arch(40)), ArcLength(step), Until(deflection=100.0, steps=steps))


def column(depth=0.01, target=12.0, step=0.2, elements=40):
    """Pinned column of length 1 with EI = 1."""
    nodes, members = {"base": (0, 0), "top": (1, 0)}, {"column": ("base", "top", elements)}
    mesh = read(lambda: meshes.frame(nodes, members), 2)
    beam = Beam(mesh, Rectangle(1.0, depth), Elastic(12 / depth**3, 0.25))
    return Case(Scene([beam], [pin(mesh, "base"), Support(mesh, "top", "y")],
                      [PointForce(mesh, "top", (-1.0, 0.0))], Monitor(mesh, "top", "x", -1.0)),
                LoadControl(step, target=target))


def critical_column(depth, half_waves=1):
    """P (1 - P/EA + P/GA) = EI (n pi)^2 of the extensible, shear-flexible column (Reissner 1972, linearised)."""
    axial, shear = 12 / depth**2, 12 / depth**2 / 2.5 * 5 / 6
    slope = 1 / shear - 1 / axial
    return (sqrt(1 + 4 * slope * (half_waves * pi) ** 2) - 1) / (2 * slope)


def loads(points):
    return np.array([p.load for p in points])


@pytest.fixture(scope="module")
def arch():
    return trace(pinned_arch())


@pytest.mark.parametrize("depth", [0.1, 0.03, 0.01])
def test_column(depth):
    """Bifurcation off a straight path: the load within the error of the mesh, Koiter's b = pi^2 / 8."""
    (point,) = trace(column(depth)).critical_points
    assert (point.kind, point.multiplicity, point.name) == ("bifurcation", 1, "stable symmetric")
    assert point.load == pytest.approx(critical_column(depth), rel=2e-7)
    assert point.slope == 0
    if depth == 0.01:
        assert point.curvature == pytest.approx(pi**2 / 8, rel=1e-3)


def test_several_bifurcations_in_one_step():
    points = trace(column(target=400.0, step=400.0)).critical_points
    assert [p.name for p in points] == 6 * ["stable symmetric"]
    exact = np.array([critical_column(0.01, n) for n in range(1, 7)])
    assert loads(points) == pytest.approx(exact, rel=2e-4)  # six half waves on 40 elements
    assert [p.curvature for p in points[:3]] == pytest.approx([(n * pi) ** 2 / 8 for n in (1, 2, 3)], rel=0.02)


def test_kinds_names_and_order(arch):
    """Along the winding path of the hinged arch each extremum of the load is found, and what lies between."""
    found = [(p.kind, p.name) for p in arch.critical_points]
    assert found[:4] == [("bifurcation", "unstable symmetric"), ("limit", "maximum"),
                         ("bifurcation", "unstable symmetric"), ("limit", "minimum")]


@pytest.mark.parametrize("times", STEPS)
@pytest.mark.slow(quick=1)
def test_points_do_not_depend_on_steps(arch, times):
    case = pinned_arch(int(12 / times) + 12, 0.01 * times)
    found = trace(case).critical_points
    count = min(len(found), len(arch.critical_points))
    assert count >= 4
    for one, other in zip(found[:count], arch.critical_points, strict=False):
        assert (one.kind, one.name) == (other.kind, other.name)
        assert one.load == pytest.approx(other.load, rel=1e-8)
        curvatures = [point.curvature or 0.0 for point in (one, other)]
        assert curvatures[0] == pytest.approx(curvatures[1], rel=1e-3)  # the state may be 1e-6 off the path


@pytest.mark.slow
def test_points_after_a_restart_from_any_step(arch):
    for kept in range(1, len(arch.states)):
        record = trace(pinned_arch(), start=arch.states[:kept])
        assert loads(record.critical_points) == pytest.approx(loads(arch.critical_points), rel=1e-8)


def test_points_on_two_processes(arch):
    lines = on_two_processes("""
from test_critical import pinned_arch
from sheetfx.case import trace
for p in trace(pinned_arch()).critical_points:
    print(p.kind, p.load)""")
    found = [line.split() for line in lines]
    assert [kind for kind, _ in found] == [p.kind for p in arch.critical_points]
    assert [float(load) for _, load in found] == pytest.approx(list(loads(arch.critical_points)), rel=1e-8)


def test_the_state_of_a_point_is_kept_or_had_again(arch):
    """The search of a path has it; a path that resumes behind the point finds it anew, of bifurcations but for what
    rounding moves it along the mode (over 864 mm).
    """
    resumed = trace(pinned_arch(), start=arch.states)
    assert set(arch.path.critical_states) == set(arch.critical_points) and not resumed.path.critical_states
    for point in arch.critical_points:
        kept, again = arch.state_at(point), resumed.state_at(point)
        assert kept is arch.path.critical_states[point] and again is not kept
        assert (kept.load, again.load) == pytest.approx((point.load, point.load), rel=1e-7)
        off = max(np.abs(values - again.fields[name]).max() for name, values in kept.fields.items())
        assert off < (1e-8 if point.kind == "limit" else 1e-3)


def test_a_step_that_jumps_over_limits_is_seen():
    """One step along the whole path of a snap: the load rises at both its ends, without an unstable direction."""
    case = pinned_arch()
    half = replace(case, scene=replace(case.scene, supports=[*case.scene.supports, Support(
        case.scene.parts[0].mesh, "crown", "x rz")]), control=ArcLength(0.2), until=Until(deflection=80.0))
    points = [p for p in trace(half).critical_points if p.kind == "limit"]
    assert [p.name for p in points][:2] == ["maximum", "minimum"]


def test_ring_under_pressure_that_follows_it():
    """Unsymmetric tangent: by the sign of its determinant. p = 3 EI / R^3 (Levy 1884), but for (depth / R)^2."""
    (point,) = trace(Case(ring_under_pressure(), LoadControl(1.7, target=5.0))).critical_points
    assert (point.kind, point.multiplicity) == ("bifurcation", 1)
    assert point.load / (pi / 2) == pytest.approx(3.0, rel=1e-4)


def test_load_control_stops_at_the_limit():
    """Its iteration converges behind the snap too; the step that does is noticed."""
    case = replace(pinned_arch(), control=LoadControl(30.0, target=400.0), until=Until())
    half = replace(case, scene=replace(case.scene, supports=[*case.scene.supports, Support(
        case.scene.parts[0].mesh, "crown", "x rz")]))
    with pytest.raises(PathFailure, match="does not converge") as failure:
        trace(half)
    assert failure.value.record.states[-1].load == pytest.approx(148.496, rel=2e-3)
