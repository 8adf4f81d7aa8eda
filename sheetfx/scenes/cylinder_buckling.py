"""Buckling of a cylinder in axial compression: the classical load and its cluster of modes.

Before buckling the ends may widen, so that the stress is uniform; in the modes they stay round and carry no further
axial force, the classical simple support (SS3 of Hoff). The classical load E t^2 / (R sqrt(3 (1 - nu^2))) per length
is that of shallow-shell theory. A shell with n waves around buckles about 1 / n^2 below it, so the default cylinder is
short and thin, with about 20 waves. Modes are compared with the exact waves of the same strains on a true cylinder.
"""

from __future__ import annotations

from math import pi, sqrt
from typing import Annotated

import numpy as np
from scipy.linalg import eigh
from typer import Option

from ..case import Case
from ..checks import AT_LEAST_1, POSITIVE
from ..critical.buckling import buckling
from ..model.loads import EdgeForce
from ..model.plate import Plate
from ..model.scene import Monitor, Scene
from ..model.section import Elastic
from ..model.shell import Shell
from ..model.supports import Support, symmetry
from ..path import Until
from ..record import Record
from . import looked_at
from ._benchmark import Form, surface

RADIUS, MATERIAL = 1000.0, Elastic(70000.0, 0.3)


@looked_at
def case(
    ratio: Annotated[float, POSITIVE, Option(help="radius over thickness")] = 500.0,
    halves: Annotated[float, POSITIVE, Option(help="length, in half waves of the axisymmetric mode")] = 2.0,
    cells: Annotated[tuple[int, int], Option(help="cells around a quarter and along")] = (24, 4),
    form: Form = "naghdi-q3",
    count: Annotated[int, AT_LEAST_1, Option(help="number of buckling loads")] = 8,
) -> Case:
    """Quarter of an axially compressed cylinder: modes with an even number of waves around."""
    thickness = RADIUS / ratio
    length = halves * pi * RADIUS / axisymmetric_wave(ratio)

    def place(x, y):
        return RADIUS * np.cos(pi / 2 * x), RADIUS * np.sin(pi / 2 * x), length * y

    mesh = surface(form, cells, place, {})
    shell = Shell(mesh, Plate(thickness), MATERIAL, form=form)
    free = [symmetry(mesh, "west", "y"), symmetry(mesh, "east", "x"), Support(mesh, "south-west", "z")]
    held = [*free, *(Support(mesh, end, "x y rz") for end in ("south", "north"))]
    force = classical(thickness)
    return Case(
        scene=Scene(
            [shell], free,
            [EdgeForce(mesh, "south", (0.0, 0.0, force)), EdgeForce(mesh, "north", (0.0, 0.0, -force))],
            Monitor(mesh, "north-west", "z", -1.0), symmetry_factor=4),
        until=Until(steps=0),
        buckling=lambda path, state: buckling(path, state, count, supports=held, tolerance=5e-3),
        quantities=lambda record: quantities(record, thickness, length),
        axes=("shortening (mm)", "load on both ends (N)"))


def axisymmetric_wave(ratio: float) -> float:
    """Classical wave number of the axisymmetric mode times the radius."""
    return (12 * (1 - MATERIAL.poisson**2)) ** 0.25 * sqrt(ratio)


def classical(thickness: float) -> float:
    """Classical load per length of the edge."""
    return MATERIAL.modulus * thickness**2 / RADIUS / sqrt(3 * (1 - MATERIAL.poisson**2))


def quantities(record: Record, thickness: float, length: float) -> dict[str, float]:
    """Lowest load over the classical one, the number in its cluster, and the difference from exact waves."""
    loads = [b for b in record.buckling() if b.factor > 0]
    exact = [value for value, _, _ in waves(thickness, length)]
    differences = [abs(b.factor / value - 1) for b, value in zip(loads, exact, strict=False)]
    return {"factor": loads[0].factor, "exact_waves": exact[0], "cluster": loads[0].multiplicity,
            "largest_difference_percent": 100 * max(differences)}


def waves(thickness: float, length: float) -> list[tuple[float, int, int]]:
    """Buckling loads over the classical one, half waves along and waves around, the lowest load first.

    Waves of displacement and director on a cylinder with the strains of `forms.shell.naghdi`: even numbers around.
    """
    most = round(1.5 * axisymmetric_wave(RADIUS / thickness))
    along = range(1, 1 + max(2, round(1.5 * length / RADIUS * axisymmetric_wave(RADIUS / thickness) / pi)))
    return sorted((_wave_load(m * pi / length, n / RADIUS, thickness) / classical(thickness), m, n)
                  for m in along for n in range(0, most, 2))


def _wave_load(m: float, k: float, thickness: float) -> float:
    """Axial force per length at which a wave with wave numbers m along and k around buckles.

    Amplitudes of axial, circumferential and radial displacement and of the director's two components.
    """
    nu, curvature = MATERIAL.poisson, 1 / RADIUS
    plane = MATERIAL.modulus * thickness / (1 - nu**2)
    shear = 5 / 6 * MATERIAL.shear_modulus * thickness
    membrane = np.array([[-m, 0, 0, 0, 0], [0, k, curvature, 0, 0], [-k, m, 0, 0, 0]])
    bending = np.array([[0, 0, 0, -m, 0], [0, k * curvature, curvature**2, 0, k], [0, m * curvature, 0, -k, m]])
    slide = np.array([[0, 0, m, 1, 0], [0, -curvature, -k, 0, 1]])
    law = np.array([[1, nu, 0], [nu, 1, 0], [0, 0, (1 - nu) / 2]])
    energy = plane * membrane.T @ law @ membrane + plane * thickness**2 / 12 * bending.T @ law @ bending
    energy += shear * slide.T @ slide
    return 1 / float(eigh(np.diag([m**2, m**2, m**2, 0, 0]), energy, eigvals_only=True)[-1])
