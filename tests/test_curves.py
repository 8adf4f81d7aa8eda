"""Curves of critical points in a number of the structure, against closed forms and paths."""

import csv
import json
from dataclasses import replace
from functools import cache
from math import cos, sin

import numpy as np
import pytest
from helpers import on_two_processes
from typer.testing import CliRunner

import sheetfx as fx
from sheetfx.case import Case, trace
from sheetfx.cli import app
from sheetfx.scenes import load_case

EXTENSION = 1e-6  # spring's stiffness over the bar's


def propped_bar(tilt: float) -> fx.Scene:
    """A stiff bar of length 1 on a hinge, held at its top by a horizontal spring of stiffness 1, under its own angle.

    The limit load is (1 - sin(tilt)^(2/3))^(3/2) (Thompson and Hunt 1973, section 5.1, after Augusti 1961).
    """
    nodes = {"foot": (0.0, 0.0), "top": (sin(tilt), cos(tilt))}
    mesh = fx.read(lambda: fx.meshes.frame(nodes, {"bar": ("foot", "top", 1)}), 2)
    bar = fx.Bar(mesh, fx.Rectangle(1.0, 1.0), fx.Elastic(1 / EXTENSION))
    return fx.Scene([bar], [fx.pin(mesh, "foot")], [fx.PointForce(mesh, "top", (0.0, -1.0))],
                    fx.Monitor(mesh, "top", "x"), joints=[fx.Spring(mesh, "top", "x", 1.0)])


def law(tilt: float) -> float:
    return (1 - abs(sin(tilt)) ** (2 / 3)) ** 1.5


def curve(record, kind: str, scene, at: float, to: float, **options) -> fx.CriticalCurve:
    point = next(p for p in record.critical_points if p.kind == kind)
    return fx.CriticalCurve(point, record.state_at(point), record.critical_modes(point), scene, at, to, **options)


@cache
def arch(alpha: float, depth: float = 0.1, elements: int = 24):
    return trace(load_case("sinusoidal-arch")(alpha=alpha, depth=depth, elements=elements))


def arches(depth: float = 0.1, elements: int = 24):
    return lambda alpha: load_case("sinusoidal-arch")(alpha=alpha, depth=depth, elements=elements).scene


@pytest.mark.slow
def test_two_thirds_law_through_its_cusp():
    """Limit loads of bars that lean to one side and to the other, which meet at the perfect bar's bifurcation."""
    record = trace(Case(propped_bar(0.3), fx.ArcLength(0.05), fx.Until(deflection=0.6)))
    points = list(curve(record, "limit", propped_bar, 0.3, -0.3, steps=6))
    assert (points[0].number, points[-1].number) == (0.3, -0.3)
    for point in points:
        assert point.load == pytest.approx(law(point.number), abs=5 * EXTENSION)
    (cusp,) = (point for point in points if point.name)
    assert (cusp.name, cusp.number) == ("cusp", pytest.approx(0.0, abs=1e-6))


@pytest.mark.slow
@pytest.mark.parametrize("end", [0.2, -0.2])
def test_the_perfect_bar_goes_on_as_the_limit_of_imperfect_ones(end):
    record = trace(Case(propped_bar(0.0), fx.ArcLength(0.05), fx.Until(deflection=0.6, load=1.2)))
    points = list(curve(record, "bifurcation", propped_bar, 0.0, end, steps=4))
    assert {point.kind for point in points[1:]} == {"limit"} and points[-1].number == end
    for point in points:
        assert point.load == pytest.approx(law(point.number), abs=5 * EXTENSION)


def bars(to: float, steps: int) -> list[fx.CurvePoint]:
    """Bifurcations of two bars against their rise, from 3 on."""
    scene = lambda rise: load_case("von-mises-truss")(rise=rise).scene  # noqa: E731
    return list(curve(trace(load_case("von-mises-truss")(rise=3.0)), "bifurcation", scene, 3.0, to, steps=steps))


