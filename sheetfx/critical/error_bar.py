"""How far critical loads are off by their discretisation: the same points with polynomials of one degree more.

State and null vectors are taken over to the richer discretisation of the same cells, and the augmented Newton method
finds the point there, until its load is known but for a small share of its change (the loss of stress that
interpolation brings in comes first, see `augmented`). That takes one to four factorisations. Where solutions are smooth
the change is 0.77 to 1.28 of the true error, elsewhere less (`demos/pages/error_bars.md`). Where that method does not
apply, as with contact, another one may find the points there (`richer_path`).
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import cast

import numpy as np

from ..continuation.control import ArcLength
from ..continuation.state import CriticalPoint, State
from ..continuation.tracer import Tracer, tracer_of
from ..continuation.transferred import between
from ..discrete.discretisation import Discretisation
from ..model.richer import NothingRicher, richer
from ..model.scene import Scene
from .augmented import load_within
from .defining import without_third_variations
from .remade import remade

ByPath = Callable[[Scene], Callable[[CriticalPoint, float], tuple[float, float, int]]]

SHARE = 0.02  # of the change of a load that need not be known
ALIKE = 0.95  # cosine between a mode and the richer discretisation's, below which it may be another one


@dataclass(frozen=True)
class ErrorBar:
    """Estimate of the discretisation error of a critical load.

    Attributes
    ----------
    point : CriticalPoint
    error : its load less that with one degree more, so that a positive one is on the unsafe side; None: not known
    reason : why it is not known, or not certain; "" otherwise
    alike : smallest cosine between the null vectors and those with one degree more; 0: not known
    factorisations : that it took
    """

    point: CriticalPoint
    error: float | None
    reason: str = ""
    alike: float = 0.0
    factorisations: int = 0

    def __str__(self) -> str:
        if self.error is None:
            return f"{self.point.title} at load {self.point.load:.6g}: no error estimate ({self.reason})"
        return (f"{self.point.title} at load {self.point.load:.6g}, too {'high' if self.error > 0 else 'low'} by "
                f"{abs(self.error):.2g}" + (f" ({self.reason})" if self.reason else ""))


def error_bars(path, points: Iterable[CriticalPoint], state_at: Callable[[CriticalPoint], State],
               modes_at: Callable[[CriticalPoint], Sequence[np.ndarray]],
               by_path: ByPath | None = None, scene: Scene | None = None) -> list[ErrorBar]:
    """Error bars of critical points of a path, which stays at its present state.

    Parameters
    ----------
    path : Path or Tracer
    points : of the path
    state_at, modes_at : give the state and the null vectors of a point
    by_path : from the richer scene to what finds its points where the augmented Newton method is not for them, see
        `richer_path`; None: no bar then
    scene : the same structure otherwise discretised, for loads less those there; None: with one degree more
    """
    points, reason, present, found = list(points), "", tracer_of(path).state, []
    try:
        bar_of = _estimator(path, state_at, modes_at, by_path, scene) if points else None
    except (ArithmeticError, ValueError) as failure:
        bar_of, reason = None, str(failure)
    try:
        for point in points:
            why = reason or _reason_of(point)
            try:
                found.append(bar_of(point) if bar_of and not why else ErrorBar(point, None, why))
            except (ArithmeticError, ValueError) as failure:
                found.append(ErrorBar(point, None, str(failure)))
    finally:
        tracer_of(path).back_to(present)
    return _in_order(found)


def _estimator(path, state_at: Callable[[CriticalPoint], State],
               modes_at: Callable[[CriticalPoint], Sequence[np.ndarray]],
               by_path: ByPath | None, scene: Scene | None) -> Callable[[CriticalPoint], ErrorBar]:
    """Function that makes the bar of a point; ValueError where no point has one, and says why."""
    scene, refused = scene or _richer(path.discretisation), without_third_variations(path.discretisation.system)
    if refused and by_path is None:
        raise ValueError(refused)
    if scene is None:
        return lambda point: ErrorBar(point, 0.0, alike=1.0)
    if refused and by_path:
        by_piece, uncounted = by_path(scene), _uncounted(path)
        return lambda point: _bar(point, by_piece(point, ALIKE), uncounted)
    tracer = Tracer(Discretisation(scene), ArcLength(), "sheetfx_")
    return lambda point: _bar(point, _by_newton(path.discretisation, tracer, point, state_at(point), modes_at(point)))


def _uncounted(path) -> str:
    """What an error leaves out that is found with one degree more."""
    contributions = path.discretisation.system.contributions
    left = [what for what, there in (("layers and steps", any(c.remembers for c in contributions)),
                                     ("steps", any(not (c.smooth or c.conservative) for c in contributions))) if there]
    return f"without that of {left[0]}" if left else ""


def _reason_of(point: CriticalPoint) -> str:
    if point.kind not in ("limit", "bifurcation"):
        return f"the tangent is not singular at {point.title}"
    if point.spread:
        return "points that could not be told apart"
    return ""


def _richer(discretisation) -> Scene | None:
    if not isinstance(discretisation, Discretisation):
        raise NothingRicher("a plain form has no richer one")
    return richer_scene(discretisation.scene)


def richer_scene(scene: Scene) -> Scene | None:
    """The structure with one degree more; None where it has only straight bars, which are exact.

    Raises
    ------
    NothingRicher
    """
    things = richer(scene.parts)
    return remade(scene, things) if things else None


def _by_newton(source: Discretisation, tracer: Tracer, point: CriticalPoint, state: State,
               modes: Sequence[np.ndarray]) -> tuple[float, float, int]:
    """Load, likeness and factorisations by the augmented Newton method."""
    before = tracer.total_factorisations
    guess, there = between(state, source, cast(Discretisation, tracer.discretisation), modes)
    return *load_within(tracer, guess, there, point.kind, SHARE), tracer.total_factorisations - before


def _bar(point: CriticalPoint, there: tuple[float, float, int], uncounted: str = "") -> ErrorBar:
    load, alike, factorisations = there
    other = f"its mode may be another one there, alike to {alike:.2f}" if alike < ALIKE else ""
    return ErrorBar(point, point.load - load, "; ".join(filter(None, (uncounted, other))), alike, factorisations)


def _in_order(bars: list[ErrorBar]) -> list[ErrorBar]:
    """Bars of points in the order of a path; where neighbours overlap each tells it."""
    for n, (one, other) in enumerate(pairwise(bars)):
        if one.error is None or other.error is None:
            continue
        if abs(one.point.load - other.point.load) <= abs(one.error) + abs(other.error):
            bars[n] = _doubtful(bars[n], other.point)
            bars[n + 1] = _doubtful(other, one.point)
    return bars


def _doubtful(bar: ErrorBar, neighbour: CriticalPoint) -> ErrorBar:
    said = f"its order with the {neighbour.kind} point at load {neighbour.load:.6g} is uncertain"
    return replace(bar, reason=f"{bar.reason}; {said}" if bar.reason else said)
