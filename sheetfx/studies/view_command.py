"""The command `sheetfx view`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer


def view(
    folder: Annotated[Path, typer.Argument(help="Folder of a finished run.")],
    along: Annotated[str | None, typer.Option(help="x, y or z: colour displacements along it, not their size.")] = None,
    picture: Annotated[Path | None, typer.Option(help="A .png to write instead of opening a view.")] = None,
) -> None:
    """Open a view of a finished run that can be turned, with a slider for its states or buckling modes."""
    from ..show.viewer import view_folder

    view_folder(folder, along, picture)
