"""The failure map as a picture for a printed page: cells of symbols and letters, and a table that explains them."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Sequence
from string import ascii_lowercase
from textwrap import wrap

from .cells import Cell
from .judgement import BACK, CRASHED, JUMPED, OUTCOMES, PASSED, STALLED, WRONG

COLOURS = dict(zip(OUTCOMES, ("#d9efdf", "#f2c14e", "#c4432b", "#e58a3c", "#9fb3c8", "#4a4a4a"), strict=True))
SYMBOLS = {PASSED: "\u2713", WRONG: "\u2260", JUMPED: "\u21af", BACK: "\u21a9", STALLED: "\u25a0", CRASHED: "\u2715"}
WIDTH, HEIGHT = 8.27, 11.69  # inches of a page (A4); the picture is as high as its rows ask
ROW, COLUMN, NAMES, COSTS, HEAD, MARGIN = 0.168, 0.235, 1.45, 0.9, 1.1, 0.1
SMALL, LETTERS = 6.5, 36  # size of the text in points, and letters on a line of the table
LINE, GAP, OUTCOME = 0.107, 0.035, ROW + 0.08  # height of a line, gap below a reason, height of the name of an outcome
NUMBER = r"-?\d+(\.\d+)?(e[+-]?\d+)?"


def draw_map(cells: Sequence[Cell]):
    """The matplotlib figure: a row for each trap, a column for each method, and what the letters of failures mean."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    traps, methods = (list(dict.fromkeys(getattr(c, name) for c in cells)) for name in ("trap", "method"))
    letters = explanations(cells)
    table = [(outcome, letters.get((outcome, kind), ""), kind) for outcome, kind in _in_order(cells)]
    left = NAMES + COLUMN * len(methods) + COSTS
    explained = sum(_height(kind) for *_, kind in table) + OUTCOME * len({outcome for outcome, *_ in table})
    width, height = max(WIDTH, left + 2.2), HEAD + MARGIN + max(ROW * len(traps), explained)
    figure = Figure(figsize=(width, height))
    FigureCanvasAgg(figure)
    axes = figure.add_axes((0, 0, 1, 1))
    axes.set(xlim=(0, width), ylim=(height, 0))
    axes.axis("off")
    for n, method in enumerate(methods):
        axes.text(NAMES + COLUMN * (n + 0.4), HEAD - 0.05, method.replace("-", " "), rotation=55, fontsize=SMALL,
                  ha="left", va="bottom", rotation_mode="anchor")
    for n, trap in enumerate(traps):
        axes.text(NAMES - 0.06, HEAD + ROW * (n + 0.5), trap, fontsize=SMALL, ha="right", va="center")
    for cell in cells:
        x, y = NAMES + COLUMN * methods.index(cell.method), HEAD + ROW * traps.index(cell.trap)
        _draw_cell(axes, x, y, cell.outcome, letters.get((cell.outcome, kind_of(cell.reason)), ""))
    _draw_costs(axes, cells, traps, left - COSTS)
    _draw_table(axes, table, left + 0.1)
    return figure


def kind_of(reason: str) -> str:
    """A reason without its numbers, so that failures of one kind have one."""
    text = re.sub(f"load {NUMBER}, deflection {NUMBER}", "a state", reason).replace("a state and a state", "two states")
    return re.sub(rf"(?<![\w]){NUMBER}", "…", text)


def _height(kind: str) -> float:
    """Of a reason in the table."""
    return LINE * len(wrap(kind, LETTERS)) + GAP if kind else 0.0


def _in_order(cells: Sequence[Cell]) -> list[tuple[str, str]]:
    """Outcomes and kinds of reasons that occur, the more frequent first."""
    count = Counter((c.outcome, kind_of(c.reason)) for c in cells)
    return sorted(count, key=lambda item: (OUTCOMES.index(item[0]), -count[item], item[1]))


def explanations(cells: Sequence[Cell]) -> dict[tuple[str, str], str]:
    """A letter for each outcome and kind of reason but the passed ones."""
    failed = [item for item in _in_order(cells) if item[0] != PASSED]
    names = [*ascii_lowercase, *(a + b for a in ascii_lowercase for b in ascii_lowercase)]
    return dict(zip(failed, names, strict=False))


def _draw_cell(axes, x: float, y: float, outcome: str, letter: str) -> None:
    from matplotlib.patches import Rectangle

    gap = 0.012
    axes.add_patch(Rectangle((x + gap, y + gap), COLUMN - 2 * gap, ROW - 2 * gap, color=COLOURS[outcome], linewidth=0))
    colour = "white" if outcome in (JUMPED, CRASHED) else "black"
    axes.text(x + COLUMN / 2, y + ROW / 2, f"{SYMBOLS[outcome]} {letter}".strip(), fontsize=SMALL, color=colour,
              ha="center", va="center_baseline")


def _draw_costs(axes, cells: Sequence[Cell], traps: Sequence[str], x: float) -> None:
    """CPU seconds and factorisations of the first method, where it passed."""
    first = cells[0].method
    for column, name in ((0.45, "seconds"), (COSTS, "factorisations")):
        axes.text(x + column - 0.05, HEAD - 0.05, f"{first}, {name}", rotation=55, fontsize=SMALL, ha="left",
                  va="bottom", rotation_mode="anchor")
    for cell in cells:
        if cell.method == first and cell.outcome == PASSED:
            y = HEAD + ROW * (traps.index(cell.trap) + 0.5)
            axes.text(x + 0.45, y, f"{cell.cpu_seconds:.1f}", fontsize=SMALL, ha="right", va="center")
            axes.text(x + COSTS, y, f"{cell.factorisations}", fontsize=SMALL, ha="right", va="center")


def _draw_table(axes, table: Sequence[tuple[str, str, str]], x: float) -> None:
    """What symbols and letters mean, from the top down."""
    y, shown = HEAD, None
    for outcome, letter, kind in table:
        if outcome != shown:
            _draw_cell(axes, x, y, outcome, "")
            axes.text(x + COLUMN + 0.06, y + ROW / 2, outcome, fontsize=SMALL, weight="bold", va="center_baseline")
            y, shown = y + OUTCOME, outcome
        if kind:
            axes.text(x + COLUMN / 2, y, letter, fontsize=SMALL, ha="center", va="top")
            axes.text(x + COLUMN + 0.06, y, "\n".join(wrap(kind, LETTERS)), fontsize=SMALL, va="top", linespacing=1.1)
            y += _height(kind)
