"""How one step's equilibrium with contributions that are not smooth is reached."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from ..discrete.system import System
from .condensation import Condensation
from .elimination import Elimination
from .linear import DirectSolver


class Enforcement:
    """Solves a step, then augments, until all contributions hold."""

    def __init__(self, system: System):
        self._system = system
        self._rough = [c for c in system.contributions if not c.smooth]
        self._condenses = any(c.condenses for c in self._rough)
        self._eliminates = self._condenses or (bool(self._rough) and all(c.steep for c in self._rough))

    def approaches(self, eliminates: bool, again: bool, begins: bool) -> list[tuple[bool, list[float]]]:
        """Ways to try: whether contact forces are eliminated, and multiples of the regularisation, the last one is 1.

        Parameters
        ----------
        eliminates : whether contact forces can be; where that fails, a shorter step is tried before other ways
        again : whether a step from the same state has failed before
        begins : whether no step has led to that state
        """
        ways = [(False, [1.0])] * (1 + any(c.retreats for c in self._rough))
        if again and begins and len(self._detours) > 1:
            ways += [(False, self._detours)]
        if not (eliminates and self._eliminates):
            return ways
        return [(True, [1.0]), *(ways if again else [])]

    def elimination(self, linear: DirectSolver) -> Elimination:
        """Solver for the contact forces within iterations that use a factor."""
        kind = Condensation if self._condenses else Elimination
        return kind(self._system, linear, self.regularise, self._multiples)

    @property
    def _detours(self) -> list[float]:
        """Of the regularisation, through which first steps are approached that fail otherwise."""
        return [*sorted({times for c in self._rough for times in c.detours}, reverse=True), 1.0]

    @property
    def _multiples(self) -> list[float]:
        """Of the regularisation, through which eliminated forces are approached."""
        return sorted({1.0, *(times for c in self._rough for times in c.approaches if times > 1)},
                      reverse=True)

    def solve(self, solve: Callable[[], bool], multiples: Sequence[float], augmentations: int) -> bool:
        """Call `solve`, which corrects from where it ended last, until all contributions hold.

        Parameters
        ----------
        augmentations : of contact forces, at most
        """
        for times in multiples:
            self.regularise(times)
            if not solve():
                self.regularise(1.0)
                break
        else:
            for _ in range(augmentations):
                if self._augmented():
                    return True
                if not solve():
                    break
        self._retreat()
        return False

    @property
    def turns_round(self) -> bool:
        """Whether there are contacts with which a step that leads back onto the path begins again otherwise."""
        return any(contribution.turns_round for contribution in self._rough)

    def turn_round(self) -> None:
        """Let a step that leads back onto the path begin again with another stiffness."""
        for contribution in self._rough:
            contribution.turn_round()
        self._system.history.rewind()

    def _retreat(self) -> None:
        """Let a step that does not converge begin again with less stiffness."""
        for contribution in self._rough:
            contribution.retreat()
        self._system.history.rewind()

    def regularise(self, times: float) -> None:
        """Make the regularisation a multiple of what it is in accepted states."""
        for contribution in self._rough:
            contribution.regularise(times)

    def _augmented(self) -> bool:
        """Whether all contributions hold; each that does not has changed what the next solution starts from."""
        held = [contribution.augment() for contribution in self._rough]
        return all(held)

    def summary(self) -> tuple[int, float, bool]:
        """Number of points that touch, largest penetration, and whether all is apart, on all processes."""
        found: Sequence[tuple[int, float]] = [contribution.touching() for contribution in self._rough]
        points, depth = sum(count for count, _ in found), max((depth for _, depth in found), default=0.0)
        return points, depth, not points and all(contribution.apart() for contribution in self._rough)
