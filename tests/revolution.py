"""Thin shells of revolution under pressure, by splines along the meridian and waves around: independent references.

Koiter's shell: W = h/2 e C e + h^3/24 k C k with the exact changes of metric e = (a - A) / 2 and of curvature
k = b - B of the mid-surface (Koiter 1966; linearised it is the theory of Sanders 1959), under a live pressure along the
present normal on the present area, or under a dead one along the first normal. The state before buckling has no waves
and is nonlinear; the second variation has n waves around. Its derivatives are exact, by numbers that carry their
gradient and Hessian.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.interpolate import BSpline, CubicSpline
from scipy.linalg import eigh, null_space
from scipy.optimize import brentq

DEGREE = 5
U, V, W = range(3)  # radial, circumferential and axial displacement


class Taylor:
    """Numbers with gradient and Hessian by some variables, one at each point."""

    def __init__(self, value, gradient, hessian):
        self.value, self.gradient, self.hessian = value, gradient, hessian

    def __add__(self, other):
        if not isinstance(other, Taylor):
            return Taylor(self.value + other, self.gradient, self.hessian)
        return Taylor(self.value + other.value, self.gradient + other.gradient, self.hessian + other.hessian)

    def __mul__(self, other):
        if not isinstance(other, Taylor):
            factor = np.broadcast_to(other, self.value.shape)
            return Taylor(self.value * factor, self.gradient * factor[:, None], self.hessian * factor[:, None, None])
        mixed = self.gradient[:, :, None] * other.gradient[:, None, :]
        first, second = self.value[:, None], other.value[:, None]
        return Taylor(self.value * other.value, first * other.gradient + second * self.gradient,
                      first[:, None] * other.hessian + second[:, None] * self.hessian + mixed + mixed.swapaxes(1, 2))

    __radd__, __rmul__ = __add__, __mul__

    def __neg__(self):
        return self * -1.0

    def __sub__(self, other):
        return self + (-other)

    def inverse_root(self):
        """One over the square root."""
        root = self.value**-0.5
        first, second = -root / self.value / 2, 0.75 * root / self.value**2
        outer = self.gradient[:, :, None] * self.gradient[:, None, :]
        return Taylor(root, first[:, None] * self.gradient,
                      first[:, None, None] * self.hessian + second[:, None, None] * outer)


def variables(points: int, count: int) -> list[Taylor]:
    """Variables that are zero at all points."""
    return [Taylor(np.zeros(points), np.tile(row, (points, 1)), np.zeros((points, count, count)))
            for row in np.eye(count)]


def cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@dataclass(frozen=True)
class Revolution:
    """Shell of revolution under a pressure along its normal (-z', 0, r'), with the length s of its meridian.

    Attributes
    ----------
    curve : function from s to r, r', r'', z, z', z''
    length : of the meridian
    held : function from the number of waves to conditions, each a list of (factor, component, end, derivative) whose
        sum is zero; end 0 or 1, derivative 0 or 1
    live : whether the pressure follows the surface
    ends : fractions of the length at which splines join
    """

    curve: Callable
    length: float
    modulus: float
    poisson: float
    thickness: float
    held: Callable[[int], Sequence[Sequence[tuple[float, int, int, int]]]]
    live: bool = True
    ends: Sequence[float] = tuple(np.linspace(0, 1, 25))

    @cached_property
    def _splines(self) -> BSpline:
        ends = self.length * np.asarray(self.ends)
        knots = np.concatenate(([0.0] * DEGREE, ends, [self.length] * DEGREE))
        return BSpline(knots, np.eye(len(knots) - DEGREE - 1), DEGREE)

    @cached_property
    def _rule(self):
        """Places, weights, and splines with two derivatives there, shape (3, places, splines)."""
        ends = self.length * np.asarray(self.ends)
        points, weights = np.polynomial.legendre.leggauss(DEGREE + 1)
        s = (ends[:-1, None] + np.diff(ends)[:, None] * (points + 1) / 2).ravel()
        return s, (np.diff(ends)[:, None] * weights / 2).ravel(), np.array([self._splines(s, d) for d in range(3)])

    @cached_property
    def unloaded(self) -> np.ndarray:
        """Coefficients of the three components."""
        return np.zeros((3, self._splines.c.shape[1]))

    @cached_property
    def _known(self) -> dict:
        """Bases by numbers of waves, and states by pressures."""
        return {"bases": {}, "states": {}}

    def _admissible(self, waves: int) -> np.ndarray:
        """Displacements that satisfy the conditions, as columns of coefficients; without waves none around."""
        bases = self._known["bases"]
        if waves not in bases:
            bases[waves] = self._basis(waves)
        return bases[waves]

    def _basis(self, waves: int) -> np.ndarray:
        rows = []
        for condition in self.held(waves):
            row = np.zeros_like(self.unloaded)
            for factor, component, end, derivative in condition:
                row[component] += factor * self._splines(self.length * end, derivative) * self.length**derivative
            rows.append(row.ravel())
        free = null_space(np.array(rows))
        if waves:
            return free
        around = np.zeros((3, self.unloaded.shape[1]), dtype=bool)
        around[V] = True
        return null_space(np.vstack([rows, np.eye(around.size)[around.ravel()]]))

    def _densities(self, state: np.ndarray, waves: int, cosine: float, pressure: float):
        """Energy per length and angle where waves have a cosine of 0 or 1, and forces of the pressure on places there.

        They depend on the amplitudes u, u', u'', v, v', v'', w, w', w'': u and w go with the cosine, v with the sine.
        """
        s, _, splines = self._rule
        first, sine, n, poisson = np.array(self.curve(s)), 1 - cosine, waves, self.poisson
        amplitudes = variables(len(s), 9)
        r, z = first[:3] + splines @ state[U], first[3:] + splines @ state[W]

        def at(order):
            """Derivative along the meridian, on axes that turn with the angle, and two derivatives of it around."""
            u, v, w = amplitudes[order::3]
            x = [u * cosine + r[order], v * sine, w * cosine + z[order]]
            once = [u * (-n * sine), v * (n * cosine), w * (-n * sine)]
            twice = [u * (-n * n * cosine), v * (-n * n * sine), w * (-n * n * cosine)]
            return (x, [once[0] - x[1], once[1] + x[0], once[2]],
                    [twice[0] - once[1] * 2.0 - x[0], twice[1] + once[0] * 2.0 - x[1], twice[2]])

        (x, around, around2), (along, mixed, _), (along2, _, _) = at(0), at(1), at(2)
        normal = cross(along, around)
        unit = dot(normal, normal).inverse_root()
        radius = first[0]
        stretch = [(dot(along, along) + -1.0) * 0.5, (dot(around, around) * radius**-2.0 + -1.0) * 0.5,
                   dot(along, around) * (0.5 / radius)]
        bend = [dot(along2, normal) * unit + (first[2] * first[4] - first[5] * first[1]),
                dot(around2, normal) * unit * radius**-2.0 + -first[4] / radius,
                dot(mixed, normal) * unit * (1 / radius)]

        def square(e):
            return e[0] * e[0] + e[1] * e[1] + e[0] * e[1] * (2 * poisson) + e[2] * e[2] * (2 * (1 - poisson))

        plane = self.modulus * self.thickness / (1 - poisson**2)
        energy = (square(stretch) + square(bend) * (self.thickness**2 / 12)) * (plane / 2 * radius)
        if self.live:
            return energy, x, [c * pressure for c in normal]
        zero = amplitudes[0] * 0.0
        return energy, x, [zero + c * radius * pressure for c in (-first[4], 0 * radius, first[1])]

    def _derivatives(self, state: np.ndarray, waves: int, pressure: float) -> tuple[np.ndarray, np.ndarray]:
        """Forces out of balance over pi, and their derivatives, by coefficients."""
        _, weights, splines = self._rule
        force = stiffness = 0.0
        for cosine, share in ((1.0, 2.0),) if waves == 0 else ((0.0, 1.0), (1.0, 1.0)):
            energy, place, pull = self._densities(state, waves, cosine, pressure)
            own = energy.gradient - sum(p.value[:, None] * x.gradient for p, x in zip(pull, place, strict=True))
            change = energy.hessian - sum(x.gradient[:, :, None] * p.gradient[:, None, :]
                                          for p, x in zip(pull, place, strict=True))
            force = force + share * weights[:, None] * own
            stiffness = stiffness + share * weights[:, None, None] * change
        size = self.unloaded.size
        force = np.einsum("qcd,dqi->ci", force.reshape(-1, 3, 3), splines).ravel()
        stiffness = np.einsum("qcdef,dqi,fqj->ciej", stiffness.reshape(-1, 3, 3, 3, 3), splines, splines, optimize=True)
        return force, stiffness.reshape(size, size)

    def prebuckled(self, pressure: float, start: np.ndarray | None = None) -> np.ndarray:
        """State without waves, by Newton's method."""
        state, free = (self.unloaded if start is None else start).copy(), self._admissible(0)
        for _ in range(25):
            force, matrix = self._derivatives(state, 0, pressure)
            step = -free @ np.linalg.solve(free.T @ matrix @ free, free.T @ force)
            state += step.reshape(state.shape)
            if np.abs(step).max() < 1e-10 * self.length:
                return state
        raise ArithmeticError(f"no state without waves is found at a pressure of {pressure}")

    def tangent(self, state: np.ndarray, waves: int, pressure: float) -> np.ndarray:
        """On the admissible displacements; symmetric, as live pressure is where its boundary is held."""
        free = self._admissible(waves)
        tangent = free.T @ self._derivatives(state, waves, pressure)[1] @ free
        assert np.abs(tangent - tangent.T).max() < 1e-9 * np.abs(tangent).max()
        return (tangent + tangent.T) / 2

    def linear_buckling(self, waves: int, small: float) -> float:
        """Lowest pressure of the sign of a small one at which the tangent is singular if it goes on as by that one."""
        plus, minus = (self.tangent(self.prebuckled(p), waves, p) for p in (small, -small))
        start = self.tangent(self.unloaded, waves, 0.0)
        return small / eigh((minus - plus) / 2, start, eigvals_only=True)[-1]

    def bifurcation(self, waves: int, pressures: Sequence[float]) -> float:
        """First pressure at which the tangent of the nonlinear state is singular, among those that are passed."""
        states = self._known["states"]

        def lowest(pressure):
            if pressure not in states:
                nearest = min(states, key=lambda known: abs(known - pressure), default=None)
                states[pressure] = self.prebuckled(pressure, states.get(nearest))
            return eigh(self.tangent(states[pressure], waves, pressure), eigvals_only=True, subset_by_index=[0, 0])[0]

        before = None
        for pressure in pressures:
            value = lowest(pressure)
            if before is not None and value < 0 < before[1]:
                return brentq(lowest, before[0], pressure, rtol=1e-9)
            before = pressure, value
        raise ArithmeticError(f"no bifurcation with {waves} waves")

    def limit(self, deflections: Sequence[float], pressure: float) -> float:
        """Largest pressure of the state without waves, which is led by its axial displacement at the start.

        Parameters
        ----------
        deflections : of rising size, beyond that at the limit
        pressure : a guess at the first
        """
        free, state, found = self._admissible(0), self.unloaded.copy(), []
        row = np.zeros_like(self.unloaded)
        row[W] = self._splines(0.0)
        row = row.ravel() @ free
        for deflection in deflections:
            for _ in range(25):
                force, matrix = self._derivatives(state, 0, pressure)
                load = (force - self._derivatives(state, 0, pressure - 1.0)[0]) @ free
                bordered = np.block([[free.T @ matrix @ free, load[:, None]], [row[None, :], np.zeros((1, 1))]])
                missing = deflection - self._splines(0.0) @ state[W]
                *step, change = np.linalg.solve(bordered, [*(-force @ free), missing])
                state, pressure = state + (free @ step).reshape(state.shape), pressure + change
                if abs(change) < 1e-9 * abs(pressure):
                    break
            found.append(abs(pressure))
        curve = CubicSpline(np.abs(deflections), found)
        return float(max(curve(root) for root in curve.derivative().roots(extrapolate=False)))
