"""The bench moves what it says it moves, puts it back, and tells how near comparisons come to another outcome."""

from collections import Counter
from math import exp

import moved
import numpy as np
import pytest
import rows

from sheetfx import ArcLength
from sheetfx.continuation import defect, explained

ROWS = rows.rows()


def row(name, file):
    return next(r for r in ROWS if (r.name, r.file) == (name, file))


def test_rows_are_told_apart():
    assert [key for key, n in Counter(r.key for r in ROWS).items() if n > 1] == []
    assert {r.kind for r in ROWS} == {"constant", "guard"}


@pytest.mark.parametrize("factor", [0.5, 2.0])
def test_constant_is_moved_wherever_it_is_and_put_back(factor):
    def now():
        return vars(explained)["STEEPEST"]

    usual = now()
    with moved.changed(row("STEEPEST", "continuation/explained.py"), factor) as possible:
        assert possible and now() == factor * usual
    assert now() == usual


def test_default_of_an_option_is_moved():
    with moved.changed(row("StepRule.largest", "continuation/control.py"), 2.0) as possible:
        assert possible and ArcLength().largest == 16.0
    assert ArcLength().largest == 8.0


def test_every_place_that_raises_can_be_switched_off():
    for guard in (r for r in ROWS if r.kind == "guard"):
        with moved.changed(guard) as possible:
            assert possible, guard.key


def test_switched_guard_and_its_code():
    before = defect.interpolates
    with moved.changed(row("interpolates", "continuation/defect.py")):
        assert defect.interpolates(None, 0.0, 1.0) is True
    assert defect.interpolates is before


@pytest.mark.parametrize(("compare", "margin"), [
    (lambda c: c < 3.0, 1.5), (lambda c: 2 * c <= np.float64(5.0), 1.25), (lambda c: np.array([8.0, 1.9]) > c, 2 / 1.9),
    (lambda c: 1 / c > 0.25, 2.0), (lambda c: 3.0 * (c * np.array([1.0, 2.0])) < np.array([60.0, 15.0]), 1.25)])
def test_watched_number_keeps_its_margin(compare, margin):
    """Of the constant 2, the factor that would turn a comparison; the comparison itself is the usual one."""
    seen = {}
    assert np.all(compare(moved.Watched(2.0, seen)) == compare(2.0))
    assert exp(seen["margin"]) == pytest.approx(margin, rel=1e-12)
