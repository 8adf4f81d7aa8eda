"""A run's folder: every converged state on disk at once, and what is read back from it.

The folder belongs to one run at a time. Its manifest lists what the program wrote there: a new run deletes that and
nothing else, and refuses a folder with other files. Hidden files are neither deleted nor refused.
"""

from __future__ import annotations

import csv
import fcntl
import fnmatch
import glob
import json
import os
import re
import shutil
import socket
from collections.abc import Callable, Iterable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from itertools import filterfalse, islice
from pathlib import Path

from .continuation.state import State

COLUMNS = ("step", "load", "deflection", "factor", "unstable", "load_rate", "iterations", "factorisations",
           "length", "contact_points", "penetration", "stage")
ATTRIBUTES = {"unstable": "unstable_modes"}  # columns that are named otherwise in a State
STEP = 6 * "[0-9]"
MANIFEST, LIST = "manifest.json", "written by sheetfx"
# On the manifest from the start, so that a run that is killed leaves no state that is not listed.
PATTERNS = (MANIFEST, "parameters.json", "path.csv", f"states/{STEP}.*[0-9].npz", f"states/{STEP}.*[0-9].part",
            "summary.json")
LOCK, UNFINISHED = ".lock", ".pictures.part"


def _files(folder: Path) -> Iterator[str]:
    """Names of all files in a folder and its subfolders but the hidden ones; links count as files."""
    for file in folder.rglob("*"):
        name = file.relative_to(folder)
        if (file.is_symlink() or not file.is_dir()) and not any(part.startswith(".") for part in name.parts):
            yield name.as_posix()


class Stopped(RuntimeError):
    """A run that something outside has stopped: says what is kept and how to go on."""


