"""Forces of pairs found exactly within each Newton iteration, on the flexibility of the structure at the pairs.

A pair acts on the many unknowns of its cells, but by few forces: those on its gap and slips e. With G their
derivatives, s(e) the law and D its moduli, the step in which the law holds on what else is linear is

    dx = K^-1 (-R - G^T q),   q = s(e + G dx) - s(e) - D G dx,

where q is zero for pairs that stay open, or stay pressed and stick. The structure is condensed onto the others,
C = G K^-1 G^T (thesis, equations 4.5 to 4.12, onto all pairs), the problem is solved there, and dx follows.
"""

from __future__ import annotations

import numpy as np
from scipy.sparse import block_diag, csc_matrix, csr_matrix, vstack

from ..discrete.condensed_pairs import CondensedPairs
from .elimination import Elimination

NOTHING = 0.1  # of the error that is allowed, forces that are none
SOFTENED = [10.0**n for n in range(6, -1, -1)]  # times softer than they are, pairs through which forces are approached


class Condensation(Elimination):
    """Corrects the steps of a Newton iteration so that the laws of all pairs hold in the linearised structure.

    Its rows are gaps and slips of pairs, in the place of unknowns. Where parts lie on each other along their length,
    stiff pairs open and close by turns. Soft ones share the load, and as they become stiffer those open that do not
    carry any of it.
    """

    most, exact, can_do_without, softened = 600, 1e-3, True, SOFTENED

    def _linearise(self) -> None:
        """Take forces and stiffness as they are, with what is held for this iteration, and the laws without it."""
        pairs = [c for c in self._system.contributions if isinstance(c, CondensedPairs)]
        self._laws = [c.law_of_changes() for c in pairs]
        motions = [c.motions() for c in pairs]
        self._motions, self._ends = vstack(motions, format="csr"), np.cumsum([m.shape[0] for m in motions])[:-1]
        self._before, self._stiff = self._after(np.zeros(self._motions.shape[0]))
        for contribution in pairs:
            contribution.release()

    def _after(self, changes: np.ndarray) -> tuple[np.ndarray, csr_matrix]:
        """Forces on gaps and slips that have changed by so much, and their derivatives."""
        found = [law(part) for law, part in zip(self._laws, np.split(changes, self._ends), strict=True)]
        forces, moduli = zip(*found, strict=True)
        return np.concatenate(forces), block_diag(moduli, format="csr")

    def _beyond(self, step: np.ndarray) -> np.ndarray:
        changes = self._motions @ step
        forces, self._moduli = self._after(changes)
        beyond = forces - self._before - self._stiff @ changes
        return np.where(np.abs(beyond) > NOTHING * self._exact * self._size, beyond, 0.0)

    def _stiffened(self) -> csr_matrix:
        return self._moduli - self._stiff

    def _units(self, rows: np.ndarray) -> csc_matrix:
        return self._motions[rows].T.tocsc()

    def _motion(self, rows: np.ndarray, responses: np.ndarray) -> np.ndarray:
        motions = self._motions[rows]
        return np.array([motions @ response for response in responses]).reshape(len(responses), len(rows)).T
