"""What friction is worth: no state without it tells, so that its own path is followed and both are compared."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from ..continuation.state import State
from ..critical.remade import remade
from ..model.scene import Scene
from ..record import Record
from .rung import Evidence
from .touching import contacts_of


class Friction:
    """Coulomb's friction of all contacts."""

    name = "friction"

    def present(self, scene: Scene) -> bool:
        return bool(_rough(scene))

    def without(self, scene: Scene) -> Scene:
        return remade(scene, {one: replace(one, friction=0.0) for one in _rough(scene)})

    def watch(self, scene: Scene, record: Record) -> Callable[[State], Evidence | None]:
        return lambda state: None

    def evidence(self, seen: object) -> Evidence:
        return Evidence("only its own path tells")


def _rough(scene: Scene) -> list:
    return [one for one in contacts_of(scene) if getattr(one, "friction", 0.0) > 0]
