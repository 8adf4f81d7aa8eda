"""Ways past the place where panels' edges lift off the dome: `python3 demos/studies/lift_off.py`.

The exact path without and with friction, snaps from it under held load and held displacement, branches of its simple
bifurcations, and domes whose nodes lie off their places, as measured ones do (normally distributed, the same for bars
and panels). Takes some 45 minutes.
"""

from __future__ import annotations

import json
from dataclasses import asdict
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

import sheetfx as fx
from sheetfx import meshes
from sheetfx.continuation.state import CriticalPoint
from sheetfx.scenes import dome

END = 14.0  # deflection of the apex, mm
FRICTION = 0.2
DEVIATIONS, SEEDS = (0.5, 5.0), (1,)  # of nodes, mm, and of the random numbers
DIVISIONS = 6  # fewest equal cells on which edges lift at about the load of finer meshes; on four at 60 % of it
OPTIONS = {"model": "contact", "divisions": DIVISIONS, "to": END}


def say(title: str, states: list[fx.State], message: str = "") -> None:
    """Critical points of a piece of path, and where it ends."""
    print(f"{title}: {message}")
    for state in states:
        for point in state.critical:
            print(f"    {point.title} at {point.load / 1e3:.2f} kN, {point.deflection:.3f} mm")
    last = states[-1]
    print(f"    ends at {last.load / 1e3:.2f} kN, {last.deflection:.3f} mm, {last.unstable_modes} unstable", flush=True)


def go_on(case: fx.Case, title: str, start: fx.State) -> None:
    """The path from a state on, to the end or to where it fails."""
    path, states = fx.Path(case.scene, case.control, fx.Until(deflection=END, steps=start.step + 80), start=[start]), []
    try:
        states.extend(path)
        say(title, [start, *states], path.message)
    except fx.PathFailure as failure:
        say(title, [start], str(failure))


def perfect(friction: float) -> None:
    """The dome of the table: its path, falls, and without friction branches."""
    case = dome.case(friction=friction, **OPTIONS)
    record = fx.trace(case)
    say(f"path, friction {friction}", record.states, record.path.message)
    for hold in ("load", "displacement"):
        fall_and_go_on(record, hold)
    for point in record.critical_points:
        if point.kind == "bifurcation" and not friction and (point.name == "corner" or not point.spread):
            try:
                follow_branches(record, point)
            except ArithmeticError as failure:
                print(f"branches at {point.load / 1e3:.2f} kN: {failure}", flush=True)


def follow_branches(record: fx.Record, point: CriticalPoint) -> None:
    """Branches of a simple bifurcation, and one of each kind of a corner: pairs that change, modes and rate alike."""
    if point.name != "corner" and point.multiplicity > 1:
        return
    kinds: dict[tuple[int, int, str], list[fx.Branch]] = {}
    for branch in record.branches(point):
        start, changing = branch.start, int(np.count_nonzero(branch.direction))
        kind = (changing, start.unstable_modes or 0, f"{start.load_rate:.2g}")
        kinds.setdefault(kind, []).append(branch)
    for (changing, modes, _), alike in sorted(kinds.items()):
        title = f"{point.title} at {point.load / 1e3:.2f} kN, {changing} change, {modes} modes, {len(alike)} alike"
        for branch in alike[:1] if point.name == "corner" else alike:
            go_on(record.case, f"{title} {branch.doubt}", branch.start)


def fall_and_go_on(record: fx.Record, hold: str) -> None:
    """A fall from the first unstable state of a path, and the path from there."""
    unstable = next(state for state in record.states if state.unstable_modes)
    fall = record.snap(unstable, hold)
    print(f"snap under held {hold} from {unstable.load / 1e3:.2f} kN, {unstable.deflection:.3f} mm to "
          f"{fall.after.load / 1e3:.2f} kN, {fall.after.deflection:.3f} mm")
    go_on(record.case, "    after it", fall.after)


def measured(deviation: float, seed: int) -> None:
    """A dome whose nodes lie off their places."""
    random, table = np.random.default_rng(seed), meshes.dome("hex")
    nodes = {name: (place + deviation * random.normal(size=3)).tolist() for name, place in table.nodes.items()}
    title = f"nodes {deviation} mm off, seed {seed}"
    with TemporaryDirectory() as folder:
        file = Path(folder) / "measured.json"
        file.write_text(json.dumps(asdict(table) | {"nodes": nodes}))
        case = dome.case(geometry=str(file), **OPTIONS)
    try:
        record = fx.trace(case)
        say(title, record.states, record.path.message)
    except fx.PathFailure as failure:
        say(title, failure.record.states, str(failure))
        for hold in ("load", "displacement"):
            fall_and_go_on(failure.record, hold)


if __name__ == "__main__":
    for coefficient in (0.0, FRICTION):
        perfect(coefficient)
    for size in DEVIATIONS:
        for number in SEEDS:
            measured(size, number)
