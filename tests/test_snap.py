"""Snaps land on the stable state that the traced path or branch has at the same load or displacement."""

import json
from dataclasses import replace
from itertools import pairwise
from math import inf, pi

import numpy as np
import pytest
from helpers import cantilever, energy_and_residual, follow, hinged_column, on_two_processes, straight
from scipy.optimize import brentq

import sheetfx as fx
from sheetfx.continuation.control import ArcLength, DisplacementControl, LoadControl
from sheetfx.continuation.state import State
from sheetfx.critical.branches import branches
from sheetfx.critical.fall import SnapFailure
from sheetfx.critical.snap import snap, snaps
from sheetfx.events.search import state_at
from sheetfx.model.loads import LineForce, PointForce, PrescribedDisplacement
from sheetfx.model.supports import Support
from sheetfx.path import Path, Until
from sheetfx.scenes import arch, cylinder_buckling, deep_arch, lee_frame, roof, star_dome, von_mises_truss
from sheetfx.show.snaps import falls_curve


def beyond_limit(record):
    """The first state beyond the first critical point."""
    return next(state for state in record.states if state.unstable_modes)


def reached(record, near, control, length):
    """The state of the path four steps, together of a length, from another."""
    tracer = Path(record.case.scene, control, start=[near]).tracer
    return [tracer.attempt(length / 4) for _ in range(4)][-1]


def falls(fall):
    """Whether the energy falls in every step, to rounding in the last ones."""
    changes = np.diff([step.energy for step in fall.history])
    return bool(np.all(changes <= 1e-9 * fall.energy_released) and np.all(changes[:-4] < 0))


def distance(one, other):
    """Largest difference of the fields of two states over the size of the other's displacement."""
    size = np.abs(next(iter(other.fields.values()))).max()
    return max(np.abs(values - other.fields[name]).max() for name, values in one.fields.items()) / size


def lost(record, fall):
    """Stored energy and potential of the monitored force that is less after a fall under this force than before."""
    stored = []
    for state in (fall.before, fall.after):
        record.show(state)
        stored.append(record.case.scene.symmetry_factor * energy_and_residual(record.path.discretisation)[0])
    return stored[0] - stored[1] + fall.before.load * (fall.after.deflection - fall.before.deflection)


@pytest.fixture(scope="module")
def thick_roof():
    case = roof.case(cells=2, to=26.0)
    return follow(case.scene, replace(case.control, largest=2.0), 26.0)


@pytest.fixture(scope="module")
def frame():
    case = lee_frame.case(elements=10, to=85.0)
    return follow(case.scene, case.control, 85.0)


@pytest.mark.parametrize("side", [1, -1])
def test_roof_under_held_load(thick_roof, side):
    """Forward to the branch behind the lower limit, backward to that before the upper one; energy by itself."""
    before = beyond_limit(thick_roof)
    fall = snap(thick_roof.path, before, side=side)
    near = thick_roof.states[-1] if side > 0 else thick_roof.states[1]
    expected = reached(thick_roof, near, LoadControl(target=inf), before.factor - near.factor)
    assert fall.after.unstable_modes == expected.unstable_modes == 0
    assert fall.after.factor == before.factor
    assert fall.after.deflection == pytest.approx(expected.deflection, rel=1e-6)
    assert distance(fall.after, expected) < 1e-6
    assert falls(fall)
    assert fall.energy_released == pytest.approx(lost(thick_roof, fall), rel=1e-6)


def test_fall_from_the_limit_point_itself(thick_roof):
    """At the pinpointed limit the structure can only fall forward: more energy than beyond it, by a cubic valley."""
    number, after = next((n, s) for n, s in enumerate(thick_roof.states) if s.critical)
    tracer = thick_roof.path.tracer
    limit = state_at(tracer, thick_roof.states[number - 1], after, after.critical[0])
    fall = snap(tracer, limit)
    near = thick_roof.states[-1]
    expected = reached(thick_roof, near, LoadControl(target=inf), limit.factor - near.factor)
    assert fall.after.deflection == pytest.approx(expected.deflection, rel=1e-6) and falls(fall)
    assert fall.energy_released > snap(tracer, beyond_limit(thick_roof)).energy_released
    with pytest.raises(SnapFailure, match="try the other side"):
        snap(tracer, limit, side=-1)


