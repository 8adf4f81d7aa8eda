"""Pictures of a structure's shapes."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path as Folder

import numpy as np

from ..continuation.state import CriticalPoint, State
from ..discrete.contact import SLIP, STICK, ContactState
from ..model.obstacles import RigidCylinder, RigidPlane
from .evaluate import (
    ContactPoints,
    Curves,
    last_state_kept,
    most_telling,
    stays,
    told,
    travel,
    unit_of,
    with_unit,
)
from .layout import Sheet
from .measure import OF_SIZE, Measure
from .saving import save_picture
from .shown import Shown
from .surfaces import has_surfaces
from .views import View, draw_states, view

SIZE, MOST_VIEWS = (1600, 900), 6
CLOSE = 0.005  # of the largest deflection and load, states that are drawn once
COLOURS = ("#0b4f8a", "#c4432b", "#1b8a5a", "#8e44ad", "#0097a7", "#7f6a00", "#d81b60")
UNDEFORMED, LAST = "#9a9a9a", "#222222"
STATUS = {STICK: ("#111111", "sticking"), SLIP: ("#f2a900", "slipping")}
TOUCHING = ("#f2a900", "touching")


@dataclass
class Shape:
    """A state as it is drawn.

    Attributes
    ----------
    label, colour : of its line
    cells : (cells, points, 3), current places
    obstacles : obstacle and its displacement (2,)
    contacts : points to be drawn, none at the last state
    """

    label: str
    colour: str
    cells: np.ndarray
    obstacles: list[tuple[RigidCylinder | RigidPlane, np.ndarray]]
    contacts: list[ContactState]


def shapes(record: Shown, folder: Folder, name: str = "shape.png") -> None:
    """Draw the structure undeformed, at critical points and at the last state (process 0 writes the file).

    Surfaces are drawn side by side, one view to each state, and so are curves in space that have several; other curves
    all in one view. A critical point is drawn in its own state; if that does not converge again at the end of its step,
    and the legend tells where. Points that are close to each other are drawn once. Views side by side are left out with
    a warning where there is no X server and Xvfb is missing. A path of a single state has no shapes to draw.
    """
    if len(record.states) > 1:
        save_picture(record, picture_of_shapes(record), Folder(folder) / name)


def picture_of_shapes(record: Shown, measure: Measure = OF_SIZE) -> Callable:
    """A function that draws the picture of `shapes`, for process 0; views side by side are coloured by a measure."""
    spatial = record.case.scene.parts[0].mesh.dimension == 3
    if has_surfaces(record) or (spatial and len(states_to_draw(record)) > 1):
        return partial(draw_states, record, _side_by_side(record, measure), measure)
    return partial(_draw_lines, record, spatial, *_collect(record))


def _draw_lines(record: Shown, spatial: bool, undeformed: np.ndarray, drawn: list[Shape]):
    """The figure of curves in one view."""
    friction = any(c.friction for c in record.case.scene.contacts)
    sheet = Sheet(SIZE, spatial, unit_of(record.case.axes[0]), record.case.scene.symmetry_factor,
                  entries=3 if record.case.scene.contacts else int(spatial))
    sheet.line("undeformed", UNDEFORMED, undeformed, width=2.5)
    for shape in drawn:
        sheet.line(shape.label, shape.colour, shape.cells, width=5)
    sheet.fit()
    for shape in drawn:
        for obstacle, shift in shape.obstacles:
            sheet.obstacle(shape.colour, obstacle, shift)
        for contact in shape.contacts:
            for status, (colour, meaning) in STATUS.items():
                chosen = contact.position[contact.status == status]
                sheet.spheres(*((colour, meaning) if friction else TOUCHING), chosen)
    return sheet.draw()


def _side_by_side(record: Shown, measure: Measure) -> list[View | None]:
    """A view of each state to draw."""
    views = []
    with last_state_kept(record):
        for state, label, _, _ in states_to_draw(record, MOST_VIEWS - 1):
            record.show(state)
            lines = label.split("; ")
            views.append(view(record, "\n".join(lines if len(lines) > 1 else label.split(": ", 1)), measure))
    return views


def _collect(record: Shown) -> tuple[np.ndarray | None, list[Shape]]:
    """The undeformed structure and all shapes, on process 0."""
    curves, points = Curves(record), ContactPoints(record)
    obstacles = list(dict.fromkeys(c.obstacle for c in record.case.scene.contacts))
    undeformed, drawn = None, []
    with last_state_kept(record):
        for state, label, colour, critical in states_to_draw(record):
            record.show(state)
            shifts = [(o, travel(record, o)) for o in obstacles]
            contacts, cells = points.evaluate(), curves.evaluate()
            if cells is not None:
                undeformed = cells[0]
                drawn.append(Shape(label, colour, cells[1], shifts, contacts if critical else []))
    return undeformed, drawn


def states_to_draw(record: Shown, most: int = len(COLOURS)) -> list[tuple[State, str, str, bool]]:
    """States to draw: label, colour and whether each belongs to a critical point."""
    length, force = (unit_of(a) for a in record.case.axes)
    still = stays(record.states)

    moved, loaded = (told(axis, plain) for axis, plain in zip(record.case.axes, ("deflection", "load"), strict=True))

    def place(at) -> str:
        deflection = with_unit(0.0 if still else at.deflection, length)
        return f"{loaded} {with_unit(at.load, force)}, {moved} {deflection}"

    every = record.critical_points
    points = most_telling(every, most)
    left_out = f" ({len(points)} of {len(every)} are drawn)" if len(points) < len(every) else ""
    last, reach, highest = record.states[-1], *(max(abs(getattr(s, name)) for s in record.states)
                                                for name in ("deflection", "load"))
    drawn: list[tuple[State, list[str]]] = []
    for i, point in enumerate(points):
        state = state_of(record, point)
        apart = not still and abs(state.deflection - point.deflection) > CLOSE * reach
        behind = f" (drawn at {with_unit(state.deflection, length)})" if apart else ""
        label = f"{point.title}{left_out if i == 0 else ''}: {place(point)}{behind}"
        if drawn and _close(drawn[-1][0], state, reach, highest):
            drawn[-1][1].append(label)
        else:
            drawn.append((state, [label]))
    critical = [(state, "; ".join(lines), colour, True)
                for (state, lines), colour in zip(drawn, COLOURS, strict=False)]
    if drawn and _close(drawn[-1][0], last, reach, highest):
        return critical
    return [*critical, (last, f"end: {place(last)}", LAST, False)]


def _close(one: State, other: State, reach: float, highest: float) -> bool:
    """Whether two states look alike, compared with the largest deflection and load of their path."""
    return (one.stage == other.stage and abs(one.deflection - other.deflection) <= CLOSE * reach
            and abs(one.load - other.load) <= CLOSE * highest)


def state_of(record: Shown, point: CriticalPoint) -> State:
    """The state of a critical point, or where it does not converge again that at the end of its step."""
    try:
        return record.state_at(point)
    except ArithmeticError:
        return next(s for s in record.states if s.step == point.step)
