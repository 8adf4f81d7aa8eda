"""Branches of multiple bifurcations and of clusters: none is missed."""

from math import comb, pi

import numpy as np
import pytest
from helpers import buckled_column, follow, started
from truss import Truss

from sheetfx import meshes
from sheetfx.case import trace
from sheetfx.continuation.control import LoadControl
from sheetfx.critical.branches import zeros_around
from sheetfx.mesh.reader import read
from sheetfx.model.beam import Beam
from sheetfx.model.joints import Spring
from sheetfx.model.loads import PointForce
from sheetfx.model.scene import Monitor, Scene
from sheetfx.model.section import Elastic, Rectangle
from sheetfx.model.supports import Support, pin
from sheetfx.scenes import star_dome


def test_column_that_may_bend_in_any_direction():
    """The double bifurcation of a square column has one family of branches, as bent as that in a plane."""
    record = buckled_column(3)
    point, found = started(record)
    assert point.multiplicity == 2
    assert len(found) == 1 and found[0].family
    for critical, (branch, *_) in (started(buckled_column(2)), (point, found)):
        assert (branch.start.load / critical.load - 1) / branch.amplitude**2 == pytest.approx(pi**2 / 8, rel=2e-3)


def test_two_bifurcations_close_together():
    """A column whose section is deeper by 1e-4 than it is wide bends in one plane, then in the other."""
    record = buckled_column(3, 0.010001)
    points = [p for p in record.critical_points if p.kind == "bifurcation"]
    assert points[1].load / points[0].load == pytest.approx(1.0001**2, rel=1e-6)
    for number, (share, unstable) in enumerate([(0, 0), (1, 1)]):
        point, found = started(record, number=number)
        assert [b.start.unstable_modes for b in found] == [unstable, unstable]
        for branch in found:
            assert abs(branch.start.deflection) == pytest.approx(share * branch.amplitude, rel=1e-3, abs=1e-9)
            assert (branch.start.load / point.load - 1) / branch.amplitude**2 == pytest.approx(pi**2 / 8, rel=2e-3)


def columns(count: int, joints=lambda mesh: []):
    """Equal pinned columns side by side, all with the same load."""
    nodes, members = {}, {}
    for i in range(count):
        base, middle, tip = f"base{i}", f"middle{i}", f"tip{i}"
        nodes |= {base: (0, i), middle: (0.5, i), tip: (1, i)}
        members |= {f"lower{i}": (base, middle, 4), f"upper{i}": (middle, tip, 4)}
    mesh = read(lambda: meshes.frame(nodes, members), 2)
    beam = Beam(mesh, Rectangle(0.01, 0.01), Elastic(1e9))
    supports = [s for i in range(count) for s in (pin(mesh, f"base{i}"), Support(mesh, f"tip{i}", "y"))]
    loads = [PointForce(mesh, f"tip{i}", (-1.0, 0.0)) for i in range(count)]
    scene = Scene([beam], supports, loads, Monitor(mesh, "middle0", "y"), joints=joints(mesh))
    return follow(scene, LoadControl(step=3.0, target=10.0))


@pytest.mark.parametrize("force, zeros", [
    (lambda a: np.sin(6 * a), np.arange(12) * pi / 6), (lambda a: np.cos(a) - 0.999, [0.04473, 2 * pi - 0.04473]),
    (lambda a: 1 - np.cos(a - 2.0), [2.0]), (lambda a: 1 + np.cos(a) / 2, [])])
def test_zeros_around_a_circle(force, zeros):
    """Simple ones, two between neighbouring samples, a double one, and none."""
    angles = 0.1 + 2 * pi * np.arange(48) / 48
    found = np.mod(zeros_around(force, angles, force(angles)), 2 * pi)
    assert np.exp(1j * np.sort(found)) == pytest.approx(np.exp(1j * np.array(zeros)), abs=1e-4)


