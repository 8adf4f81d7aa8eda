"""Critical loads of a scene against one of its options, as a table, named points and a picture."""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Callable, Sequence
from pathlib import Path as Folder

from ..archive.folder import write_whole
from ..case import Case
from ..critical.curve import CriticalCurve, CurvePoint, Kept
from ..critical.defining import without_third_variations
from ..discrete.discretisation import Discretisation
from .curve_by_paths import CurveByPaths
from .numbered_point import path_to_point

FILES = "curve.csv", "points.json", "curve.png", "kept/*.npz"
COLUMNS = "parameter", "load", "deflection", "kind"


def curve_of(name: str, first: Case, case: Callable[[float], Case], number: int, key: str, ends: tuple[float, float],
             parts: int, kept: Kept | None, known: Sequence[CurvePoint]) -> CriticalCurve | CurveByPaths:
    """The curve of a critical point of the first case, or what goes on from where another run of it was.

    Raises
    ------
    ValueError
        If the path has not so many critical points.
    """
    if without_third_variations(Discretisation(first.scene).system):
        return CurveByPaths(case, *ends, number=number, steps=parts, known=known)
    record, point = path_to_point(first, number, f"{name} with {key} = {ends[0]:g}")
    curve = CriticalCurve(point, record.state_at(point), record.critical_modes(point), lambda value: case(value).scene,
                          *ends, steps=parts)
    curve.kept = kept
    return curve


def written(points: Sequence[CurvePoint], folder: Folder) -> None:
    """Write `curve.csv`, all points, and `points.json`, those with a name."""
    text = io.StringIO()
    table = csv.writer(text, lineterminator="\n")
    table.writerow(COLUMNS)
    table.writerows((repr(p.number), repr(p.load), repr(p.deflection), p.kind) for p in points)
    write_whole(folder / "curve.csv", text.getvalue())
    named = [{"name": p.name, "parameter": p.number, "load": p.load, "deflection": p.deflection, "kind": p.kind}
             for p in points if p.name]
    write_whole(folder / "points.json", json.dumps(named, indent=2) + "\n")


def begun(folder: Folder) -> list[CurvePoint]:
    """The points that `written` wrote."""
    names = {(p["parameter"], p["load"]): p["name"] for p in json.loads((folder / "points.json").read_text())}
    with (folder / "curve.csv").open(newline="") as stream:
        rows = [(float(r["parameter"]), float(r["load"]), float(r["deflection"]), r["kind"])
                for r in csv.DictReader(stream)]
    return [CurvePoint(number, load, deflection, kind, names.get((number, load), ""))
            for number, load, deflection, kind in rows]


def draw(points: Sequence[CurvePoint], key: str, axis: str, title: str, file: Folder) -> None:
    """Load against the option, with the named points."""
    from ..show.figure import Picture

    figure = Picture(figsize=(7.0, 4.5), dpi=150, layout="constrained")
    axes = figure.add_subplot()
    axes.plot([p.number for p in points], [p.load for p in points], ".-", color="#0b4f8a", markersize=3.5,
              label=f"{points[-1].kind} points")
    for name in dict.fromkeys(p.name for p in points if p.name):
        those = [p for p in points if p.name == name]
        axes.plot([p.number for p in those], [p.load for p in those], "D", markersize=6, label=name)
    axes.set_xlabel(key)
    axes.set_ylabel(axis)
    axes.set_title(f"{title}: critical load against {key}", fontsize=10)
    axes.grid(color="#dddddd", linewidth=0.6)
    axes.legend(frameon=False, fontsize=9)
    axes.spines[["top", "right"]].set_visible(False)
    figure.savefig(file)
