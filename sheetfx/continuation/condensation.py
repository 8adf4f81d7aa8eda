"""Forces of pairs found exactly within each Newton iteration, on the flexibility of the structure at the pairs.

A pair acts on the many unknowns of its cells, but by few forces: those on its gap and slips e. With G their
derivatives, s(e) the law and D its moduli, the step in which the law holds on what else is linear is

    dx = K^-1 (-R - G^T q),   q = s(e + G dx) - s(e) - D G dx,

where q is zero for pairs that stay open, or stay pressed and stick. The structure is condensed onto the others,
C = G K^-1 G^T (thesis, equations 4.5 to 4.12, onto all pairs), the problem is solved there, and dx follows. Without
friction it is a linear complementarity problem, which block pivots solve; with friction Newton's iteration does. The
laws have pieces (open, stick, slip), of which each pair passes one in an iteration, as Katzenelson (1965) does for one
pair at a time. Contacts that are not condensed are part of the linear problem.
"""

from __future__ import annotations

import numpy as np
from scipy.sparse import block_diag, csc_matrix, csr_matrix, vstack

from .. import rounding
from ..discrete.condensed_pairs import CondensedPairs
from .elimination import ITERATIONS, Elimination

NOTHING = 0.1  # of the error that is allowed, forces that are none
SOFTENED = [10.0**n for n in range(6, -1, -1)]  # times softer than they are, pairs through which forces are approached


