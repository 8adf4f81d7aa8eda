"""The bench: golden figures, and which structure needs which constant or guard of the path follower.

    docker/run python3 tests/golden/bench.py count               rows by room
    docker/run python3 tests/golden/bench.py figures             golden figures, figures.json
    docker/run python3 tests/golden/bench.py table --minutes 120 trials, trials.jsonl, and the table, table.csv

A trial that is there is not run again; `--again` begins anew. README.md beside this file has more.
"""

from __future__ import annotations

import argparse
import csv
import functools
import json
import multiprocessing
import os
import sys
import time
from collections import Counter, defaultdict
from collections.abc import Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import ExitStack
from dataclasses import asdict
from math import exp, inf, log
from pathlib import Path

import moved
import rows
from rows import PACKAGE, Row

HERE = Path(__file__).parent
FIGURES, WATCHED = HERE / "figures.json", HERE / "watched.json"
TRIALS, TABLE = HERE / "trials.jsonl", HERE / "table.csv"
FACTORS = 2.0, 0.5, 4.0, 0.25, 10.0, 0.1  # tried in this order, until an outcome changes
OVERRUN = 5.0  # times its CPU time, after which a trial's path is ended
LEAST = 1e-6  # relative change of a load that is an outcome's
COLUMNS = "name", "kind", "file", "needed_by", "margin"


def figures(which: str, jobs: int, again: bool) -> dict:
    """Golden outcomes of all structures, each with the change of its loads by steps of half the length."""
    kept = {} if again or not FIGURES.exists() else json.loads(FIGURES.read_text())
    from structures import names

    wanted = [name for name in names(which) if name not in kept]
    for name, found in spread(golden, [(name,) for name in wanted], jobs):
        kept[name[0]] = found
        write_json(FIGURES, kept)
    return kept


def golden(name: str) -> dict:
    from structures import outcome

    outcome(name)  # compiles
    found, halved = outcome(name), outcome(name, shorter=0.5)
    return asdict(found) | {"accuracy": accuracy(found, halved)}


def accuracy(one, other) -> float | None:
    """Largest change of a critical load over the largest load; None: the points are others."""
    if [(p.kind, p.multiplicity) for p in one.points] != [(p.kind, p.multiplicity) for p in other.points]:
        return None
    largest = max((abs(p.load) for p in one.points), default=1.0) or 1.0
    return max((abs(p.load - q.load) / largest for p, q in zip(one.points, other.points, strict=True)), default=0.0)


def watch(name: str) -> dict:
    """Follow a path with constants that keep how near their comparisons came to another outcome.

    Returns
    -------
    "margins": row -> factor, "lines": file -> lines of the source that are reached, "same": whether the outcome is
    """
    from structures import difference, outcome

    golden_one, reached = outcome(name), defaultdict(set)
    seen: dict[str, dict] = {}
    with ExitStack() as stack, reaching(reached):
        for row in watchable():
            seen[row.key] = {}
            moved._set(row, lambda value, kept=seen[row.key]: moved.Watched(value, kept)
                       if isinstance(value, float) else value, stack)
        found = outcome(name, within=20 * OVERRUN * max(golden_one.seconds, 1.0))
    margins = {key: exp(kept["margin"]) for key, kept in seen.items() if "margin" in kept}
    return {"margins": margins, "lines": {file: sorted(lines) for file, lines in reached.items()},
            "same": difference(golden_one, found)}


@functools.cache
def watchable() -> list[Row]:
    return [row for row in rows.rows() if row.kind == "constant" and moved.only_compared(row)]


class reaching:
    """Keep which lines of files with rows are reached."""

    TOOL = 4

    def __init__(self, lines: dict[str, set[int]]):
        self.lines, self.files = lines, {str(f): str(f.relative_to(PACKAGE)) for f in PACKAGE.rglob("*.py")}

    def __enter__(self):
        monitoring = sys.monitoring
        monitoring.use_tool_id(self.TOOL, "bench")

        def line(code, number):
            if file := self.files.get(code.co_filename):
                self.lines[file].add(number)
            return monitoring.DISABLE

        monitoring.register_callback(self.TOOL, monitoring.events.LINE, line)
        monitoring.set_events(self.TOOL, monitoring.events.LINE)
        monitoring.restart_events()

    def __exit__(self, *_):
        sys.monitoring.set_events(self.TOOL, 0)
        sys.monitoring.free_tool_id(self.TOOL)


def places(row: Row) -> dict[str, set[int]]:
    """File -> lines of the source that use a constant, or raise."""
    found = defaultdict(set)
    for file, node in moved.uses(row):
        found[str(file.relative_to(PACKAGE))].add(node.lineno)
    return found


def touched(row: Row, factor: float | None, watched: dict, seconds: dict) -> list[str]:
    """Structures whose outcome a trial may change, the cheapest first."""
    lines, found = places(row), []
    compared = row.kind == "constant" and row.key in {r.key for r in watchable()}
    for name, kept in watched.items():
        if not any(lines[file] & set(kept["lines"].get(file, ())) for file in lines):
            continue
        near = kept["margins"].get(row.key, inf)
        if compared and factor and not kept["same"] and abs(log(factor)) < log(near):
            continue
        found.append(name)
    return sorted(found, key=lambda name: seconds[name])


