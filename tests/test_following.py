"""Loads that follow the structure: which have a potential, all their bifurcations, and flutter."""

from __future__ import annotations

from math import cos, cosh, pi, sin, sinh, sqrt

import gmsh
import numpy as np
import pytest
from helpers import on_two_processes
from scipy.optimize import brentq

import sheetfx as fx

STEPS = (1 / 16, 1 / 4, 4.0, 16.0)


def points(scene, until, control=None):
    path = fx.Path(scene, control, until)
    return path, [p for state in path for p in state.critical]


def found(scene, until, control=None):
    """Kind, load and multiplicity of all critical points."""
    return [(p.kind, p.load, p.multiplicity) for p in points(scene, until, control)[1]]


def steps(scene):
    """Controls with multiples of the first step that is chosen for a scene."""
    first = fx.Path(scene).tracer.first
    return [fx.ArcLength(step=part * first) for part in STEPS]


def ring(load, quarters: int, cells: int = 20):
    """Part of a ring of radius 1 with EI = 1, pressed from outside by a load that grows to a pressure of 1.

    A half ring has symmetric ends; a whole one is held where its own symmetry holds it.
    """
    def build():
        geo, angles = gmsh.model.geo, [n * pi / 2 for n in range(quarters + (quarters < 4))]
        centre, ends = geo.addPoint(0, 0, 0), [geo.addPoint(cos(a), sin(a), 0) for a in angles]
        arcs = [geo.addCircleArc(ends[n], centre, ends[(n + 1) % len(ends)]) for n in range(quarters)]
        for arc in arcs:
            geo.mesh.setTransfiniteCurve(arc, cells + 1)
        geo.synchronize()
        gmsh.model.addPhysicalGroup(1, arcs, name="ring")
        for name, end in zip(("east", "north", "west"), ends, strict=False):
            gmsh.model.addPhysicalGroup(0, [end], name=name)

    mesh, depth = fx.read(build, 2), 0.01
    beam = fx.Beam(mesh, fx.Rectangle(1.0, depth), fx.Elastic(12 / depth**3))
    held = [("east", "y"), ("west", "y"), ("north", "x")] if quarters == 4 else [("east", "y rz"), ("west", "x y rz")]
    return fx.Scene([beam], [fx.Support(mesh, *where) for where in held], [load(beam)], fx.Monitor(mesh, "north", "y"))


def pressure(beam):
    return fx.LinePressure(beam, 1.0)


def suction(beam):
    return fx.LinePressure(beam, -1.0, side="positive")


def follower(beam):
    return fx.LineForce(beam, (0.0, 1.0), follower=True)


@pytest.mark.parametrize(("load", "size"), [(pressure, 1.0), (suction, 1.0), (follower, pi)])
def test_half_ring_under_pressure(load, size):
    """p R^3 / EI = n^2 - 1 for n = 2, 3, 4 (Levy 1884), but for a mesh error of h^2 that is the same for both loads."""
    scene = ring(load, 2)
    expected = [("bifurcation", (n * n - 1) * size, 1) for n in (2, 3, 4)]
    (kinds, loads, numbers) = zip(*found(scene, fx.Until(load=20 * size)), strict=True)
    assert (kinds, numbers) == tuple(zip(*expected, strict=True))[::2]
    assert loads == pytest.approx([load for _, load, _ in expected], rel=2e-3)


@pytest.mark.parametrize(("load", "size"), [(pressure, 1.0), (follower, 2 * pi)])
def test_whole_ring_under_pressure_buckles_in_pairs_of_modes(load, size):
    path, kept = points(ring(load, 4, 10), fx.Until(load=20 * size))
    assert [p.multiplicity for p in kept] == [2, 2, 2]
    assert [p.load for p in kept] == pytest.approx([3 * size, 8 * size, 15 * size], rel=6e-3)
    assert path.tracer.state.unstable_modes == 6


@pytest.mark.slow
@pytest.mark.parametrize("load", [pressure, follower])
@pytest.mark.parametrize("quarters", [2, 4])
def test_rings_with_other_first_steps(load, quarters):
    scene = ring(load, quarters, 10)
    until = fx.Until(load=20 * (quarters * pi / 2 if load is follower else 1.0))
    expected = found(scene, until)
    for control in steps(scene):
        _assert_same(found(scene, until, control), expected)


