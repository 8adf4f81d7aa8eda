"""The first critical points of a scene's models, each found once."""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from typing import TYPE_CHECKING

from ..model.scene import Scene
from .first_point import FirstPoint, from_coarser, up_to_first
from .integration import integrated_finer
from .left_out import LeftOut
from .meshes import Meshes
from .symmetry import Asymmetric, across

if TYPE_CHECKING:
    from ..case import Case


@contextmanager
def quiet(said: bool = True) -> Iterator[None]:
    """Without warnings, which have been given before."""
    with warnings.catch_warnings():
        if said:
            warnings.simplefilter("ignore")
        yield


class Models:
    """Models of a structure by the level of their meshes and by what they leave out.

    Attributes
    ----------
    meshes : Meshes
    small : name of a thing left out -> its worth, where that was measured and the path is not watched for it
    across : planes of symmetry whose modes count as critical
    doubled : how often layers, fibres and steps are doubled in number
    """

    def __init__(self, meshes: Meshes):
        self.meshes = meshes
        self.small: dict[str, float] = {}
        self.across: list[str] = []
        self.doubled = 0
        self._cases: dict[int, Case] = {}
        self._found: dict[tuple[int, LeftOut, int], FirstPoint] = {}

    def scene(self, level: int) -> Scene:
        """With all that it has."""
        return self._case(level).scene

    def _case(self, level: int) -> Case:
        if level not in self._cases:
            with quiet(bool(self._cases)):
                self._cases[level] = self.meshes.case(level)
        return self._cases[level]

    def at(self, level: int, left: LeftOut, more: int = 0) -> FirstPoint:
        """The first critical point of a model: directly from that on coarser cells where these tell, else by its path.

        Parameters
        ----------
        more : how often layers, fibres and steps are doubled in number, beyond `doubled`

        Raises
        ------
        ValueError
            If there is no structure without the things left out.
        """
        doubled = self.doubled + more
        if (level, left, doubled) not in self._found:
            whole = self._case(level)
            with quiet():
                case = self._counted(integrated_finer(left.of(whole), doubled))
            watched = LeftOut(**{rung.name: rung.name not in self.small for rung in left.rungs})
            coarser, found = self._found.get((level - 1, left, doubled)), None
            if coarser and not (coarser.refuted or coarser.failure):
                found = from_coarser(coarser, case, whole.scene, left, watched)
            self._found[level, left, doubled] = found or up_to_first(case, whole.scene, left, watched, self._names)
        return self._found[level, left, doubled]

    def counts(self, name: str) -> None:
        """From now on modes across a plane of symmetry are critical, so that all is to be found again."""
        self.across.append(name)
        self._found.clear()

    def _counted(self, case: Case) -> Case:
        """A case that looks for modes across planes of symmetry, where these count."""
        events = [Asymmetric(modes).event for modes in across(case.scene) if modes.name in self.across]
        return replace(case, events=[*case.events, *events], snaps=False)

    @property
    def _names(self) -> list[str]:
        return [f"mode across {name}" for name in self.across]