@pytest.mark.slow
def test_bifurcations_of_two_bars():
    """Bars of length l, L at rest, over half the span: limits at l^3 = L, bifurcations at l^3 = L (l^2 - 1).

    They meet where l^2 = 2 and rise^2 = 7, and the bifurcations turn back where l^2 = 3 and rise^2 = 23 / 4.
    """
    turn, meeting = (p for p in bars(2.2, 4) if p.name)
    assert (turn.name, turn.number**2) == ("turn", pytest.approx(23 / 4, rel=1e-6))
    assert meeting.name == "limit meets bifurcation"
    assert (meeting.number**2, meeting.load) == pytest.approx((7.0, 0.5**0.5), rel=1e-6)


@pytest.mark.slow
def test_limit_meets_bifurcation_of_a_shallow_arch():
    """At alpha^2 = 5.5 (Fung and Kaplan 1952), by curves of either; the arch is h^2 off the shallow theory."""
    limits = curve(arch(2.0), "limit", arches(), 2.0, 2.8)
    points = list(limits)
    (meeting,) = (point for point in points if point.name)
    assert meeting.name == "limit meets bifurcation" and meeting.number**2 == pytest.approx(5.5, rel=1e-4)
    other = next(p for p in curve(arch(2.8), "bifurcation", arches(), 2.8, 2.2) if p.name)
    assert (other.name, other.number) == (meeting.name, pytest.approx(meeting.number, rel=1e-5))
    last = next(p for p in arch(2.8).critical_points if p.kind == "limit")
    assert (points[-1].load, points[-1].deflection) == pytest.approx((last.load, last.deflection), rel=1e-7)
    paths = len(points) * sum(state.factorisations for state in arch(2.8).states)
    assert 10 * limits.factorisations < paths


@pytest.mark.slow
def test_limit_meets_bifurcation_of_a_slender_arch():
    """A tenth of the depth has a hundredth of the difference; 48 elements are 1e-6 off, twice as many a sixteenth."""
    record = arch(2.3, 0.01, 96)
    meeting = next(p for p in curve(record, "limit", arches(0.01, 96), 2.3, 2.4, steps=7) if p.name)
    assert meeting.number**2 == pytest.approx(5.5, rel=1e-6)


@pytest.mark.slow
def test_bifurcations_turn_back():
    """Two bifurcations of the arch meet where alpha^2 = 4; behind the turn lies the second one."""
    points = list(curve(arch(2.8), "bifurcation", arches(), 2.8, 1.9))
    assert [p.name for p in points if p.name] == ["limit meets bifurcation", "turn", "limit meets bifurcation"]
    assert next(p for p in points if p.name == "turn").number**2 == pytest.approx(4.0, rel=1e-4)
    second = [p for p in arch(2.8).critical_points if p.kind == "bifurcation"][1]
    assert (points[-1].number, points[-1].load) == (2.8, pytest.approx(second.load, rel=1e-6))


@pytest.mark.slow
def test_double_bifurcations_stay_double():
    """Those of the star dome, as its ring is loaded too."""
    domes = load_case("star-dome")
    record, end = trace(domes(ring=0.0)), trace(domes(ring=0.2))
    (first,), (last,) = ([p for p in r.critical_points if p.multiplicity == 2][:1] for r in (record, end))
    modes = record.critical_modes(first)
    points = list(fx.CriticalCurve(first, record.state_at(first), modes, lambda ring: domes(ring=ring).scene, 0.0, 0.2,
                                   steps=4))
    assert (points[-1].load, points[-1].deflection) == pytest.approx((last.load, last.deflection), rel=1e-6)


