"""Growth of the stiffness with which pressures of contact are augmented."""

from __future__ import annotations

from math import inf

STIFFER, MOST = 10.0, 8  # stiffness from one augmentation to the next, and how often it grows at most
SLOW = 0.01  # part of the penetration that an augmentation leaves, above which the next one is stiffer


class Growth:
    """How often a stiffness has grown, which does so as long as augmentations take little of the penetration away.

    Each step begins with the one that the last step ended with. The given stiffness then only begins a path: with
    pairs far softer than the structure all steps would lead through states in which nothing seems to touch, and which
    may not be there.

    Parameters
    ----------
    least : how often it has grown at the end of a step at least; where one does not converge, as at first touch, it
        begins again with the stiffness that is given
    rubs : whether there is friction, with which each step begins with the stiffness that is given where there is a
        least growth: what sticks to it turns less sharply as it begins to slip

    Attributes
    ----------
    times : how often it has grown by now
    begun : how often it has where a step begins
    """

    def __init__(self, least: int, rubs: bool):
        self._least, self._most, self._other, self._deepest = least, 0 if least and rubs else MOST, 0, inf
        self.times = self.begun = min(least, self._most)

    @property
    def factor(self) -> float:
        """The stiffness over the one that is given."""
        return STIFFER**self.times

    @property
    def reached(self) -> float:
        """Factor on the stiffness at the end of a step, at least."""
        return STIFFER**max(self.begun, self._least)

    @property
    def retreats(self) -> bool:
        """Whether a step that does not converge begins again with the stiffness that is given."""
        return bool(self._least and self.begun)

    def retreat(self) -> None:
        """Begin with the stiffness that is given, or where that has failed as well, with the one before."""
        if self._least:
            self.begun, self._other = self._other, self.begun

    @property
    def suffices(self) -> bool:
        """Whether it has grown as often as it does within a step at least."""
        return self.times >= self._least

    def go_on(self, deepest: float) -> None:
        """Grow for the next augmentation if need be.

        Parameters
        ----------
        deepest : penetration that the last one has left
        """
        if not self.suffices or (self.times < MOST and deepest > SLOW * self._deepest):
            self.times += 1
        self._deepest = deepest

    def commit(self) -> None:
        """Let the next step begin with what this one has ended with."""
        self.restore(self.times)

    def rewind(self) -> None:
        """Forget what a step has changed."""
        self.times, self._deepest = self.begun, inf

    def restore(self, begun: int) -> None:
        """Return to an accepted state, where a step begins with such a growth."""
        self.begun, self._other = min(begun, self._most), 0
        self.rewind()
