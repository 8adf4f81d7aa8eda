"""Frame of a column and a beam, loaded at its corner: asymmetric bifurcation (Roorda 1965; Koiter 1967).

Members of equal length and section, pinned at their far ends. The column's shortening would bend the beam and make
the frame imperfect; so the beam ends on a strut that shortens as the column does under the same force, and does not
bend: one element with the area of the column and a millionth of its bending stiffness. The perfect frame then keeps its
shape up to the bifurcation, at 1.4069 times Euler's load of the column on two hinges: the load's unit here.
"""

from __future__ import annotations

from math import pi
from typing import Annotated

from typer import Option

from .. import meshes
from ..case import Case
from ..checks import AT_LEAST_1, POSITIVE
from ..continuation.control import LoadControl
from ..mesh.reader import read
from ..model.beam import Beam
from ..model.loads import PointForce
from ..model.scene import Monitor, Scene
from ..model.section import Elastic, Rectangle
from ..model.supports import Support, pin
from . import looked_at
from .column import quantities

LENGTH = 1.0


@looked_at
def case(
    depth: Annotated[float, POSITIVE, Option(help="depth of the section; members have length 1")] = 1e-3,
    elements: Annotated[int, AT_LEAST_1, Option(help="elements on each member, of degree 1")] = 40,
    to: Annotated[float, POSITIVE, Option(help="force on the corner over Euler's load at which the path ends")] = 2.0,
    step: Annotated[float, POSITIVE, Option(help="first step of the load, over Euler's")] = 0.2,
) -> Case:
    """Roorda's frame, perfect: the load falls on one side of the bifurcation and rises on the other."""
    nodes = {"base": (0.0, 0.0), "corner": (0.0, LENGTH), "end": (LENGTH, LENGTH), "foot": (LENGTH, 0.0)}
    members = {"column": ("base", "corner", elements), "beam": ("corner", "end", elements), "strut": ("foot", "end", 1)}
    mesh = read(lambda: meshes.frame(nodes, members), 2)
    material = Elastic(12 * LENGTH**2 / (pi**2 * depth**3))
    sections = {name: Rectangle(1.0, depth) for name in members} | {"strut": Rectangle(1e3, 1e-3 * depth)}
    return Case(
        scene=Scene(
            parts=[Beam(mesh, s, material, group=name, degree=1) for name, s in sections.items()],
            supports=[pin(mesh, "base"), pin(mesh, "foot"), Support(mesh, "end", "x")],
            loads=[PointForce(mesh, at, (0.0, -1.0)) for at in ("corner", "end")],
            monitor=Monitor(mesh, "corner", "rz")),
        control=LoadControl(step=step, target=to), quantities=quantities,
        axes=("rotation of the corner", "load on corner and strut over Euler's"))
