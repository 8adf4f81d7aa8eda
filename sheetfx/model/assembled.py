"""Scenes of a `Structure`: bars alone, with sheets as flanges, fully joined to sheets, or touching them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from typing import Annotated

import numpy as np

from .. import meshes
from ..checks import Choice, Count, NotNegative, Positive, Range, check
from ..mesh.lines import Stretch
from ..mesh.mixed import MixedMesh, read_mixed
from ..mesh.reader import NamedMesh, read
from .beam import Beam
from .interface import bolt, hinge, weld
from .joints import Compatible, Joint
from .loads import PointForce
from .pair_contact import ENFORCEMENTS, FACES, PairContact
from .scene import Monitor, Scene
from .section import Flanged, Section, effective_width
from .shell import FORMS, TRIANGLE, Shell, named_form
from .structure import Members, Structure
from .supports import Support

FACES_OF_PANELS = (*FACES, "both")
TIES = {"weld": weld, "bolt": bolt, "hinge": hinge}  # with all rotations, all but that in the panel's plane, none
EDGES: dict[str, bool | str] = {"own": True, "shared": "bars"}  # of panels, and from what `structure` separates them


@dataclass(frozen=True)
class Cells:
    """How a structure is divided into finite elements.

    Attributes
    ----------
    divisions : cells along each bar; even for quadrilaterals
    grading : ratio of the lengths of cells in the middle of each bar and at its ends
    form : of the shells
    """

    divisions: Count = 4
    grading: Annotated[float, Range(least=1)] = 1.0
    form: Annotated[str, Choice(tuple(FORMS))] = "naghdi-q2"

    def __post_init__(self):
        check(self)


@dataclass(frozen=True)
class Joining:
    """How sheets are joined to bars where they are not fully joined.

    Attributes
    ----------
    weld : length of the welds from each corner of a panel along its edges
    screws : number along each edge between its welds, evenly spaced
    radius : of a screw, which joins that much of the edge on both sides of it
    tie : of rotations in welds and screws: all (`weld`), all but that in the panel's plane (`bolt`), none (`hinge`)
    faces : that touch elsewhere: panels lie on bars (`seat`), their edges push against bars (`butt`), or `both`
    edges : of panels: each has its `own`, or neighbours `shared` ones
    gap, friction, pairs, stiffness, enforcement : of the contact, see `PairContact`
    """

    weld: Positive
    screws: Annotated[int, Range(least=0)] = 0
    radius: Positive = 1.0
    tie: Annotated[str, Choice(tuple(TIES))] = "weld"
    faces: Annotated[str, Choice(FACES_OF_PANELS)] = "both"
    edges: Annotated[str, Choice(tuple(EDGES))] = "own"
    gap: NotNegative = 0.0
    friction: NotNegative = 0.0
    pairs: Count | None = None
    stiffness: Positive | None = None
    enforcement: Annotated[str, Choice(ENFORCEMENTS)] = "condensed"

    def __post_init__(self):
        check(self)
        if self.edges == "shared" and self.faces != "seat":
            raise ValueError(f"Joining: faces is {self.faces!r}, but shared edges of panels do not push against bars; "
                             "give seat")


def skeleton(structure: Structure, cells: Cells, flange: float | None = None) -> Scene:
    """Bars alone, or with the effective width of the panels as flanges.

    Parameters
    ----------
    flange : height of the panels' mid-surfaces above the axes of the bars; None: no flanges
    """
    whole = structure.table
    kinds = {f"bars {name}": (kind, kind.section, 0.0, list(kind.ends)) for name, kind in structure.bars.items()}
    if flange is not None:
        kinds = _flanged(structure, flange)
    alone = meshes.Table(whole.nodes, whole.bars, (), whole.sets,
                         {name: [f"bar {'-'.join(ends)}" for ends in bars] for name, (*_, bars) in kinds.items()})
    mesh = read(partial(meshes.structure, alone, cells.divisions, grading=cells.grading), 3)
    return _scene(structure, mesh, [Beam(mesh, section, kind.material, group=name, up=kind.up, offset=offset)
                                    for name, (kind, section, offset, _) in kinds.items()])


def _flanged(structure: Structure, height: float) -> dict[str, tuple]:
    """Bars with equal flanges by a name: their kind, their section, the offset of its centroid, and their ends."""
    kinds: dict[str, tuple] = {}
    for name, kind in structure.bars.items():
        for ends in kind.ends:
            wide = f"{flange_width(structure, kind, ends):.9g}"
            section: Section = kind.section
            if float(wide):
                section = Flanged(kind.section, float(wide), _plate(structure).thickness, height)
            offset = getattr(section, "centroid", 0.0), 0.0
            kinds.setdefault(f"flange {wide} of {name}", (kind, section, offset, []))[-1].append(ends)
    return kinds


def coupled(structure: Structure, cells: Cells, offset: float = 0.0) -> Scene:
    """Sheets and bars that share all nodes along their edges.

    Parameters
    ----------
    offset : of the panels' mid-surfaces above the axes of the bars
    """
    mesh = _mesh(structure, cells, separate=False)
    return _scene(structure, mesh.curves, _parts(structure, mesh, cells, offset),
                  [Compatible(mesh.curves, mesh.surfaces)])


def touching(structure: Structure, cells: Cells, joining: Joining, offset: float = 0.0) -> Scene:
    """Sheets that are welded to the bars near their corners, screwed between them, and touch them elsewhere."""
    mesh = _mesh(structure, cells, EDGES[joining.edges])
    return _scene(structure, mesh.curves, _parts(structure, mesh, cells, offset), _joints(structure, mesh, joining))


def _mesh(structure: Structure, cells: Cells, separate: bool | str) -> MixedMesh:
    if not structure.panels:
        raise ValueError("Structure: panels is empty; give some, or take its `skeleton`, the bars alone")
    triangles = named_form(cells.form).cell == TRIANGLE
    source = partial(meshes.structure, structure.table, cells.divisions, triangles, separate, cells.grading)
    return read_mixed(source, ["bars"])


def flange_width(structure: Structure, kind: Members, ends: Sequence[str]) -> float:
    """Effective width of the panels at a bar, whose halves reach to a third of their heights, as their centroids do."""
    places = {name: np.array(x, dtype=float) for name, x in structure.nodes.items()}
    first, last = (places[name] for name in ends)
    span, heights = float(np.linalg.norm(last - first)), []
    for panel in structure.table.panels:
        if set(ends) <= set(panel):
            across = np.mean([places[name] for name in panel], axis=0) - first
            heights.append(float(np.linalg.norm(np.cross(across, (last - first) / span))))
    return effective_width(span, _plate(structure).thickness, width(kind), sum(heights)) if heights else 0.0


def width(kind: Members) -> float:
    """Width of a bar, across its depth."""
    return float(getattr(kind.section, "width", kind.section.depth))


def seat(structure: Structure) -> float:
    """Distance of the panels' mid-surfaces from the axes of the bars that they lie on: half of both depths."""
    return max(kind.section.depth for kind in structure.bars.values()) / 2 + _plate(structure).thickness / 2


