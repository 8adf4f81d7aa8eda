"""The command line: what it suggests, refuses and prints; in this process, since a start takes seconds."""

from __future__ import annotations

import sys
import warnings

import numpy as np
import pytest

import sheetfx as fx
from sheetfx.continuation.state import CriticalPoint
from sheetfx.notices import warn
from sheetfx.show.progress import Progress


def test_what_is_printed_of_results_is_a_line():
    point = CriticalPoint("limit", 159.0, 12.3, 4, name="maximum")
    assert str(point) == "limit point (maximum) at load 159, deflection 12.3"
    assert repr(point).startswith("CriticalPoint(kind='limit'")
    mode = np.zeros(1000)
    for thing, words in ((fx.BucklingLoad(2.0, 20.0, 2.0, 0, 2, 1e-9, mode), "buckling at load 20 (load factor 2, "),
                         (fx.Vibration((2 * np.pi) ** 2, mode), "vibration with frequency 1")):
        assert str(thing).startswith(words) and "\n" not in str(thing) and len(str(thing)) < 120


def test_a_warning_shows_the_first_line_outside_the_package():
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        exec("def inner():\n    warn('here')", package := {"__name__": "sheetfx.somewhere", "warn": warn})
        package["inner"]()
    assert told[0].filename == __file__


def test_progress_off_a_terminal_is_a_line_by_time(tmp_path, capsys, monkeypatch):
    from types import SimpleNamespace

    def state(step):
        return SimpleNamespace(step=step, load=1.0, deflection=2.0, iterations=3, critical=(), contact_points=0,
                               unstable_modes=0, stage=0)

    now = 0.0
    monkeypatch.setattr("sheetfx.show.progress.time.perf_counter", lambda: now)
    with Progress("arch", tmp_path) as progress:
        for step in range(25):
            progress(state(step))
            now += 1.0
    steps = [line.split("step ")[1].split(",")[0] for line in capsys.readouterr().out.splitlines()]
    assert steps == ["10", "20", "24"], "every 10 s, and the last state"


@pytest.mark.parametrize(("words", "answer"), [
    (["run", "arhc"], "did you mean 'arch'?"),
    (["run", "lee_frame"], "did you mean 'lee-frame'?"),
    (["rnu", "arch"], "did you mean 'run'?"),
    (["run", "arch", "--element", "3"], "--elements"),
    (["run", "arch", "--elements", "3", "--elements", "4"], "option --elements is given twice; leave one out"),
    (["study", "arch", "--vary", "elemnts=3,4"], "no option 'elemnts'; did you mean 'elements'?"),
    (["map", "--traps", "a", "--traps", "b"], "option --traps is given twice; leave one out"),
    (["run", "arch", "--elements", "three"], "'--elements'"),
    (["run", "arch", "--elements"], "'--elements' requires an argument"),
    (["run", "arch", "again"], "again"),
    (["chart", "roof", "--repeat", "0"], "'--repeat'"),
    (["chart"], "; sheetfx chart --help says more"),
])
def test_wrong_words(command, words, answer):
    status, _, errors = command(*words)
    assert status == 2 and answer in errors
    assert errors.startswith("sheetfx: error: ") and errors.endswith("\n") and errors.count("\n") == 1


def test_chart_does_not_go_on_with_that_of_another_scene(command, tmp_path):
    (tmp_path / "runs.json").write_text('{"scene": "bend", "runs": {}}')
    status, _, errors = command("chart", "roof", "-o", tmp_path, "--resume")
    assert status == 2 and f"--resume: the chart in {tmp_path} is of bend, not of roof; choose another folder" in errors


def test_version_and_help(command):
    assert command("--version")[1] == f"sheetfx {fx.__version__}\n"
    helped = command("run", "--help")[1]
    assert "function `case`" in helped and "FOLDER/script.py" in helped
    assert command("--quiet", "run", "--list")[1] == ""


@pytest.mark.parametrize(("text", "answer"), [
    ("x = 1", "has no function `case`"),
    ("def case(", "cannot read the script"),
    ("import nowhere_to_be_found", "No module named 'nowhere_to_be_found' ("),
    ("def case(size=1.0): pass", "the parameter size has no annotation, so that its option has no type; write size: "
                                 "float = 1.0"),
    ("def case(*sizes): pass", "*sizes cannot be an option"),
    ("def case(**sizes): pass", "**sizes cannot be an option"),
    ("def case(size: dict = {}): pass", "the parameter size is annotated dict, which cannot be an option"),
    ("def case(size: float = 'a'): pass", "the default of size is 'a', but its annotation is float"),
    ("def case(): pass", "case returns None; return a sheetfx.Case"),
    ("from sheetfx.scenes.arch import case as a\ndef case(): return a(elements=8, no_punch=True).scene",
     "case returns a Scene; return fx.Case(scene)"),
    ("import beside_it\ndef case(): return beside_it.three", "case returns 3, an int; return a sheetfx.Case"),
])
def test_scripts_that_cannot_be_used(command, monkeypatch, tmp_path, text, answer):
    script = tmp_path / "my_own.py"
    script.write_text(text)
    (tmp_path / "beside_it.py").write_text("three = 3")
    monkeypatch.setattr(sys, "path", list(sys.path))
    status, _, errors = command("run", script, "-o", tmp_path / "out")
    assert status == 2 and str(script) in errors and answer in errors and "Traceback" not in errors


def test_completion_of_scenes_and_scripts(tmp_path, monkeypatch):
    from sheetfx.studies.suggesting import scripts

    monkeypatch.chdir(tmp_path)
    (tmp_path / "models").mkdir()
    (tmp_path / "models" / "panel.py").touch()
    assert scripts("mo") == ["models/"] and scripts("models/p") == ["models/panel.py"]
