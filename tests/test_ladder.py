"""The least model that a critical load needs: what is left out, what is needed, and whether the interval holds."""

from __future__ import annotations

import csv
import json
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from helpers import on_two_processes

import sheetfx as fx
from sheetfx.ladder import models
from sheetfx.ladder.climb import Climb
from sheetfx.ladder.first_point import from_coarser, up_to_first
from sheetfx.ladder.symmetry import Asymmetric, across, planes
from sheetfx.ladder.unsupported import rows_that_hold

DEMOS = Path(__file__).parents[1] / "demos" / "advice"
NOTHING = fx.LeftOut()


def scene_of(name: str):
    return fx.load_case(str(DEMOS / f"{name}.py") if (DEMOS / f"{name}.py").exists() else name)


def advised(name: str, within: float = 0.02, **options):
    function = scene_of(name)
    meshes = fx.by_option(function, options, 2) or fx.by_halving(function(**options), 2)
    return Climb(meshes, within).advice()


def first_of(case: fx.Case) -> float:
    """The first critical load of a whole model by its path, or the largest load."""
    return up_to_first(case, case.scene, NOTHING, NOTHING).load


def decisions(advice: fx.Advice) -> dict[str, str]:
    return {one.about: one.decided for one in advice.decisions}


def inside(advice: fx.Advice, load: float) -> bool:
    low, high = advice.interval
    return low <= load <= high


@pytest.mark.parametrize("name, options, finer, left", [
    ("roof", {"thickness": 12.7}, {"cells": 8}, NOTHING),
    ("stop", {"load": 1000.0}, {"cells": 32}, fx.LeftOut(contact=True)),
    ("stop", {}, {"cells": 32}, NOTHING),
    ("stocky_column", {}, {"cells": 64}, NOTHING),
    pytest.param("stiffened", {}, {"cells": 12}, fx.LeftOut(plasticity=True), marks=pytest.mark.slow),
    ("rough_foot", {}, {"cells": 32}, fx.LeftOut(friction=True)),
    ("rough_foot", {"friction": 0.6}, {"cells": 32}, NOTHING),
    ("ring", {}, {"cells": 64}, NOTHING),
])
@pytest.mark.slow(quick=2)
def test_the_load_of_the_whole_model_is_inside(name, options, finer, left):
    """What matters by construction is not left out, and what does not is."""
    advice = advised(name, **options)
    assert advice.reached and advice.left == left
    assert inside(advice, first_of(scene_of(name)(**options | finer)))


@pytest.mark.parametrize("name, exact", [
    ("hinged_half", 1e-3), pytest.param("plate_half", 0.02, marks=pytest.mark.slow)])
def test_modes_that_symmetry_hides_are_found(name, exact):
    """The half has them by the supports of the other symmetry, at the load of the whole."""
    advice = advised(name)
    whole, half = (scene_of(name)(whole=whole) for whole in (True, False))
    assert decisions(advice)["symmetry"] == "broken"
    load = first_of(whole)
    assert advice.load == pytest.approx(load, rel=exact) and inside(advice, load)
    assert first_of(half) > 1.1 * load


def test_half_of_a_plate_buckles_across_its_plane_as_the_whole_does():
    """On the same cells to rounding, whether the part can move freely or not (closed form: four, thin and sharp)."""
    elastic = fx.LeftOut(plasticity=True)
    case, whole = (elastic.of(scene_of("plate_half")(cells=4, whole=w)) for w in (False, True))
    modes, found = next(across(case.scene)), up_to_first(case, case.scene, NOTHING, NOTHING)
    assert Asymmetric(modes)(found.record.states[0]) > 0 > Asymmetric(modes)(found.state)
    closed = 4 * np.pi**2 * 210e3 / (12 * (1 - 0.3**2)) * (2.0 / 200.0) ** 2 * 2.0 * 2 * 200.0
    assert first_of(whole) == pytest.approx(closed, rel=0.02)


