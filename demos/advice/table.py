"""Advice on twelve scenes against the whole model on the finest mesh: is its load inside, and at what cost?

docker/run python3 demos/advice/table.py [NAME ...] writes results/advice-table.csv, row by row; rows that are there
already are not run again.
"""

from __future__ import annotations

import csv
import json
import subprocess
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


def meshes_of(name: str, options: dict, finest: int) -> fx.Meshes:
    """Meshes of a scene of the table."""
    scene = ROWS[name][0]
    function = fx.load_case(str(HERE / scene) if scene.endswith(".py") else scene)
    return fx.by_option(function, options, finest) or fx.by_halving(function(**options), finest)


def advised(name: str) -> dict:
    """The advice, its model and its CPU time."""
    advice = fx.Climb(meshes_of(name, ROWS[name][1], 2), 0.02).advice()
    return {"load": advice.load, "interval": advice.interval, "model": f"{advice.left.words}, {advice.mesh}",
            "seconds": advice.cpu_seconds}


def top(name: str) -> dict:
    """The load of the whole model on the finest mesh, and its CPU time."""
    _, options, level, doubled = ROWS[name]
    begun = time.process_time()
    case = fx.integrated_finer(meshes_of(name, options | WHOLE.get(name, {}), 3).case(level), doubled)
    found = up_to_first(case, case.scene, fx.LeftOut(), fx.LeftOut())
    return {"load": found.load, "seconds": time.process_time() - begun}


def alone(which: str, name: str) -> dict:
    """What a function of this script gives in a process of its own."""
    done = subprocess.run([sys.executable, __file__, which, name], capture_output=True, text=True, check=True)
    return json.loads(done.stdout.splitlines()[-1])


def row(name: str) -> list:
    """One row of the table."""
    advice, whole = alone("advised", name), alone("top", name)
    low, high = advice["interval"]
    return [name, f"{advice['load']:.6g}", f"{low:.6g}", f"{high:.6g}", advice["model"], f"{advice['seconds']:.1f}",
            f"{whole['load']:.6g}", f"{whole['seconds']:.1f}", low <= whole["load"] <= high,
            f"{advice['seconds'] / whole['seconds']:.2f}"]


def main() -> None:
    """Write the rows that are asked for and not there."""
    if len(sys.argv) == 3 and sys.argv[1] in ("advised", "top"):
        print(json.dumps({"advised": advised, "top": top}[sys.argv[1]](sys.argv[2])))
        return
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
