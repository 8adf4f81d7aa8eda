"""Load stages: constant loads first, then the varying load; prescribed rotations and held displacements among them."""

from __future__ import annotations

import json
from math import pi

import numpy as np
import pytest
from helpers import on_two_processes, shallow_arch
from scipy.optimize import brentq

import sheetfx as fx
from sheetfx.case import run
from sheetfx.continuation.state import State

AREA = fx.Rectangle(1.0, 1.0)
WEIGHT = 0.04


def two_bars(half_span, height, supports, loads, monitor="y", **scene):
    """Two bars of unit axial stiffness from supports to an apex."""
    nodes = {"left": (-half_span, 0.0), "apex": (0.0, height), "right": (half_span, 0.0)}
    mesh = fx.read(lambda: fx.meshes.frame(nodes, {"a": ("left", "apex", 1), "b": ("apex", "right", 1)}), 2)
    bars = fx.Bar(mesh, AREA, fx.Elastic(1.0))
    return fx.Scene([bars], supports(mesh), loads(mesh), fx.Monitor(mesh, "apex", monitor, -1.0),
                    **{name: value(mesh) for name, value in scene.items()})


def weighted_arch(stages):
    """The shallow arch under its weight (some fifth of what it carries) and a force at its crown."""
    base = shallow_arch(10)
    weight = fx.LineForce(base.parts[0], (0.0, -WEIGHT))
    if stages:
        return fx.Scene(base.parts, base.supports, base.loads, base.monitor, symmetry_factor=2,
                        stages=[fx.Stage([weight], "self-weight")])
    return base, weight


def first_limit(record):
    return next(p for p in record.critical_points if p.kind == "limit")


def test_arch_under_self_weight_and_then_a_force():
    """Elastic limits do not depend on the order of loads: both loads growing together pass the same limit."""
    record = fx.trace(fx.Case(weighted_arch(True), fx.ArcLength(0.005), fx.Until(deflection=15.0)))
    limit = first_limit(record)
    stages = [s.stage for s in record.states]
    assert stages == sorted(stages) and set(stages) == {0, 1}
    begin = next(s for s in record.states if s.stage == 1)
    assert begin.factor == begin.load == 0.0 and begin.deflection == record.states[begin.step - 1].deflection > 0.05
    base, weight = weighted_arch(False)
    force = limit.load / 2
    together = fx.Scene(base.parts, base.supports, [weight, fx.PointForce(base.parts[0].mesh, "crown", (0.0, -force))],
                        base.monitor, symmetry_factor=2)
    path = fx.trace(fx.Case(together, fx.ArcLength(0.005), fx.Until(deflection=15.0)))
    after = next(s for s in path.states if s.critical)
    total = first_limit(path).load / after.load * after.factor
    assert total == pytest.approx(1.0, rel=1e-8)
    assert first_limit(path).deflection == pytest.approx(limit.deflection, rel=1e-5)
    bare = first_limit(fx.trace(fx.Case(base, fx.ArcLength(0.005), fx.Until(deflection=15.0))))
    assert limit.load < 0.95 * bare.load


def test_prestressed_cable():
    """Two bars in line, stretched first and then pushed across: F = 2 EA (l - L) / L v / l with l^2 = a^2 + v^2.

    Without prestress it is a mechanism; a weak spring holds it at the start.
    """
    stretch = 0.01
    scene = two_bars(
        1.0, 0.0, lambda m: [fx.pin(m, "left"), fx.Support(m, "right", "y"), fx.Support(m, "apex", "")],
        lambda m: [fx.PointForce(m, "apex", (0.0, -1e-3))],
        stages=lambda m: [fx.Stage([fx.PrescribedDisplacement(m, "right", "x", 2 * stretch)], "prestress")],
        joints=lambda m: [fx.Spring(m, "apex", "y", 1e-3)])
    record = fx.trace(fx.Case(scene, fx.LoadControl(0.25)))
    held = [s for s in record.states if s.stage == 0][-1]
    assert held.load == pytest.approx(stretch, rel=1e-9), "the reaction is the prestress EA e"
    last, a = record.states[-1], 1 + stretch

    def force(v):
        length = np.hypot(a, v)
        return 2 * (length - 1) * v / length + 1e-3 * v - 1e-3

    assert last.deflection == pytest.approx(brentq(force, 0, 1), rel=1e-8)
    assert last.load == pytest.approx(1e-3, rel=1e-12)