def test_what_becomes_imperfect_on_the_way_is_refused():
    """A tilt that grows with the square of the number does not push at first."""
    record = trace(Case(propped_bar(0.0), fx.ArcLength(0.05), fx.Until(deflection=0.6, load=1.2)))
    with pytest.raises(ValueError, match="makes the structure imperfect"):
        list(curve(record, "bifurcation", lambda number: propped_bar(number**2), 0.0, 0.3))


def test_modes_that_the_number_parts_are_refused():
    """A column in space on springs along y and z, of which the number stiffens one."""
    def scene(more: float) -> fx.Scene:
        mesh = fx.read(lambda: fx.meshes.frame({"foot": (0.0, 0.0, 0.0), "top": (0.0, 0.0, 1.0)},
                                               {"bar": ("foot", "top", 1)}), 3)
        bar = fx.Bar(mesh, fx.Rectangle(1.0, 1.0), fx.Elastic(1 / EXTENSION))
        springs = [fx.Spring(mesh, "top", "x", 1.0), fx.Spring(mesh, "top", "y", 1.0 + more)]
        return fx.Scene([bar], [fx.pin(mesh, "foot")], [fx.PointForce(mesh, "top", (0.0, 0.0, -1.0))],
                        fx.Monitor(mesh, "top", "z", -1.0), joints=springs)

    record = trace(Case(scene(0.0), fx.ArcLength(0.05), fx.Until(deflection=0.6, load=1.2)))
    with pytest.raises(ValueError, match="parts the 2 modes"):
        list(curve(record, "bifurcation", scene, 0.0, 1.0))


@pytest.mark.slow
def test_a_curve_goes_on_where_it_was_kept(tmp_path):
    whole = list(curve(arch(2.0), "limit", arches(), 2.0, 2.3, steps=6))
    first = curve(arch(2.0), "limit", arches(), 2.0, 2.3, steps=6)
    begun = [next(points) for points in [iter(first)] * 3]
    first.kept.save(tmp_path / "kept.npz", len(begun))
    second = curve(arch(2.0), "limit", arches(), 2.0, 2.3, steps=6)
    second.kept, count = type(first.kept).load(tmp_path / "kept.npz")
    rest = list(second)
    assert count == 3 and [p.number for p in begun + rest] == pytest.approx([p.number for p in whole], rel=1e-12)


@pytest.mark.slow
def test_the_command(tmp_path):
    words = ["curve", "sinusoidal-arch", "--against", "alpha=2.2:2.5", "--parts", "4", "-o", str(tmp_path)]
    result = CliRunner().invoke(app, words)
    assert result.exit_code == 0, result.output
    rows = list(csv.DictReader((tmp_path / "curve.csv").open()))
    assert list(rows[0]) == ["parameter", "load", "deflection", "kind"]
    assert [float(rows[n]["parameter"]) for n in (0, -1)] == [2.2, 2.5]
    (meeting,) = json.loads((tmp_path / "points.json").read_text())
    assert meeting["name"] == "limit meets bifurcation" and (tmp_path / "curve.png").exists()
    again = CliRunner().invoke(app, [*words, "--resume"])
    assert again.exit_code == 0 and list(csv.DictReader((tmp_path / "curve.csv").open())) == rows


@pytest.mark.slow
def test_with_friction_each_point_is_that_of_its_own_path(tmp_path):
    words = ["curve", "arch", "--elements", "12", "--against", "friction=0:0.4", "--parts", "2", "-o", str(tmp_path)]
    result = CliRunner().invoke(app, words)
    assert result.exit_code == 0 and "by its whole path" in result.output, result.output
    text = (tmp_path / "curve.csv").read_text()
    rows = list(csv.DictReader(text.splitlines()))
    assert [float(row["parameter"]) for row in rows] == [0.0, 0.2, 0.4] and {row["kind"] for row in rows} == {"limit"}
    loads = [float(row["load"]) for row in rows]
    last = trace(load_case("arch")(elements=12, friction=0.4)).critical_points
    assert loads[-1] in [p.load for p in last if p.kind == "limit"] and loads == sorted(set(loads))
    (tmp_path / "curve.csv").write_text(text.rpartition("0.4,")[0])
    again = CliRunner().invoke(app, [*words, "--resume"])
    assert again.exit_code == 0 and (tmp_path / "curve.csv").read_text() == text


