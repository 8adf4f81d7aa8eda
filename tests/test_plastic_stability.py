"""Stability of structures that have yielded: history frozen in differences, columns and plates of the literature."""

from __future__ import annotations

from math import pi

import pytest
from helpers import follow
from test_plastic_paths import column, hinged_beam

import sheetfx as fx
from sheetfx.stability.critical import state_at
from sheetfx.stability.koiter import expansion

MODULUS, HARDENING = 200e3, 50e3  # of columns; the tangent modulus is a fifth of the elastic one


def test_linear_buckling_about_a_yielded_state():
    """At 0.9 of the tangent-modulus load the comparison solid buckles there; before it yields, at Euler's load.

    Differences about the state go both ways: were history not frozen, one of them would meet the elastic moduli.
    """
    scene, load = column(HARDENING, depth=0.01, shear_rigidity=30.0)
    record = follow(scene, fx.LoadControl(step=0.1, target=0.9, fixed=True))
    *_, elastic, _, yielded = record.states
    assert record.buckling(yielded, count=1)[0].load == pytest.approx(load, rel=2e-3)
    assert record.buckling(yielded, count=1, prebuckling=False)[0].load == pytest.approx(load, rel=2e-3)
    euler = record.buckling(elastic, count=1, prebuckling=False)[0].load
    assert euler == pytest.approx(load * (MODULUS + HARDENING) / HARDENING, rel=1e-2)


def test_koiters_coefficients_of_the_comparison_solid():
    """Those of the elastica, load / critical load = 1 + (pi w / L)^2 / 8, though it has yielded; 0.2 % compressed."""
    record = follow(column(HARDENING)[0], fx.LoadControl(step=0.1, target=1.2))
    (point,) = record.critical_points
    (mode,) = record.modes(point)
    beside = record.states[-2:]
    tracer = record.path.tracer
    state = state_at(tracer, *beside, point)
    unit = tracer.system.create_vector(mode)
    unit.scale(1 / tracer.distance(0.0, mode))
    found = expansion(tracer, unit, beside)
    bend = -found.quartic / (6 * found.stiffness) / found.size**2 / state.factor
    assert bend == pytest.approx(pi**2 / 8, rel=1e-2)
    assert abs(found.cubic) < 1e-6 * found.quartic * found.size


def test_a_yielded_structure_does_not_snap():
    record = follow(hinged_beam(kinematic=0.01), fx.DisplacementControl(step=1e-4), deflection=3e-4)
    with pytest.raises(ValueError, match="snap: parts whose law has history have no energy to descend; trace"):
        record.snap(record.states[-1])
    with pytest.raises(ValueError, match="a law with history does not say how much of the work it has taken"):
        record.energies()
