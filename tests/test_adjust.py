"""Overlap at the start that is taken for an imperfection: parts touch where they are."""

from __future__ import annotations

import numpy as np
import pytest
from test_obstacle_contact import bar
from test_pair_contact import stacked
from test_surface_contact import two_plates

import sheetfx as fx


def on_a_plane(distance, adjust, wave=0.0):
    """A beam under its weight on a plane at distance 10 below its axis, which waves by some of it."""
    mesh, beam = bar(2)
    if wave:
        mesh = fx.imperfect(mesh, lambda x: np.column_stack((0 * x[:, 0], wave * np.sin(np.pi * x[:, 0] / 250.0))))
        beam = fx.Beam(mesh, beam.section, beam.material)
    touch = fx.ObstacleContact(mesh, None, fx.RigidPlane((0.0, -10.0), (0.0, 1.0)), distance=distance, adjust=adjust)
    return fx.Scene([beam], [fx.clamp(mesh, "start")], [fx.LineForce(beam, (0.0, -1e-3))],
                    fx.Monitor(mesh, "end", "y", -1.0), joints=[touch])


SCENES = {
    "obstacle": lambda overlap, adjust: on_a_plane(10.0 + overlap, adjust),
    "surface": lambda overlap, adjust: two_plates(distance=0.3 + overlap, adjust=adjust),
    "pairs": lambda overlap, adjust: stacked(True, gap=lambda x: np.full(len(x), -overlap), adjust=adjust),
}


def loads(scene):
    return [(s.load, s.deflection, s.contact_points) for s in fx.trace(
        fx.Case(scene, fx.LoadControl(0.5), fx.Until(steps=2))).states]


@pytest.mark.parametrize("kind", [
    pytest.param(kind, marks=[pytest.mark.slow] * (kind == "surface")) for kind in SCENES])
@pytest.mark.slow(quick=1)
def test_an_even_overlap_is_none(kind):
    """With it the path is that of parts that touch; without, or with less, it is refused.

    In the unloaded state rounding decides whether they touch.
    """
    assert loads(SCENES[kind](0.05, 0.06))[1:] == [pytest.approx(state) for state in loads(SCENES[kind](0.0, 0.0))[1:]]
    for adjust in (0.0, 0.04):
        with pytest.raises(ValueError, match="adjust= where it is an imperfection"):
            fx.Path(SCENES[kind](0.05, adjust))


def test_a_wave_that_cuts_the_plane_touches_where_it_is():
    """Crests stay off by what they are, troughs touch; nothing is pressed before the load is there."""
    scene = on_a_plane(10.0, 0.3, wave=0.25)
    record = fx.trace(fx.Case(scene, fx.LoadControl(1.0), fx.Until(steps=1)))
    touch, = scene.joints
    record.show(record.states[0])
    begun = record.pairs(touch)
    below = begun.position[:, 1] < 0
    assert begun.gap[below] == pytest.approx(0.0, abs=1e-9)
    assert begun.gap[~below] == pytest.approx(begun.position[~below, 1])
    assert not begun.pressure.any()
    record.show(record.states[1])
    assert record.pairs(touch).pressure.max() > 0.0
    assert record.pairs(touch).gap.min() > -1e-3
