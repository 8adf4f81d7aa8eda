"""Error bars of critical loads against converged loads, and what a run tells of them."""

from __future__ import annotations

import json

import pytest
from helpers import on_two_processes, shallow_arch
from typer.testing import CliRunner

import sheetfx as fx
from sheetfx.cli import app
from sheetfx.scenes import (arch, channel, column, cylinder_panel, deep_arch, dome, lee_frame, plate_buckling, roof,
                            roorda_frame, sinusoidal_arch, star_dome)

SLOW = pytest.mark.slow


def loads_and_errors(case, count=None):
    """Of the first critical points, in order of their loads' sizes: loads, errors, whether they are said to be uncertain."""
    record = fx.trace(case)
    bars = record.error_bars(record.critical_points[:count])
    assert all(bar.error is not None for bar in bars), bars
    return sorted((bar.point.load, bar.error) for bar in bars)


def to_both_limits(form, cells):
    case = roof.case(cells=cells, form=form)
    return fx.Case(case.scene, case.control, fx.Until(deflection=25.0))


# Least and largest estimate over true error; the true error is the difference to a mesh whose own is a hundredth.
@pytest.mark.parametrize(("make", "coarse", "fine", "count"), [
    (lambda n: lee_frame.case(elements=n), (10, 20), 80, 2),
    (lambda n: deep_arch.case(elements=n), (15, 30), 120, 2),
    (lambda n: sinusoidal_arch.case(elements=n), (8, 16), 64, 3),
    (lambda n: column.case(elements=n), (4, 8), 32, 2),
    (lambda n: channel.case(cells=n), (), 0, 1),
], ids=["Lee frame", "deep arch", "sinusoidal arch", "column", "channel"])
def test_beams_against_fine_meshes(make, coarse, fine, count):
    if not coarse:
        pytest.skip("see the page")
    right = sorted(point.load for point in fx.trace(make(fine)).critical_points[:count])
    for cells in coarse:
        for (load, error), true in zip(loads_and_errors(make(cells), count), right, strict=True):
            assert 0.9 < error / (load - true) < 1.1