@pytest.mark.parametrize("side", [1, -1])
def test_frame_under_held_displacement(frame, side):
    """Behind the snap-back the load falls (rises) at the same deflection, to a state that only that holds."""
    turned = next(b for a, b in pairwise(frame.states) if b.deflection < a.deflection)
    fall = snap(frame.path, turned, "displacement", side)
    assert fall.after.deflection == pytest.approx(turned.deflection, abs=1e-9)
    assert np.sign(fall.after.factor - turned.factor) == -side
    beyond = [s for s in frame.states if side * (s.step - turned.step) > 0 and s.deflection < turned.deflection]
    near = min(beyond, key=lambda s: abs(s.load - fall.after.load))
    expected = reached(frame, near, DisplacementControl(), turned.deflection - near.deflection)
    assert fall.after.load == pytest.approx(expected.load, rel=1e-6)
    assert distance(fall.after, expected) < 1e-6
    assert falls(fall)


@pytest.mark.slow
def test_prescribed_motion_holds_the_displacement(frame):
    """The frame moved by a prescribed displacement, whose reaction is a multiplier, falls as under a held one."""
    scene = frame.case.scene
    motion = replace(scene, loads=[PrescribedDisplacement(scene.parts[0].mesh, "load", "y", -1.0)])
    path = Path(motion, frame.case.control, Until(steps=12))
    *_, before = path
    assert before.unstable_modes == 1
    turned = frame.states[before.step]
    assert turned.deflection == pytest.approx(before.deflection, rel=1e-8)
    held, fall = snap(frame.path, turned, "displacement"), snap(path, before)
    assert fall.after.load == pytest.approx(held.after.load, rel=1e-6)
    assert fall.energy_released == pytest.approx(held.energy_released, rel=1e-6)


def test_falls_of_a_test(frame, tmp_path):
    """One where the load is lost, one where the displacement is; each is written, and drawn with the path."""
    (by_load,), (by_displacement,) = (snaps(frame.path, frame.states, hold) for hold in ("load", "displacement"))
    assert by_load.before.load == pytest.approx(frame.critical_points[0].load, rel=1e-10)
    assert by_load.after.load == pytest.approx(by_load.before.load, rel=1e-12)
    turning = by_displacement.before.step
    assert by_displacement.before.deflection > frame.states[turning].deflection
    assert by_displacement.before.deflection > frame.states[turning + 1].deflection
    assert by_displacement.before.deflection > frame.states[turning - 1].deflection
    falls_curve(frame, tmp_path)
    report = json.loads((tmp_path / "fall1" / "snap.json").read_text())
    assert report["energy_released"] == by_load.energy_released
    assert State.load_from(tmp_path / "fall1" / "after.0.npz").deflection == by_load.after.deflection
    assert (tmp_path / "falls.png").stat().st_size > 10000


@pytest.mark.parametrize(("scene", "hold"), [
    (lambda: roof.case(cells=2, to=26.0), "load"), (lambda: lee_frame.case(elements=10, to=85.0), "displacement"),
    (lambda: von_mises_truss.case(0.3), "load")], ids=["roof", "Lee frame", "flat truss"])
@pytest.mark.slow(quick=1)
def test_falls_do_not_hang_on_the_lengths_of_steps(scene, hold):
    """They begin where what is held has its extreme, not at the next state."""
    found = []
    for largest in (2.0, 8.0):
        case = scene()
        record = fx.trace(replace(case, control=replace(case.control, largest=largest)))
        found.append([(fall.before.load, fall.after.deflection, fall.energy_released)
                      for fall in snaps(record.path, record.states, hold)])
    assert found[0]
    for one, other in zip(*found, strict=True):
        assert one == pytest.approx(other, rel=1e-7)


@pytest.mark.parametrize("side", [-1, 1])
@pytest.mark.slow(quick=1)
def test_arch_under_a_punch(side):
    """Contact layers store energy too: back to the path before the limit, forward until the arch is thrown over."""
    case = arch.case(elements=40, ratio=0.8, to=20.0)
    record = follow(case.scene, case.control, 20.0)
    before = record.states[-1]
    fall = snap(record.path, before, side=side)
    assert fall.after.unstable_modes == 0 and fall.after.contact_points > 0 and falls(fall)
    if side > 0:
        assert fall.after.deflection > 2 * record.critical_points[0].deflection
        return
    near = [s for s in record.states[:before.step] if s.load < before.load][-1]
    expected = reached(record, near, LoadControl(target=inf), before.factor - near.factor)
    assert fall.after.deflection == pytest.approx(expected.deflection, rel=1e-6)
    assert distance(fall.after, expected) < 1e-6


