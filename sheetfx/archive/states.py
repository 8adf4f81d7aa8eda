"""Files of the states of a run, a part of each state for each process."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from itertools import count
from pathlib import Path

import numpy as np

from ..continuation.state import ForeignState, State, write_arrays
from ..notices import warn
from .scattered import ScatteredState

STEP = 6 * "[0-9]"
PATTERNS = (f"states/{STEP}.*[0-9].npz", f"states/{STEP}.*[0-9].part", "states/origins*.npz", "states/origins*.part")
ASIDE = ".aside"


class StateFiles:
    """States of the run in a folder, as the processes of this run have them.

    A state's file says which run it belongs to, which step it is and how many processes have a part of it: one that is
    of another run or step, or cannot be read, ends what a run resumes from and is put aside. Files of origins say what
    the entries of the parts belong to, so that another number of processes can take them.
    """

    def __init__(self, folder: Path, comm):
        self._folder, self._comm, self._states = folder, comm, folder / "states"

    def save(self, state: State, run: str) -> None:
        """Keep this process's part of a state."""
        state.save(self._file(state.step, self._comm.rank), run, self._comm.size)

    def save_origins(self, origins: Mapping[str, np.ndarray]) -> None:
        """Keep what the entries of this process's parts belong to, see `System.origins`."""
        write_arrays(self._origins(self._comm.rank, self._comm.size), **origins)

    def have_origins(self, processes: int) -> bool:
        """Whether parts of so many processes can be taken by another number of them."""
        return all(self._origins(rank, processes).exists() for rank in range(processes))

    def whole(self, run: str) -> Iterator[State]:
        """States from the first on, up to one that is not there or not usable on this process."""
        for step in count():
            state = self._load(step, run)
            if not isinstance(state, State):
                return
            yield state

    def kept(self, run: str) -> int:
        """How many states all processes have kept, by their files alone; the last is looked into."""
        steps = next(step for step in count() if not self._file(step, 0).exists())
        while steps:
            first = self._read(steps - 1, 0, run)
            if not isinstance(first, str) and all(self._file(steps - 1, rank).exists() for rank in range(first[1])):
                break
            steps -= 1
        return steps

    def put_aside(self, first: int, run: str) -> None:
        """States from a step on go to a folder of their own, where there are any; none is deleted."""
        comm = self._comm
        later = sorted(f for f in self._states.glob(f"{STEP}.*[0-9].npz")
                       if int(f.name[:6]) >= first and int(f.name.split(".")[1]) % comm.size == comm.rank)
        if not any(comm.allgather(bool(later))):
            return
        wrong = self._load(first, run)
        found = list(filter(None, comm.allgather(wrong if isinstance(wrong, str) else "")))
        for file in later:
            aside = self._folder / ASIDE / file.name
            aside.parent.mkdir(exist_ok=True)
            os.replace(file, aside)
        if found and comm.rank == 0:
            warn(f"--resume: {found[0]}; the path goes on from {f'step {first - 1}' if first else 'its start'}"
                          f", and what came later is put aside in {self._folder / ASIDE}")

    def _load(self, step: int, run: str) -> State | str:
        """The state of a step, or the fault of its files."""
        own = self._read(step, self._comm.rank, run) if self._file(step, self._comm.rank).exists() else None
        first = own or self._read(step, 0, run)
        if isinstance(first, str):
            return first
        state, processes = first
        if processes in (0, self._comm.size):
            return state if own else f"{self._name(step, self._comm.rank)} is missing"
        if not self.have_origins(processes):
            return f"{self._name(step, 0)} is of {processes} processes, whose origins are missing,"
        parts = [self._read(step, rank, run) for rank in range(processes)]
        states = []
        for part in parts:
            if isinstance(part, str):
                return part
            states.append(part[0])
        origins = [dict(np.load(self._origins(rank, processes))) for rank in range(processes)]
        return ScatteredState.of(states, origins)

    def _read(self, step: int, rank: int, run: str) -> tuple[State, int] | str:
        """A process's part of a state and how many have one (0: an older version's), or its fault."""
        file, name = self._file(step, rank), self._name(step, rank)
        try:
            state, processes = State.load_part(file, run)
        except FileNotFoundError:
            return f"{name} is missing"
        except ForeignState:
            return f"{name} is of another run"
        except Exception:  # whatever NumPy finds in bytes that are no archive
            return f"{name} cannot be read"
        return (state, processes) if state.step == step else f"{name} is that of step {state.step}"

    def _file(self, step: int, rank: int) -> Path:
        return self._states / f"{step:06d}.{rank}.npz"

    def _name(self, step: int, rank: int) -> str:
        return str(self._file(step, rank).relative_to(self._folder))

    def _origins(self, rank: int, processes: int) -> Path:
        return self._states / f"origins{processes}.{rank}.npz"
