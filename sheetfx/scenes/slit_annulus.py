"""Slit annular plate lifted along one side of the slit (Sze, Liu and Lo 2004, section 3.3)."""

from __future__ import annotations

from math import pi
from typing import Annotated

import numpy as np
from typer import Option

from ..case import Case
from ..checks import AT_LEAST_1, NONZERO, NOT_NEGATIVE, POSITIVE
from ..model.loads import EdgeForce
from ..model.plate import Plate
from ..model.section import Elastic
from ..model.shell import Shell
from ..model.supports import clamp
from . import looked_at
from ._benchmark import Form, Published, Reading, Steps, benchmark, members, surface

INNER, OUTER = 6.0, 10.0
READINGS = {"w_A": Reading("A", "z"), "w_B": Reading("B", "z")}
PUBLISHED = Published("Sze, Liu and Lo (2004)", 3.2, (
    (0.025, 1.305, 1.789), (0.05, 2.455, 3.370), (0.075, 3.435, 4.720), (0.10, 4.277, 5.876), (0.125, 5.007, 6.872),
    (0.15, 5.649, 7.736), (0.20, 6.725, 9.160), (0.25, 7.602, 10.288), (0.30, 8.340, 11.213), (0.35, 8.974, 11.992),
    (0.40, 9.529, 12.661), (0.45, 10.023, 13.247), (0.50, 10.468, 13.768), (0.55, 10.876, 14.240),
    (0.60, 11.257, 14.674), (0.65, 11.620, 15.081), (0.70, 11.970, 15.469), (0.75, 12.310, 15.842),
    (0.80, 12.642, 16.202), (0.85, 12.966, 16.550), (0.90, 13.282, 16.886), (0.95, 13.590, 17.212),
    (1.00, 13.891, 17.528)))
# Quadrilaterals of degree 4, fully integrated, on 48 x 12 cells graded to the free edges, whose layers are as wide as
# the thickness: 13.8637, 17.5013 (48 x 10 cells graded to all edges: 13.8635, 17.5011; naghdi-q3 on 60 x 12 equal
# cells: 13.8634, 17.5010). The table, 13.891 and 17.528, does not resolve these layers.
REFERENCE = {"w_A": 13.8636, "w_B": 17.5012}
CHART = members({"naghdi-q2": (15, 30), "naghdi-q3": (12, 15, 18), "naghdi-t2": (15, 30)}, steps=4)
PEERS = [{"driver": "kratos", "arguments": [
    "slit-annulus", "--cells", "30", "--across", "6", "--steps", "20", "--solver", "sparse_lu"]}]


@looked_at
def case(
    cells: Annotated[int, AT_LEAST_1, Option(help="cells around the plate")] = 15,
    across: Annotated[int, NOT_NEGATIVE,
                      Option(help="cells across its width; 0: a fifth of those around, at least 2")] = 0,
    form: Form = "naghdi-q3",
    thickness: Annotated[float, POSITIVE, Option(help="of the plate; its radii are 6 and 10")] = 0.03,
    load: Annotated[float, NONZERO, Option(help="force per length of the free side of the slit")] = 0.8,
    steps: Steps = 5,
) -> Case:
    """Slit annular plate, one side of the slit clamped and the other lifted by more than its outer radius."""
    def place(s, t):
        radius, angle = INNER + (OUTER - INNER) * t, 2 * pi * s
        return radius * np.cos(angle), radius * np.sin(angle), 0 * s

    mesh = surface(form, (cells, across or max(2, cells // 5)), place, {"A": (0, 0), "B": (0, 1)})
    return benchmark(
        Shell(mesh, Plate(thickness), Elastic(21e6, 0.0), form=form), [clamp(mesh, "east")],
        [EdgeForce(mesh, "west", (0.0, 0.0, load))], READINGS, ("deflection of A", "force on the slit"),
        steps=steps, published=PUBLISHED)
