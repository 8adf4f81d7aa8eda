"""The failure map as a picture and on the terminal."""

from __future__ import annotations

from collections.abc import Sequence
from textwrap import fill, wrap

from .failure_map import Cell
from .judgement import CRASHED, JUMPED, OUTCOMES, PASSED

COLOURS = dict(zip(OUTCOMES, ("#7fc097", "#f2c14e", "#c4432b", "#e58a3c", "#9fb3c8", "#5a5a5a"), strict=True))
WIDTH, HEIGHT, SIDE = 1.3, 0.5, 2.2
LETTERS, LINES = 34, 3


def draw_map(cells: Sequence[Cell]):
    """The matplotlib figure: a row for each trap, a column for each method."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure
    from matplotlib.patches import Patch

    traps, methods = (list(dict.fromkeys(getattr(c, name) for c in cells)) for name in ("trap", "method"))
    figure = Figure(figsize=(SIDE + WIDTH * len(methods), SIDE + HEIGHT * len(traps)), layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.add_subplot()
    for cell in cells:
        x, y = methods.index(cell.method), traps.index(cell.trap)
        axes.add_patch(_square(x, y, COLOURS[cell.outcome]))
        dark = cell.outcome in (JUMPED, CRASHED)
        colour = "white" if dark else "black"
        axes.text(x, y - 0.42, _title(cell), ha="center", va="top", fontsize=7, color=colour)
        axes.text(x, y - 0.08, _note(cell), ha="center", va="top", fontsize=4.8, color=colour)
    axes.set(xlim=(-0.5, len(methods) - 0.5), ylim=(len(traps) - 0.5, -0.5))
    axes.set_xticks(range(len(methods)), [fill(m.replace("-", " "), 12) for m in methods], fontsize=8)
    axes.set_yticks(range(len(traps)), traps, fontsize=9)
    axes.xaxis.tick_top()
    axes.tick_params(length=0)
    axes.spines[:].set_visible(False)
    present = [o for o in OUTCOMES if any(c.outcome == o for c in cells)]
    figure.legend(handles=[Patch(color=COLOURS[o], label=o) for o in present], loc="outside lower center",
                  ncols=len(present), frameon=False, fontsize=9)
    return figure


def _square(x: float, y: float, colour: str):
    from matplotlib.patches import Rectangle

    return Rectangle((x - 0.48, y - 0.47), 0.96, 0.94, color=colour, linewidth=0)


def _title(cell: Cell) -> str:
    return f"{cell.cpu_seconds:.2g} s" if cell.outcome == PASSED else cell.outcome


def _note(cell: Cell) -> str:
    """The cost where a method passed, the reason elsewhere if it fits."""
    if cell.outcome == PASSED:
        return f"{cell.factorisations} factorisations"
    lines = wrap(cell.reason, LETTERS)
    return "\n".join(lines) if len(lines) <= LINES else ""
