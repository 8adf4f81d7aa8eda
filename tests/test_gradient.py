"""Derivatives of critical loads against differences of whole paths and closed forms; what a load depends on."""

from __future__ import annotations

import csv
import json
from dataclasses import replace
from math import pi
from pathlib import Path

import numpy as np
import pytest
from helpers import on_two_processes
from typer.testing import CliRunner

import sheetfx as fx
from sheetfx import meshes
from sheetfx.cli import app
from sheetfx.critical.changed import Change
from sheetfx.critical.numbers import numbers
from sheetfx.scenes import arch, cylinder_panel, lee_frame, load_case, roof, sinusoidal_arch

SLOW = pytest.mark.slow


def short_roof(thickness):
    case = roof.case(cells=4, form="naghdi-q2", thickness=thickness)
    return fx.Case(case.scene, case.control, fx.Until(deflection=25.0))


def higher_frame(height):
    """Lee's frame with its nodes moved up in proportion, which strains slender members at the same displacements."""
    case = lee_frame.case(elements=10)
    moved = fx.imperfect(case.scene, lambda x: np.column_stack((0 * x[:, 0], (height - 1.0) * x[:, 1], 0 * x[:, 0])))
    return fx.Case(moved, case.control, case.until)


def differences(make, at, point, step=1e-3):
    """Central ones of whole paths, of the nearest point of the same kind."""
    ahead, behind = (min((p.load for p in fx.trace(make(at * (1 + sign * step))).critical_points
                          if p.kind == point.kind), key=lambda load: abs(load - point.load)) for sign in (1, -1))
    return (ahead - behind) / (2 * step * at)


@pytest.mark.parametrize(("make", "at", "count"), [
    pytest.param(short_roof, 12.7, 2, marks=SLOW),
    pytest.param(lambda v: sinusoidal_arch.case(elements=8, alpha=v), 2.8, 2, marks=SLOW), (higher_frame, 1.0, 2),
    pytest.param(lambda v: cylinder_panel.case(cells=(4, 4), length=v), 0.5, 2, marks=SLOW),
    pytest.param(lambda v: cylinder_panel.case(cells=(4, 4), ratio=v), 100.0, 2, marks=SLOW),
], ids=["thickness of the roof", "rise of the arch", "height of the frame", "length of the panel", "its thickness"])
def test_against_differences_of_paths(make, at, count):
    """Limit points and bifurcations."""
    record = fx.trace(make(at))
    for point in record.critical_points[:count]:
        found = record.gradient(point, lambda v: make(v).scene, at)
        assert found == pytest.approx(differences(make, at, point), rel=1e-4)


LENGTHS = "Plate.thickness", "Rectangle.width", "Rectangle.depth", "Tube.diameter", "Tube.thickness"


@pytest.mark.parametrize(("name", "options"), [
    ("lee-frame", {"elements": 10}), ("von-mises-truss", {}), ("deep-arch", {}), ("star-dome", {}), ("column", {}),
    pytest.param("roof", {"cells": 4, "to": 20.0}, marks=SLOW), pytest.param("channel", {}, marks=SLOW),
    pytest.param("cylinder-panel", {"cells": (4, 4)}, marks=SLOW), pytest.param("dome", {"model": "bars"}, marks=SLOW),
], ids=lambda value: value if isinstance(value, str) else "")
@pytest.mark.slow(quick=1)
def test_structures_in_other_units(name, options):
    """A load is proportional to the modulus, and to the square of all lengths: of sections, and between nodes.

    Nodes that move strain the deep arch, 1e7 times as stiff along as across: at seven states about its minimum rounding
    scatters the sum by 6e-5.
    """
    record = fx.trace(load_case(name)(**options))
    scene = record.case.scene
    known = {number.name: Change(number.scene, number.value) for number in numbers(scene)}
    places = Change(lambda times: fx.imperfect(scene, lambda x: (times - 1.0) * x), 1.0)
    lengths = [places, *(known[one] for one in LENGTHS if one in known)]
    for point in [point for point in record.critical_points if point.kind != "event"][:3]:
        rates = list(record.load_gradient(point).derivatives([known["Elastic.modulus"], *lengths]))
        modulus, *others = (np.atleast_1d(rate) * change.at / point.load
                            for rate, change in zip(rates, [known["Elastic.modulus"], *lengths], strict=True))
        assert modulus == pytest.approx(1.0, rel=1e-5)
        assert sum(others) == pytest.approx(2.0, rel=5e-5 if name == "deep-arch" else 2e-5)


