"""Hemisphere with a hole of 18 degrees, pinched by four forces (Sze, Liu and Lo 2004)."""

from __future__ import annotations

from math import pi, radians
from typing import Annotated

import numpy as np
from typer import Option

from .. import meshes
from ..case import Case, Record
from ..mesh.reader import Model, read
from ..scene import Monitor, PointForce, Scene, Support, symmetry
from ..section import Elastic, Plate
from ..shell import Shell
from ..show.curves import path_curve
from ..show.files import paraview
from ..show.pictures import shapes
from ..solve.control import LoadControl

RADIUS, HOLE = 10.0, radians(18.0)


def scene(
    cells: Annotated[int, Option(help="cells on each side of a quarter")] = 8,
    form: Annotated[str, Option(help="of the shell")] = "naghdi-q3",
    thickness: Annotated[float, Option(help="of the shell; the radius is 10")] = 0.04,
    load: Annotated[float, Option(help="each of the four forces at the end of the path")] = 400.0,
    steps: Annotated[int, Option(help="load steps")] = 2,
) -> Case:
    """Pinched hemisphere: large rotations, hardly any stretching."""
    def place(x):
        azimuth, height = pi / 2 * x[:, 0], (pi / 2 - HOLE) * x[:, 1]
        return RADIUS * np.column_stack((np.cos(height) * np.cos(azimuth), np.cos(height) * np.sin(azimuth),
                                         np.sin(height)))

    triangles = form.startswith("naghdi-p")
    points = {"A": (0, 0), "B": (1, 0)}
    order = 2 if triangles else int(form.removeprefix("naghdi-q")[0])
    model = read(lambda: meshes.rectangle((cells, cells), triangles=triangles, points=points), 3, order, place)
    shell = Shell(model, Plate(thickness), Elastic(6.825e7, 0.3), form=form)
    return Case(
        scene=Scene(
            [shell], [symmetry(model, "west", "y"), symmetry(model, "east", "x"), Support(model, "A", "z")],
            [PointForce(model, "A", (load / 2, 0.0, 0.0)), PointForce(model, "B", (0.0, -load / 2, 0.0))],
            Monitor(model, "A", "x")),
        control=LoadControl(step=1 / steps, fixed=True), quantities=lambda record: quantities(record, model),
        pictures=[path_curve, shapes, paraview], axes=("deflection of A", "load"))


def quantities(record: Record, model: Model) -> dict[str, float]:
    """Deflections of the loaded points, outward at A and inward at B."""
    record.show(record.states[-1])
    kinematics = record.path.discretisation.kinematics(model)
    return {"u_A": float(kinematics.displacement(model, "A")[0]), "u_B": -float(kinematics.displacement(model, "B")[1])}
