"""Advice on twelve scenes against the whole model on the finest mesh: is its load inside, and at what cost?

docker/run python3 demos/advice/table.py [NAME ...] writes results/advice-table.csv, row by row; rows that are there
already are not run again.
"""

from __future__ import annotations

import csv
import sys
import time
from pathlib import Path

import sheetfx as fx
from sheetfx.ladder.first_point import up_to_first

HERE, TABLE = Path(__file__).parent, Path("results/advice-table.csv")
ROWS = {  # scene, its options, level of the top, how often its layers and steps are doubled
    "arch": ("arch", {"elements": 80}, 2, 0),
    "arch-0.2": ("arch", {"elements": 80, "ratio": 0.2}, 2, 0),
    "roof": ("roof", {}, 1, 0),
    "hinged-half": ("hinged_half.py", {}, 2, 0),
    "coupled-dome": ("dome", {"model": "coupled"}, 2, 0),
    "double-plate": ("double-plate", {}, 1, 1),
    "m1": ("m1", {"model": "coupled"}, 2, 1),
    "stocky-column": ("stocky_column.py", {}, 2, 2),
    "portal": ("portal.py", {}, 3, 2),
    "ring": ("ring.py", {}, 2, 0),
    "stiffened-plate": ("stiffened.py", {}, 1, 0),
    "rough-foot": ("rough_foot.py", {}, 2, 0),
    "plate-half": ("plate_half.py", {}, 1, 0),
    "stop": ("stop.py", {}, 2, 0),
}
WHOLE = {"hinged-half": {"whole": True}, "plate-half": {"whole": True}}
HEAD = "scene", "load", "low", "high", "model", "seconds", "top load", "top seconds", "inside", "ratio"


def row(name: str) -> list:
    """One row of the table."""
    scene, options, level, doubled = ROWS[name]
    function = fx.load_case(str(HERE / scene) if scene.endswith(".py") else scene)
    meshes = fx.by_option(function, options, 2) or fx.by_halving(function(**options), 2)
    advice = fx.Climb(meshes, 0.02).advice()
    begun = time.process_time()
    whole = options | WHOLE.get(name, {})
    case = fx.integrated_finer((fx.by_option(function, whole, 3) or fx.by_halving(function(**whole), 3)).case(level),
                               doubled)
    top = up_to_first(case, case.scene, fx.LeftOut(), fx.LeftOut())
    spent = time.process_time() - begun
    low, high = advice.interval
    return [name, f"{advice.load:.6g}", f"{low:.6g}", f"{high:.6g}", f"{advice.left.words}, {advice.mesh}",
            f"{advice.cpu_seconds:.1f}", f"{top.load:.6g}", f"{spent:.1f}", low <= top.load <= high,
            f"{advice.cpu_seconds / spent:.2f}"]


def main() -> None:
    """Write the rows that are asked for and not there."""
    TABLE.parent.mkdir(exist_ok=True)
    known = {line[0] for line in csv.reader(TABLE.open())} if TABLE.exists() else set()
    with TABLE.open("a", newline="") as file:
        table = csv.writer(file)
        if not known:
            table.writerow(HEAD)
        for name in sys.argv[1:] or ROWS:
            if name not in known:
                table.writerow(found := row(name))
                file.flush()
                print(*found, sep=" | ", flush=True)


if __name__ == "__main__":
    main()