def test_the_modulus_of_a_frame_that_symmetry_does_not_protect():
    """Koiter's frame: what its columns' sections change makes it imperfect; shear that is not there does nothing."""
    record = fx.trace(load_case("roorda-frame")())
    known = {number.name: number for number in numbers(record.case.scene)}
    gradient, one = record.load_gradient(record.critical_points[0]), known["Elastic.modulus"]
    rate = gradient.derivative(one.scene, one.value)
    assert rate * one.value == pytest.approx(record.critical_points[0].load, rel=1e-4)
    one = known["Rectangle.shear_factor of column"]
    assert abs(gradient.derivative(one.scene, one.value)) < 1e-2 * record.critical_points[0].load
    one = known["Rectangle.depth of column"]
    with pytest.raises(ValueError, match="makes the structure imperfect"):
        gradient.derivative(one.scene, one.value)


@pytest.mark.slow
def test_a_reaction_to_a_prescribed_displacement():
    """A column that is shortened buckles as one that is pressed does."""
    mesh = fx.read(lambda: meshes.frame({"a": (0, 0), "b": (0, 1)}, {"one": ("a", "b", 8)}), 2, order=2)
    beam = fx.Beam(mesh, fx.Rectangle(1.0, 0.02), fx.Elastic(1e6))
    rates = []
    for load, control in ((fx.PointForce(mesh, "b", (0.0, -1.0)), fx.LoadControl(4.0, target=10.0)),
                          (fx.PrescribedDisplacement(mesh, "b", "y", -0.01), fx.LoadControl(0.02, target=0.05))):
        supports = [fx.pin(mesh, "a"), fx.Support(mesh, "b", "x")]
        scene = fx.Scene([beam], supports, [load], fx.Monitor(mesh, "b", "y", -1.0))
        record = fx.trace(fx.Case(scene, control))
        (point,) = record.critical_points
        rates.append(list(record.load_gradient(point).derivatives(
            Change(number.scene, number.value) for number in numbers(scene))))
    assert rates[0][1] == pytest.approx(2.9986 * point.load / 0.02, rel=1e-5)
    assert rates[1] == pytest.approx(rates[0], rel=1e-4)


@pytest.mark.slow
def test_a_number_at_the_end_of_its_range():
    """A tube without a hole: its diameter can only grow, and its thickness only fall, which does nothing at first."""
    mesh = fx.read(lambda: meshes.frame({"a": (0, 0, 0), "b": (0, 0, 1)}, {"one": ("a", "b", 8)}), 3, order=2)
    beam = fx.Beam(mesh, fx.Tube(0.02, 0.01), fx.Elastic(1e6), up=lambda x: (1.0, 0.0, 0.0))
    supports = [fx.Support(mesh, "a", "x y z rx rz"), fx.Support(mesh, "b", "x y rx")]
    scene = fx.Scene([beam], supports, [fx.PointForce(mesh, "b", (0.0, 0.0, -1.0))], fx.Monitor(mesh, "b", "z", -1.0))
    record = fx.trace(fx.Case(scene, fx.LoadControl(0.02, target=0.1)))
    known = {number.name: Change(number.scene, number.value) for number in numbers(scene)}
    point = record.critical_points[0]
    rates = record.load_gradient(point).derivatives([known["Tube.diameter"], known["Tube.thickness"]])
    by_diameter, by_thickness = (rate / point.load for rate in rates)
    assert 0.02 * by_diameter == pytest.approx(4.0, rel=1e-3)
    assert 0.01 * by_thickness == pytest.approx(0.0, abs=1e-4)


@pytest.mark.slow
def test_contact_at_a_limit_point():
    """Paths with contact have limit loads that waver by 1e-5 as points of contact come and go: longer differences."""
    case = arch.case(elements=80)

    def thicker(depth):
        scene = case.scene
        section = scene.parts[0].section
        return fx.Case(fx.remade(scene, {section: replace(section, depth=depth)}), case.control,
                       fx.Until(deflection=20.0))

    at = case.scene.parts[0].section.depth
    record = fx.trace(thicker(at))
    (point,) = record.critical_points
    found = record.gradient(point, lambda v: thicker(v).scene, at)
    assert found == pytest.approx(differences(thicker, at, point, 1e-2), rel=2e-3)


