"""Critical points that lie close together: told apart, named rightly, none of them invented."""

import re
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from dense_path import DensePath
from helpers import on_two_processes
from random_structures import DenseTruss, Structure, scene
from scipy.optimize import brentq

import sheetfx as fx
from sheetfx.continuation.segment import Segment
from sheetfx.continuation.state import CriticalPoint, State
from sheetfx.events.search import unresolved

SLOW = pytest.mark.slow
RISE = 3.0
NAMES = {"across": "stable symmetric", "return": "unstable symmetric"}


def pyramid(gap: float) -> Structure:
    """Four legs, of which one pair is stiffer by a share: its apex sways along either pair."""
    nodes = {"apex": (0.0, 0.0, RISE), "east": (1.0, 0.0, 0.0), "west": (-1.0, 0.0, 0.0), "north": (0.0, 1.0, 0.0),
             "south": (0.0, -1.0, 0.0)}
    members = [("apex", "east", 0), ("apex", "west", 0), ("apex", "north", 1), ("apex", "south", 1)]
    return Structure("pyramid", nodes, members, [1.0, 1.0 + gap], dict.fromkeys(list(nodes)[1:], "x y z"),
                     {"apex": (0.0, 0.0, -1.0)}, ("apex", "z", -1.0), 2.2 * RISE)


@cache
def loads(gap: float) -> dict[str, float]:
    """Loads of the first bifurcation, where its branch returns, and on this branch that of the sway across it."""
    truss = DenseTruss(pyramid(gap))
    path = DensePath(truss, 0.05, 0.05)
    while not path.points:
        path.step()

    def on_branch(x: float, z: float) -> float:
        for _ in range(20):
            gradient, hessian = truss.derivatives(np.array([x, 0.0, z]))
            z -= gradient[0] / hessian[0, 2]
        return float(z)

    def across(x: float, z: float) -> float:
        return truss.derivatives(np.array([x, 0.0, on_branch(x, z)]))[1][1, 1]

    z, x, step = float(path.places[-1].z[2]), 1e-3, 0.01
    while across(x, z) * across(x + step, z) > 0:
        x, z = x + step, on_branch(x + step, z)
    x = brentq(across, x, x + step, args=(z,), xtol=1e-14)
    return {"return": path.points[0].factor,
            "across": -float(truss.derivatives(np.array([x, 0.0, on_branch(x, z)]))[0][2])}


def points_on_branch(gap: float, times: float = 1.0) -> list[CriticalPoint]:
    """Seven or so points in order on the closed branch, followed by multiples of a step."""
    case = fx.Case(scene(pyramid(gap)), until=fx.Until(deflection=0.5))
    record = fx.trace(case)
    point = next(p for p in record.critical_points if p.kind == "bifurcation")
    start = fx.branches(record.path, record.states, point)[0].start
    control = fx.ArcLength(0.01 * times, largest=8 / min(times, 1.0))
    found = []
    for state in fx.Path(case.scene, control, fx.Until(steps=200), start=[start]):
        found += state.critical
        if len(found) >= 7:
            break
    return found


@pytest.mark.parametrize("gap", [0.05, 1e-3])
@pytest.mark.parametrize("times", [1, 4, 12, *(pytest.param(t, marks=SLOW) for t in (1 / 16, 1 / 4, 15.9, 16))])
@pytest.mark.slow(quick=1)
def test_branch_that_returns_beside_another_mode(gap, times):
    """A closed branch passes through both bifurcations it ends at, and before and behind sways across itself."""
    found = points_on_branch(gap, times)
    assert [(p.kind, p.multiplicity) for p in found] == len(found) * [("bifurcation", 1)]
    cycle = [(sign, kind) for sign in (1, -1) for kind in ("across", "return", "across")]
    signs = [(int(np.sign(p.load)), next(kind for kind in NAMES if NAMES[kind] == p.name)) for p in found]
    assert signs in [[cycle[(k + i) % 6] for i in range(len(found))] for k in range(6)]
    assert [abs(p.load) for p in found] == pytest.approx([loads(gap)[kind] for _, kind in signs], rel=2e-7)


@SLOW
@pytest.mark.parametrize("gap", [0.05, 1e-3])
def test_branch_that_returns_on_two_processes(gap):
    """The same points in the same order."""
    lines = on_two_processes(f"""
from test_close_points import points_on_branch
for p in points_on_branch({gap}):
    print(f"{{p.load:.12g}}", p.multiplicity, p.name)""")
    alone = points_on_branch(gap)
    both = [line.split(maxsplit=2) for line in lines]
    assert [(int(number), name) for _, number, name in both] == [(p.multiplicity, p.name) for p in alone]
    assert [float(load) for load, *_ in both] == pytest.approx([p.load for p in alone], rel=1e-8)


