"""Contact between deformable parts at pairs of points: patch tests, tangents, friction, sliding, history."""

from __future__ import annotations

import numpy as np
import pytest
from helpers import distance, move_at_random, tangents

import sheetfx as fx
from sheetfx.discrete.discretisation import Discretisation
from sheetfx.discrete.pair_work import pairs_of

SECTION = {"section": fx.Rectangle(0.1, 0.1), "material": fx.Elastic(1.2e6, 0.0)}


def line(cells, start, end, dimension=2, name="bar"):
    nodes = {"start": start, "end": end}
    return fx.read(lambda: fx.meshes.frame(nodes, {name: ("start", "end", cells)}), dimension)


def works(path_or_discretisation):
    discretisation = getattr(path_or_discretisation, "discretisation", path_or_discretisation)
    return pairs_of(discretisation.system.contributions)


def stacked(moving, enforcement="penalty", dimension=2, **how):
    """A beam on another one of other cells, which lies on an elastic foundation; the upper one is loaded evenly."""
    upper, lower = (line(n, (0.0, y, 0.0)[:3], (1.0, y, 0.0)[:3], dimension) for n, y in ((3, 0.1), (5, 0.0)))
    beams = [fx.Beam(m, **SECTION) for m in (upper, lower)]
    contact = fx.PairContact(upper, "bar", (lower, None), reach=0.1, moving=moving, enforcement=enforcement, **how)
    foundation = fx.Foundation(beams[1], (0.0, 50.0, 0.0)[:dimension])
    down = (0.0, -1.0, 0.0)[:dimension]
    held = {2: ("x rz", "x"), 3: ("x z rx ry rz", "x z rx ry")}[dimension]
    return fx.Scene(beams, [fx.Support(upper, "start", held[0]), fx.Support(lower, "start", held[1])],
                    [fx.LineForce(beams[0], down)], fx.Monitor(upper, "end", "y", -1.0), joints=[contact, foundation])


@pytest.mark.parametrize("moving", [False, True])
def test_constant_pressure_passes(moving):
    record = fx.trace(fx.Case(stacked(moving), fx.LoadControl(1.0, fixed=True)))
    work, = works(record.path)
    state = work.evaluate()
    assert np.abs(state.pressure - 1.0).max() < 1e-9  # of a stiffness of 3e6 times rounding
    assert record.states[-1].deflection == pytest.approx(1 / 50 + 1 / work.pairs.parameters[0], rel=1e-9)


@pytest.mark.parametrize("dimension, moving, friction", [
    (2, True, 1.3), (3, True, 1.3), pytest.param(2, False, 1.3, marks=pytest.mark.slow),
    pytest.param(3, False, 1.3, marks=pytest.mark.slow), pytest.param(3, True, 0.0, marks=pytest.mark.slow)])
def test_tangent_is_the_derivative(dimension, moving, friction):
    """Far from equilibrium, partners in other cells than at first; with friction not symmetric."""
    scene = stacked(moving, dimension=dimension, friction=friction, stiffness=1e3, tangential=1e3, gap=0.05)
    discretisation = Discretisation(scene, mixed_points=False)
    x = move_at_random(discretisation, size=0.1)
    work, = works(discretisation)
    assert set(work.evaluate().status) == ({"open", "slip", "stick"} if friction else {"open", "slip"})
    with discretisation.system.additive_increments():
        assembled, differences = tangents(discretisation.system, x, 1e-5)
    assert distance(assembled, differences) < 1e-7
    if friction:
        assert distance(assembled.T, differences) > 1e-4
