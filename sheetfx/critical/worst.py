"""The worst and the likely imperfections of a structure, by critical loads of imperfect ones and their gradients.

Imperfections are sums of shapes with coefficients c; their size is the norm of c. Where the load of the first critical
point is least among all of one size r, its gradient g is normal to the sphere:

    c = -r g / |g|,

a fixed point that is found by iteration (advanced mean value: Wu, Millwater and Cruse 1990), on the circle from c to
there, not as far where the load does not fall by enough. Several starts find several minima.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated

import numpy as np

from ..checks import NOT_NEGATIVE, Count, Positive, Range, require
from .bifurcation_gradient import NoDerivative
from .likely import LoadQuantile, load_quantile

NONE = "none"  # kind where a path has no critical point
MANY = 8  # coefficients, more than which are not printed
WELL = 1e-4  # relative fall of the load that the gradient still promises, where a search ends
ITERATIONS, CUTS = 20, 3  # of a search, and of one of its steps
TURNS = 0.3, 0.1, 0.03  # angles at which loads are looked at where the slope does not lead down
ENOUGH, CUT = 0.25, 0.25  # of what the slope promises, fall that is enough; smallest part that a step is cut to
APART = 0.9  # cosine between two minima that are different ones
BROKEN = 0.1  # of the size, what a start in one shape has of others: symmetry would hold a search


@dataclass(frozen=True)
class ImperfectLoad:
    """The first critical point on the path of an imperfect structure.

    Attributes
    ----------
    coefficients : of the shapes
    load : total load; infinite where there is none
    kind : "limit" or "bifurcation"; "none" where the path ends without a critical point
    """

    coefficients: tuple[float, ...]
    load: float
    kind: str

    def __str__(self) -> str:
        said = ", ".join(f"{c:.4g}" for c in self.coefficients)
        if (count := len(self.coefficients)) > MANY:
            n = int(np.argmax(np.abs(self.coefficients)))
            said = f"{count} coefficients, the largest c{n + 1} = {self.coefficients[n]:.4g}"
        return (f"no critical point with {said}" if self.kind == NONE else
                f"{self.kind} at load {self.load:.6g} with {said}")


class LoadsByShape(ABC):
    """First critical loads of imperfect structures, and a search for the worst and the likely ones.

    Attributes
    ----------
    count : number of shapes
    """

    count: int

    @abstractmethod
    def at(self, coefficients: Sequence[float]) -> ImperfectLoad:
        """The first critical load with an imperfection."""

    @abstractmethod
    def gradient(self, coefficients: Sequence[float]) -> np.ndarray:
        """Derivatives of the first critical load by the coefficients, shape (count,).

        Raises
        ------
        NoDerivative
            At a bifurcation that a shape makes a limit point.
        """

    def worst(self, size: float, *, starts: int = 3, seed: int = 0,
              near: Sequence[ImperfectLoad] = ()) -> list[ImperfectLoad]:
        """Imperfections of one size whose loads are least among their neighbours', the least first.

        Parameters
        ----------
        size : norm of the coefficients
        starts : number of searches, from those that are least of four for each shape: both signs of it, a little of
            the others added, and two of all shapes at random
        seed : of the random numbers
        near : imperfections of any size, from whose ways the searches start instead

        Raises
        ------
        ValueError
            If no imperfection that is looked at has a critical point.
        """
        require("worst", size=(size, Positive), starts=(starts, Count),
                seed=(seed, Annotated[int, NOT_NEGATIVE]))
        if near:
            return self._searched(size, _unit(np.array([one.coefficients for one in near])), len(near))
        random, count = np.random.default_rng(seed), self.count
        alone = np.concatenate((np.eye(count), -np.eye(count)))
        if count > 1:
            alone = alone + BROKEN * _unit(random.standard_normal((2 * count, count)))
        ways = _unit(np.concatenate((alone, random.standard_normal((2 * count if count > 1 else 0, count)))))
        return self._searched(size, ways, starts)

    def quantile(self, probability: float, deviation: float, *, samples: int = 50, seed: int = 0) -> LoadQuantile:
        """Load that critical loads are below with a probability, of independent normal coefficients, see `likely`.

        Parameters
        ----------
        probability : below 1/2
        deviation : standard deviation of each coefficient
        samples : number of loads that are looked for, two at least
        seed : of the random numbers

        Raises
        ------
        ValueError
            If no imperfection that is looked at has a critical point.
        """
        require("quantile", deviation=(deviation, Positive), samples=(samples, Annotated[int, Range(least=2)]),
                seed=(seed, Annotated[int, NOT_NEGATIVE]),
                probability=(probability, Annotated[float, Range(above=0.0, below=0.5)]))
        return load_quantile(self.at, self.count, probability, deviation, samples, seed)

    def _searched(self, size: float, ways: np.ndarray, starts: int) -> list[ImperfectLoad]:
        """Minima of one size, from the best of some ways."""
        found: list[ImperfectLoad] = []
        tried = sorted((self.at(size * way) for way in ways), key=lambda one: one.load)
        if tried[0].kind == NONE:
            raise ValueError(f"worst: none of {len(tried)} imperfections of size {size:g} has a critical point; let "
                             "their paths go further, or take other shapes")
        begun: list[np.ndarray] = []
        for start in tried:
            way = np.array(start.coefficients) / size
            if start.kind == NONE or len(begun) == starts or any(way @ other > APART for other in begun):
                continue
            begun.append(way)
            end = self._descended(start, size)
            if all(np.dot(end.coefficients, other.coefficients) <= APART * size**2 for other in found):
                found.append(end)
        return sorted(found, key=lambda one: one.load)

    def _descended(self, start: ImperfectLoad, size: float) -> ImperfectLoad:
        """Where the load falls to from a start, on the sphere."""
        here = start
        for _ in range(ITERATIONS):
            place = np.array(here.coefficients)
            try:
                slope = self.gradient(here.coefficients)
            except NoDerivative:
                break
            steepest = float(np.linalg.norm(slope))
            if not steepest:
                break
            downhill, ahead = -slope / steepest, -slope @ place / (steepest * size)
            across, angle = downhill - ahead * place / size, float(np.arccos(np.clip(ahead, -1.0, 1.0)))
            if steepest * size * angle**2 / 2 <= WELL * abs(here.load) or not across.any():
                break
            lower = (self._lower(here, size * _unit(across), angle, -steepest * float(np.sin(angle)) * size)
                     or self._beside(here, size))
            if lower is None:
                break
            here = lower
        return here

    def _lower(self, here: ImperfectLoad, across: np.ndarray, angle: float, slope: float) -> ImperfectLoad | None:
        """A load on the circle towards another place that falls by enough of what its slope promises; None: none does.

        The parabola through both loads gives the next angle (Dennis and Schnabel 1983, section 6.3.2).
        """
        place = np.array(here.coefficients)
        for _ in range(CUTS):
            one = self.at(np.cos(angle) * place + np.sin(angle) * across)
            bend = one.load - here.load - slope * angle
            if bend <= (1 - ENOUGH) * -slope * angle:
                return one
            angle *= max(CUT, -slope * angle / (2 * bend))
        return None

    def _beside(self, here: ImperfectLoad, size: float) -> ImperfectLoad | None:
        """The least load about another that is less, on the sphere; None: there is none.

        Where the load has a kink, as two limit points have that come first by turns, its slope does not lead down.
        """
        place = np.array(here.coefficients)
        for turn in TURNS:
            around = size * np.linalg.svd(place[None, :])[2][1:]
            least = min((self.at(np.cos(turn) * place + np.sin(turn) * sign * way) for way in around
                         for sign in (1.0, -1.0)), key=lambda one: one.load, default=here)
            if least.load < here.load - WELL * abs(here.load):
                return least
        return None


def _unit(vectors: np.ndarray) -> np.ndarray:
    return vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)
