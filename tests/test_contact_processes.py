"""Contact and joints along lines on several processes: the path of one process, state by state."""

from __future__ import annotations

import json
from dataclasses import replace

import pytest
from helpers import on_two_processes
from test_contact_by_steps import node_on_a_rough_floor
from test_interface import bar, panel
from test_obstacle_contact import pressed_by_circle
from test_pair_contact import sliding_tip
from test_surface_contact import strips_case

import sheetfx as fx
from sheetfx.mesh.whole import whole
from sheetfx.scenes import dome


def joined():
    """Two panels of other cells, welded along an edge, and a bar that is linked under both."""
    one, other, beam = panel((2, 2)), panel((3, 3), (1.0, 0.0, 0.0)), bar((0.2, 0.5, -0.1), (1.8, 0.5, -0.1), 3)
    parts = [fx.Shell(mesh, fx.Plate(0.05), fx.Elastic(1e4, 0.3)) for mesh in (one, other)]
    parts.append(fx.Beam(beam, fx.Rectangle(0.1, 0.1), fx.Elastic(1e4, 0.0), up=(0.0, 0.0, 1.0)))
    joints = [fx.weld(one, "east", (other, "west")),
              *(fx.link(mesh, fx.Stretch((begin, 0.5, 0.0), end=(begin + 0.6, 0.5, 0.0)), (beam, None), 0.2)
                for mesh, begin in ((one, 0.3), (other, 1.1)))]
    scene = fx.Scene(parts, [fx.clamp(one, "west")], [fx.PointForce(other, "north-east", (0.0, 0.0, 0.5))],
                     fx.Monitor(other, "south-east", "z"), joints=joints)
    return fx.Case(scene, fx.LoadControl(step=0.5))


def steps(case, count):
    return replace(case, until=fx.Until(steps=count), pictures=(), quantities=lambda record: {})


CASES = {
    "welds and links": joined,
    "pairs that slide": lambda: steps(sliding_tip(0.2), 12),
    "augmented pairs": lambda: steps(sliding_tip(0.2, enforcement="uzawa"), 3),
    "penalty": lambda: steps(sliding_tip(0.0, enforcement="penalty"), 6),
    "an obstacle that travels": lambda: steps(pressed_by_circle(0.2), 6),
    "limit points of friction": lambda: fx.Case(node_on_a_rough_floor(), fx.ArcLength(), fx.Until(deflection=0.035)),
    "surfaces": lambda: steps(strips_case(4), 14),
    "dome": lambda: steps(dome.case(model="contact", divisions=2, friction=0.2), 6),
}


BESIDE = "augmented pairs", "pairs that slide"  # rounding decides whether a residual is within the tolerance, or which
# way a pair that has just touched is taken to slip: about one factorisation
LONG = "surfaces", "dome", "welds and links", "penalty", "pairs that slide"


def followed(name):
    """Loads, deflections, points in contact, critical points and factorisations of all states of a path."""
    record = fx.trace(CASES[name]())
    return [[[s.load, s.deflection, *(p.load for p in s.critical)],
             [s.contact_points, len(s.critical)], s.factorisations] for s in record.states]


@pytest.mark.parametrize("name", [pytest.param(name, marks=[pytest.mark.slow] * (name in LONG)) for name in CASES])
@pytest.mark.slow(quick=1)
def test_two_processes_follow_the_path_of_one(name):
    lines = on_two_processes(f"""
import json
from mpi4py import MPI
from test_contact_processes import followed
found = followed({name!r})
if MPI.COMM_WORLD.rank == 0:
    print(json.dumps(found))
""")
    found, alone = json.loads(lines[-1]), followed(name)
    assert [counts for _, counts, _ in found] == [counts for _, counts, _ in alone]
    for (numbers, _, factors), (others, _, factors_alone) in zip(found, alone, strict=True):
        assert numbers == pytest.approx(others, rel=1e-8, abs=1e-12)
        assert abs(factors - factors_alone) <= (name in BESIDE)


@pytest.mark.parametrize("order", [1, 2, 3])
def test_whole_meshes_are_those_of_one_process(order):
    """Names of all kinds, places and nodes, on two processes and on one."""
    lines = on_two_processes(f"""
import json
from mpi4py import MPI
from test_contact_processes import described
found = described({order})
if MPI.COMM_WORLD.rank == 0:
    print(json.dumps(found))
""")
    assert json.loads(lines[-1]) == described(order)


def described(order):
    mesh = whole(fx.read(lambda: fx.meshes.rectangle((3, 5), (1.0, 2.0)), 3, order))
    named = [{name: numbers.tolist() for name, numbers in kind.items()} for kind in (
        mesh.cells, mesh.edges, mesh.points)]
    return [*named, mesh.domain.geometry.x.tolist(), mesh.domain.topology.original_cell_index.tolist()]
