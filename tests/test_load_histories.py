"""Load histories to their end: paths that fall where they have lost their stability, and go on from there."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import sheetfx as fx

RISE, STIFF = 0.1, 1e5


def toggle(load=None):
    """Two bars of half span 1 and rise 0.1, EA = 1e5; pressed down at their apex."""
    mesh = fx.read(lambda: fx.meshes.frame({"a": (-1, 0), "o": (0, RISE), "b": (1, 0)},
                                           {"ao": ("a", "o", 1), "ob": ("o", "b", 1)}), 2)
    bars = fx.Bar(mesh, fx.Rectangle(1.0, 1.0), fx.Elastic(STIFF))
    force = load(mesh) if load else fx.PointForce(mesh, "o", (0.0, -200.0))
    return fx.Scene([bars], [fx.pin(mesh, "a"), fx.pin(mesh, "b"), fx.Support(mesh, "o", "x")], [force],
                    fx.Monitor(mesh, "o", "y", -1))


def force(w):
    """Force of the toggle at a deflection, and the largest one."""
    height, long = RISE - w, np.hypot(1.0, RISE - w)
    return 2 * STIFF * (np.hypot(1.0, RISE) - long) / np.hypot(1.0, RISE) * height / long


LIMIT = max(force(w) for w in np.linspace(0.0, 0.1, 100001))


def snapped(record):
    return [(point.load, state.step) for state in record.states for point in state.critical if point.title == "snap"]


@pytest.mark.parametrize("control", [fx.LoadControl(), fx.ArcLength()], ids=lambda c: type(c).__name__)
@pytest.mark.slow(quick=1)
def test_toggle_goes_through(control):
    record = fx.trace(fx.Case(toggle(), control, fx.Until(load=200.0), snaps=True))
    ((load, step),) = snapped(record)
    assert load == pytest.approx(LIMIT, rel=1e-6)
    assert [state.step for state in record.states] == list(range(len(record.states)))
    assert all(state.unstable_modes == 0 for state in record.states if state.step != step)
    for state in record.states:
        assert force(state.deflection) == pytest.approx(state.load, rel=1e-5, abs=1e-5)
    assert record.states[-1].load == pytest.approx(200.0, rel=1e-5) and record.states[-1].deflection > 2 * RISE
    (fall,) = record.path.falls
    before, after = (state.deflection for state in (fall.before, fall.after))
    way = np.linspace(before, after, 200001)
    stored = np.trapezoid([force(w) for w in way], way)
    assert fall.energy_released == pytest.approx(load * (after - before) - stored, rel=1e-4)


def test_to_and_fro_is_a_loop():
    """Down to the full load, back to its opposite, and down again: it falls at plus and minus the limit load."""
    scene, start, found = toggle(), [], []
    for target in (1.0, -1.0, 1.0):
        record = fx.trace(fx.Case(scene, fx.LoadControl(target=target), snaps=True), start=start)
        assert record.path.message == f"load factor {target:g} reached"
        assert record.states[-1].factor == pytest.approx(target, rel=1e-5)
        found += [(fall.before.load, fall.after.deflection) for fall in record.path.falls]
        start = record.states[-1:]
    loads, ends = zip(*found, strict=True)
    assert loads == pytest.approx([LIMIT, -LIMIT, LIMIT], rel=1e-6)
    assert ends[0] == pytest.approx(ends[2], rel=1e-8) and ends[1] == pytest.approx(2 * RISE - ends[0], rel=1e-6)


@pytest.mark.slow
def test_moved_by_a_soft_bar_it_falls_at_a_held_displacement():
    """A soft bar in series: its end turns back where the slope of the toggle's force is minus its stiffness."""
    mesh = fx.read(lambda: fx.meshes.frame(
        {"a": (-1, 0), "o": (0, RISE), "b": (1, 0), "t": (0, RISE + 1)},
        {"ao": ("a", "o", 1), "ob": ("o", "b", 1), "ot": ("o", "t", 1)}), 2)
    soft = 400.0
    bars = [fx.Bar(mesh, fx.Rectangle(1.0, 1.0), fx.Elastic(STIFF), group=g) for g in ("ao", "ob")]
    bars.append(fx.Bar(mesh, fx.Rectangle(1.0, 1.0), fx.Elastic(soft), group="ot"))
    supports = [fx.pin(mesh, "a"), fx.pin(mesh, "b"), *(fx.Support(mesh, at, "x") for at in "ot")]
    scene = fx.Scene(bars, supports, [fx.PrescribedDisplacement(mesh, "t", "y", -0.4)],
                     fx.Monitor(mesh, "o", "y", -1))
    record = fx.trace(fx.Case(scene, fx.LoadControl(), snaps=True))
    ways = np.linspace(0.0, 0.25, 250001)
    moved = ways + np.array([force(w) for w in ways]) / soft
    rising = np.flatnonzero(np.diff(moved) < 0)[0]
    (fall,) = record.path.falls
    assert fall.before.factor * 0.4 == pytest.approx(moved[rising], rel=1e-6)
    assert record.states[-1].factor == pytest.approx(1.0, rel=1e-5) and record.states[-1].deflection > 2 * RISE


