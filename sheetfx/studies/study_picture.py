"""A study as tables and as a picture: the paths of all runs, and their first critical loads against the option."""

from __future__ import annotations

import csv
from collections.abc import Sequence
from itertools import groupby
from pathlib import Path as Folder
from typing import Any

import numpy as np
from rich.console import Console
from rich.table import Table

from ..show.curves import MARKERS, path_knots, smooth
from .study import FINISHED, Run, written

MOST_POINTS, MOST_NAMES, DECADES = 3, 20, 100.0  # points of a run on a line, runs in a legend, range of a log axis
POINT = ("kind", "name", "load", "deflection", "step", "multiplicity", "slope", "curvature")
RESULTS = ("status", "critical_points", "first_kind", "first_load", "first_deflection", "limit_load",
           "limit_deflection", "initial_stiffness", "unknowns", "steps", "factorisations", "cpu_seconds", "message")
NUMBERS = (("limit_load", ".5g"), ("initial_stiffness", ".5g"), ("steps", "d"), ("factorisations", "d"),
           ("cpu_seconds", ".2f"))


def results(run: Run) -> dict[str, Any]:
    """The figures listed of a run, by the names of RESULTS; absent ones are missing."""
    row = {"status": run.status, "message": run.message, "critical_points": len(run.points)}
    row |= {name: run.summary[name] for name in ("unknowns", "steps", "factorisations") if run.summary}
    row |= {name: value for name, value in run.summary.get("quantities", {}).items() if name == "initial_stiffness"}
    if run.summary:
        row["cpu_seconds"] = run.summary["timings"]["total"]
    if run.points:
        first = run.points[0]
        row |= {"first_kind": first.kind, "first_load": first.load, "first_deflection": first.deflection}
    if run.limit:
        row |= {"limit_load": run.limit.load, "limit_deflection": run.limit.deflection}
    return row


def describe(run: Run) -> str:
    """What became of a run, in one line."""
    points = f"{len(run.points)} critical point{'' if len(run.points) == 1 else 's'}"
    return f"{run.name}: {run.status}, {f'{points}, ' if run.states else ''}{run.message}"


def write_table(runs: Sequence[Run], file: Folder) -> None:
    """Write one line for each run, with the quantities of its scene at the end."""
    quantities = dict.fromkeys(name for run in runs for name in run.summary.get("quantities", {}))
    names = [*runs[0].chosen, *RESULTS]
    _write(file, dict.fromkeys([*names, *quantities]),
           [run.summary.get("quantities", {}) | results(run) | run.chosen for run in runs])


def write_points(runs: Sequence[Run], file: Folder) -> None:
    """Write one line for each critical point of each run."""
    _write(file, [*runs[0].chosen, *POINT],
           [{name: getattr(point, name) for name in POINT} | run.chosen for run in runs for point in run.points])


def _write(file: Folder, names, rows: Sequence[dict[str, Any]]) -> None:
    with Folder(file).open("w", newline="") as stream:
        writer = csv.DictWriter(stream, list(names), extrasaction="ignore")
        writer.writeheader()
        writer.writerows(rows)


def print_table(runs: Sequence[Run], console: Console) -> None:
    """Print the runs with their first critical points."""
    table = Table(*runs[0].chosen, box=None, pad_edge=False, collapse_padding=True)
    table.add_column("critical points", no_wrap=True)
    for name in ("limit\nload", "initial\nstiffness", "steps", "tangents\nfactored", "CPU s"):
        table.add_column(name, justify="right", no_wrap=True)
    for run in runs:
        row = results(run)
        cells = (f"{row[name]:{form}}" if name in row else "-" for name, form in NUMBERS)
        table.add_row(*map(written, run.chosen.values()), _in_words(run), *cells)
    console.print(table)


def _in_words(run: Run) -> str:
    """Its first critical points, each on a line, and why it failed."""
    lines = [f"{p.kind} {p.load:.5g} at {p.deflection:.4g}" for p in run.points[:MOST_POINTS]]
    if len(run.points) > MOST_POINTS:
        lines.append(f"and {len(run.points) - MOST_POINTS} more")
    if run.status != FINISHED:
        lines.append(f"{run.status}: {run.message}")
    return "\n".join(lines or ["none"])


