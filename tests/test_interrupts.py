"""Ctrl-C: one line on what is kept, status 130, and the same path when resumed."""

from __future__ import annotations

import os
import re
import signal
import subprocess
import sys
import textwrap
import time

import numpy as np
import pytest
from mpi4py import MPI

import sheetfx as fx
from sheetfx.archive import Archive, Interrupted
from sheetfx.case import run
from sheetfx.continuation.arclength import PathStep
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


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    folder = tmp_path_factory.mktemp("whole")
    assert sheetfx(*RUN, "-o", folder).returncode == 0
    return states(folder)


@pytest.mark.parametrize("moment, kept", [
    (NOW, None),
    (at_call("sheetfx.path:Path.__init__", 1), 0),
    (at_call("sheetfx.continuation.arclength:PathStep._evaluate", 1), 1),
    (at_call("sheetfx.continuation.arclength:PathStep._evaluate", 20), 5),
    (at_call("sheetfx.archive:Archive.drawing", 1), -1),
    (at_call("sheetfx.archive:Archive.write_json", 3), -1),
], ids=["start-up", "before the path", "first step", "residual", "pictures", "summary"])
def test_interrupted_at(moment, kept, whole, tmp_path):
    """Twice, as impatient users do; the residual is evaluated within PETSc."""
    result = sheetfx(*RUN, "-o", "run", before=moment.replace(NOW, f"{NOW}; {NOW}"), cwd=tmp_path)
    assert result.returncode == 130, result.stderr
    assert LINE.fullmatch(result.stderr), result.stderr
    if kept is not None:
        found = len(states(tmp_path / "run"))
        assert f"{found} state" in result.stderr
        assert found == {-1: len(whole)}.get(kept, found) and (found > 0) == (kept != 0)
    resumed = sheetfx(*RUN, "-o", "run", "--resume", cwd=tmp_path)
    assert resumed.returncode == 0, resumed.stderr
    np.testing.assert_allclose(states(tmp_path / "run"), whole, rtol=1e-9, atol=1e-12)


def test_interrupt_in_a_script(tmp_path, monkeypatch):
    """It is Python's, not PETSc's, though it has been raised in a function that PETSc calls."""
    def interrupt(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr(PathStep, "_evaluate", interrupt)
    with pytest.raises(KeyboardInterrupt):
        fx.trace(load_case("von-mises-truss")())
    with pytest.raises(Interrupted, match="interrupted; 1 state is kept in .*; go on with --resume"):
        run(load_case("von-mises-truss")(), "truss", {}, tmp_path, resume=False)


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
    for pid in pids.read_text().split():
        with pytest.raises(OSError):
            os.kill(int(pid), 0)


def test_resume_begins_where_nothing_is_kept(tmp_path):
    assert sheetfx("study", "von-mises-truss", "--vary", "rise=1,3", "-o", "new", "--resume",
                   cwd=tmp_path).returncode == 0