@pytest.mark.slow
def test_roof_falls_as_by_hand():
    """The hinged roof of 12.7 mm, beside `fx.snaps` along its whole path."""
    from sheetfx.scenes import roof

    case = roof.case()
    whole = fx.trace(case)
    (first, *_) = fx.snaps(whole.path, whole.states)
    record = fx.trace(fx.Case(case.scene, fx.LoadControl(target=1.2 * first.before.factor), snaps=True))
    assert record.path.falls[0].before.load == pytest.approx(first.before.load, rel=1e-5)
    assert record.path.falls[0].after.deflection == pytest.approx(first.after.deflection, rel=1e-5)


def test_displacement_control_holds_the_displacement():
    """Without a turning point of the displacement it does not fall, where the load would."""
    record = fx.trace(fx.Case(toggle(), fx.DisplacementControl(), fx.Until(deflection=0.25), snaps=True))
    assert not record.path.falls and record.states[-1].deflection == pytest.approx(0.25, rel=1e-5)


@pytest.mark.slow
@pytest.mark.parametrize("cells", [4, 6])
def test_airbag_is_inflated_by_one_call(cells):
    """A square bag to 5000 Pa: 0.205 to 0.217 m (Contri and Schrefler 1988); 0.1986 on 4 x 4 cells, still coarse."""
    side = 0.42426
    mesh = fx.read(lambda: fx.meshes.rectangle((cells, cells), (side, side)), 3, 2)
    shell = fx.Shell(mesh, fx.Plate(0.0006), fx.Elastic(588e6, 0.4))
    supports = [fx.symmetry(mesh, "west", "x"), fx.symmetry(mesh, "south", "y"),
                *(fx.Support(mesh, at, "z") for at in ("east", "north"))]
    scene = fx.Scene([shell], supports, [fx.Pressure(shell, 5000.0)], fx.Monitor(mesh, "south-west", "z"))
    record = fx.trace(fx.Case(scene, fx.LoadControl(), fx.Until(steps=2000), snaps=True))
    assert record.path.message == "load factor 1 reached" and len(record.path.falls) > 3
    assert 0.197 < record.states[-1].deflection < 0.217


def test_energy_of_a_fall_is_dissipated():
    """The work of the load is what is stored and what the fall has set free."""
    record = fx.trace(fx.Case(toggle(), fx.LoadControl(), fx.Until(load=200.0), snaps=True))
    balance, (fall,) = record.balance(), record.path.falls
    assert balance.dissipated[-1] == pytest.approx(fall.energy_released, rel=1e-6) and not balance.broken
    assert balance.dissipated[fall.before.step] == 0.0 and balance.off < 1e-2


def column(force):
    mesh = fx.read(lambda: fx.meshes.frame({"a": (0, 0), "m": (0.5, 0), "b": (1, 0)},
                                           {"l": ("a", "m", 8), "r": ("m", "b", 8)}), 2)
    beam = fx.Beam(mesh, fx.Rectangle(0.01, 0.01), fx.Elastic(2.1e11))
    return fx.Scene([beam], [fx.Support(mesh, "a", "x y"), fx.Support(mesh, "b", "y")],
                    [fx.PointForce(mesh, "b", (-force, 0.0))], fx.Monitor(mesh, "m", "y"))


def test_column_falls_onto_its_branch_and_goes_on():
    """A perfect column beyond Euler's load, beside its branch; few steps follow the fall."""
    euler = np.pi**2 * 2.1e11 * 0.01**4 / 12
    record = fx.trace(fx.Case(column(1.2 * euler), fx.LoadControl(), snaps=True))
    assert len(record.path.falls) == 1 and len(record.states) < 15
    whole = fx.trace(fx.Case(column(1.2 * euler), fx.LoadControl()))
    (point,) = [p for p in whole.critical_points if p.kind == "bifurcation"]
    *_, last = fx.Path(column(1.2 * euler), fx.ArcLength(), fx.Until(load=1.2 * euler),
                       start=[whole.branches(point)[0].start])
    assert abs(record.states[-1].deflection) == pytest.approx(abs(last.deflection), rel=1e-6)


def test_stages_and_resumed_paths():
    """A load before the history takes its part of the limit; from any of its states the path ends where it did."""
    scene = toggle()
    mesh = scene.parts[0].mesh
    preloaded = replace(scene, stages=[fx.Stage([fx.PointForce(mesh, "o", (0.0, -10.0))])])
    record = fx.trace(fx.Case(preloaded, fx.LoadControl(), snaps=True))
    assert record.path.falls[0].before.load == pytest.approx(LIMIT - 10, rel=1e-6)
    record = fx.trace(fx.Case(scene, fx.LoadControl(), snaps=True))
    for number in range(1, len(record.states)):
        *_, last = fx.Path(scene, fx.LoadControl(), start=record.states[:number], snaps=True)
        assert last.deflection == pytest.approx(record.states[-1].deflection, rel=1e-9)


def test_a_fall_is_drawn_as_no_stable_way():
    from sheetfx.show.curves import path_knots

    record = fx.trace(fx.Case(toggle(), fx.LoadControl(), fx.Until(load=200.0), snaps=True))
    knots, unstable = path_knots(record.states)
    (place,) = np.flatnonzero(unstable)
    assert knots[place + 1, 0] == pytest.approx(record.path.falls[0].after.deflection)
