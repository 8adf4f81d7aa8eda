"""Errors and times of elastic benchmarks, here and in an earlier tree: `assumed_strains.py --before FOLDER`.

The earlier tree is a checkout of commit f6cdf96, in which the energy of a shell was divided between two rules and its
section law called with a part of the strains at each of them. Both have the same scenes, forms and meshes. Prints a
table in Markdown, and draws errors against times.
"""

from __future__ import annotations

import argparse
import json
import os
from pathlib import Path

import matplotlib.pyplot as plt
from times import HERE, run

SCENES = "scordelis_lo", "pinched_cylinder", "hemisphere", "slit_annulus", "roof"
LARGEST = 400  # cells: finer meshes of a scene's chart are left out
REPEAT = 3
CODE = f"""
import json, sys
from importlib import import_module
from statistics import median
import sheetfx as fx
scene = import_module("sheetfx.scenes." + sys.argv[1])
for member in scene.CHART:
    if member["cells"] ** 2 > {LARGEST}:
        continue
    seconds = []
    for _ in range({REPEAT} + 1):  # the first one compiles
        record = fx.trace(scene.case(**member))
        seconds.append(record.path.clock.seconds["path"])
    found = record.case.quantities(record)
    error = max(abs(found[name] / value - 1) for name, value in scene.REFERENCE.items())
    print(json.dumps(dict(form=member["form"], cells=member["cells"], unknowns=record.path.unknowns, error=error,
                          factorisations=record.path.tracer.total_factorisations, seconds=median(seconds[1:]))))
"""


def measure(tree: Path, scene: str) -> list[dict]:
    """Members of a scene's chart in a tree, in a process of its own."""
    cache = Path(os.environ.get("XDG_CACHE_HOME", Path.home() / ".cache"))
    *_, output = run(tree, "-c", CODE, scene, cache=cache)
    return [json.loads(line) for line in output.splitlines() if line.startswith("{")]


def draw(results: dict[str, list[list[dict]]], file: Path) -> None:
    """Errors against CPU seconds, before hollow and now filled."""
    figure, axes = plt.subplots(2, 3, figsize=(11, 6.5), layout="constrained")
    axes.flat[-1].axis("off")
    for place, (scene, (before, now)) in zip(axes.flat, results.items(), strict=False):
        for number, form in enumerate(dict.fromkeys(row["form"] for row in now)):
            for rows, when, line, fill in ((before, "before", "--", "none"), (now, "now", "-", "full")):
                own = [row for row in rows if row["form"] == form]
                place.loglog([row["seconds"] for row in own], [100 * row["error"] for row in own], f"C{number}o",
                             fillstyle=fill, linewidth=0.8, linestyle=line, label=f"{form}, {when}")
        place.set(title=scene.replace("_", " "), xlabel="CPU seconds of the path", ylabel="error (%)")
        place.grid(alpha=0.3, which="both")
    axes.flat[0].legend(fontsize=7)
    figure.savefig(file, dpi=130)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--before", type=Path, required=True, help="checkout of the earlier commit")
    parser.add_argument("--picture", type=Path, default=Path("assumed_strains.png"), help="file of the chart")
    chosen = parser.parse_args()
    results = {}
    print("| scene | form | cells | unknowns | error before, now (%) | factorisations | CPU s |\n" + "|---" * 7 + "|")
    for scene in SCENES:
        results[scene] = [measure(tree, scene) for tree in (chosen.before.resolve(), HERE)]
        for one, other in zip(*results[scene], strict=True):
            both = one, other
            print(f"| {scene} | {one['form']} | {one['cells']} | {other['unknowns']} | "
                  + ", ".join(f"{100 * row['error']:.3g}" for row in both) + " | "
                  + ", ".join(str(row["factorisations"]) for row in both) + " | "
                  + ", ".join(f"{row['seconds']:.2f}" for row in both) + " |", flush=True)
    draw(results, chosen.picture)


if __name__ == "__main__":
    main()
