"""What friction may be worth: its forces on the slip of the structure without friction."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from ..continuation.state import CriticalPoint, State
from ..critical.remade import remade
from ..model.scene import Scene
from ..record import Record
from .rung import Evidence
from .touching import contacts_of


class Friction:
    """Coulomb's friction of all contacts."""

    name = "friction"

    def present(self, scene: Scene) -> bool:
        return any(contact.friction > 0 for contact in contacts_of(scene) if hasattr(contact, "friction"))

    def without(self, scene: Scene) -> Scene:
        rough = [one for one in contacts_of(scene) if getattr(one, "friction", 0.0) > 0]
        return remade(scene, {one: replace(one, friction=0.0) for one in rough})

    def watch(self, scene: Scene, record: Record) -> Callable[[State], Evidence | None]:
        return lambda state: None

    def evidence(self, scene: Scene, record: Record, point: CriticalPoint | None, seen: object) -> Evidence:
        return Evidence("only its own path tells")
