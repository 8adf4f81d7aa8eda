"""Picture of the dome's joints: `python3 demos/studies/joints.py FOLDER [FOLDER] [-o FILE]`.

The folders are those of `sheetfx study dome --model contact --vary faces=... --vary weld=... --vary tie=...`, the
second one with a finer mesh. Paths are dotted where they are unstable.
"""

from __future__ import annotations

import argparse
import csv
from itertools import groupby
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

FACES, TIES = ("seat", "butt", "both"), ("weld", "hinge")
COLOURS = {100: "#c4432b", 200: "#0b4f8a", 400: "#2e8b57"}
STYLES = {"width": (2.0, 0.9), "alpha": (0.55, 1.0)}  # of the first folder, and of the second


def path_of(folder: Path, faces: str, weld: int, tie: str) -> tuple[np.ndarray, list[bool]] | None:
    """Deflections (mm) and loads (kN) of a run, shape (states, 2), and whether each state is unstable; None: no run."""
    file = folder / "runs" / f"faces={faces},weld={weld},tie={tie}" / "path.csv"
    if not file.exists():
        return None
    with file.open(encoding="utf-8") as lines:
        rows = list(csv.DictReader(lines))
    points = np.array([(float(row["deflection"]), float(row["load"]) / 1e3) for row in rows])
    return points, [row["unstable"] not in ("", "0") for row in rows]


def draw(folders: list[Path]) -> Figure:
    """A panel for each tie and face, a curve for each length of welds and folder."""
    figure = Figure(figsize=(11.0, 6.6), layout="constrained")
    panels = figure.subplots(len(TIES), len(FACES), sharex=True, sharey=True)
    for row, tie in zip(panels, TIES, strict=True):
        for axes, faces in zip(row, FACES, strict=True):
            axes.set_title(f"{faces}, {tie}", loc="left", fontsize=10)
            axes.grid(color="#dddddd", linewidth=0.6)
            axes.spines[["top", "right"]].set_visible(False)
            for weld in COLOURS:
                for number, folder in enumerate(folders):
                    if (path := path_of(folder, faces, weld, tie)) is not None:
                        draw_path(axes, *path, color=COLOURS[weld], linewidth=STYLES["width"][number],
                                  alpha=STYLES["alpha"][number])
    for weld, colour in COLOURS.items():
        panels[0][0].plot([], [], color=colour, label=f"welds of {weld} mm")
    panels[0][0].plot([], [], ":", color="#555555", label="unstable")
    if len(folders) > 1:
        panels[0][0].plot([], [], color="#555555", linewidth=STYLES["width"][1], label="finer mesh")
    panels[0][0].legend(frameon=False, fontsize=8)
    figure.supxlabel("deflection of the apex (mm)", fontsize=10)
    figure.supylabel("load (kN)", fontsize=10)
    return figure


def draw_path(axes, points: np.ndarray, unstable: list[bool], **style) -> None:
    """Pieces between states: dotted where the one behind is unstable, ended by a cross where the path has stopped."""
    for dotted, pieces in groupby(range(1, len(points)), key=lambda n: unstable[n]):
        stretch = list(pieces)
        axes.plot(*points[stretch[0] - 1:stretch[-1] + 1].T, ":" if dotted else "-", **style)
    if points[-1, 0] < 0.99 * 20.0:
        axes.plot(*points[-1], "x", color=style["color"], markersize=6)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folders", nargs="+", type=Path)
    parser.add_argument("-o", "--output", type=Path, default=Path("dome_joints.png"))
    given = parser.parse_args()
    draw(given.folders).savefig(given.output, dpi=130)
