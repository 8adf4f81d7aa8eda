"""Failure map: methods of path following against traps, each cell in a process of its own."""

from __future__ import annotations

import csv
import json
import os
import subprocess
import sys
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor, as_completed
from dataclasses import asdict, dataclass, fields
from io import StringIO
from pathlib import Path as Folder

from mpi4py import MPI

from sheetfx.archive.folder import Archive, write_whole
from sheetfx.continuation.state import CriticalPoint
from sheetfx.interrupts import call
from sheetfx.path import Path, PathFailure, Until
from sheetfx.studies.chart import ONE_THREAD

from .judgement import CRASHED, STALLED, Judge, Trail, place
from .methods import METHODS, applies, references
from .traps import TRAPS, Trap

REFERENCE = "reference"


@dataclass(frozen=True)
class Cell:
    """What became of a method on a trap.

    Attributes
    ----------
    outcome : one of judgement.OUTCOMES
    reason : sentence; "" where the method passed
    cpu_seconds : of the path; the limit where it was reached
    factorisations : of all steps, failed tries and the search for critical points included
    """

    trap: str
    method: str
    outcome: str
    reason: str
    cpu_seconds: float
    factorisations: int


def choose(kind: str, names: str | None, known: Iterable[str]) -> list[str]:
    """Names from a list separated by commas; None: all.

    Raises
    ------
    ValueError
        Where a name is not known.
    """
    chosen = list(known) if names is None else names.split(",")
    for name in chosen:
        if name not in known:
            raise ValueError(f"map: no {kind} {name!r}; choose from {', '.join(known)}")
    return chosen


def failure_map(traps: Sequence[str], methods: Sequence[str], folder: Folder, limit: float,
                say: Callable[[Cell], None] = lambda cell: None, begin: Callable[[str, str], None] = lambda *_: None,
                done: Sequence[Cell] = ()) -> list[Cell]:
    """Trace every trap with every method that applies to it.

    Parameters
    ----------
    folder : gets a folder for each path with its states and path.csv
    limit : seconds that a path may take
    say : called with each cell, and with the cells of the reference paths
    begin : called with trap and method of each path that begins
    done : cells of an interrupted map, which are not traced again
    """
    if MPI.COMM_WORLD.size > 1:
        raise ValueError(f"map: {MPI.COMM_WORLD.size} MPI processes, but the map starts processes of its own; "
                         "leave mpirun out")
    with ThreadPoolExecutor(len(os.sched_getaffinity(0))) as pool:
        cases, known = {trap: TRAPS[trap].case() for trap in traps}, {(cell.trap, cell.method) for cell in done}
        pairs = [(trap, method) for trap, case in cases.items() for method in methods
                 if applies(method, case) and (trap, method) not in known]
        concerned = [trap for trap in traps if trap in {trap for trap, _ in pairs}]
        list(_ended(pool, [(trap, REFERENCE, folder, limit) for trap in concerned], say, begin))
        cells = list(_ended(pool, [(*pair, folder, limit) for pair in pairs], say, begin))
    cells += [cell for cell in done if cell.trap in traps and cell.method in methods]
    return sorted(cells, key=lambda cell: (traps.index(cell.trap), methods.index(cell.method)))


def _ended(pool: ThreadPoolExecutor, tasks: Sequence[tuple], say, begin) -> Iterator[Cell]:
    """Cells as they come."""
    def traced(*task) -> Cell:
        begin(*task[:2])
        return _process(*task)

    for future in as_completed([pool.submit(traced, *task) for task in tasks]):
        say(cell := future.result())
        yield cell


def _process(trap: str, method: str, folder: Folder, limit: float) -> Cell:
    """A cell traced in a process of its own, which is given some time for its last step."""
    command = [sys.executable, "-m", "failure_map.cells", trap, method, str(folder), str(limit)]
    environment = os.environ | ONE_THREAD | {"PYTHONPATH": os.pathsep.join(sys.path)}
    try:
        process = call(command, environment, timeout=1.5 * limit + 60)
    except subprocess.TimeoutExpired:
        return Cell(trap, method, STALLED, f"does not return from a step within {limit:g} s", limit, 0)
    if process.returncode:
        lines = process.stderr.strip().splitlines()
        return Cell(trap, method, CRASHED, lines[-1] if lines else f"exit status {process.returncode}", 0.0, 0)
    return Cell(**json.loads(process.stdout.splitlines()[-1]))


def trace(trap: Trap, method: str, folder: Folder, limit: float) -> Cell:
    """Trace a trap with a method in this process, and judge its path by its points and the reference in the folder.

    A trap whose reference path does not reach its end has none.
    """
    home = Folder(folder) / trap.name
    judge = Judge(trap.points, None)
    if method != REFERENCE and (states := Archive(home / REFERENCE, MPI.COMM_SELF).states()):
        judge = Judge(trap.points, Trail(states))
    archive = Archive(home / method, MPI.COMM_SELF)
    for case in references(trap.case()) if method == REFERENCE else [METHODS[method](trap.case())]:
        archive.clear({})
        path = Path(case.scene, case.control, case.until, mixed_points=case.mixed_points)
        path.subscribe(archive)
        outcome, reason = _follow(path, limit, judge)
        if outcome != STALLED:
            break
    if method == REFERENCE and outcome == STALLED:
        archive.clear({})
    return Cell(trap.name, method, outcome, reason, path.clock.seconds["path"], path.tracer.total_factorisations)


def _follow(path: Path, limit: float, judge: Judge) -> tuple[str, str]:
    """Outcome and reason of a path."""
    points, state = [], path.tracer.state
    try:
        for state in path:
            points += state.critical
            if strayed := judge.watch(state):
                return strayed
            if path.clock.seconds["path"] > limit:
                return STALLED, f"is still at {place(state)} after {limit:g} s"
    except PathFailure as failure:
        return STALLED, f"stops at {place(state)}, {failure.cause}"
    if path.message.endswith("steps taken"):
        return STALLED, f"is still at {place(state)} after {path.message.replace(' taken', '')}"
    return judge.conclude([point for point in points if within(path.until, point)])


def within(until: Until, point: CriticalPoint) -> bool:
    """Whether a point lies before the end of the path, which the last step passes."""
    bounds = (until.deflection, point.deflection), (until.load, point.load)
    return all(bound is None or abs(value) <= bound for bound, value in bounds)


def write_map(cells: Sequence[Cell], file: Folder) -> None:
    """Write one line for each cell."""
    text = StringIO(newline="")
    writer = csv.DictWriter(text, [f.name for f in fields(Cell)])
    writer.writeheader()
    writer.writerows(asdict(cell) for cell in cells)
    write_whole(Folder(file), text.getvalue())


def read_map(file: Folder) -> list[Cell]:
    """Cells that `write_map` has written; none where there is no file."""
    if not Folder(file).exists():
        return []
    with Folder(file).open(newline="") as stream:
        return [Cell(**row | {"cpu_seconds": float(row["cpu_seconds"]), "factorisations": int(row["factorisations"])})
                for row in csv.DictReader(stream)]


if __name__ == "__main__":
    trap, method, folder, limit = sys.argv[1:]
    print(json.dumps(asdict(trace(TRAPS[trap], method, Folder(folder), float(limit)))))