def yielding(no_punch, to):
    def make(**options):
        case = arch.case(**{"elements": 20, "no_punch": no_punch, "yield_stress": 60.0, "hardening": 500.0} | options)
        return fx.Case(case.scene, case.control, fx.Until(deflection=to))

    return make


def yielding_roof(**options):
    return roof.case(**{"cells": 4, "yield_stress": 8.0, "to": 16.0} | options)


def under_a_follower(**options):
    """Half of a shallow arch under a force that turns with it."""
    given = {"depth": 4.0, "angle": 10.0} | options
    mesh = fx.read(lambda: meshes.arc(1000.0, 0.0, np.radians(given["angle"]), 16, {"crown": 0.0}), 2, order=2)
    beam = fx.Beam(mesh, fx.Rectangle(10.0, given["depth"]), fx.Elastic(7e4))
    load = fx.LineForce(beam, (0.0, -0.01), follower=True)
    return fx.Case(fx.Scene([beam], [fx.pin(mesh, "end"), fx.symmetry(mesh, "crown")], [load],
                            fx.Monitor(mesh, "crown", "y", -1.0)), until=fx.Until(deflection=40.0))


def rubbing(**options):
    """In steps short enough that friction, which is counted by the step, does not change the load by more than 1e-4."""
    case = arch.case(**{"elements": 20, "friction": 0.3} | options)
    return fx.Case(case.scene, fx.ArcLength(step=4e-4, largest=2.0), fx.Until(deflection=16.5))


def in_stages(**options):
    """A yielding arch under its weight, then a force; with ten fibres alone derivatives waver by 3 % as these flow."""
    given = {"depth": 8.0, "modulus": 7e4, "yield_stress": 120.0, "hardening": 500.0, "weight": 0.01} | options
    mesh = fx.read(lambda: meshes.arc(1000.0, 0.0, np.radians(12.0), 16, {"crown": 0.0}), 2, order=2)
    metal = fx.Plastic(given["modulus"], 0.3, yield_stress=given["yield_stress"], hardening=given["hardening"])
    beam = fx.Beam(mesh, fx.Rectangle(10.0, given["depth"], points=40), metal)
    weight = fx.Stage([fx.LineForce(beam, (0.0, -given["weight"]))], "weight")
    scene = fx.Scene([beam], [fx.pin(mesh, "end"), fx.symmetry(mesh, "crown")],
                     [fx.PointForce(mesh, "crown", (0.0, -1.0))], fx.Monitor(mesh, "crown", "y", -1.0), stages=[weight])
    return fx.Case(scene, until=fx.Until(deflection=4.0))


@pytest.mark.parametrize(("make", "by", "step", "rel"), [
    (yielding(True, 20.0), {"yield_stress": 60.0, "thickness": 4.7625}, 1e-3, 1e-3),
    pytest.param(yielding(False, 14.0), {"yield_stress": 60.0, "thickness": 4.7625}, 1e-3, 1e-3, marks=SLOW),
    (in_stages, {"depth": 8.0, "weight": 0.01}, 1e-2, 2e-3),
    pytest.param(under_a_follower, {"depth": 4.0, "angle": 10.0}, 1e-3, 1e-4, marks=SLOW),
    pytest.param(yielding_roof, {"yield_stress": 8.0, "thickness": 12.7}, 1e-3, 1e-3, marks=SLOW),
    pytest.param(rubbing, {"thickness": 4.7625}, 3e-3, 1e-3, marks=SLOW),
], ids=["yielding arch", "yielding under a punch", "stages", "follower", "yielding roof", "friction"])
@pytest.mark.slow(quick=1)
def test_limits_that_depend_on_the_way(make, by, step, rel):
    record = fx.trace(make())
    for point in [point for point in record.critical_points if point.kind == "limit"]:
        found = record.load_gradient(point).derivatives(
            Change(lambda value, name=name: make(**{name: value}).scene, at) for name, at in by.items())
        for (name, at), known in zip(by.items(), found, strict=True):
            other = differences(lambda value, name=name: make(**{name: value}), at, point, step)
            assert known == pytest.approx(other, rel=rel), name


