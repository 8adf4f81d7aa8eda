"""Error bars that cells of twice the size agree with.

A bar is the change of a load by one degree more, which is the error where the load converges faster with that degree.
Cells of twice the size have the same point, at the load l' with the bar b' for l with b. Where both are on their way to
the same power of the cells, b / b' = r is what errors fall by, and the error is (l' - l) r / (1 - r) (Roache 1998). At
integrals of a shape, and beside corners with forces, that is much more than b: one degree more helps little there.
With contact or yielding errors follow no power of the cells, and bars are as they are.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from .. import rounding
from ..checks import require
from ..continuation.state import CriticalPoint
from ..critical.defining import without_third_variations
from ..critical.error_bar import ALIKE, ErrorBar, richer_scene
from ..record import Record
from .meshes import Meshes
from .models import quiet

LEAST, MOST = 0.75, 1.35  # a bar over the error by two meshes, where both tell the same


def error_bars_beside(record: Record, meshes: Meshes | None,
                      points: Sequence[CriticalPoint] | None = None) -> list[ErrorBar]:
    """Error bars of a record, none where cells of twice the size tell another error.

    Parameters
    ----------
    record : its `errors` are replaced
    meshes : of its case, level 0 being the given one; None, or without coarser ones: bars as they are
    points : None: all but events
    """
    require("error_bars_beside", record=(record, Record), meshes=(meshes, Meshes | None))
    bars = record.error_bars(points)
    asked = [bar for bar in bars if _asks(bar)]
    rough = without_third_variations(record.path.discretisation.system)
    if rough or not asked or meshes is None or meshes.lowest >= 0:
        return bars
    try:
        with quiet():
            coarse = meshes.case(-1).scene
            scenes = coarse, richer_scene(coarse) or coarse
            there, beyond = (record.loads_on(scene, [bar.point for bar in asked]) for scene in scenes)
    except (ArithmeticError, ValueError):
        return bars
    compared = {bar.point: _compared(bar, *others) for bar, *others in zip(asked, there, beyond, strict=True)}
    record.errors |= compared
    return [compared.get(bar.point, bar) for bar in bars]


def _asks(bar: ErrorBar) -> bool:
    """Whether there is a bar, and more of it than rounding."""
    return bar.error is not None and abs(bar.error) > rounding.NONE * abs(bar.point.load)


def _compared(bar: ErrorBar, coarse: ErrorBar, richer: ErrorBar) -> ErrorBar:
    """A bar beside differences from the load on coarser cells, and from that on these with one degree more."""
    if bar.error is None or coarse.error is None or richer.error is None or min(coarse.alike, richer.alike) < ALIKE:
        return _none(bar, "cells of twice the size have no such point")
    there = richer.error - coarse.error
    share = bar.error / there if there else 1.0
    if not 0.0 < share < 1.0:
        return _none(bar, f"one degree more changes it by {-bar.error:.2g} here and by {-there:.2g} on cells of twice "
                          "the size")
    error = -coarse.error * share / (1.0 - share)
    if error and LEAST <= bar.error / error <= MOST:
        return bar
    return _none(bar, f"one degree more changes it by {-bar.error:.2g}, and by cells of twice the size it is off by "
                      f"{error:.2g}")


def _with(bar: ErrorBar, reason: str) -> ErrorBar:
    return replace(bar, reason="; ".join(filter(None, (bar.reason, reason))))


def _none(bar: ErrorBar, reason: str) -> ErrorBar:
    return _with(replace(bar, error=None), f"{reason}: compare finer meshes, with --within")
