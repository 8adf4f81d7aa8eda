"""Buckling modes as a picture, as a table and as files for ParaView."""

from __future__ import annotations

import csv
from collections.abc import Callable
from functools import partial
from pathlib import Path as Folder
from typing import TYPE_CHECKING

import numpy as np
from dolfinx import fem
from dolfinx.io import VTKFile

from ..critical.modes import mode_displacement
from ..mesh.reader import NamedMesh
from .evaluate import Curves, communicator, unit_of, with_unit
from .measure import OF_SIZE, Measure
from .saving import save_picture
from .shown import Shown
from .surfaces import surfaces
from .views import Manner, View, coloured, draw_views

if TYPE_CHECKING:  # SLEPc starts slowly
    from ..critical.buckling import BucklingLoad

WIDTH, HEIGHT, ROW, COLUMNS, MOST = 1600, 900, 450, 3, 9  # in pixels: of pictures, least and of each row
SHARE = 0.05  # of the structure's size, by which its modes are moved
COLUMNS_OF_TABLE = ("factor", "load", "increment", "cluster", "multiplicity", "residual")


def draw_modes(record: Shown, folder: Folder, name: str = "modes.png") -> None:
    """Draw the buckling modes nearest to the last state (process 0 writes the file).

    The picture is left out with a warning where there is no X server and Xvfb is missing.
    """
    save_picture(record, picture_of_modes(record), Folder(folder) / name)


def picture_of_modes(record: Shown, measure: Measure = OF_SIZE) -> Callable:
    """A function that draws the buckling modes nearest to the last state, for process 0."""
    return partial(draw_shapes, record, [shape_of(record, load.mode, _title(load), measure)
                                         for load in record.buckling()[:MOST]], measure)


def _title(load: BucklingLoad) -> str:
    group = f", cluster of {load.multiplicity}" if load.multiplicity > 1 else ""
    return f"load factor {load.factor:.5g}{group}"


def mode_files(record: Shown, folder: Folder) -> None:
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
        with VTKFile(mesh.comm, Folder(folder) / "paraview" / f"modes{i or ''}.pvd", "w") as stream:
            for number, load in enumerate(record.buckling()):
                function.interpolate(mode_displacement(record.path, mesh, load))
                stream.write_function(function, float(number))


def shape_of(record: Shown, mode: np.ndarray, title: str, measure: Measure) -> View | None:
    """A mode on process 0, None elsewhere."""
    return view_of(record, {mesh: mode_displacement(record.path, mesh, mode) for mesh in record.case.scene.meshes},
                   title, measure)


def view_of(record: Shown, displacements: dict[NamedMesh, fem.Function], title: str, measure: Measure) -> View | None:
    """Displacements over the largest one on process 0, None elsewhere."""
    found, curves = surfaces(record, displacements), Curves(record, displacements).evaluate()
    if found is None or curves is None:
        return None
    before, after = curves
    shown = View(title, found, after, None, before)
    largest = max(float(np.linalg.norm(d, axis=-1).max(initial=0.0))
                  for d in (after - before, *(s.current - s.undeformed for s in found)))
    return coloured(shown.moved(1 / (largest or 1.0)), measure, (after - before) / (largest or 1.0))


def draw_shapes(record: Shown, shapes: list[View], measure: Measure):
    """The figure of modes side by side, to one scale, which moves them by a small part of the structure's size."""
    scale = SHARE * float(np.linalg.norm(np.ptp(shapes[0].undeformed, axis=0)))
    rows = -(-len(shapes) // COLUMNS)
    moved = with_unit(scale, unit_of(record.case.axes[0]))
    return draw_views([shape.moved(scale) for shape in shapes], Manner(
        f"{measure.name}, over the largest", [f"largest displacement of a mode drawn as {moved}", "grey: undeformed"],
        measure.colour_map, measure.limits([c for shape in shapes for c in shape.colours]), False,
        (WIDTH, max(HEIGHT, ROW * rows))))
