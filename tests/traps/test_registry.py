"""Every trap, followed by the default method, gives all its critical points and no others."""

from __future__ import annotations

from dataclasses import replace

import pytest

from sheetfx.case import Case, trace
from sheetfx.traps import TRAPS, Trap

PENDING = {
    "star-dome-all-nodes": "a double bifurcation in a step with three more points is found twice, once 7e-5 of the "
                           "load away",
    "slenderness-1e-5": "the step past the first bifurcation is refused for rounding of the eigenvalue",
    "slenderness-1e-6": "the minimum is named a maximum",
}
SMALL = [t.name for t in TRAPS.values() if not t.slow and t.points and not t.name.startswith(("punch", "slenderness"))]


def named(names, pending):
    return [pytest.param(n, marks=pytest.mark.xfail(strict=True, reason=pending[n]) if n in pending else ())
            for n in names]


def assert_points(trap: Trap, case: Case):
    found = trace(case).critical_points
    assert [p.kind for p in found] == [e.kind for e in trap.points]
    for point, expected in zip(found, trap.points, strict=True):
        assert point.load == pytest.approx(expected.load, rel=expected.tolerance)
        assert point.multiplicity == expected.multiplicity
        assert expected.name in (None, point.name)


@pytest.mark.parametrize("name", named(TRAPS, PENDING))
def test_all_critical_points_and_no_others_are_found(name):
    assert_points(TRAPS[name], TRAPS[name].case())


@pytest.mark.slow
@pytest.mark.parametrize("factor", [1 / 16, 1 / 4, 4, 16])
@pytest.mark.parametrize("name", SMALL)
def test_steps_of_any_length_find_the_same_points(name, factor):
    case = TRAPS[name].case()
    assert_points(TRAPS[name], replace(case, control=replace(case.control, step=factor * case.control.first)))
