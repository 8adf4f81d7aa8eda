"""What all parts of a picture are coloured by."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated

import numpy as np

from ..checks import NONZERO, Like, require

Along = str | Sequence[float] | None
DIRECTION = Like("'x', 'y', 'z' or a vector of three numbers", lambda along: along is None or (
    along in tuple("xyz") if isinstance(along, str) else np.shape(along) == (3,)))
SIZES, SIDES = "viridis", "coolwarm"  # colour maps of numbers from zero, and of numbers to both sides of it


@dataclass(frozen=True)
class Measure:
    """Size of the displacement, or its component along one direction, which is the same for all parts.

    Attributes
    ----------
    along : "x", "y" or "z", or a vector of any length (3,); None: the size
    """

    along: Along = None

    def __post_init__(self):
        require("pictures", along=(self.along, Annotated[object, DIRECTION]))
        if self.along is not None and not isinstance(self.along, str):
            require("pictures", along=(self.along, Annotated[Sequence[float], NONZERO]))

    def __call__(self, displacements: np.ndarray) -> np.ndarray:
        """Values for displacements (..., 3)."""
        if self.along is None:
            return np.linalg.norm(displacements, axis=-1)
        direction = np.eye(3)["xyz".index(self.along)] if isinstance(self.along, str) else np.asarray(self.along)
        return displacements @ (direction / np.linalg.norm(direction))

    @property
    def name(self) -> str:
        """What a colour bar says, without unit."""
        if self.along is None:
            return "size of the displacement"
        to = self.along if isinstance(self.along, str) else f"({', '.join(f'{c:g}' for c in self.along)})"
        return f"displacement along {to}"

    def said(self, unit: str) -> str:
        """What a colour bar says, with a unit where lengths have one."""
        return f"{self.name} ({unit})" if unit else self.name

    @property
    def colour_map(self) -> str:
        return SIZES if self.along is None else SIDES

    def limits(self, values: Sequence[np.ndarray]) -> tuple[float, float]:
        """Ends of the colour bar: from zero, or as far to both sides of it."""
        largest = max((float(np.abs(v).max(initial=0.0)) for v in values), default=0.0) or 1.0
        return (0.0 if self.along is None else -largest), largest


OF_SIZE = Measure()
