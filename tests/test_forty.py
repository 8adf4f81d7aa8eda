"""Structures that nobody here had tried: nothing is missed, and nothing invented."""

from __future__ import annotations

from dataclasses import replace

import pytest
from forty import STRUCTURES

import sheetfx as fx

LONG = "plate-on-foundation", "plate-sheared", "whole-roof"


@pytest.mark.parametrize("name", [
    pytest.param(name, marks=[pytest.mark.slow] * (name in LONG))
    for name, structure in STRUCTURES.items() if structure.loads])
@pytest.mark.slow(quick=8)
def test_first_critical_loads(name):
    """Those that a closed form or a publication has, by default steps."""
    structure = STRUCTURES[name]
    found = [point.load for point in fx.trace(structure.case()).critical_points]
    assert found[:len(structure.loads)] == pytest.approx(structure.loads, rel=structure.error), structure.source


@pytest.mark.slow
@pytest.mark.parametrize("name", STRUCTURES)
def test_short_steps_find_the_same(name):
    """Kinds, multiplicities, names and loads of all points with a first step of an eighth."""
    case = STRUCTURES[name].case()
    first = fx.Path(case.scene, case.control).tracer.first
    shorter = replace(case, control=replace(case.control, step=first / 8))
    usual, short = (fx.trace(c).critical_points for c in (case, shorter))
    assert [(p.kind, p.multiplicity, p.name) for p in usual] == [(p.kind, p.multiplicity, p.name) for p in short]
    assert [p.load for p in usual] == pytest.approx([p.load for p in short], rel=1e-6)
