"""Buckling modes as a picture, as a table and as files for ParaView."""

from __future__ import annotations

import csv
from dataclasses import dataclass
from pathlib import Path as Folder

import numpy as np
from dolfinx import fem
from dolfinx.io import VTKFile

from ..record import Record
from ..stability.buckling import BucklingLoad
from ..stability.modes import mode_displacement
from .display import save_picture
from .evaluate import Curves, communicator
from .surfaces import Surface, surfaces
from .views import lines

WIDTH, HEIGHT, ROW, COLUMNS, MOST = 1600, 900, 450, 3, 9  # in pixels: of pictures, least and of each row
SHARE = 0.04
UNDEFORMED, CURVE = "#9a9a9a", "#0b4f8a"
COLUMNS_OF_TABLE = ("factor", "load", "increment", "cluster", "multiplicity", "residual")


def draw_modes(record: Record, folder: Folder, name: str = "modes.png") -> None:
    """Draw the buckling modes nearest to the last state (process 0 writes the file).

    Colours show the displacement along the normal of surfaces; curves stand beside the undeformed ones. The picture
    is left out with a warning where there is no X server and Xvfb is missing.
    """
    shapes = [shape_of(record, load.mode, _title(load)) for load in record.buckling()[:MOST]]
    if communicator(record).rank == 0:
        save_picture(lambda file: draw_shapes(shapes, file), Folder(folder) / name)


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


@dataclass
class ModeShape:
    """A mode as it is drawn, its places moved by the mode: title, surfaces, curves before and after."""

    title: str
    surfaces: list[Surface]
    curves: tuple[np.ndarray, np.ndarray]

    @property
    def undeformed(self) -> np.ndarray:
        """All undeformed places, (n, 3)."""
        return np.concatenate([*(s.undeformed for s in self.surfaces), self.curves[0].reshape(-1, 3)])

    @property
    def flat(self) -> bool:
        """Whether all lies in the plane of x and y, and stays there."""
        current = [*(s.current for s in self.surfaces), self.curves[1].reshape(-1, 3)]
        return not np.ptp(np.concatenate([self.undeformed, *current])[:, 2])


def shape_of(record: Record, mode: np.ndarray, title: str) -> ModeShape | None:
    """A mode on process 0, None elsewhere."""
    displacements = {mesh: mode_displacement(record.path, mesh, mode) for mesh in record.case.scene.meshes}
    found, curves = surfaces(record, displacements), Curves(record, displacements).evaluate()
    return None if found is None else ModeShape(title, found, curves)


def draw_shapes(shapes: list[ModeShape], file: Folder) -> None:
    """Draw modes side by side, moved by a small part of the structure's size."""
    import pyvista

    size = SHARE * np.linalg.norm(np.ptp(shapes[0].undeformed, axis=0))
    rows, columns = -(-len(shapes) // COLUMNS), min(COLUMNS, len(shapes))
    height = max(HEIGHT, ROW * rows)
    plotter = pyvista.Plotter(off_screen=True, shape=(rows, columns), window_size=(WIDTH, height), border=False)
    for i, shape in enumerate(shapes):
        plotter.subplot(i // COLUMNS, i % COLUMNS)
        for surface in shape.surfaces:
            _add_surface(plotter, surface, size)
        before, after = shape.curves
        if len(before):
            plotter.add_mesh(lines(before), color=UNDEFORMED, line_width=2)
            plotter.add_mesh(lines(before + size * (after - before)), color=CURVE, line_width=4)
        plotter.add_text(shape.title, font_size=11, color="black")
        plotter.view_xy() if shape.flat else plotter.view_isometric()
        plotter.camera.zoom(min(1.2, WIDTH / columns / (height / rows)))
    plotter.set_background("white")
    plotter.screenshot(file)
    plotter.close()


def _add_surface(plotter, surface: Surface, size: float) -> None:
    mesh = surface.mesh(surface.undeformed).compute_normals(cell_normals=False, split_vertices=False)
    values = np.einsum("ni,ni->n", mesh["displacement"], mesh["Normals"])
    mesh.points = mesh.points + size * mesh["displacement"]
    limit = float(np.abs(values).max()) or 1.0
    plotter.add_mesh(mesh, scalars=values, cmap="coolwarm", clim=(-limit, limit), show_scalar_bar=False,
                     ambient=0.25, diffuse=0.75, smooth_shading=True)