def test_path_goes_on_as_a_test_would(frame):
    """Load held at the first limit, displacement held behind the snap-back: the test goes on to larger ones."""
    unstable = beyond_limit(frame)
    forward = snap(frame.path, unstable)
    assert forward.after.deflection > frame.critical_points[-1].deflection
    more = Path(frame.case.scene, frame.case.control, Until(steps=forward.after.step + 3), start=[forward.after])
    loads = [state.load for state in more]
    assert loads[0] > unstable.load and loads == sorted(loads)
    turned = next(b for a, b in pairwise(frame.states) if b.deflection < a.deflection)
    down = snap(frame.path, turned, "displacement")
    more = Path(frame.case.scene, frame.case.control, Until(steps=down.after.step + 3), start=[down.after])
    deflections = [down.after.deflection, *(state.deflection for state in more)]
    assert deflections == sorted(deflections)


def test_path_stays_at_its_state(frame):
    """A snap in the middle of a path leaves the path as it is."""
    path, loads = Path(frame.case.scene, frame.case.control, Until(steps=13)), []
    for state in path:
        if state.unstable_modes:
            snap(path, state)
        loads.append(state.load)
    assert loads == pytest.approx([s.load for s in frame.states[:14]], rel=1e-10)


def column():
    """Perfect column on two hinges with its bifurcation, traced up to 1.1 times Euler's load."""
    target = 1.1 * pi**2 * 1e9 * 0.01**4 / 12
    return follow(hinged_column(), LoadControl(step=target / 4, largest=1.0, target=target))


@pytest.mark.parametrize("side", [1, -1])
def test_column_falls_into_its_branch(side):
    """Above its bifurcation the straight column falls to one of the two bent states."""
    record = column()
    before = record.states[-1]
    assert before.unstable_modes == 1
    fall = snap(record.path, before, side=side)
    assert np.sign(fall.after.deflection) == side and falls(fall)
    point = next(p for p in record.critical_points if p.kind == "bifurcation")
    starts = [branch.start for branch in branches(record.path, record.states, point)]
    near = next(start for start in starts if start.deflection * side > 0)
    *_, expected = Path(record.case.scene, LoadControl(step=(before.factor - near.factor) / 4, target=before.factor),
                        start=[near])
    assert fall.after.unstable_modes == 0
    assert fall.after.deflection == pytest.approx(expected.deflection, rel=1e-6)
    assert distance(fall.after, expected) < 1e-6


def test_higher_modes_are_left_behind():
    """A cantilever above its second bifurcation falls to its first bent shape, which has no inflection."""
    record = follow(cantilever(straight(20), lambda beam: [PointForce(beam.mesh, "tip", (-1.0, 0.0))]),
                    LoadControl(step=7.0, target=28.0))
    before = record.states[-1]
    assert before.unstable_modes == 2
    falling = [snap(record.path, before, side=side) for side in (1, -1)]
    assert [fall.after.unstable_modes for fall in falling] == [0, 0] and all(map(falls, falling))
    assert falling[0].energy_released == pytest.approx(falling[1].energy_released, rel=1e-9)
    shapes = []
    for fall in falling:
        record.show(fall.after)
        u = record.path.discretisation.unknowns.fields[0].value
        order = np.argsort(u.function_space.tabulate_dof_coordinates()[:, 0])
        shapes.append(u.x.array.reshape(-1, 2)[order, 1])
    np.testing.assert_allclose(shapes[0], -shapes[1], atol=1e-8)
    assert np.all(np.diff(shapes[0]) > 0)


@pytest.mark.parametrize("side", [1, -1])
def test_von_mises_truss(side):
    """Two bars under a force below their limit: forward to the hanging truss, backward to the standing one."""
    rise = 0.3
    record = follow(von_mises_truss.case(rise).scene, ArcLength(step=0.01, largest=1.0), 0.6 * rise)
    before = record.states[-1]
    assert before.unstable_modes == 1
    fall = snap(record.path, before, side=side)

    def out_of_balance(height):
        length, short = np.hypot(1.0, rise), np.hypot(1.0, height)
        return 2 * (1 - short / length) * height / short - before.load

    height = rise - fall.after.deflection
    bracket = (-2 * rise, -rise) if side > 0 else (0.7 * rise, rise)
    assert height == pytest.approx(brentq(out_of_balance, *bracket, xtol=1e-14), rel=1e-6)
    assert fall.after.unstable_modes == 0 and falls(fall)


