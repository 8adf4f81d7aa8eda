"""The bifurcation diagram as a picture, and its branches in words."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from ..continuation.state import CriticalPoint
from ..show.curves import draw_points, draw_stretches
from ..show.evaluate import told, unit_of, with_unit
from ..show.labels import place_labels
from .diagram import Traced, everything

WIDTHS = 2.4, 1.4, 1.0  # of lines, by level
FIELDS = ("kind", "load", "step", "length", "multiplicity", "name")
MOST_NAMES, PIECES = 16, 12


def draw_diagram(primary: Traced, axes_names: tuple[str, str]):
    """The matplotlib figure: load against the monitored deflection, and against the norm of all displacements.

    Branches that are the reverse of others are left out, as are those that are equivalent by symmetry.
    """
    from matplotlib.lines import Line2D

    from ..show.figure import Picture

    branches = [b for b in everything(primary) if not b.reverse_of and b.result["states"]]
    figure = Picture(figsize=(13.0, 5.2), layout="constrained")
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
    if key := branch_key(branches, axes_names[1]):
        figure.legend(len(key) * [Line2D([], [], linestyle="")], key, loc="outside right upper", frameon=False,
                      fontsize=8, handlelength=0, handletextpad=0, title="branches begin at", alignment="left")
    return figure


def branch_key(branches: Sequence[Traced], load: str) -> list[str]:
    """For each point at which named branches begin: their names, the point's kind and its load."""
    named: dict[tuple[str, float], list[str]] = {}
    for branch in _named(branches):
        named.setdefault((branch.origin["title"], branch.origin["load"]), []).append(branch.name)
    return [f"{', '.join(names)}: {title},\n{told(load, 'load')} {with_unit(at, unit_of(load))}"
            for (title, at), names in named.items()]


def _named(branches: Sequence[Traced]) -> list[Traced]:
    """Branches with names on the picture; where they are many, the first level's."""
    named = [branch for branch in branches if branch.origin]
    return named if len(named) <= MOST_NAMES else [branch for branch in named if "." not in branch.name]


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
    line += "".join(f"; point {point['number']}: {point['failure']}" for point in branch.points if point["failure"])
    return line + (f"; doubt: {branch.half['doubt']}" if branch.half and branch.half["doubt"] else "")


def _points(branch: Traced, quantity: str) -> list[CriticalPoint]:
    """Its critical points, with another quantity for the deflection."""
    return [CriticalPoint(deflection=p[quantity], **{f: p[f] for f in FIELDS})
            for p in branch.points if p[quantity] is not None and p["last_stage"]]


def _draw_branch(axes, branch: Traced, quantity: str) -> np.ndarray:
    """Draw a branch from its origin to its end, and return the points of its curve."""
    level = 0 if branch.origin is None else 1 + branch.name.count(".")
    named = branch.result["states"][-1]["unstable"] is not None
    return draw_stretches(axes, *_knots(branch, quantity), named=named, width=WIDTHS[min(level, len(WIDTHS) - 1)])


def _knots(branch: Traced, quantity: str) -> tuple[np.ndarray, np.ndarray]:
    """Points of a branch close together, and whether it is unstable between each and the next.

    Between states they are on the cubic with the tangents at both, which passes through critical points.
    """
    states, arrival, points = branch.result["states"], branch.result["arrival"], _points(branch, quantity)
    knots, unstable = [(states[0][quantity], states[0]["load"])], []
    if branch.origin:
        knots.insert(0, (branch.origin[quantity], branch.origin["load"]))
        unstable.append(bool(states[0]["unstable"]))
    curve = branch.cubic((quantity, "load")) if len(states) > 1 else None
    for start, before, after in zip(curve.x if curve else (), states[:-1], states[1:], strict=False):
        inside = [p for p in points if p.step == after["step"]]
        ends = [start + after["chord"] * part for part in [0.0, *(p.length / after["length"] for p in inside), 1.0]]
        for n, (left, right) in enumerate(pairwise(ends)):
            fine = curve(np.linspace(left, right, PIECES + 1)[1:])
            if n < len(inside):
                fine[-1] = inside[n].deflection, inside[n].load
            knots += map(tuple, fine)
            unstable += PIECES * [bool((after if n == len(inside) else before)["unstable"]) or 0 < n < len(inside)]
    if arrival:
        rest = [(p.deflection, p.load) for p in points if p.step > states[-1]["step"]]
        knots += [*rest, (arrival[quantity], arrival["load"])]
        unstable += (len(rest) + 1) * [bool(states[-1]["unstable"])]
    return np.array(knots), np.array(unstable)


def _names(branches: Sequence[Traced], curves: Sequence[np.ndarray]) -> list[tuple[float, float, str]]:
    """Places and names of branches, each in the middle of its curve."""
    chosen = _named(branches)
    return [(*curve[len(curve) // 2], branch.name) for branch, curve in zip(branches, curves, strict=True)
            if branch in chosen]