def _plate(structure: Structure):
    """The plate of the panels, the same for all."""
    plates = {kind.plate for kind in structure.panels.values()}
    if len(plates) != 1:
        raise ValueError(f"Structure: its panels have {len(plates)} plates, of which one is needed for the distance "
                         "from the bars; give a number for it, and the model coupled or contact")
    return plates.pop()


def _parts(structure: Structure, mesh: MixedMesh, cells: Cells, offset: float) -> list[Beam | Shell]:
    degree = named_form(cells.form).displacement[1]
    return [*(Beam(mesh.curves, kind.section, kind.material, degree=degree, up=kind.up, group=f"bars {name}")
              for name, kind in structure.bars.items()),
            *(Shell(mesh.surfaces, kind.plate, kind.material, form=cells.form, offset=offset, group=f"panels {name}")
              for name, kind in structure.panels.items())]


def _joints(structure: Structure, mesh: MixedMesh, joining: Joining) -> list[Joint]:
    """Welds, screws and contact of the edges of panels that lie on bars."""
    table, length = structure.table, joining.weld
    bars = {frozenset(ends) for ends in table.bars}
    lines = {line: ends for line, ends in meshes.edges_of(table, EDGES[joining.edges]).items()
             if frozenset(name.split(" of ")[0] for name in ends) in bars}
    if not lines:
        raise ValueError("Structure: no edge of its panels lies along a bar, where they could be joined; add such bars")
    spans = {line: _distance(table, ends) for line, ends in lines.items()}
    if not length < (shortest := min(spans.values()) / 2):
        raise ValueError(f"Joining: weld is {length:g}; give a length below half of the shortest edge, {shortest:.4g}")
    tied = [Stretch(point, along=line, length=length) for line, ends in lines.items() for point in ends]
    for line, (first, _) in lines.items():
        between = (spans[line] - 2 * length) / (joining.screws + 1)
        if joining.screws and between <= 2 * joining.radius:
            raise ValueError(f"Joining: {joining.screws} screws with radius {joining.radius:g} overlap on {line!r}, "
                             f"where they are {between:.4g} apart; give fewer")
        tied += [Stretch(first, along=line, length=2 * joining.radius, after=length + n * between - joining.radius)
                 for n in range(1, joining.screws + 1)]
    faces = FACES if joining.faces == "both" else (joining.faces,)
    return [TIES[joining.tie](mesh.surfaces, tied, (mesh.curves, None)),
            *(PairContact(mesh.surfaces, list(lines), (mesh.curves, None), face, toward=structure.under, name="contact",
                          gap=joining.gap, friction=joining.friction, pairs=joining.pairs, stiffness=joining.stiffness,
                          enforcement=joining.enforcement) for face in faces)]


def _distance(table: meshes.Table, ends: Sequence[str]) -> float:
    first, last = (np.array(table.nodes[name.split(" of ")[0]], dtype=float) for name in ends)
    return float(np.linalg.norm(last - first))


def _scene(structure: Structure, bars: NamedMesh, parts: Sequence[Beam | Shell], joints: Sequence[Joint] = ()) -> Scene:
    at, component, sign = structure.monitor
    return Scene(parts, [Support(bars, place, held) for place, held in structure.supports.items()],
                 [PointForce(bars, place, tuple(force)) for place, force in structure.loads.items()],
                 Monitor(bars, at, component, sign), joints=joints)