def _assert_same(ones, others, rel=1e-5):
    assert [(kind, number) for kind, _, number in ones] == [(kind, number) for kind, _, number in others]
    assert [load for _, load, _ in ones] == pytest.approx([load for _, load, _ in others], rel=rel)


@pytest.mark.slow
def test_rings_on_two_processes():
    script = '''
import sheetfx as fx
from test_following import follower, found, pressure, ring
for load, end in ((pressure, 12.0), (follower, 70.0)):
    print(*(f"{kind} {load:.6g} {number}" for kind, load, number in found(ring(load, 4, 10), fx.Until(load=end))))
'''
    lines = on_two_processes(script)
    for line, (load, end) in zip(lines, ((pressure, 12.0), (follower, 70.0)), strict=True):
        words = line.split()
        both = [(words[n], float(words[n + 1]), int(words[n + 2])) for n in range(0, len(words), 3)]
        _assert_same(both, found(ring(load, 4, 10), fx.Until(load=end)))


def test_line_pressure_is_refused_in_space():
    mesh = fx.read(lambda: fx.meshes.frame({"a": (0, 0, 0), "b": (1, 0, 0)}, {"beam": ("a", "b", 2)}), 3)
    with pytest.raises(ValueError, match="LinePressure: the mesh is in space.*LineForce"):
        fx.LinePressure(fx.Beam(mesh, fx.Rectangle(1, 1), fx.Elastic(1.0, 0.3)), 1.0)


def test_a_load_says_whether_it_has_a_potential():
    """Between free ends pressure has none; the path says so."""
    held = fx.Path(ring(pressure, 2))
    scene = ring(pressure, 2)
    mesh = scene.meshes[0]
    loose = fx.Path(fx.Scene(scene.parts, [fx.clamp(mesh, "east")], scene.loads, scene.monitor))
    words = "loads: LinePressure have a potential as the structure is supported: the tangent is symmetric"
    assert words in held.searched
    assert "loads: LinePressure have no potential: the tangent is not symmetric" in loose.searched


def column(load, supports, monitor="x", cells=10):
    """A slender column of length, EI and mass per length 1 along x, free or held at its tip."""
    depth = 0.005
    nodes = {"base": (0.0, 0.0), "tip": (1.0, 0.0)}
    mesh = fx.read(lambda: fx.meshes.frame(nodes, {"column": ("base", "tip", cells)}), 2)
    beam = fx.Beam(mesh, fx.Rectangle(1.0, depth), fx.Elastic(12 / depth**3, density=1 / depth))
    held = [fx.Support(mesh, at, fixed) for at, fixed in supports.items()]
    return fx.Scene([beam], held, [load(mesh, beam)], fx.Monitor(mesh, "tip", monitor))


CLAMPED, PINNED = {"base": "x y rz"}, {"base": "x y", "tip": "y"}


def beck(mesh, beam):
    return fx.FollowerForce(mesh, "tip", (-1.0, 0.0))


def along_axis(mesh, beam):
    return fx.LineForce(beam, (-1.0, 0.0), follower=True)


class Reut(fx.Load):
    """A force on the x axis that a rigid plate at the tip carries: as the tip moves, its moment about it grows."""

    conservative = False

    def __init__(self, mesh, beam):
        self.mesh = mesh

    def work(self, fields):
        u, angle = fields.displacement(self.mesh), fields.spin(self.mesh)
        work = -fields.vary(u[0]) - u[1] * fields.vary(angle)
        return fields.factor * work * self.mesh.facet_measure("tip")


def pflueger():
    return column(along_axis, PINNED, cells=20)


def test_pinned_column_under_distributed_follower_load_diverges():
    """q L^3 / EI = 18.956, 81.9, 189.1 (Pfluger 1950; Leipholz 1962), by a tangent that is not symmetric."""
    kept = found(pflueger(), fx.Until(load=250.0))
    assert [(kind, number) for kind, _, number in kept] == [("bifurcation", 1)] * 3
    assert [load for _, load, _ in kept] == pytest.approx([18.956, 81.9, 189.1], rel=1e-3)


