"""The bench: golden figures, and which structure needs which constant or guard of the path follower.

    docker/run python3 tests/golden/bench.py count                rows by room
    docker/run python3 tests/golden/bench.py figures              golden figures, figures.json
    docker/run python3 tests/golden/bench.py table --minutes 120  trials, trials.jsonl, and the table, table.csv
    docker/run python3 tests/golden/bench.py check                outcomes of the present source against the figures

What is there is not computed again; `--again` begins anew. README.md beside this file has more.
"""

from __future__ import annotations

import argparse
import csv
import json
import multiprocessing
import os
import sys
import time
from collections import Counter, defaultdict
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import ExitStack
from dataclasses import asdict
from math import inf
from pathlib import Path

import moved
import rows
from rows import PACKAGE, Row

HERE = Path(__file__).parent
FIGURES, LINES = HERE / "figures.json", HERE / "lines.json"
TRIALS, TABLE = HERE / "trials.jsonl", HERE / "table.csv"
OFF = 0.0  # the factor of a guard
FAR = 1e3  # a factor that no tuned number survives: what no structure needs within it has no effect
FACTORS = OFF, 2.0, 0.5, 4.0, 0.25, 10.0, 0.1, FAR, 1 / FAR, 1.25, 0.8  # in this order; 1.25 where 2 told something
TOGETHER = {2.0: 16, 4.0: 12, 10.0: 8, FAR: 6, 1.25: 1, OFF: 1}  # rows first changed at once; guards hide each other
CHEAP = 1.0  # CPU seconds of a run on which factors beyond 2 are tried
OVERRUN, LEAST_SECONDS = 4.0, 2.0  # CPU time of a trial over that of the golden run, and at least
LEAST, WIDE = 1e-6, 3.0  # accuracy of loads at least, and over what halved steps show
UNSTEADY = 1e-3  # accuracy of loads where halved steps show other points
COLUMNS = "name", "kind", "file", "needed_by", "margin"


def figures(which: str, jobs: int, again: bool) -> dict:
    """Golden outcomes of all structures, each with the change of its loads by steps of half the length."""
    kept = {} if again or not FIGURES.exists() else json.loads(FIGURES.read_text())
    lines = {} if again or not LINES.exists() else json.loads(LINES.read_text())
    from structures import names

    wanted = [name for name in names(which) if name not in kept or name not in lines]
    for (name,), (found, reached) in spread(golden, [(name,) for name in wanted], jobs):
        kept[name], lines[name] = found, reached
        print(f"{name}: {found['seconds']:.2f} CPU s, {len(found['points'])} points, {found['ended']}", flush=True)
        write_json(FIGURES, kept)
        write_json(LINES, lines)
    return {name: kept[name] for name in names(which) if name in kept}


def golden(name: str) -> tuple[dict, dict]:
    """Outcome with its accuracy, and the lines of the source that are reached."""
    from structures import outcome

    reached: dict[str, set] = defaultdict(set)
    with reaching(reached):
        outcome(name)  # compiles
    found, halved = outcome(name), outcome(name, shorter=0.5)
    return (asdict(found) | {"accuracy": accuracy(found, halved)},
            {file: sorted(numbers) for file, numbers in reached.items()})


def accuracy(one, other) -> float | None:
    """Largest change of a load over the largest load; None: the points are others.

    Of paths that the number of steps ends the points count that both reach.
    """
    kinds = [[(p.kind, p.multiplicity) for p in found.points] for found in (one, other)]
    common = min(map(len, kinds)) if one.counted or other.counted else None
    if kinds[0][:common] != kinds[1][:common]:
        return None
    largest = max([abs(p.load) for p in one.points] + [abs(one.load)]) or 1.0
    changes = [abs(p.load - q.load) for p, q in zip(one.points, other.points, strict=False)]
    return max([*changes, abs(one.load - other.load) if common is None else 0.0]) / largest


def tolerance(kept: dict) -> float:
    """Relative change of a load that is no other outcome."""
    return UNSTEADY if kept["accuracy"] is None else max(LEAST, WIDE * kept["accuracy"])


def kept_outcome(kept: dict):
    from structures import Outcome, Point

    known = {key: value for key, value in kept.items() if key != "accuracy"}
    return Outcome(**known | {"points": tuple(Point(**p) for p in kept["points"])})


class reaching:
    """Keep which lines of the package are reached."""

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


