"""Convergence of the double plate in mesh, step and enforcement.

    python3 demos/studies/double_plate.py [FOLDER] [--draw]

Traces the path for friction 0, 0.2 and 0.4, elastic and plastic, with three levels of each, and leaves
`convergence.png` and `convergence.md` in the folder (default results/double-plate-convergence). What is finished there
is not traced again; `--draw` traces nothing and draws what is there.
"""

from __future__ import annotations

import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

from sheetfx.studies.study import Study, trace_study

LEVELS = {"cells": [8, 16, 32], "step": [0.02, 0.01, 0.005], "stiffness": [6.0, 60.0, 600.0]}
TITLES = {"cells": "cells along a plate", "step": "step (arc length)", "stiffness": "stiffness of contact (N/mm3)"}
USUAL = {"cells": 16, "step": 0.01, "stiffness": 60.0}
FRICTIONS, LIMIT = [0.0, 0.2, 0.4], "limit"
READ = {"A_load": "A (N)", "B_load": "B (N)", LIMIT: "limit (N)", "C_load": "C (N)", "C_deflection": "C (mm)",
        "largest_contact_force": "contact force (N)"}


def trace(folder: Path, jobs: int) -> dict:
    """Quantities of all runs, by material, friction, what is varied, and its value; no jobs: of those at hand."""
    found = {}
    for name, values in LEVELS.items():
        others = values if name == "cells" else [v for v in values if v != USUAL[name]]
        fixed = {key: value for key, value in USUAL.items() if key != name}
        varied = {"elastic": [True, False], "friction": FRICTIONS, name: others}
        home = folder / name
        study = Study("double-plate", fixed, varied)
        runs = [run for run in study.runs(home) if run.finished] if not jobs else trace_study(
            study, home, jobs, home.exists(), say=lambda run: print(run.name, run.status, flush=True))
        for run in runs:
            key = run.chosen["elastic"], run.chosen["friction"]
            if run.status == "finished":
                limit = max((p.load for p in run.points if p.kind == "limit"), default=np.nan)
                found[*key, name, run.chosen[name]] = run.summary["quantities"] | {
                    LIMIT: limit, "cpu": run.summary["timings"]["path"]}
            else:
                print(run.name, run.message)
    for elastic, friction, name, value in list(found):
        if name == "cells" and value == USUAL["cells"]:
            for other in ("step", "stiffness"):
                found[elastic, friction, other, USUAL[other]] = found[elastic, friction, name, value]
    return found


def differences(found: dict, elastic: bool, friction: float, name: str, quantity: str) -> list[float]:
    """Of the first two levels from the third, in percent."""
    levels = [found.get((elastic, friction, name, value), {}).get(quantity, np.nan) for value in LEVELS[name]]
    return [100 * abs(value / levels[-1] - 1) for value in levels[:-1]]


def draw(found: dict, folder: Path) -> None:
    figure, axes = plt.subplots(2, 3, figsize=(11, 6.5), sharey=True, layout="constrained")
    for row, elastic in zip(axes, (True, False), strict=True):
        for panel, (name, values) in zip(row, LEVELS.items(), strict=True):
            for friction, marker in zip(FRICTIONS, "osD", strict=True):
                for colour, (quantity, title) in zip(("C0", "C5", "C3", "C2", "C4", "C1"), READ.items(), strict=True):
                    off = np.maximum(differences(found, elastic, friction, name, quantity), 1e-3)
                    panel.loglog(values[:-1], off, color=colour, marker=marker, linewidth=1, markersize=4,
                                 label=title if friction == 0 else None)
            panel.axhline(1.0, color="0.7", linewidth=1)
            panel.set(xlabel=TITLES[name], xticks=values[:-1], xticklabels=[f"{v:g}" for v in values[:-1]],
                      title=f"{'elastic' if elastic else 'plastic'}, against {values[-1]:g}")
            panel.minorticks_off()
        row[0].set_ylabel("difference (%)")
    figure.legend(*axes[0, 0].get_legend_handles_labels(), loc="outside lower center", ncols=len(READ), frameon=False)
    figure.savefig(folder / "convergence.png", dpi=130)


def tables(found: dict) -> str:
    lines = ["| | friction | " + " | ".join(READ.values()) + " | largest difference from the finest (%): mesh, step, "
             "enforcement | CPU (s) |", "|---" * (len(READ) + 4) + "|"]
    for elastic in (True, False):
        for friction in FRICTIONS:
            usual = found[elastic, friction, "cells", USUAL["cells"]]
            every = [[differences(found, elastic, friction, name, q)[1] for q in READ] for name in LEVELS]
            off = [[d for d in values if not np.isnan(d)] for values in every]
            lines.append(f"| {'elastic' if elastic else 'plastic'} | {friction:g} | " + " | ".join(
                "-" if np.isnan(usual[q]) else f"{usual[q]:.2f}" for q in READ)
                + f" | {', '.join(f'{max(o):.2f}' if o else '-' for o in off)} | {usual['cpu']:.0f} |")
    return "\n".join(lines) + "\n"


if __name__ == "__main__":
    folders = [argument for argument in sys.argv[1:] if argument != "--draw"]
    home = Path(folders[0] if folders else "results/double-plate-convergence")
    results = trace(home, jobs=0 if "--draw" in sys.argv else 2)
    draw(results, home)
    (home / "convergence.md").write_text(tables(results))
    print(tables(results))
