"""Branches of corners, where pairs that open together need not."""

import json
from types import SimpleNamespace

import numpy as np
import pytest
from helpers import on_two_processes
from test_pair_contact import SECTION, line

import sheetfx as fx
from sheetfx.continuation.corner import _unloads
from sheetfx.critical.branches import NoBranch

COUNT = 3


def propped() -> fx.Case:
    """Clamped columns side by side, each pressed against a prop that lets go at four times what it bears alone."""
    parts, supports, props, presses, loads = [], [], [], [], []
    for i in range(COUNT):
        column, wall = line(4, (0.0, i), (1.0, i)), line(2, (0.9, i), (1.1, i), name="wall")
        parts += [fx.Beam(mesh, **SECTION) for mesh in (column, wall)]
        supports += [fx.clamp(column, "start"), fx.clamp(wall, "start"), fx.clamp(wall, "end")]
        props.append(fx.PairContact(column, "end", (wall, None), moving=False, toward=(0.0, -1.0)))
        presses.append(fx.PointForce(column, "end", (0.0, -1.0)))
        loads.append(fx.PointForce(column, "end", (-1.0, 0.01)))
    scene = fx.Scene(parts, supports, loads, fx.Monitor(parts[0].mesh, "end", "y"), joints=props,
                     stages=[fx.Stage(presses)])
    return fx.Case(scene, until=fx.Until(deflection=0.01))


@pytest.fixture(scope="module")
def columns():
    return fx.trace(propped())


def sets_of_branches(record) -> list[list[bool]]:
    """For each branch of its corner which props let go."""
    corner, = (p for p in record.critical_points if p.name == "corner")
    return [(branch.direction > 0).tolist() for branch in record.branches(corner)]


def deflections(record, state) -> np.ndarray:
    record.show(state)
    return np.array([record.displacement("end", part.mesh)[1] for part in record.case.scene.parts[::2]])


@pytest.mark.slow
def test_every_set_of_props_may_let_go(columns):
    """Those that do leave columns of their own, which deflect as in closed form while the load falls.

    (Timoshenko and Gere 1961, section 1.11; 2 %: strains along and across the column are not in the formula.)
    """
    corner, = (p for p in columns.critical_points if p.name == "corner")
    found = columns.branches(corner)
    sets = [tuple(branch.direction > 0) for branch in found]
    assert len(set(sets)) == len(sets) == 2**COUNT - 2, "but none, which leads back, and all, the path's own"
    for branch, free in zip(found, map(np.array, sets), strict=True):
        path = fx.Path(columns.case.scene, columns.case.control, fx.Until(steps=branch.start.step + 3),
                       start=[branch.start])
        for state in [branch.start, *path]:
            k, moved = np.sqrt(state.factor / 10.0), deflections(columns, state)
            assert state.unstable_modes == free.sum() and state.factor < corner.load / COUNT
            assert np.abs(moved[~free]).max(initial=0.0) < 1e-6
            assert moved[free] == pytest.approx((0.01 - 1 / state.factor) * (np.tan(k) / k - 1), rel=0.02, abs=1e-5)


@pytest.mark.slow
def test_two_processes_find_the_same_sets(columns):
    lines = on_two_processes("""
import json
import sheetfx as fx
from mpi4py import MPI
from test_corner_branches import propped, sets_of_branches
found = sets_of_branches(fx.trace(propped()))
if MPI.COMM_WORLD.rank == 0:
    print(json.dumps(found))
""")
    assert json.loads(lines[-1]) == sets_of_branches(columns)


@pytest.mark.slow
def test_corners_whose_branches_are_not_known_say_so(columns, monkeypatch):
    corner, = (p for p in columns.critical_points if p.name == "corner")
    monkeypatch.setattr("sheetfx.critical.corner_branches.MOST", COUNT - 1)
    with pytest.raises(NoBranch, match=f"corner at load .*{COUNT} pairs open or close together"):
        columns.branches(corner)
    monkeypatch.setattr("sheetfx.critical.corner_branches.NEAR", 0.0)
    with pytest.raises(NoBranch, match="no pair opens or closes"):
        columns.branches(corner)


@pytest.mark.parametrize(("modes", "unloads"), [(0, True), (1, False)])
def test_what_loses_stability_as_it_turns_back_does_more_than_unload(modes, unloads):
    """Elastic unloading is stiffer than loading: M1 with friction turns back at 3691 N, where a pair opens."""
    history = SimpleNamespace(moved_since=lambda fields: False)
    tracer = SimpleNamespace(inner=lambda one, other: -1.0, system=SimpleNamespace(conservative=False, history=history))
    before, after = (SimpleNamespace(direction=None, fields={}, contact_points=3, unstable_modes=count)
                     for count in (0, modes))
    assert _unloads(tracer, before, after) is unloads
