"""What a run draws and writes where its case does not say otherwise."""

from __future__ import annotations

from pathlib import Path as Folder

from .curves import path_curve
from .files import paraview
from .modes import draw_modes, mode_files
from .pictures import shapes
from .shown import Shown


def buckling_modes(record: Shown, folder: Folder) -> None:
    """Draw modes.png, and write buckling.csv and paraview/modes.pvd, where linear buckling is asked for.

    A path with `Until(steps=0)` asks for it.
    """
    if record.case.until.steps == 0:
        draw_modes(record, folder)
        mode_files(record, folder)


STANDARD = (path_curve, shapes, paraview, buckling_modes)
