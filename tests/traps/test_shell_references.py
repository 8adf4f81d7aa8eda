"""The loads of traps of plates and shells, by closed forms and by means of scipy alone."""

from __future__ import annotations

from math import cos, cosh, pi, radians, sin, sinh, sqrt

import numpy as np
import pytest
from failure_map.traps import TRAPS
from scipy.integrate import solve_bvp
from scipy.interpolate import CubicSpline
from test_mode_references import loads, zeros

from sheetfx.model.laminate import Laminate, Ply

WAVES = range(1, 20)


@pytest.mark.parametrize(("name", "aspect", "across", "to"), [
    ("plate-root-2", sqrt(2), 0.0, 8.0), ("plate-long", 10.0, 0.0, 4.25), ("plate-all-round", 1.0, 1.0, 9.0)])
def test_plates(name, aspect, across, to):
    """Bryan 1891: k (m^2 / a^2 + across n^2) = (m^2 / a^2 + n^2)^2."""
    along = [(m / aspect) ** 2 for m in WAVES]
    found = sorted((x + n**2) ** 2 / (x + across * n**2) for x in along for n in WAVES)
    expected = [p.load for p in TRAPS[name].points for _ in range(p.multiplicity)]
    assert expected == pytest.approx([k for k in found if k < to], rel=1e-6)


def test_angle_ply():
    """Jones (1975, chapter 5) for antisymmetric angle-ply laminates, for a square.

    Without coupling the first load would be twice as large.
    """
    stiffness = Laminate([Ply(0.5, angle, 10.0, 1.0, 0.25, 0.5) for angle in (45.0, -45.0)]).stiffness()
    a, b, d = (np.array(block) for block in (stiffness.membrane, stiffness.coupling, stiffness.bending))
    assert np.allclose(a[:2, 2], 0) and np.allclose(d[:2, 2], 0) and np.allclose(b[:2, :2], 0)

    def load(m, n, coupled=1.0):
        p, q = m * pi, n * pi
        t11, t12 = a[0, 0] * p**2 + a[2, 2] * q**2, (a[0, 1] + a[2, 2]) * p * q
        t22, t33 = a[1, 1] * q**2 + a[2, 2] * p**2, d[0, 0] * p**4 + 2 * (d[0, 1] + 2 * d[2, 2]) * p**2 * q**2
        t13 = -coupled * (3 * b[0, 2] * p**2 * q + b[1, 2] * q**3)
        t23 = -coupled * (b[0, 2] * p**3 + 3 * b[1, 2] * p * q**2)
        less = (2 * t12 * t23 * t13 - t22 * t13**2 - t11 * t23**2) / (t11 * t22 - t12**2)
        return (t33 + d[1, 1] * q**4 + less) / p**2

    found = sorted(load(m, n) for m in WAVES for n in WAVES)
    assert loads("angle-ply") == pytest.approx([k for k in found if k < 25.0], rel=1e-6)
    assert load(1, 1, 0.0) > 2 * load(1, 1)


def test_layers_of_one_material_are_a_plate():
    """E = 2, nu = 0.25 and G = E / 2 / (1 + nu) in two layers at any angles."""
    one = Laminate([Ply(0.05, angle, 2.0, 2.0, 0.25, 0.8) for angle in (20.0, -70.0)]).stiffness()
    plane = 2 / (1 - 0.25**2) * np.array([[1, 0.25, 0], [0.25, 1, 0], [0, 0, 0.375]])
    assert np.allclose(one.membrane, 0.1 * plane) and np.allclose(one.bending, 0.1**3 / 12 * plane)
    assert np.allclose(one.coupling, 0.0, atol=1e-12)


def edge(k, wave, hinged):
    """Misfit at the free edge of f(y) sin(wave x), 0 < y < 1, hinged or clamped at y = 0; Poisson's ratio is 0."""
    root = pi * sqrt(k) * wave
    a, b = sqrt(root + wave**2), sqrt(root - wave**2)
    if hinged:
        f, g = (np.array([a**2 * sinh(a), a**3 * cosh(a) - 2 * wave**2 * a * cosh(a)]),
                np.array([-b**2 * sin(b), -b**3 * cos(b) - 2 * wave**2 * b * cos(b)]))
    else:
        f = np.array([a**2 * cosh(a) + b**2 * cos(b),
                      a**3 * sinh(a) - b**3 * sin(b) - 2 * wave**2 * (a * sinh(a) + b * sin(b))])
        g = np.array([a**2 * sinh(a) + a * b * sin(b),
                      a**3 * cosh(a) + a * b**2 * cos(b) - 2 * wave**2 * (a * cosh(a) - a * cos(b))])
    return f[0] * g[1] - f[1] * g[0]


def test_angle_column():
    """Legs that turn about the junction alike bend it nowhere; those that turn against each other clamp it."""
    found = sorted(k for m in (1, 2, 3) for hinged in (True, False)
                   for k in zeros(lambda k, m=m, h=hinged: edge(k, m * pi / 3, h), (m / 3) ** 2 + 1e-6, 1.7))
    assert loads("angle-column") == pytest.approx(found, rel=1e-5)


def cap_under_pressure(rim, hole, thickness, poisson, steps):
    """Deflections of the hole's edge and pressures over the classical one, for a cap without shear deformation.

    Axisymmetric equations of Reissner (1950) for the place r, z of the meridian, its angle, the forces H and V and
    the moment, times the reference radius, with the pressure on the deformed surface as a further unknown.
    """
    start, end = radians(hole), radians(rim)
    classical = 2 * thickness**2 / sqrt(3 * (1 - poisson**2))
    stretch = thickness / (1 - poisson**2) / classical
    bend = stretch * thickness**2 / 12

    def rates(s, y, unknown):
        r, _, angle, horizontal, vertical, moment = y
        reference, c, n = np.sin(s), np.cos(angle), np.sin(angle)
        around, turn = r / reference - 1, (np.sin(angle) + np.sin(s)) / reference
        along = (horizontal * c + vertical * n) / reference / stretch - poisson * around
        curved = moment / reference / bend - poisson * turn
        force, bending = stretch * (around + poisson * along), bend * (turn + poisson * curved)
        push = unknown[0] * (1 + along) * r
        return np.vstack([(1 + along) * c, (1 + along) * n, curved - 1, force - push * n, push * c,
                          bending * c + (1 + along) * (horizontal * n - vertical * c)])

    s = np.linspace(start, end, 60)
    y = np.vstack([np.sin(s), np.cos(s), -s, 0 * s, 0 * s, 0 * s])
    pressure, rows = np.array([0.0]), []
    for w in steps:
        def ends(a, b, unknown, w=w):
            return np.array([a[1] - np.cos(start) + w, a[3], a[4], a[5],
                             b[0] - np.sin(end), b[1] - np.cos(end), b[2] + end])

        solution = solve_bvp(rates, ends, s, y, pressure, tol=1e-6, max_nodes=5000)
        assert solution.success
        s, y, pressure = solution.x, solution.y, solution.p
        rows.append((w, pressure[0]))
    return np.array(rows).T


def test_holed_cap():
    deflection, pressure = cap_under_pressure(4.5, 0.9, 1e-3, 0.3, np.arange(5e-5, 5e-3, 1e-4))
    spline = CubicSpline(deflection, pressure)
    extremes = [float(spline(w)) for w in spline.derivative().roots(extrapolate=False)]
    assert loads("holed-cap") == pytest.approx(extremes, rel=5e-4)
