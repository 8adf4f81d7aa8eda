"""Contact of a beam with an obstacle as a contribution to the system, with what it remembers."""

from __future__ import annotations

import numpy as np
from mpi4py import MPI

from .contact import OPEN, ContactFields, ContactState
from .fields import Fields
from .form_work import FormWork
from .origins import of_nodes
from .timing import Stopwatch

PENETRATION = 1e-6  # over the depth, that augmentation leaves


class ContactWork(FormWork):
    """Virtual work of the tractions of one contact.

    Multipliers that are not unknowns are its history: tractions that the next step starts from.

    Attributes
    ----------
    fields : ContactFields
    """

    called = "contact"

    def __init__(self, of_scene: Fields, fields: ContactFields, clock: Stopwatch):
        unknowns = of_scene.unknowns
        super().__init__(unknowns, fields.work(unknowns.vary), smooth=False, conservative=not fields.contact.friction)
        self.fields, self._clock = fields, clock
        self._kept = fields.multiplier if fields.block is None else None
        self.augments = fields.enforcement != "penalty"
        if self.augments:
            self.without_fall = (f"contact with enforcement {fields.enforcement!r} has no energy between its "
                                 "solutions; use Contact(..., enforcement='penalty') or a layer")
        self._keep()

    def _keep(self) -> None:
        """Take the multipliers as they are for the last accepted state's."""
        self._committed = None if self._kept is None else self._kept.x.array.copy()

    def commit(self) -> None:
        if self._kept is not None:
            self.fields.store(self._state(), normal=self.fields.enforcement == "uzawa")
        self._keep()

    def snapshot(self) -> dict[str, np.ndarray]:
        return {} if self._kept is None else {self._kept.name: self._kept.x.array.copy()}

    def origins(self) -> dict[str, np.ndarray]:
        return dict.fromkeys(self.snapshot(), of_nodes(self.fields.multiplier.function_space))

    def restore(self, snapshot: dict[str, np.ndarray]) -> None:
        if self._kept is not None:
            self._kept.x.array[:] = snapshot[self._kept.name]
        self._keep()

    def rewind(self) -> None:
        if self._kept is not None:
            self._kept.x.array[:] = self._committed

    def regularise(self, times: float) -> None:
        self.fields.thicken(times)

    def augment(self) -> bool:
        if self.fields.enforcement != "uzawa":
            return True
        state = self._state()
        if penetration(self.fields, state) <= PENETRATION * self.fields.contact.beam.section.depth:
            return True
        self.fields.store(state, normal=True)
        return False

    def touch(self) -> np.ndarray | None:
        """Gaps where pressed, pressures and weights in the columns; None: what slips is not known."""
        if self.fields.contact.friction:
            return None
        state = self._state()
        return np.column_stack((np.where(state.pressure > 0, state.gap, 0.0), state.pressure, state.weight))

    def work_between(self, start: np.ndarray, end: np.ndarray) -> float:
        deeper, pressures = start[:, 0] - end[:, 0], (start[:, 1] + end[:, 1]) / 2
        return self.fields.contact.beam.mesh.comm.allreduce(float(end[:, 2] @ (pressures * deeper)))

    def apart(self) -> bool:
        state, comm = self._state(), self.fields.contact.beam.mesh.comm
        return comm.allreduce(bool(((state.status == OPEN) & (state.gap > 0)).all()), op=MPI.LAND)

    def touching(self) -> tuple[int, float]:
        with self._clock("contact"):
            return touching(self.fields)

    def _state(self) -> ContactState:
        with self._clock("contact"):
            return self.fields.evaluate()


def touching(fields: ContactFields) -> tuple[int, float]:
    """Number of points that touch and largest penetration, on all processes."""
    state = fields.evaluate()
    return fields.contact.beam.mesh.comm.allreduce(fields.touching(state)), penetration(fields, state)


def penetration(fields: ContactFields, state: ContactState) -> float:
    """Largest penetration at contact points, on all processes."""
    deepest = float(-state.gap.min(initial=np.inf))
    return max(0.0, fields.contact.beam.mesh.comm.allreduce(deepest, op=MPI.MAX))
