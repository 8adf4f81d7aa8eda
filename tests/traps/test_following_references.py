"""The loads of traps whose loads follow the structure, by closed forms and by means of scipy alone."""

from __future__ import annotations

from math import cos, pi, sin, sqrt

import numpy as np
import pytest
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

    assert loads("partly-following") == pytest.approx(zeros(determinant, 0.5, 30.0), rel=1e-6)


@pytest.mark.parametrize(("name", "ends"), [
    ("pressed-arch-hinged", lambda k, half: sin(k * half)),
    ("pressed-arch-clamped", lambda k, half: k * sin(half) * cos(k * half) - cos(half) * sin(k * half))])
def test_sway_of_a_semicircle_under_pressure(name, ends):
    """p R^3 / EI = k^2 - 1 for the first k above 1 with which the inextensible arch fits its ends (Hurlbrink 1908)."""
    first, *_ = zeros(lambda k: ends(k, pi / 2), 1.1, 4.5)
    assert loads(name) == pytest.approx([first**2 - 1])
