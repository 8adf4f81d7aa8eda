"""Branches start on their first piece, before secondary critical points, or say that they may not.

A mast on a hinge is held by two pairs of horizontal stays of length 1, of stiffness 1 along x and of another one along
y. With a rigid mast the energy follows from its geometry: stays across the sway stiffen the branch, and those along it
lose their hold across, so that it soon has a bifurcation where the stiffnesses are nearly equal.
"""

import re
from dataclasses import replace

import numpy as np
import pytest
from helpers import follow, on_two_processes
from scipy.optimize import brentq

from sheetfx import meshes
from sheetfx.continuation.control import ArcLength, LoadControl
from sheetfx.critical.branches import branches
from sheetfx.mesh.reader import read
from sheetfx.model.beam import Bar
from sheetfx.model.loads import PointForce
from sheetfx.model.scene import Monitor, Scene
from sheetfx.model.section import Elastic, Rectangle
from sheetfx.model.supports import pin
from sheetfx.path import Path, Until

TURNING = 1.5, 0.825  # stiffness across, and height, where the load soon turns on the branch
MASTS = *((1 + nearness, 2.0) for nearness in (0.05, 1e-3, 3e-6)), TURNING


def stayed_mast(across: float, height: float, stiffness: float = 1e6):
    """Path through the bifurcations of a mast, whose bar is so much stiffer than the stays."""
    top = {"east": (1, 0), "west": (-1, 0), "north": (0, 1), "south": (0, -1)}
    nodes = {"base": (0, 0, 0), "top": (0, 0, height)} | {name: (*place, height) for name, place in top.items()}
    members = {"mast": ("base", "top", 1)} | {name: ("top", name, 1) for name in top}
    rigidities = {"mast": stiffness * height, "east": 1.0, "west": 1.0, "north": across, "south": across}
    mesh = read(lambda: meshes.frame(nodes, members), 3)
    bars = [Bar(mesh, Rectangle(1.0, 1.0), Elastic(value), group=name) for name, value in rigidities.items()]
    scene = Scene(bars, [pin(mesh, name) for name in nodes if name != "top"],
                  [PointForce(mesh, "top", (0.0, 0.0, -1.0))], Monitor(mesh, "top", "x"))
    return follow(scene, LoadControl(step=0.7 * height, target=2.2 * across * height))


class RigidMast:
    """The same mast with a rigid bar, by its exact geometry."""

    def __init__(self, across: float, height: float):
        self.across, self.height = across, height

    def rates(self, x: float, y: float) -> tuple[float, float]:
        """Loads that hold a sway, times its components: the stays' energy changes by them as the top goes down."""
        z = np.sqrt(self.height**2 - x * x - y * y)
        total = np.zeros(2)
        for ax, ay, k in ((1, 0, 1.0), (-1, 0, 1.0), (0, 1, self.across), (0, -1, self.across)):
            arm = np.array([x - ax, y - ay, z - self.height])
            length = np.linalg.norm(arm)
            total += k * (length - 1) / length * (arm[:2] * z - arm[2] * np.array([x, y]))
        return total

    def load(self, x: float) -> float:
        """On the branch along x."""
        return self.rates(x, 0.0)[0] / x

    def secondary(self) -> float:
        """Sway along x at which the branch along x has no stiffness across."""
        small = 1e-6
        return brentq(lambda x: self.rates(x, small)[1] / small - self.load(x), 1e-4, 0.4)

    def limit(self) -> float:
        """Sway along x at which the load is stationary."""
        return brentq(lambda x: self.load(x + 1e-5) - self.load(x - 1e-5), 0.01, 0.5)


@pytest.mark.parametrize("nearness", [0.05, 0.01, 1e-3, 3e-6])
def test_starts_before_a_secondary_bifurcation(nearness):
    """Stable as the primary branch is; the secondary bifurcation at a sway of about (2/5 nearness)^(1/2).

    3e-4 of the sway: interpolation between the last steps; the bar is strained by 2e-6 only.
    """
    record = stayed_mast(1 + nearness, 2.0)
    point, sway = record.critical_points[0], RigidMast(1 + nearness, 2.0).secondary()
    assert sway == pytest.approx((0.4 * nearness) ** 0.5, rel=0.05)
    for branch in record.branches(point):
        assert branch.doubt == "" and branch.start.unstable_modes == 0 and branch.start.load > point.load
        assert sway / 4 < abs(branch.start.deflection) < sway
    if nearness > 1e-3:
        path = Path(record.case.scene, ArcLength(sway / 20), Until(deflection=1.2 * sway), start=[branch.start])
        (secondary,) = (p for state in path for p in state.critical)
        assert secondary.kind == "bifurcation" and abs(secondary.deflection) == pytest.approx(sway, rel=3e-4)


@pytest.mark.slow
def test_starts_on_two_processes():
    """The same points on the branches, and the same doubts, if any."""
    lines = on_two_processes("""
from test_first_piece import MASTS, stayed_mast
for mast in MASTS:
    record = stayed_mast(*mast)
    for branch in record.branches(record.critical_points[0]):
        start = branch.start
        print(f"{start.load:.12g} {abs(start.deflection):.12g}", start.unstable_modes, branch.doubt, sep=",")""")
    found = []
    for mast in MASTS:
        record = stayed_mast(*mast)
        found += record.branches(record.critical_points[0])
    for line, branch in zip(lines, found, strict=True):
        *numbers, doubt = line.split(",", 3)
        start = branch.start
        alone = [start.load, abs(start.deflection), start.unstable_modes]
        assert [float(n) for n in " ".join(numbers).split()] == pytest.approx(alone, rel=1e-8)
        assert doubt == branch.doubt == ""


@pytest.mark.parametrize("stiffness", [1e4, 1e5, 1e6])
def test_critical_point_whose_tangent_is_singular_to_the_last_digit(stiffness):
    """Koiter's b is (across - 1 / height^2) / 2 but for the strain, however stiff the bar.

    The straight mast's tangent is diagonal: at the bifurcation a pivot may vanish exactly.
    """
    point = stayed_mast(1.05, 2.0, stiffness).critical_points[0]
    assert point.name == "stable symmetric"
    assert point.curvature == pytest.approx(0.4, rel=20 / stiffness + 1e-5)


def test_starts_before_a_limit():
    """The load of the primary branch rises, then falls; 1e-3: strain of 2e-6 beside a b of about 0.02."""
    record = stayed_mast(*TURNING)
    point, sway = record.critical_points[0], RigidMast(*TURNING).limit()
    assert point.name == "stable symmetric"
    for branch in record.branches(point):
        assert branch.doubt == "" and abs(branch.start.deflection) < sway and branch.start.load_rate > 0
    path = Path(record.case.scene, ArcLength(sway / 20), Until(deflection=1.2 * sway), start=[branch.start])
    (limit,) = (p for state in path for p in state.critical)
    assert limit.name == "maximum" and abs(limit.deflection) == pytest.approx(sway, rel=1e-3)


@pytest.mark.parametrize("changes, words", [
    ({"name": "unstable symmetric"}, "0 unstable modes, where .* have 1"),
    ({"curvature": -1.0}, "against Koiter's b of -1")])
def test_starts_that_contradict_their_point_are_doubted(changes, words):
    """A point whose type is wrong: no amplitude can agree with it, and the branches say so."""
    record = stayed_mast(2.0, 2.0)
    point = replace(record.critical_points[0], **changes)
    found = branches(record.path, record.states, point)
    assert len(found) == 2
    for branch in found:
        assert re.search(words, branch.doubt)
