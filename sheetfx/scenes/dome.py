"""Three-way dome of bars and panels under a force at its apex (thesis, sections 5.2 and 5.3).

19 nodes, 42 bars (tubes 40 x 2), 24 flat steel panels 10 mm thick, span 8 m and rise 1.6 m. The thesis prints neither
coordinates nor drawing: three geometries are likely, see `meshes.dome`. It fixes the six outermost corners; they are
pinned here, and `--held "x y z rx ry rz"` clamps them. Where mid-surfaces of panels lie against the axes of the bars it
does not say either: `--offset` is that distance, zero by default. With `--model contact` which faces touch and how long
the welds are decides the answer (demos/dome_contact.md); the thesis gives neither.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from typing import Annotated

import numpy as np
from typer import Option

from .. import meshes
from ..case import Case
from ..checks import AT_LEAST_1, NOT_NEGATIVE, POSITIVE, Choice
from ..continuation.control import ArcLength
from ..mesh.mixed import read_mixed
from ..mesh.reader import NamedMesh, read
from ..model.beam import Beam
from ..model.joints import Compatible, Joint
from ..model.loads import PointForce
from ..model.pair_contact import ENFORCEMENTS
from ..model.plate import Plate
from ..model.scene import Monitor, Scene
from ..model.section import Elastic, Flanged, Tube, effective_width
from ..model.shell import TRIANGLE, Shell, named_form
from ..model.supports import Support
from ..path import Until
from ..record import Record
from ..show.critical_modes import draw_critical_modes
from ..show.evaluate import last_state_kept
from ..show.pairs import pair_history
from ..show.standard import STANDARD
from . import looked_at
from ._benchmark import Form
from ._dome_contact import EDGES, FACES_OF_PANELS, TIES, joints, separate_panels

BAR, PANEL = Tube(40.0, 2.0), Plate(10.0)
STEEL = Elastic(2.1e5, 0.3, density=7.85e-9)
MODELS = "coupled", "contact", "flange", "bars"


@dataclass(frozen=True, eq=False)
class Dome:
    """Parts of a dome.

    Attributes
    ----------
    bars : mesh that has the apex and the corners
    parts, joints : of the scene
    """

    bars: NamedMesh
    parts: list[Beam | Shell]
    joints: list[Joint]


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
    table = meshes.dome(geometry)
    for name in ("apex", "corners"):
        if name not in table.sets:
            raise ValueError(f"dome: the geometry {geometry!r} has no set of nodes {name!r}; add it to the table")
    if model == "coupled":
        dome = coupled(table, divisions, form, offset, grading)
    elif model == "contact":
        dome = touching(table, divisions, form, offset, faces, weld, pairs, stiffness, grading, tie=tie, gap=gap,
                        friction=friction, enforcement=enforcement, edges=edges)
    else:
        dome = skeleton(table, divisions, offset if model == "flange" else None, grading)
    bars = dome.bars
    return Case(
        scene=Scene(dome.parts, [Support(bars, "corners", held)], [PointForce(bars, "apex", (0.0, 0.0, -1.0))],
                    Monitor(bars, "apex", "z", -1.0), joints=dome.joints),
        control=ArcLength() if step is None else ArcLength(step=step), until=Until(deflection=to),
        quantities=quantities, pictures=[*STANDARD, draw_critical_modes, pair_history],
        axes=("deflection of the apex (mm)", "load (N)"))


def coupled(table: meshes.Table, divisions: int, form: str, offset: float = 0.0, grading: float = 1.0) -> Dome:
    """Panels and bars that share all nodes along their edges."""
    discrete = named_form(form)
    panels_and_bars = partial(meshes.structure, table, divisions, discrete.cell == TRIANGLE, grading=grading)
    mesh = read_mixed(panels_and_bars, ["bars"])
    beams = Beam(mesh.curves, BAR, STEEL, degree=discrete.displacement[1])
    return Dome(mesh.curves, [beams, Shell(mesh.surfaces, PANEL, STEEL, form=form, offset=offset)],
                [Compatible(mesh.curves, mesh.surfaces)])


def touching(table: meshes.Table, divisions: int, form: str, offset: float, faces: str, weld: float,
             pairs: int | None, stiffness: float | None, grading: float = 1.0, edges: str = "own", **joined) -> Dome:
    """Panels that are welded to the bars near their corners, and touch them elsewhere."""
    discrete = named_form(form)
    mesh = separate_panels(table, divisions, discrete, edges, grading)
    if stiffness is not None and pairs is not None:
        lengths = [np.linalg.norm(np.subtract(table.nodes[a], table.nodes[b])) for a, b in table.bars]
        stiffness *= pairs / float(np.mean(lengths))
    beams = Beam(mesh.curves, BAR, STEEL, degree=discrete.displacement[1])
    return Dome(mesh.curves, [beams, Shell(mesh.surfaces, PANEL, STEEL, form=form, offset=offset)],
                joints(mesh, table, faces, weld, edges=edges, pairs=pairs, stiffness=stiffness, **joined))


def skeleton(table: meshes.Table, divisions: int, offset: float | None, grading: float = 1.0) -> Dome:
    """Bars alone (offset None), or with the effective width of panels that stand so far above their axes as flanges."""
    alone = meshes.Table(table.nodes, table.bars, (), table.sets)
    mesh = read(partial(meshes.structure, alone, divisions, grading=grading), 3)
    if offset is None:
        return Dome(mesh, [Beam(mesh, BAR, STEEL)], [])
    alike: dict[str, list[str]] = {}
    for name, ends in table.named_bars.items():
        alike.setdefault(f"{flange_width(table, ends):.9g}", []).append(name)
    parts: list[Beam | Shell] = []
    for width, names in alike.items():
        mesh.cells[f"flange {width}"] = np.sort(np.concatenate([mesh.cells[name] for name in names]))
        section = Flanged(BAR, float(width), PANEL.thickness, offset)
        parts.append(Beam(mesh, section, STEEL, group=f"flange {width}", offset=(section.centroid, 0.0)))
    return Dome(mesh, parts, [])


def flange_width(table: meshes.Table, ends) -> float:
    """Effective width of the panels at a bar, whose halves reach to a third of their heights, as their centroids do."""
    places = {name: np.array(x, dtype=float) for name, x in table.nodes.items()}
    first, last = (places[name] for name in ends)
    span, heights = float(np.linalg.norm(last - first)), []
    for panel in table.panels:
        if set(ends) <= set(panel):
            across = np.mean([places[name] for name in panel], axis=0) - first
            heights.append(float(np.linalg.norm(np.cross(across, (last - first) / span))))
    return effective_width(span, PANEL.thickness, BAR.diameter, sum(heights))


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
