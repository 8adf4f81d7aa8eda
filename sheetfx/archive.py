"""A run's folder: every converged state on disk at once, and what is read back from it."""

from __future__ import annotations

import csv
import json
import os
from pathlib import Path

from .continuation.state import State

COLUMNS = ("step", "load", "deflection", "factor", "unstable", "load_rate", "iterations", "factorisations",
           "length", "contact_points", "penetration")
FILES = ("path.csv", "buckling.csv", "summary.json", "*.png", "paraview/path*", "paraview/modes*",
         "fall*/snap.json", "fall*/before.*.npz", "fall*/after.*.npz")


class Archive:
    """States and tables of one run.

    Each process keeps its own part of a state, so a run resumes on as many processes as it
    started with. Tables are written by process 0.
    """

    def __init__(self, folder: Path, comm):
        self.folder, self.comm = Path(folder), comm
        self._states = self.folder / "states"
        if comm.rank == 0:
            self._states.mkdir(parents=True, exist_ok=True)
        comm.barrier()

    def clear(self, parameters: dict) -> None:
        """Begin a new run in the folder: remove the files of an earlier one."""
        if self.comm.rank == 0:
            for file in self._states.glob("*.npz"):
                file.unlink()
            for pattern in FILES:
                for file in self.folder.glob(pattern):
                    file.unlink()
            for fall in self.folder.glob("fall*"):
                if fall.is_dir() and not any(fall.iterdir()):
                    fall.rmdir()
            self.write_json("parameters.json", parameters | {"processes": self.comm.size})
        self.comm.barrier()

    def check(self, parameters: dict) -> None:
        """Refuse to resume a run that was started with other parameters."""
        file = self.folder / "parameters.json"
        if not file.exists():
            raise ValueError(f"--resume: {self.folder} holds no run; leave --resume out")
        wanted = json.loads(json.dumps(parameters | {"processes": self.comm.size}))
        for name, value in json.loads(file.read_text()).items():
            if wanted.get(name) != value:
                raise ValueError(f"--resume: the run in {self.folder} has {name} = {value}, not {wanted.get(name)}")

    def write_json(self, name: str, content: dict) -> None:
        """Write a JSON file that appears complete or not at all."""
        part = self.folder / (name + ".part")
        part.write_text(json.dumps(content, indent=2, default=float) + "\n")
        os.replace(part, self.folder / name)

    def __call__(self, state: State) -> None:
        """Keep a state."""
        state.save(self._file(state.step))
        self._tabulate(state)

    def _tabulate(self, state: State) -> None:
        """Add a line to the table, which begins anew at step 0."""
        if self.comm.rank == 0:
            with (self.folder / "path.csv").open("a" if state.step else "w", newline="") as stream:
                writer = csv.writer(stream)
                if state.step == 0:
                    writer.writerow(COLUMNS)
                writer.writerow([getattr(state, c) for c in COLUMNS])

    def _file(self, step: int) -> Path:
        return self._states / f"{step:06d}.{self.comm.rank}.npz"

    def states(self) -> list[State]:
        """All states that every process has kept, in order of their steps."""
        mine = sorted(int(f.name.split(".")[0]) for f in self._states.glob(f"*.{self.comm.rank}.npz"))
        count = min(self.comm.allgather(len(mine)))
        return [State.load_from(self._file(step)) for step in mine[:count]]

    def resume(self) -> list[State]:
        """States to go on from; the table is cut back to them."""
        states = self.states()
        for state in states:
            self._tabulate(state)
        return states