def test_truss_whose_supports_have_moved_apart():
    """Unloaded bars keep their length as the supports part; the limit is that of the flatter truss in closed form."""
    half_span, height, apart = 1.0, 0.3, 0.02
    scene = two_bars(
        half_span, height, lambda m: [fx.pin(m, "left"), fx.Support(m, "right", "y")],
        lambda m: [fx.PointForce(m, "apex", (0.0, -1.0))],
        stages=lambda m: [fx.Stage([fx.PrescribedDisplacement(m, "right", "x", apart)], "settlement",
                                   fx.LoadControl(0.5))])
    record = fx.trace(fx.Case(scene, fx.ArcLength(0.01), fx.Until(deflection=0.45)))
    length, base = np.hypot(half_span, height), half_span + apart / 2
    flat = next(s for s in record.states if s.stage == 1)
    assert flat.deflection == pytest.approx(height - np.sqrt(length**2 - base**2), rel=1e-7)
    limit, at_limit = first_limit(record), (length * base**2) ** (1 / 3)
    exact = 2 * (length - at_limit) / length * np.sqrt(at_limit**2 - base**2) / at_limit
    assert limit.load == pytest.approx(exact, rel=1e-9)


def test_stage_applied_at_once():
    scene = weighted_arch(True)
    quick = fx.Scene(scene.parts, scene.supports, scene.loads, scene.monitor, symmetry_factor=2,
                     stages=[fx.Stage(scene.stages[0].loads, "self-weight", fx.LoadControl(1.0, fixed=True))])
    states = [fx.trace(fx.Case(s, fx.ArcLength(0.005), fx.Until(steps=n))).states
              for s, n in ((scene, 30), (quick, 2))]
    ends = [[s for s in path if s.stage == 0][-1] for path in states]
    assert ends[1].step == 1 and ends[1].deflection == pytest.approx(ends[0].deflection, rel=1e-6)


def test_interrupted_stages_resume(tmp_path):
    """In both stages, from files."""
    case = fx.Case(weighted_arch(True), fx.ArcLength(0.01), fx.Until(deflection=8.0))
    whole = fx.trace(case).states
    border = next(s.step for s in whole if s.stage == 1)
    for end in (2, border, border + 1, border + 3):
        for state in whole[:end]:
            state.save(tmp_path / f"{state.step}.npz")
        read = [State.load_from(tmp_path / f"{n}.npz") for n in range(end)]
        again = fx.trace(case, start=read).states
        assert [s.load for s in again] == pytest.approx([s.load for s in whole], rel=1e-7, abs=1e-9)
        assert [s.stage for s in again] == [s.stage for s in whole]


def test_states_of_an_earlier_version_are_read(tmp_path):
    """They have no stage, the load factor among the numbers alone, and two attributes of other names."""
    case = fx.Case(shallow_arch(10), fx.ArcLength(0.01), fx.Until(deflection=8.0))
    whole = fx.trace(case).states
    for state in whole[:3]:
        file = tmp_path / f"{state.step}.npz"
        state.save(file)
        with np.load(file) as archive:
            content = {name: archive[name] for name in archive.files if name != "field load"}
        numbers = json.loads(str(content["numbers"]))
        del numbers["stage"]
        numbers |= {"unstable": numbers.pop("unstable_modes"), "determinant": numbers.pop("determinant_sign")}
        np.savez(file, **content | {"numbers": json.dumps(numbers)})
    read = [State.load_from(tmp_path / f"{n}.npz") for n in range(3)]
    again = fx.trace(case, start=read).states
    assert [s.load for s in again] == pytest.approx([s.load for s in whole], rel=1e-9)
    assert [s.unstable_modes for s in read] == [s.unstable_modes for s in whole[:3]]


