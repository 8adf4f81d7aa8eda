"""What a problem remembers: the values that increments count from, and the history of its contributions."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager

import numpy as np

from .contribution import Contribution
from .nodal_field import AdditiveField


class History:
    """The one list of all that a state consists of.

    Two acts move it on. *Rebasing* lets increments count from the present values: every converged configuration does,
    those on the way of a fall too. *Committing* accepts the present state: slip, multipliers and plastic strains of
    contributions take it for the start of the next step.

    Parameters
    ----------
    fields : unknown fields, in the order in which snapshots count them
    contributions : of the system
    """

    def __init__(self, fields: Sequence[AdditiveField], contributions: Sequence[Contribution]):
        self._fields, self._contributions = fields, contributions

    def rebase(self) -> None:
        """Let increments count from the present values."""
        for field in self._fields:
            field.rebase()

    def commit(self) -> None:
        """Accept the present state; increments count from it."""
        for contribution in self._contributions:
            contribution.commit()
        self.rebase()

    def update_history(self) -> bool:
        """Let laws move on to the present state; return whether tangents have changed.

        Within a step their moduli belong to a return from its start, which is shorter than the way that strains have
        gone, and like deformation theory's softer across it. Moduli of the comparison solid (Hill 1958) are the
        ones about the state itself.
        """
        changed = [contribution.update_history() for contribution in self._contributions]
        return any(changed)

    def rewind(self) -> None:
        """Forget what a failed step has changed in the history of contributions."""
        for contribution in self._contributions:
            contribution.rewind()

    @property
    def moved(self) -> bool:
        """Whether laws remember something, so that forces have no potential but for the comparison solid."""
        return any(contribution.history_moved for contribution in self._contributions)

    def moved_since(self, snapshot: dict[str, np.ndarray]) -> bool:
        """Whether laws remember something else than in an earlier state, as where points have flowed."""
        return any(contribution.history_moved_since(snapshot) for contribution in self._contributions)

    @contextmanager
    def frozen(self) -> Iterator[None]:
        """Let history stand still, so that forces are a smooth function of the increments since the last state.

        Laws with history are then linear, with the moduli of loading (the comparison solid of Hill 1958).
        """
        for contribution in self._contributions:
            contribution.freeze(True)
        try:
            yield
        finally:
            for contribution in self._contributions:
                contribution.freeze(False)

    def snapshot(self) -> dict[str, np.ndarray]:
        """All values at the last converged state on this process.

        Raises
        ------
        ValueError
            If two contributions use one name.
        """
        kept = {self.key(f): f.previous.x.array.copy() for f in self._fields}
        for contribution in self._contributions:
            own = contribution.snapshot()
            if twice := kept.keys() & own.keys():
                raise ValueError(f"{type(contribution).__name__}: its history has the name {min(twice)!r}, which "
                                 "another one uses; give each contribution's a name of its own")
            kept |= own
        return kept

    def origins(self) -> dict[str, np.ndarray]:
        """What tells rows of a snapshot's arrays on any number of processes, of those where it is known."""
        known = {self.key(f): f.origins for f in self._fields}
        for contribution in self._contributions:
            known |= contribution.origins()
        return known

    def restore(self, snapshot: dict[str, np.ndarray]) -> None:
        """Return to a state that `snapshot` gave."""
        for field in self._fields:
            field.restore(snapshot[self.key(field)])
        for contribution in self._contributions:
            contribution.restore(snapshot)

    def key(self, field: AdditiveField) -> str:
        """Name of a field in a snapshot; fields of several meshes have the same name but for the number."""
        return f"{field.name} {self._fields.index(field)}"
