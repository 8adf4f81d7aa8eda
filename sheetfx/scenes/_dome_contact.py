"""Panels of a dome that are welded to its bars near their corners and touch them elsewhere."""

from __future__ import annotations

from functools import partial

import numpy as np

from .. import meshes
from ..mesh.lines import Stretch
from ..mesh.mixed import MixedMesh, read_mixed
from ..model.interface import bolt, hinge, weld
from ..model.joints import Joint
from ..model.pair_contact import FACES, PairContact
from ..model.shell import TRIANGLE, ShellForm

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
    chosen = FACES if faces == "both" else (faces,)
    return [TIES[tie](mesh.surfaces, ends, (mesh.curves, None)),
            *(PairContact(mesh.surfaces, list(lines), (mesh.curves, None), face, toward=INWARD, name="contact",
                          **contact) for face in chosen)]
