"""Load against deflection."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path as Folder

import numpy as np

from ..continuation.state import CriticalPoint, State
from ..record import Record
from .evaluate import communicator, most_telling, stays, unit_of, with_unit
from .labels import place_labels

STABLE, UNSTABLE = "#0b4f8a", "#c4432b"
MARKERS = {"limit": ("o", "limit point"), "bifurcation": ("D", "bifurcation point"), "flutter": ("v", "flutter"),
           "event": ("s", "event")}
MOST_LABELS = 6


def path_curve(record: Record, folder: Folder, name: str = "path.png") -> None:
    """Draw load against deflection with stability and critical points (process 0 writes the file)."""
    if communicator(record).rank == 0:
        figure = draw_path(record)
        figure.savefig(Folder(folder) / name, dpi=150)


def draw_path(record: Record, jumps: Sequence[tuple[State, State]] = ()):
    """The matplotlib figure of `path_curve`: of the last load stage, since each has a load of its own.

    Parameters
    ----------
    jumps : states between which labels leave room for arrows
    """
    figure, axes = _frame(record)
    states = [s for s in record.states if s.stage == record.states[-1].stage]
    knots, unstable = path_knots(states)
    if not knots[:, 0].any():
        axes.set_xlim(-1.0, 1.0)
    curve = draw_stretches(axes, knots, unstable, named=record.states[-1].unstable_modes is not None)
    axes.plot([s.deflection for s in states], [s.load for s in states], ".", color="#333333",
              markersize=3.5, zorder=3, label="converged states")
    points = [point for state in states for point in state.critical]
    draw_points(axes, points)
    axes.legend(frameon=True, framealpha=0.9, edgecolor="none", fontsize=9)
    unit = unit_of(record.case.axes[1])
    texts = [(p.deflection, p.load, f"{p.name if p.kind == 'event' else p.kind} {with_unit(p.load, unit)}")
             for p in most_telling(points, MOST_LABELS)]
    arrows = [np.linspace((a.deflection, a.load), (b.deflection, b.load), 100) for a, b in jumps]
    place_labels(axes, texts, np.concatenate([curve, *arrows]))
    return figure


def draw_branches(record: Record, branches: Sequence[tuple[CriticalPoint, Sequence[State]]]):
    """Matplotlib figure of a path with branches of its bifurcations.

    Parameters
    ----------
    branches : bifurcation and states of each branch, in order, the first being the start
    """
    figure, axes = _frame(record)
    named = record.states[-1].unstable_modes is not None
    for point, states in branches:
        knots, unstable = path_knots(states)
        knots = np.concatenate([[(point.deflection, point.load)], knots])
        unstable = np.concatenate([[bool(states[0].unstable_modes)], unstable])
        draw_stretches(axes, knots, unstable, named=named, width=0.9)
    draw_stretches(axes, *path_knots(record.states), named=named, width=2.4)
    draw_points(axes, record.critical_points)
    handles = dict(zip(*reversed(axes.get_legend_handles_labels()), strict=True))
    axes.legend(handles.values(), handles.keys(), frameon=True, framealpha=0.9, edgecolor="none", fontsize=9)
    return figure


def _frame(record: Record):
    """A figure and its axes, with the names of a record."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(8.0, 5.2), layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.add_subplot()
    axes.set_xlabel(record.case.axes[0])
    axes.set_ylabel(record.case.axes[1])
    axes.grid(color="#dddddd", linewidth=0.6)
    axes.set_axisbelow(True)
    axes.margins(x=0.05, y=0.12)
    axes.spines[["top", "right"]].set_visible(False)
    return figure, axes


def draw_stretches(axes, knots: np.ndarray, unstable: np.ndarray, named: bool, width: float = 1.6) -> np.ndarray:
    """Draw a smooth curve through knots by its stability, and return its points."""
    curve, segment = smooth(knots)
    flags = unstable[segment]
    for flag, colour, dashes, label in ((False, STABLE, "-", "stable" if named else "path"),
                                        (True, UNSTABLE, (0, (5, 2)), "unstable")):
        for i, (first, last) in enumerate(_runs(flags == flag)):
            axes.plot(*curve[first:last + 1].T, color=colour, linestyle=dashes, linewidth=width, zorder=2,
                      label=label if i == 0 else None)
    return curve


def draw_points(axes, points: list[CriticalPoint]) -> None:
    for kind, (marker, label) in MARKERS.items():
        chosen = [p for p in points if p.kind == kind]
        if chosen:
            axes.plot([p.deflection for p in chosen], [p.load for p in chosen], marker, color="white",
                      markeredgecolor="black", markeredgewidth=1.3, markersize=7, zorder=4, label=_count(label, chosen))


def path_knots(states: Sequence[State]) -> tuple[np.ndarray, np.ndarray]:
    """Points of the path in order, and whether it is unstable between each and the next.

    Events change no stability. Deflections that are zero but for rounding are zero.

    Returns
    -------
    (n, 2) deflection and load of states and critical points; (n - 1,) bool
    """
    rows, unstable = [(states[0].deflection, states[0].load)], []
    points = [p for s in states for p in s.critical]
    for before, after in zip(states[:-1], states[1:], strict=True):
        inside = [p for p in points if p.step == after.step]
        changes = np.cumsum([0, *(p.kind != "event" for p in inside)])
        unstable += [bool((after if n == changes[-1] else before).unstable_modes) or 0 < n < changes[-1]
                     for n in changes]
        rows += [*((p.deflection, p.load) for p in inside), (after.deflection, after.load)]
    knots = np.array(rows)
    if stays(states):
        knots[:, 0] = 0.0
    return knots, np.array(unstable, dtype=bool)


def smooth(knots: np.ndarray, pieces: int = 12) -> tuple[np.ndarray, np.ndarray]:
    """Monotone cubic curve through points, by the length of the chords: it has no extremes but at points.

    Returns
    -------
    (m, 2) points; (m - 1,) number of the interval between knots that each piece lies in
    """
    from scipy.interpolate import PchipInterpolator

    extent = np.ptp(knots, axis=0)
    chords = np.linalg.norm(np.diff(knots, axis=0) / np.where(extent > 0, extent, 1), axis=1)
    parameter = np.concatenate([[0], np.cumsum(np.maximum(chords, 1e-9))])
    if len(knots) < 3:
        return knots, np.arange(len(knots) - 1)
    start, step = parameter[:-1, None], np.diff(parameter)[:, None]
    fine = np.append((start + step * np.arange(pieces) / pieces).ravel(), parameter[-1])
    return PchipInterpolator(parameter, knots)(fine), np.repeat(np.arange(len(knots) - 1), pieces)


def _runs(chosen: np.ndarray) -> list[tuple[int, int]]:
    """First and one past the last index of each stretch of true values."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], chosen, [False]]).astype(int)))
    return list(zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True))


def _count(label: str, chosen: list[CriticalPoint]) -> str:
    return label if len(chosen) == 1 else f"{label}s ({len(chosen)})"
