"""Contributions at nodes: forces at points, and the rows of increments that are zero."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from .contribution import Contribution, Forces
from .layout import Layout


class NodalLoads(Contribution):
    """Forces and moments at nodes, times the load factor of their stage.

    Parameters
    ----------
    arrays : for each block the forces on its local dofs for a load factor of 1; None: none on this block
    factor : function that gives the load factor
    stage : number of the load stage
    conservative : whether the moments among them have a potential
    """

    gives_moments = True

    def __init__(self, arrays: Sequence[np.ndarray | None], factor, stage: int, conservative: bool):
        self._arrays, self._factor = arrays, factor
        self.stage, self.conservative = stage, conservative

    def residual(self, forces: Forces) -> None:
        self._add(forces, -self._factor())

    def load(self, forces: Forces) -> None:
        self._add(forces, 1.0)

    def _add(self, forces: Forces, times: float) -> None:
        for total, array in zip(forces.along_space, self._arrays, strict=True):
            if array is not None:
                total += times * array


class FixedIncrements(Contribution):
    """The equations of increments that supports hold at zero.

    Attributes
    ----------
    stiffness : on the diagonal
    """

    stiffness = 1.0

    def pattern(self, layout: Layout) -> tuple[np.ndarray, np.ndarray]:
        rows = layout.fixed.astype(np.int64) + layout.start
        self._ones = np.ones(len(rows))
        return rows, rows

    def tangent(self, held: Forces) -> Sequence[np.ndarray]:
        return [self.stiffness * self._ones]

    def energy(self) -> float:
        return 0.0
