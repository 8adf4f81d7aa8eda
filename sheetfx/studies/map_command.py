"""The command `sheetfx map`; traps and methods are in `demos/failure_map` of the source tree."""

from __future__ import annotations

import sys
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import Annotated

import typer

from ..checks import Range, require
from .suggesting import Resumed, with_choices

DEMOS = Path(__file__).parents[2] / "demos"
MISSING = ("the traps belong to the source tree, and this sheetfx is installed without one; run "
           "`docker/run sheetfx map` in a checkout")


def _in_the_tree() -> bool:
    return (DEMOS / "failure_map").is_dir()


def _of_the_tree() -> ModuleType:
    """What does the work.

    Raises
    ------
    ValueError
        Where the package is installed without its source tree.
    """
    if not _in_the_tree():
        raise ValueError(f"map: {MISSING}")
    if str(DEMOS) not in sys.path:
        sys.path.append(str(DEMOS))
    return import_module("failure_map.command")


Listing = with_choices(lambda: _of_the_tree().choices() if _in_the_tree() else f"Here {MISSING}.")


def draw_failure_map(
    traps: Annotated[str | None, typer.Option(help="Names of traps, separated by commas; default all.")] = None,
    methods: Annotated[str | None, typer.Option(help="Names of methods, separated by commas; default all.")] = None,
    output: Annotated[Path, typer.Option("-o", "--output", help="Folder of the results.")] = Path("results/map"),
    limit: Annotated[float, typer.Option(help="Seconds that a path may take.")] = 60.0,
    resume: Resumed = False,
) -> None:
    """Draw which method of path following passes which trap, and how the others fail (in a checkout).

    The table map.csv has each result as soon as it is there.
    """
    require("map", **{"--limit": (limit, Annotated[float, Range(least=1)])})
    _of_the_tree().draw(traps, methods, output, limit, resume)
    typer.echo(f"results in {output}")
