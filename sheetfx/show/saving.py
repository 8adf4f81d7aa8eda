"""Pictures that are drawn on process 0 and saved in the format that their file's ending names."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from os import PathLike
from pathlib import Path
from typing import Any

from ..notices import warn
from .display import NoDisplay
from .evaluate import communicator
from .shown import Shown

STILL, MOVING = (".png", ".svg", ".pdf"), (".gif",)  # endings
File = str | PathLike[str]


def require_ending(what: str, file: File, endings: Sequence[str] = STILL) -> None:
    """Refuse a file whose ending names no format, before anything is drawn.

    Raises
    ------
    ValueError
    """
    if not (isinstance(file, (str, PathLike)) and Path(file).suffix.lower() in endings):
        raise ValueError(f"{what}: file is {str(file)!r}; its name must end with {' or '.join(endings)}")


def on_process_0(record: Shown, action: Callable[[], Any]) -> Any:
    """What process 0 makes, None elsewhere; what stops process 0, all processes raise."""
    comm, made, failure = communicator(record), None, None
    if comm.rank == 0:
        try:
            made = action()
        except Exception as error:
            failure = error
    if failure := comm.bcast(failure):
        raise failure
    return made


def picture(what: str, record: Shown, collect: Callable[[], Callable[[], Any]], file: File | None) -> Any:
    """A figure on process 0, None elsewhere; saved where a file is given.

    Parameters
    ----------
    what : is called, for refusals
    collect : called on all processes; what it gives draws the figure on process 0
    """
    if file is not None:
        require_ending(what, file)
    draw = collect()

    def drawn():
        figure = draw()
        if file is not None:
            figure.savefig(file)
        return figure

    return on_process_0(record, drawn)


def save_picture(record: Shown, draw: Callable[[], Any], file: Path) -> None:
    """Save what process 0 draws for a run's folder; without an X server it is left out with a warning."""
    if communicator(record).rank > 0:
        return
    try:
        draw().savefig(file)
    except NoDisplay as missing:
        warn(f"{file.name} is not drawn: {missing}")
