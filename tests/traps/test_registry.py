"""Every trap, followed by the default method, gives all its critical points and no others."""

from __future__ import annotations

import pytest

from sheetfx.case import trace
from sheetfx.traps import TRAPS


@pytest.mark.parametrize("name", [pytest.param(t.name, marks=[pytest.mark.slow] * t.slow) for t in TRAPS.values()])
def test_all_critical_points_and_no_others_are_found(name):
    trap = TRAPS[name]
    found = trace(trap.case()).critical_points
    assert [p.kind for p in found] == [e.kind for e in trap.points]
    for point, expected in zip(found, trap.points, strict=True):
        assert point.load == pytest.approx(expected.load, rel=expected.tolerance)
