"""Equilibrium of a few modes about a critical point, and where its stable states end.

With amplitudes a of the modes, a change d of the load factor and coefficients c of imperfections it is

    k_ij a_j - d f_i + (p_im + d q_im) c_m + (d B_ij + c_m D_ijm) a_j + A_ijk a_j a_k / 2 + C_ijkl a_j a_k a_l / 6 = 0

(Byskov and Hutchinson 1977, with the terms q and D of imperfections besides). Stable states are followed from the
perfect structure's below its critical load to the imperfections, and on with the load, without leaving their way.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from .. import rounding

BELOW = 0.01, 0.02, 0.05, 0.1, 0.2, 0.4, 0.8  # of the critical load factor, how far below it a path may begin
PART, BENT = 0.02, 0.5  # longest part of a way in one step; change of amplitudes off their tangent over that along
EXACT = 1e-8  # part of a way, shortest step
NEAR = 1e-3  # correction of amplitudes over them that is small
ITERATIONS, FEW = 50, 6  # of searches, and of Newton's method along a way


@dataclass(frozen=True)
class StableEnd:
    """A state where stable ones end.

    Attributes
    ----------
    amplitudes : of the modes, shape (n,)
    change : of the load factor since the critical point
    coefficients : of the imperfections, shape (m,)
    null : null vector, shape (n,)
    """

    amplitudes: np.ndarray
    change: float
    coefficients: np.ndarray
    null: np.ndarray


@dataclass(frozen=True)
class AmplitudeEquations:
    """The equations of n modes and m imperfections about a critical point.

    Attributes
    ----------
    factor : load factor of the critical point
    stiffness, load : k, shape (n, n), and f, shape (n,)
    softening : B, shape (n, n)
    cubic, quartic : A, shape (n, n, n), and C, shape (n, n, n, n), symmetric
    pushes, steeper : p and q, shape (m, n)
    changes : D, shape (m, n, n)
    """

    factor: float
    stiffness: np.ndarray
    load: np.ndarray
    softening: np.ndarray
    cubic: np.ndarray
    quartic: np.ndarray
    pushes: np.ndarray
    steeper: np.ndarray
    changes: np.ndarray

    def _energy(self, a: np.ndarray, change: float, c: np.ndarray) -> float:
        forces = c @ (self.pushes + change * self.steeper) - change * self.load
        return (self._tangent_without(change, c) @ a / 2 + forces + self.cubic @ a @ a / 6
                + self.quartic @ a @ a @ a / 24) @ a

    def forces(self, a: np.ndarray, change: float, c: np.ndarray) -> np.ndarray:
        cubic, quartic_ = self.cubic @ a @ a, self.quartic @ a @ a @ a
        return (self._tangent_without(change, c) @ a - change * self.load + c @ (self.pushes + change * self.steeper)
                + cubic / 2 + quartic_ / 6)

    def tangent(self, a: np.ndarray, change: float, c: np.ndarray) -> np.ndarray:
        return self._tangent_without(change, c) + self.cubic @ a + self.quartic @ a @ a / 2

    def _tangent_without(self, change: float, c: np.ndarray) -> np.ndarray:
        return self.stiffness + change * self.softening + np.tensordot(c, self.changes, 1)

    def by_load(self, a: np.ndarray, c: np.ndarray) -> np.ndarray:
        """Derivative of the forces by the load factor."""
        return self.softening @ a - self.load + c @ self.steeper

    def by_shapes(self, a: np.ndarray, change: float) -> np.ndarray:
        """Derivatives of the forces by the coefficients, shape (m, n)."""
        return self.pushes + change * self.steeper + self.changes @ a

    def _balanced(self, a: np.ndarray, change: float, c: np.ndarray) -> np.ndarray | None:
        """Amplitudes of a stable equilibrium near others; None: Newton's method finds none."""
        for _ in range(FEW):
            step = np.linalg.solve(self.tangent(a, change, c), -self.forces(a, change, c))
            a = a + step
            if np.linalg.norm(step) <= NEAR**3 * np.linalg.norm(a):
                stable = np.linalg.eigvalsh(self.tangent(a, change, c))[0] > 0
                return a if stable else None
        return None

    @cached_property
    def _perfect(self) -> list[tuple[np.ndarray, float]]:
        """Amplitudes and changes of the load factor of stable states without imperfections, the nearest first."""
        change, none, found = -BELOW[0] * self.factor, np.zeros(len(self.pushes)), []
        a = self._descended(change, none)
        for below in BELOW if a is not None else ():
            before, change = change, -below * self.factor
            a, there = self._followed(a, before, change - before, none, none)
            if there < 1:
                break
            found.append((a, change))
        return found

    def _begun(self, c: np.ndarray) -> tuple[np.ndarray, float]:
        """Amplitudes and change of the load factor of a stable equilibrium, to which the perfect structure's leads.

        Raises
        ------
        ValueError
            If there is none.
        """
        for a, change in self._perfect:
            found, there = self._followed(a, change, 0.0, np.zeros_like(c), c)
            if there == 1:
                return found, change
        raise ValueError(f"AmplitudeEquations: at {1 - BELOW[-1]:.0%} of the critical load no stable way leads to the "
                         f"imperfections {', '.join(f'{n:.4g}' for n in c)}; take smaller ones")

    def _followed(self, a: np.ndarray, change: float, rise: float, c: np.ndarray,
                  more: np.ndarray) -> tuple[np.ndarray, float]:
        """Stable equilibria while load factor and coefficients change evenly, and the part at which they end."""
        there, part = 0.0, PART
        while there < 1 and part > EXACT:
            part, here = min(part, 1 - there), (change + there * rise, c + there * more)
            by_part = rise * self.by_load(a, here[1]) + more @ self.by_shapes(a, here[0])
            rate = -part * np.linalg.solve(self.tangent(a, *here), by_part)
            ahead = self._balanced(a + rate, change + (there + part) * rise, c + (there + part) * more)
            off = np.inf if ahead is None else np.linalg.norm(ahead - a - rate)
            if ahead is None or off > BENT * np.linalg.norm(rate) + NEAR * np.linalg.norm(a):
                part /= 2
            else:
                a, there, part = ahead, there + part, min(1.5 * part, PART)
        return a, there

    def _descended(self, change: float, c: np.ndarray) -> np.ndarray | None:
        """Amplitudes of the equilibrium that the energy falls to from none; None: it falls without end."""
        a = np.zeros(len(self.load))
        for _ in range(ITERATIONS):
            sizes, ways = np.linalg.eigh(self.tangent(a, change, c))
            sizes_ = np.maximum(np.abs(sizes), rounding.SAME * np.abs(sizes).max())
            step = -ways @ (ways.T @ self.forces(a, change, c) / sizes_)
            if sizes[0] > 0 and np.linalg.norm(step) <= NEAR * np.linalg.norm(a + step):
                return self._balanced(a + step, change, c)
            energy = self._energy(a, change, c)
            while self._energy(a + step, change, c) > energy:
                step = step / 2
            a = a + step
        return None

    def end(self, c: np.ndarray) -> StableEnd | None:
        """Where stable states end as the load grows; None: they do not, up to about twice the critical load.

        Raises
        ------
        ValueError
            If no stable way leads to the imperfections.
        """
        a, change = self._begun(c)
        rise = 2 * self.factor
        a, there = self._followed(a, change, rise, c, np.zeros_like(c))
        if there == 1:
            return None
        change += there * rise
        return StableEnd(a, change, c, np.linalg.eigh(self.tangent(a, change, c))[1][:, 0])
