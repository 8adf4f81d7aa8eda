"""Third tested structure of the thesis (section 5.4.3): ribs in two directions, panels of 1 mm, four columns.

The thesis lacks the figure of the plan: neither span, rise nor number of ribs is known, and no load here is a
prediction of its test. Sections, steels, columns and five equal loads are those printed. Ribs stand on a paraboloid
z = rise (1 - 2 (x / span)^2 - 2 (y / span)^2); the loads are at the centre and at the crossings nearest to the quarter
points of both diagonals; deflections are those of the centre.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Annotated

import numpy as np
from typer import Option

from ..case import Case
from ..checks import NOT_NEGATIVE, POSITIVE, Range
from ..model.assembled import Joining
from ..model.joints import Spring
from ..model.obstacle_contact import ObstacleContact
from ..model.obstacles import RigidPlane
from ..model.plasticity import Plastic
from ..model.plate import Plate
from ..model.scene import Scene
from ..model.section import Rectangle, round_bar
from ..model.structure import Members, Sheets, Structure
from . import _structures as with_
from . import looked_at
from ._benchmark import Form

INNER, EDGE, COLUMN, PANEL = Rectangle(8.02, 20.19), Rectangle(10.21, 20.21), round_bar(40.0), Plate(1.0)
BARS, PANELS = Plastic(2.03e5, 0.3, yield_stress=355.0), Plastic(2.01e5, 0.3, yield_stress=182.0)
COLUMNS = 37.98, 38.37, 38.15, 38.14
SOFT = 1.0  # N/mm, against feet that slide: 1 N where the structure carries some 10 kN


@looked_at
def case(
    bays: Annotated[int, Range(least=2), Option(help="between ribs in each direction; even")] = 4,
    span: Annotated[float, POSITIVE, Option(help="between columns, mm")] = 800.0,
    rise: Annotated[float, POSITIVE, Option(help="of the centre above the corners, mm")] = 80.0,
    held: Annotated[str, Option(help="components that are held at the feet of the columns")] = "x y z",
    slide: Annotated[float | None, NOT_NEGATIVE,
                     Option(help="coefficient of friction of feet on a floor; default: they are held")] = None,
    model: with_.Model = "coupled", eccentric: with_.Eccentric = False, elastic: with_.Unyielding = False,
    divisions: with_.Divisions = 4, grading: with_.Grading = None, form: Form = "naghdi-q2",
    edges: with_.Edges = "shared", faces: with_.Faces = "seat", weld: with_.Weld = 20.0, screws: with_.Screws = 0,
    radius: with_.Radius = 1.0, tie: with_.Tie = "weld", gap: with_.Gap = 0.01, friction: with_.Friction = 0.2,
    pairs: with_.Pairs = None, stiffness: with_.Stiffness = None, enforcement: with_.Enforcement = "condensed",
    to: with_.To = 25.0, step: with_.FirstStep = None,
) -> Case:
    """A plan that M3 of the thesis may have had: its limit load."""
    joining = Joining(weld, screws, radius, tie, faces, edges, gap, friction, pairs, stiffness, enforcement)
    structure = ribs(bays, span, rise, held)
    case = with_.case_of(structure, model, eccentric, elastic, divisions, grading, form, joining, to, step,
                         with_.MILLIMETRES)
    return case if slide is None else replace(case, scene=on_floor(structure, case.scene, slide))


def on_floor(structure: Structure, scene: Scene, friction: float) -> Scene:
    """The scene with a rough floor under each foot in the place of supports, and springs, as nothing presses it yet."""
    mesh = scene.monitor.on
    joints = [joint for foot in structure.sets["feet"] for joint in (
        ObstacleContact(mesh, foot, RigidPlane(structure.nodes[foot], (0.0, 0.0, 1.0)), friction=friction,
                        distance=0.0, name="foot"), Spring(mesh, foot, "x", SOFT), Spring(mesh, foot, "y", SOFT))]
    return replace(scene, supports=(), joints=[*scene.joints, *joints])


def ribs(bays: int, span: float, rise: float, held: str = "x y z") -> Structure:
    """Crossing ribs over a square, with a column at each corner."""
    if bays % 2:
        raise ValueError(f"m3: bays is {bays}; give an even number, so that ribs cross in the centre")
    places = np.linspace(-span / 2, span / 2, bays + 1)
    nodes = {_node(i, j): (x, y, rise * (1 - 2 * (x / span) ** 2 - 2 * (y / span) ** 2))
             for i, x in enumerate(places) for j, y in enumerate(places)}
    inner: list[tuple[str, str]] = []
    edge: list[tuple[str, str]] = []
    for i in range(bays + 1):
        kind = edge if i in (0, bays) else inner
        for j in range(bays):
            kind += [(_node(i, j), _node(i, j + 1)), (_node(j, i), _node(j + 1, i))]
    corners = [_node(0, 0), _node(bays, 0), _node(bays, bays), _node(0, bays)]
    columns = [(corner, f"foot{n}") for n, corner in enumerate(corners, 1)]
    for (corner, foot), height in zip(columns, COLUMNS, strict=True):
        x, y, z = nodes[corner]
        nodes[foot] = (x, y, z - height)
    cells = [(_node(i, j), _node(i + 1, j), _node(i + 1, j + 1), _node(i, j + 1))
             for i in range(bays) for j in range(bays)]
    low, middle, high = max(1, bays // 4), bays // 2, min(bays - 1, bays - bays // 4)
    crossings = {(middle, middle), *((i, j) for i in (low, high) for j in (low, high))}
    loaded = [_node(i, j) for i, j in sorted(crossings)]
    return Structure(
        nodes, {"inner": Members(inner, INNER, BARS), "edge": Members(edge, EDGE, BARS),
                "columns": Members(columns, COLUMN, BARS, up=(1.0, 0.0, 0.0))},
        {"panels": Sheets(cells, PANEL, PANELS)}, {"feet": held},
        {node: (0.0, 0.0, -1.0 / len(loaded)) for node in loaded}, (_node(middle, middle), "z", -1.0),
        {"feet": [foot for _, foot in columns]})


def _node(i: int, j: int) -> str:
    return f"n{i}.{j}"
