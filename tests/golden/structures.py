"""Structures of the bench, and what comes out of each: critical points, last state, further numbers, cost."""

from __future__ import annotations

import re
import signal
import sys
import time
import warnings
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1]))
sys.path.insert(0, str(Path(__file__).parents[2] / "demos"))

import random_shapes
from afterwards import AFTERWARDS
from failure_map.traps import TRAPS
from random_structures import scene as random_scene
from untried import CASES

import sheetfx as fx

TRUSSES, FRAMES = 34, 26
STEPS = 25  # of a random structure
KEPT = 0.7  # share of the points that a path whose steps are counted must still reach


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
    ended : the path's message, or the error that ended it
    numbers : further ones, of an afterwards
    """

    points: tuple[Point, ...]
    load: float
    deflection: float
    states: int
    factorisations: int
    seconds: float
    ended: str
    numbers: dict[str, float] = field(default_factory=dict)

    @property
    def way(self) -> str:
        """How it ended, without the numbers of the message."""
        return re.sub(r"[-+]?\d[\d.e+-]*", "#", self.ended)[:100]

    @property
    def counted(self) -> bool:
        """Whether the number of steps ended the path."""
        return "steps taken" in self.ended


class TimeIsUp(BaseException):
    """A run that takes too long; no handler of the package catches it."""


def names(which: str = "all") -> list[str]:
    """Structures by name: those of a "quick" bench, or all."""
    share = 1 if which == "all" else 4
    found = [f"trap:{name}" for name, trap in TRAPS.items() if which == "all" or not trap.slow]
    found += [f"truss:{n}" for n in range(TRUSSES // share)] + [f"frame:{n}" for n in range(FRAMES // share)]
    found += [f"untried:{name}" for name in list(CASES)[::1 if which == "all" else 2]]
    return found + [f"after:{name}" for name in list(AFTERWARDS)[::1 if which == "all" else 2]]


def case_of(name: str) -> fx.Case:
    kind, _, which = name.partition(":")
    if kind == "trap":
        return TRAPS[which].case()
    if kind == "untried":
        return CASES[which]()
    if kind == "after":
        return AFTERWARDS[which][0]()
    structure = getattr(random_shapes, kind)(int(which))
    return fx.Case(random_scene(structure), fx.ArcLength(), fx.Until(deflection=structure.deflection, steps=STEPS))


def outcome(name: str, within: float = 600.0, shorter: float = 1.0) -> Outcome:
    """Follow the path of a structure.

    Parameters
    ----------
    within : CPU seconds, after which it is ended
    shorter : factor on the length of all steps
    """
    begun, record, numbers = time.process_time(), None, {}
    try:
        with warnings.catch_warnings(), _limited(within):
            warnings.simplefilter("ignore")
            case = case_of(name)
            if shorter != 1.0:
                case = _shorter(case, shorter)
            record = fx.trace(case)
            ended = record.path.message
            if name.startswith("after:"):
                numbers = {key: float(value) for key, value in AFTERWARDS[name.partition(":")[2]][1](record).items()}
            elif case.until.steps == 0:
                numbers = {f"buckling {n}": load.factor for n, load in enumerate(record.buckling())}
    except TimeIsUp:
        ended = "time is up"
    except Exception as failure:
        ended, record = f"{type(failure).__name__}: {failure}"[:200], getattr(failure, "record", record)
    seconds = time.process_time() - begun
    if record is None or not record.states:
        return Outcome((), 0.0, 0.0, 0, 0, seconds, ended)
    points = tuple(Point(p.kind, p.load, p.deflection, p.multiplicity, p.name) for p in record.critical_points)
    last = record.states[-1]
    return Outcome(points, last.load, last.deflection, len(record.states), sum(s.factorisations for s in record.states),
                   seconds, ended, numbers)


def _shorter(case: fx.Case, factor: float) -> fx.Case:
    """A case with steps that are shorter throughout, the first one that it takes and their bound, and more of them."""
    first = next((s for s in fx.Path(case.scene, case.control, fx.Until(steps=1)) if s.step), None)
    if not first:
        return case
    until = replace(case.until, steps=round(case.until.steps / factor))
    return replace(case, control=replace(case.control, step=factor * first.length), until=until)


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


def difference(golden: Outcome, found: Outcome, accuracy: float = 1e-6) -> str:
    """How an outcome differs from the golden one; "" where it does not.

    Where steps are counted only the points that both paths reach are compared. Nearly all must be reached, unless the
    other path alone ends by its number of steps, as with shorter ones.

    Parameters
    ----------
    accuracy : of loads and numbers, relative to the largest
    """
    cut = found.counted and not golden.counted
    if found.way != golden.way and not cut and not (golden.counted and "reached" in found.ended):
        return f"ends: {found.ended}"
    count, reached = len(golden.points), len(found.points)
    allowed = reached < count if cut else golden.counted and (reached >= KEPT * count or not found.counted)
    if count != reached and not allowed:
        return f"{reached} points for {count}"
    largest = max([abs(p.load) for p in golden.points] + [abs(golden.load)]) or 1.0
    for mine, other in zip(golden.points, found.points, strict=False):
        if (mine.kind, mine.multiplicity, mine.name) != (other.kind, other.multiplicity, other.name):
            return f"{other.kind} {other.name} {other.multiplicity} for {mine.kind} {mine.name} {mine.multiplicity}"
        if abs(mine.load - other.load) > accuracy * largest:
            return f"load {other.load:.9g} for {mine.load:.9g}"
    if "reached" in golden.ended and not cut and abs(golden.load - found.load) > accuracy * largest:
        return f"last load {found.load:.9g} for {golden.load:.9g}"
    if golden.numbers.keys() != found.numbers.keys():
        return f"{len(found.numbers)} numbers for {len(golden.numbers)}"
    for key, value in golden.numbers.items():
        if abs(found.numbers[key] - value) > max(accuracy, 1e-4) * max(abs(value), 1e-12):
            return f"{key} {found.numbers[key]:.9g} for {value:.9g}"
    return ""