@pytest.mark.slow
def test_pinned_column_with_other_first_steps():
    expected = found(pflueger(), fx.Until(load=250.0))
    for control in [*steps(pflueger()), fx.ArcLength(step=0.01)]:
        _assert_same(found(pflueger(), fx.Until(load=250.0), control), expected)


@pytest.mark.parametrize(("load", "critical"), [(beck, 20.05), (along_axis, 40.05), (Reut, 20.05)])
def test_clamped_columns_flutter(load, critical):
    """Beck 1952: 20.05; Leipholz 1962: 40.05; Reut's column is adjoint to Beck's (Bolotin 1963, section 1.5)."""
    kept = points(column(load, CLAMPED), fx.Until(load=1.2 * critical))[1]
    assert [(p.kind, p.name) for p in kept] == [("flutter", "begins")]
    assert kept[0].load == pytest.approx(critical, rel=1e-3)


@pytest.mark.slow
def test_flutter_with_other_first_steps():
    scene, until = column(beck, CLAMPED), fx.Until(load=25.0)
    expected = found(scene, until)
    for control in steps(scene):
        _assert_same(found(scene, until, control), expected)


@pytest.mark.slow
def test_flutter_on_two_processes():
    script = '''
import sheetfx as fx
from test_following import CLAMPED, beck, column, found
print(*(f"{kind} {load:.9g}" for kind, load, _ in found(column(beck, CLAMPED), fx.Until(load=25.0))))
'''
    kind, load = on_two_processes(script)[0].split()
    ((alone, expected, _),) = found(column(beck, CLAMPED), fx.Until(load=25.0))
    assert (kind, float(load)) == (alone, pytest.approx(expected, rel=1e-6))


def test_smallest_structure_under_a_load_that_follows():
    """Two elements, fewer unknowns than eigenvalues are asked for: Pfluger's column on a coarse mesh."""
    kept = found(column(along_axis, PINNED, cells=2), fx.Until(load=25.0))
    assert [(kind, number) for kind, _, number in kept] == [("bifurcation", 1)]
    assert kept[0][1] == pytest.approx(18.956, rel=0.05)


def becks_equation(load, frequency):
    """Zero for the frequencies of Beck's column (Beck 1952; Bolotin 1963, eq. 2.20), with EI, length and mass 1."""
    root = sqrt(load**2 / 4 + frequency**2)
    one, two = sqrt(root - load / 2), sqrt(root + load / 2)
    return (load**2 + 2 * frequency**2 * (1 + cosh(one) * cos(two)) + load * frequency * sinh(one) * sin(two))


@pytest.mark.slow
def test_frequencies_under_a_follower_force():
    """Both squares of frequencies of Beck's column up to where they meet, against the transcendental equation."""
    path = fx.Path(column(beck, CLAMPED), fx.LoadControl(0.1, target=20.0, fixed=True))
    checked = 0
    for state in path:
        if state.step % 40 == 20:
            grid = np.linspace(1.0, 30.0, 400)
            values = [becks_equation(state.load, w) for w in grid]
            exact = [brentq(lambda w, load=state.load: becks_equation(load, w), a, b)
                     for a, b, one, other in zip(grid[:-1], grid[1:], values[:-1], values[1:], strict=True)
                     if one * other < 0]
            got = [v.squared for v in fx.frequencies(path, state, 2)]
            assert got == pytest.approx([w**2 for w in exact[:2]], rel=1e-3)
            checked += 1
    assert checked == 5


def test_motions_grow_beyond_flutter():
    path = fx.Path(column(beck, CLAMPED), None, fx.Until(load=25.0))
    states = list(path)
    still, growing = (fx.frequencies(path, states[n], 1)[0] for n in (0, -1))
    assert still.growth == 0.0 and still.frequency == pytest.approx(3.516 / (2 * pi), rel=1e-3)
    assert growing.growth > 1.0 and growing.frequency > 1.0
    s = growing.growth + 2j * pi * growing.frequency
    assert abs(s * s + growing.squared.conjugate()) < 1e-9 * abs(s * s), "motions exp(s t) with s^2 = -omega^2"