def test_planes_of_symmetry_are_those_that_are_declared_or_counted():
    """A sliding clamp is none, unless the factor needs it."""
    mesh = fx.read(lambda: fx.meshes.frame({"a": (0, 0), "b": (1, 0)}, {"one": ("a", "b", 2)}), 2)
    beam = fx.Beam(mesh, fx.Rectangle(0.1, 0.1), fx.Elastic(1e4))

    def count(support: fx.Support, factor: int) -> int:
        return len(planes(fx.Scene([beam], [fx.pin(mesh, "a"), support], [fx.PointForce(mesh, "b", (0.0, 1.0))],
                                   fx.Monitor(mesh, "b", "y"), symmetry_factor=factor)))

    sliding = fx.Support(mesh, "b", "x rz")
    assert [count(sliding, 1), count(sliding, 2), count(sliding, 4)] == [0, 1, 0]
    assert [count(fx.symmetry(mesh, "b"), factor) for factor in (1, 2, 4)] == [1, 1, 1]
    assert len(planes(fx.load_case("roof")(cells=1).scene)) == 2


def test_what_moves_freely_is_held_by_as_many_unknowns():
    """The half plate can slide along its length and turn in its plane by modes across it; the arch can not move."""
    for name, count in (("plate_half", 2), ("hinged_half", 0)):
        discretisation = Asymmetric(next(across(scene_of(name)().scene)))._home
        system = discretisation.system
        system.extrapolate_stress()
        assert len(rows_that_hold(discretisation, system.tangent())) == count


@pytest.mark.slow
def test_obstacles_that_travel_stand_still_in_modes_across():
    """The arch under a punch that moves freely does not buckle sideways, as the whole one does not."""
    advice = advised("arch", elements=40)
    assert decisions(advice)["symmetry"] == "kept"
    assert inside(advice, first_of(fx.load_case("arch")(elements=80, full=True)))


@pytest.mark.slow
def test_plastic_hinges_need_more_layers_and_cells():
    """Five fibres give the plastic moment 5 % low; the exact rigid-plastic load bounds what large sway leaves."""
    advice = advised("portal")
    assert advice.doubled and decisions(advice)["plasticity"] == "needed" and advice.reached
    finest = fx.integrated_finer(scene_of("portal")(cells=64), 2)
    assert inside(advice, first_of(finest))
    coarse = scene_of("portal")(cells=4)
    assert first_of(fx.integrated_finer(coarse)) > 1.02 * first_of(coarse)


def test_layers_whose_error_is_unknown_are_told(monkeypatch):
    """Where the path with twice as many stops, the interval is not as narrow as asked, and no number is doubled."""
    def stops(case: fx.Case, times: int = 1) -> fx.Case:
        return replace(case, control=fx.LoadControl(step=1e9, target=1e9, fixed=True, smallest=0.5)) if times else case

    monkeypatch.setattr(models, "integrated_finer", stops)
    advice = advised("portal")
    assert not advice.reached and not advice.doubled and decisions(advice)["layers and steps"] == "unknown"
    assert sum(one.about == "layers and steps" for one in advice.decisions) == 1


def test_half_steps_may_be_twice_as_many():
    case = scene_of("portal")(cells=4)
    case = replace(case, until=fx.Until(steps=len(up_to_first(case, case.scene, NOTHING, NOTHING).record.states)))
    finer = fx.integrated_finer(case)
    assert up_to_first(finer, finer.scene, NOTHING, NOTHING).point


def test_finer_cells_give_the_point_of_their_path_directly():
    meshes = fx.by_option(scene_of("roof"), {"cells": 2}, 1)
    coarse, fine = (meshes.case(level) for level in (0, 1))
    direct = from_coarser(up_to_first(coarse, coarse.scene, NOTHING, NOTHING), fine, fine.scene, NOTHING, NOTHING)
    path = up_to_first(fine, fine.scene, NOTHING, NOTHING)
    assert direct.point.load == pytest.approx(path.point.load, rel=1e-8)
    spent = sum(state.factorisations for state in path.record.states)
    assert direct.record.path.tracer.total_factorisations < spent
    assert direct.bar().error == pytest.approx(path.bar().error, rel=0.05)


@pytest.mark.slow
def test_a_mode_that_is_overtaken_on_finer_cells_is_noticed():
    """On four cells the cylindrical panel's modes are in the wrong order: the second one is no first point on ten."""
    function = fx.load_case("cylinder-panel")
    coarse, fine = function(cells=(4, 4)), function(cells=(10, 6))
    found = up_to_first(coarse, coarse.scene, NOTHING, NOTHING)
    direct = from_coarser(found, fine, fine.scene, NOTHING, NOTHING)
    first = up_to_first(fine, fine.scene, NOTHING, NOTHING)
    assert direct is None or direct.load == pytest.approx(first.load, rel=1e-7)
    second = up_to_first(coarse, coarse.scene, NOTHING, NOTHING)
    record = fx.trace(coarse)
    points = [p for p in record.critical_points if p.kind == "bifurcation"]
    second.record, second.point = record, points[1]
    again = from_coarser(second, fine, fine.scene, NOTHING, NOTHING)
    assert again is None or again.load == pytest.approx(first.load, rel=1e-7)


