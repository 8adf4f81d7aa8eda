"""Times to an answer, of this tree and of an earlier one in turn: `python3 demos/studies/times.py [--before FOLDER]`.

An earlier tree is a checkout, such as `git worktree add FOLDER COMMIT` makes. Each measurement is a process of its own,
with forms that are compiled already but for the edited one; medians of --repeat are printed as a table in Markdown.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import time
from pathlib import Path
from random import Random
from statistics import median
from tempfile import TemporaryDirectory

HERE = Path(__file__).parents[2]
IMPORTS = "import dolfinx.fem.petsc, pyvista"
STEP = """
import sheetfx as fx
from sheetfx.scenes import {scene}
case = {scene}.case({options})
next(state for state in fx.Path(case.scene, case.control, case.until) if state.step == 1)
"""
EDITED = """
from dataclasses import replace
import numpy as np, sheetfx as fx
from sheetfx.forms.shell import naghdi

def edited(u, rotation, frame):
    measure = naghdi(u, rotation, frame)
    return replace(measure, shear=measure.shear * (1 + {number} / 12 * measure.drilling))

mesh = fx.read(lambda: fx.meshes.rectangle((4, 4)), 3, 3, lambda x: np.column_stack((x[:, :2], x[:, 0] ** 2 / 9)))
shell = fx.Shell(mesh, fx.Plate(0.01), fx.Elastic(1e6, 0.3), form="naghdi-q3", strains=edited)
scene = fx.Scene([shell], [fx.clamp(mesh, "west")], [fx.EdgeForce(mesh, "east", (0.0, 0.0, 1e-3))],
                 fx.Monitor(mesh, "south-east", "z"))
next(state for state in fx.Path(scene, fx.LoadControl(0.5)) if state.step == 1)
"""
SECOND = """
import time
import sheetfx as fx
from sheetfx.scenes import hemisphere
case = hemisphere.case(cells=8)
for _ in range(2):
    start = time.process_time()
    path = fx.Path(case.scene, case.control, case.until)
    made = time.process_time() - start
compiled = path.clock.seconds["compile"]
path.clock.seconds.clear()
start = time.process_time()
states = list(path)
seconds, total = path.clock.seconds, time.process_time() - start
print(compiled, made, total, (seconds["factorisation"] + seconds["solve"]) / total)
"""


def run(tree: Path, *command: str, cache: Path) -> tuple[float, float, str]:
    """Wall and CPU seconds of a process and those that it starts, and what it prints."""
    places = {"PYTHONPATH": str(tree), "PYTHONSAFEPATH": "1", "OMP_NUM_THREADS": "1", "XDG_CACHE_HOME": str(cache)}
    start = time.perf_counter()
    process = subprocess.Popen([sys.executable, *command], env=os.environ | places, stdout=subprocess.PIPE,
                               stderr=subprocess.PIPE, text=True)
    output, errors = process.stdout.read(), process.stderr.read()
    _, status, usage = os.wait4(process.pid, 0)
    if status:
        raise RuntimeError(f"{' '.join(command)[:60]} fails in {tree}:\n{errors}")
    return time.perf_counter() - start, usage.ru_utime + usage.ru_stime, output


def of_run(tree: Path, cache: Path, scene: str) -> dict[str, float]:
    """A scene by the command, warm."""
    with TemporaryDirectory() as folder:
        wall, cpu, _ = run(tree, "-m", "sheetfx", "run", scene, "-o", f"{folder}/out", cache=cache)
        seconds = json.loads((Path(folder) / "out" / "summary.json").read_text())["timings"]
    return {f"`sheetfx run {scene}`, wall s": wall, f"`sheetfx run {scene}`, CPU s": cpu,
            f"{scene}: pictures and files, share of CPU": seconds["output"] / cpu,
            f"{scene}: path, CPU s": seconds["compile"] + seconds["path"]}


def measure(tree: Path, cache: Path, number: int) -> dict[str, float]:
    """All figures of a tree, once; the number is one that no form has had."""
    found = {}
    for title, code in (("imports of DOLFINx and pyvista", IMPORTS),
                        ("import to first step, frame", STEP.format(scene="lee_frame", options="")),
                        ("import to first step, shell", STEP.format(scene="roof", options="cells=2")),
                        ("edited strain measure of a shell to first step", EDITED.format(number=number))):
        wall, cpu, _ = run(tree, "-c", code, cache=cache)
        found |= {f"{title}, wall s": wall, f"{title}, CPU s": cpu}
    found |= of_run(tree, cache, "arch") | of_run(tree, cache, "roof")
    floor = found["roof: path, CPU s"] + found["imports of DOLFINx and pyvista, wall s"]
    found["`sheetfx run roof`: wall over that of path and imports"] = found["`sheetfx run roof`, wall s"] / floor
    numbers = map(float, run(tree, "-c", SECOND, cache=cache)[2].split())
    titles = ("forms of a second path, CPU s", "set-up of a second path, CPU s", "its path, CPU s",
              "share of factorisation and back-substitution")
    return found | {f"hemisphere of 3 599 unknowns: {title}": n for title, n in zip(titles, numbers, strict=True)}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--before", type=Path, help="checkout of an earlier commit")
    parser.add_argument("--repeat", type=int, default=5, help="measurements of each figure")
    chosen = parser.parse_args()
    trees = [*([chosen.before.resolve()] if chosen.before else []), HERE]
    found, numbers = {tree: [] for tree in trees}, Random()
    with TemporaryDirectory() as folder:
        caches = {tree: Path(folder) / str(place) for place, tree in enumerate(trees)}
        for turn in range(chosen.repeat + 1):
            for tree in trees:
                figures = measure(tree, caches[tree], numbers.choice([n for n in range(13, 192) if n % 12]))
                if turn:  # the first one compiles
                    found[tree].append(figures)
                print(f"{tree}: {'turn ' + str(turn) if turn else 'compiled'}", file=sys.stderr, flush=True)
    print("| | " + " | ".join(["before", "now"][-len(trees):]) + " |\n" + "|---" * (len(trees) + 1) + "|")
    for title in found[HERE][0]:
        print(f"| {title} | " + " | ".join(f"{median(f[title] for f in found[tree]):.3g}" for tree in trees) + " |")


if __name__ == "__main__":
    main()
