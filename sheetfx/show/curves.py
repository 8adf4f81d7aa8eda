"""Load against deflection."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path as Folder
from typing import TYPE_CHECKING

import numpy as np

from ..continuation.state import CriticalPoint, State
from .course import curve_of, monitored, points_in
from .evaluate import most_telling, stays, unit_of, with_unit
from .labels import place_labels
from .saving import save_picture
from .shown import Shown

if TYPE_CHECKING:
    from ..critical.error_bar import ErrorBar

STABLE, UNSTABLE = "#0b4f8a", "#c4432b"
MARKERS = {"limit": ("o", "limit point"), "bifurcation": ("D", "bifurcation point"), "flutter": ("v", "flutter"),
           "event": ("s", "event")}
MOST_LABELS = 6
DPI, VIEWS = 150, 100  # of a curve alone, and of one beside views
DOMINANT, SEEN = 1.0, 0.35  # of the extent of all other states, how far the last may be off before it is left out
FEWEST = 6  # states of a path, from which its last may be left out


def path_curve(record: Shown, folder: Folder, name: str = "path.png") -> None:
    """Draw load against deflection with stability and critical points (process 0 writes the file).

    A path of a single state has no curve to draw.
    """
    if len(record.states) > 1:
        figure = draw_path(record)
        save_picture(record, lambda: figure, Folder(folder) / name)


def draw_path(record: Shown, jumps: Sequence[tuple[State, State]] = ()):
    """The matplotlib figure of `path_curve`: of the last load stage, since each has a load of its own.

    Parameters
    ----------
    jumps : states between which labels leave room for arrows
    """
    figure, axes = frame(record)
    states = _last_stage(record)
    knots, _ = path_knots(states)
    curve = draw_course(axes, record)
    axes.plot([s.deflection for s in states], [s.load for s in states], ".", color="#333333",
              markersize=3.5, zorder=3, label="converged states")
    points = [point for state in states for point in state.critical]
    draw_points(axes, points)
    draw_errors(axes, [record.errors[p] for p in points if p in record.errors])
    legend_above(axes)
    arrows = [np.linspace((a.deflection, a.load), (b.deflection, b.load), 100) for a, b in jumps]
    _leave_out_last(axes, record, states, np.concatenate([knots[:-1], *arrows]), knots[-1])
    unit = unit_of(record.case.axes[1])
    texts = [(p.deflection, p.load, f"{p.name if p.kind == 'event' else p.kind} {with_unit(p.load, unit)}")
             for p in most_telling(points, MOST_LABELS)]
    place_labels(axes, texts, np.concatenate([curve, *arrows]))
    return figure


def draw_course(axes, record: Shown) -> np.ndarray:
    """Draw the curve of the last load stage by its stability, and return its points."""
    states = _last_stage(record)
    knots, unstable = path_knots(states)
    if not knots[:, 0].any():
        axes.set_xlim(-1.0, 1.0)
    return draw_stretches(axes, knots, unstable, named=record.states[-1].unstable_modes is not None,
                          smoothly=partial(_course, record, states))


def curve_points(record: Shown) -> np.ndarray:
    """Deflections and loads close together on the curve of the last load stage, (n, 2).

    Between states they are on Hermite's cubic with the tangents of both.
    """
    states = _last_stage(record)
    return _course(record, states, path_knots(states)[0])[0]


def _last_stage(record: Shown) -> list[State]:
    return [s for s in record.states if s.stage == record.states[-1].stage]


def _course(record: Shown, states: Sequence[State], knots: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The curve through the knots of a path, by the tangents of its states, and the interval of each piece."""
    values, rates = monitored(record, states)
    curve, segment = curve_of(record, states, values, rates, lambda p: (p.deflection, p.load), stationary=1)
    if not knots[:, 0].any():
        curve[:, 0] = 0.0
    return curve, segment


def legend_above(axes) -> None:
    """A legend in a row above the axes, where it hides nothing, each name once."""
    handles = dict(zip(*reversed(axes.get_legend_handles_labels()), strict=True))
    axes.legend(handles.values(), handles.keys(), loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=len(handles),
                frameon=False, fontsize=9, columnspacing=1.4, handlelength=1.8, borderaxespad=0.2)