def test_cells_are_halved_on_their_geometry():
    case = fx.load_case("roof")(cells=2)
    once, again = fx.halved(case), fx.load_case("roof")(cells=4)
    mesh, same = (c.scene.parts[0].mesh for c in (once, again))
    count = [m.domain.topology.index_map(2).size_global for m in (mesh, same)]
    assert count == [16, 16] and mesh.measure == pytest.approx(same.measure, rel=1e-10)
    assert first_of(once) == pytest.approx(first_of(again), rel=1e-6)
    assert fx.halved(case, 0) is case


def test_where_cells_cannot_be_halved_degrees_are_raised():
    """As of a structure whose nodes have been moved; cubic triangles have no form of a higher degree."""
    for form, highest in (("naghdi-q2", 1), ("naghdi-t3", 0)):
        case = fx.load_case("roof")(cells=2, form=form)
        moved = fx.imperfect(case.scene, lambda x: 0.0 * x, 1.0)
        meshes = fx.by_halving(fx.Case(moved, case.control, case.until), 2)
        assert (meshes.lowest, meshes.highest) == (0, highest)
    case = fx.raised(fx.load_case("roof")(cells=2, form="naghdi-q2"))
    assert first_of(case) == pytest.approx(first_of(fx.load_case("roof")(cells=2, form="naghdi-q3")), rel=1e-6)


def test_a_file_of_cells_is_not_halved(tmp_path):
    import gmsh

    gmsh.initialize(interruptible=False)
    gmsh.option.setNumber("General.Terminal", 0)
    fx.meshes.rectangle((2, 2))
    gmsh.model.mesh.generate(2)
    gmsh.write(str(tmp_path / "plate.msh"))
    gmsh.finalize()
    assert fx.read(tmp_path / "plate.msh", 3).measure == pytest.approx(1.0)
    with pytest.raises(ValueError, match="halvings is 1, but a file of cells"):
        fx.read(tmp_path / "plate.msh", 3, halvings=1)


def test_the_command_writes_its_advice_and_a_script(tmp_path, command):
    out = tmp_path / "advice"
    status, said, errors = command("advise", "roof", "--yield", "60", "--within", "1%", "-o", out)
    assert status == 0, errors
    told = json.loads((out / "advice.json").read_text())
    assert told["reached"] and told["model"]["plasticity"] and told["within"] == 0.01
    assert told["interval"][0] < told["load"] < told["interval"][1] and told["cpu_seconds"] > 0
    assert "plasticity left out: the largest von Mises stress" in said
    case = fx.load_case(str(out / "advised.py"))()
    low, high = told["interval"]
    assert low < first_of(case) < high


@pytest.mark.slow
def test_two_processes_advise_the_same(tmp_path):
    """A part that can move freely across its plane of symmetry, held by an unknown of one process."""
    words = ["advise", str(DEMOS / "plate_half.py"), "-o", str(tmp_path / "two")]
    on_two_processes(f"from sheetfx.cli import app\napp({words!r}, standalone_mode=False)")
    two, one = json.loads((tmp_path / "two" / "advice.json").read_text()), advised("plate_half")
    assert two["load"] == pytest.approx(one.load, rel=1e-7)
    assert [d["decided"] for d in two["decisions"]] == [d.decided for d in one.decisions]


def test_an_interval_that_stays_wider_is_told(tmp_path, command):
    status, said, _ = command("advise", "roof", "--cells", "2", "--finest", "0", "--within", "0.0001%", "-o", tmp_path)
    told = json.loads((tmp_path / "advice.json").read_text())
    assert status == 0 and not told["reached"] and "wider than asked for" in said
    assert told["interval"][0] < told["load"] < told["interval"][1]


