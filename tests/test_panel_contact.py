"""Panel with a bolted hat whose feet touch the skin between the bolts: what contact costs, and what it does."""

from __future__ import annotations

import time
import warnings
from pathlib import Path

import pytest

import sheetfx as fx
from sheetfx.scenes import load_case

PANEL = Path(__file__).parents[1] / "demos" / "panel.py"


def traced(**options):
    """End of the path, its largest penetration, and CPU seconds of the path."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        made = load_case(str(PANEL))(**options)
        start = time.process_time()
        record = fx.trace(made)
    return record, time.process_time() - start


@pytest.mark.slow
@pytest.mark.parametrize(("imperfection", "times"), [(0.0, 3), (0.4, 10)])
def test_what_contact_costs(imperfection, times):
    """To 1.5 mm, with 60 mm cells; feet that lie on the skin make the panel stiffer than feet that pass through it.

    Three times the CPU time without contact is the aim; the imperfect panel takes seven.
    """
    free, seconds = traced(imperfection=imperfection)
    touching, longer = traced(imperfection=imperfection, clearance=0.15)
    ends = free.states[-1], touching.states[-1]
    assert [end.deflection for end in ends] == pytest.approx([1.5, 1.5])
    assert ends[1].contact_points > 10
    assert max(state.penetration for state in touching.states) < 1.01e-6 * 60
    assert 1.0 < ends[1].load / ends[0].load < 1.2
    assert longer < times * seconds