def touches(row: Row, lines: dict) -> bool:
    """Whether a run reaches a line where a constant, or the condition of a guard, stands."""
    return any(node.lineno in lines.get(str(file.relative_to(PACKAGE)), ()) for file, node in moved.uses(row))


def trials(name: str, factor: float, keys: list[str], kept: dict, together: int) -> dict:
    """Change rows of one structure's run in groups, and halve each group that changes the outcome (Dorfman 1943).

    Returns
    -------
    "differing": row -> how; "together": groups that change an outcome only as a whole; "impossible": rows that cannot
    be changed
    """
    from structures import difference, outcome

    outcome(name)  # compiles, which counts in no trial
    first, every = kept_outcome(kept), {row.key: row for row in rows.rows()}
    found = {"structure": name, "factor": factor, "tried": keys, "differing": {}, "together": [], "impossible": [],
             "runs": 0}

    def told(group: list[str]) -> str:
        with ExitStack() as stack:
            possible = {key: stack.enter_context(moved.changed(every[key], factor or None)) for key in group}
            found["impossible"] = sorted({*found["impossible"], *(key for key in group if not possible[key])})
            found["runs"] += 1
            return difference(first, outcome(name, max(OVERRUN * first.seconds, LEAST_SECONDS)),
                              tolerance(kept))

    def halve(group: list[str], how: str) -> None:
        if len(group) == 1:
            found["differing"][group[0]] = how
            return
        half = len(group) // 2
        parts = [(part, said) for part in (group[:half], group[half:]) if (said := told(part))]
        if not parts:
            found["together"].append(group)
        for part, said in parts:
            halve(part, said)

    for n in range(0, len(keys), together):
        group = keys[n:n + together]
        if how := told(group):
            halve(group, how)
    return found


def table(which: str, jobs: int, minutes: float, again: bool) -> None:
    """Run the trials that are missing, and write the table of what is there."""
    end = time.monotonic() + 60 * minutes
    golden_ones = figures(which, jobs, False)
    lines = json.loads(LINES.read_text())
    if again:
        TRIALS.unlink(missing_ok=True)
    done = kept_trials()
    order = sorted(golden_ones, key=lambda name: golden_ones[name]["seconds"])
    begun = time.monotonic()
    for factor in FACTORS:
        wanted = [row for row in rows.rows() if is_wanted(row, factor, done)]
        tried = {(t["structure"], key) for t in done if t["factor"] == factor for key in t["tried"]}
        needing = {(t["structure"], key) for t in done for key in t["differing"]}
        tasks = []
        for name in order:
            missing = [row.key for row in wanted
                       if (name, row.key) not in tried and touches(row, lines[name])
                       and (factor == OFF or size_of(factor) >= 2 or (name, row.key) in needing)]
            if missing and (size_of(factor) <= 2 or golden_ones[name]["seconds"] <= CHEAP):
                tasks.append((name, factor, missing, golden_ones[name], TOGETHER[size_of(factor)]))
        print(f"factor {factor}: {sum(len(task[2]) for task in tasks)} changes on {len(tasks)} structures", flush=True)
        for task, found in spread(trials, tasks, jobs, end, lambda task: sorted_by_need(task, done)):
            keep_trial(found, done)
            done.append(found)
            print(f"{(time.monotonic() - begun) / 60:5.1f} min  x{factor} {task[0]}: {len(found['differing'])} of "
                  f"{len(task[2])} differ, {found['runs']} runs", flush=True)
        write_table(done)
        if time.monotonic() > end:
            print("time is up; the same command goes on")
            return


def size_of(factor: float) -> float:
    """A factor or its inverse, whichever is above 1; OFF as it is."""
    return max(factor, 1 / factor) if factor else OFF


def is_wanted(row: Row, factor: float, done: list[dict]) -> bool:
    """Whether a row is changed by a factor: a constant until a smaller one has changed an outcome."""
    if (row.kind == "guard") != (factor == OFF):
        return False
    if factor == OFF:
        return True
    margin, moved_by = margin_of(row, done), size_of(factor)
    return margin in (2.0, moved_by) if moved_by < 2 else margin >= moved_by


def margin_of(row: Row, done: list[dict]) -> float:
    return min((size_of(t["factor"]) for t in done if row.key in t["differing"] and t["factor"]), default=inf)


def sorted_by_need(task: tuple, done: list[dict]) -> tuple:
    """A task with the rows together that changed other structures, so that fewer groups are halved."""
    name, factor, keys, kept, size = task
    need = Counter(key for t in done if t["factor"] == factor for key in t["differing"])
    return name, factor, sorted(keys, key=lambda key: -need[key]), kept, size