@SLOW
def test_minimum_after_unloading():
    """Its load depends on the steps by 5e-4, and so do differences of whole paths by some 3e-3."""
    make = yielding(True, 30.0)
    record = fx.trace(make())
    point = record.critical_points[-1]
    assert point.name == "minimum"
    found = record.gradient(point, lambda value: make(thickness=value).scene, 4.7625)
    assert found == pytest.approx(differences(lambda value: make(thickness=value), 4.7625, point), rel=5e-3)


def test_forces_that_scale_together():
    """Modulus, yield stress, hardening and weight together scale the load, whatever the way."""
    record = fx.trace(in_stages())
    point = next(p for p in record.critical_points if p.kind == "limit")
    by = {"modulus": 7e4, "yield_stress": 120.0, "hardening": 500.0, "weight": 0.01}
    rates = record.load_gradient(point).derivatives(
        Change(lambda value, name=name: in_stages(**{name: value}).scene, at) for name, at in by.items())
    total = sum(at * rate for at, rate in zip(by.values(), rates, strict=True))
    assert total == pytest.approx(point.load, rel=1e-6)


@SLOW
def test_a_yielding_structure_in_other_units(tmp_path):
    """Modulus, yield stress and hardening together scale the load, on two processes too; the width alone does."""
    words = ["depends", "arch", "--elements", "20", "--no-punch", "--yield", "60", "--hardening", "500", "--to", "8"]
    result = CliRunner().invoke(app, [*words, "-o", str(tmp_path / "one")])
    assert result.exit_code == 0, result.output
    found = json.loads((tmp_path / "one" / "depends.json").read_text())
    shares = {name: one["percent_per_percent"] for name, one in found.items()}
    assert shares["Rectangle.width"] == pytest.approx(1.0, rel=1e-6)
    assert shares["Plastic.modulus"] + shares["yield_stress"] + shares["hardening"] == pytest.approx(1.0, rel=1e-6)
    two = [*words, "-o", str(tmp_path / "two")]
    on_two_processes(f"from sheetfx.cli import app\napp({two!r}, standalone_mode=False)")
    others = json.loads((tmp_path / "two" / "depends.json").read_text())
    assert {name: one["derivative"] for name, one in others.items()} == pytest.approx(
        {name: one["derivative"] for name, one in found.items()}, rel=1e-5)


def test_what_changes_the_way_needs_its_states():
    """A part of the record does not tell what laws remember; a resumed path's first state is no unloaded one."""
    make = yielding(True, 20.0)
    record = fx.trace(make())
    point = next(p for p in record.critical_points if p.kind == "limit")
    with pytest.raises(ValueError, match="depends on states before it, and some are missing"):
        fx.LoadGradient(record.path, point, record.state_at(point), record.critical_modes(point), record.states[1:])


def masts(depth):
    """Two equal columns, of which the second has a depth of its own; loads over Euler's of the first."""
    nodes = {"a": (0, 0), "b": (0, 1), "c": (1, 0), "d": (1, 1)}
    mesh = fx.read(lambda: meshes.frame(nodes, {"one": ("a", "b", 8), "two": ("c", "d", 8)}), 2, order=1)
    parts = [fx.Beam(mesh, fx.Rectangle(1.0, d), fx.Elastic(1e6), group=name) for name, d in (("one", 0.01),
                                                                                         ("two", depth))]
    euler = pi**2 * 1e6 * 1e-6 / 12
    supports = [fx.pin(mesh, "a"), fx.Support(mesh, "b", "x"), fx.pin(mesh, "c"), fx.Support(mesh, "d", "x")]
    loads = [fx.PointForce(mesh, name, (0.0, -euler / 2)) for name in "bd"]
    return fx.Case(fx.Scene(parts, supports, loads, fx.Monitor(mesh, "b", "y", -1.0)), fx.LoadControl(0.45, target=3.0))


def test_a_double_point_splits():
    """Its second load is that of the column that is made stiffer, and grows with the third power of its depth."""
    record = fx.trace(masts(0.01))
    point = record.critical_points[0]
    assert point.multiplicity == 2
    found = record.gradient(point, lambda v: masts(v).scene, 0.01)
    assert found == pytest.approx([0.0, 3 * point.load / 0.01], rel=1e-3, abs=1e-6 * point.load / 0.01)


