"""Load against deflection with the jumps that structures take."""

from __future__ import annotations

from collections.abc import Sequence

from ..case import Record
from ..solve.snap import Snap
from .curves import draw_path

JUMP = "#2a7f3b"


def draw_snaps(record: Record, snaps: Sequence[Snap]):
    """Matplotlib figure of a path with the falls that leave it, each with the energy that it releases."""
    figure = draw_path(record)
    axes = figure.axes[0]
    for snap in snaps:
        start, end = ((state.deflection, state.load) for state in (snap.before, snap.after))
        axes.annotate("", end, start, zorder=5,
                      arrowprops={"arrowstyle": "-|>", "color": JUMP, "linewidth": 1.6, "shrinkA": 0, "shrinkB": 0})
        middle = [(a + b) / 2 for a, b in zip(start, end, strict=True)]
        axes.annotate(f"held {snap.hold}\n{snap.energy_released:.4g} released", middle, textcoords="offset points",
                      xytext=(8, 8), color=JUMP, fontsize=9)
    return figure
