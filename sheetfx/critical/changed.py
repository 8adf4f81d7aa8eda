"""Structures that a number has changed, beside the one of a path, and derivatives by central differences of the two."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from .. import rounding
from ..discrete.discretisation import Discretisation
from ..model.scene import Scene

EXACT = 1e-6  # of a derivative, error that differences may have
TRIES = 3  # steps of a number, each as much shorter as the error of the one before asks for


@dataclass(frozen=True)
class Change:
    """A number that a structure is changed by.

    Attributes
    ----------
    scene : function from the number to the scene, of which only values change and nodes move
    at : the number as it is
    given : step of differences; None: a share of the size
    size : that its changes are small beside; None: that of the number
    """

    scene: Callable[[float], Scene]
    at: float
    given: float | None = None
    size: float | None = None

    @property
    def step(self) -> float:
        """Step of differences.

        Raises
        ------
        ValueError
            If the number is zero, and neither step nor size are given.
        """
        if not (step := self.given or rounding.DIFFERENCE * (self.size or abs(self.at))):
            raise ValueError("gradient: at is 0, which tells no size of a step; give step")
        return step

    def shorter(self, found: Differences) -> Change:
        """The change by a step whose error is small enough, by that of the present one."""
        return replace(self, given=self.step * (EXACT / self.error(found)) ** 0.5 / 2)

    def error(self, found: Differences) -> float:
        """Relative error of the derivative by central differences; of a number without a size `odd` alone is known.

        The third difference is estimated by the second one times the step over the size. The first one may be far less
        than both, where the structure gives way to what strains it.
        """
        size = self.size or abs(self.at)
        return found.odd + (found.bend * self.step / size if size else 0.0)

    def sides(self, fields: Mapping[str, np.ndarray]) -> tuple[Discretisation, Discretisation]:
        """The structure with a step more of the number and with a step less, both at fields of the path's.

        Where one of them cannot be, as a tube thicker than its radius, there are two steps to the other side.

        Raises
        ------
        ValueError
            If neither can be, or the number changes the unknowns.
        """
        more, less = self._scenes(1, -1) or self._scenes(2, 0) or self._scenes(0, -2) or (
            self.scene(self.at + way) for way in (self.step, -self.step))
        return changed_structure("gradient", more, fields), changed_structure("gradient", less, fields)

    def _scenes(self, *steps: int) -> list[Scene]:
        """Scenes with so many steps; none where one of them cannot be."""
        try:
            return [self.scene(self.at + way * self.step) for way in steps]
        except ValueError:
            return []


@dataclass(frozen=True)
class Differences:
    """Differences of the load by one step of a number.

    Attributes
    ----------
    first : derivative, of several modes in ascending order
    half_second : size of half of the second difference, over the step
    odd : relative error that the difference of both sides is known to have
    """

    first: float | np.ndarray
    half_second: float
    odd: float = 0.0

    @property
    def bend(self) -> float:
        """Half of the second difference over the first one."""
        return self.half_second / max(float(np.abs(self.first).max()), rounding.TINIEST)


Failure = ValueError | ArithmeticError
Found = Differences | Failure


def derivatives(changes: Sequence[Change], load: float, differences: Callable[[Sequence[Change]], list[Found]]
                ) -> list[float | np.ndarray | Failure]:
    """Derivatives of a load, or why there is none, by steps that are so short that second differences are small.

    Slender parts are strained by a change of their places, and long steps would be errors; of other numbers short ones
    are rounding, and the longer ones are kept.

    Parameters
    ----------
    differences : function that tells them for numbers together
    """
    found: list[Found] = differences(changes)
    steps, looked = list(changes), list(range(len(found)))
    for _ in range(TRIES - 1):
        shorter = {n: steps[n].shorter(one) for n in looked if isinstance(one := found[n], Differences)
                   and _is_rough(one, steps[n], load)}
        if not shorter:
            break
        looked = []
        for n, one in zip(shorter, differences(list(shorter.values())), strict=True):
            if not _is_rounding(one, found[n]):
                found[n], steps[n] = one, shorter[n]
                looked.append(n)
    return [one.first if isinstance(one, Differences) else one for one in found]


def _is_rough(found: Differences, change: Change, load: float) -> bool:
    """Whether differences have more of an error than allowed, and than rounding."""
    return change.error(found) > EXACT and (
        found.odd > EXACT or found.half_second * change.step > rounding.NONE * abs(load))


def _is_rounding(shorter: Found, longer: Found) -> bool:
    """Whether differences by a shorter step are no nearer to the derivative: the second one is rounding then."""
    return (isinstance(shorter, Differences) and isinstance(longer, Differences)
            and shorter.odd >= longer.odd and shorter.half_second >= longer.half_second)


def changed_structure(said: str, scene: Scene, fields: Mapping[str, np.ndarray]) -> Discretisation:
    """A structure that a number has changed, at the fields of a state of the one before.

    Raises
    ------
    ValueError
        If it has other unknowns.
    """
    changed = Discretisation(scene)
    known = changed.system.snapshot()
    if {name: values.shape for name, values in known.items()} != {name: v.shape for name, v in fields.items()}:
        raise ValueError(f"{said}: the number changes the unknowns of the structure; give one that changes values and "
                         "places only")
    changed.system.restore(dict(fields))
    return changed


def unit_of(discretisation: Discretisation) -> float:
    """Total load for a load factor of 1.

    Raises
    ------
    ValueError
        If it is a reaction.
    """
    unit = discretisation.load_of_unit()
    if unit is None:
        raise ValueError("gradient: the load is a reaction to what is prescribed; give the load as forces")
    return unit
