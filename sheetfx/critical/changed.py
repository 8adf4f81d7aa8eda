"""Structures that a number has changed, beside the one of a path."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from ..discrete.discretisation import Discretisation
from ..model.scene import Scene

STEP = 1e-6  # of a number, of its differences: slender parts are strained by a change of their places


@dataclass(frozen=True)
class Change:
    """A number that a structure is changed by.

    Attributes
    ----------
    scene : function from the number to the scene, of which only values change and nodes move
    at : the number as it is
    given : step of differences; None: a millionth of the number
    """

    scene: Callable[[float], Scene]
    at: float
    given: float | None = None

    @property
    def step(self) -> float:
        """Step of differences.

        Raises
        ------
        ValueError
            If the number is zero and no step is given.
        """
        if not (step := self.given or STEP * abs(self.at)):
            raise ValueError("gradient: at is 0, which tells no size of a step; give step")
        return step

    def sides(self, fields: Mapping[str, np.ndarray]) -> tuple[Discretisation, Discretisation]:
        """The structure with a step more of the number and with a step less, both at fields of the path's.

        Raises
        ------
        ValueError
            If the number changes the unknowns.
        """
        more, less = (self.scene(self.at + way) for way in (self.step, -self.step))
        return changed_structure("gradient", more, fields), changed_structure("gradient", less, fields)


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