def test_stage_is_on_file(tmp_path):
    case = fx.Case(weighted_arch(True), fx.ArcLength(0.01), fx.Until(deflection=4.0))
    summary = run(case, "arch", {}, tmp_path, False)
    header, *rows = (tmp_path / "path.csv").read_text().splitlines()
    place = header.split(",").index("stage")
    assert {row.split(",")[place] for row in rows} == {"0", "1"}
    assert summary["stages"] == ["self-weight", "load"]


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.slow(quick=1)
def test_prescribed_rotation(dimension):
    """The end of a cantilever turned far: a circle under the moment EI angle / L.

    In the plane by 1.5 turns; in space about a skew axis and by less than a turn, from where the circle is unstable.
    """
    def length(*x):
        return x + (0.0,) * (dimension - 2)

    mesh = fx.read(lambda: fx.meshes.frame({"base": length(0.0, 0.0), "tip": length(1.0, 0.0)},
                                            {"beam": ("base", "tip", 24)}), dimension)
    beam = fx.Beam(mesh, fx.Rectangle(0.1, 0.1), fx.Elastic(1.2e5, 0.0))
    angle = 3 * pi if dimension == 2 else 1.4 * pi
    rotation = angle if dimension == 2 else (0.0, 0.6 * angle, 0.8 * angle)
    scene = fx.Scene([beam], [fx.clamp(mesh, "base")], [fx.PrescribedRotation(mesh, "tip", rotation)],
                     fx.Monitor(mesh, "tip", "x"))
    record = fx.trace(fx.Case(scene, fx.LoadControl(0.05)))
    state = record.states[-1]
    assert state.load == pytest.approx(angle, rel=1e-4), "EI = 1"
    assert record.displacement("tip")[0] == pytest.approx(-1 + np.sin(angle) / angle, abs=1e-3)
    assert record.critical_points == []


def test_stages_on_two_processes():
    script = '''
import sheetfx as fx
from test_stages import weighted_arch, first_limit
print(first_limit(fx.trace(fx.Case(weighted_arch(True), fx.ArcLength(0.02), fx.Until(deflection=15.0)))).load)
'''
    record = fx.trace(fx.Case(weighted_arch(True), fx.ArcLength(0.02), fx.Until(deflection=15.0)))
    assert float(on_two_processes(script)[0]) == pytest.approx(first_limit(record).load, rel=1e-8)


def test_empty_stage_is_named():
    with pytest.raises(ValueError, match="Stage 'prestress': loads is empty; give at least one"):
        fx.Stage([], "prestress")


def test_each_stage_has_its_control():
    """Displacement control of a point that is not the monitored one, and modified Newton, behind a stage of weight."""
    scene = weighted_arch(True)
    mesh = scene.parts[0].mesh
    turn = fx.Monitor(mesh, "crown", "y", -1.0)
    hinged = [fx.pin(mesh, "end"), fx.symmetry(mesh, "crown")]
    other = fx.Scene(scene.parts, hinged, scene.loads, fx.Monitor(mesh, "end", "rz"), symmetry_factor=2,
                     stages=scene.stages)
    control = fx.DisplacementControl(0.5, monitor=turn, newton="modified", largest=1.0, iterations=100)
    record = fx.trace(fx.Case(other, control, fx.Until(steps=8)))
    _, dofs = record.path.discretisation.monitored(turn)
    steps = [-s.increment[dofs].sum() for s in record.states if s.stage == 1][1:]
    assert steps == pytest.approx([0.5] * len(steps), rel=1e-9) and len(steps) > 2
    assert max(s.hardest for s in record.states) > 3


def test_stage_that_would_not_end_at_its_full_loads_is_named():
    scene = weighted_arch(True)
    for control in (fx.ArcLength(0.01), fx.LoadControl(target=2.0)):
        with pytest.raises(ValueError, match="Stage.*: control is .*; it must be a LoadControl with the"):
            fx.Path(fx.Scene(scene.parts, scene.supports, scene.loads, scene.monitor, symmetry_factor=2,
                             stages=[fx.Stage(scene.stages[0].loads, "self-weight", control)]))
