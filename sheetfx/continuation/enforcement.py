"""How one step's equilibrium with contact is reached."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from mpi4py import MPI

from ..discrete.contact import ContactFields, ContactState
from ..discrete.timing import Stopwatch


class Enforcement:
    """Solves a step with all contacts: approach through thicker layers, then augmentation.

    Parameters
    ----------
    contacts : ContactFields
    """

    augmentations = 30

    def __init__(self, contacts: Sequence[ContactFields], clock: Stopwatch):
        self.contacts, self.clock = list(contacts), clock
        self._kept = [c.multiplier for c in contacts if c.block is None]
        self._committed = [m.x.array.copy() for m in self._kept]

    def approaches(self) -> list[list[float]]:
        """Sequences of layers to try: through thick ones to the final one, then directly.

        Thick layers make long steps converge; a step shorter than their indentation fails in them.
        """
        times = sorted({1.0, *(t for c in self.contacts if c.layer for t in c.contact.approach)}, reverse=True)
        return [times, [1.0]] if len(times) > 1 else [[1.0]]

    def solve(self, solve: Callable[[], bool], layers: Sequence[float]) -> bool:
        """Call `solve`, which corrects from where it ended last, until all contacts hold."""
        for times in layers:
            for c in self.contacts:
                c.thicken(times)
            if not solve():
                self._reset()
                return False
        return self._augment(solve)

    def _augment(self, solve) -> bool:
        uzawa = [c for c in self.contacts if c.enforcement == "uzawa"]
        for _ in range(self.augmentations if uzawa else 0):
            states = [self.state(c) for c in uzawa]
            if all(self.penetration(c, s) <= 1e-6 * c.contact.beam.section.depth
                   for c, s in zip(uzawa, states, strict=True)):
                return True
            for c, state in zip(uzawa, states, strict=True):
                c.store(state, normal=True)
            if not solve():
                self.rewind()
                return False
        if uzawa:
            self.rewind()
        return not uzawa

    def _reset(self) -> None:
        for c in self.contacts:
            c.thicken(1.0)
        self.rewind()

    def state(self, contact: ContactFields) -> ContactState:
        with self.clock("contact"):
            return contact.evaluate()

    def penetration(self, contact: ContactFields, state: ContactState) -> float:
        """Largest penetration at contact points, on all processes."""
        comm = contact.contact.beam.model.mesh.comm
        return max(0.0, comm.allreduce(float(-state.gap.min(initial=np.inf)), op=MPI.MAX))

    def summary(self) -> tuple[int, float]:
        """Number of points that touch and largest penetration, on all processes."""
        touching, penetration = 0, 0.0
        for c in self.contacts:
            state = self.state(c)
            touching += c.contact.beam.model.mesh.comm.allreduce(c.touching(state))
            penetration = max(penetration, self.penetration(c, state))
        return touching, penetration

    def commit(self) -> None:
        """Keep tractions that the next step starts from."""
        for c in self.contacts:
            if c.block is None:
                c.store(self.state(c), normal=c.enforcement == "uzawa")
        self.keep()

    def keep(self) -> None:
        """Take the multipliers as they are for those of the last converged state."""
        self._committed = [m.x.array.copy() for m in self._kept]

    def rewind(self) -> None:
        for multiplier, values in zip(self._kept, self._committed, strict=True):
            multiplier.x.array[:] = values