@pytest.mark.parametrize("arguments, said", [
    (["--within", "0"], "--within is '0'; it must be a share above 0 and below 1"),
    (["--within", "half"], "--within is 'half'"),
    (["--refine", "thick"], "--refine is 'thick', but the scene has no such option"),
    (["--refine", "form"], "--refine form: the option is 'naghdi-q3'; name one that is a number"),
    (["--finest", "-1"], "--finest"),
])
def test_wrong_options_are_refused(tmp_path, command, arguments, said):
    status, _, told = command("advise", "roof", *arguments, "-o", tmp_path / "advice")
    assert status and said in " ".join(told.split())


@pytest.mark.slow
def test_a_scene_without_reference_has_a_chart_of_its_models(tmp_path, command):
    """The elastic column has no critical point; a chart that is gone on with runs nothing again."""
    words = ["chart", DEMOS / "stocky_column.py", "--repeat", "1", "-o", tmp_path]
    status, said, errors = command(*words)
    assert status == 0, errors
    assert "without plasticity cells 32 is left out: sheetfx: error: no limit point" in said
    rows = list(csv.DictReader((tmp_path / "chart.csv").open()))
    off = {(row["method"], row["label"]): float(row["error_percent"]) for row in rows}
    assert 0.2 < off["all that the scene has", "cells 32"] < 1  # by five fibres along each side
    assert off["sheetfx advise", ""] < 0.1
    assert (tmp_path / "chart.png").exists()
    status, _, _ = command(*words, "--resume")
    assert status == 0 and list(csv.DictReader((tmp_path / "chart.csv").open())) == rows, "seconds of another run"


def test_where_finer_cells_stop_the_load_of_coarser_ones_is_told():
    """With an interval that says that nothing checks it, and the reason."""
    def case(cells: int = 4) -> fx.Case:
        given = fx.load_case("roof")(cells=cells, thickness=6.35)
        if cells < 4:
            return given
        return fx.Case(given.scene, fx.LoadControl(step=2000.0, target=2000.0, fixed=True, smallest=0.5))

    advice = Climb(fx.by_option(case, {}, 0), 1e-9).advice()
    assert not advice.reached and advice.level == -1 and decisions(advice)["path"] == "stopped"
    assert inside(advice, first_of(case(2)))


def test_an_option_that_makes_another_structure_is_not_one_of_cells():
    """As of a frame with more bays; its cells are halved by gmsh."""
    def frame(cells: int = 4) -> fx.Case:
        points = {str(n): (float(n), 0.0) for n in range(cells + 1)}
        members = {f"bay {n}": (str(n), str(n + 1), 4) for n in range(cells)}
        mesh = fx.read(lambda: fx.meshes.frame(points, members), 2)
        beam = fx.Beam(mesh, fx.Rectangle(0.1, 0.1), fx.Elastic(1e4))
        return fx.Case(fx.Scene([beam], [fx.clamp(mesh, "0")], [fx.PointForce(mesh, str(cells), (-1.0, 0.0))],
                                fx.Monitor(mesh, str(cells), "x")))

    assert fx.by_option(frame, {}) is None
    with pytest.raises(ValueError, match="--refine cells: cells 2 makes another structure"):
        fx.by_option(frame, {}, refine="cells")
    assert fx.by_halving(frame()).highest == 1


@pytest.mark.slow
def test_the_page_leads_from_a_gmsh_file_to_a_load(tmp_path, monkeypatch, command):
    """Its files and its command as they stand; the load is inside the interval of cells halved once more."""
    page = (DEMOS.parent / "pages" / "advice.md").read_text()
    files = {"strut.geo": re.search(r"^```geo\n(.*?)^```", page, re.M | re.S)[1],
             "strut.py": re.search(r"^```py\n(.*?)^```", page, re.M | re.S)[1]}
    for name, text in files.items():
        (tmp_path / name).write_text(text)
    monkeypatch.chdir(tmp_path)
    words = re.search(r"^\$ docker/run sheetfx (advise .*)$", page, re.M)[1].split()
    status, said, errors = command(*words)
    assert status == 0, errors
    assert "plasticity needed" in said
    told = json.loads(Path("results/strut-advice/advice.json").read_text())
    assert told["load"] == pytest.approx(float(re.search(r"at load (\d{5}) ", page)[1]), rel=1e-3)
    low, high = told["interval"]
    assert low < first_of(fx.halved(fx.load_case("strut.py")(), 2)) < high