@pytest.mark.slow
@pytest.mark.parametrize("words", [
    ["von-mises-truss", "--against", "rise=3.0:2.9", "--parts", "1"],
    ["arch", "--elements", "6", "--to", "17", "--against", "friction=0:0.2", "--parts", "1"],
], ids=["equations", "paths"])
def test_the_command_on_two_processes(words, tmp_path):
    one, two = (["curve", *words, "-o", str(tmp_path / folder)] for folder in ("one", "two"))
    assert CliRunner().invoke(app, one).exit_code == 0
    on_two_processes(f"from sheetfx.cli import app\napp({two!r}, standalone_mode=False)")
    tables = [csv.DictReader((tmp_path / folder / "curve.csv").open()) for folder in ("one", "two")]
    found = [[(float(row["parameter"]), float(row["load"])) for row in table] for table in tables]
    assert len(found[0]) > 1 and np.array(found[1]) == pytest.approx(np.array(found[0]), rel=1e-6)
    assert (tmp_path / "two" / "curve.png").exists()


def test_a_point_that_paths_lose_is_told():
    def shorter(to: float) -> Case:
        return replace(load_case("von-mises-truss")(rise=1.0), until=fx.Until(deflection=to))

    begun = iter(fx.CurveByPaths(shorter, 1.0, 0.2, steps=1))
    first = next(begun)
    assert first.kind == "limit"
    with pytest.raises(fx.CurveEnds, match=f"no limit point is like that at .*, load {first.load:.6g}"):
        list(begun)
    with pytest.raises(ValueError, match="point 9 is asked for, but the path at 1 has 1 limit"):
        list(fx.CurveByPaths(shorter, 1.0, 0.2, number=9))


@pytest.mark.parametrize(("words", "said"), [
    ([], "nothing is varied"),
    (["--against", "elements=4:8"], "choose from alpha, depth, step"),
    (["--against", "alpha=2.2"], "give two values"),
    (["--against", "alpha=2.2:2.2"], "give two values"),
    (["--against", "alpha=2.2:-1"], "alpha is -1"),
    (["--against", "alpha=x:3"], "'x'"),
    (["--against", "alpha=2.2:2.4", "--alpha", "3.0"], "leave one out"),
    (["--against", "alpha=0.9:1.1"], "has 0 limit points"),
])
def test_what_the_command_refuses(words, said, tmp_path):
    result = CliRunner().invoke(app, ["curve", "sinusoidal-arch", *words, "-o", str(tmp_path)])
    assert result.exit_code and said in f"{result.exception} {result.output}"


@pytest.mark.slow
def test_two_processes():
    script = "from test_curves import bars\nprint(*(repr(n) for p in bars(2.8, 2) for n in (p.number, p.load)))"
    both = [float(word) for word in on_two_processes(script)[0].split()]
    assert both == pytest.approx([n for p in bars(2.8, 2) for n in (p.number, p.load)], rel=1e-8)


def test_what_a_curve_refuses():
    record = arch(2.0)
    with pytest.raises(ValueError, match="both 2"):
        curve(record, "limit", arches(), 2.0, 2.0)
    with pytest.raises(ValueError, match="changes the unknowns"):
        list(curve(record, "limit", lambda n: arches(elements=2 * round(n))(2.0), 12.0, 16.0))
    contact = trace(load_case("arch")(elements=12))
    point = next(p for p in contact.critical_points if p.kind == "limit")
    with pytest.raises(ValueError, match="has contact"):
        list(fx.CriticalCurve(point, contact.state_at(point), contact.critical_modes(point),
                              lambda value: contact.case.scene, 0.0, 1.0))
