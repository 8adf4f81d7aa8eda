"""Modes at critical points as a picture."""

from __future__ import annotations

from pathlib import Path as Folder

from ..model.beam import Bar, Beam
from ..record import Record
from .display import save_picture
from .evaluate import communicator, unit_of, with_unit
from .modes import MOST, draw_shapes, shape_of


def draw_critical_modes(record: Record, folder: Folder, name: str = "critical_modes.png") -> None:
    """Draw null vectors of the first critical points (process 0 writes the file).

    Titles tell the load and, in structures of beams and shells, which share of the strain energy of the modes there is
    in the beams. Points where nothing is singular have no mode; without any there is no picture.
    """
    force, parts, drawn = unit_of(record.case.axes[1]), record.case.scene.parts, []
    beams = [isinstance(part, (Beam, Bar)) for part in parts]
    for point in record.critical_points:
        if len(drawn) >= MOST or point.kind not in ("bifurcation", "limit"):
            continue
        modes = record.modes(point)
        share = sum(s for s, beam in zip(record.energy_shares(modes), beams, strict=True) if beam)
        told = f"\n{100 * share:.0f} % of its energy in beams" if 0 < sum(beams) < len(beams) else ""
        drawn += [shape_of(record, mode, f"{point.title}: {with_unit(point.load, force)}{told}") for mode in modes]
    if drawn and communicator(record).rank == 0:
        save_picture(lambda file: draw_shapes(record, drawn[:MOST], file), Folder(folder) / name)
