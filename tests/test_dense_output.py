"""States within a step are interpolated so well that critical points cost few factorisations."""

from __future__ import annotations

from math import log2

import pytest
from helpers import cantilever, hinged_column, straight

import sheetfx as fx
from sheetfx.continuation.segment import Segment
from sheetfx.scenes import load_case

PER_POINT = 8  # factorisations beyond those of the steps


def bent_in_space() -> fx.Scene:
    """A cantilever that bends about both axes and twists."""
    mesh = straight(4, dimension=3)
    return cantilever(mesh, lambda beam: [fx.PointForce(mesh, "tip", (0.0, 6.0, 4.0)),
                                          fx.Moment(mesh, "tip", (3.0, 0.0, 2.0))])


def with_partly_fixed_rotations() -> fx.Scene:
    """A column in space, one rotation of whose base is fixed, that bends out of its plane."""
    scene = hinged_column(3, 0.02)
    mesh = scene.parts[0].mesh
    return fx.Scene(scene.parts, scene.supports, [fx.PointForce(mesh, "middle", (0.0, 3.0, 2.0)),
                                                  fx.Moment(mesh, "tip", (0.5, 0.2, 0.3))], scene.monitor)


def errors(path: fx.Path, before: fx.State, length: float) -> tuple[float, float]:
    """Of the middle of a step, over its length: of the dense output, and of the cubic off the path."""
    tracer = path.tracer
    tracer.back_to(before)
    after = tracer.attempt(length)
    segment = Segment(tracer, before, after)
    dense, cubic = segment.dense.at(length / 2, segment.states), segment.interpolated(0.0, length, length / 2)
    state, way = segment[length / 2], tracer.distance(*after.direction)
    wrong, off = ((load - state.load_increment, x - state.increment) for load, x in (dense, cubic))
    along = tracer.inner(off, after.direction) / way
    return tracer.distance(*wrong) / way, (tracer.inner(off, off) - along**2) ** 0.5 / way


@pytest.mark.parametrize(("scene", "control", "length"), [
    (bent_in_space, fx.LoadControl(0.1), 0.1), (bent_in_space, fx.ArcLength(0.02), 0.02),
    (bent_in_space, fx.ArcLength(0.02, shape="spherical"), 0.02),
    (with_partly_fixed_rotations, fx.ArcLength(0.02), 0.16)])
def test_interpolation_is_of_fourth_order(scene, control, length):
    """Half the step has a sixteenth of the error, an eighth of it over the length; a wrong rate leaves a quarter."""
    path = fx.Path(scene(), control, fx.Until(steps=2))
    *_, before = path
    for whole, half in zip(errors(path, before, length), errors(path, before, length / 2), strict=True):
        assert log2(whole / half) > 2.6


@pytest.mark.parametrize(("name", "points"), [
    ("von-mises-truss", 6), ("column", 3), ("sinusoidal-arch", 4), ("roorda-frame", 1)])
def test_critical_points_cost_few_factorisations(name, points):
    """A handful of factorisations each, the examination of steps between them included."""
    record = fx.trace(load_case(name)())
    spent = record.path.tracer.total_factorisations - sum(s.factorisations for s in record.states)
    assert len(record.critical_points) == points
    assert spent <= PER_POINT * points
