"""Elastic-plastic cylinder with end diaphragms, pinched by two opposite forces (Brank, Peric and Damjanic 1997)."""

from __future__ import annotations

from typing import Annotated

from typer import Option

from ..case import Case
from ..checks import AT_LEAST_1, POSITIVE
from ..continuation.control import ArcLength
from ..model.loads import PointForce
from ..model.plasticity import Plastic
from ..model.plate import Plate
from ..model.shell import Shell
from ..path import Until
from ..record import Record
from . import looked_at
from ._benchmark import Cells, FirstArc, Form, Reading, benchmark, members
from .diaphragm_cylinder import eighth

RADIUS, THICKNESS, MODULUS, POISSON = 300.0, 3.0, 3000.0, 0.3
READINGS = {"w_A": Reading("A", "z", -1.0), "u_B": Reading("B", "y")}
DEFLECTIONS = 50.0, 100.0, 150.0, 200.0
# naghdi-q2 on 32 x 32 cells (24 x 24: 812.9, 1995.6, 2354.3, 4826.6; 16 x 16: 818.4, 1929.9, 2434.4, 4781.5); before
# 150 the fold that the force has made snaps through, at about 2900. The publication gives a curve, no figures.
REFERENCE = {"force_at_50": 815.7, "force_at_100": 1982.2, "force_at_150": 2392.2, "force_at_200": 4926.6}
CHART = members({"naghdi-q2": (16, 24, 32)})
PEERS = [{"driver": "kratos",
          "arguments": ["plastic-cylinder", "--cells", "24", "--step", "1", "--solver", "sparse_lu"]}]


@looked_at
def case(
    cells: Cells = 24,
    form: Form = "naghdi-q2",
    layers: Annotated[int, AT_LEAST_1, Option(help="layers through the thickness, by Gauss's rule")] = 5,
    yield_stress: Annotated[float, POSITIVE, Option("--yield", help="yield stress")] = 24.3,
    hardening: Annotated[float, Option(help="increase of the yield stress by plastic strain")] = 300.0,
    to: Annotated[float, POSITIVE, Option(help="deflection under a force at which the path ends")] = 200.0,
    step: FirstArc = 0.02,
) -> Case:
    """Pinched cylinder that flows and folds: the force at deflections of 50, 100, 150 and 200. One eighth is modelled.

    Radius 300, length 600, thickness 3, E = 3000, nu = 0.3, von Mises with linear isotropic hardening; the diaphragms
    hold the ends in their planes.
    """
    mesh, supports = eighth(form, cells, RADIUS)
    material = Plastic(MODULUS, POISSON, yield_stress=yield_stress, hardening=hardening)
    return benchmark(
        Shell(mesh, Plate(THICKNESS, points=layers), material, form=form), supports,
        [PointForce(mesh, "A", (0.0, 0.0, -0.25))], READINGS, ("deflection under a force", "sum of both forces"),
        symmetry_factor=8, control=ArcLength(step=step), until=Until(deflection=to), quantities=forces)


def forces(record: Record) -> dict[str, float]:
    """Each of the two forces where the path first comes to some deflections, between states in a straight line."""
    values: dict[str, float] = {}
    for before, after in zip(record.states, record.states[1:], strict=False):
        for w in DEFLECTIONS:
            if before.deflection < w <= after.deflection:
                part = (w - before.deflection) / (after.deflection - before.deflection)
                values.setdefault(f"force_at_{w:g}", (before.load + part * (after.load - before.load)) / 2)
    return values