def right_angle_frame(whole: bool, cells: int = 8):
    """Two slender strips at a right angle under moments about z at hinges that turn about z alone (Argyris 1979)."""
    reach = 240.0 / sqrt(2)
    nodes = {"apex": (0.0, 0.0, 0.0), "right": (reach, -reach, 0.0)}
    lines, moments = {"one": ("apex", "right", cells)}, {"right": 1.0}
    if whole:
        nodes["left"], lines["other"], moments["left"] = (-reach, -reach, 0.0), ("apex", "left", cells), -1.0
    mesh = fx.read(lambda: fx.meshes.frame(nodes, lines), 3)
    beam = fx.Beam(mesh, fx.Rectangle(0.6, 30.0), fx.Elastic(71240.0, 0.31), up=(0.0, 1.0, 0.0))
    held = [fx.Support(mesh, "right", "y z rx ry")]
    held += [fx.Support(mesh, "left", "x y z rx ry")] if whole else [fx.symmetry(mesh, "apex", "x")]
    loads = [fx.Moment(mesh, at, (0.0, 0.0, moment)) for at, moment in moments.items()]
    return fx.Scene([beam], held, loads, fx.Monitor(mesh, "apex", "y"))


def torsion_constant(width, depth):
    """Of a thin rectangle (Timoshenko and Goodier 1951, section 109)."""
    series = sum(np.tanh(n * pi * depth / (2 * width)) / n**5 for n in range(1, 40, 2))
    return width**3 * depth / 3 * (1 - 192 * width / (pi**5 * depth) * series)


def lateral_moment():
    """Of a strip under equal end moments, pi / L sqrt(EI GJ) (Simo and Vu-Quoc 1986: 622.2 for a thin one)."""
    bending, twist = 71240.0 * 30.0 * 0.6**3 / 12, 71240.0 / 2.62 * torsion_constant(0.6, 30.0)
    return pi / 240.0 * sqrt(bending * twist)


@pytest.mark.parametrize("whole", [False, True])
def test_frame_under_end_moments_buckles_sideways(whole):
    """Moments at hinges that turn about one axis have a potential: the half frame's modes are n times the first."""
    scene, hinges = right_angle_frame(whole), 2 if whole else 1
    path, kept = points(scene, fx.Until(load=hinges * 1300.0))
    assert path.discretisation.system.conservative
    half = right_angle_frame(False)
    mesh = half.meshes[0]
    other = fx.Path(half)
    antisymmetric = [half.supports[0], fx.Support(mesh, "apex", "y z rx")]
    loads = [lateral_moment(), 2 * lateral_moment()]
    loads += [b.load for b in fx.buckling(other, other.tracer.state, 6, supports=antisymmetric)
              if 0 < b.load < 1300.0] if whole else []
    assert [p.multiplicity for p in kept] == [1] * len(loads)
    assert [p.load for p in kept] == pytest.approx(sorted(hinges * load for load in loads), rel=1e-3)


@pytest.mark.slow
@pytest.mark.parametrize("whole", [False, True])
def test_frame_with_other_first_steps(whole):
    scene, until = right_angle_frame(whole), fx.Until(load=2500.0)
    expected = found(scene, until)
    for control in steps(scene):
        _assert_same(found(scene, until, control), expected)


@pytest.mark.slow
def test_columns_and_frames_on_two_processes():
    script = '''
import sheetfx as fx
from test_following import found, pflueger, right_angle_frame
for scene, end in ((pflueger(), 250.0), (right_angle_frame(False), 1300.0), (right_angle_frame(True), 2600.0)):
    print(*(f"{kind} {load:.9g} {number}" for kind, load, number in found(scene, fx.Until(load=end))))
'''
    scenes = (pflueger(), 250.0), (right_angle_frame(False), 1300.0), (right_angle_frame(True), 2600.0)
    for line, (scene, end) in zip(on_two_processes(script), scenes, strict=True):
        words = line.split()
        both = [(words[n], float(words[n + 1]), int(words[n + 2])) for n in range(0, len(words), 3)]
        _assert_same(both, found(scene, fx.Until(load=end)))


def test_free_moments_have_no_potential():
    """The same moment where the end of a leg turns about all axes."""
    scene = right_angle_frame(False)
    free = fx.Scene(scene.parts, [fx.clamp(scene.meshes[0], "apex")], scene.loads,
                    fx.Monitor(scene.meshes[0], "right", "y"))
    assert "loads: Moment have no potential: the tangent is not symmetric" in fx.Path(free).searched
