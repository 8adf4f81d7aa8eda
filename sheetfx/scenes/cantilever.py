"""Cantilever strip under an end shear (Sze, Liu and Lo 2004, section 3.1)."""

from __future__ import annotations

from typing import Annotated

from typer import Option

from ..case import Case
from ..checks import NONZERO, POSITIVE
from ..model.loads import EdgeForce
from ..model.plate import Plate
from ..model.section import Elastic
from ..model.shell import Shell
from ..model.supports import clamp
from . import looked_at
from ._benchmark import Cells, Form, Published, Reading, Steps, benchmark, members, surface

LENGTH, WIDTH = 10.0, 1.0
READINGS = {"w_tip": Reading("tip", "z"), "u_tip": Reading("tip", "x", -1.0)}
PUBLISHED = Published("Sze, Liu and Lo (2004)", 4.0, (
    (0.05, 0.663, 0.026), (0.10, 1.309, 0.103), (0.15, 1.922, 0.224), (0.20, 2.493, 0.381), (0.25, 3.015, 0.563),
    (0.30, 3.488, 0.763), (0.35, 3.912, 0.971), (0.40, 4.292, 1.184), (0.45, 4.631, 1.396), (0.50, 4.933, 1.604),
    (0.55, 5.202, 1.807), (0.60, 5.444, 2.002), (0.65, 5.660, 2.190), (0.70, 5.855, 2.370), (0.75, 6.031, 2.541),
    (0.80, 6.190, 2.705), (0.85, 6.335, 2.861), (0.90, 6.467, 3.010), (0.95, 6.588, 3.151), (1.00, 6.698, 3.286)))
# naghdi-q3 on 16 x 1 cells (8 x 1: equal to 1e-5); the table is 0.1 % below in u_tip.
REFERENCE = {"u_tip": 3.2897, "w_tip": 6.7002}
CHART = members({"naghdi-q2": (2, 4, 8, 16), "naghdi-q3": (1, 2, 4, 8), "naghdi-t2": (2, 4, 8, 16)})


@looked_at
def case(
    cells: Cells = 8,
    form: Form = "naghdi-q3",
    thickness: Annotated[float, POSITIVE, Option(help="of the strip; it is 10 long and 1 wide")] = 0.1,
    load: Annotated[float, NONZERO, Option(help="end shear at the end of the path")] = 4.0,
    steps: Steps = 2,
) -> Case:
    """Cantilever strip bent by an end shear of fixed direction, with one cell across its width."""
    mesh = surface(form, (cells, 1), lambda s, t: (LENGTH * s, WIDTH * t, 0 * s), {"tip": (1, 0)})
    return benchmark(
        Shell(mesh, Plate(thickness), Elastic(1.2e6, 0.0), form=form), [clamp(mesh, "west")],
        [EdgeForce(mesh, "east", (0.0, 0.0, load / WIDTH))], READINGS, ("deflection of the tip", "end shear"),
        steps=steps, published=PUBLISHED)
