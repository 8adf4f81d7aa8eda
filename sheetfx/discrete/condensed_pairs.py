"""Pairs whose forces are found on the flexibility of the structure, see `continuation.condensation`."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.sparse import bsr_matrix

from .contact import SLIP
from .pair_work import PairWork

CLINGING = 1e300  # tensile strength of pairs that do not open


class CondensedPairs(PairWork):
    """Virtual work of pairs that also tells gaps and slips apart from the law in them."""

    condenses = True
    _pressed: np.ndarray | None = None  # pairs that were pressed where forces were found last

    @property
    def components(self) -> int:
        """Gap and slips of each pair."""
        return 1 + self._slips

    def freeze_open_contacts(self) -> bool:
        if self._pressed is None or not self._pressed.any() or not self.sticks:
            return False
        if (self.place()[self._pressed] <= 0).any():
            return False
        table = self._table.copy()
        table[self._pressed, 4] = CLINGING
        self._law.give(self._data_of_history + 1, table)
        return True

    def law_of_changes(self) -> tuple[Callable[[np.ndarray], np.ndarray], Callable[[np.ndarray], bsr_matrix]]:
        """Functions from changes of gaps and slips to forces on these, and to their derivatives; partners stay."""
        z, own = self.values(), self.components
        strains = self._law.strains(z)
        self._pressed = self._law.resultants(z)[:, 0] < 0

        def changed(changes: np.ndarray) -> np.ndarray:
            changed = strains.copy()
            changed[:, :own] += changes.reshape(-1, own)
            return changed

        def forces(changes: np.ndarray) -> np.ndarray:
            return self._law.resultants_of(changed(changes), z)[:, :own].ravel()

        def moduli(changes: np.ndarray) -> bsr_matrix:
            every = np.arange(len(strains) + 1)
            return bsr_matrix((self._law.moduli_of(changed(changes), z)[:, :own, :own], every[:-1], every))

        return forces, moduli

    def alike(self, forces: np.ndarray, others: np.ndarray) -> np.ndarray:
        """Whether pairs are open, stick or slip as by other forces, and do not slip the other way.

        Parameters
        ----------
        forces, others : as of `law_of_changes`
        """
        found = [f.reshape(-1, self.components) / self.pairs.weights[:, None] for f in (forces, others)]
        status, other = (self.pairs.status(-f[:, 0], f[:, 1:], self._slack) for f in found)
        back = (status == SLIP) & ((found[0] * found[1])[:, 1:].sum(axis=1) < 0)
        return (status == other) & ~back
