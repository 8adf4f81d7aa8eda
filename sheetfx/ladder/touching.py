"""Whether parts touch before the first critical point: gaps of the structure without contact."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from mpi4py import MPI

from ..continuation.state import State
from ..discrete.discretisation import Discretisation
from ..discrete.pair_work import pairs_of
from ..discrete.transfer import Transfer
from ..model.scene import Scene
from ..record import Record
from .rung import Evidence


def contacts_of(scene: Scene) -> list:
    """Contacts with obstacles and between parts."""
    return [*scene.contacts, *(joint for joint in scene.joints if not joint.smooth)]


def _idle(scene: Scene) -> list:
    """Contacts that could be left out: not those with obstacles that loads move or paths are drawn against."""
    moved = [getattr(load, "obstacle", None) for load in scene.all_loads] + [scene.monitor.on]
    return [one for one in contacts_of(scene) if not any(getattr(one, "obstacle", one) is other for other in moved)]


class Gaps:
    """Smallest gap over the states of a path of the structure without contact.

    Attributes
    ----------
    smallest, first, load : the smallest so far, the unloaded structure's, and the load of its state
    """

    def __init__(self, scene: Scene, record: Record):
        self._target, self._comm = Discretisation(scene), scene.parts[0].mesh.comm
        self._transfer = Transfer(record.path.discretisation, self._target)
        self.smallest, self.load, self.first = np.inf, 0.0, self._now()

    def _now(self) -> float:
        pairs = pairs_of(self._target.system.contributions)
        found = [contact.smallest_gap() for contact in [*self._target.contacts, *pairs]]
        return self._comm.allreduce(min(found, default=np.inf), op=MPI.MIN)

    def __call__(self, state: State) -> Evidence | None:
        self._target.system.restore(self._transfer.snapshot(state.fields, state.factor))
        now = self._now()
        if now < self.smallest:
            self.smallest, self.load = now, state.load
        return None if now > 0 else Evidence(self.told)

    @property
    def told(self) -> str:
        if self.smallest <= 0:
            return f"a gap of {self.first:.4g} has closed at load {self.load:.6g}"
        return f"the smallest gap, {self.first:.4g} at first, is {self.smallest:.4g} at load {self.load:.6g}"


class Touching:
    """Contact of parts that do not touch at the start; until a gap closes the structure is that without it."""

    name = "contact"

    def present(self, scene: Scene) -> bool:
        return bool(_idle(scene))

    def without(self, scene: Scene) -> Scene:
        gone = set(map(id, _idle(scene)))
        return replace(scene, contacts=tuple(c for c in scene.contacts if id(c) not in gone),
                       joints=tuple(j for j in scene.joints if id(j) not in gone))

    def watch(self, scene: Scene, record: Record) -> Callable[[State], Evidence | None]:
        return Gaps(scene, record)

    def evidence(self, seen: Gaps) -> Evidence:
        return Evidence(seen.told, 0.0 if seen.smallest > 0 else None)
