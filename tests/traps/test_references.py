"""The loads in the registry of traps, from closed forms and by means that share nothing with sheetfx."""

from __future__ import annotations

from math import pi, sqrt

import numpy as np
import pytest
from failure_map.traps import TRAPS
from scipy.integrate import solve_bvp
from scipy.optimize import brentq, fsolve
from truss import SymmetricPath, Truss

from sheetfx.case import trace
from sheetfx.scenes import column, roorda_frame, star_dome


def loads(name, kind=None):
    return [p.load for p in TRAPS[name].points if kind in (None, p.kind)]


def test_von_mises_truss():
    """P = 2 h (1/l - 1/L), extreme where l^3 = L; sideways stiffness 1/l^2 + (1 - L/l) h^2/l^2 zero."""
    rise = 3.0
    whole = sqrt(1 + rise**2)

    def load(length):
        return 2 * sqrt(length**2 - 1) * (1 / length - 1 / whole)

    sideways = [r.real for r in np.roots([1 / whole, -1, 0, 1]) if r.real > 1]
    expected = [load(length) for length in sorted([*sideways, whole ** (1 / 3)], reverse=True)]
    assert loads("von-mises-truss") == pytest.approx([*expected, *(-p for p in reversed(expected))], rel=1e-9)


@pytest.mark.parametrize("name, ring", [
    ("star-dome", 0.0), pytest.param("star-dome-all-nodes", 1.0, marks=pytest.mark.slow)])
@pytest.mark.slow
def test_star_dome(name, ring):
    nodes, members = star_dome.dome()
    names, places = list(nodes), np.array(list(nodes.values()))
    free = [i for i, n in enumerate(names) if not n.startswith("outer")]
    load, symmetric = np.zeros((7, 3)), np.zeros((7, 3, 3))
    load[:, 2] = [-1.0, *6 * [-ring]]
    symmetric[0, 2, 0] = 1
    symmetric[1:, :2, 1] = places[free[1:], :2] / np.linalg.norm(places[free[1:], :2])
    symmetric[1:, 2, 2] = 1 / sqrt(6)
    bars = np.array([[names.index(n) for n in ends] for ends in members.values()])
    path = SymmetricPath(Truss(places, bars, free, load), symmetric.reshape(-1, 3))
    found = path.critical_points(lambda moves: -moves[2] >= 20.0, 0.1)
    expected = TRAPS[name].points
    assert [(kind, count) for kind, _, count in found] == [(p.kind, p.multiplicity) for p in expected]
    assert [value * (1 + 6 * ring) for _, value, _ in found] == pytest.approx([p.load for p in expected], rel=1e-7)


def test_column_with_extension_and_shear():
    """P (1 - P / EA + P / kGA) = n^2 Euler's load, in whose units EA is 12 / (pi depth)^2."""
    depth = 0.1
    axial = 12 / (pi * depth) ** 2
    shear = axial * 5 / 6 / 2.6
    expected = [brentq(lambda p, n=n: p * (1 - p / axial + p / shear) - n * n, 0, 2 * n * n) for n in (1, 2, 3)]
    found = [p.load for p in trace(column.case(depth=depth)).critical_points]
    assert found == pytest.approx(expected, rel=2e-3)
    finer = trace(column.case(depth=depth, elements=36)).critical_points
    assert [p.load for p in finer] == pytest.approx(expected, rel=2e-5)


def roorda(angle):
    """Force on the corner and largest displacement over the angle, of Roorda's frame without extension and shear.

    Places, angles and moments of column and beam by collocation, with the force in the beam and the load unknown.
    """
    def rates(s, y, unknown):
        column, beam, force = y[:4], y[4:], unknown[:2]
        rows = []
        for (_, _, turn, moment), start, inner in ((column, pi / 2, force - [0, unknown[2]]), (beam, 0.0, force)):
            along = np.cos(start + turn), np.sin(start + turn)
            rows += [*along, moment, along[1] * inner[0] - along[0] * inner[1]]
        return np.array(rows)

    def ends(a, b, unknown):
        return np.array([a[0], a[1], a[3], b[4] - 1, b[5] - 1, b[7], *(b[:4] - a[4:]), b[2] - angle])

    s = np.linspace(0, 1, 40)
    wave = angle * np.array([np.sin(3.73 * s) / -2, 0 * s, np.cos(3.73 * s), np.sin(3.73 * s) * -3.7,
                             0 * s, (s**3 - 3 * s**2 + 2 * s) / 2, 0 * s, 3 * (s - 1)])
    straight = np.array([0 * s, s, *4 * [0 * s], *2 * [0 * s]])
    straight[4], straight[5] = s, 1.0
    solution = solve_bvp(rates, ends, s, straight + wave, [0.0, 3 * angle, 13.88], tol=1e-10, max_nodes=20000)
    assert solution.success
    y = solution.sol(np.linspace(0, 1, 2001))
    places = np.linspace(0, 1, 2001)
    moves = max(np.hypot(y[0], y[1] - places).max(), np.hypot(y[4] - places, y[5] - 1).max())
    return solution.p[2], moves / abs(angle)


