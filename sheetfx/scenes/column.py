"""Column under an axial force: Euler's bifurcations of a path that stays straight.

With extension and shear the column on two hinges buckles where P (1 - P / EA + P / kGA) = (n pi / L)^2 EI, as the
equations of Reissner (1972) give it; a slender one at n^2 times Euler's load. Loads are in units of Euler's load.
"""

from __future__ import annotations

from math import pi
from typing import Annotated

from typer import Option

from .. import meshes
from ..case import Case
from ..checks import AT_LEAST_1, POSITIVE, Choice
from ..continuation.control import LoadControl
from ..mesh.reader import read
from ..model.beam import Beam
from ..model.loads import PointForce
from ..model.scene import Monitor, Scene
from ..model.section import Elastic, Rectangle
from ..model.supports import Support
from ..record import Record
from . import looked_at

LENGTH = 1.0
ENDS = {"pinned-pinned": ("x y", "y"), "clamped-free": ("x y rz", ""), "clamped-pinned": ("x y rz", "y"),
        "clamped-clamped": ("x y rz", "y rz")}


@looked_at
def case(
    ends: Annotated[str, Choice(tuple(ENDS)), Option(help=f"of the column: {', '.join(ENDS)}")] = "pinned-pinned",
    depth: Annotated[float, POSITIVE, Option(help="depth of the section; the length is 1")] = 0.01,
    elements: Annotated[int, AT_LEAST_1, Option(help="elements on the column")] = 12,
    degree: Annotated[int, Choice((1, 2, 3)), Option(help="of the elements: 1 (two nodes) or 2")] = 2,
    to: Annotated[float, POSITIVE, Option(help="load over Euler's at which the path ends")] = 10.0,
    step: Annotated[float, POSITIVE, Option(help="first step of the load, over Euler's")] = 0.5,
) -> Case:
    """Perfect column: the path is straight, and every critical point is a bifurcation."""
    nodes = {"base": (0.0, 0.0), "top": (LENGTH, 0.0)}
    mesh = read(lambda: meshes.frame(nodes, {"column": ("base", "top", elements)}), 2)
    section = Rectangle(1.0, depth)
    beam = Beam(mesh, section, Elastic(12 * LENGTH**2 / (pi**2 * depth**3)), degree=degree)
    return Case(
        scene=Scene(
            parts=[beam],
            supports=[Support(mesh, at, fixed) for at, fixed in zip(nodes, ENDS[ends], strict=True) if fixed],
            loads=[PointForce(mesh, "top", (-1.0, 0.0))], monitor=Monitor(mesh, "top", "x", -1.0)),
        control=LoadControl(step=step, target=to), quantities=quantities,
        axes=("shortening over the length", "load over Euler's"))


def quantities(record: Record) -> dict[str, float]:
    """Loads of the bifurcations over Euler's."""
    return {f"bifurcation_{n}": p.load for n, p in enumerate(record.critical_points, 1)}
