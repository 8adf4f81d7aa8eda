"""A study: a scene traced with every combination of the values of some of its options, several runs at a time.

Each run has a process and a folder of its own, which is that of `sheetfx run` with the same parameters but for the
pictures. A run that fails is named and leaves the others alone.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Executor, as_completed
from dataclasses import dataclass, field
from functools import cached_property
from itertools import product
from pathlib import Path as Folder
from typing import Any

from mpi4py import MPI

from ..archive.folder import Archive
from ..continuation.state import CriticalPoint, State
from ..interrupts import call
from ..scenes import load_case
from .pool import alone, pool

FINISHED, STOPPED, FAILED = "finished", "stopped", "failed"


@dataclass(frozen=True)
class Study:
    """The varied options and their scene.

    Attributes
    ----------
    scene : name or script
    fixed : parameters of its function that are the same in all runs
    varied : names of parameters and the values that each takes
    """

    scene: str
    fixed: dict[str, Any]
    varied: dict[str, list[Any]]

    def runs(self, folder: Folder) -> list[Run]:
        """All combinations, the values of the last name changing fastest, with their places below a folder."""
        combinations = (dict(zip(self.varied, values, strict=True)) for values in product(*self.varied.values()))
        return [Run(chosen, Folder(folder) / "runs" / label(chosen)) for chosen in combinations]


@dataclass
class Run:
    """One combination of values.

    Attributes
    ----------
    chosen : value of each varied parameter
    home : folder
    reason : why it failed; "" where it left a summary
    """

    chosen: dict[str, Any]
    home: Folder
    reason: str = field(default="", compare=False)

    @property
    def name(self) -> str:
        return self.home.name

    @cached_property
    def summary(self) -> dict[str, Any]:
        """What the run wrote at its end; empty where it failed."""
        return {} if self.reason else json.loads((self.home / "summary.json").read_text())

    @property
    def status(self) -> str:
        return self.summary.get("status", FAILED)

    @property
    def message(self) -> str:
        """Why it ended."""
        return self.reason or self.summary["message"]

    @cached_property
    def states(self) -> list[State]:
        """States of the last load stage that were kept, also by a run that failed."""
        states = Archive(self.home, MPI.COMM_SELF).states()
        return [state for state in states if state.stage == states[-1].stage]

    @property
    def points(self) -> list[CriticalPoint]:
        """Its critical points but for events."""
        return [point for state in self.states for point in state.critical if point.kind != "event"]

    @property
    def limit(self) -> CriticalPoint | None:
        """Its first limit point."""
        return next((point for point in self.points if point.kind == "limit"), None)

    @property
    def finished(self) -> bool:
        """Whether it ended in this process or an earlier one; one that was stopped on its way did not."""
        file = self.home / "summary.json"
        return file.exists() and json.loads(file.read_text())["status"] == FINISHED


def label(chosen: dict[str, Any]) -> str:
    """Values by name, fit for a folder."""
    return ",".join(f"{name}={written(value)}".replace("/", "_") for name, value in chosen.items())


def written(value: Any) -> str:
    """A value as an option is written."""
    if isinstance(value, float):
        return f"{value:.12g}"
    return "x".join(map(written, value)) if isinstance(value, list | tuple) else str(value)


def trace_study(study: Study, folder: Folder, jobs: int = 1, resume: bool = False, pictures: bool = False,
                say: Callable[[Run], None] = lambda run: None) -> list[Run]:
    """Trace all runs of a study.

    Parameters
    ----------
    folder : gets a folder `runs` with one for each run; to resume, finished runs are not traced again, interrupted ones
        go on where they were, and those that are new or failed begin
    jobs : runs at a time, each on one thread; under mpirun one on each further process
    pictures : whether each run draws the pictures of its scene
    say : called with each run that has ended

    Returns
    -------
    runs; on process 0 with how they have ended

    Raises
    ------
    ValueError
        Where a scene cannot be made with some of the values, or the folder holds files of others or another study; then
        nothing has run.
    """
    runs = study.runs(folder)
    for run in runs:
        try:
            load_case(study.scene)(**study.fixed | run.chosen)
        except ValueError as error:
            raise ValueError(f"study, run {run.name}: {error}") from None
    archive = Archive(folder, MPI.COMM_SELF, ("runs/*", "study.csv", "critical_points.csv", "study.png"),
                      lambda: f"{sum(run.finished for run in runs)} of {len(runs)} runs")
    with pool(jobs) as executor:
        if executor:
            with archive.opened({"command": "study", "scene": study.scene} | study.fixed, resume):
                for run in _ended(executor, study, [run for run in runs if not run.finished], pictures):
                    say(run)
    return runs


def _ended(executor: Executor, study: Study, runs: Sequence[Run], pictures: bool) -> Iterator[Run]:
    """Runs as they end; where one looks no further, those that wait are called off."""
    futures = {executor.submit(_process, _task(study, run, pictures)): run for run in runs}
    try:
        for future in as_completed(futures):
            futures[future].reason = future.result()
            yield futures[future]
    finally:
        executor.shutdown(wait=False, cancel_futures=True)


def _task(study: Study, run: Run, pictures: bool) -> dict[str, Any]:
    """What `study_run.follow` takes."""
    return {"scene": study.scene, "parameters": study.fixed | run.chosen, "folder": str(run.home),
            "resume": (run.home / "parameters.json").exists(), "pictures": pictures}


def _process(task: dict[str, Any]) -> str:
    """Do a run by a process of its own, and return why it fails."""
    command = [sys.executable, "-m", "sheetfx.studies.study_run", json.dumps(task)]
    process = call(command, alone())
    lines = process.stderr.strip().splitlines() or [f"exit status {process.returncode}"]
    return lines[-1] if process.returncode else ""
