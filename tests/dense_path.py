"""Equilibrium paths and all their critical points by numpy and scipy alone: tiny steps, all eigenvalues at each."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from scipy.linalg import eigvalsh
from scipy.optimize import brentq

SAME = 1e-6  # relative difference of loads of one multiple point
PASSED = 1e-5  # an eigenvalue where it changes its sign, over those at the ends of the step
ROUNDING = 1e-14  # of eigenvalues, over the largest; of forces, over the largest eigenvalue and a displacement of one


class Undecided(ArithmeticError):
    """The path cannot be followed with steps as small as allowed."""


class Problem(Protocol):
    """Equilibrium of a structure with a potential under a dead load: gradient(q) = factor load.

    Attributes
    ----------
    load : on the free unknowns, for a load factor of 1
    """

    load: np.ndarray

    def derivatives(self, q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Gradient and Hessian of the energy."""


@dataclass(frozen=True)
class Point:
    """A critical point: kind ("limit" or "bifurcation"), load factor, number of null vectors, length of path there."""

    kind: str
    factor: float
    multiplicity: int
    along: float


@dataclass(frozen=True)
class Place:
    """An equilibrium: unknowns and scaled load factor in z, the unit tangent of the path, and all eigenvalues."""

    z: np.ndarray
    tangent: np.ndarray
    values: np.ndarray

    @property
    def unstable(self) -> int:
        return int((self.values < 0).sum())


class DensePath:
    """The path from the unloaded state, by pseudo-arclength with Newton's method.

    Lengths are measured in the unknowns, and in the load factor times the norm of the first displacement by a load of
    one. A step whose tangents turn by more than allowed, or whose eigenvalues change sign without passing zero, is
    halved.

    Parameters
    ----------
    longest : length of a step
    turn : radians between the tangents at both ends of a step
    """

    def __init__(self, problem: Problem, longest: float, turn: float):
        self.problem, self.longest, self.turn = problem, longest, turn
        size = len(problem.load)
        stiffness = problem.derivatives(np.zeros(size))[1]
        self._rounding = ROUNDING * float(eigvalsh(stiffness)[-1])
        self.scale = float(np.linalg.norm(np.linalg.solve(stiffness, problem.load)))
        start = np.zeros(size + 1)
        self.places = [self._place(start, np.append(start[:-1], 1.0))]
        self.lengths, self.points = [0.0], []
        self._length = longest

    def _bordered(self, hessian: np.ndarray, row: np.ndarray) -> np.ndarray:
        return np.block([[hessian, -self.problem.load[:, None] / self.scale], [row[None, :]]])

    def _place(self, z: np.ndarray, forward: np.ndarray) -> Place:
        hessian = self.problem.derivatives(z[:-1])[1]
        tangent = np.linalg.solve(self._bordered(hessian, forward), np.append(np.zeros(len(z) - 1), 1.0))
        return Place(z, tangent / np.linalg.norm(tangent), eigvalsh(hessian))

    def ahead(self, place: Place, length: float) -> Place:
        """The equilibrium whose distance from a place along the tangent there is `length`."""
        if not length:
            return place
        z = place.z + length * place.tangent
        for _ in range(15):
            gradient, hessian = self.problem.derivatives(z[:-1])
            residual = np.append(gradient - z[-1] / self.scale * self.problem.load,
                                 place.tangent @ (z - place.z) - length)
            if np.linalg.norm(residual) < self._rounding:
                return self._place(z, place.tangent)
            change = np.linalg.solve(self._bordered(hessian, place.tangent), -residual)
            z = z + change
            if np.linalg.norm(change) > length:
                break
            if np.linalg.norm(change) < 1e-11 * length:
                return self._place(z, place.tangent)
        raise Undecided("Newton's method does not converge")

    def step(self) -> None:
        """Add a place, and the critical points on the way there."""
        here = self.places[-1]
        while True:
            try:
                there = self.ahead(here, self._length)
                turn = float(np.arccos(np.clip(here.tangent @ there.tangent, -1.0, 1.0)))
                if turn <= self.turn:
                    points = self._points(here, there)
                    break
            except (Undecided, np.linalg.LinAlgError):
                pass
            self._length /= 2
            if self._length < 1e-7 * self.longest:
                raise Undecided("no step is short enough")
        self.points += points
        self.places.append(there)
        self.lengths.append(self.lengths[-1] + self._length)
        self._length = min(self.longest, self._length * (2.0 if turn < self.turn / 3 else 1.0))

    def _points(self, here: Place, there: Place) -> list[Point]:
        """Critical points of a step, in order."""
        known = {0.0: here, self._length: there}

        def at(length: float) -> Place:
            if length not in known:
                known[length] = self.ahead(here, length)
            return known[length]

        def root(function) -> float:
            return float(brentq(lambda s: function(at(s)), 0.0, self._length, xtol=1e-11 * self._length, rtol=1e-14))

        found = []
        if here.tangent[-1] * there.tangent[-1] < 0:
            found.append(("limit", root(lambda place: place.tangent[-1])))
        numbers = range(*sorted((here.unstable, there.unstable)))
        zeros = sorted(root(lambda place, n=n: place.values[n]) for n in numbers)
        for n in numbers:
            self._check([place.values[n] for place in known.values()], there.values)
        if found:
            limit = found[0][1]
            if not zeros:
                raise Undecided("an extremum of the load without a singular tangent")
            zeros.remove(min(zeros, key=lambda s: abs(s - limit)))
        found += [("bifurcation", zero) for zero in zeros]
        return self._grouped([(kind, at(s).z[-1] / self.scale, self.lengths[-1] + s)
                              for kind, s in sorted(found, key=lambda one: one[1])])

    def _check(self, found: list[float], all_values: np.ndarray) -> None:
        """Refuse an eigenvalue that changes its sign without passing zero: a jump from one path to another."""
        least, ends = np.abs(found).min(), max(map(abs, found[:2]))
        if least > PASSED * ends + ROUNDING * np.abs(all_values).max():
            raise Undecided("an eigenvalue changes sign without passing zero")

    def _grouped(self, found: list[tuple[str, float, float]]) -> list[Point]:
        points: list[Point] = []
        for kind, factor, along in found:
            last = points[-1] if points else None
            if last and last.kind == kind == "bifurcation" and abs(factor - last.factor) <= SAME * abs(factor):
                points[-1] = Point(kind, last.factor, last.multiplicity + 1, last.along)
            else:
                points.append(Point(kind, factor, 1, along))
        return points