class Condensation(Elimination):
    """Corrects the steps of a Newton iteration so that the laws of all pairs hold in the linearised structure.

    Its rows are gaps and slips of pairs, in the place of unknowns. Where parts lie on each other along their length,
    stiff pairs open and close by turns. Soft ones share the load, and as they become stiffer those open that do not
    carry any of it.
    """

    most, exact, can_do_without, softened = 600, 1e-3, True, SOFTENED

    @property
    def throughout(self) -> bool:  # type: ignore[override]
        return any(c.rubs for c in self._system.contributions)

    def _linearise(self) -> None:
        """Take forces and stiffness as they are, with the forces held for this iteration, and the laws without them."""
        pairs = [c for c in self._system.contributions if isinstance(c, CondensedPairs)]
        self._laws = [c.law_of_changes() for c in pairs]
        motions = [c.motions() for c in pairs]
        self._motions, self._ends = vstack(motions, format="csr"), np.cumsum([m.shape[0] for m in motions])[:-1]
        self._gaps = None if any(c.components > 1 for c in pairs) else np.concatenate([c.place() for c in pairs])
        self._alike = [c.alike for c in pairs]
        self._rows_of_pairs = np.concatenate([np.full(c.pairs.count, c.components) for c in pairs])
        self._before, self._stiff = self._after(np.zeros(self._motions.shape[0]))
        self._begin()
        for contribution in pairs:
            contribution.release()

    def _begin(self) -> None:
        """Linearise laws where the step starts."""
        self._at, self._forces_there = np.zeros(len(self._before)), self._before

    def _converge(self, forces: np.ndarray) -> np.ndarray | None:
        self._begin()
        found = None if self._gaps is None else self._by_pivots(forces)
        return super()._converge(forces) if found is None else found

    def _by_pivots(self, forces: np.ndarray) -> np.ndarray | None:
        """Forces of pairs without friction, at as many rows as it takes; None: not found."""
        solved = -1
        for _ in range(ITERATIONS):
            if (off := self._off(forces)) is None:
                return None
            forces = np.append(forces, np.zeros(len(off) - len(forces)))
            if np.linalg.norm(off) <= self._exact * self._size:
                return forces
            if len(off) == solved or (pivoted := self._pivoted(forces + off < 0)) is None:
                return None  # the law has more than the two pieces of contact
            forces, solved = pivoted, len(off)
        return None

    def _pivoted(self, basic: np.ndarray) -> np.ndarray | None:
        """Forces at the rows by pivots, where some are guessed to be there; None: not found.

        With y = -q, gaps g before the forces and stiffnesses k of closed pairs it is the complementarity problem

            y >= 0,    y / k - s (g + F y) >= 0,    one of both zero,

        where F is the flexibility at the rows and s is 1 for pairs that are pressed before, else -1. All rows that are
        wrong are changed while they become fewer, else the last one of them (Judice and Pires 1994; Murty 1974).
        """
        rows, moved = self._rows, self._moved
        closed = -np.abs(self._gaps) - np.abs(moved).max()
        pressures, moduli = self._after(closed)
        stiff, pressed = moduli.diagonal()[rows], np.where(self._stiff.diagonal()[rows] > 0, 1.0, -1.0)
        gaps = (moved - closed)[rows] + pressures[rows] / stiff
        matrix = np.diag(1 / stiff) - pressed[:, None] * self._flexibility[:, rows].T
        right = -pressed * gaps
        found, fewest = np.zeros(len(rows)), len(rows) + 1
        for _ in range(ITERATIONS * len(rows)):
            found[:] = 0.0
            try:
                found[basic] = np.linalg.solve(matrix[np.ix_(basic, basic)], -right[basic])
            except np.linalg.LinAlgError:
                return None
            wrong = np.where(basic, found / stiff, matrix @ found + right) < -rounding.SAME * np.abs(right).max()
            if not wrong.any():
                return -found
            if (count := wrong.sum()) >= fewest:
                wrong[:np.flatnonzero(wrong)[-1]] = False
            basic, fewest = basic ^ wrong, min(fewest, count)
        return None

    def _after(self, changes: np.ndarray) -> tuple[np.ndarray, csr_matrix]:
        """Forces on gaps and slips that have changed by so much, and their derivatives."""
        moduli = [law(part) for (_, law), part in zip(self._laws, np.split(changes, self._ends), strict=True)]
        return self._forces_after(changes), block_diag(moduli, format="csr")

    def _forces_after(self, changes: np.ndarray) -> np.ndarray:
        parts = np.split(changes, self._ends)
        return np.concatenate([law(part) for (law, _), part in zip(self._laws, parts, strict=True)])

    def _places(self, responses: np.ndarray) -> np.ndarray:
        return (self._motions @ responses.T).T

    def _beyond(self, changes: np.ndarray) -> np.ndarray:
        self._at = changes if self._is_patient or self._gaps is not None else self._toward(changes)
        self._forces_there, self._moduli = self._after(self._at)
        after = self._forces_there + self._moduli @ (changes - self._at)
        self._untold = self._forces_after(changes) - after
        beyond = after - self._before - self._stiff @ changes
        return np.where(np.abs(beyond) > NOTHING * self._exact * self._size, beyond, 0.0)

    def _error(self, off: np.ndarray) -> float:
        return float(np.linalg.norm(off + self._untold[self._rows]))

    def _toward(self, changes: np.ndarray) -> np.ndarray:
        """Where laws are linearised next: on the way to some changes, where each pair comes to another piece first.

        At the end of the way pairs that slip back would slip forth next, without sticking between, and pairs that
        close deeply would stick, because of a pressure that they do not have. First steps, in which hundreds of pairs
        close at once, go there all the same, and through softer pairs where that fails.
        """
        leave = ~self._stay(changes)
        way, low, high = changes - self._at, np.zeros(len(leave)), np.ones(len(leave))
        while leave.any() and (high - low).max() > rounding.SAME:
            middle = (low + high) / 2
            stay = self._stay(self._at + np.repeat(middle, self._rows_of_pairs) * way)
            low, high = np.where(stay, middle, low), np.where(stay, high, middle)
        return self._at + np.repeat(np.where(leave, high, 1.0), self._rows_of_pairs) * way

    def _stay(self, changes: np.ndarray) -> np.ndarray:
        """Whether pairs are on the pieces of their laws that they are linearised on."""
        found, there = (np.split(forces, self._ends) for forces in (self._forces_after(changes), self._forces_there))
        return np.concatenate([alike(*forces) for alike, *forces in zip(self._alike, found, there, strict=True)])

    def _stiffened(self) -> csr_matrix:
        return self._moduli - self._stiff

    def _units(self, rows: np.ndarray) -> csc_matrix:
        return self._motions[rows].T.tocsc()
