"""Lee's frame: two members with a snap-through and a snap-back (Lee, Manuel and Rossow 1968).

The section's shear lowers the first limit to 18544.5; with a thousand times its shear stiffness the
frame is shear-rigid to 1e-6.
"""

from __future__ import annotations

from typing import Annotated

from typer import Option

from .. import meshes
from ..case import Case
from ..checks import AT_LEAST_1, POSITIVE, Choice
from ..continuation.control import ArcLength
from ..mesh.reader import read
from ..model.beam import Beam
from ..model.loads import PointForce
from ..model.scene import Monitor, Scene
from ..model.section import Elastic, Rectangle
from ..model.supports import pin
from ..path import Until
from ..record import Record
from ..show.snaps import falls_curve
from ..show.standard import STANDARD
from . import looked_at

SIDE, LOAD_FROM_CORNER = 120.0, 24.0
SECTION, MATERIAL = Rectangle(3.0, 2.0), Elastic(7.2e6, 0.3)


@looked_at
def case(
    elements: Annotated[int, AT_LEAST_1, Option(help="elements on each member, a multiple of 5")] = 20,
    degree: Annotated[int, Choice((1, 2, 3)), Option(help="of the elements: 1 (two nodes) or 2")] = 2,
    to: Annotated[float, POSITIVE, Option(help="deflection under the load at which the path ends")] = 95.0,
    step: Annotated[float, POSITIVE, Option(help="first arc length")] = 0.02,
) -> Case:
    """Lee's frame without shear: limits of 18556.7 and -9414.4, with a snap-back between them."""
    if elements < 5 or elements % 5:
        raise ValueError(f"lee-frame: elements is {elements}; a node under the load needs a multiple of 5")
    nodes = {"base": (0, 0), "corner": (0, SIDE), "load": (LOAD_FROM_CORNER, SIDE), "end": (SIDE, SIDE)}
    members = {
        "column": ("base", "corner", elements),
        "short": ("corner", "load", elements // 5),
        "long": ("load", "end", elements - elements // 5),
    }
    mesh = read(lambda: meshes.frame(nodes, members), 2)
    beam = Beam(mesh, SECTION, MATERIAL, degree=degree, shear_rigidity=1e3)
    return Case(
        scene=Scene(
            parts=[beam], supports=[pin(mesh, "base"), pin(mesh, "end")],
            loads=[PointForce(mesh, "load", (0.0, -1.0))], monitor=Monitor(mesh, "load", "y", -1.0)),
        control=ArcLength(step=step), until=Until(deflection=to), quantities=quantities,
        pictures=[*STANDARD, falls_curve],
        axes=("deflection under the load", "load"))


def quantities(record: Record) -> dict[str, float]:
    """Upper and lower limit load with their deflections."""
    limits = [p for p in record.critical_points if p.kind == "limit"]
    values = {}
    if limits:
        values |= {"limit_load": limits[0].load, "limit_deflection": limits[0].deflection}
    if len(limits) > 1:
        values |= {"lower_limit_load": limits[1].load, "lower_limit_deflection": limits[1].deflection}
    return values
