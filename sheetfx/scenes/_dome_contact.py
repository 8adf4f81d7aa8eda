"""Panels of a dome that are welded to its bars near their corners and touch them elsewhere."""

from __future__ import annotations

from collections.abc import Iterable
from functools import partial

import numpy as np

from .. import meshes
from ..mesh.lines import Stretch, lines_of
from ..mesh.mixed import MixedMesh, read_mixed
from ..model.interface import bolt, hinge, weld
from ..model.joints import Joint
from ..model.pair_contact import FACES, PairContact
from ..model.shell import TRIANGLE, ShellForm
from ..notices import warn

FACES_OF_PANELS = (*FACES, "both")
TIES = {"weld": weld, "bolt": bolt, "hinge": hinge}  # with all rotations, all but that in the panel's plane, none
EDGES: dict[str, bool | str] = {"own": True, "shared": "bars"}  # of panels, and from what `structure` separates them
INWARD = (0.0, 0.0, -1.0)  # roughly from the panels to the bars under them


def separate_panels(table: meshes.Table, divisions: int, form: ShellForm, edges: str,
                    grading: float) -> MixedMesh:
    """Bars that meet at the nodes, and panels that share nodes with nothing, or with each other alone."""
    panels_and_bars = partial(meshes.structure, table, divisions, form.cell == TRIANGLE, EDGES[edges], grading)
    return read_mixed(panels_and_bars, ["bars"])


def joints(mesh: MixedMesh, table: meshes.Table, faces: str, length: float, tie: str, edges: str,
           **contact) -> list[Joint]:
    """Welds of a length from each corner of a panel along both its edges, and contact along the edges.

    Parameters
    ----------
    edges : of panels, a key of `EDGES`
    faces : "seat", "butt", or "both"
    tie : of rotations in the welds, a key of `TIES`
    contact : further attributes of `PairContact`
    """
    lines = meshes.edges_of(table, EDGES[edges])
    ends = [Stretch(point, along=line, length=length) for line, points in lines.items() for point in points]
    shortest = min(np.linalg.norm(np.subtract(table.nodes[a], table.nodes[b])) for a, b in table.bars)
    if not 0 < length < shortest / 2:
        raise ValueError(f"dome: weld is {length}; give a length between 0 and half of the shortest bar, "
                         f"{shortest / 2:.4g}")
    if edges == "shared" and faces != "seat":
        raise ValueError(f"dome: faces is {faces!r}, but shared edges of panels do not push against bars; give seat")
    _warn_of_long_cells(mesh, lines, length)
    chosen = FACES if faces == "both" else (faces,)
    return [TIES[tie](mesh.surfaces, ends, (mesh.curves, None)),
            *(PairContact(mesh.surfaces, list(lines), (mesh.curves, None), face, toward=INWARD, name="contact",
                          **contact) for face in chosen)]


def _warn_of_long_cells(mesh: MixedMesh, lines: Iterable[str], length: float) -> None:
    """Say so where welds are shorter than half of the cells that they begin on, on which all such welds are alike."""
    pieces = [piece for line in lines for found in lines_of(mesh.surfaces, line) for piece in (found[0], found[-1])]
    longest = max((piece.length() for piece in pieces), default=0.0)
    if length < longest / 2:
        warn(f"dome: welds of {length:g} mm begin on cells of {longest:.4g} mm, more than twice as long: "
                      "stiffness, and where panels lift, are those of the mesh (demos/dome_contact.md); give more "
                      "divisions, or a grading")