def test_what_cannot_be_told_apart_has_a_spread_instead_of_a_number(tmp_path):
    """Two of the pyramid's points, as if they could not be resolved."""
    record = fx.trace(fx.Case(scene(pyramid(1e-3)), until=fx.Until(deflection=0.5)))
    first, second = [p for p in record.critical_points if p.kind == "bifurcation"]
    before, after = record.states[first.step - 1], record.states[first.step]
    segment = Segment(record.path.tracer, before, after)
    crossings = unresolved(segment, 0.0, after.length, 2)
    assert crossings[0].spread == (before.load, after.load)
    assert before.load < first.load < after.load
    point = replace(first, multiplicity=2, name="", spread=crossings[0].spread)
    assert re.match(r"bifurcation points \(at least 2, not told apart, between the loads .* and .*\)", point.title)
    replace(after, critical=(point,)).save(tmp_path / "state.npz")
    assert State.load_from(tmp_path / "state.npz").critical == (point,)


def springs_in_series(scales: list[float]) -> fx.Scene:
    """Springs of the law s (e^3 - 4.5 e^2 + 6 e): each has a maximum 2.5 s at e = 1 and a minimum 2 s at e = 2."""
    count = len(scales)
    nodes = {f"n{i}": (float(i), 0.0) for i in range(count + 1)}
    members = {f"b{i}": (f"n{i}", f"n{i + 1}", 1) for i in range(count)}
    mesh = fx.read(lambda: fx.meshes.frame(nodes, members), 2)
    springs = [fx.Spring(mesh, f"n{i}", "x", s, to=(mesh, f"n{i + 1}"),
                         law=lambda e, s: s * (e**3 - 4.5 * e**2 + 6 * e)) for i, s in enumerate(scales)]
    supports = [fx.pin(mesh, "n0"), *(fx.Support(mesh, f"n{i}", "y") for i in range(1, count + 1))]
    bars = fx.Bar(mesh, fx.Rectangle(1, 1), fx.Elastic(1e-9))
    load, monitor = fx.PointForce(mesh, f"n{count}", (1.0, 0.0)), fx.Monitor(mesh, f"n{count}", "x")
    return fx.Scene([bars], supports, [load], monitor, joints=springs)


@pytest.mark.parametrize("times", [pytest.param(t, marks=SLOW) for t in (None, 1 / 8, 1 / 3, 3.0, 8.0)])
def test_springs_that_are_almost_equal_snap_one_after_the_other(times):
    """Behind a limit point others are as near as 0.013: the path goes through all, the load turning at each."""
    scales = [1.0, 1.0001, 1.0002, 1.0003]
    record = fx.trace(fx.Case(springs_in_series(scales), fx.ArcLength(times and 0.01 * times), fx.Until(load=3.5)))
    assert [p.kind for p in record.critical_points] == 8 * ["limit"]
    exact = [x * s for s in scales for x in (2.5, 2.0)]
    assert [p.load for p in record.critical_points] == pytest.approx(exact, rel=1e-8)


def is_multiple_point_of_four(found, most):
    assert found.point.load == pytest.approx(2.5, rel=1e-8)
    assert found.point.deflection == pytest.approx(4.0, rel=1e-5)
    assert found.point.multiplicity == 4
    assert found.factorisations <= most


@pytest.mark.parametrize("count", [2, *(pytest.param(n, marks=SLOW) for n in (3, 4, 5))])
@pytest.mark.slow
def test_springs_that_are_equal(count):
    """A path ends at a multiple point and says so, or finds all modes there, in one point or more at the same load."""
    path = fx.Path(springs_in_series(count * [1.0]), until=fx.Until(load=3.5))
    points, ended = [], ""
    try:
        for state in path:
            points += state.critical
    except fx.PathFailure as failure:
        ended = str(failure)
    assert not ended or re.search(r"[2-5] modes .* fx.critical\(path, state, kind", ended)
    for load in (2.5, 2.0):
        modes = [p.multiplicity for p in points if p.load == pytest.approx(load, rel=1e-7)]
        assert sum(modes) in (0, count)
    assert {round(p.load, 6) for p in points} <= {2.5, 2.0}


@pytest.mark.parametrize("load", [2.2, 2.3, 2.4, 2.45, 2.49])
@pytest.mark.slow(quick=1)
def test_multiple_point_of_equal_springs_directly_from_farther_off(load):
    record = fx.trace(fx.Case(springs_in_series(4 * [1.0]), until=fx.Until(load=load)))
    for asked, most in ((1, 20), (4, 7)):
        found = fx.critical(record.path, record.states[-1], kind="limit", multiplicity=asked)
        is_multiple_point_of_four(found, most)
