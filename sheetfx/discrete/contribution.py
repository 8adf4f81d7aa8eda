"""What a system is the sum of: anything that does virtual work on the unknowns."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from .layout import Layout
from .unknowns import Unknowns


class Forces:
    """Forces that contributions add up on this process and its ghosts.

    Attributes
    ----------
    along_space : for each block an array of forces along the directions of space, moments being conjugate to the
        spin; filled by forms and by loads at points
    """

    def __init__(self, unknowns: Unknowns, layout: Layout):
        self._fields = unknowns.fields
        self._values: dict[int, np.ndarray] = {}
        self.along_space = layout.zeros()

    def on(self, number: int) -> np.ndarray:
        """Forces conjugate to the nodal values of a field, shape (nodes, components), to be added to.

        Those on rotations are conjugate to the components of the nodal quaternions.

        Parameters
        ----------
        number : of the field in `Unknowns.fields`
        """
        if number not in self._values:
            self._values[number] = np.zeros_like(self._fields[number].table)
        return self._values[number]

    def given(self, number: int) -> np.ndarray | None:
        """What has been added to a field; None: nothing."""
        return self._values.get(number)

    def spatial(self, layout: Layout) -> list[np.ndarray]:
        """All that has been added, along the directions of space: an array for each block, written over."""
        entries: Sequence[Any] = layout.fields(self.along_space)
        for number, values in self._values.items():
            field, array = entries[number]
            array[field.dofs] += field.spatial(values)
        return self.along_space


class Contribution:
    """One summand of a system; what it does not define it leaves as here.

    A contribution couples unknowns (`pattern`), and adds its residual, its load and the values of its tangent. All are
    called on every process for the part of the contribution that this process answers for.

    Attributes
    ----------
    smooth : whether its tangent changes continuously with the state; of contact and of yielding it does not
    conservative : whether its forces have a potential, so that its tangent is symmetric
    sticks : whether it can `stick`, and has a potential then, though it is not conservative: contact with friction
    called : what messages call it; "": by its class
    without_fall : why structures with it cannot fall, in words; "": they can
    moved : whether it couples other unknowns than when `pattern` was last asked; the system then asks again
    rubs : whether there is friction, so that it has to `foresee` where points touch
    augments : whether forces are found by augmentation: work is then told between accepted states only
    tells_work : whether the work of its load is what the load vector does along the motion
    tolerance : length by which it leaves places of accepted states undetermined
    gives_moments : whether it adds moments to `Forces.along_space`, which turn with the nodes
    stage : number of the load stage that its load belongs to; None: it has none
    kinks : whether its moduli may jump where its strains pass some values: laws with history, and laws with cases
    remembers, history_moved : whether it has laws with history, whose forces do work but have no energy; whether one
        remembers something by now, such as plastic strains, on any process
    approaches : multiples of its regularisation through which eliminated forces are approached
    detours : those through which a first step's is that fails otherwise, however short
    retreats : whether a step that does not converge begins again with less stiffness
    turns_round : whether a step that leads back onto the path begins again with another stiffness
    steep : whether its forces change with motions that are far smaller than a step's, but act on few unknowns at
        a time: each Newton iteration then finds them exactly, see `continuation.elimination`
    condenses : whether it says how its forces follow from a few gaps and slips, on which each Newton iteration then
        finds them, see `continuation.condensation`
    """

    smooth = conservative = tells_work = True
    steep = condenses = sticks = augments = rubs = False
    called = without_fall = ""
    moved = gives_moments = kinks = remembers = history_moved = False
    stage: int | None = None
    tolerance = 0.0
    approaches: Sequence[float] = (1.0,)
    detours: Sequence[float] = ()
    retreats = False
    turns_round = False

    def pattern(self, layout: Layout) -> tuple[np.ndarray, np.ndarray]:
        """Global rows and columns of the entries of the tangent, -1 where an increment is zero.

        `layout.free_numbers[number]` has the numbers of the increments at each node of a field.
        """
        return np.empty(0, dtype=np.int64), np.empty(0, dtype=np.int64)

    def residual(self, forces: Forces) -> None:
        """Add what the contribution does on the unknowns now: internal forces, minus external ones."""

    def load(self, forces: Forces) -> None:
        """Add the derivative of the external forces with respect to the load factor of its stage."""

    def extrapolate_stress(self) -> None:
        """Take the stresses of the tangent on by the change of the fields in the last Newton step."""

    def forget_stress(self) -> None:
        """Let the next tangent have no stresses, where an interpolated state's mean nothing."""

    def tangent(self, held: Forces) -> Sequence[np.ndarray]:
        """Values of the tangent in the order of `pattern`, in arrays one behind the other.

        They are derivatives by nodal increments.

        Forces on rotations that the tangent holds fixed are added to `held`: the system makes their share of the
        tangent, which comes from the curvature of the rotations, for all contributions at once.
        """
        return ()

    def update_history(self) -> bool:
        """Let laws with history move on to the present state, so that its tangent belongs to loading on from it.

        `commit` confirms it, `rewind` takes it back. Return whether the tangent has changed.
        """
        return False

    def commit(self) -> None:
        """Accept the present state: history moves on. Increments still count from where they did."""

    def snapshot(self) -> dict[str, np.ndarray]:
        """History at the last accepted state on this process, by names that no other contribution uses."""
        return {}

    def origins(self) -> dict[str, np.ndarray]:
        """What tells the rows of its arrays in a snapshot on any number of processes, see `discrete.origins`.

        Where an array is left out, a path resumes on as many processes as it began with.
        """
        return {}

    def restore(self, snapshot: dict[str, np.ndarray]) -> None:
        """Return to what `snapshot` gave."""

    def history_moved_since(self, snapshot: dict[str, np.ndarray]) -> bool:
        """Whether laws with history remember something else than in a snapshot, on any process."""
        return False

    def pass_by(self, begins: bool) -> None:
        """Add the present strains to those that a step comes by, for `forgotten`: halfway to a state, there, and so on.

        Parameters
        ----------
        begins : whether they are the first ones
        """

    def forgotten(self, forces: Forces) -> np.ndarray:
        """Add the forces that laws with history forget of the way of a step to the present state.

        Returns
        -------
        sizes of the power of forgotten resultants, and of all, on this process, at places of the way; (places, 2)
        """
        return np.zeros((1, 2))

    def rewind(self) -> None:
        """Forget what a step that failed has changed since the last accepted state."""

    def freeze(self, frozen: bool) -> None:
        """Answer as the linear comparison solid of the last accepted state, or as one with history again."""

    def turn_round(self) -> None:
        """Let a step that leads back onto the path begin again with another stiffness."""

    def retreat(self) -> None:
        """Let a step that has not converged begin with less stiffness, if it has not; the history is rewound next."""

    def regularise(self, times: float) -> None:
        """Make the regularisation a multiple of what it is in accepted states; see `approaches`."""

    def foresee(self, ahead: bool) -> None:
        """Look at where a step starts, then at where its tangent leads: what slips does so from where it touches.

        Parameters
        ----------
        ahead : whether the system is there
        """

    def freeze_open_contacts(self) -> bool:
        """Answer as if what was pressed stayed closed, where all of it is open at an iterate; whether anything is held.

        A step that is straight opens it, and without it the structure springs back through what it touched. It is asked
        before forces are found on the flexibility of the structure, with which it opens if it must.
        """
        return False

    def stick(self) -> None:
        """Answer as if all that touches stuck where it is now, with the forces of now, until `release`."""

    def release(self) -> None:
        """Answer again as it is, after `freeze_open_contacts` or `stick`."""

    def augment(self) -> bool:
        """Whether a converged solution satisfies the contribution; if not, change what the next solution starts from.

        Augmented-Lagrangian contact updates its multipliers here.
        """
        return True

    def energy(self) -> float | None:
        """Energy that it stores now, on all processes; None: it does not tell."""
        return None

    def touch(self) -> np.ndarray | None:
        """What `work_between` has to know of a state, when the system is there; None: its work is not told."""
        energy = self.energy()
        return None if energy is None else np.array([energy])

    def work_between(self, start: np.ndarray, end: np.ndarray) -> float:
        """Change of the energy, and what friction takes, from a state to the next one, on all processes.

        Parameters
        ----------
        start, end : `touch` of both states
        """
        return float(end[0] - start[0])

    def gaps(self) -> np.ndarray:
        """Distances of its points on this process, negative where they touch; NaN: unknown; none: it does not tell."""
        return np.empty(0)

    def apart(self) -> bool:
        """Whether it does nothing now, nor will after a small motion, on all processes: then it is smooth here."""
        return self.smooth

    def touching(self) -> tuple[int, float]:
        """Number of points in contact and largest penetration, on all processes."""
        return 0, 0.0