def kept_trials() -> list[dict]:
    """Trials on disk; rows that were tried stand there as numbers in the order in which lines "rows" name them."""
    known, found = [], []
    for line in map(json.loads, TRIALS.read_text().splitlines() if TRIALS.exists() else ()):
        if "rows" in line:
            known += line["rows"]
        else:
            found.append(line | {"tried": [known[n] for n in line["tried"]]})
    return found


def keep_trial(found: dict, done: list[dict]) -> None:
    """Write a trial behind those that are done."""
    known = dict.fromkeys(key for t in done for key in t["tried"])
    new = [key for key in found["tried"] if key not in known]
    numbers = {key: n for n, key in enumerate([*known, *new])}
    with TRIALS.open("a") as file:
        if new:
            file.write(json.dumps({"rows": new}) + "\n")
        file.write(json.dumps(found | {"tried": [numbers[key] for key in found["tried"]]}) + "\n")


def write_table(done: list[dict]) -> None:
    with TABLE.open("w", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(COLUMNS)
        for row in rows.rows():
            margin = margin_of(row, done)
            needed = sorted({t["structure"] for t in done if row.key in t["differing"]})
            writer.writerow((row.name, row.kind, row.file, ";".join(needed), "" if margin >= FAR else f"{margin:g}"))


def check(which: str, jobs: int) -> int:
    """Compare outcomes with the golden figures; the number that differ."""
    kept, differing = json.loads(FIGURES.read_text()), 0
    from structures import names

    costs = []
    for (name, *_), (how, cost, seconds) in spread(against, [(n, kept[n]) for n in names(which) if n in kept], jobs):
        costs.append(seconds)
        if how:
            differing += 1
            print(f"{name}: {how}; {cost:.2f} of the factorisations", flush=True)
    costs.sort()
    print(f"{differing} of {len(costs)} differ; CPU time over the golden one: median {costs[len(costs) // 2]:.3f}")
    return differing


def against(name: str, kept: dict) -> tuple[str, float, float]:
    from structures import difference, outcome

    first = kept_outcome(kept)
    outcome(name)
    found = outcome(name)
    return (difference(first, found, tolerance(kept)), found.factorisations / max(first.factorisations, 1),
            found.seconds / first.seconds)


def spread(function: Callable, tasks: list[tuple], jobs: int, end: float = inf,
           prepare: Callable[[tuple], tuple] = lambda task: task) -> Iterator[tuple[tuple, dict]]:
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
                        running[pool.submit(function, *prepare(task))] = task
                    for future in wait(running, return_when=FIRST_COMPLETED).done:
                        yield running[future], future.result()
                        del running[future]
            except BrokenProcessPool:
                for task in running.values():
                    died[task[0]] += 1
                    if died[task[0]] < 2:
                        waiting.insert(0, task)
                    else:
                        print(f"{task[:2]} ends its process", flush=True)


def write_json(file: Path, content: dict) -> None:
    """Write a line for each key; the file is whole at each moment."""
    beside = file.with_suffix(".part")
    beside.write_text("{\n" + ",\n".join(f"{json.dumps(k)}: {json.dumps(v)}" for k, v in content.items()) + "\n}\n")
    beside.replace(file)


def count(found: Iterable[Row]) -> None:
    for (room, kind), number in sorted(Counter((r.file.split("/")[0], r.kind) for r in found).items()):
        print(f"{room:14} {kind:9} {number:4}")
    with TABLE.open() as file:
        for row in csv.DictReader(file):
            if row["margin"] and float(row["margin"]) < 2:
                print(f"margin {row['margin']:4} {row['file']}: {row['name']}")


def main() -> int:
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument("what", choices=["count", "figures", "table", "check"])
    options.add_argument("--set", default="all", choices=["all", "quick"])
    options.add_argument("--jobs", type=int, default=2)
    options.add_argument("--minutes", type=float, default=120.0)
    options.add_argument("--again", action="store_true")
    given = options.parse_args()
    if given.what == "count":
        count(rows.rows())
    elif given.what == "figures":
        figures(given.set, given.jobs, given.again)
    elif given.what == "table":
        table(given.set, given.jobs, given.minutes, given.again)
    else:
        return check(given.set, given.jobs)
    return 0


if __name__ == "__main__":
    sys.exit(main())
