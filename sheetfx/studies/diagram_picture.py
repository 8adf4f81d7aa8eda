"""The bifurcation diagram as a picture, and its branches in words."""

from __future__ import annotations

from collections.abc import Sequence
from types import SimpleNamespace

import numpy as np

from ..continuation.state import CriticalPoint
from ..show.curves import draw_points, draw_stretches, path_knots
from ..show.labels import place_labels
from .diagram import Traced, everything

WIDTHS = 2.4, 1.4, 1.0  # of lines, by level
FIELDS = ("kind", "load", "step", "length", "multiplicity", "name")
MOST_NAMES = 16


def draw_diagram(primary: Traced, axes_names: tuple[str, str]):
    """The matplotlib figure: load against the monitored deflection, and against the norm of all displacements.

    Branches that are the reverse of others are left out, as are those that are equivalent by symmetry.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    branches = [b for b in everything(primary) if not b.reverse_of and b.result["states"]]
    figure = Figure(figsize=(11.0, 5.2), layout="constrained")
    FigureCanvasAgg(figure)
    left, right = figure.subplots(1, 2, sharey=True)
    for axes, quantity, name in ((left, "deflection", axes_names[0]),
                                 (right, "norm", "root mean square of nodal displacements")):
        axes.set_xlabel(name)
        axes.grid(color="#dddddd", linewidth=0.6)
        axes.set_axisbelow(True)
        axes.margins(x=0.06, y=0.1)
        axes.spines[["top", "right"]].set_visible(False)
        curves = [_draw_branch(axes, branch, quantity) for branch in reversed(branches)]
        draw_points(axes, [p for branch in branches for p in _points(branch, quantity)])
        place_labels(axes, _names(branches, list(reversed(curves))), np.concatenate(curves))
    left.set_ylabel(axes_names[1])
    handles = dict(zip(*reversed(left.get_legend_handles_labels()), strict=True))
    names = sorted(handles)
    figure.legend([handles[n] for n in names], names, loc="outside lower center", ncols=len(names), frameon=False,
                  fontsize=9, handlelength=3.2)
    return figure


def describe(branch: Traced) -> str:
    """What became of a branch, in one line."""
    origin, arrival = branch.origin, branch.result["arrival"]
    line = "primary path" if origin is None else (
        f"branch {branch.name} from the {origin['title'].replace(' point', '')} at load {origin['load']:.6g}")
    if branch.half and branch.half["equivalent"] > 1:
        line += f" ({branch.half['equivalent']} equivalent ones)"
    if branch.half and branch.half["family"]:
        line += " (one of a family)"
    line += f": {len(branch.result['states'])} states, {len(branch.points)} critical points"
    line += "; " + (branch.result["message"] if not arrival else f"ends at point {arrival['point']}")
    return line + (f"; doubt: {branch.half['doubt']}" if branch.half and branch.half["doubt"] else "")


def _points(branch: Traced, quantity: str) -> list[CriticalPoint]:
    """Its critical points, with another quantity for the deflection."""
    return [CriticalPoint(deflection=p[quantity], **{f: p[f] for f in FIELDS})
            for p in branch.points if p[quantity] is not None]


def _draw_branch(axes, branch: Traced, quantity: str) -> np.ndarray:
    """Draw a branch from its origin to its end, and return the points of its curve."""
    result, points = branch.result, _points(branch, quantity)
    largest = np.array([max(s["norm"] for s in result["states"])])
    states = [SimpleNamespace(step=s["step"], load=s["load"], deflection=s[quantity], unstable_modes=s["unstable"],
                              critical=[p for p in points if p.step == s["step"]], increment=largest)
              for s in result["states"]]
    if branch.origin:
        states.insert(0, SimpleNamespace(**vars(states[0]) | {
            "step": states[0].step - 1, "load": branch.origin["load"], "deflection": branch.origin[quantity],
            "critical": []}))
    if arrival := result["arrival"]:
        states.append(SimpleNamespace(**vars(states[-1]) | {
            "step": states[-1].step + 1, "load": arrival["load"], "deflection": arrival[quantity],
            "critical": [p for p in points if p.step > states[-1].step]}))
    level = 0 if branch.origin is None else 1 + branch.name.count(".")
    named = states[-1].unstable_modes is not None
    return draw_stretches(axes, *path_knots(states), named=named, width=WIDTHS[min(level, len(WIDTHS) - 1)])


def _names(branches: Sequence[Traced], curves: Sequence[np.ndarray]) -> list[tuple[float, float, str]]:
    """Places and names of branches, each in the middle of its curve; where they are many, of the first level."""
    named = [(branch.name, curve) for branch, curve in zip(branches, curves, strict=True) if branch.origin]
    if len(named) > MOST_NAMES:
        named = [(name, curve) for name, curve in named if "." not in name]
    return [(*curve[len(curve) // 2], name) for name, curve in named]
