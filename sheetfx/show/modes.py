"""Buckling modes as a picture, as a table and as files for ParaView."""

from __future__ import annotations

import csv
from dataclasses import replace
from pathlib import Path as Folder

import numpy as np
from dolfinx import fem
from dolfinx.io import VTKFile
from scipy.spatial import cKDTree

from ..record import Record
from ..stability.buckling import BucklingLoad
from ..stability.modes import mode_displacement
from .display import save_picture
from .evaluate import Curves, communicator, unit_of, with_unit
from .surfaces import Surface, surfaces
from .views import Manner, View, draw_views

WIDTH, HEIGHT, ROW, COLUMNS, MOST = 1600, 900, 450, 3, 9  # in pixels: of pictures, least and of each row
SHARE = 0.05  # of the structure's size, by which its modes are moved
COLUMNS_OF_TABLE = ("factor", "load", "increment", "cluster", "multiplicity", "residual")


def draw_modes(record: Record, folder: Folder, name: str = "modes.png") -> None:
    """Draw the buckling modes nearest to the last state (process 0 writes the file).

    Colours show the displacement along the normal of surfaces; curves stand beside the undeformed ones. The picture
    is left out with a warning where there is no X server and Xvfb is missing.
    """
    shapes = [shape_of(record, load.mode, _title(load)) for load in record.buckling()[:MOST]]
    if communicator(record).rank == 0:
        save_picture(lambda file: draw_shapes(record, shapes, file), Folder(folder) / name)


def _title(load: BucklingLoad) -> str:
    group = f", cluster of {load.multiplicity}" if load.multiplicity > 1 else ""
    return f"load factor {load.factor:.5g}{group}"


def mode_files(record: Record, folder: Folder) -> None:
    """Write buckling.csv, and paraview/modes.pvd with the number of the mode as time.

    A scene of several meshes gets modes.pvd, modes1.pvd and so on.
    """
    if communicator(record).rank == 0:
        with (Folder(folder) / "buckling.csv").open("w", newline="") as stream:
            writer = csv.writer(stream)
            writer.writerow(COLUMNS_OF_TABLE)
            writer.writerows([getattr(load, c) for c in COLUMNS_OF_TABLE] for load in record.buckling())
    for i, mesh in enumerate(record.case.scene.meshes):
        degree = min(record.path.discretisation.kinematics(mesh).u.function_space.element.basix_element.degree, 2)
        function = fem.Function(fem.functionspace(mesh.domain, ("P", degree, (mesh.dimension,))), name="mode")
        with VTKFile(mesh.domain.comm, Folder(folder) / "paraview" / f"modes{i or ''}.pvd", "w") as stream:
            for number, load in enumerate(record.buckling()):
                function.interpolate(mode_displacement(record.path, mesh, load))
                stream.write_function(function, float(number))


def shape_of(record: Record, mode: np.ndarray, title: str) -> View | None:
    """A mode on process 0, None elsewhere; displacements are those of `mode_displacement`, the largest 1."""
    displacements = {mesh: mode_displacement(record.path, mesh, mode) for mesh in record.case.scene.meshes}
    found, curves = surfaces(record, displacements), Curves(record, displacements).evaluate()
    if found is None or curves is None:
        return None
    before, after = curves
    return View(title, [replace(s, values=_along_normals(s)) for s in found], after, None, before)


def _along_normals(surface: Surface) -> np.ndarray:
    """Displacement along the normals of a surface, over the largest, at its places."""
    mesh = surface.mesh(surface.undeformed).compute_normals(cell_normals=False, split_vertices=False)
    values = np.einsum("ni,ni->n", mesh["displacement"], mesh["Normals"])
    return values[cKDTree(mesh.points).query(surface.undeformed)[1]] / (np.abs(values).max() or 1.0)


def draw_shapes(record: Record, shapes: list[View], file: Folder) -> None:
    """Draw modes side by side, to one scale, which moves them by a small part of the structure's size."""
    scale = SHARE * float(np.linalg.norm(np.ptp(shapes[0].undeformed, axis=0)))
    rows = -(-len(shapes) // COLUMNS)
    moved = with_unit(scale, unit_of(record.case.axes[0]))
    draw_views([shape.moved(scale) for shape in shapes], file, Manner(
        "displacement along the normal, over the largest",
        [f"largest displacement of a mode drawn as {moved}", "grey: undeformed"], "coolwarm", (-1.0, 1.0), False,
        (WIDTH, max(HEIGHT, ROW * rows))))
