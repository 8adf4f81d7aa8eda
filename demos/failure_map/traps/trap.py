"""What a trap is: a structure, and all critical points of its path."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

from sheetfx.case import Case

STABLE, UNSTABLE = "stable symmetric", "unstable symmetric"


@dataclass(frozen=True)
class Expected:
    """A critical point as it should be found.

    Attributes
    ----------
    kind : "limit", "bifurcation" or "flutter"
    load : total load on the whole structure
    tolerance : of the load, relative; it holds the error of the trap's coarse mesh
    multiplicity : number of null vectors of the tangent
    name : as in CriticalPoint; None: not compared
    """

    kind: str
    load: float
    tolerance: float = 1e-3
    multiplicity: int = 1
    name: str | None = None


@dataclass(frozen=True, eq=False)
class Trap:
    """A structure on which some classical method fails.

    Attributes
    ----------
    name : as on the command line
    fails : which method fails here, and why
    case : function that makes the case
    points : all critical points in the order of the path
    source : where their loads come from
    slow : whether the path takes more than a few seconds
    """

    name: str
    fails: str
    case: Callable[[], Case]
    points: tuple[Expected, ...]
    source: str
    slow: bool = False


def limits(first: float, *others: float, tolerance: float = 1e-3) -> tuple[Expected, ...]:
    """Limit points with the given loads, maxima and minima in turn."""
    names = ("maximum", "minimum")
    return tuple(Expected("limit", load, tolerance, name=names[n % 2]) for n, load in enumerate((first, *others)))


def bifurcation(load: float, name: str | None = None, tolerance: float = 1e-3) -> Expected:
    return Expected("bifurcation", load, tolerance, 2 if name == "multiple" else 1, name)


def and_mirrored(*points: Expected) -> tuple[Expected, ...]:
    """Points of a path that goes on through the mirror image of the structure, with the loads of opposite signs."""
    names = {"maximum": "minimum", "minimum": "maximum"}
    return points + tuple(replace(p, load=-p.load, name=names.get(p.name, p.name)) for p in reversed(points))
