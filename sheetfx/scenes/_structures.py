"""What the tested structures of the thesis (section 5.4), and a user's own of bars and sheets, have in common."""

from __future__ import annotations

from collections.abc import Callable
from typing import Annotated

from typer import Option

from .. import meshes
from ..case import Case
from ..checks import AT_LEAST_1, NOT_NEGATIVE, POSITIVE, Choice
from ..continuation.control import ArcLength
from ..model import assembled
from ..model.assembled import Cells, Joining
from ..model.pair_contact import ENFORCEMENTS
from ..model.plasticity import Plastic
from ..model.structure import Structure, read_structure
from ..path import Until
from ..record import Record
from ..show.critical_modes import draw_critical_modes
from ..show.pairs import pair_history
from ..show.plastic import plastic_zones
from ..show.standard import STANDARD
from . import looked_at
from ._benchmark import Form
from ._plastic import plastic_quantities, yield_events

MODELS = "bars", "flange", "coupled", "contact"
MILLIMETRES = " (mm)", " (N)"  # units of the thesis
GRADED = 4.0  # with contact: cells at the welds, where forces are large, a quarter of those in the middle of bars

Data = Annotated[str, Option(help="JSON file of the structure, see `read_structure`")]
Coordinates = Annotated[str, Option(help="of the nodes, of those that the file has: `ideal` or `measured`")]
Model = Annotated[str, Choice(MODELS),
                  Option(help="`bars` alone, bars with the effective `flange` of panels, panels and bars `coupled` "
                              "along their edges, or welded near the corners, screwed, and in `contact` elsewhere")]
Eccentric = Annotated[bool, Option("--eccentric", help="panels lie on top of the bars; else their mid-surfaces meet "
                                                       "the axes of the bars")]
Unyielding = Annotated[bool, Option("--elastic", help="no material yields")]
Divisions = Annotated[int, AT_LEAST_1, Option(help="cells along each bar; even for quadrilaterals")]
Grading = Annotated[float | None, AT_LEAST_1,
                    Option(help="length of cells in the middle of each bar over that of those at its ends; default 1, "
                                "with contact 4")]
Edges = Annotated[str, Choice(tuple(assembled.EDGES)),
                  Option(help="of panels in contact: each has its `own`, or neighbours `shared` ones")]
Faces = Annotated[str, Choice(assembled.FACES_OF_PANELS),
                  Option(help="that touch: panels lie on bars (`seat`), their edges push against bars (`butt`), or "
                              "`both`")]
Weld = Annotated[float, POSITIVE, Option(help="length of the welds from each corner of a panel along its edges")]
Screws = Annotated[int, NOT_NEGATIVE, Option(help="on each edge between its welds, evenly spaced")]
Radius = Annotated[float, POSITIVE, Option(help="of screws: the edge is held so far on both sides of each")]
Tie = Annotated[str, Choice(tuple(assembled.TIES)),
                Option(help="of rotations in welds and screws: all (`weld`), all but that in the panel's plane "
                            "(`bolt`), or none (`hinge`)")]
Gap = Annotated[float, NOT_NEGATIVE, Option(help="initial gap of the contact")]
Friction = Annotated[float, NOT_NEGATIVE, Option(help="Coulomb's coefficient of contact")]
Pairs = Annotated[int | None, AT_LEAST_1,
                  Option(help="of points along each edge; default three in each piece of cells")]
Stiffness = Annotated[float | None, POSITIVE,
                      Option(help="of contact, force for each unit of penetration and of edge; default by the panels' "
                                  "own")]
Enforcement = Annotated[str, Choice(ENFORCEMENTS), Option(help="of contact: `penalty`, `uzawa` or `condensed`")]
To = Annotated[float, POSITIVE, Option(help="deflection at which the path ends")]
FirstStep = Annotated[float | None, POSITIVE, Option(help="first arc length; default chosen by the structure")]


def from_file(scene: str, title: str, end: float, name: str = "m1") -> Callable[..., Case]:
    """The function `case` of a scene whose structure is read from a file.

    Parameters
    ----------
    scene : its name
    title : what the function says of itself
    end : deflection at which its path ends by default
    name : of the file in `meshes.domes` that is read by default
    """
    def case(
        data: Data = str(meshes.tables.STRUCTURES[name]), coordinates: Coordinates = "ideal", model: Model = "coupled",
        eccentric: Eccentric = False, elastic: Unyielding = False, divisions: Divisions = 4, grading: Grading = None,
        form: Form = "naghdi-q2", edges: Edges = "shared", faces: Faces = "seat", weld: Weld = 20.0, screws: Screws = 0,
        radius: Radius = 1.0, tie: Tie = "weld", gap: Gap = 0.01, friction: Friction = 0.2, pairs: Pairs = None,
        stiffness: Stiffness = None, enforcement: Enforcement = "condensed", to: To = end, step: FirstStep = None,
    ) -> Case:
        structure = read_structure(data, coordinates)
        joining = Joining(weld, screws, radius, tie, faces, edges, gap, friction, pairs, stiffness, enforcement)
        units = MILLIMETRES if data == str(meshes.tables.STRUCTURES[name]) else ("", "")
        return case_of(structure, model, eccentric, elastic, divisions, grading, form, joining, to, step, units)

    case.__doc__, case.__module__ = title, f"{__package__}.{scene}"
    return looked_at(case)


def case_of(structure: Structure, model: str, eccentric: bool, elastic: bool, divisions: int, grading: float | None,
            form: str, joining: Joining, to: float, step: float | None, units: tuple[str, str]) -> Case:
    """Case of a structure by one of `MODELS`; `units` of deflection and load are what plots say."""
    if elastic:
        structure = structure.elastic()
    cells = Cells(divisions, grading or (GRADED if model == "contact" else 1.0), form)
    offset = assembled.seat(structure) if eccentric and model != "bars" else 0.0
    if model in ("bars", "flange"):
        scene = assembled.skeleton(structure, cells, offset if model == "flange" else None)
    elif model == "coupled":
        scene = assembled.coupled(structure, cells, offset)
    else:
        scene = assembled.touching(structure, cells, joining, offset)
    plastic = isinstance(scene.parts[0].material, Plastic)
    pictures = [*STANDARD, draw_critical_modes, *([plastic_zones] if plastic else []),
                *([pair_history] if model == "contact" else [])]
    at, component, _ = structure.monitor
    return Case(scene=scene, control=ArcLength() if step is None else ArcLength(step=step), until=Until(deflection=to),
                quantities=quantities, pictures=pictures, events=yield_events(scene),
                axes=(f"deflection of {at} along {component}{units[0]}", f"load{units[1]}"))


def quantities(record: Record) -> dict[str, float]:
    """Initial stiffness, the first limit point, and what has yielded."""
    values = {"initial_stiffness": 1 / record.states[0].reference[1]}
    for point in [p for p in record.critical_points if p.kind == "limit"][:1]:
        values |= {"limit_load": point.load, "limit_deflection": point.deflection}
    return values | plastic_quantities(record)
