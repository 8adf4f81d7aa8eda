"""Modes at critical points as a picture."""

from __future__ import annotations

from pathlib import Path as Folder

from ..model.beam import Bar, Beam
from .evaluate import unit_of, with_unit
from .measure import OF_SIZE
from .modes import MOST, draw_shapes, shape_of
from .saving import save_picture
from .shown import Shown


def draw_critical_modes(record: Shown, folder: Folder, name: str = "critical_modes.png") -> None:
    """Draw null vectors of the first critical points (process 0 writes the file).

    Titles tell the load and, in structures of beams and shells, which share of the strain energy of the modes there is
    in the beams. Points where nothing is singular have no mode; without any there is no picture.
    """
    force, parts, drawn = unit_of(record.case.axes[1]), record.case.scene.parts, []
    beams = [isinstance(part, (Beam, Bar)) for part in parts]
    for point in record.critical_points:
        if len(drawn) >= MOST or point.kind not in ("bifurcation", "limit"):
            continue
        modes = record.critical_modes(point)
        share = sum(s for s, beam in zip(record.energy_shares(modes), beams, strict=True) if beam)
        told = f": {with_unit(point.load, force)}"
        if 0 < sum(beams) < len(beams):
            told += f"\n{100 * share:.0f} % of its energy in beams"
        drawn += [shape_of(record, mode, point.title + told, OF_SIZE) for mode in modes]
    if drawn:
        save_picture(record, lambda: draw_shapes(record, drawn[:MOST], OF_SIZE), Folder(folder) / name)
