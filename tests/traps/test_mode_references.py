"""The loads of traps with close modes, a mode jump and closed paths, by closed forms and by means of numpy alone."""

from __future__ import annotations

from math import cos, pi, sin, sqrt

import numpy as np
import pytest
from failure_map.traps import TRAPS
from scipy.optimize import brentq, fsolve, minimize_scalar
from truss import SymmetricPath, Truss


def loads(name):
    return [p.load for p in TRAPS[name].points]


def zeros(function, low, high, count=2000):
    """Places in order where a function changes its sign."""
    places = np.linspace(low, high, count)
    values = [function(x) for x in places]
    return [brentq(function, a, b, xtol=1e-14)
            for a, b, p, q in zip(places, places[1:], values, values[1:], strict=False) if p * q < 0]


@pytest.mark.parametrize(("name", "half_span"), [("close-modes-exact", 1.0), ("close-modes-0.1-percent", 1.00053),
                                                 ("close-modes-5-percent", 1.0272)])
def test_pyramid(name, half_span):
    """Stiffness of bars of length l and force N along and across them: 1 / L and N / l."""
    spans, rise = np.array([1.0, half_span]), 3.0
    whole = np.hypot(spans, rise)

    def state(height):
        """Load, and stiffness of the apex along x, y and z."""
        length = np.hypot(spans, height)
        force = length / whole - 1
        in_plane = 2 * (spans**2 / whole / length**2 + force * height**2 / length**3)
        vertical = 2 * (height**2 / whole / length**2 + force * spans**2 / length**3).sum()
        return -2 * (force * height / length).sum(), *(in_plane + 2 * (force / length)[::-1]), vertical

    heights = [(h, kind) for kind in (1, 2, 3) for h in zeros(lambda h, kind=kind: state(h)[kind], -rise, rise)]
    in_order = sorted(heights, reverse=True)
    if half_span == 1.0:
        in_order = [point for point in in_order if point[1] != 2]
    assert [p.kind for p in TRAPS[name].points] == [{3: "limit"}.get(kind, "bifurcation") for _, kind in in_order]
    assert loads(name) == pytest.approx([state(h)[0] for h, _ in in_order], rel=1e-9)
    if "percent" in name:
        share = float(name.split("-")[2]) / 100
        assert loads(name)[1] / loads(name)[0] - 1 == pytest.approx(share, rel=0.04)


@pytest.mark.parametrize(("name", "ratio", "tilt"), [
    ("augusti-5-percent", 0.95, 0.01), ("augusti-0.1-percent", 0.999, 3e-5), ("augusti-exact", 1.0, 1e-3)])
def test_augusti(name, ratio, tilt):
    """Forces s (x, z) in a strut of length l = EA / (s + EA): s x = x - tilt, and s = ratio at the bifurcation."""
    def load(x):
        s = 1 - tilt / x
        return s * sqrt((100 / (s + 100)) ** 2 - x**2)

    highest = minimize_scalar(lambda x: -load(x), bounds=(tilt, 0.5), method="bounded", options={"xatol": 1e-12})
    points = [(highest.x, load(highest.x))]
    if ratio < 1:
        points = sorted([*points, (tilt / (1 - ratio), load(tilt / (1 - ratio)))])
    assert loads(name) == pytest.approx([p for _, p in points], rel=1e-9)


def test_mode_jump():
    """Galerkin's method for EI w'''' + P (w + w_0)'' + pi^2 (linear w + cubic w^3) = 0 with EI pi^2 = 1."""
    linear, cubic, imperfection = 3.0, 8e4, 1e-4
    x, weights = np.polynomial.legendre.leggauss(40)
    x, weights = (x + 1) / 2, weights / 2
    odd, even = np.array([1, 3, 5, 7]), np.array([2, 4, 6, 8])
    one, other = (np.sin(pi * np.outer(n, x)) for n in (odd, even))

    def stiffness(n, waves, load, a):
        cubed = 6 * cubic * (waves * weights * (a @ one) ** 2) @ waves.T
        return np.diag(n**4.0 - load * n**2 + linear) + cubed

    def bent(load, a):
        """Amplitudes of odd numbers of waves under a load, by Newton's method."""
        for _ in range(30):
            y = a @ one
            off = (odd**4 - load * odd**2 + linear) * a + 2 * cubic * (one * weights) @ y**3
            off[0] -= load * imperfection
            a = a - np.linalg.solve(stiffness(odd, one, load, a), off)
        return a

    states, a = {}, np.zeros(4)
    for load in np.arange(0.0, 7.0, 0.05):
        states[load] = a = bent(load, a)

    def lowest(load):
        start = states[max(known for known in states if known <= load)]
        return np.linalg.eigvalsh(stiffness(even, other, load, bent(load, start)))[0]

    assert loads("mode-jump") == pytest.approx(zeros(lowest, 0.0, 6.99, 80), rel=1e-5)


def test_closed_path():
    """Moment k_x (x_0 - x) y + k_y (y - y_0) x of two springs on a circle."""
    stiffness, start = 3.0, 0.5

    def moment(angle):
        return (cos(start) - cos(angle)) * sin(angle) + stiffness * (sin(angle) - sin(start)) * cos(angle)

    def slope(angle):
        return (stiffness - 1) * cos(2 * angle) + cos(start) * cos(angle) + stiffness * sin(start) * sin(angle)

    turn = [moment(angle) for angle in zeros(slope, start, start + 2 * pi)]
    assert loads("closed-path") == pytest.approx(2 * turn, rel=1e-8)


def test_half_loop():
    truss = Truss(np.array([[-1.0, 0.0], [1e-3, 3.0], [1.0, 0.0]]), np.array([[0, 1], [1, 2]]), [1],
                  np.array([[0.0, -1.0]]))
    found = SymmetricPath(truss, np.eye(2)).critical_points(lambda moves: -moves[1] >= 6.6, 0.05)
    assert [(kind, count) for kind, _, count in found] == [("limit", 1)] * 2
    assert loads("half-loop") == pytest.approx([load for _, load, _ in found], rel=1e-8)


def test_offset_load():
    """The thrust H = alpha^2 - b^2 - 4 c^2 of waves b (1 - H) = alpha - P and c (16 - 4 H) = -part P; extremes of P."""
    alpha, part = 2.8, 0.02

    def off(thrust, load):
        b, c = (alpha - load) / (1 - thrust), part * load / (16 - 4 * thrust)
        return b**2 + 4 * c**2 + thrust - alpha**2, 2 * b**2 / (1 - thrust) + 32 * c**2 / (16 - 4 * thrust) + 1

    starts = (3.8, 8.3), (5.5, -4.1), (5.5, 9.7), (3.9, -2.9)
    found = [fsolve(lambda z: off(*z), start, xtol=1e-12) for start in starts]
    assert all(np.allclose(off(*z), 0.0, atol=1e-8) for z in found)
    assert loads("offset-load") == pytest.approx([load for _, load in found], rel=1e-7)