def draw_study(runs: Sequence[Run], title: str, axes_names: tuple[str, str]):
    """The matplotlib figure: all paths, and the first critical load of each run against the first varied option.

    Paths are dashed where they are unstable. Where there are no critical points, there is no second chart.
    """
    from matplotlib import colormaps
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    drawn = [run for run in runs if run.states]
    with_points = [run for run in drawn if run.points]
    figure = Figure(figsize=(11.0 if with_points else 7.5, 5.4), layout="constrained")
    FigureCanvasAgg(figure)
    panels = figure.subplots(1, 2 if with_points else 1, squeeze=False)[0]
    colours = {run.name: colormaps["viridis"](place) for run, place in
               zip(drawn, np.linspace(0.0, 0.88, len(drawn)), strict=True)}
    for axes in panels:
        axes.grid(color="#dddddd", linewidth=0.6)
        axes.set_axisbelow(True)
        axes.spines[["top", "right"]].set_visible(False)
    for n, run in enumerate(drawn):
        _draw_path(panels[0], run, colours[run.name], named=n % (1 + (len(drawn) - 1) // MOST_NAMES) == 0)
    panels[0].set(xlabel=axes_names[0], ylabel=axes_names[1])
    panels[0].set_title(title, fontsize=10, loc="left")
    if with_points:
        _draw_loads(panels[1], with_points, colours)
        panels[1].set_ylabel(f"first critical {axes_names[1]}")
    figure.legend(loc="outside lower center", ncols=3, frameon=False, fontsize=8)
    return figure


def _draw_path(axes, run: Run, colour, named: bool) -> None:
    """Its curve, stretch by stretch, and its critical points."""
    from matplotlib.lines import Line2D

    knots, unstable = path_knots(run.states)
    curve, segment = smooth(knots)
    for is_unstable, pieces in groupby(range(len(curve) - 1), key=lambda piece: unstable[segment[piece]]):
        stretch = list(pieces)
        axes.plot(*curve[stretch[0]:stretch[-1] + 2].T, color=colour, linewidth=1.4,
                  linestyle=(0, (4, 2)) if is_unstable else "-")
    for point in run.points:
        axes.plot(point.deflection, point.load, _marker(point), color="white", markeredgecolor=colour, markersize=5)
    if named:
        axes.add_line(Line2D([], [], color=colour, label=", ".join(
            f"{name.replace('_', ' ')} {written(value)}" for name, value in run.chosen.items())))


def _draw_loads(axes, runs: Sequence[Run], colours) -> None:
    """A line for each combination of the other options; axes that span decades are logarithmic."""
    first, *others = runs[0].chosen
    numeric = all(isinstance(run.chosen[first], int | float) and not isinstance(run.chosen[first], bool)
                  for run in runs)
    names = list(dict.fromkeys(written(run.chosen[first]) for run in runs))
    places = {run.name: run.chosen[first] if numeric else names.index(written(run.chosen[first])) for run in runs}
    lines: dict[str, list[Run]] = {}
    for run in runs:
        lines.setdefault(", ".join(f"{name.replace('_', ' ')} {written(run.chosen[name])}" for name in others),
                         []).append(run)
    for text, members in lines.items():
        members.sort(key=lambda run: places[run.name])
        table = np.array([(places[run.name], run.points[0].load) for run in members])
        axes.plot(*table.T, color="#999999", linewidth=0.9, zorder=1)
        if text and len(lines) <= MOST_NAMES:
            axes.annotate(text, table[-1], xytext=(6, 0), textcoords="offset points", fontsize=8, va="center")
        for run, place in zip(members, table, strict=True):
            axes.plot(*place, _marker(run.points[0]), color=colours[run.name], markersize=7, zorder=2)
    axes.set_xlabel(first.replace("_", " "))
    if numeric:
        axes.set_xscale(_scale(places.values()))
    else:
        axes.set_xticks(range(len(names)), names)
    axes.set_yscale(_scale(run.points[0].load for run in runs))
    for kind, (marker, text) in MARKERS.items():
        if any(run.points[0].kind == kind for run in runs):
            axes.plot([], [], marker, color="#555555", label=f"first: {text}")


def _scale(values) -> str:
    """Scale of an axis for values of one kind."""
    low, high = min(values := list(values)), max(values)
    return "log" if low > 0 and high >= DECADES * low else "linear"


def _marker(point) -> str:
    return MARKERS[point.kind][0]
