"""A run's folder: every converged state on disk at once, and its reading back.

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
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import ExitStack, contextmanager, suppress
from functools import cached_property
from io import StringIO
from itertools import filterfalse, islice
from pathlib import Path
from uuid import uuid4

import numpy as np

from ..continuation.state import State
from ..interrupts import HOW, tell
from .states import PATTERNS as STATES
from .states import StateFiles

COLUMNS = ("step", "load", "deflection", "factor", "unstable", "load_rate", "iterations", "factorisations",
           "length", "contact_points", "penetration", "stage")
ATTRIBUTES = {"unstable": "unstable_modes"}  # columns that are named otherwise in a State
MANIFEST, LIST, RUN = "manifest.json", "written by sheetfx", "run"
# On the manifest from the start, so that a run that is killed leaves no state that is not listed.
PATTERNS = (MANIFEST, "parameters.json", "path.csv", "summary.json", *STATES)
PARAMETERS = "parameters.json"
LOCK, UNFINISHED = ".lock", ".pictures.part"


def _files(folder: Path) -> Iterator[str]:
    """Names of all files in a folder and its subfolders but the hidden ones; links count as files."""
    for file in folder.rglob("*"):
        name = file.relative_to(folder)
        if (file.is_symlink() or not file.is_dir()) and not any(part.startswith(".") for part in name.parts):
            yield name.as_posix()


def _table(states: Iterable[State]) -> str:
    """The table of a path, with its head."""
    return ",".join(COLUMNS) + "\r\n" + _rows(states)


def _rows(states: Iterable[State]) -> str:
    text = StringIO(newline="")
    csv.writer(text).writerows([getattr(state, ATTRIBUTES.get(c, c)) for c in COLUMNS] for state in states)
    return text.getvalue()


def _reason(error: OSError) -> str:
    """What the system says, as a sentence."""
    return f"{error.strerror}: {error.filename}" if error.filename else error.strerror or str(error)


def write_whole(file: Path, text: str) -> None:
    """Write a text that appears complete or not at all."""
    part = file.with_name(f".{file.name}.part")
    try:
        part.write_text(text, newline="")
        os.replace(part, file)
    except OSError:
        part.unlink(missing_ok=True)
        raise


class Stopped(RuntimeError):
    """A run that the system has stopped, as a full disk does: says what stays and how to go on."""


class Interrupted(KeyboardInterrupt):
    """A run that its user has stopped: says what stays and how to go on."""


class Archive:
    """States and tables of one run.

    Each process keeps its own part of a state. Tables are written by process 0.

    Parameters
    ----------
    patterns : of names that the program writes beside a run's own, so that a new run deletes them
    count : says how much is kept, such as "2 of 4 runs"; None: it counts states
    """

    def __init__(self, folder: Path, comm, patterns: Iterable[str] = (), count: Callable[[], str] | None = None):
        self.folder, self.comm, self._count = Path(folder), comm, count or self._count_states
        self._patterns = {*PATTERNS, *patterns}
        self._states = StateFiles(self.folder, comm)

    @contextmanager
    def opened(self, parameters: dict, resume: bool) -> Iterator[list[State]]:
        """Keep other runs out of the folder for the time of a `with` block, which gets the states to go on from.

        To resume in a folder that holds no run begins one.

        Raises
        ------
        ValueError
            Where another run is in the folder, `clear` refuses it or, to resume, `check` does.
        Stopped
            Where the folder can no longer be written to.
        Interrupted
            Where the user stops the run.
        """
        with ExitStack() as stack:
            try:
                states = self._begin(parameters, resume, stack)
            except OSError as error:
                raise ValueError(f"{_reason(error)}; choose another folder with -o") from error
            tell(self._kept)
            try:
                yield states
            except OSError as error:
                raise Stopped(f"{_reason(error)}; {self._kept()}; {HOW}, once that is mended") from error
            except KeyboardInterrupt as error:
                raise Interrupted(f"interrupted; {self._kept()}; {HOW}") from error
            self.comm.barrier()

    def _begin(self, parameters: dict, resume: bool, stack: ExitStack) -> list[State]:
        # Looked at before it is locked: a folder that is refused does not get the lock's file.
        resume = resume and self.comm.bcast((self.folder / PARAMETERS).exists())
        if resume:
            self.check(parameters)
        else:
            self._on_process_0(self._refuse_other_files)
        self._on_process_0(lambda: self._lock(stack))
        if resume:
            return self.resume()
        self.clear(parameters)
        return []

    def _kept(self) -> str:
        count = self._count()
        return f"{count} {'is' if count.startswith('1 ') else 'are'} kept in {self.folder}"

    def _count_states(self) -> str:
        """Of all processes, by their files, since others may no longer answer."""
        count = self._states.kept(self._manifest().get(RUN, ""))
        return f"{count} state{'' if count == 1 else 's'}"

    def clear(self, parameters: dict) -> None:
        """Begin a new run in the folder: delete what an earlier one wrote.

        Raises
        ------
        ValueError
            Where the folder holds other files; then nothing is deleted.
        """
        self._on_process_0(lambda: self._clear(parameters | {"processes": self.comm.size}))
        self.__dict__.pop("_run", None)  # that of the run before

    def check(self, parameters: dict) -> None:
        """Refuse to resume a run that was started with other parameters."""
        file = self.folder / PARAMETERS
        wanted = json.loads(json.dumps(parameters | {"processes": self.comm.size}))
        for name, value in json.loads(file.read_text()).items():
            if wanted.get(name) != value and not (name == "processes" and self._states.have_origins(value)):
                remedy = f"start it with mpirun -n {value}" if name == "processes" else "give the same"
                raise ValueError(f"--resume: the run in {self.folder} has {name} = {value}, not {wanted.get(name)}; "
                                 f"{remedy}, or choose another folder with -o")

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
        self._write(name, json.dumps(content, indent=2, default=float) + "\n")

    def _write(self, name: str, text: str) -> None:
        write_whole(self.folder / name, text)

    def __call__(self, state: State) -> None:
        """Keep a state."""
        self._states.save(state, self._run)
        if self.comm.rank == 0:
            with (self.folder / "path.csv").open("a" if state.step else "w", newline="") as stream:
                stream.write(_rows([state]) if state.step else _table([state]))

    def keep_origins(self, origins: Mapping[str, np.ndarray]) -> None:
        """Keep what the entries of states belong to, so that a run resumes on another number of processes too."""
        self._states.save_origins(origins)

    def states(self) -> list[State]:
        """The states from the first on that every process has kept whole, in order of their steps."""
        _ = self._run  # told to all processes, of which some may have no state
        mine = list(self._states.whole(self._run))
        return mine[:min(self.comm.allgather(len(mine)))]

    def resume(self) -> list[State]:
        """States to go on from; the table is cut back to them, and files that are not whole, or later, put aside."""
        self._on_process_0(lambda: self._list({*self._patterns, *self._listed()}))
        states = self.states()
        self._states.put_aside(len(states), self._run)
        if states:
            self._on_process_0(lambda: self._write("path.csv", _table(states)))
        return states

    def _on_process_0(self, action: Callable[[], object]) -> None:
        """Let process 0 act; what it refuses or the system denies it, every process raises."""
        refusal = None
        if self.comm.rank == 0:
            try:
                action()
            except (ValueError, OSError) as error:
                refusal = error
        if refusal := self.comm.bcast(refusal):
            raise refusal

    def _listed(self) -> list[str]:
        """Patterns of the names on the manifest; none where the folder has no manifest of ours."""
        return self._manifest().get(LIST, [])

    def _manifest(self) -> dict:
        try:
            found = json.loads((self.folder / MANIFEST).read_text())
        except (FileNotFoundError, ValueError):
            return {}
        return found if isinstance(found, dict) else {}

    @cached_property
    def _run(self) -> str:
        """What states of this run are told by; "" for a run of an older version."""
        return self.comm.bcast(self._manifest().get(RUN, ""))

    def _list(self, patterns: Iterable[str], run: str | None = None) -> None:
        self.write_json(MANIFEST, {LIST: sorted(patterns), RUN: self._manifest().get(RUN, "") if run is None else run})

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
        (self.folder / "states").mkdir(parents=True, exist_ok=True)
        self._list(self._patterns, uuid4().hex)
        self.write_json(PARAMETERS, parameters)

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
