"""Buckling modes as a picture, as a table and as files for ParaView."""

from __future__ import annotations

import csv
import warnings
from pathlib import Path as Folder

import numpy as np
from dolfinx import fem, plot
from dolfinx.io import VTKFile

from ..case import Record
from ..solve.buckling import BucklingLoad, mode_displacement
from .display import NoDisplay, display
from .evaluate import communicator

SIZE, COLUMNS, MOST = (1600, 900), 3, 6
SHARE = 0.04
UNDEFORMED, CURVE = "#9a9a9a", "#0b4f8a"
COLUMNS_OF_TABLE = ("factor", "load", "increment", "cluster", "multiplicity", "residual")


def draw_modes(record: Record, folder: Folder, name: str = "modes.png") -> None:
    """Draw the buckling modes nearest to the last state (process 0 writes the file).

    Colours show the displacement along the normal of surfaces; curves stand beside the undeformed ones. The picture
    is left out with a warning where there is no X server and Xvfb is missing.
    """
    loads = record.buckling[:MOST]
    models = _models(record)
    drawn = [[_gather(record, model, load) for model in models] for load in loads]
    if communicator(record).rank > 0:
        return
    length = max(_size(parts) for parts in drawn[0])
    try:
        with display():
            _draw(loads, drawn, SHARE * length, Folder(folder) / name)
    except NoDisplay as missing:
        warnings.warn(f"{name} is not drawn: {missing}", stacklevel=2)


def mode_files(record: Record, folder: Folder) -> None:
    """Write buckling.csv, and paraview/modes.pvd with the number of the mode as time.

    A scene of several models gets modes.pvd, modes1.pvd and so on.
    """
    if communicator(record).rank == 0:
        with (Folder(folder) / "buckling.csv").open("w", newline="") as stream:
            writer = csv.writer(stream)
            writer.writerow(COLUMNS_OF_TABLE)
            writer.writerows([getattr(load, c) for c in COLUMNS_OF_TABLE] for load in record.buckling)
    for i, model in enumerate(_models(record)):
        degree = min(record.path.discretisation.kinematics(model).u.function_space.element.basix_element.degree, 2)
        function = fem.Function(fem.functionspace(model.mesh, ("P", degree, (model.dimension,))), name="mode")
        with VTKFile(model.mesh.comm, Folder(folder) / "paraview" / f"modes{i or ''}.pvd", "w") as stream:
            for number, load in enumerate(record.buckling):
                function.interpolate(mode_displacement(record.path, model, load))
                stream.write_function(function, float(number))


def _models(record: Record) -> list:
    return list(dict.fromkeys(part.model for part in record.case.scene.parts))


def _size(parts) -> float:
    """Diagonal of the box around gathered pieces."""
    x = np.concatenate([piece[2] for piece in parts])
    return float(np.linalg.norm(np.ptp(x, axis=0)))


def _gather(record: Record, model, load: BucklingLoad) -> list | None:
    """Cells, their types, nodes and displacements of each process, on process 0."""
    displacement = mode_displacement(record.path, model, load)
    cells, types, x = plot.vtk_mesh(displacement.function_space, model.group(None))
    values = np.zeros((len(x), 3))
    values[:, :model.dimension] = displacement.x.array.reshape(len(x), -1)
    return communicator(record).gather((cells, types, x, values))


def _draw(loads, drawn, size: float, file: Folder) -> None:
    import pyvista

    rows = -(-len(loads) // COLUMNS)
    plotter = pyvista.Plotter(off_screen=True, shape=(rows, min(COLUMNS, len(loads))), window_size=SIZE, border=False)
    for i, (load, parts) in enumerate(zip(loads, drawn, strict=True)):
        plotter.subplot(i // COLUMNS, i % COLUMNS)
        flat = True
        for piece in (piece for part in parts for piece in part):
            flat = flat and not np.ptp(piece[2][:, 2]) and not piece[3][:, 2].any()
            _add(plotter, *piece, size)
        group = f", cluster of {load.multiplicity}" if load.multiplicity > 1 else ""
        plotter.add_text(f"load factor {load.factor:.5g}{group}", font_size=11, color="black")
        plotter.view_xy() if flat else plotter.view_isometric()
        plotter.camera.zoom(1.2)
    plotter.set_background("white")
    plotter.screenshot(file)
    plotter.close()


def _add(plotter, cells, types, x, displacement, size: float) -> None:
    """Add a piece with its nodes moved."""
    import pyvista

    grid = pyvista.UnstructuredGrid(cells, types, x)
    grid["displacement"] = displacement
    grid = grid.tessellate()
    surface = grid.extract_geometry()
    if surface.n_faces_strict:
        surface = surface.compute_normals(cell_normals=False, split_vertices=False)
        values = np.einsum("ni,ni->n", surface["displacement"], surface["Normals"])
        limit = float(np.abs(values).max()) or 1.0
        look = {"scalars": values, "cmap": "coolwarm", "clim": (-limit, limit), "show_scalar_bar": False,
                "ambient": 0.25, "diffuse": 0.75, "smooth_shading": True}
    else:
        plotter.add_mesh(surface.copy(), color=UNDEFORMED, line_width=2)
        look = {"color": CURVE, "line_width": 4}
    surface.points = surface.points + size * surface["displacement"]
    plotter.add_mesh(surface, **look)
