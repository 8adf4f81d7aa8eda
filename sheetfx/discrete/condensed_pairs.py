"""Pairs whose forces are found on the flexibility of the structure, see `continuation.condensation`."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.sparse import bsr_matrix

from .pair_work import PairWork

CLINGING = 1e300  # tensile strength of pairs that do not open


class CondensedPairs(PairWork):
    """Virtual work of pairs that also tells gaps and slips apart from the law in them."""

    condenses = True
    _pressed: np.ndarray | None = None  # pairs that were pressed where forces were found last

    def freeze_open_contacts(self) -> bool:
        if self._pressed is None or not self._pressed.any() or not self.sticks:
            return False
        if (self.place()[self._pressed] <= 0).any():
            return False
        table = self._table.copy()
        table[self._pressed, 4] = CLINGING
        self._law.give(self._data_of_history + 1, table)
        return True

    def law_of_changes(self) -> Callable[[np.ndarray], tuple[np.ndarray, bsr_matrix]]:
        """Function from changes of gaps and slips to forces on these, and their derivatives; partners stay."""
        z, own = self.values(), 1 + self._slips
        strains = self._law.strains(z)
        self._pressed = self._law.resultants(z)[:, 0] < 0

        def law(changes: np.ndarray) -> tuple[np.ndarray, bsr_matrix]:
            changed = strains.copy()
            changed[:, :own] += changes.reshape(-1, own)
            forces, moduli = self._law.at_strains(changed, z)
            every = np.arange(len(strains) + 1)
            return forces[:, :own].ravel(), bsr_matrix((moduli[:, :own, :own], every[:-1], every))

        return law
