"""A shape of a structure, a sum of displacements, as a table of its nodes and a picture."""

from __future__ import annotations

import io
from collections.abc import Sequence
from pathlib import Path as Folder
from typing import Any

import numpy as np
from dolfinx import fem

from ..archive.folder import write_whole
from ..compat import geometry_nodes
from ..critical.imperfect import imperfect
from ..model.scene import Scene
from ..record import Record


def write_shape(file: Folder, scene: Scene, shapes: Sequence[Any], coefficients: Sequence[float]) -> None:
    """Write the nodes and their displacements by a sum of shapes with coefficients."""
    moved = imperfect(scene, list(shapes), list(coefficients))
    pairs = [(mesh.domain.geometry, after.domain.geometry.x) for mesh, after in zip(scene.meshes, moved.meshes,
                                                                                   strict=True)]
    rows = [np.column_stack((before.x, after - before.x))[:before.index_map().size_local] for before, after in pairs]
    table = scene.meshes[0].comm.gather(np.concatenate(rows))
    if table is not None:
        text = io.StringIO()
        np.savetxt(text, np.concatenate(table), fmt="%.12g", delimiter=",", header="x,y,z,dx,dy,dz", comments="")
        write_whole(file, text.getvalue())


def draw_shape(file: Folder, record: Record, shapes: Sequence[Any], coefficients: Sequence[float], title: str) -> None:
    """Draw the displacements by a sum of shapes with coefficients."""
    from ..show.measure import OF_SIZE
    from ..show.modes import draw_shapes, view_of
    from ..show.saving import save_picture

    scene, displacements = record.case.scene, {}
    moved = imperfect(scene, list(shapes), list(coefficients))
    for before, after in zip(scene.meshes, moved.meshes, strict=True):
        space = fem.functionspace(before.domain, before.domain.ufl_domain().ufl_coordinate_element())
        nodal = fem.Function(space)
        nodal.x.array.reshape(-1, before.dimension)[space.dofmap.list] = (
            after.domain.geometry.x - before.domain.geometry.x)[geometry_nodes(before.domain), :before.dimension]
        displacements[before] = fem.Function(record.path.discretisation.kinematics(before).u.function_space)
        displacements[before].interpolate(nodal)
    view = view_of(record, displacements, title, OF_SIZE)
    save_picture(record, lambda: draw_shapes(record, [view], OF_SIZE), file)
