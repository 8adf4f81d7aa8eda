"""How far critical loads are off by their discretisation: the same points with polynomials of one degree more.

State and null vectors are taken over to the richer discretisation of the same cells, and the augmented Newton method
finds the point there, until its load is known but for a small share of its change (the loss of stress that
interpolation brings in comes first, see `augmented`). That takes one to four factorisations. Where solutions are smooth
the change is 0.77 to 1.28 of the true error, elsewhere less (`demos/pages/error_bars.md`).
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
from ..model.richer import richer
from ..model.scene import Scene
from .augmented import load_within
from .remade import remade

SHARE = 0.02  # of the change of a load that need not be known
ALIKE = 0.95  # cosine between a mode and that of the richer discretisation, below which it may be another one


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
               modes_at: Callable[[CriticalPoint], Sequence[np.ndarray]]) -> list[ErrorBar]:
    """Error bars of critical points of a path, which stays at its present state.

    Parameters
    ----------
    path : Path or Tracer
    points : of the path
    state_at, modes_at : give the state and the null vectors of a point
    """
    points, reason, tracer = list(points), _reason(path), None
    if points and not reason:
        try:
            tracer = _richer(path.discretisation.scene)
        except (ArithmeticError, ValueError) as failure:
            reason = str(failure)
    present, found = tracer_of(path).state, []
    try:
        for point in points:
            try:
                if why := reason or _reason_of(point):
                    found.append(ErrorBar(point, None, why))
                elif tracer is None:
                    found.append(ErrorBar(point, 0.0, alike=1.0))
                else:
                    found.append(_bar(point, path.discretisation, tracer, state_at(point), modes_at(point)))
            except (ArithmeticError, ValueError) as failure:
                found.append(ErrorBar(point, None, str(failure)))
    finally:
        tracer_of(path).back_to(present)
    return _in_order(found)


def _reason(path) -> str:
    """Why no load of a path has an error bar; "": some may have."""
    system = path.discretisation.system
    if not isinstance(path.discretisation, Discretisation):
        return "a plain form has no richer one"
    if system.rough:
        return "contact or friction"
    if any(contribution.remembers for contribution in system.contributions):
        return "laws with history"
    if not system.conservative:
        return "forces without a potential"
    return ""


def _reason_of(point: CriticalPoint) -> str:
    if point.kind not in ("limit", "bifurcation"):
        return f"the tangent is not singular at {point.title}"
    if point.spread:
        return "points that could not be told apart"
    return ""


def _richer(scene: Scene) -> Tracer | None:
    """A tracer of the structure with one degree more; None where it has no discretisation."""
    things = richer(scene.parts)
    return Tracer(Discretisation(remade(scene, things)), ArcLength(), "sheetfx_") if things else None


def _bar(point: CriticalPoint, source: Discretisation, tracer: Tracer, state: State,
         modes: Sequence[np.ndarray]) -> ErrorBar:
    before = tracer.total_factorisations
    guess, there = between(state, source, cast(Discretisation, tracer.discretisation), modes)
    load, alike = load_within(tracer, guess, there, point.kind, SHARE)
    reason = "" if alike >= ALIKE else f"its mode may be another one there, alike to {alike:.2f}"
    return ErrorBar(point, point.load - load, reason, alike, tracer.total_factorisations - before)


def _in_order(bars: list[ErrorBar]) -> list[ErrorBar]:
    """Bars of points in the order of a path; where those of neighbours overlap each tells it."""
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
