"""Pictures of the double plate: contact force and slip along its path, and both plates in side view at its stages."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path as Folder

import numpy as np

from ..continuation.state import State
from ..mesh.reader import NamedMesh
from ..record import Record
from ..show.curves import curve_points
from ..show.evaluate import communicator, last_state_kept
from ..show.pictures import state_of

COLOURS = "#0b4f8a", "#c4432b", "#1b8a5a", "#8e44ad", "#0097a7"


@dataclass(frozen=True)
class Touch:
    """What a state of the path has in its contact: the whole force, and the slip since the plates touched first."""

    force: float
    slip: float


def touches(record: Record) -> list[Touch]:
    """Contact force on the whole plate and slip, for each state."""
    contact, found, start = record.case.scene.joints[0], [], None
    with last_state_kept(record):
        for state in record.states:
            record.show(state)
            pairs = record.pairs(contact)
            if start is None and state.contact_points:
                start = pairs.slip
            slip = 0.0 if start is None else float(np.linalg.norm(pairs.slip - start, axis=1).max())
            found.append(Touch(record.case.scene.symmetry_factor * float(pairs.weight @ pairs.pressure), slip))
    return found


def stages(record: Record, folder: Folder, name: str = "stages.png") -> None:
    """Draw stages.png."""
    figure = draw_stages(record)
    if communicator(record).rank == 0:
        figure.savefig(Folder(folder) / name)


def draw_stages(record: Record, figure=None):
    """The matplotlib figure of `stages`; one may be given, such as that of a notebook's cell."""
    if figure is None:
        from ..show.figure import Picture

        figure = Picture(figsize=(11.0, 8.0), dpi=150, layout="constrained")
    above, below = figure.subfigures(2, 1)
    left, right = above.subplots(1, 2)
    deflection, found = [s.deflection for s in record.states], touches(record)
    left.plot(*curve_points(record).T, color="#222222", label="load")
    left.plot(deflection, [t.force for t in found], color="#999999", label="contact force")
    right.plot(deflection, [t.slip for t in found], color="#222222")
    left.set(xlabel=record.case.axes[0], ylabel="force (N)")
    right.set(xlabel=record.case.axes[0], ylabel="slip since first touch (mm)")
    side = below.subplots()
    _draw_sides(side, record, record.states[0], "#bbbbbb", "at the start")
    events = [p for p in record.critical_points if p.kind == "event"]
    for point, colour in zip(events, COLOURS, strict=False):
        left.plot(point.deflection, point.load, "o", color=colour, label=f"{point.name} ({point.load:.2f} N)")
        _draw_sides(side, record, state_of(record, point), colour, point.name)
    left.legend(frameon=False, fontsize=8)
    side.set_aspect("equal")
    side.set(xlabel="x (mm)", ylabel="z (mm)")
    side.legend(frameon=False, fontsize=8, loc="lower left")
    return figure


def _side_lines(record: Record, state: State) -> list[np.ndarray]:
    with last_state_kept(record):
        record.show(state)
        return [_middle_line(record, mesh) for mesh in record.case.scene.meshes]


def _draw_sides(axes, record: Record, state: State, colour: str, label: str) -> None:
    for number, line in enumerate(_side_lines(record, state)):
        axes.plot(*line.T, color=colour, label=label if number == 0 else None)


def _middle_line(record: Record, mesh: NamedMesh) -> np.ndarray:
    """Places x and z of the nodes on the long axis, one behind the other."""
    displacement = record.path.discretisation.kinematics(mesh).u
    places = displacement.function_space.tabulate_dof_coordinates()
    line: Sequence[int] = np.flatnonzero(np.abs(places[:, 1]) < 1e-9)
    line = line[np.argsort(places[line, 0])]
    return (places + displacement.x.array.reshape(-1, 3))[line][:, [0, 2]]
