"""Ctrl-C: one line on what is kept, status 130, and the same path when resumed."""

from __future__ import annotations

import csv
import os
import random
import re
import signal
import subprocess
import sys
import textwrap
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from mpi4py import MPI

import sheetfx as fx
from sheetfx.archive.folder import Archive, Interrupted
from sheetfx.case import run
from sheetfx.continuation.corrector import BorderedNewton
from sheetfx.scenes import load_case

LINE = re.compile(r"sheetfx: interrupted; (.+ (?:is|are) kept in .+|nothing new is kept, and the folder is as it was); "
                  r"go on with --resume\n")
NOW = "os.kill(os.getpid(), signal.SIGINT)"
RUN = ["run", "von-mises-truss"]


def sheetfx(*words, before: str = "", cwd=None) -> subprocess.CompletedProcess:
    """The command in a process of its own, after some lines of Python."""
    code = "import os, signal, sys\nfrom sheetfx.__main__ import main\n" + textwrap.dedent(before) + "\nmain()\n"
    return subprocess.run([sys.executable, "-c", code, *map(str, words)], cwd=cwd, capture_output=True, text=True,
                          timeout=120)


def at_call(function: str, number: int) -> str:
    """Lines that interrupt at a call of a method `module:Class.name`."""
    module, name = function.split(":")
    owner, method = name.split(".")
    return f"""
        from {module} import {owner}
        inner, calls = {owner}.{method}, []
        def outer(*arguments, **options):
            calls.append(1)
            if len(calls) == {number}:
                {NOW}
            return inner(*arguments, **options)
        {owner}.{method} = outer
        """


def states(folder) -> np.ndarray:
    return np.array([(s.step, s.load, s.deflection) for s in Archive(folder, MPI.COMM_SELF).states()])


MOMENTS = [  # and the states that are kept then; -1: all, None: those of earlier
    (NOW, None), (at_call("sheetfx.path:Path.__init__", 1), 0),
    (at_call("sheetfx.continuation.corrector:BorderedNewton._evaluate", 20), 3),
    (at_call("sheetfx.archive.folder:Archive.drawing", 1), -1),
]


@pytest.mark.slow
def test_interrupted_again_and_again(tmp_path):
    """At start-up, before the path, within PETSc and as pictures are drawn; twice each, as impatient users do."""
    run(replace(load_case("von-mises-truss")(), pictures=()), "truss", {}, tmp_path / "whole", resume=False)
    whole, folder = states(tmp_path / "whole"), tmp_path / "run"
    for moment, kept in MOMENTS:
        result = sheetfx(*RUN, "-o", folder, "--resume", before=moment.replace(NOW, f"{NOW}; {NOW}"))
        assert result.returncode == 130, result.stderr
        assert LINE.fullmatch(result.stderr), result.stderr
        if kept is not None:
            found = len(states(folder))
            assert f" {found} state" in result.stderr
            assert kept <= found < len(whole) if kept >= 0 else found == len(whole)
    assert sheetfx(*RUN, "-o", folder, "--resume", "--no-pictures").returncode == 0
    np.testing.assert_allclose(states(folder), whole, rtol=1e-9, atol=1e-12)


