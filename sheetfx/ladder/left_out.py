"""Things left out of a scene, and the rungs that put it back."""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from typing import TYPE_CHECKING

from ..checks import check
from ..model.scene import Scene
from .friction import Friction
from .plasticity import Plasticity
from .rung import Rung
from .touching import Touching

if TYPE_CHECKING:
    from ..case import Case

RUNGS: tuple[Rung, ...] = (Touching(), Friction(), Plasticity())  # what is worth more in general first


@dataclass(frozen=True)
class LeftOut:
    """What a model does without, though its scene has it.

    ```python
    case = fx.LeftOut(plasticity=True).of(case)
    ```

    Attributes
    ----------
    contact : parts go through each other and through obstacles
    friction : what touches slides freely
    plasticity : materials are elastic
    """

    contact: bool = False
    friction: bool = False
    plasticity: bool = False

    def __post_init__(self):
        check(self)

    @classmethod
    def all_of(cls, scene: Scene) -> LeftOut:
        """All that a scene has."""
        return cls(**{rung.name: rung.present(scene) for rung in RUNGS})

    @property
    def rungs(self) -> list[Rung]:
        return [rung for rung in RUNGS if getattr(self, rung.name)]

    @property
    def words(self) -> str:
        """For messages, such as "without contact and friction"."""
        names = [f.name for f in fields(self) if getattr(self, f.name)]
        return "without " + " and ".join(names) if names else "all that the scene has"

    def but(self, name: str) -> LeftOut:
        """Leave out all but one of the things left out."""
        return replace(self, **{name: False})

    def of(self, case: Case) -> Case:
        """A case without the things left out, and without its events: their tests may ask for that."""
        if (scene := self.scene(case.scene)) is case.scene:
            return case
        return replace(case, scene=scene, events=(), until=replace(case.until, event=None),
                       quantities=lambda record: {})

    def scene(self, scene: Scene) -> Scene:
        for rung in self.rungs:
            if rung.present(scene):
                scene = rung.without(scene)
        return scene
