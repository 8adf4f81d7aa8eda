"""Von Mises truss: two bars under a force at their apex (von Mises 1923).

A truss that is more than 2.4 times as high as half its span sways sideways before it snaps through: bifurcations lie on
the path that every symmetric solution follows. Loads are in units of the axial stiffness EA.
"""

from __future__ import annotations

from typing import Annotated

from typer import Option

from .. import meshes
from ..case import Case
from ..checks import POSITIVE
from ..continuation.control import ArcLength
from ..mesh.reader import read
from ..model.beam import Bar
from ..model.loads import PointForce
from ..model.scene import Monitor, Scene
from ..model.section import Elastic, Rectangle
from ..model.supports import pin
from ..path import Until
from . import looked_at
from .lee_frame import quantities


@looked_at
def case(
    rise: Annotated[float, POSITIVE, Option(help="height of the apex over half the span")] = 3.0,
    step: Annotated[float, POSITIVE, Option(help="first arc length")] = 0.02,
) -> Case:
    """Two bars: bifurcations and limit points in turn, while the apex is pressed down to its mirror image."""
    nodes = {"left": (-1.0, 0.0), "apex": (0.0, rise), "right": (1.0, 0.0)}
    mesh = read(lambda: meshes.frame(nodes, {"one": ("left", "apex", 1), "other": ("apex", "right", 1)}), 2)
    return Case(
        scene=Scene(
            parts=[Bar(mesh, Rectangle(1.0, 1.0), Elastic(1.0))], supports=[pin(mesh, "left"), pin(mesh, "right")],
            loads=[PointForce(mesh, "apex", (0.0, -1.0))], monitor=Monitor(mesh, "apex", "y", -1.0)),
        control=ArcLength(step=step), until=Until(deflection=2.2 * rise), quantities=quantities,
        axes=("deflection of the apex over half the span", "load / EA"))