def _leave_out_last(axes, record: Shown, states: Sequence[State], others: np.ndarray, last: np.ndarray) -> None:
    """Let axes show the path without its last state where that would have most of them for itself, and say where it is.

    The step that leads there leaves the frame.
    """
    if len(states) < FEWEST or not any(s.critical for s in states[:-1]):
        return
    low, high = others.min(axis=0), others.max(axis=0)
    extent = high - low
    beyond = np.maximum(np.maximum(last - high, low - last), 0.0)
    if not (beyond > DOMINANT * extent).any() or not extent.all():
        return
    room = np.minimum(beyond, SEEN * extent)
    below, above = np.where(last < low, room, 0.0), np.where(last > high, room, 0.0)
    axes.set_xlim(low[0] - below[0] - 0.05 * extent[0], high[0] + above[0] + 0.05 * extent[0])
    axes.set_ylim(low[1] - below[1] - 0.12 * extent[1], high[1] + above[1] + 0.12 * extent[1])
    length, force = map(unit_of, record.case.axes)
    axes.text(1.0, -0.085, f"goes on to {with_unit(last[0], length)}, {with_unit(last[1], force)}", fontsize=9,
              color="#333333", ha="right", va="top", transform=axes.transAxes)


def draw_branches(record: Shown, branches: Sequence[tuple[CriticalPoint, Sequence[State]]]):
    """Matplotlib figure of a path with branches of its bifurcations.

    Parameters
    ----------
    branches : bifurcation and states of each branch, in order, the first being the start
    """
    figure, axes = frame(record)
    named = record.states[-1].unstable_modes is not None
    for point, states in branches:
        knots, unstable = path_knots(states)
        knots = np.concatenate([[(point.deflection, point.load)], knots])
        unstable = np.concatenate([[bool(states[0].unstable_modes)], unstable])
        draw_stretches(axes, knots, unstable, named=named, width=0.9)
    draw_stretches(axes, *path_knots(record.states), named=named, width=2.4)
    draw_points(axes, record.critical_points)
    legend_above(axes)
    return figure


def frame(record: Shown, place: Sequence[float] | None = None, size: Sequence[int] = (1200, 780)):
    """A figure and its axes, with the names of a record.

    Parameters
    ----------
    place : of the axes in the figure (left, bottom, width, height); None: all of it
    size : in pixels
    """
    from .figure import Picture

    layout, dpi = ("none", VIEWS) if place else ("constrained", DPI)
    figure = Picture(figsize=np.array(size) / dpi, dpi=dpi, layout=layout)
    axes = figure.add_axes(place) if place else figure.add_subplot()
    axes.set_xlabel(record.case.axes[0])
    axes.set_ylabel(record.case.axes[1])
    axes.grid(color="#dddddd", linewidth=0.6)
    axes.set_axisbelow(True)
    axes.margins(x=0.05, y=0.12)
    axes.spines[["top", "right"]].set_visible(False)
    return figure, axes


def draw_stretches(axes, knots: np.ndarray, unstable: np.ndarray, named: bool, width: float = 1.6,
                   smoothly: Callable | None = None) -> np.ndarray:
    """Draw a smooth curve through knots by its stability, and return its points.

    Parameters
    ----------
    smoothly : function from knots to the curve's points and the interval of each of its pieces; None: `smooth`
    """
    curve, segment = (smoothly or smooth)(knots)
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


def draw_errors(axes, bars: Sequence[ErrorBar]) -> None:
    """Draw from critical loads to where their error estimates put them."""
    known = [(bar.point.deflection, bar.point.load, bar.error) for bar in bars if bar.error is not None]
    if known:
        x, y, error = np.array(known).T
        axes.errorbar(x, y, yerr=[np.maximum(error, 0.0), np.maximum(-error, 0.0)], fmt="none", ecolor="black",
                      elinewidth=1.0, capsize=3.0, zorder=3, label="estimated error")


def path_knots(states: Sequence[State]) -> tuple[np.ndarray, np.ndarray]:
    """Points of the path in order, and whether it is unstable between each and the next.

    Events change no stability. A fall, which ends in a state that no step leads to, is no stable way.
    Deflections that are zero but for rounding are zero.

    Returns
    -------
    (n, 2) deflection and load of states and critical points; (n - 1,) bool
    """
    rows, unstable = [(states[0].deflection, states[0].load)], []
    for before, after in zip(states[:-1], states[1:], strict=True):
        inside = points_in(states, after)
        changes = np.cumsum([0, *(p.kind != "event" for p in inside)])
        unstable += [bool((after if n == changes[-1] else before).unstable_modes) or 0 < n < changes[-1]
                     or (getattr(after, "length", None) == 0.0 and n == changes[-1]) for n in changes]
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
