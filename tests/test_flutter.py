"""Flutter where frequencies coincide that do not act on each other: in two planes, beside torsion, on rings."""

from __future__ import annotations

from dataclasses import dataclass
from math import pi

import numpy as np
import pytest
from helpers import on_two_processes
from scipy.optimize import brentq
from test_following import follower, ring, steps

import sheetfx as fx
from sheetfx.critical.vibration import is_complex

BECK = 20.046  # of the mesh below in one plane; Beck 1952: 20.05
BED = 0.05  # stiffness of the foundation that carries a ring


@dataclass(frozen=True)
class Strip(fx.Rectangle):
    """Rectangle of a material of modulus E and density, whose cantilever of length 1 has a given torsional frequency.

    Attributes
    ----------
    torsional : square of the lowest frequency of torsion; the next ones are 9, 25, ... times it
    """

    torsional: float = 1e3
    shear_modulus: float = 1.0
    density: float = 1.0

    @property
    def torsion(self):
        return self.torsional * 4 / pi**2 * self.density * sum(self.second_moments) / self.shear_modulus


def column(ratio: float, torsional: float, up=(0.0, 0.0, 1.0), spring: float = 0.0):
    """Beck's column in space with EI, length and mass per length 1 in one plane, and EI a ratio of it in the other.

    Parameters
    ----------
    up : direction of the depth of the section
    spring : stiffness against motion of the tip along y
    """
    nodes = {"base": (0.0, 0.0, 0.0), "tip": (1.0, 0.0, 0.0)}
    mesh = fx.read(lambda: fx.meshes.frame(nodes, {"column": ("base", "tip", 8)}), 3)
    depth, width = 0.01, 0.01 * ratio**0.5
    density, material = 1 / (width * depth), fx.Elastic(12 / (width * depth**3), 0.3, density=1 / (width * depth))
    section = Strip(width, depth, torsional=torsional, shear_modulus=material.shear_modulus, density=density)
    return fx.Scene([fx.Beam(mesh, section, material, up=up)], [fx.clamp(mesh, "base")],
                    [fx.FollowerForce(mesh, "tip", (-1.0, 0.0, 0.0))], fx.Monitor(mesh, "tip", "x"),
                    joints=[fx.Spring(mesh, "tip", "y", spring)] if spring else [])


def found(scene, end: float, control=None) -> list[tuple[str, float, int]]:
    return [(f"{p.kind} {p.name}", p.load, p.multiplicity) for state in fx.Path(scene, control, fx.Until(load=end))
            for p in state.critical]


@pytest.mark.parametrize("torsional", [
    3.0, 60.0, *(pytest.param(t, marks=pytest.mark.slow) for t in (12.36, 121.3, 400.0))])
def test_torsion_beside_bending(torsional):
    """Whatever frequencies torsion has, those of bending meet as in one plane, at 121.3, twice.

    With 3 seven squares of torsion lie below the second one of bending, 12.36 is the first one of bending.
    """
    ((what, load, number),) = found(column(1.0, torsional), 30.0)
    assert (what, number) == ("flutter begins", 2)
    assert load == pytest.approx(BECK, rel=1e-4)


@pytest.mark.parametrize("ratio", [1.001, 1.1, pytest.param(1.5, marks=pytest.mark.slow)])
def test_planes_that_flutter_one_after_the_other(ratio):
    """Each plane at its own load, however near; shear in the deeper direction changes 4e-4."""
    points = found(column(ratio, 60.0), 20.05 * ratio + 10)
    assert [(what, number) for what, _, number in points] == 2 * [("flutter begins", 1)]
    assert [load for _, load, _ in points] == pytest.approx([BECK, ratio * BECK], rel=5e-4)


SKEW = 2.61, 196.2, (0.0, 0.622, 0.783), 1.53  # spring that couples bending in two planes, whose frequencies cross


@pytest.mark.slow
def test_short_interval_of_flutter_within_a_step():
    """Frequencies of two planes that cross are coupled by a spring: they meet, part again, and others meet.

    Two steps lead to the end; `frequencies` has complex squares between these loads alone.
    """
    names, loads, _ = zip(*found(column(*SKEW), 30.0), strict=True)
    assert names == ("flutter begins", "flutter ends", "flutter begins")
    assert loads[1] - loads[0] < 1.0
    path, near = fx.Path(column(*SKEW), fx.LoadControl(0.25, target=loads[-1] + 0.5, fixed=True)), []
    for state in path:
        if min(abs(state.load - load) for load in loads) < 0.3:
            pairs = sum(is_complex(v.squared) for v in fx.frequencies(path, state, 12))
            near.append((state.load, pairs))
    assert len(near) > 5
    assert [pairs for _, pairs in near] == [int(loads[0] < load < loads[1] or load > loads[2]) for load, _ in near]


@pytest.mark.slow
def test_coupled_planes_with_other_first_steps():
    scene = column(*SKEW)
    names, loads, _ = zip(*found(scene, 30.0), strict=True)
    for control in steps(scene):
        others = found(scene, 30.0, control)
        assert [name for name, *_ in others] == list(names)
        assert [load for _, load, _ in others] == pytest.approx(loads, rel=1e-6)


@pytest.mark.slow
def test_coupled_planes_on_two_processes():
    lines = on_two_processes("""
from test_flutter import SKEW, column, found
for name, load, number in found(column(*SKEW), 30.0):
    print(f"{name},{load:.12g},{number}")""")
    both, alone = [line.split(",") for line in lines], found(column(*SKEW), 30.0)
    assert [(name, int(number)) for name, _, number in both] == [(name, number) for name, _, number in alone]
    assert [float(load) for _, load, _ in both] == pytest.approx([load for _, load, _ in alone], rel=1e-7)


