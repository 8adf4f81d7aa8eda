"""The command line: what it suggests, refuses and prints; in this process, since a start takes seconds."""

from __future__ import annotations

import warnings

import numpy as np

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
