"""Equilibrium of a few modes about a critical point, and where its stable states end.

With amplitudes a of the modes, a change d of the load factor and coefficients c of imperfections it is

    k_ij a_j - d f_i + (p_im + d q_im) c_m + (d B_ij + c_m D_ijm) a_j + A_ijk a_j a_k / 2 + C_ijkl a_j a_k a_l / 6 = 0

(Byskov and Hutchinson 1977, with the terms q and D of imperfections besides). Stable states are followed from the
perfect structure's below its critical load to the imperfections, and on with the load, as the solution of the
differential equation of their way by its arc length (Davidenko 1953), up to where an eigenvalue of the tangent is zero.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import minimize

from .. import rounding

BELOW = 0.01, 0.02, 0.05, 0.1, 0.2, 0.4, 0.8  # of the critical load factor, how far below it a path may begin


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

    @cached_property
    def _perfect(self) -> list[tuple[np.ndarray, float]]:
        """Amplitudes and changes of the load factor of stable states without imperfections, the nearest first."""
        change, none, found = -BELOW[0] * self.factor, np.zeros(len(self.pushes)), []
        a = self._lowest(change, none)
        for below in BELOW if a is not None else ():
            before, change = change, -below * self.factor
            a, there = self._followed(a, before, change - before, none, none)
            if there < 1:
                break
            found.append((a, change))
        return found

    def _begun(self, c: np.ndarray) -> tuple[np.ndarray, float]:
        """Amplitudes and change of the load factor of a stable equilibrium, to which that of the perfect one leads.

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
        sense = np.eye(1 + len(a))[0]

        def here(way):
            return way[1:], change + way[0] * rise, c + way[0] * more

        def rate(_, way):
            nonlocal sense
            a, change, c = here(way)
            by_part = rise * self.by_load(a, c) + more @ self.by_shapes(a, change)
            found = np.linalg.svd(np.column_stack((by_part, self.tangent(a, change, c))))[2][-1]
            sense = found * np.copysign(1.0, found @ sense)
            return sense

        def left(_, way):
            return 1.0 - way[0]

        def lowest(_, way):
            return np.linalg.eigvalsh(self.tangent(*here(way)))[0]

        left.terminal = lowest.terminal = True
        found = solve_ivp(rate, (0.0, np.inf), np.array([0.0, *a]), "DOP853", events=(left, lowest),
                          rtol=rounding.NONE, atol=rounding.SAME)
        there, *a = found.y[:, -1]
        return np.array(a), 1.0 if len(found.t_events[0]) else float(there)

    def _lowest(self, change: float, c: np.ndarray) -> np.ndarray | None:
        """Amplitudes of the equilibrium that the energy falls to from none; None: it falls without end."""
        none, size = np.zeros(len(self.load)), abs(change) * np.linalg.norm(self.softening)
        found = minimize(self._energy, none, (change, c), "trust-exact", self.forces, self.tangent,
                         options={"gtol": rounding.DIFFERENCE**2 * size})
        return found.x if found.success else None

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
