"""Contact along a path: zones that touch, forces found within iterations, and the balance of work and energy."""

from dataclasses import replace

import numpy as np
import pytest

from sheetfx.case import trace
from sheetfx.continuation.control import LoadControl
from sheetfx.continuation.enforcement import Enforcement
from sheetfx.continuation.segment import Jump, Segment
from sheetfx.continuation.visited import VisitedStates
from sheetfx.continuation.work import require_work
from sheetfx.discrete.zones import Zones, samples
from sheetfx.path import PathFailure
from sheetfx.scenes.arch import case as arch_case

COARSE = {"elements": 80, "layer": 2.7}


@pytest.mark.parametrize(("edges", "length"), [
    ((0.31, 0.32), 0.01), ((-0.2, 0.4), 0.4), ((0.9, 1.3), 0.1), ((-1.0, 2.0), 1.0), ((1.5, 2.0), 0.0)])
def test_zones_lie_between_the_roots_of_the_gap(edges, length):
    """Length, and the integral of the square of (s - a)(s - b) between its roots, (b - a)^5 / 30, to rounding."""
    gap = (samples() - edges[0]) * (samples() - edges[1])
    zones = Zones.where_negative(np.array([np.ones_like(gap), gap]))
    assert set(zones.cells) <= {1}
    assert zones.weights.sum() == pytest.approx(length, abs=1e-12)
    if edges[0] > 0 and edges[1] < 1:
        square = zones.weights @ zones.interpolate(np.array([np.zeros_like(gap), gap])) ** 2
        assert square == pytest.approx(length**5 / 30, rel=1e-9)


def test_two_zones_in_a_cell():
    """A quartic gap that touches twice between four roots."""
    roots = 0.1, 0.2, 0.7, 0.75
    zones = Zones.where_negative(np.prod([samples() - r for r in roots], axis=0)[None])
    assert zones.weights.sum() == pytest.approx(0.15, abs=1e-12)
    inside = [(zones.reference > a) & (zones.reference < b) for a, b in (roots[:2], roots[2:])]
    assert (inside[0] | inside[1]).all()


def test_steps_with_contact_cost_what_steps_without_do():
    """Eliminated contact forces leave three or four iterations to a step, which begins with the factor of the last one.

    38 factors are made on this path, 46 where each step makes that of its start again.
    """
    record = trace(arch_case(**COARSE, to=20.0))
    assert record.path.tracer.total_factorisations < 43
    assert max(s.iterations for s in record.states) <= 6
    assert np.diff([s.unstable_modes for s in record.states]).sum() == 1, "stable before the maximum, unstable behind"


def test_forces_found_within_iterations_are_those_approached_through_layers(monkeypatch):
    """The same step by both ways: equal loads (tolerance of a step), a third of the factors."""
    found = [trace(arch_case(**COARSE, to=1.5))]
    monkeypatch.setattr(Enforcement, "approaches", lambda *_: [(False, [8.0, 4.0, 2.0, 1.0])])
    found.append(trace(arch_case(**COARSE, to=1.5)))
    assert found[0].states[-1].load == pytest.approx(found[1].states[-1].load, rel=1e-7)
    one, other = (record.path.tracer.total_factorisations for record in found)
    assert one < other / 3


def test_work_along_a_step_is_the_change_of_energy():
    """All steps behind the first of a path, and none whose last state is said to have another load."""
    record = trace(arch_case(**COARSE, to=20.0))
    tracer, states = record.path.tracer, record.states
    for earlier, before, after in zip(states, states[1:], states[2:], strict=False):
        require_work(Segment(tracer, before, after), earlier)
        wrong = after.load_increment + 0.5 * max(abs(before.load_increment), abs(after.load_increment))
        with pytest.raises(Jump, match="work"):
            require_work(Segment(tracer, before, replace(after, load_increment=wrong)), earlier)


def test_steps_back_onto_the_path_are_told():
    """A state between two others of the path lies on it, unless it touches or stands elsewhere, or is less stable."""
    record = trace(arch_case(**COARSE, to=20.0))
    states, tracer = record.states, record.path.tracer
    assert not any(VisitedStates(tracer, states[:n]).holds(states[n]) for n in range(1, len(states)))
    one, other = states[2:4]
    trail, back = VisitedStates(tracer, states[:5]), -states[4].increment - other.increment / 2
    between = replace(one, load=(one.load + other.load) / 2, deflection=(one.deflection + other.deflection) / 2,
                      increment=back)
    assert trail.holds(between)
    assert not trail.holds(replace(between, unstable_modes=7))
    assert not trail.holds(replace(between, load_rate=2 * max(one.load_rate, other.load_rate)))
    assert not trail.holds(replace(between, contact_points=max(one.contact_points, other.contact_points) + 1))
    assert not trail.holds(replace(between, load=between.load + 0.2 * abs(other.load - one.load)))
    aside = np.random.default_rng(0).normal(size=len(back)) * np.linalg.norm(other.increment) / len(back) ** 0.5
    assert not trail.holds(replace(between, increment=back + 2 * aside))


def test_prescribed_loads_do_not_jump_over_the_limit():
    """Beyond the maximum near 206 the arch would snap: a step that finds it there is refused."""
    case = arch_case(**COARSE)
    with pytest.raises(PathFailure) as failure:
        trace(replace(case, control=LoadControl(step=50.0, smallest=1e-2, target=300.0)))
    assert 190.0 < failure.value.record.states[-1].load < 206.5
    assert failure.value.record.states[-1].unstable_modes == 0
