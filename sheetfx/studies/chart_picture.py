"""Speed-accuracy charts: table on the terminal, file of numbers, picture."""

from __future__ import annotations

import csv
from collections.abc import Sequence
from pathlib import Path as Folder

import numpy as np
from rich.console import Console
from rich.table import Table

from ..show.labels import place_labels
from .chart import Point, rivals

COLUMNS = ("method", "label", "unknowns", "factorisations", "iterations", "cpu_seconds", "error_percent", "runs")
PANELS = (("cpu_seconds", "CPU time (s)"), ("unknowns", "unknowns"), ("factorisations", "factorisations"))
COLOURS = ("#0b4f8a", "#c4432b", "#3a7d44", "#8a5a0b", "#6a3d8a", "#2b8c9e")
MARKERS, PEER_MARKERS = "os^vDp", "*XP"
LEAST_PERCENT = 1e-4


def write_table(points: Sequence[Point], file: Folder) -> None:
    """Write the points with all their quantities as CSV."""
    names = [name for name in dict.fromkeys(n for p in points for n in p.quantities) if name not in COLUMNS]
    with Folder(file).open("w", newline="") as stream:
        writer = csv.writer(stream)
        writer.writerow([*COLUMNS, *names])
        for point in points:
            writer.writerow([*(getattr(point, c) for c in COLUMNS), *(point.quantities.get(n, "") for n in names)])


def print_table(points: Sequence[Point], console: Console) -> None:
    """Print the points, and CPU time at equal or smaller error as a share of each peer's."""
    table = Table("method", "parameters", box=None)
    for name in ("unknowns", "factorisations", "CPU s", "error %"):
        table.add_column(name, justify="right")
    for p in points:
        table.add_row(p.method, p.label, str(p.unknowns), str(p.factorisations), f"{p.cpu_seconds:.3g}",
                      f"{p.error_percent:.3g}")
    console.print(table)
    for peer, own in rivals(points):
        console.print(_comparison(peer, own), soft_wrap=True)


def _comparison(peer: Point, own: Point | None) -> str:
    rival = f"{peer.method} ({peer.label}; {peer.cpu_seconds:.3g} s, error {peer.error_percent:.3g} %)"
    if own is None:
        return f"no member is as accurate as {rival}"
    return (f"{own.cpu_seconds / peer.cpu_seconds:.3f} of the CPU time of {rival}: {own.method} ({own.label}; "
            f"{own.cpu_seconds:.3g} s, error {own.error_percent:.3g} %)")


def draw_chart(points: Sequence[Point], title: str):
    """The matplotlib figure: error against CPU time, unknowns and factorisations."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(9.6, 5.4), layout="constrained")
    FigureCanvasAgg(figure)
    grid = figure.add_gridspec(2, 2, width_ratios=(2, 1))
    panels = [figure.add_subplot(grid[:, 0]), figure.add_subplot(grid[0, 1]), figure.add_subplot(grid[1, 1])]
    for axes, (cost, label) in zip(panels, PANELS, strict=True):
        _draw_panel(axes, points, cost)
        axes.set(xlabel=label, ylabel="error (%)")
    main = panels[0]
    main.set_title(f"{title}: largest error of its reference quantities", fontsize=10, loc="left")
    main.margins(0.1)
    main.plot(*_front(points).T, color="#999999", linewidth=5.0, alpha=0.4, solid_capstyle="round", zorder=1,
                label="no other is faster and as accurate")
    main.legend(frameon=True, framealpha=0.9, edgecolor="none", fontsize=9)
    texts = [(p.cpu_seconds, _height(p), p.label) for p in points if p.label and not p.peer]
    lines = [_line(chosen, "cpu_seconds") for chosen in _methods(points).values()]
    place_labels(main, texts, np.concatenate([_fill(line) for line in lines]))
    return figure


def _height(point: Point) -> float:
    return max(point.error_percent, LEAST_PERCENT)


def _methods(points: Sequence[Point]) -> dict[tuple[bool, str], list[Point]]:
    """Points of each method in order of their unknowns; peers come last."""
    names = dict.fromkeys((p.peer, p.method) for p in sorted(points, key=lambda p: p.peer))
    return {name: sorted((p for p in points if (p.peer, p.method) == name), key=lambda p: p.unknowns)
            for name in names}


def _line(points: Sequence[Point], cost: str) -> np.ndarray:
    return np.array([(getattr(p, cost), _height(p)) for p in points], dtype=float)


def _front(points: Sequence[Point]) -> np.ndarray:
    """CPU time and error of the points that no other one beats in both."""
    found: list[tuple[float, float]] = []
    for place in sorted((p.cpu_seconds, _height(p)) for p in points):
        if not found or place[1] < found[-1][1]:
            found.append(place)
    return np.array(found)


def _fill(line: np.ndarray, pieces: int = 30) -> np.ndarray:
    """Points along the straight pieces of a line between logarithmic axes."""
    places = np.linspace(0, len(line) - 1, pieces * (len(line) - 1) + 1)
    return np.exp([np.interp(places, np.arange(len(line)), values) for values in np.log(line).T]).T


def _draw_panel(axes, points: Sequence[Point], cost: str) -> None:
    """A line for each method of ours, single markers for peers."""
    from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

    counts = {False: 0, True: 0}
    for (peer, method), chosen in _methods(points).items():
        style = {"linestyle": "none", "color": "black", "markersize": 9} if peer else {
            "color": COLOURS[counts[peer] % len(COLOURS)], "markersize": 5.5, "linewidth": 1.4}
        markers = PEER_MARKERS if peer else MARKERS
        marker = markers[counts[peer] % len(markers)]
        axes.loglog(*_line(chosen, cost).T, marker=marker, label=method, zorder=3, **style)
        counts[peer] += 1
    for axis in (axes.xaxis, axes.yaxis):
        low, high = np.log10(axis.get_view_interval())
        axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0) if high - low < 2 else (1.0,)))
        axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
        axis.set_minor_formatter(NullFormatter())
    axes.grid(color="#dddddd", linewidth=0.6)
    axes.set_axisbelow(True)
    axes.spines[["top", "right"]].set_visible(False)
