"""Linear benchmark: roof on end diaphragms under its own weight (Scordelis and Lo 1964; MacNeal and Harder 1985)."""

from __future__ import annotations

from math import radians
from typing import Annotated

from typer import Option

from ..case import Case
from ..checks import NONZERO, POSITIVE
from ..model.loads import SurfaceForce
from ..model.plate import Plate
from ..model.section import Elastic
from ..model.shell import Shell
from ..model.supports import Support, symmetry
from . import looked_at
from ._benchmark import Cells, Form, LinearSteps, Reading, ShearFactor, benchmark, cylinder, members, slopes

RADIUS, LENGTH, HALF_ANGLE = 25.0, 50.0, radians(40.0)
READINGS = {"deflection": Reading("middle", "z", -1.0)}
# naghdi-q3 on 16 x 16 cells (32 x 32: equal to 1e-4); 0.3014 if the diaphragms also hold the rotation about the
# axis; shear-rigid 0.3006; 0.3024 published.
REFERENCE = {"deflection": 0.3020}
CHART = members({"naghdi-q2": (4, 8, 12, 16), "naghdi-q3": (2, 4, 6, 8), "naghdi-t2": (4, 8, 12, 16)}, steps=0)


@looked_at
def case(
    cells: Cells = 8,
    form: Form = "naghdi-q3",
    thickness: Annotated[float, POSITIVE, Option(help="of the roof; its radius is 25")] = 0.25,
    load: Annotated[float, NONZERO, Option(help="weight per area")] = 90.0,
    shear_factor: ShearFactor = 5 / 6,
    steps: LinearSteps = 1,
) -> Case:
    """Scordelis-Lo roof: the linear deflection at the middle of a free edge. A quarter is modelled."""
    mesh = cylinder(form, (cells, cells), RADIUS, LENGTH / 2, HALF_ANGLE, {"middle": (0, 1)})
    shell = Shell(mesh, Plate(thickness, shear_factor), Elastic(4.32e8, 0.0), form=form)
    return benchmark(
        shell, [symmetry(mesh, "west", "x"), symmetry(mesh, "south", "y"), Support(mesh, "east", "y z")],
        [SurfaceForce(shell, (0.0, 0.0, -load))], READINGS,
        ("deflection of the free edge", "weight"), steps=steps, symmetry_factor=4,
        quantities=lambda record: slopes(record, READINGS, 0))
