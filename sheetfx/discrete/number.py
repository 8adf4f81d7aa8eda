"""Single numbers as unknowns, without a finite element space."""

from __future__ import annotations

import numpy as np
import ufl
from dolfinx.common import IndexMap
from dolfinx.fem import Constant
from mpi4py import MPI

from ..compat import index_map
from .nodal_field import AdditiveField


class Number:
    """A single number that all processes share, or one for each of several points, without a finite element space.

    Attributes
    ----------
    name : of the number
    x : holder of `array`, the entries on this process, as a Function has it
    """

    def __init__(self, name: str, count: int = 1):
        self.name, self.x, self.array = name, self, np.zeros(count)


class NumberField(AdditiveField):
    """Numbers as unknowns: the travel of an obstacle, the multiplier of a joint.

    Parameters
    ----------
    name : of the number
    index_map : of its entries
    domain : mesh of the forms that the number occurs in, of one number that all processes share; None: it occurs in
        none
    origins : of the entries

    Attributes
    ----------
    symbol : UFL variable that stands for the number in forms
    variation : UFL constant that stands for its variation there
    """

    components = width = 1

    origins = np.zeros(1, dtype=np.int64)

    def __init__(self, name: str, index_map: IndexMap, scale: float, multiplier: bool = False, domain=None,
                 origins: np.ndarray | None = None):
        count = index_map.size_local + index_map.num_ghosts
        self.value, self.previous = Number(name, count), Number(name, count)
        self.dofs, self.scale, self.multiplier, self._index_map = np.arange(count), scale, multiplier, index_map
        if origins is not None:
            self.origins = origins
        self.symbol = None
        if domain is not None:
            self._now, self._before, self.variation = (Constant(domain, 0.0) for _ in range(3))
            self.symbol = ufl.variable(self._now)

    @property
    def index_map(self) -> IndexMap:
        return self._index_map

    @property
    def count(self) -> int:
        return self._index_map.size_global

    def advance(self, block_increment):
        super().advance(block_increment)
        self._show()

    def rebase(self):
        super().rebase()
        self._show()

    def restore(self, values):
        super().restore(values)
        self._show()

    def show(self, values):
        super().show(values)
        self._show()

    def create_change(self) -> Number:
        return Number(self.value.name, len(self.value.x.array))

    def start(self, value: float) -> None:
        """Put the number to a value before the path begins."""
        self.restore(np.full_like(self.value.x.array, value))

    def _show(self) -> None:
        """Let forms see the present values."""
        if self.symbol is not None:
            self._now.value, self._before.value = self.value.x.array[0], self.previous.x.array[0]

    def earlier(self) -> dict:
        """Replacement of the number in forms by its value at the last converged state."""
        return {self.symbol: self._before}


def shared_by_all(comm: MPI.Comm) -> IndexMap:
    """Distribution of one number that process 0 owns and all others have as a ghost."""
    ghosts = np.zeros(int(comm.rank > 0), dtype=np.int64)
    return index_map(comm, int(comm.rank == 0), ghosts, ghosts.astype(np.int32))
