"""Structures on which classical methods of path following fail, with every critical point of their paths.

A method is right on a trap if it finds all points of the list, in this order, and no others.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

from .case import Case
from .scenes import arch, deep_arch, lee_frame, roll_up, roof


@dataclass(frozen=True)
class Expected:
    """A critical point as it should be found.

    Attributes
    ----------
    kind : "limit" or "bifurcation"
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


def _limits(first: float, *others: float, tolerance: float = 1e-3) -> tuple[Expected, ...]:
    """Limit points with the given loads, maxima and minima in turn."""
    names = ("maximum", "minimum")
    return tuple(Expected("limit", load, tolerance, name=names[n % 2]) for n, load in enumerate((first, *others)))


TRAPS = {trap.name: trap for trap in (
    Trap("lee-frame",
         "Displacement control fails: the loaded point moves back while the load falls.",
         partial(lee_frame.scene, elements=10), _limits(18556.7, -9414.4, tolerance=2e-4),
         "shear-rigid limits of the scene lee-frame, converged"),
    Trap("deep-arch-215",
         "Load control stops at the first limit, behind which the arch sways to its hinged side.",
         partial(deep_arch.scene, elements=30), _limits(11.21600, -0.91309, tolerance=5e-4),
         "DaDeppo and Schmidt 1975: 8.9728 EI/R^2 = 11.2160; the minimum from 160 elements"),
    Trap("roof-12.7",
         "Load control jumps from the first limit to a distant state; a predictor whose sign follows the last load "
         "increment turns back behind it.",
         partial(roof.scene, cells=2), _limits(2220.93, 505.68, tolerance=1e-3),
         "16 x 16 cells; Sze, Liu and Lo 2004: 2226 and 519 as tabulated"),
    Trap("roof-6.35",
         "Displacement control jumps where the crown moves back, load control at both limits.",
         partial(roof.scene, cells=2, thickness=6.35), _limits(583.83, -384.66, tolerance=3e-3),
         "16 x 16 cells; Sze, Liu and Lo 2004: 585.9 and -386.4 as tabulated"),
    Trap("punch-arch",
         "Contact is gained and lost within a step, so tangents waver and signs of pivots mean little.",
         partial(arch.scene, elements=40), _limits(205.60, 88.35, tolerance=2e-3),
         "160 elements: 205.60; 1.292 times the limit load of the arch under a point load"),
    Trap("punch-arch-friction",
         "With friction the tangent is not symmetric, its factor counts no negative pivots, and the state at the "
         "limit depends on the path that led to it.",
         partial(arch.scene, elements=40, friction=0.3), _limits(206.10, 88.86, tolerance=5e-3),
         "80 elements"),
    Trap("roll-up",
         "Rotations pass 2 pi twice: rotation vectors that are added up are singular there.",
         partial(roll_up.scene, turns=2), (), "exact circle; the tangent stays definite"),
    Trap("roll-up-in-space",
         "Rotations pass 2 pi twice about an axis in space.",
         partial(roll_up.scene, turns=2, spatial=True), (), "exact circle; the tangent stays definite"),
)}
