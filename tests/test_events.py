"""Events: test functions of a state whose crossing is pinpointed and named as limit points are."""

from __future__ import annotations

from dataclasses import replace

import pytest
from helpers import shallow_arch

import sheetfx as fx
from sheetfx.continuation.segment import Missed
from sheetfx.events.event import occurrences
from sheetfx.scenes import arch

UNTIL = fx.Until(deflection=15.0)


def traced(until=UNTIL, events=(), step=0.005):
    return fx.trace(fx.Case(shallow_arch(10), fx.ArcLength(step), until, events=events))


def test_path_ends_at_an_event():
    """Exactly there, and the same for other steps."""
    ends = [traced(fx.Until(lambda state: state.deflection - 7.5), step=step) for step in (0.002, 0.005, 0.02)]
    for record in ends:
        assert record.states[-1].deflection == pytest.approx(7.5, rel=1e-9)
        assert record.path.message == "event 'end' reached"
        assert [p.kind for p in record.critical_points] == ["event"], "the limit point lies behind it"
    assert [r.states[-1].load for r in ends] == pytest.approx([ends[0].states[-1].load] * 3, rel=1e-9)


@pytest.mark.parametrize("guarded", [True, False])
def test_a_bound_is_met_or_the_step_is_not_taken(monkeypatch, guarded):
    """Where states within it do not converge, as with contact; a control that takes steps as they are ends behind it.

    With contact a path used to end as far beyond its bound as its last step did, and said that it was reached.
    """
    path = fx.Path(shallow_arch(10), fx.ArcLength(0.02) if guarded else fx.ArcLength(0.02, turn=4.0))
    before, after = (replace(state, apart=False) for state, _ in zip(path, range(2), strict=False))
    bound, = fx.Until(deflection=after.deflection / 2).bounds
    monkeypatch.setattr(path.tracer, "attempt", lambda *_, **__: None)
    monkeypatch.setattr(path.tracer.system, "smooth", False)
    if guarded:
        with pytest.raises(Missed):
            occurrences(path.tracer, before, after, [bound])
    else:
        found, = occurrences(path.tracer, before, after, [bound])
        assert found.state is after


def test_events_stand_among_the_critical_points_in_order():
    """The load 140 is passed before and behind the limit of 159.1."""
    record = traced(fx.Until(deflection=20.0), [fx.Event("load 140", lambda state: state.load - 140.0)], 0.02)
    assert [p.title for p in record.critical_points] == ["load 140", "limit point (maximum)", "load 140"]
    loads = [p.load for p in record.critical_points if p.kind == "event"]
    assert loads == pytest.approx([140.0, 140.0], rel=1e-9)
    assert traced(fx.Until(deflection=20.0), step=0.02).states[-1].load == pytest.approx(record.states[-1].load, 1e-9)


def test_event_that_is_true_or_false():
    record = traced(UNTIL, [fx.Event("half", lambda state: state.deflection > 7.5)])
    (half,) = (p for p in record.critical_points if p.kind == "event")
    assert half.deflection == pytest.approx(7.5, rel=1e-5)


def test_event_with_contact():
    """The punched arch touches at its crown from the start; the contact splits into two later."""
    case = arch.case(elements=40, ratio=1.0, to=9.0)
    record = fx.trace(fx.Case(case.scene, case.control, case.until,
                              events=[fx.Event("spread", lambda state: state.contact_points - 9.5)]))
    (point,) = (p for p in record.critical_points if p.name == "spread")
    assert 0 < point.deflection < 9.0


def test_event_that_counts():
    """Its value passes zero without coming near to it."""
    record = traced(UNTIL, [fx.Event("half", lambda state: 0.5 if state.deflection > 7.5 else -0.5)])
    (half,) = (p for p in record.critical_points if p.kind == "event")
    assert half.deflection == pytest.approx(7.5, rel=1e-5)


def without_states(monkeypatch, hidden):
    """A path with tangents that waver, of which steps find no state that is `hidden`, given the one they start from."""
    path = fx.Path(shallow_arch(10), fx.ArcLength(0.01), UNTIL, events=[HALF, HALVED])
    path.tracer.state = replace(path.tracer.state, apart=False)
    attempt = path.tracer._attempted

    def attempted(*arguments, **named):
        start, found = path.tracer.state, attempt(*arguments, **named)
        if found is not None and hidden(start, found):
            path.tracer.back_to(start)
            return None
        return found

    monkeypatch.setattr(path.tracer, "_attempted", attempted)
    monkeypatch.setattr(path.tracer.system, "smooth", False)
    return path


HALF = fx.Event("half", lambda state: state.deflection > 7.5)
HALVED = fx.Event("halved", lambda state: state.deflection - 7.5)


def test_event_is_found_by_shorter_steps(monkeypatch):
    """Where a long step finds no states in between, and used to be taken to hold the event at its end."""
    path = without_states(monkeypatch, lambda start, found: found.deflection - start.deflection > 0.5 and
                          6.0 < found.deflection < 8.5)
    found = {p.name: p for state in path for p in state.critical if p.kind == "event"}
    assert {name: p.deflection for name, p in found.items()} == pytest.approx({"half": 7.5, "halved": 7.5}, rel=1e-5)
    assert not any(p.spread for p in found.values())


@pytest.mark.parametrize("width", [0.05, 2.0])
def test_event_where_no_state_is(monkeypatch, width):
    """A path that jumps goes on, and the event is told to lie between the states on both sides of the jump."""
    low, high = 7.5 - width / 2, 7.5 + width / 2
    path = without_states(monkeypatch, lambda start, found: low < found.deflection < high)
    states = list(path)
    found = {p.name: p for state in states for p in state.critical if p.kind == "event"}
    assert states[-1].deflection == pytest.approx(15.0, rel=1e-9), path.message
    for point in found.values():
        assert point.spread and high <= point.deflection < high + width
        assert point.title == f"{point.name} (between the loads {point.spread[0]:.8g} and {point.spread[1]:.8g})"


def test_resumed_path_knows_its_events():
    case = fx.Case(shallow_arch(10), fx.ArcLength(0.005), fx.Until(lambda state: state.deflection - 7.5))
    whole = fx.trace(case).states
    assert fx.trace(case, start=whole[:4]).states[-1].deflection == pytest.approx(7.5, rel=1e-9)
    assert len(fx.trace(case, start=whole).states) == len(whole), "a path that has ended has"