def trial(key: str, factor: float | None, structures: list[str], figures: dict) -> dict:
    """Follow paths with one row changed."""
    from structures import Outcome, Point, difference, outcome

    row = next(r for r in rows.rows() if r.key == key)
    differing, cost = {}, []
    with moved.changed(row, factor) as possible:
        if not possible:
            return {"row": key, "factor": factor, "tried": 0, "differing": {}, "cost": 1.0, "possible": False}
        for name in structures:
            kept = {k: v for k, v in figures[name].items() if k != "accuracy"}
            first = Outcome(**kept | {"points": tuple(Point(**p) for p in kept["points"])})
            found = outcome(name, within=max(OVERRUN * first.seconds, 2.0))
            if told := difference(first, found, max(LEAST, 2 * (figures[name]["accuracy"] or 0.0))):
                differing[name] = told
            cost.append(found.factorisations / max(first.factorisations, 1))
    return {"row": key, "factor": factor, "tried": len(structures), "differing": differing,
            "cost": round(sum(cost) / max(len(cost), 1), 3), "possible": True}


def table(which: str, jobs: int, minutes: float, again: bool) -> None:
    """Run the trials that are missing, and write the table of what is there."""
    end, golden_ones = time.monotonic() + 60 * minutes, figures(which, jobs, False)
    watched = {} if again or not WATCHED.exists() else json.loads(WATCHED.read_text())
    for (name,), found in spread(watch, [(n,) for n in golden_ones if n not in watched], jobs):
        watched[name] = found
        write_json(WATCHED, watched)
    done = {} if again else kept_trials()
    seconds = {name: kept["seconds"] for name, kept in golden_ones.items()}
    for factors in [(None,), *((f,) for f in FACTORS)]:
        tasks = [task for row in rows.rows() if (task := task_of(row, factors[0], done, watched, seconds))]
        print(f"factor {factors[0]}: {len(tasks)} trials, "
              f"{sum(seconds[n] for t in tasks for n in t[2]):.0f} CPU s at most", flush=True)
        for (key, factor, names, _), found in spread(trial, [(*t, golden_ones) for t in tasks], jobs, end):
            done[key, factor] = found
            with TRIALS.open("a") as file:
                file.write(json.dumps(found) + "\n")
            print(f"{key} x{factor}: {len(found['differing'])} of {len(names)} differ", flush=True)
        write_table(done)
        if time.monotonic() > end:
            print("time is up; the same command goes on")
            return


def task_of(row: Row, factor: float | None, done: dict, watched: dict, seconds: dict) -> tuple | None:
    """What a trial of a row needs; None where there is none to be run."""
    if (row.kind == "guard") != (factor is None) or (row.key, factor) in done:
        return None
    if any(found["differing"] or not found["possible"] for (key, _), found in done.items() if key == row.key):
        side = [f for (key, f), found in done.items() if key == row.key and found["differing"] and f]
        if not side or factor in (4.0, 0.25, 10.0, 0.1):
            return None
    names = touched(row, factor, watched, seconds)
    return (row.key, factor, names) if names else None


def kept_trials() -> dict:
    """Trials on disk by row and factor."""
    lines = TRIALS.read_text().splitlines() if TRIALS.exists() else []
    return {(t["row"], t["factor"]): t for t in map(json.loads, lines)}


def write_table(done: dict) -> None:
    with TABLE.open("w", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(COLUMNS)
        for row in rows.rows():
            mine = [t for (key, _), t in done.items() if key == row.key]
            needed = sorted({name for t in mine for name in t["differing"]})
            margins = [max(t["factor"], 1 / t["factor"]) for t in mine if t["differing"] and t["factor"]]
            writer.writerow((row.name, row.kind, row.file, ";".join(needed), f"{min(margins):g}" if margins else ""))


def spread(function, tasks: list[tuple], jobs: int, end: float = inf) -> Iterator[tuple[tuple, dict]]:
    """Results as they come from several processes; a task whose process dies twice is left out, and told."""
    os.environ["OMP_NUM_THREADS"] = "1"
    waiting, died = list(tasks), Counter()
    while waiting and time.monotonic() < end:
        with ProcessPoolExecutor(jobs, multiprocessing.get_context("spawn")) as pool:
            running: dict = {}
            try:
                while (waiting or running) and (running or time.monotonic() < end):
                    while waiting and len(running) < jobs and time.monotonic() < end:
                        task = waiting.pop(0)
                        running[pool.submit(function, *task)] = task
                    for future in wait(running, return_when=FIRST_COMPLETED).done:
                        yield running[future], future.result()
                        del running[future]
            except BrokenProcessPool:
                for task in running.values():
                    died[task[:2]] += 1
                    if died[task[:2]] < 2:
                        waiting.insert(0, task)
                    else:
                        print(f"{task[:2]} ends its process", flush=True)


def write_json(file: Path, content) -> None:
    beside = file.with_suffix(".part")
    beside.write_text(json.dumps(content, indent=0) + "\n")
    beside.replace(file)


def count(found: Iterable[Row]) -> None:
    for (room, kind), number in sorted(Counter((r.file.split("/")[0], r.kind) for r in found).items()):
        print(f"{room:14} {kind:9} {number:4}")


def main() -> None:
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument("what", choices=["count", "figures", "table"])
    options.add_argument("--set", default="all", choices=["all", "quick"])
    options.add_argument("--jobs", type=int, default=2)
    options.add_argument("--minutes", type=float, default=120.0)
    options.add_argument("--again", action="store_true")
    given = options.parse_args()
    if given.what == "count":
        count(rows.rows())
    elif given.what == "figures":
        figures(given.set, given.jobs, given.again)
    else:
        table(given.set, given.jobs, given.minutes, given.again)


if __name__ == "__main__":
    main()
