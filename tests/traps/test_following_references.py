"""The loads of traps whose loads follow the structure, by closed forms and by means of scipy alone."""

from __future__ import annotations

from math import cos, cosh, pi, sin, sinh, sqrt

import numpy as np
import pytest
from scipy.optimize import brentq, minimize_scalar
from scipy.special import jv
from test_mode_references import loads, zeros


def test_column_under_following_axial_forces():
    """M'' + q (1 - x) M = 0 with M = 0 at both ends: J_1/3 (2/3 sqrt q) = 0."""
    found = zeros(lambda q: jv(1 / 3, 2 / 3 * sqrt(q)), 1.0, 200.0)
    assert loads("pflueger-hinged") == pytest.approx(found, rel=1e-6)


def test_partly_following_force():
    """Sums of 1, x, cos k x and sin k x with w = w' = 0, and w'' = w''' + (1 - share) k^2 w' = 0 at the tip."""
    rest = 1 - 0.49

    def determinant(load):
        k = sqrt(load)
        c, s = cos(k), sin(k)
        return np.linalg.det([[1, 0, 1, 0], [0, 1, 0, k], [0, 0, -k**2 * c, -k**2 * s],
                              [0, rest * k**2, (1 - rest) * k**3 * s, -(1 - rest) * k**3 * c]])

    assert loads("partly-following")[:2] == pytest.approx(zeros(determinant, 0.5, 30.0), rel=1e-6)


def test_flutter_under_a_partly_following_force():
    """Two zeros in omega^2 of the determinant of w^IV + P w^II = omega^2 w meet (Bolotin 1963, section 2.2).

    For P = 20.051 they do so where all of the force follows (Beck 1952).
    """
    def determinant(load, square, rest):
        root = sqrt(load**2 / 4 + square)
        a, b = sqrt(root - load / 2), sqrt(root + load / 2)
        moment = a**2 * cosh(a) + b**2 * cos(b), a * sinh(a) + b * sin(b)
        force = a**3 * sinh(a) - b**3 * sin(b), a**2 * cosh(a) + b**2 * cos(b)
        tilt = a * sinh(a) + b * sin(b), cosh(a) - cos(b)
        return np.linalg.det([moment, np.array(force) + rest * load * np.array(tilt)])

    def between(load, rest):
        """The extreme of the determinant between the two lowest frequencies, where it is negative."""
        return minimize_scalar(lambda square: determinant(load, square, rest), bounds=(5.0, 200.0), method="bounded",
                               options={"xatol": 1e-9}).fun

    flutter = {rest: brentq(between, 15.0, 20.5, args=(rest,)) for rest in (0.0, 0.51)}
    assert flutter[0.0] == pytest.approx(20.051, rel=1e-5)
    assert loads("partly-following")[2] == pytest.approx(flutter[0.51], rel=1e-6)


@pytest.mark.parametrize(("name", "ends"), [
    ("pressed-arch-hinged", lambda k, half: sin(k * half)),
    ("pressed-arch-clamped", lambda k, half: k * sin(half) * cos(k * half) - cos(half) * sin(k * half))])
def test_sway_of_a_semicircle_under_pressure(name, ends):
    """p R^3 / EI = k^2 - 1 for the first k above 1 with which the inextensible arch fits its ends (Hurlbrink 1908)."""
    first, *_ = zeros(lambda k: ends(k, pi / 2), 1.1, 4.5)
    assert loads(name) == pytest.approx([first**2 - 1])
