"""The load factors of a scene's stages, of which one varies at a time."""

from __future__ import annotations

import ufl
from dolfinx import fem


class LoadFactors:
    """One load factor for each stage: 1 of earlier stages, 0 of later ones.

    Attributes
    ----------
    stage : number of the stage whose factor varies
    symbols : UFL variables that stand for the factors in forms
    """

    def __init__(self, domain, stages: int):
        self._constants = [fem.Constant(domain, 0.0) for _ in range(stages)]
        self.symbols = [ufl.variable(constant) for constant in self._constants]
        self.stage = 0

    @property
    def now(self) -> float:
        """The factor that varies."""
        return self.value(self.stage)

    def value(self, stage: int) -> float:
        return float(self._constants[stage].value)

    def set(self, factor: float) -> None:
        self._constants[self.stage].value = factor

    def enter(self, stage: int, factor: float) -> None:
        """Let the factor of a stage vary, from a value."""
        self.stage = stage
        for number, constant in enumerate(self._constants):
            constant.value = 1.0 if number < stage else 0.0
        self.set(factor)
