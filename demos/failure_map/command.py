"""What `sheetfx map` does: paths of all traps by all methods, told as they end, then a table and a picture."""

from __future__ import annotations

from pathlib import Path

from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

from sheetfx.interrupts import tell

from .cells import REFERENCE, Cell, choose, failure_map, read_map, write_map
from .methods import METHODS
from .picture import draw_map
from .traps import TRAPS


def choices() -> str:
    """Names of traps and methods, for the help of the command."""
    return f"Traps: {', '.join(TRAPS)}.\n\nMethods: {', '.join(METHODS)}."


def draw(traps: str | None, methods: str | None, output: Path, limit: float, resume: bool) -> None:
    """Trace missing cells, and write map.csv and map.png; see `sheetfx map --help`."""
    rows, columns = choose("trap", traps, TRAPS), choose("method", methods, METHODS)
    layout = TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn()
    earlier = read_map(output / "map.csv") if resume else []
    with Progress(*layout, transient=True) as progress:
        output.mkdir(parents=True, exist_ok=True)
        task, done, running = progress.add_task("", total=len(rows) * (len(columns) + 1)), [*earlier], []
        progress.advance(task, len(earlier))

        def begin(trap: str, method: str) -> None:
            running.append(f"{trap}, {method}")
            progress.update(task, description="; ".join(running))

        def say(cell: Cell) -> None:
            running.remove(f"{cell.trap}, {cell.method}")
            progress.update(task, description="; ".join(running))
            if cell.method != REFERENCE:
                done.append(cell)
                write_map(done, output / "map.csv")
                tell(lambda: f"{len(done)} cells are kept in {output}")
            line = f"{cell.trap}, {cell.method}: {cell.outcome}{'; ' if cell.reason else ''}{cell.reason}"
            progress.console.print(line, soft_wrap=True, markup=False, highlight=False)
            progress.advance(task)

        cells = failure_map(rows, columns, output, limit, say, begin, earlier)
        if not cells:
            raise ValueError("map: no method applies; methods of contact need traps with contact")
    write_map(cells, output / "map.csv")
    draw_map(cells).savefig(output / "map.png", dpi=200)
