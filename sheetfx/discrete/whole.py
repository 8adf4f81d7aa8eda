"""Fields as one process would have them: where parts meet, each process knows all that may touch.

Work of pairs of points of two parts is done by every process for all of them, from nodal values that all have gathered,
and each takes the forces on its own nodes. So partners may stand, and slide, anywhere, and all processes decide alike.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from dolfinx import fem

from ..communicators import lasting
from .nodal_field import AdditiveField


class WholeField:
    """The nodes of a field on all processes, with the methods of the field that traces need.

    All that gathers is called on all processes.

    Parameters
    ----------
    field : as this process has it
    origins : of the nodes of all processes, in the order in which they are to be
    space : of the whole mesh, with its nodes in that order; None: the field has none
    """

    def __init__(self, field: AdditiveField, origins: np.ndarray, space: fem.FunctionSpace | None = None):
        self._field, self._own, self._comm = field, field.index_map.size_local, lasting(field.index_map.comm)
        self.components, self.width, self.curved = field.components, field.width, field.curved
        self.space: Any = space
        self._counts = np.array(self._comm.allgather(self._own))
        known = self._gathered(field.origins)
        order = np.argsort(known)
        self._order = order[np.searchsorted(known, origins, sorter=order)]
        start = self._counts[:self._comm.rank].sum()
        self._mine = np.flatnonzero((self._order >= start) & (self._order < start + self._own))
        self._local = self._order[self._mine] - start

    def _gathered(self, rows: np.ndarray) -> np.ndarray:
        """Rows of all processes, one behind the other, from this process's and its ghosts', which come last."""
        own, width = np.ascontiguousarray(rows[:self._own]), int(np.prod(rows.shape[1:]))
        found = np.empty((self._counts.sum(), *rows.shape[1:]), rows.dtype)
        self._comm.Allgatherv(own, [found, self._counts * width])
        return found

    def seen(self, rows: np.ndarray) -> np.ndarray:
        """Rows for all nodes, from the rows of this process and its ghosts."""
        return self._gathered(rows)[self._order]

    @property
    def table(self) -> np.ndarray:
        """Values of the nodes, shape (nodes, components)."""
        return self.seen(self._field.table)

    def variations(self) -> np.ndarray:
        """Nodal variations by a unit increment, shape (nodes, components, width)."""
        f = self._field
        return self.seen(np.broadcast_to(f.variations(), (len(f.table), f.components, f.width)))

    def add(self, total: np.ndarray, nodes: np.ndarray, values: np.ndarray) -> None:
        """Add values at nodes to an array of this process's nodes, as far as it owns them."""
        found = np.zeros((len(self._order), *total.shape[1:]))
        np.add.at(found, nodes, values)
        total[self._local] += found[self._mine]
