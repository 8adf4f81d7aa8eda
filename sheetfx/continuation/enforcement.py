"""How one step's equilibrium with contributions that are not smooth is reached."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from ..discrete.system import System

AUGMENTATIONS = 30


class Enforcement:
    """Solves a step: approach through stronger regularisation, then augmentation, until all contributions hold."""

    def __init__(self, system: System):
        self._system = system
        self._rough = [c for c in system.contributions if not c.smooth or len(c.approaches) > 1]

    def approaches(self) -> list[list[float]]:
        """Sequences of multiples of the regularisation to try: from large ones to the final one, then directly.

        Thick contact layers make long steps converge; a step shorter than their indentation fails in them.
        """
        times = sorted({1.0, *(t for c in self._rough for t in c.approaches)}, reverse=True)
        return [times, [1.0]] if len(times) > 1 else [[1.0]]

    def solve(self, solve: Callable[[], bool], multiples: Sequence[float]) -> bool:
        """Call `solve`, which corrects from where it ended last, until all contributions hold."""
        for times in multiples:
            self._regularise(times)
            if not solve():
                self._regularise(1.0)
                self._system.history.rewind()
                return False
        for _ in range(AUGMENTATIONS):
            if self._augmented():
                return True
            if not solve():
                break
        self._system.history.rewind()
        return False

    def _regularise(self, times: float) -> None:
        for contribution in self._rough:
            contribution.regularise(times)

    def _augmented(self) -> bool:
        """Whether all contributions hold; each that does not has changed what the next solution starts from."""
        held = [contribution.augment() for contribution in self._rough]
        return all(held)

    def summary(self) -> tuple[int, float]:
        """Number of points that touch and largest penetration, on all processes."""
        found: Sequence[tuple[int, float]] = [contribution.touching() for contribution in self._rough]
        return sum(count for count, _ in found), max((depth for _, depth in found), default=0.0)
