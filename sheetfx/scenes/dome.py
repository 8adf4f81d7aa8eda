"""Three-way dome of bars and panels under a force at its apex (thesis, sections 5.2 and 5.3).

19 nodes, 42 bars (tubes 40 x 2), 24 flat steel panels 10 mm thick, span 8 m and rise 1.6 m. The thesis prints neither
coordinates nor drawing: three geometries are likely, see `meshes.dome`. It fixes the six outermost corners; they are
pinned here, and `--held "x y z rx ry rz"` clamps them. Where mid-surfaces of panels lie against the axes of the bars it
does not say either: `--offset` is that distance, zero by default. With `--model contact` which faces touch and how long
the welds are decides the answer (demos/dome_contact.md); the thesis gives neither.
"""

from __future__ import annotations

from typing import Annotated

import numpy as np
from typer import Option

from .. import meshes
from ..case import Case
from ..checks import AT_LEAST_1, NOT_NEGATIVE, POSITIVE, Choice
from ..continuation.control import ArcLength
from ..model.assembled import EDGES, FACES_OF_PANELS, TIES, Cells, Joining, coupled, skeleton, touching
from ..model.beam import Beam
from ..model.pair_contact import ENFORCEMENTS
from ..model.plate import Plate
from ..model.section import Elastic, Tube
from ..model.structure import Members, Sheets, Structure
from ..path import Until
from ..record import Record
from ..show.critical_modes import draw_critical_modes
from ..show.evaluate import last_state_kept
from ..show.pairs import pair_history
from ..show.standard import STANDARD
from . import looked_at
from ._benchmark import Form

BAR, PANEL = Tube(40.0, 2.0), Plate(10.0)
STEEL = Elastic(2.1e5, 0.3, density=7.85e-9)
MODELS = "coupled", "contact", "flange", "bars"


@looked_at
def case(
    geometry: Annotated[str, Option(help=f"of the nodes: {', '.join(meshes.tables.DOMES)}, or a file, see "
                                         "`meshes.read_table`")] = "hex",
    model: Annotated[str, Choice(MODELS),
                     Option(help="panels and bars `coupled` along their edges, welded near the corners and in "
                                 "`contact` elsewhere, bars with the effective `flange` of panels, or `bars` "
                                 "alone")] = "coupled",
    divisions: Annotated[int, AT_LEAST_1, Option(help="cells along each bar; even for quadrilaterals")] = 6,
    grading: Annotated[float, AT_LEAST_1,
                       Option(help="length of cells in the middle of each bar over that of those at its ends")] = 1.0,
    form: Form = "naghdi-q2",
    offset: Annotated[float, Option(help="of the panels' mid-surfaces above the axes of the bars, mm")] = 0.0,
    held: Annotated[str, Option(help="components that supports hold at the corners")] = "x y z",
    faces: Annotated[str, Choice(tuple(FACES_OF_PANELS)),
                     Option(help="that touch: panels lie on bars (`seat`), their edges push against bars (`butt`), or "
                                 "`both`")] = "both",
    edges: Annotated[str, Choice(tuple(EDGES)),
                     Option(help="of panels: each has its `own`, or neighbours `shared` ones")] = "own",
    weld: Annotated[float, POSITIVE,
                    Option(help="length of the welds from each corner of a panel along its edges, mm")] = 200.0,
    tie: Annotated[str, Choice(tuple(TIES)),
                   Option(help="of rotations in the welds: all (`weld`), all but that in the panel's plane (`bolt`), "
                               "or none (`hinge`)")] = "weld",
    gap: Annotated[float, NOT_NEGATIVE, Option(help="initial gap, mm")] = 0.1,
    friction: Annotated[float, NOT_NEGATIVE, Option(help="Coulomb's coefficient of contact")] = 0.0,
    pairs: Annotated[int | None, AT_LEAST_1,
                     Option(help="of points along each edge; default three in each piece of cells")] = None,
    stiffness: Annotated[float | None, POSITIVE,
                         Option(help="of a pair, N/mm, or without --pairs of contact, N/mm for each mm of edge; "
                                     "default by the panels' own")] = None,
    enforcement: Annotated[str, Choice(ENFORCEMENTS),
                           Option(help="of contact: `penalty`, `uzawa` or `condensed`")] = "condensed",
    to: Annotated[float, POSITIVE, Option(help="deflection of the apex at which the path ends, mm")] = 45.0,
    step: Annotated[float | None, POSITIVE, Option(help="first arc length; default chosen by the structure")] = None,
) -> Case:
    """Dome of panels on bars: the load at which its rising path bifurcates, and where it goes from there."""
    structure, cells = dome(meshes.dome(geometry), held), Cells(divisions, grading, form)
    if model == "coupled":
        scene = coupled(structure, cells, offset)
    elif model == "contact":
        if stiffness is not None and pairs is not None:
            stiffness *= pairs / structure.mean_span
        scene = touching(structure, cells, Joining(weld, tie=tie, faces=faces, edges=edges, gap=gap, friction=friction,
                                                   pairs=pairs, stiffness=stiffness, enforcement=enforcement), offset)
    else:
        scene = skeleton(structure, cells, offset if model == "flange" else None)
    return Case(
        scene=scene, control=ArcLength() if step is None else ArcLength(step=step), until=Until(deflection=to),
        quantities=quantities, pictures=[*STANDARD, draw_critical_modes, pair_history],
        axes=("deflection of the apex (mm)", "load (N)"))


def dome(table: meshes.Table, held: str = "x y z") -> Structure:
    """The dome of a table's nodes, bars and panels, held at its corners and pushed at its apex."""
    for name in ("apex", "corners"):
        if name not in table.sets:
            raise ValueError(f"dome: the geometry has no set of nodes {name!r}; add it to the table")
    return Structure(table.nodes, {"dome": Members(table.bars, BAR, STEEL)},
                     {"dome": Sheets(table.panels, PANEL, STEEL)}, {"corners": held}, {"apex": (0.0, 0.0, -1.0)},
                     ("apex", "z", -1.0), table.sets)


def quantities(record: Record) -> dict[str, float]:
    """Initial stiffness, linear buckling load, and of the first critical point the bars' shares in energies.

    One is of the energy of its mode, the other of that which is stored in the state behind it.
    """
    first = record.states[0]
    values = {"initial_stiffness": 1 / first.reference[1],
              "linear_buckling_load": min(b.load for b in record.buckling(first, count=2) if b.factor > 0)}
    beams = [isinstance(part, Beam) for part in record.case.scene.parts]
    for point in record.critical_points[:1]:
        shares = record.energy_shares(record.critical_modes(point))
        values |= {f"{point.kind}_load": point.load, f"{point.kind}_deflection": point.deflection,
                   "bars_share_of_mode": float(np.dot(beams, shares)), "bars_share_of_energy": _share(record, beams)}
    return values


def _share(record: Record, beams: list[bool]) -> float:
    """Share of the bars in the energy stored at the end of the step that the first critical point lies in."""
    with last_state_kept(record):
        record.show(next(s for s in record.states if s.step == record.critical_points[0].step))
        energies = record.energies()
    return float(np.dot(beams, energies)) / sum(energies)