class Archive:
    """States and tables of one run.

    Each process keeps its own part of a state, so a run resumes on as many processes as it
    started with. Tables are written by process 0.

    Parameters
    ----------
    patterns : of names that the program writes beside those of a run, so that a new run deletes them
    """

    def __init__(self, folder: Path, comm, patterns: Iterable[str] = ()):
        self.folder, self.comm = Path(folder), comm
        self._patterns = {*PATTERNS, *patterns}
        self._states = self.folder / "states"

    @contextmanager
    def opened(self, parameters: dict, resume: bool) -> Iterator[list[State]]:
        """Keep other runs out of the folder for the time of a `with` block, which gets the states to go on from.

        Raises
        ------
        ValueError
            Where another run is in the folder, `clear` refuses it or, to resume, `check` does.
        """
        # Looked at before it is locked: a folder that is refused does not get the lock's file.
        if resume:
            self.check(parameters)
        else:
            self._on_process_0(self._refuse_other_files)
        with ExitStack() as stack:
            self._on_process_0(lambda: self._lock(stack))
            if resume:
                states = self.resume()
            else:
                self.clear(parameters)
                states = []
            yield states
            self.comm.barrier()

    def clear(self, parameters: dict) -> None:
        """Begin a new run in the folder: delete what an earlier one wrote.

        Raises
        ------
        ValueError
            Where the folder holds other files; then nothing is deleted.
        """
        self._on_process_0(lambda: self._clear(parameters | {"processes": self.comm.size}))

    def check(self, parameters: dict) -> None:
        """Refuse to resume a run that was started with other parameters."""
        file = self.folder / "parameters.json"
        if not file.exists():
            raise ValueError(f"--resume: {self.folder} holds no run; leave --resume out")
        wanted = json.loads(json.dumps(parameters | {"processes": self.comm.size}))
        for name, value in json.loads(file.read_text()).items():
            if wanted.get(name) != value:
                raise ValueError(f"--resume: the run in {self.folder} has {name} = {value}, not {wanted.get(name)}")

    @contextmanager
    def drawing(self) -> Iterator[Path]:
        """A folder to draw in; at the end of the `with` block its files move into the folder of the run.

        They are listed before they move, so that a run that is killed leaves no picture that is not listed.
        """
        unfinished = self.folder / UNFINISHED
        self._on_process_0(lambda: self._make_empty(unfinished))
        yield unfinished
        self.comm.barrier()
        self._on_process_0(lambda: self._move_from(unfinished))

    def write_json(self, name: str, content: dict) -> None:
        """Write a JSON file that appears complete or not at all."""
        part = self.folder / f".{name}.part"
        part.write_text(json.dumps(content, indent=2, default=float) + "\n")
        os.replace(part, self.folder / name)

    def __call__(self, state: State) -> None:
        """Keep a state."""
        state.save(self._file(state.step))
        self._tabulate(state)

    def states(self) -> list[State]:
        """All states that every process has kept, in order of their steps."""
        mine = sorted(int(f.name.split(".")[0]) for f in self._states.glob(f"{STEP}.{self.comm.rank}.npz"))
        count = min(self.comm.allgather(len(mine)))
        return [State.load_from(self._file(step)) for step in mine[:count]]

    def resume(self) -> list[State]:
        """States to go on from; the table is cut back to them."""
        self._on_process_0(lambda: self._list({*self._patterns, *self._listed()}))
        states = self.states()
        for state in states:
            self._tabulate(state)
        return states

    def _file(self, step: int) -> Path:
        return self._states / f"{step:06d}.{self.comm.rank}.npz"

    def _tabulate(self, state: State) -> None:
        """Add a line to the table, which begins anew at step 0."""
        if self.comm.rank == 0:
            with (self.folder / "path.csv").open("a" if state.step else "w", newline="") as stream:
                writer = csv.writer(stream)
                if state.step == 0:
                    writer.writerow(COLUMNS)
                writer.writerow([getattr(state, ATTRIBUTES.get(c, c)) for c in COLUMNS])

    def _on_process_0(self, action: Callable[[], object]) -> None:
        """Let process 0 act; what it refuses or the system denies it, every process raises."""
        refusal = None
        if self.comm.rank == 0:
            try:
                action()
            except (ValueError, OSError) as error:
                refusal = str(error)
        if refusal := self.comm.bcast(refusal):
            raise ValueError(refusal)

    def _listed(self) -> list[str]:
        """Patterns of the names on the manifest; none where the folder has no manifest of ours."""
        try:
            return json.loads((self.folder / MANIFEST).read_text())[LIST]
        except (FileNotFoundError, ValueError, KeyError, TypeError):
            return []

    def _list(self, patterns: Iterable[str]) -> None:
        self.write_json(MANIFEST, {LIST: sorted(patterns)})

    def _ours(self) -> Callable[[str], re.Match | None]:
        """Whether the program wrote a file of that name."""
        return re.compile("|".join(map(fnmatch.translate, self._listed()))).fullmatch

    def _refuse_other_files(self) -> None:
        """Refuse the folder where it holds files that the program did not write."""
        if self.folder.is_file():
            raise ValueError(f"{self.folder} is a file; choose a folder with -o")
        others = list(islice(filterfalse(self._ours(), _files(self.folder)), 4))
        if others:
            raise ValueError(f"{self.folder} holds files that no manifest of sheetfx lists: "
                             f"{', '.join(others[:3])}{' and others' if len(others) > 3 else ''}; "
                             "choose an empty folder with -o, or move or delete them")

    def _clear(self, parameters: dict) -> None:
        self._refuse_other_files()
        for name in list(filter(self._ours(), _files(self.folder))):
            if name != MANIFEST:  # which is replaced last, for a run that is killed before
                (self.folder / name).unlink()
                with suppress(OSError):  # not empty, as the folder of the manifest always is
                    os.removedirs((self.folder / name).parent)
        self._states.mkdir(parents=True, exist_ok=True)
        self._list(self._patterns)
        self.write_json("parameters.json", parameters)

    def _make_empty(self, unfinished: Path) -> None:
        if unfinished.exists():  # left by a run that was killed
            shutil.rmtree(unfinished)
        unfinished.mkdir()

    def _move_from(self, unfinished: Path) -> None:
        names, ours = list(_files(unfinished)), self._ours()
        for name in names:
            if (self.folder / name).exists() and not ours(name):
                raise ValueError(f"{self.folder}: {name} is not of this run, which draws a picture of that name; "
                                 "move it away and add --resume")
        self._list({*self._listed(), *map(glob.escape, names)})
        for name in names:
            (self.folder / name).parent.mkdir(parents=True, exist_ok=True)
            os.replace(unfinished / name, self.folder / name)
        shutil.rmtree(unfinished)

    def _lock(self, stack: ExitStack) -> None:
        """Hold the lock until the stack is closed; the system lets go of it where the process is killed."""
        self.folder.mkdir(parents=True, exist_ok=True)
        stream = stack.enter_context((self.folder / LOCK).open("a+"))
        try:
            fcntl.flock(stream, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            stream.seek(0)
            raise ValueError(f"{self.folder} is in use by {stream.read() or 'another run'}; wait for its end, "
                             "or choose another folder with -o") from None
        except OSError:  # a file system without locks, as some clusters have: no reason to refuse every run
            return
        stream.truncate(0)
        stream.write(f"process {os.getpid()} on {socket.gethostname()}")
        stream.flush()
