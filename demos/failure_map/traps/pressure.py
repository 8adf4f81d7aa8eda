"""Shells under pressure that follows them."""

from __future__ import annotations

from functools import partial
from math import cos, pi, radians, sin

import numpy as np

from sheetfx.case import Case
from sheetfx.continuation.control import ArcLength, LoadControl
from sheetfx.model.following import Pressure
from sheetfx.model.plate import Plate
from sheetfx.model.scene import Monitor, Scene
from sheetfx.model.section import Elastic
from sheetfx.model.shell import Shell
from sheetfx.model.supports import Support, clamp, symmetry
from sheetfx.path import Until
from sheetfx.scenes._benchmark import cylinder, surface

from .trap import Trap, bifurcation, limits

FORM, POISSON = "naghdi-q3", 0.3


def pressed_cylinder(to: float, step: float, cells: int = 8, thickness: float = 0.01, length: float = 0.4) -> Case:
    """Half of a piece of a long cylinder of radius 1 between planes of symmetry; its plates' stiffness D is 1."""
    mesh = cylinder(FORM, (1, cells), 1.0, length, pi, {})
    shell = Shell(mesh, Plate(thickness), Elastic(12 * (1 - POISSON**2) / thickness**3, POISSON), form=FORM)
    planes = {"west": "x", "east": "x", "south": "y", "north": "y"}
    supports = [symmetry(mesh, edge, normal) for edge, normal in planes.items()]
    return Case(Scene([shell], [*supports, Support(mesh, "south-west", "z")], [Pressure(shell, -1.0)],
                      Monitor(mesh, "north-west", "z")), LoadControl(step=step, target=to))


def holed_cap(rim: float = 4.5, hole: float = 0.9, thickness: float = 1e-3, cells: int = 8, sector: float = 15.0,
              step: float = 1e-3) -> Case:
    """Sector of a spherical cap of radius 1 with a hole at its pole and a clamped rim, angles in degrees.

    The pressure is given over the classical one of the sphere.
    """
    start, end, wide = radians(hole), radians(rim), radians(sector)

    def place(s, t):
        colatitude, longitude = start + (end - start) * s, wide * t
        return np.sin(colatitude) * np.cos(longitude), np.sin(colatitude) * np.sin(longitude), np.cos(colatitude)

    mesh = surface(FORM, (cells, 1), place, {})
    classical = 2 * thickness**2 / np.sqrt(3 * (1 - POISSON**2))
    shell = Shell(mesh, Plate(thickness), Elastic(1 / classical, POISSON), form=FORM)
    side = (-sin(wide), cos(wide), 0.0)
    return Case(Scene([shell], [symmetry(mesh, "south", "y"), symmetry(mesh, "north", side), clamp(mesh, "east")],
                      [Pressure(shell, -1.0)], Monitor(mesh, "south-west", "z", -1.0)),
                ArcLength(step=step), Until(deflection=2.5 * (1 - cos(end))))


PRESSURE = (
    Trap("pressed-cylinder",
         "Pressure turns with the shell; between planes of symmetry it has a potential, though no closed surface is "
         "modelled.",
         partial(pressed_cylinder, 20.0, 1.0), tuple(bifurcation(p, None, 5e-4) for p in (3.0, 8.0, 15.0)),
         "p R^3 / D = n^2 - 1 (Bresse 1866)", slow=True),
    Trap("holed-cap",
         "The pressure has no potential, for the cap has a free edge; its tangent is not symmetric at limit points.",
         holed_cap, limits(0.514122, 0.352335, tolerance=2e-3),
         "axisymmetric shell by collocation, tests/traps/test_shell_references.py", slow=True),
)
