"""Every trap, followed by the default method, gives all its critical points and no others."""

from __future__ import annotations

from dataclasses import replace

import pytest
from failure_map.traps import FAMILIES, TRAPS, Trap

import sheetfx as fx
from sheetfx.case import Case, trace

UNLESS_LONG = "punch", "slenderness", "contact"  # whose points lie too close together for long steps
SMALL = [t.name for t in TRAPS.values() if not t.slow and t.points and not t.name.startswith(UNLESS_LONG)]


def assert_points(trap: Trap, case: Case):
    found = [p for p in trace(case).critical_points if case.until.load is None or abs(p.load) < case.until.load]
    assert [p.kind for p in found] == [e.kind for e in trap.points]
    for point, expected in zip(found, trap.points, strict=True):
        assert point.load == pytest.approx(expected.load, rel=expected.tolerance)
        assert point.multiplicity == expected.multiplicity
        assert expected.name in (None, point.name)


def test_every_trap_has_a_name_of_its_own():
    assert len(TRAPS) == sum(map(len, FAMILIES))


@pytest.mark.parametrize("name", [pytest.param(t.name, marks=pytest.mark.slow) if t.slow else t.name
                                  for t in TRAPS.values()])
def test_all_critical_points_and_no_others_are_found(name):
    assert_points(TRAPS[name], TRAPS[name].case())


@pytest.mark.slow
@pytest.mark.parametrize("factor", [1 / 16, 1 / 4, 4, 16])
@pytest.mark.parametrize("name", SMALL)
def test_steps_of_any_length_find_the_same_points(name, factor):
    case = TRAPS[name].case()
    assert_points(TRAPS[name], replace(case, control=replace(case.control, step=factor * case.control.first)))


def test_a_part_that_floats_freely_is_named():
    """Of its own mesh, and as a loose piece of a mesh that is supported elsewhere."""
    nodes = {"base": (0.0, 0.0), "tip": (1.0, 0.0), "here": (0.0, 1.0), "there": (1.0, 1.0)}
    members = {"cantilever": ("base", "tip", 2), "lost": ("here", "there", 2)}
    both = fx.read(lambda: fx.meshes.frame(nodes, members), 2)
    single = [fx.read(lambda n=n: fx.meshes.frame({k: nodes[k] for k in members[n][:2]}, {n: members[n]}), 2)
              for n in members]
    for meshes in ([both], single):
        beams = [fx.Beam(m, fx.Rectangle(0.1, 0.1), fx.Elastic(1e4)) for m in meshes]
        scene = fx.Scene(beams, [fx.clamp(meshes[0], "base")], [fx.PointForce(meshes[0], "tip", (0.0, 1.0))],
                         fx.Monitor(meshes[0], "tip", "y"))
        with pytest.raises(ValueError, match="nothing supports the piece with 'lost', 'here', 'there'; add a support"):
            fx.Path(scene)
