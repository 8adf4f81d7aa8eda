"""Trusses with engineering strain by numpy and scipy alone: equilibrium, and critical points of symmetric paths."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg import null_space
from scipy.optimize import brentq


@dataclass
class Truss:
    """Bars of axial stiffness 1.

    Attributes
    ----------
    places : undeformed nodes, shape (n, d)
    bars : pairs of nodes, shape (m, 2)
    free : numbers of free nodes
    load : on the free nodes for a load factor of 1, shape (free nodes, d)
    """

    places: np.ndarray
    bars: np.ndarray
    free: list[int]
    load: np.ndarray

    def derivatives(self, moves: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Gradient and Hessian of the energy sum (l - L)^2 / (2 L) by the displacements of the free nodes."""
        count, d = self.places.shape
        x = self.places.astype(float).copy()
        x[self.free] += moves.reshape(-1, d)
        ends = np.eye(count)[self.bars[:, 1]] - np.eye(count)[self.bars[:, 0]]
        whole, length = (np.linalg.norm(ends @ places, axis=1) for places in (self.places, x))
        along = ends @ x / length[:, None]
        force, outer = (length - whole) / whole, np.einsum("ki,kj->kij", along, along)
        blocks = outer / whole[:, None, None] + (force / length)[:, None, None] * (np.eye(d) - outer)
        free = ends[:, self.free]
        hessian = np.einsum("kn,km,kij->nimj", free, free, blocks, optimize=True).reshape((d * len(self.free),) * 2)
        return (free.T @ (force[:, None] * along)).ravel(), hessian

    def equilibrium(self, load: np.ndarray, start: np.ndarray | float = 0.0) -> np.ndarray | None:
        """Displacements of the free nodes under a load, by Newton's method from others; None if it leads far away.

        Parameters
        ----------
        load, start : shape (free nodes, d), as is the result
        """
        moves = np.zeros(load.size) + np.ravel(start)
        for _ in range(30):
            gradient, hessian = self.derivatives(moves)
            change = np.linalg.solve(hessian, load.ravel() - gradient)
            moves = moves + change
            if np.linalg.norm(change) < 1e-11:
                return moves.reshape(load.shape)
            if np.linalg.norm(change) > 3:
                return None
        return None


class SymmetricPath:
    """The path of a truss under growing load, among displacements of one symmetry.

    Steps of pseudo-arclength in z, the amplitudes of the symmetric displacements and the load factor, with
    Newton's method.

    Parameters
    ----------
    symmetric : orthonormal columns that span the displacements
    """

    def __init__(self, truss: Truss, symmetric: np.ndarray):
        self.truss, self.symmetric, self.others = truss, symmetric, null_space(symmetric.T)
        self.load = symmetric.T @ truss.load.ravel()

    def _derivatives(self, z):
        return self.truss.derivatives(self.symmetric @ z[:-1])

    def _matrix(self, z, direction):
        hessian = self.symmetric.T @ self._derivatives(z)[1] @ self.symmetric
        return np.block([[hessian, -self.load[:, None]], [direction[None, :]]])

    def forward(self, z, direction):
        """Unit tangent on the side of a direction."""
        tangent = np.linalg.solve(self._matrix(z, direction), np.append(np.zeros(len(z) - 1), 1.0))
        return tangent / np.linalg.norm(tangent)

    def place(self, z, direction, step):
        """The place whose distance from z along a direction is `step`."""
        there = z + step * direction
        for _ in range(50):
            balance = self.symmetric.T @ self._derivatives(there)[0] - there[-1] * self.load
            residual = np.append(balance, direction @ (there - z) - step)
            change = np.linalg.solve(self._matrix(there, direction), -residual)
            there = there + change
            if np.linalg.norm(change) < 1e-13 * np.linalg.norm(there):
                break
        return there

    def eigenvalues(self, z, kind):
        """Of the Hessian on the path's symmetry, which vanish at limit points, and on its complement."""
        basis = self.symmetric if kind == "limit" else self.others
        return np.linalg.eigvalsh(basis.T @ self._derivatives(z)[1] @ basis)

    def critical_points(self, until, length: float) -> list[tuple[str, float, int]]:
        """Kind, load factor and multiplicity of all critical points in order.

        Parameters
        ----------
        until : function of the displacements that is true where the path ends
        length : of a step; small beside the distance of critical points
        """
        z, found = np.zeros(self.symmetric.shape[1] + 1), []
        direction = self.forward(z, np.append(np.zeros(len(z) - 1), 1.0))
        while not until(self.symmetric @ z[:-1]):
            steps = sorted((step, kind) for kind in ("limit", "bifurcation")
                           for step in self._zeros(z, direction, length, kind))
            for step, kind in dict.fromkeys((round(step / length, 6), kind) for step, kind in steps):
                multiplicity = sum(k == kind and round(s / length, 6) == step for s, k in steps)
                found.append((kind, self.place(z, direction, step * length)[-1], multiplicity))
            z = self.place(z, direction, length)
            direction = self.forward(z, direction)
        return found

    def _zeros(self, z, direction, length, kind) -> list[float]:
        """Where in a step eigenvalues vanish."""
        def values(step):
            return self.eigenvalues(self.place(z, direction, step), kind)

        changed = np.flatnonzero(values(0.0) * values(length) < 0)
        return [brentq(lambda step, n=n: values(step)[n], 0.0, length, xtol=1e-12 * length) for n in changed]
