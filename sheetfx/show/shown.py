"""What pictures and files ask of a traced path; `record.Record` answers, and pictures know no more of it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

from ..continuation.balance import Balance
from ..continuation.state import CriticalPoint, State
from ..discrete.pair_work import PairState
from ..discrete.plastic import PlasticState
from ..discrete.reactions import Reaction
from ..discrete.section_forces import SectionPoints
from ..events.until import Until
from ..model.scene import Scene
from ..path import Path

if TYPE_CHECKING:
    from ..critical.buckling import BucklingLoad
    from ..critical.error_bar import ErrorBar


class ShownCase(Protocol):
    """What a picture needs of a case: its scene, where its path ends, and the names of deflection and load."""

    @property
    def scene(self) -> Scene: ...

    @property
    def until(self) -> Until: ...

    @property
    def axes(self) -> tuple[str, str]: ...


class Shown(Protocol):
    """A traced path with its states, whose fields can be put to any state's."""

    case: Any
    path: Path
    states: list[State]
    errors: dict[CriticalPoint, ErrorBar]

    @property
    def critical_points(self) -> list[CriticalPoint]: ...

    def nearest(self, load: float) -> State: ...

    def state_at(self, point: CriticalPoint) -> State: ...

    def show(self, state: State) -> None: ...

    def critical_modes(self, point: CriticalPoint) -> list[np.ndarray]: ...

    def energy_shares(self, modes: Sequence[np.ndarray]) -> list[float]: ...

    def buckling(self) -> list[BucklingLoad]: ...

    def forces(self, part: Any) -> np.ndarray: ...

    def section_points(self, part: Any) -> SectionPoints: ...

    def shown_reactions(self) -> list[tuple[Any, Reaction]]: ...

    def plastic(self, part: Any) -> PlasticState: ...

    def pairs(self, contact: Any) -> PairState: ...

    def balance(self) -> Balance: ...
