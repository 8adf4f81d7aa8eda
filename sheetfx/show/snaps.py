"""Load against deflection with the jumps that structures take."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path as Folder

from ..critical.fall import SnapFailure
from ..critical.snap import Snap, snaps
from ..notices import warn
from .curves import draw_path
from .evaluate import communicator
from .saving import save_picture
from .shown import Shown

JUMP = "#2a7f3b"


def falls_curve(record: Shown, folder: Folder, name: str = "falls.png") -> None:
    """Draw where the structure falls while the load is held, and save each fall in a folder of its own.

    The picture is left out with a warning where a fall finds no stable state.
    """
    comm = communicator(record)
    try:
        falls = snaps(record.path, record.states)
    except SnapFailure as failure:
        warn(f"{name} is not drawn: {failure}")
        return
    for number, fall in enumerate(falls, start=1):
        fall.save(Folder(folder) / f"fall{number}", comm)
    figure = draw_snaps(record, falls)
    save_picture(record, lambda: figure, Folder(folder) / name)


def draw_snaps(record: Shown, falls: Sequence[Snap]):
    """Matplotlib figure of a path with the falls that leave it, each with the energy that it releases."""
    figure = draw_path(record, [(fall.before, fall.after) for fall in falls])
    axes = figure.axes[0]
    if falls:  # an arrow that ends outside of the axes is not drawn
        axes.update_datalim([(fall.after.deflection, fall.after.load) for fall in falls])
        axes.autoscale_view()
    for snap in falls:
        start, end = ((state.deflection, state.load) for state in (snap.before, snap.after))
        axes.annotate("", end, start, zorder=5,
                      arrowprops={"arrowstyle": "-|>", "color": JUMP, "linewidth": 1.6, "shrinkA": 0, "shrinkB": 0})
        middle = [(a + b) / 2 for a, b in zip(start, end, strict=True)]
        axes.annotate(f"held {snap.hold}\n{snap.energy_released:.4g} released", middle, textcoords="offset points",
                      xytext=(8, 8), color=JUMP, fontsize=9)
    return figure
