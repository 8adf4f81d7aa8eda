"""Studies: every run has its own folder and values, is traced once, and one that fails leaves the others alone."""

import csv
import json
import os
import subprocess
import sys
from inspect import signature

import numpy as np
import pytest

from sheetfx.scenes import load_case
from sheetfx.studies import study, study_run
from sheetfx.studies.study import Study, trace_study
from sheetfx.studies.study_command import variations
from sheetfx.studies.study_picture import describe, draw_study, write_points, write_table

TRUSS = "von-mises-truss"


@pytest.fixture
def traced(monkeypatch):
    """Names of the runs that are traced; they are in this process."""
    names = []

    def process(task):
        names.append(study.label(task["parameters"]))
        try:
            study_run.follow(**task)
        except RuntimeError as error:
            return str(error)
        return ""

    monkeypatch.setattr(study, "_process", process)
    return names


def table(file):
    with file.open() as stream:
        return list(csv.DictReader(stream))


def stiffness(rise):
    """Of two bars of EA = 1 over half a span of 1: 2 sin² / length."""
    return 2 * rise**2 / (1 + rise**2) ** 1.5


def limit_load(rise):
    """Where the shortening of the bars times their slope is largest: their length is then the cube root of the first.

    With engineering strain the load is 2 (L/l - 1) y / L at the height y, and l² = 1 + y², L² = 1 + rise².
    """
    length = np.sqrt(1 + rise**2)
    height = np.sqrt(length ** (2 / 3) - 1)
    return 2 * (1 / np.sqrt(1 + height**2) - 1 / length) * height


def test_loads_and_stiffness_of_every_run(traced, tmp_path):
    """By closed forms; at a rise of 3 the first critical point is a bifurcation."""
    rises = [0.5, 1.0, 3.0]
    runs = trace_study(Study(TRUSS, {"step": 0.02}, {"rise": rises}), tmp_path)
    assert len(traced) == 3
    write_table(runs, tmp_path / "study.csv")
    write_points(runs, tmp_path / "critical_points.csv")
    rows, points = table(tmp_path / "study.csv"), table(tmp_path / "critical_points.csv")
    for rise, row in zip(rises, rows, strict=True):
        assert float(row["rise"]) == rise and row["status"] == "finished"
        assert float(row["initial_stiffness"]) == pytest.approx(stiffness(rise), rel=1e-9)
        assert float(row["limit_load"]) == pytest.approx(limit_load(rise), rel=1e-8)
        mine = [p for p in points if float(p["rise"]) == rise]
        assert len(mine) == int(row["critical_points"])
        assert [mine[0][name] for name in ("kind", "load", "deflection")] == [
            row[name] for name in ("first_kind", "first_load", "first_deflection")]
    assert [row["first_kind"] for row in rows] == ["limit", "limit", "bifurcation"]
    assert float(rows[2]["first_load"]) < float(rows[2]["limit_load"])


def test_picture_has_all_runs(traced, tmp_path):
    """A curve for each run, a point against the first option, a line for each value of the second; decades in logs."""
    runs = trace_study(Study("lee-frame", {"degree": 2, "to": 50.0}, {"step": [0.005, 0.5], "elements": [5, 10]}),
                       tmp_path)
    assert [run.chosen for run in runs] == [{"step": s, "elements": e} for s in (0.005, 0.5) for e in (5, 10)]
    curves, loads = draw_study(runs, "Lee's frame", ("deflection", "load")).axes
    assert loads.get_xscale() == "log" and loads.get_yscale() == "linear"
    assert {text.get_text() for text in loads.texts} == {"elements 5", "elements 10"}
    ends = [line.get_xydata()[-1] for line in curves.lines if line.get_linestyle() == "--"]
    assert np.allclose([end[0] for end in ends], 50.0) and len(ends) == 4
    shown = [line.get_xydata()[0] for line in loads.lines if line.get_marker() == "o" and len(line.get_xdata())]
    assert sorted(map(tuple, shown)) == sorted((run.chosen["step"], run.points[0].load) for run in runs)


def test_finished_runs_are_not_repeated_and_others_go_on(traced, tmp_path, monkeypatch):
    """One is interrupted at its third state; it goes on from there, to the path of a run that was not."""
    plan = Study(TRUSS, {"step": 0.02}, {"rise": [0.5, 1.0]})
    original, calls = study_run.run, []

    def interrupted(case, name, parameters, folder, resume):
        def interrupt(state):
            if state.step == 2 and parameters["rise"] == 1.0 and not resume:
                raise RuntimeError("power cut")

        calls.append((parameters["rise"], resume))
        return original(case, name, parameters, folder, resume, [interrupt])

    monkeypatch.setattr(study_run, "run", interrupted)
    first = trace_study(plan, tmp_path / "parts")
    assert [run.status for run in first] == ["finished", "failed"]
    assert describe(first[1]) == "rise=1: failed, 0 critical points, power cut"
    assert len(first[1].states) == 3, "what a run that fails has kept is drawn"
    plan = Study(TRUSS, {"step": 0.02}, {"rise": [0.5, 1.0, 2.0]})
    resumed = trace_study(plan, tmp_path / "parts", resume=True)
    assert [run.status for run in resumed] == 3 * ["finished"]
    assert calls == [(0.5, False), (1.0, False), (1.0, True), (2.0, False)]
    monkeypatch.setattr(study_run, "run", original)
    whole = trace_study(Study(TRUSS, {"step": 0.02}, {"rise": [1.0]}), tmp_path / "whole")
    np.testing.assert_allclose([s.load for s in resumed[1].states], [s.load for s in whole[0].states], rtol=1e-7)
    with pytest.raises(ValueError, match="step = 0.02, not 0.03"):
        trace_study(Study(TRUSS, {"step": 0.03}, {"rise": [0.5]}), tmp_path / "parts", resume=True)


