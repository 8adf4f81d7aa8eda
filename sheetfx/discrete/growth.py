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
    least : how often it has grown at the end of a step at least; a step then begins again with the stiffness that is
        given where it does not converge, and where that helps later ones with half the growth that has failed, until
        a step that does so leads back
    rubs : whether there is friction, with which each step begins with the stiffness that is given where there is a
        least growth: what sticks to it turns less sharply as it begins to slip

    Attributes
    ----------
    times : how often it has grown by now
    begun : how often it has where a step begins
    """

    def __init__(self, least: int, rubs: bool):
        self._least, self._most, self._failed, self._deepest = least, 0 if least and rubs else MOST, 0, inf
        self._bound, self._ended = self._most, min(least, self._most)
        self.times = self.begun = self._ended

    @property
    def kept(self) -> tuple[int, int]:
        """What `restore` returns to: how often it has grown where the last step ends, and may have where one begins."""
        return self._ended, self._bound

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
            self.begun, self._failed = self._failed, self.begun

    @property
    def turns_round(self) -> bool:
        """Whether a step that leads back onto the path begins again with another stiffness."""
        return bool(self._least and self._most)

    def turn_round(self) -> None:
        """Begin with what the last step has ended with, where less leads back onto the path, else with less."""
        ended = min(self._ended, self._most)
        if self.begun < ended:
            self._bound, self.begun = self._most, ended
        else:
            self.retreat()

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
        """Let the next step begin with what this one has ended with, or with half the growth that has failed in it."""
        if self._failed:
            self._bound = self._failed // 2
        self.restore(self.times, self._bound)

    def rewind(self) -> None:
        """Forget what a step has changed."""
        self.times, self._deepest = self.begun, inf

    def restore(self, ended: int, bound: int) -> None:
        """Return to an accepted state, see `kept`, but to no stiffness that has failed since."""
        self._bound = min(bound, self._bound)
        self._ended, self.begun, self._failed = ended, min(ended, self._bound), 0
        self.rewind()
