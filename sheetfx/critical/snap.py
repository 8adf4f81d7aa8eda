"""Snaps: from an unstable state to the stable one that a structure falls into."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from itertools import pairwise
from pathlib import Path as Folder

from ..continuation.inertia import can_stick
from ..continuation.segment import Jump, Missed
from ..continuation.state import State
from ..continuation.tracer import tracer_of
from ..events.event import Event, occurrences
from .fall import Fall, FallStep, unstable

HOLDS = ("load", "displacement")
# of the load, where its rate passes zero; of the displacement on which it works, where the compliance does
EXTREMES = {"load": Event("extreme", lambda state: state.load_rate),
            "displacement": Event("extreme", lambda state: state.reference[1] / state.current_stiffness)}


@dataclass(frozen=True)
class Snap:
    """A jump from an unstable state to a stable one.

    Attributes
    ----------
    before, after : states; a path goes on with `Path(scene, control, until, start=[snap.after])`, away from zero load
        where the load was held, from zero deflection where the displacement was
    hold : "load" or "displacement"
    history : the fall, from `before` to `after`
    """

    before: State
    after: State
    hold: str
    history: tuple[FallStep, ...]

    def __str__(self) -> str:
        return (f"snap with held {self.hold} from {self.before} to {self.after}, "
                f"energy released {self.energy_released:.6g}")

    @property
    def energy_released(self) -> float:
        """What a real structure turns into motion and heat (force times length), beside what friction takes.

        That is what stored energy and the held load's potential fall by, less friction's work, which hangs on the way.
        """
        return -self.history[-1].energy

    @property
    def iterations(self) -> int:
        return len(self.history) - 1

    def save(self, folder: Folder, comm) -> None:
        """Write `snap.json` with the jump and its history, and both states of each process."""
        folder = Folder(folder)
        folder.mkdir(parents=True, exist_ok=True)
        for name, state in (("before", self.before), ("after", self.after)):
            state.save(folder / f"{name}.{comm.rank}.npz")
        if comm.rank == 0:
            ends = {name: {"load": state.load, "deflection": state.deflection, "unstable": state.unstable_modes}
                    for name, state in (("before", self.before), ("after", self.after))}
            content = ends | {"hold": self.hold, "energy_released": self.energy_released,
                              "history": [asdict(step) for step in self.history]}
            (folder / "snap.json").write_text(json.dumps(content, indent=2) + "\n")


def snap(path, state: State, hold: str = "load", side: int = 1,
         listener: Callable[[FallStep], None] | None = None) -> Snap:
    """The stable state that a structure falls into from an unstable one.

    Parameters
    ----------
    path : Path or Tracer that the state belongs to; it stays at its present state
    state : unstable, or at a critical point; with friction also a stable one ahead of which there is no equilibrium,
        where a path ends: the held quantity is then raised by a thousandth of the load, as the path went on
    hold : what the test holds during the fall: "load", the load factor (with a prescribed displacement that one), or
        "displacement", that on which the load works: the monitored one where the load is a force there
    side : 1 or -1, the sense of the fall along the unstable direction; 1: the path's sense where the two are not
        perpendicular, as at limit points; friction may hold the structure in one of them
    listener : called with every step of the fall

    Raises
    ------
    ValueError
        If the state is stable, or the structure has no energy: follower loads, exact contact, friction on an obstacle.
    SnapFailure
        If no stable state is found.
    """
    tracer = tracer_of(path)
    _check(tracer, state, hold, side)
    present = tracer.state
    try:
        tracer.back_to(state)
        fall = Fall(tracer, hold, side, listener or (lambda step: None))
        return Snap(state, fall.run(), hold, tuple(fall.history))
    finally:
        tracer.back_to(present)


def snaps(path, states: Sequence[State], hold: str = "load") -> list[Snap]:
    """Falls of a test along a path: one where each unstable piece begins.

    There the held quantity has its extreme, and this state comes first. Where a piece begins with a bifurcation or with
    contact, the next state of the path counts, and the fall hangs on the length of steps.

    Parameters
    ----------
    path : Path or Tracer
    states : of the path, in order
    hold : as of `snap`
    """
    return [first_fall(path, before, after, hold) for before, after in pairwise(states)
            if unstable(after, hold) and not unstable(before, hold)]


def first_fall(path, before: State, after: State, hold: str) -> Snap:
    """The fall from the extreme of the held quantity between two states, else from the second one."""
    return snap(path, _extreme(tracer_of(path), before, after, hold) or after, hold)


def _extreme(tracer, before: State, after: State, hold: str) -> State | None:
    """The state between two others at which the held quantity has its extreme; None if they know of none."""
    first = next((point for point in after.critical if point.step == after.step), None)
    if not tracer.system.smooth or (first and first.kind == "bifurcation"):
        return None
    present = tracer.state
    try:
        found = occurrences(tracer, before, after, [EXTREMES[hold]], whole=True)
    except (Jump, Missed):
        return None
    finally:
        tracer.back_to(present)
    return found[0].state if found and not found[0].point.spread else None


def _check(tracer, state: State, hold: str, side: int) -> None:
    if hold not in HOLDS:
        raise ValueError(f"snap: hold is {hold!r}; it must be one of {', '.join(HOLDS)}")
    if side not in (1, -1):
        raise ValueError(f"snap: side is {side!r}; it must be 1 or -1")
    if state.unstable_modes is None or not (tracer.system.conservative or can_stick(tracer.system)):
        raise ValueError("snap: the structure has no energy that could fall (friction of a Contact, pressure, "
                         "follower forces or moments in space make its tangent unsymmetric), or its tangent is not "
                         "factored with its inertia; use loads of fixed direction, contact with friction between parts "
                         "alone, and the default solver")
    for contribution in tracer.system.contributions:
        if contribution.without_fall:
            raise ValueError(f"snap: {contribution.without_fall}")
