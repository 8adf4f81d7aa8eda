"""Error bars that cells of twice the size agree with."""

from __future__ import annotations

import pytest
from helpers import on_two_processes

import sheetfx as fx
from sheetfx.continuation.state import CriticalPoint
from sheetfx.critical.error_bar import ErrorBar
from sheetfx.ladder import coarser_bars
from sheetfx.ladder.coarser_bars import error_bars_beside
from sheetfx.ladder.meshes import by_option
from sheetfx.scenes import arch, deep_arch, dome, lee_frame, sinusoidal_arch

POINT = CriticalPoint(kind="limit", load=100.0, deflection=1.0, step=1, length=0.1)


def beside(function, **options):
    record = fx.trace(function(**options))
    return record, error_bars_beside(record, by_option(function, options))


def test_a_load_that_one_degree_more_hardly_changes_has_no_bar():
    """The maximum of the sinusoidal arch: its bar is a quarter of the true error, those of its other points are right.

    Loads on 64 elements: 8.678597, 9.685298, -4.085389.
    """
    record, (bifurcation, maximum, minimum, *_) = beside(sinusoidal_arch.case, elements=8)
    assert maximum.error is None and "off by 0.00018: compare finer meshes" in maximum.reason, str(maximum)
    assert maximum.point.load - 9.685298 == pytest.approx(0.000129, abs=1e-5)
    assert bifurcation.error == pytest.approx(8.68364 - 8.678597, rel=0.03) and not bifurcation.reason
    assert 0.75 < minimum.error / (-4.08505 + 4.085389) < 1.35 and not minimum.reason
    assert record.errors[maximum.point] == maximum


@pytest.mark.slow
@pytest.mark.parametrize(("function", "elements"), [(lee_frame.case, 10), (deep_arch.case, 30)])
def test_bars_of_smooth_solutions_stay(function, elements):
    record, bars = beside(function, elements=elements)
    assert bars == record.error_bars() and not any(bar.reason for bar in bars)


@pytest.mark.slow
def test_the_first_bifurcation_of_the_dome():
    """It falls with the first power of the cells: with 4 cells a bar of 44 kN, for an error of 79."""
    _, bars = beside(dome.case, divisions=4)
    first = bars[0]
    assert first.point.kind == "bifurcation" and first.point.load == pytest.approx(1630.2e3, rel=1e-3)
    assert first.error is None and "twice the size" in first.reason


def test_no_comparison_leaves_bars_as_they_are():
    """With contact, and without coarser cells."""
    contact = arch.case(elements=20, to=20.0)
    few, smooth = (sinusoidal_arch.case(elements=n) for n in (2, 8))
    for case, meshes in ((contact, by_option(arch.case, {"elements": 20})), (smooth, None),
                         (few, by_option(sinusoidal_arch.case, {"elements": 2}))):
        record = fx.trace(case)
        assert error_bars_beside(record, meshes) == record.error_bars()


@pytest.mark.parametrize(("bar", "coarse", "richer", "error"), [
    (1.0, -15.0, 1.0, 1.0),  # fourth power, and one degree more is exact
    (0.25, -15.0, -11.0, None),  # fourth power, and one degree more has three quarters of the error
    (1.0, -2.0, 0.0, None),  # first power, and one degree more has half of the error
    (1.0, -15.0, -20.0, None),  # the other way on coarser cells
    (1.0, 15.0, 31.0, None),  # errors of the other sign
    (2.0, -3.0, -1.5, None),  # more than on coarser cells
], ids=["smooth", "integral", "corner", "sign", "way", "grows"])
def test_two_meshes_beside_one_degree_more(bar, coarse, richer, error):
    bars = [ErrorBar(POINT, value, alike=1.0) for value in (bar, coarse, richer)]
    assert coarser_bars._compared(*bars).error == error


def test_modes_that_are_other_ones_tell_nothing():
    found = coarser_bars._compared(*(ErrorBar(POINT, value, alike=alike)
                                     for value, alike in ((1.0, 1.0), (-15.0, 0.5), (1.0, 1.0))))
    assert found.error is None and "no such point" in found.reason


TWO = """
from mpi4py import MPI
import sheetfx as fx
from sheetfx.ladder.coarser_bars import error_bars_beside
from sheetfx.ladder.meshes import by_option
from sheetfx.scenes.sinusoidal_arch import case
bars = error_bars_beside(fx.trace(case(elements=8)), by_option(case, {"elements": 8}))
if MPI.COMM_WORLD.rank == 0:
    print(*(bar.error for bar in bars))
"""


@pytest.mark.slow
def test_two_processes_find_the_same():
    _, bars = beside(sinusoidal_arch.case, elements=8)
    (line,) = on_two_processes(TWO)
    bifurcation, maximum, minimum, other = line.split()
    assert maximum == "None" and [float(bifurcation), float(minimum), float(other)] == pytest.approx(
        [bar.error for bar in bars if bar.error is not None], rel=1e-4)