def test_roorda_frame():
    """u^2 / (u cot u - 1) = 3 from the stiffness of a compressed column; the slope from both sides of the branch."""
    u = brentq(lambda u: u**2 * np.sin(u) - 3 * (u * np.cos(u) - np.sin(u)), 3.3, 4.2)
    assert loads("roorda-frame") == pytest.approx([2 * u**2 / pi**2], rel=1e-5)
    (high, size), (low, _) = roorda(1e-3), roorda(-1e-3)
    assert (high + low) / 2 == pytest.approx(u**2, rel=1e-5)
    slope = abs(high - low) / 2e-3 / u**2 / size
    point, = trace(roorda_frame.case(elements=80)).critical_points
    assert abs(point.slope) == pytest.approx(slope, rel=2e-3)


class SymmetricElastica:
    """Half of an inextensible, shear-rigid semicircle of radius 1 and stiffness 1, from its crown to its hinge.

    Unknowns z are the crown's moment, the thrust and the load on the whole arch; no moment acts at the hinge, which
    stays 1 from the axis of symmetry.
    """

    STEPS = 80

    @staticmethod
    def _rates(y, thrust, shear):
        angle, moment = y[0], y[1]
        return np.array([moment - 1, np.sin(angle) * thrust - np.cos(angle) * shear, np.cos(angle)])

    def misfit(self, z):
        """Moment at the hinge, and how far it is from its place; for columns of unknowns."""
        y, h = np.array([0 * z[0], z[0], 0 * z[0]]), pi / 2 / self.STEPS
        for _ in range(self.STEPS):
            a = self._rates(y, z[1], z[2] / 2)
            b = self._rates(y + h / 2 * a, z[1], z[2] / 2)
            c = self._rates(y + h / 2 * b, z[1], z[2] / 2)
            d = self._rates(y + h * c, z[1], z[2] / 2)
            y = y + h / 6 * (a + 2 * b + 2 * c + d)
        return np.array([y[1], y[2] - 1])

    def slopes(self, z):
        """Misfit and its derivatives, by complex steps."""
        values = self.misfit(z[:, None] + 1e-30j * np.eye(3))
        return values[:, 0].real, values.imag / 1e-30

    def extremes(self, until):
        """Extremes of the load in the order of the path, by steps of pseudo-arclength."""
        z, direction, found = np.zeros(3), np.array([0.0, 0.0, 1.0]), []
        while abs(z[2]) < until:
            slopes = self.slopes(z)[1]
            ahead = np.cross(*slopes)
            ahead *= np.sign(ahead @ direction) / np.linalg.norm(ahead)
            if ahead[2] * direction[2] < 0:
                found.append(self._extreme(z))
            direction, start = ahead, z
            step = 0.06 * (1 + np.linalg.norm(z))
            z = start + step * direction
            for _ in range(20):
                misfit, slopes = self.slopes(z)
                change = np.linalg.solve(np.vstack([slopes, direction]), [*-misfit, step - direction @ (z - start)])
                z = z + change
                if np.linalg.norm(change) < 1e-10 * np.linalg.norm(z):
                    break
        return found

    def _extreme(self, z):
        """Load near z where the path's direction has no component of load."""
        def equations(z):
            misfit, slopes = self.slopes(z)
            return [*misfit, np.cross(*(row / np.linalg.norm(row) for row in slopes))[2]]

        return fsolve(equations, z, xtol=1e-12)[2]


@pytest.mark.slow
def test_semicircular_arch():
    """Tolerances: the arch's own are 5e-4, for extension with depth / radius 0.005."""
    found = SymmetricElastica().extremes(200.0)
    expected = TRAPS["deep-arch-180"].points
    assert [1.25 * load for load in found] == pytest.approx([p.load for p in expected], rel=2e-4)
