"""What `.ci/versions` runs in each environment, and how it compares the results."""

import csv
import json
import sys
from dataclasses import replace
from pathlib import Path

LIMIT = 1e-8  # of loads; the largest difference that rounding may make
NONE = 1e-4  # in the scene's units, what deflections and loads are compared with at least: a frame may not deflect

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
    """Run a scene without its pictures; of one that is not loaded the summary has all buckling loads."""
    from sheetfx import case
    from sheetfx.scenes import load_case

    options = CHEAPER.get(name, {})
    made = replace(load_case(name)(**options), pictures=())
    if made.until.steps == 0:
        made = replace(made, quantities=lambda record: {"buckling": [vars(load) | {"mode": None}
                                                                     for load in record.buckling()]})
    summary = case.run(made, name, options, folder, resume=False)
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
    """Differences of loads, the line of the table and what is not a matter of a number."""
    paths = [list(csv.DictReader((run / "path.csv").open())) for run in (one, other)]
    summaries = [json.loads((run / "summary.json").read_text()) for run in (one, other)]
    for summary in summaries:
        summary["buckling"] = summary["quantities"].get("buckling", [])
    largest = max(abs(float(state["load"])) for state in paths[0])
    remarks = [f"{key}: {summaries[0][key]!r}, {summaries[1][key]!r}" for key in ("status", "unknowns")
               if summaries[0][key] != summaries[1][key]]
    points, modes = ([summary[key] for summary in summaries] for key in ("critical_points", "buckling"))
    kinds = [[(p["kind"], p["name"], p["multiplicity"]) for p in found] for found in points]
    clusters = [[(mode["cluster"], mode["multiplicity"]) for mode in found] for found in modes]
    remarks += [f"{what[0]}, {what[1]}" for what in (kinds, clusters) if what[0] != what[1]]
    # A load that passes zero is compared with a thousandth of the path's largest.
    loads = [max((_relative(p["load"], q["load"], largest / 1000) for p, q in zip(*found, strict=False)), default=0.0)
             for found in (points, modes)]
    # The load where a deflection ends the path, the deflection where a load does.
    last = max(_relative(*(float(states[-1][key]) for states in paths),
                         max(NONE, max(abs(float(state[key])) for state in paths[0]) / 1000))
               for key in ("load", "deflection"))
    if len(paths[0]) == 1 and not modes[0]:
        remarks.append("nothing to compare: neither a path nor buckling loads")
    line = (f"{len(points[0]):6} {loads[0]:12.1e} {last:12.1e} {len(modes[0]):8} {loads[1]:12.1e} "
            f"{len(paths[0]):5} {len(paths[1]):5}")
    return [*loads, last], line, remarks


def _relative(value: float, other: float, least: float = 0.0) -> float:
    """Difference over the larger of the two; infinite where one is not a number."""
    size = max(abs(value), abs(other), least)
    difference = abs(value - other) / size if size else 0.0
    return difference if difference == difference else float("inf")


if __name__ == "__main__":
    action, *words = sys.argv[1:]
    if action == "head":
        print(f"{'':20} {'points':>6} {'their loads':>12} {'last state':>12} {'buckling':>8} {'their loads':>12} "
              f"{'states':>11}")
    elif action == "run":
        run(words[0], Path(words[1]))
    elif not compare(words[0], Path(words[1]), Path(words[2])):
        sys.exit(1)
