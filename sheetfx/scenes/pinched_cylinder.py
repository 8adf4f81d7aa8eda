"""Linear benchmark: cylinder with end diaphragms pinched by two forces (MacNeal and Harder 1985: 1.8248e-5)."""

from __future__ import annotations

from typing import Annotated

from typer import Option

from ..case import Case
from ..checks import NONZERO, POSITIVE
from ..model.loads import PointForce
from ..model.plate import Plate
from ..model.section import Elastic
from ..model.shell import Shell
from . import looked_at
from ._benchmark import Cells, Form, LinearSteps, Reading, ShearFactor, benchmark, members, slopes
from .diaphragm_cylinder import eighth

READINGS = {"deflection": Reading("A", "z", -1.0)}
# naghdi-q3 on 32 x 32 cells. Transverse shear has no finite deflection under a point force: 48 x 48 cells add 0.03 %.
# Shear-rigid, as published: 1.8246e-5.
REFERENCE = {"deflection": 1.859e-5}
CHART = members({"naghdi-q2": (8, 16, 24, 32), "naghdi-q3": (4, 8, 12, 16), "naghdi-t2": (8, 16, 24, 32)}, steps=0)


@looked_at
def case(
    cells: Cells = 16,
    form: Form = "naghdi-q3",
    thickness: Annotated[float, POSITIVE, Option(help="of the shell; the radius is 300")] = 3.0,
    load: Annotated[float, NONZERO, Option(help="each of the two forces")] = 1.0,
    shear_factor: ShearFactor = 5 / 6,
    steps: LinearSteps = 1,
) -> Case:
    """Pinched cylinder: the linear deflection under a force. One eighth is modelled."""
    mesh, supports = eighth(form, cells, 300.0)
    return benchmark(
        Shell(mesh, Plate(thickness, shear_factor), Elastic(3e6, 0.3), form=form), supports,
        [PointForce(mesh, "A", (0.0, 0.0, -load / 4))], READINGS,
        ("deflection under a force", "sum of both forces"), steps=steps, symmetry_factor=8,
        quantities=lambda record: slopes(record, READINGS, 0))
