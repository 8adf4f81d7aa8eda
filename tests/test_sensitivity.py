"""Koiter's laws of imperfection sensitivity against traced paths of imperfect structures."""

from math import radians

import numpy as np
import pytest
from helpers import hinged_arch, whole_arch

from sheetfx.case import Case, trace
from sheetfx.continuation.control import ArcLength
from sheetfx.continuation.state import CriticalPoint
from sheetfx.mesh.imperfection import imperfect
from sheetfx.path import Until
from sheetfx.stability.sensitivity import imperfection_sensitivity, limit_of_imperfect

HALF, DEPTH = radians(7.338), 4.7625


def deviation(x):
    return np.sin(np.pi * np.arctan2(x[:, 0], x[:, 1]) / HALF)


def first_limit(scene):
    record = trace(Case(scene, ArcLength(0.005), Until(deflection=20.0)))
    return next(p.load for p in record.critical_points if p.kind == "limit")


def test_two_thirds_law():
    """Hinged shallow arch, which bends before it buckles sideways; the law's error falls with the imperfection."""
    mesh = whole_arch(40)
    record = trace(Case(hinged_arch(mesh), until=Until(deflection=10.0)))
    point = next(p for p in record.critical_points if p.kind == "bifurcation")

    def imperfect_arch(amplitude):
        return hinged_arch(imperfect(mesh, deviation, amplitude))

    before, after = record.states[point.step - 1: point.step + 1]
    rho = imperfection_sensitivity(record.path, before, after, point, imperfect_arch, 1e-3 * DEPTH)
    errors = []
    for amplitude in (0.01, 0.001):
        ratio = first_limit(imperfect_arch(amplitude * DEPTH)) / point.load
        law = limit_of_imperfect(point, amplitude * DEPTH, rho)
        errors.append(abs(law - ratio) / (1 - ratio))
    assert errors[0] < 0.03 and errors[1] < 0.3 * errors[0]


@pytest.mark.parametrize(("amplitude", "step"), [
    (1e-2, None), (1e-4, None), (1e-6, None), (1e-4, 4.672885757e-3), (3e-6, 2.871219167e-3), (3e-7, 3.142864521e-3)])
def test_the_path_of_a_slightly_imperfect_structure_bends_away(amplitude, step):
    """A step past the bifurcation lands on the path of the perfect structure (limit at 148.5), which is another branch.

    The load of the perfect arch's bifurcation, 129.761, is reached from below as the imperfection vanishes. The steps
    are those of 56 at random from which states on both paths were once taken for neighbours beside a bifurcation.
    """
    mesh = whole_arch(40)
    record = trace(Case(hinged_arch(imperfect(mesh, deviation, amplitude * DEPTH)), ArcLength(step),
                        Until(deflection=20.0)))
    (point,) = record.critical_points
    assert point.name == "maximum"
    # the perfect arch's point and sensitivity, as test_two_thirds_law finds them; the law is off by 4 % of the loss
    law = CriticalPoint("bifurcation", 129.761, 0.0, 1, slope=0.0, curvature=-2.0512e-3)
    assert point.load / law.load == pytest.approx(limit_of_imperfect(law, amplitude * DEPTH, 0.7352), abs=1e-3)
