"""What `.ci/versions` runs in each environment, and how it compares the results."""

import csv
import json
import sys
from dataclasses import replace
from pathlib import Path

LIMIT = 1e-8  # of loads; the largest difference that rounding may make

# Options of scenes that take longer than a minute by default.
CHEAPER = {
    "channel": {"cells": 12},
    "diaphragm-cylinder": {"cells": 8},
    "dome": {"divisions": 2},
    "double-plate": {"cells": 8},
    "plastic-cylinder": {"cells": 8, "to": 60.0},
    "pull-out": {"cells": 4},
    "semi-cylinder": {"cells": 6},
}


def run(name: str, folder: Path):
    """Run a scene without its pictures."""
    from sheetfx import case
    from sheetfx.scenes import load_case

    options = CHEAPER.get(name, {})
    summary = case.run(replace(load_case(name)(**options), pictures=()), name, options, folder, resume=False)
    print(f"{name}: {summary['status']}, {summary['message']}; {summary['timings']['total']:.0f} s", file=sys.stderr)


def compare(name: str, one: Path, other: Path) -> bool:
    """Print the largest differences between two runs of a scene; whether all that count are small."""
    missing = [str(folder) for folder in (one, other) if not (folder / "summary.json").exists()]
    if missing:
        print(f"{name:20} no results: {', '.join(missing)}")
        return False
    counting, line, remarks = _differences(one, other)
    good = max(counting) <= LIMIT and not remarks
    print("\n".join([f"{name:20} {line}{'' if good else '  DIFFERENT'}", *(f"{'':20} {remark}" for remark in remarks)]))
    return good


def _differences(one: Path, other: Path):
    """Differences of loads that count, the line of the table and what is not a matter of a number."""
    paths = [list(csv.DictReader((run / "path.csv").open())) for run in (one, other)]
    summaries = [json.loads((run / "summary.json").read_text()) for run in (one, other)]
    largest = max(abs(float(state["load"])) for state in paths[0])
    remarks = [f"{key}: {summaries[0][key]!r}, {summaries[1][key]!r}" for key in ("status", "unknowns")
               if summaries[0][key] != summaries[1][key]]
    points = [summary["critical_points"] for summary in summaries]
    kinds = [[(p["kind"], p["name"], p["multiplicity"]) for p in found] for found in points]
    if kinds[0] != kinds[1]:
        remarks.append(f"critical points: {kinds[0]}, {kinds[1]}")
    # A load that passes zero is compared with a thousandth of the path's largest.
    loads = max((_relative(p["load"], q["load"], largest / 1000) for p, q in zip(*points, strict=False)), default=0.0)
    last = _relative(*(float(states[-1]["load"]) for states in paths), largest / 1000)
    named = [_numbers(summary["quantities"]) for summary in summaries]
    quantities = max((_relative(value, named[1].get(key, float("nan"))) for key, value in named[0].items()),
                     default=0.0)
    # Of a structure that is not loaded, quantities are all there is: its buckling loads.
    counts = [loads, last] + [quantities] * (len(paths[0]) == 1)
    line = f"{len(points[0]):6} {loads:12.1e} {last:12.1e} {quantities:12.1e} {len(paths[0]):5} {len(paths[1]):5}"
    return counts, line, remarks


def _relative(value: float, other: float, least: float = 0.0) -> float:
    """Difference over the larger of the two; infinite where one is not a number."""
    size = max(abs(value), abs(other), least)
    difference = abs(value - other) / size if size else 0.0
    return difference if difference == difference else float("inf")


def _numbers(found, name="") -> dict[str, float]:
    """Numbers of nested lists and dictionaries by their places."""
    if isinstance(found, bool) or not isinstance(found, (int, float, list, dict)):
        return {}
    if isinstance(found, (int, float)):
        return {name: found}
    pairs = found.items() if isinstance(found, dict) else enumerate(found)
    return {key: value for place, inner in pairs for key, value in _numbers(inner, f"{name}/{place}").items()}


if __name__ == "__main__":
    action, *words = sys.argv[1:]
    if action == "head":
        print(f"{'':20} {'points':>6} {'their loads':>12} {'last load':>12} {'quantities':>12} {'states':>11}")
    elif action == "run":
        run(words[0], Path(words[1]))
    elif not compare(words[0], Path(words[1]), Path(words[2])):
        sys.exit(1)