@pytest.mark.parametrize("hold", ["load", "displacement"])
def test_star_dome_with_six_unstable_directions(hold):
    """Down to a stable dome, whichever of the directions it leaves along; the energy by itself."""
    case = star_dome.case()
    record = follow(case.scene, case.control, 12.0)
    before = max(record.states, key=lambda state: state.unstable_modes)
    assert before.unstable_modes == 6
    fall = snap(record.path, before, hold)
    assert fall.after.unstable_modes == (0 if hold == "load" else 1) and falls(fall)
    if hold == "load":
        assert fall.energy_released == pytest.approx(lost(record, fall), rel=1e-6)
    with pytest.raises(ValueError, match=f"stable while the {hold} is held"):
        snap(record.path, fall.after, hold)


@pytest.mark.parametrize("side", [1, -1])
@pytest.mark.slow(quick=1)
def test_slender_arch_falls_along_a_curved_valley(side):
    """The deep arch, inextensible and shear-rigid; straight steps need more than 300 (energy to 1e-6 by itself)."""
    case = deep_arch.case()
    record = follow(case.scene, case.control, 118.0)
    fall = snap(record.path, record.states[-1], side=side)
    assert record.states[-1].unstable_modes and fall.after.unstable_modes == 0
    assert falls(fall) and fall.iterations < 100
    assert fall.energy_released == pytest.approx(lost(record, fall), rel=1e-6)


@pytest.mark.slow
def test_cylinder_with_a_cluster_of_unstable_directions():
    """Axially compressed far beyond its first of many bifurcations: less than half the load is left when it has fallen.

    Under the load itself a cylinder has no stable state near it.
    """
    scene = cylinder_buckling.case(ratio=100.0, halves=4.0, cells=(12, 5)).scene
    mesh = scene.parts[0].mesh
    held = replace(scene, supports=[*scene.supports, *(Support(mesh, end, "x y rz") for end in ("south", "north"))])
    path = Path(held, LoadControl(step=0.25, largest=1.0, target=1.0))
    *_, before = path
    assert before.unstable_modes >= 8
    fall = snap(path, before, "displacement")
    assert fall.after.load < before.load / 2 and fall.iterations < 100 and falls(fall)
    with pytest.raises(ValueError, match="stable while the displacement is held"):
        snap(path, fall.after, "displacement")


def test_stable_states_do_not_snap(thick_roof):
    with pytest.raises(ValueError, match="stable while the load is held"):
        snap(thick_roof.path, thick_roof.states[1])
    with pytest.raises(ValueError, match="stable while the displacement is held"):
        snap(thick_roof.path, beyond_limit(thick_roof), "displacement")


def test_bad_input(thick_roof):
    before = beyond_limit(thick_roof)
    with pytest.raises(ValueError, match="hold is 'force'; it must be one of load, displacement"):
        snap(thick_roof.path, before, "force")
    with pytest.raises(ValueError, match="side is 0"):
        snap(thick_roof.path, before, side=0)
    with pytest.raises(ValueError, match="deflection 0 is stable"):
        snap(thick_roof.path, thick_roof.states[0])
    scene = column().case.scene
    follower = replace(scene, loads=[LineForce(scene.parts[0], (0.0, -1.0), follower=True)])
    path = Path(follower)
    with pytest.raises(ValueError, match="no energy that could fall"):
        snap(path, path.tracer.state)


def fallen_dome():
    """Load, deflection and energy after the fall of the star dome from its most unstable state."""
    case = star_dome.case()
    record = follow(case.scene, case.control, 12.0)
    fall = snap(record.path, max(record.states, key=lambda state: state.unstable_modes), "displacement")
    return fall.after.load, fall.after.deflection, fall.energy_released


@pytest.mark.slow
def test_two_processes():
    """The same state and energy to solver tolerance."""
    (line,) = on_two_processes("from test_snap import fallen_dome; print(*fallen_dome())")
    assert [float(v) for v in line.split()] == pytest.approx(fallen_dome(), rel=1e-7)
