"""Axially compressed cylindrical panel: a cluster of bifurcations below the classical load.

A half of a cylinder between planes of symmetry, of which half the length and half the angle are modelled. The loaded
edge is hinged and held in its plane (simple support SS3), so that the panel bends near it before it buckles. The unit
of load is the classical one, E t^2 / (R sqrt(3 (1 - nu^2))) per length of the loaded edge.
"""

from __future__ import annotations

from math import pi, sqrt
from typing import Annotated

import numpy as np
from typer import Option

from ..case import Case
from ..checks import POSITIVE
from ..continuation.control import ArcLength
from ..model.loads import EdgeForce
from ..model.plate import Plate
from ..model.scene import Monitor, Scene
from ..model.section import Elastic
from ..model.shell import Shell
from ..model.supports import Support, symmetry
from ..path import Until
from . import looked_at
from ._benchmark import Form, surface
from .column import quantities

RADIUS, POISSON = 1.0, 0.3


@looked_at
def case(
    ratio: Annotated[float, POSITIVE, Option(help="radius over thickness")] = 100.0,
    length: Annotated[float, POSITIVE, Option(help="half the length over the radius")] = 0.5,
    cells: Annotated[tuple[int, int], Option(help="cells around and along")] = (10, 6),
    form: Form = "naghdi-q3",
    to: Annotated[float, POSITIVE, Option(help="load over the classical one at which the path ends")] = 0.9,
    step: Annotated[float, POSITIVE, Option(help="first arc length")] = 2e-4,
) -> Case:
    """Axially compressed panel: several bifurcations within a few percent of the classical load."""
    thickness, quarter = RADIUS / ratio, pi / 2

    def place(x, y):
        return RADIUS * np.cos(quarter * x), RADIUS * np.sin(quarter * x), length * y

    mesh = surface(form, cells, place, {"corner": (0, 1)})
    force = 1 / (RADIUS * quarter)
    modulus = force * RADIUS * sqrt(3 * (1 - POISSON**2)) / thickness**2
    shell = Shell(mesh, Plate(thickness), Elastic(modulus, POISSON), form=form)
    return Case(
        scene=Scene(
            [shell],
            [symmetry(mesh, "west", "y"), symmetry(mesh, "east", "x"),
             symmetry(mesh, "south", "z"), Support(mesh, "north", "x y rz")],
            [EdgeForce(mesh, "north", (0.0, 0.0, -force))], Monitor(mesh, "corner", "z", -1.0)),
        control=ArcLength(step=step), until=Until(load=to), quantities=quantities,
        axes=("shortening over the radius", "load over the classical one"))