@pytest.mark.parametrize("count", [2, pytest.param(3, marks=pytest.mark.slow)])
def test_every_branch_of_a_multiple_bifurcation(count):
    """Each column stays straight or bends to either side, those that bend equally: 3^n - 1 half-branches.

    With k columns bent at amplitude 1, each has 1 / sqrt(k), and the load has risen by 1 / k of that with one bent.
    """
    point, found = started(columns(count))
    assert point.multiplicity == count
    assert len(found) == 3**count - 1
    rises = np.sort([branch.start.load / point.load - 1 for branch in found])[::-1]
    expected = [1 / k for k in range(1, count + 1) for _ in range(2**k * comb(count, k))]
    assert rises / rises[0] == pytest.approx(expected, rel=2e-3)


@pytest.mark.slow
def test_nearly_double_bifurcation_keeps_its_branches():
    """Two columns that a spring joins, which parts their loads by 4e-8: eight half-branches, and no continuum.

    The forces that single out directions fall with the cube of the amplitude; at 1e-3 they look like those of a
    continuum, of which one branch was given in the place of eight.
    """
    _, found = started(columns(2, lambda mesh: [Spring(mesh, "middle0", "y", 1e-6, (mesh, "middle1"))]))
    assert len(found) == 8 and not any(branch.family for branch in found)
    assert sum(not branch.doubt for branch in found) >= 4, "those on which both columns bend"


@pytest.fixture(scope="module")
def dome():
    """The star dome up to its first bifurcation and a little further, and the same truss for numpy."""
    case = star_dome.case(to=11.0)
    nodes, members = star_dome.dome()
    names = list(nodes)
    free = [i for i, name in enumerate(names) if not name.startswith("outer")]
    bars = np.array([[names.index(end) for end in ends] for ends in members.values()])
    load = np.array([[0.0, 0.0, -(names[i] == "apex")] for i in free])
    truss = Truss(np.array(list(nodes.values())), bars, free, load)
    return trace(case), truss, [names[i] for i in free]


def displacements(record, state, names):
    """Displacements of named nodes, one in each row."""
    record.show(state)
    mesh = record.case.scene.parts[0].mesh
    kinematics = record.path.discretisation.kinematics(mesh)
    return np.array([kinematics.displacement(mesh, name) for name in names])


def test_branches_of_the_star_dome(dome):
    """Twelve half-branches, 30 degrees apart and of two kinds; their starts are equilibria of the truss in numpy."""
    record, truss, names = dome
    point, found = started(record)
    assert point.multiplicity == 2
    angles = np.sort([np.degrees(np.arctan2(*branch.direction)) for branch in found])
    assert np.diff(angles) == pytest.approx(30.0, abs=1e-3)
    assert sorted(branch.start.unstable_modes for branch in found) == [1] * 6 + [2] * 6
    for branch in found:
        moves = displacements(record, branch.start, names)
        assert truss.equilibrium(branch.start.factor * truss.load, moves) == pytest.approx(moves, abs=1e-9)


def test_no_branch_of_the_star_dome_is_missed(dome):
    """At 0.99 of the load of the bifurcation there are as many equilibria beside the path, found by numpy alone."""
    record, truss, names = dome
    point, found = started(record)
    load = 0.99 * point.load * truss.load
    path = truss.equilibrium(load, displacements(record, record.nearest(0.99 * point.load), names))
    modes = np.linalg.eigh(truss.derivatives(path)[1])[1][:, :2]
    others = []
    for size in (0.3, 0.5, 0.7):
        for angle in np.radians(np.arange(0, 360, 5)):
            sway = size * modes @ (np.cos(angle), np.sin(angle))
            other = truss.equilibrium(load, path + sway.reshape(path.shape))
            if other is not None and all(np.linalg.norm(other - known) > 1e-6 for known in [path, *others]):
                others.append(other)
    assert len(others) == len(found)
    unstable = [int((np.linalg.eigvalsh(truss.derivatives(other)[1]) < 0).sum()) for other in others]
    assert sorted(unstable) == sorted(branch.start.unstable_modes for branch in found)