@pytest.mark.parametrize(("texts", "words"), [
    ([], "nothing is varied"),
    (["elemens=5,10"], "no option 'elemens'; did you mean 'elements'. choose from elements, degree, to, step"),
    (["output=a,b"], "no option 'output'"),
    (["elements=5,x"], "elements: 'x'.*valid integer"),
    (["elements=5,10,5"], "5 is there twice"),
    (["elements=5,10", "elements=20"], "elements is given twice"),
    (["elements"], "a value is missing"),
    (["to=9,10"], "to is both 50.0 and varied"),
])
def test_wrong_values_are_named(texts, words):
    function = load_case("lee-frame")
    with pytest.raises(ValueError, match=words):
        variations("lee-frame", function, {"elements": 20, "degree": 2, "to": 50.0, "step": 0.02}, texts)


def test_values_are_read_as_options_are():
    """Dashes and underscores in names, numbers of each kind, truth, and parts of a value separated by spaces."""
    function = load_case("cylinder-panel")
    defaults = {name: parameter.default for name, parameter in signature(function).parameters.items()}
    assert variations("cylinder-panel", function, defaults, ["cells=10 6,16 8", "--ratio=2e2,3e2"]) == {
        "cells": [(10, 6), (16, 8)], "ratio": [200.0, 300.0]}
    assert study.label({"cells": (10, 6), "ratio": 2e-10, "file": "a/b.csv"}) == "cells=10x6,ratio=2e-10,file=a_b.csv"
    no_punch = {"no_punch": False, "friction": 0.0}
    found = variations("arch", lambda no_punch=False, friction=0.0: None, no_punch, ["no-punch=true,false"])
    assert found == {"no_punch": [True, False]}
    function = load_case("arch")
    defaults = {name: parameter.default for name, parameter in signature(function).parameters.items()}
    assert variations("arch", function, defaults, ["yield=30,40"]) == {"yield_stress": [30.0, 40.0]}
    with pytest.raises(ValueError, match="yield_stress is given twice"):
        variations("arch", function, defaults, ["yield=30,40", "yield-stress=50"])


def test_a_value_that_the_scene_refuses_stops_the_study_before_any_run(traced, tmp_path):
    with pytest.raises(ValueError, match="run elements=7: lee-frame: elements is 7"):
        trace_study(Study("lee-frame", {}, {"elements": [5, 7]}), tmp_path / "out")
    assert not traced and not (tmp_path / "out").exists()


def test_command(tmp_path):
    """Two runs at a time in processes of their own; one stops on its way and is named, the other is finished."""
    script = tmp_path / "mine.py"
    script.write_text(
        "from dataclasses import replace\n"
        "import sheetfx as fx\n"
        "from sheetfx.scenes.von_mises_truss import case as truss\n"
        "def stop(state):\n"
        "    if state.deflection > 0.3:\n"
        "        raise ArithmeticError('the wind has blown it away')\n"
        "    return False\n"
        "def case(rise: float = 1.0, windy: bool = False):\n"
        "    made = truss(rise)\n"
        "    return replace(made, events=[fx.Event('wind', stop)]) if windy else made\n")
    command = [sys.executable, "-m", "sheetfx", "study", str(script), "--rise", "0.5", "--vary", "windy=no,yes",
               "--jobs", "2", "-o", str(tmp_path / "out")]
    result = subprocess.run(command, capture_output=True, text=True, timeout=300, env=os.environ | {"COLUMNS": "120"})
    assert result.returncode == 1, result.stderr
    assert "windy=True: failed" in result.stdout and "the wind has blown it away" in result.stdout
    assert "2 runs, 1 failed" in result.stdout
    rows = table(tmp_path / "out" / "study.csv")
    assert [row["status"] for row in rows] == ["finished", "failed"]
    assert float(rows[0]["limit_load"]) == pytest.approx(limit_load(0.5), rel=1e-8)
    assert (tmp_path / "out" / "study.png").stat().st_size > 500
    summary = json.loads((tmp_path / "out" / "runs" / "windy=False" / "summary.json").read_text())
    assert summary["parameters"] == {"rise": 0.5, "windy": False}


@pytest.mark.parametrize(("words", "file", "columns"), [
    (["study", "von-mises-truss", "--vary", "rise=0.4,0.5"], "study.csv", ["rise", "status", "limit_load"]),
    pytest.param(["diagram", "star-dome", "--levels", "1", "--max-deflection", "3"], "diagram.csv", None,
                 marks=pytest.mark.slow)], ids=["study", "diagram"])
@pytest.mark.slow
def test_processes_of_mpirun_give_the_same_table(words, file, columns, tmp_path):
    for name, launcher in (("alone", []), ("mpirun", ["mpirun", "-n", "3"])):
        command = [*launcher, sys.executable, "-m", "sheetfx", *words, "-o", str(tmp_path / name)]
        result = subprocess.run(command, capture_output=True, text=True, timeout=300)
        assert result.returncode == 0, result.stderr
    found, alone = (table(tmp_path / name / file) for name in ("mpirun", "alone"))
    assert len(found) > 1 and [[row[c] for c in columns or row] for row in found] == [
        [row[c] for c in columns or row] for row in alone]