def test_an_imperfection_has_no_derivative():
    case = sinusoidal_arch.case(elements=8)
    record = fx.trace(case)
    point = next(p for p in record.critical_points if p.kind == "bifurcation")

    def leaning(amplitude):
        return fx.imperfect(case.scene, lambda x: np.column_stack(
            (0 * x[:, 0], amplitude * np.sin(2 * pi * x[:, 0] / 100.0), 0 * x[:, 0])))

    with pytest.raises(ValueError, match="the number makes the structure imperfect, so that bifurcation point"):
        record.gradient(point, leaning, 0.0, step=1e-4)
    limit = next(p for p in record.critical_points if p.kind == "limit")
    assert record.gradient(limit, leaning, 0.0, step=1e-4) == pytest.approx(0.0, abs=1e-6 * limit.load / 1e-2)


def test_what_has_no_gradient_is_refused():
    record = fx.trace(short_roof(12.7))
    point = record.critical_points[0]
    with pytest.raises(ValueError, match="at is 0, which tells no size of a step; give step"):
        record.gradient(point, lambda v: record.case.scene, 0.0)
    with pytest.raises(ValueError, match="changes the unknowns of the structure"):
        record.gradient(point, lambda v: roof.case(cells=6, form="naghdi-q2").scene, 12.7)
    with pytest.raises(ValueError, match="remade: the scene has not this Plate"):
        fx.remade(record.case.scene, {fx.Plate(12.7): fx.Plate(13.0)})


def test_what_a_load_depends_on_by_nodes(tmp_path):
    """A truss that is 0.1 high: its apex moves up as its rise grows, its feet have half of that the other way."""
    words = ["depends", "von-mises-truss", "--rise", "0.1", "--nodes", "-o", str(tmp_path)]
    result = CliRunner().invoke(app, words)
    assert result.exit_code == 0, result.output
    by_rise = json.loads((tmp_path / "depends.json").read_text())["rise"]["derivative"]
    rows = list(csv.DictReader((tmp_path / "nodes.csv").open()))
    found = {float(row["x"]): float(row["derivative"]) for row in rows}
    assert found[0.0] == pytest.approx(by_rise, rel=1e-5)
    assert found[-1.0] == pytest.approx(found[1.0], rel=1e-6) == pytest.approx(-by_rise / 2, rel=0.01)
    assert {row["along_x"] for row in rows} == {""} and (tmp_path / "nodes.png").exists()


def test_what_a_load_depends_on(tmp_path):
    """A stiffness that all parts share scales the load; the thickness as core.md and differences of paths have it."""
    result = CliRunner().invoke(app, ["depends", "roof", "--cells", "4", "-o", str(tmp_path)])
    assert result.exit_code == 0, result.output
    found = json.loads((tmp_path / "depends.json").read_text())
    assert list(found)[:2] == ["thickness", "Elastic.modulus"]
    assert found["thickness"]["derivative"] == pytest.approx(331.602, rel=1e-5)
    assert found["Elastic.modulus"]["percent_per_percent"] == pytest.approx(1.0, rel=1e-8)
    assert "a per cent more thickness (now 12.7): +1.9 % load" in result.output
    assert "without effect: to, step" in result.output
    assert (tmp_path / "depends.png").exists()
    result = CliRunner().invoke(app, ["depends", "roof", "--cells", "2", "--point", "9", "-o", str(tmp_path)])
    assert isinstance(result.exception, ValueError) and "has 2 limit points" in str(result.exception)


@pytest.mark.slow
def test_the_path_ends_at_the_point_that_is_asked_for(tmp_path):
    """The portal's path cannot be continued behind step 37; its limit point lies before."""
    scene = Path(__file__).parents[1] / "demos" / "advice" / "portal.py"
    assert CliRunner().invoke(app, ["depends", str(scene), "-o", str(tmp_path)]).exit_code == 0
    found = json.loads((tmp_path / "depends.json").read_text())
    assert found["yield_stress"]["percent_per_percent"] > 0.5 > 0 > found["sway"]["percent_per_percent"]


@pytest.mark.slow
def test_friction_between_parts_is_refused_before_the_path(tmp_path):
    result = CliRunner().invoke(app, ["depends", "double-plate", "-o", str(tmp_path)])
    assert "depends double-plate: parts that touch each other rub" in str(result.exception)
