"""Rates of eigenvalues along the path, by which modes that dip below zero within a step are told."""

from __future__ import annotations

import pytest
from failure_map.traps import TRAPS

import sheetfx as fx
from sheetfx.continuation.segment import Segment
from sheetfx.events.heading import eigenvalues

PART = 1 / 16  # of a step
WITHIN = 1e-2  # of the change of an eigenvalue over that, what the trapezoidal rule is off at most


@pytest.mark.parametrize("name", ["lee-frame", "deep-arch-215", "slenderness-1e-3", "slenderness-1e-5"])
def test_eigenvalues_change_by_their_rates(name):
    """Slender parts show it: a difference to one side is wrong by what the membrane's stiffness adds."""
    case = TRAPS[name].case()
    path = fx.Path(case.scene, case.control, fx.Until(steps=3))
    *_, before = path
    tracer = path.tracer
    tracer.back_to(before)
    after = tracer.attempt(PART * before.length)
    segment = Segment(tracer, before, after)
    (first, rate), (last, later) = (eigenvalues(segment, length)[0] for length in (0.0, after.length))
    change = (rate + later) / 2 * segment.distance(0.0, after.length)
    assert last - first == pytest.approx(change, rel=WITHIN)