def test_interrupt_in_a_script(tmp_path, monkeypatch):
    """It is Python's, not PETSc's, though it has been raised in a function that PETSc calls."""
    def interrupt(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr(BorderedNewton, "_evaluate", interrupt)
    with pytest.raises(KeyboardInterrupt):
        fx.trace(load_case("von-mises-truss")())
    with pytest.raises(Interrupted, match="interrupted; 1 state is kept in .*; go on with --resume"):
        run(load_case("von-mises-truss")(), "truss", {}, tmp_path, resume=False)


def test_an_error_that_frees_meshes_ends_the_program():
    """Meshes that are temporaries of the expression in which it is raised: the program does not hang at its end."""
    ended = subprocess.run([sys.executable, "-c", """if True:
        import sheetfx as fx
        from helpers import straight
        def measured():
            mesh = straight(2)
            assert mesh.measure
            return mesh
        fx.Scene([fx.Bar(measured(), fx.Rectangle(1.0, 1.0), fx.Elastic(1.0))], [], [],
                 fx.Monitor(measured(), "nowhere", "x"))
        """], capture_output=True, text=True, timeout=100, env=os.environ | {"PYTHONPATH": str(Path(__file__).parent)})
    assert ended.returncode == 1 and "nowhere" in ended.stderr.splitlines()[-1], ended.stderr


def test_started_processes_end_with_the_command(tmp_path):
    """Those that they have started in turn, too."""
    pids, code = tmp_path / "pids", "import subprocess, sys, time; subprocess.run(['sh', '-c', sys.argv[1]])"
    started = subprocess.Popen([sys.executable, "-c", f"""if True:
        import os, sys
        from concurrent.futures import ThreadPoolExecutor
        from sheetfx.interrupts import call, own
        own()
        with ThreadPoolExecutor() as pool:
            pool.submit(call, [sys.executable, "-c", {code!r}, "echo $$ $PPID > {pids}; sleep 100"], os.environ)
        """], stderr=subprocess.PIPE, text=True)
    while not (pids.exists() and pids.read_text().endswith("\n")):
        time.sleep(0.01)
    started.send_signal(signal.SIGINT)
    assert LINE.fullmatch(started.communicate(timeout=20)[1]) and started.returncode == 130
    end = time.monotonic() + 20
    while living := [pid for pid in pids.read_text().split() if lives(pid)]:
        assert time.monotonic() < end, f"{living} live on"
        time.sleep(0.05)


def lives(pid: str) -> bool:
    try:
        return ") Z " not in Path("/proc", pid, "stat").read_text()
    except (FileNotFoundError, ProcessLookupError):
        return False


def outcome(command: str, folder: Path) -> object:
    """What a command has found; a chart's errors, since its times differ."""
    if command == "run":
        return states(folder).tolist()
    if command == "study":
        return [states(home).tolist() for home in sorted((folder / "runs").iterdir())]
    if command == "diagram":
        return [[row[c] for c in ("branch", "step", "load", "deflection")] for row in rows(folder / "diagram.csv")]
    if command == "map":
        return [[row["trap"], row["method"], row["outcome"]] for row in rows(folder / "map.csv")]
    return [[row["method"], row["label"], row["error_percent"], row["runs"]] for row in rows(folder / "chart.csv")]


CHARTED = """
from sheetfx.scenes.von_mises_truss import case as truss

REFERENCE, CHART = {"limit_load": 0.5}, [{"rise": 1.0}, {"rise": 2.0}]


def case(rise: float = 3.0):
    return truss(rise=rise)
"""


def rows(file: Path) -> list[dict[str, str]]:
    with file.open() as stream:
        return list(csv.DictReader(stream))


@pytest.mark.slow
@pytest.mark.parametrize("processes, command, words", [
    (1, "run", ["lee-frame"]),
    (2, "run", ["lee-frame"]),
    (1, "study", ["von-mises-truss", "--vary", "rise=1,2,3"]),
    (1, "diagram", ["von-mises-truss", "--levels", "0"]),
    (1, "chart", ["truss.py", "--no-peers", "--repeat", "1"]),
    (1, "map", ["--traps", "lee-frame", "--methods", "default,load"]),
])
def test_random_moments(processes, command, words, tmp_path):
    """Four interrupts, by the terminal to all processes or to one, then the same as without."""
    (tmp_path / "truss.py").write_text(CHARTED)
    words = [str(tmp_path / word) if word == "truss.py" else word for word in words]
    mpi = ["mpirun", "-n", str(processes)] if processes > 1 else []
    line = [*mpi, sys.executable, "-m", "sheetfx", command, *words]
    subprocess.run([*line, "-o", tmp_path / "warm"], check=True, capture_output=True)
    began = time.perf_counter()
    subprocess.run([*line, "-o", tmp_path / "whole"], check=True, capture_output=True)
    lasts, chance = time.perf_counter() - began, random.Random(f"{command} {processes}")
    for number in range(4):
        started = subprocess.Popen([*line, "-o", tmp_path / "parts", "--resume"], stdout=subprocess.PIPE,
                                   stderr=subprocess.PIPE, text=True, start_new_session=True)
        moment = chance.uniform(0.1, 0.8) * lasts
        try:
            started.communicate(timeout=moment)
            continue  # it has ended before
        except subprocess.TimeoutExpired:
            (os.killpg if number % 2 else os.kill)(started.pid, signal.SIGINT)
        began = time.perf_counter()
        _, said = started.communicate(timeout=60)
        if started.returncode == 0:
            continue  # all was written, and only the process had not ended
        print(f"\n{command} on {processes}: at {moment:.1f} s of {lasts:.1f} s, status {started.returncode} after "
              f"{time.perf_counter() - began:.2f} s: {said}", end="")
        assert LINE.fullmatch(said), said
        assert started.returncode == (1 if mpi else 130)  # mpirun has a status of its own
    subprocess.run([*line, "-o", tmp_path / "parts", "--resume"], check=True, capture_output=True)
    assert str(outcome(command, tmp_path / "parts")) == str(outcome(command, tmp_path / "whole"))
