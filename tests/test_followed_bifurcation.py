"""Derivatives of loads of bifurcations with contact, plasticity or forces without a potential."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from math import pi

import numpy as np
import pytest
from failure_map.traps import TRAPS
from helpers import on_two_processes
from test_pair_contact import arch_above_a_beam, line, shallow_arch
from test_plastic_paths import column

import sheetfx as fx
from sheetfx import meshes
from sheetfx.continuation.state import CriticalPoint
from sheetfx.critical.bifurcation_gradient import NoDerivative
from sheetfx.critical.changed import Change
from sheetfx.critical.numbers import numbers
from sheetfx.record import Record

SLOW = pytest.mark.slow
STEP = 1e-3  # of a number, over which loads of whole paths are compared



def first(record: Record) -> CriticalPoint:
    return next(p for p in record.critical_points if p.kind == "bifurcation")


def elasticities(record: Record, names: Sequence[str]) -> list[float]:
    """Relative changes of the first bifurcation's load by those of numbers of the scene."""
    point, known = first(record), {n.name: n for n in numbers(record.case.scene)}
    changes = [Change(known[name].scene, known[name].value) for name in names]
    found = record.load_gradient(point).derivatives(changes)
    return [float(np.mean(one)) * change.at / point.load for one, change in zip(found, changes, strict=True)]


@pytest.mark.parametrize(("name", "rel"), [("pflueger-hinged", 1e-4), ("partly-following", 1e-3),
                                           ("whole-ring-turning", 1e-4)])
def test_forces_without_a_potential(name, rel):
    """Loads of thin columns and rings go with the modulus, the width and the third power of the depth.

    Rounding of the tangent decides: an eigenvalue of the column under a force half of which follows is nearly double.
    """
    record = fx.trace(TRAPS[name].case())
    names = "Elastic.modulus", "Rectangle.width", "Rectangle.depth", "Elastic.poisson"
    assert elasticities(record, names) == pytest.approx([1.0, 1.0, 3.0, 0.0], rel=rel, abs=rel)


def arch_on_a_beam(enforcement: str) -> fx.Case:
    """A shallow arch that comes to rest on a beam before it sways."""
    arch, below = shallow_arch(20, 0.0), line(10, (100.0, 0.0), (900.0, 0.0))
    beams = [fx.Beam(mesh, fx.Rectangle(20.0, depth), fx.Elastic(7e4)) for mesh, depth in ((arch, 10.0), (below, 2.0))]
    touch = fx.PairContact(arch, ["part 9", "part 10"], (below, None), toward=(0.0, -1.0), reach=50.0, gap=3.0,
                           enforcement=enforcement)
    supports = [fx.pin(arch, "0"), fx.pin(arch, "20"), fx.clamp(below, "start"), fx.clamp(below, "end")]
    scene = fx.Scene(beams, supports, [fx.PointForce(arch, "10", (0.0, -1.0))], fx.Monitor(arch, "10", "y", -1.0),
                     joints=[touch])
    return fx.Case(scene, until=fx.Until(deflection=8.0))


@pytest.mark.parametrize("enforcement", [
    "condensed", pytest.param("uzawa", marks=SLOW), pytest.param("penalty", marks=SLOW)])
def test_contact(enforcement):
    """Against differences of whole paths; the gap's by steps so short that nothing lets go."""
    case = arch_on_a_beam(enforcement)
    names = "Rectangle.depth of part 1", "Rectangle.depth of part 2", "PairContact.gap"
    known = {n.name: n for n in numbers(case.scene)}
    record = fx.trace(case)
    assert max(s.contact_points for s in record.states if s.step < first(record).step) > 0
    for name, found in zip(names, elasticities(record, names), strict=True):
        more, less = (first(fx.trace(replace(case, scene=known[name].scene(known[name].value * (1 + way))))).load
                      for way in (STEP, -STEP))
        assert found == pytest.approx((more - less) / (2 * STEP * first(record).load), rel=1e-3)


def yielding(**options) -> fx.Case:
    return fx.Case(column(50e3, **options)[0], fx.LoadControl(step=0.1, target=1.2))


def test_a_column_that_yields():
    """Engesser's load goes with the tangent modulus E H / (E + H) and the third power of the depth."""
    record = fx.trace(yielding(depth=0.02, shear_rigidity=30.0, points=20))
    names = "Plastic.modulus", "Plastic.hardening", "Rectangle.width", "Rectangle.depth", "Plastic.yield_stress"
    assert elasticities(record, names) == pytest.approx([0.2, 0.8, 1.0, 3.0, 0.0], abs=1e-3)


def test_an_imperfection_has_no_derivative():
    record = fx.trace(yielding())

    def bowed(size):
        return fx.imperfect(record.case.scene, lambda x: np.column_stack(
            (0 * x[:, 0], size * np.sin(pi * x[:, 0]), 0 * x[:, 0])))

    with pytest.raises(NoDerivative, match="the number makes the structure imperfect"):
        record.gradient(first(record), bowed, 0.0, step=1e-5)


def test_a_stiffness_that_jumps_past_zero_has_none():
    """A portal is unstable as soon as points begin to flow: its load is that of the beginning."""
    nodes = {"A": (0, 0), "B": (0, 1000), "C": (1000, 1000), "D": (2000, 1000), "F": (2000, 0)}
    mesh = fx.read(lambda: meshes.frame(nodes, {a + b: (a, b, 6) for a, b in ("AB", "BC", "CD", "DF")}), 2)
    metal = fx.Plastic(200e3, 0.3, yield_stress=200.0, hardening=1e3)
    beam = fx.Beam(mesh, fx.Rectangle(20.0, 60.0, points=8), metal)
    scene = fx.Scene([beam], [fx.pin(mesh, "A"), fx.pin(mesh, "F")], [fx.PointForce(mesh, "C", (0.0, -1.0))],
                     fx.Monitor(mesh, "C", "y", -1.0))
    record = fx.trace(fx.Case(scene, until=fx.Until(deflection=45.0)))
    with pytest.raises(NoDerivative, match="jumps past zero there, as where points begin to flow"):
        record.load_gradient(first(record))


def test_a_limit_at_a_corner_is_refused():
    """Where the arch meets the beam the load turns at once: -6.6 N/mm of the gap by whole paths, 0 by its tangent."""
    record = fx.trace(fx.Case(arch_above_a_beam("condensed")[0], until=fx.Until(deflection=30.0)))
    (minimum,) = (p for p in record.critical_points if p.name == "minimum")
    with pytest.raises(ValueError, match="is a corner of the path, as where something begins to touch"):
        record.load_gradient(minimum)


TWO = """
from mpi4py import MPI
import sheetfx as fx
from test_followed_bifurcation import elasticities, yielding
found = elasticities(fx.trace(yielding()), ["Plastic.hardening", "Rectangle.depth"])
if MPI.COMM_WORLD.rank == 0:
    print(*found)
"""


def test_two_processes_find_the_same():
    (line,) = on_two_processes(TWO)
    assert list(map(float, line.split())) == pytest.approx(
        elasticities(fx.trace(yielding()), ["Plastic.hardening", "Rectangle.depth"]), rel=1e-4)
