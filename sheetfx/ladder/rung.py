"""A rung of the ladder: something that a scene models, and that its critical load may not need."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Protocol

from ..continuation.state import State
from ..model.scene import Scene
from ..record import Record


@dataclass(frozen=True)
class Evidence:
    """What the poorer model tells of the richer one.

    Attributes
    ----------
    because : the figures, in words
    worth : change of the load by the richer model, over the load; None: it can not be told without climbing
    """

    because: str
    worth: float | None = None


class Rung(Protocol):
    """Something that can be left out, such as plasticity.

    Attributes
    ----------
    name : what decisions call it
    """

    name: str

    def present(self, scene: Scene) -> bool:
        """Whether a scene models it."""

    def without(self, scene: Scene) -> Scene:
        """The scene with all but that."""

    def watch(self, scene: Scene, record: Record) -> Callable[[State], Evidence | None]:
        """What looks at each state of the poorer model's path, and tells where it is no longer right.

        Parameters
        ----------
        scene : that models it, otherwise the same
        record : of the poorer model, as it grows
        """

    def evidence(self, seen: Any) -> Evidence:
        """What the path of the poorer model up to its first critical point tells.

        Parameters
        ----------
        seen : what `watch` returned, which has seen all states
        """
