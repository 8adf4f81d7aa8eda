"""Structures of the bench, and what comes out of each: critical points, last state, cost."""

from __future__ import annotations

import signal
import sys
import time
import warnings
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1]))

import random_shapes
from random_structures import scene as random_scene

import sheetfx as fx
from sheetfx.continuation.control import StepRule
from sheetfx.studies.traps import TRAPS

TRUSSES, FRAMES = 34, 26
STEPS = 40  # of a random structure


@dataclass(frozen=True)
class Point:
    """A critical point as golden figures keep it."""

    kind: str
    load: float
    deflection: float
    multiplicity: int
    name: str | None


@dataclass(frozen=True)
class Outcome:
    """What came of a run.

    Attributes
    ----------
    points : all critical points
    load, deflection : of the last state
    states, factorisations : their numbers
    seconds : CPU time
    ended : "" where the path came to its end, else why not
    """

    points: tuple[Point, ...]
    load: float
    deflection: float
    states: int
    factorisations: int
    seconds: float
    ended: str


class TimeIsUp(BaseException):
    """A run that takes too long; no handler of the package catches it."""


def names(which: str = "all") -> list[str]:
    """Structures by name: those of a "quick" bench, or all."""
    traps = [f"trap:{name}" for name, trap in TRAPS.items() if which == "all" or not trap.slow]
    share = 1 if which == "all" else 4
    return traps + [f"truss:{n}" for n in range(TRUSSES // share)] + [f"frame:{n}" for n in range(FRAMES // share)]


def case_of(name: str) -> fx.Case:
    kind, _, which = name.partition(":")
    if kind == "trap":
        return TRAPS[which].case()
    structure = getattr(random_shapes, kind)(int(which))
    return fx.Case(random_scene(structure), fx.ArcLength(), fx.Until(deflection=structure.deflection, steps=STEPS))


def outcome(name: str, within: float = 600.0, shorter: float = 1.0) -> Outcome:
    """Follow the path of a structure.

    Parameters
    ----------
    within : CPU seconds, after which it is ended
    shorter : factor on the length of all steps
    """
    begun, ended, record = time.process_time(), "", None
    try:
        with warnings.catch_warnings(), _limited(within):
            warnings.simplefilter("ignore")
            case = case_of(name)
            if shorter != 1.0:
                case = replace(case, control=_shorter(case, shorter))
            record = fx.trace(case)
    except TimeIsUp:
        ended = "time is up"
    except Exception as failure:
        ended, record = f"{type(failure).__name__}: {failure}"[:200], getattr(failure, "record", None)
    seconds = time.process_time() - begun
    if record is None or not record.states:
        return Outcome((), 0.0, 0.0, 0, 0, seconds, ended)
    points = tuple(Point(p.kind, p.load, p.deflection, p.multiplicity, p.name) for p in record.critical_points)
    last = record.states[-1]
    return Outcome(points, last.load, last.deflection, len(record.states), sum(s.factorisations for s in record.states),
                   seconds, ended)


def _shorter(case: fx.Case, factor: float) -> StepRule:
    """The control of a case with steps that are shorter throughout: the first one that it takes, and their bound."""
    first = next(s for s in fx.Path(case.scene, case.control, fx.Until(steps=1)) if s.step)
    return replace(case.control, step=factor * first.length)


@contextmanager
def _limited(seconds: float):
    def end(*_):
        raise TimeIsUp

    before = signal.signal(signal.SIGVTALRM, end)
    signal.setitimer(signal.ITIMER_VIRTUAL, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_VIRTUAL, 0)
        signal.signal(signal.SIGVTALRM, before)


def difference(golden: Outcome, found: Outcome, load: float = 1e-6) -> str:
    """How an outcome differs from the golden one; "" where it does not."""
    if found.ended != golden.ended and (found.ended or golden.ended):
        return f"ends: {found.ended or 'at its bound'}"
    if len(golden.points) != len(found.points):
        return f"{len(found.points)} points for {len(golden.points)}"
    for mine, other in zip(golden.points, found.points, strict=True):
        if (mine.kind, mine.multiplicity, mine.name) != (other.kind, other.multiplicity, other.name):
            return f"{other.kind} {other.name} {other.multiplicity} for {mine.kind} {mine.name} {mine.multiplicity}"
        if abs(mine.load - other.load) > load * max(abs(p.load) for p in golden.points):
            return f"load {other.load:.9g} for {mine.load:.9g}"
    return ""