def bedded_ring():
    """A ring of mass per length 1 on a foundation alone, under forces that turn with it and have no potential."""
    scene = ring(follower, 4)
    beam = fx.Beam(scene.parts[0].mesh, fx.Rectangle(1.0, 0.01), fx.Elastic(12 / 0.01**3, density=100.0))
    return fx.Scene([beam], [], [follower(beam)], scene.monitor, joints=[fx.Foundation(beam, (BED, BED))])


def test_waves_of_a_ring_do_not_flutter():
    """All frequencies coincide in pairs on the whole way through three double bifurcations.

    omega^2 (n^2 + 1) / n^2 = (n^2 - 1) (n^2 - 1 - p) + k (n^2 + 1) / n^2 of inextensible rings with EI, R and mass 1
    (Levy 1884; Love 1927, section 293); the mesh error is that of rings without mass.
    """
    waves = np.arange(2, 5)
    loads = waves**2 - 1 + BED * (waves**2 + 1) / (waves**2 * (waves**2 - 1))
    kinds, found_loads, numbers = zip(*found(bedded_ring(), 2 * pi * 20.0), strict=True)
    assert (kinds, numbers) == (3 * ("bifurcation ",), (2, 2, 2))
    assert [load / (2 * pi) for load in found_loads] == pytest.approx(loads, rel=2e-3)
    path = fx.Path(bedded_ring(), fx.LoadControl(0.5, target=1.0))
    *_, state = path
    squares = [v.squared for v in fx.frequencies(path, state, 9)]
    pressed = waves**2 * (waves**2 - 1) * (waves**2 - 1 - state.load / (2 * pi)) / (waves**2 + 1) + BED
    assert squares[:3] == pytest.approx(3 * [BED], rel=1e-4)
    assert squares[3:] == pytest.approx(np.repeat(pressed, 2), rel=3e-3)


@pytest.mark.parametrize("end, expected", [(8.0, ["begins"]), (16.0, ["begins", "ends"])])
@pytest.mark.slow
def test_stiff_rods_on_springs(end, expected):
    """Ziegler's pendulum of two rods: M q'' + K q = 0 in two angles, whose squares meet, and part again below zero.

    The rods are stiffer than the springs by 4e3 (1e-3: their bending) and have squares up to 1e10, so that rounding
    moves those that meet: states at the ends of short pieces told points that their modes did not show.
    """
    length, stiffness, mass, modulus = 1.0, 2.0, 0.03, 1e9
    rods = [fx.read(lambda x=x: fx.meshes.frame({"start": (x, 0.0), "end": (x + length, 0.0)},
                                                {"rod": ("start", "end", 2)}), 2) for x in (0.0, length)]
    one, two = rods
    scene = fx.Scene([fx.Beam(m, fx.Rectangle(0.1, 0.1), fx.Elastic(modulus, 0.0, density=3.0)) for m in rods],
                     [fx.pin(one, "start")], [fx.FollowerForce(two, "end", (-1.0, 0.0))], fx.Monitor(two, "end", "x"),
                     joints=[fx.hinge(one, "end", (two, "start")), fx.Spring(one, "start", "rz", stiffness),
                             fx.Spring(one, "end", "rz", stiffness, (two, "start"))])
    inertia = mass * (length**2 / 3 + 0.1**2 / 12)
    masses = np.array([[inertia + mass * length**2, mass * length**2 / 2], [mass * length**2 / 2, inertia]])

    def discriminant(load):
        tangent = np.array([[2 * stiffness - load, load - stiffness], [-stiffness, stiffness]])
        squares = np.linalg.eigvals(np.linalg.solve(masses, tangent)).astype(complex)
        return ((squares[0] - squares[1]) ** 2).real

    exact = [brentq(discriminant, 2.0, 7.0), brentq(discriminant, 7.0, 14.0)]
    points = found(scene, 20.0, fx.LoadControl(step=0.6, target=end))
    assert [(what, number) for what, _, number in points] == [(f"flutter {name}", 1) for name in expected]
    assert [load for _, load, _ in points] == pytest.approx(exact[:len(expected)], rel=1e-3)


@pytest.mark.parametrize("bed", [pytest.param(0.0, marks=pytest.mark.slow), 100.0])
def test_squares_that_meet_are_one_point_however_stiff_the_rest_is(bed):
    """Beck's column is slender and shear-rigid: its stiffest squares are orders of magnitude above those that meet.

    Rounding parts and joins these several times within 1e-7 of the load, which were so many points. A foundation adds
    the same to both squares and leaves the load as it is (Smith and Herrmann 1972).
    """
    depth = 0.005
    mesh = fx.read(lambda: fx.meshes.frame({"base": (0.0, 0.0), "tip": (1.0, 0.0)}, {"column": ("base", "tip", 24)}), 2)
    beam = fx.Beam(mesh, fx.Rectangle(1.0, depth), fx.Elastic(12 / depth**3, density=1 / depth), shear_rigidity=1e3)
    scene = fx.Scene([beam], [fx.clamp(mesh, "base")], [fx.FollowerForce(mesh, "tip", (-1.0, 0.0))],
                     fx.Monitor(mesh, "tip", "y"), joints=[fx.Foundation(beam, (0.0, bed))] if bed else [])
    ((what, load, number),) = found(scene, 30.0, fx.LoadControl(0.5, target=40.0))
    assert (what, number) == ("flutter begins", 1)
    assert load == pytest.approx(20.051, rel=1e-4)
