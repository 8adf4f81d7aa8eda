"""Hemisphere with a hole of 18 degrees, pinched by four forces (Sze, Liu and Lo 2004, section 3.4).

The same structure under forces of 2 is the linear benchmark of MacNeal and Harder (1985): 0.0940.
"""

from __future__ import annotations

from math import pi, radians
from typing import Annotated

import numpy as np
from typer import Option

from ..case import Case
from ..checks import NONZERO, POSITIVE
from ..model.loads import PointForce
from ..model.plate import Plate
from ..model.section import Elastic
from ..model.shell import Shell
from ..model.supports import Support, symmetry
from . import looked_at
from ._benchmark import Cells, Form, Published, Reading, Steps, at_load, benchmark, members, slopes, surface

RADIUS, HOLE = 10.0, radians(18.0)
READINGS = {"u_A": Reading("A", "x"), "u_B": Reading("B", "y", -1.0)}
PUBLISHED = Published("Sze, Liu and Lo (2004)", 400.0, (
    (0.05, 0.855, 0.955), (0.10, 1.499, 1.840), (0.15, 1.969, 2.604), (0.20, 2.321, 3.261), (0.25, 2.596, 3.833),
    (0.30, 2.819, 4.339), (0.35, 3.002, 4.790), (0.40, 3.158, 5.196), (0.45, 3.291, 5.565), (0.50, 3.406, 5.902),
    (0.55, 3.508, 6.212), (0.60, 3.598, 6.497), (0.65, 3.678, 6.761), (0.70, 3.750, 7.006), (0.75, 3.816, 7.234),
    (0.80, 3.875, 7.448), (0.85, 3.929, 7.647), (0.90, 3.979, 7.835), (0.95, 4.025, 8.011), (1.00, 4.067, 8.178)))
# naghdi-q3 on 24 x 24 cells: 4.0760, 8.1544 (16 x 16: 4.0755, 8.1542). The table: 4.067, 8.178.
REFERENCE = {"u_A": 4.076, "u_B": 8.155}
CHART = members({"naghdi-q2": (8, 12, 16), "naghdi-q3": (4, 6, 8, 12), "naghdi-t2": (8, 12, 16)})
PEERS = [{"driver": "kratos", "arguments": ["hemisphere", "--cells", "24", "--steps", "10", "--solver", "amgcl"]}]


@looked_at
def case(
    cells: Cells = 8,
    form: Form = "naghdi-q3",
    thickness: Annotated[float, POSITIVE, Option(help="of the shell; the radius is 10")] = 0.04,
    load: Annotated[float, NONZERO, Option(help="each of the four forces at the end of the path")] = 400.0,
    steps: Steps = 2,
) -> Case:
    """Pinched hemisphere: large rotations, hardly any stretching."""
    def place(s, t):
        azimuth, height = pi / 2 * s, (pi / 2 - HOLE) * t
        return RADIUS * np.cos(height) * np.cos(azimuth), RADIUS * np.cos(height) * np.sin(azimuth), \
            RADIUS * np.sin(height)

    mesh = surface(form, (cells, cells), place, {"A": (0, 0), "B": (1, 0)})
    return benchmark(
        Shell(mesh, Plate(thickness), Elastic(6.825e7, 0.3), form=form),
        [symmetry(mesh, "west", "y"), symmetry(mesh, "east", "x"), Support(mesh, "A", "z")],
        [PointForce(mesh, "A", (load / 2, 0.0, 0.0)), PointForce(mesh, "B", (0.0, -load / 2, 0.0))],
        READINGS, ("deflection of A", "each force"), steps=steps, published=PUBLISHED,
        quantities=lambda record: at_load(record, READINGS) | {
            "linear_u_A": 2 / load * slopes(record, READINGS, 0)["u_A"]})
