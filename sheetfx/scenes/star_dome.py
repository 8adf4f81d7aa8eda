"""Star dome of 24 bars under a force at its apex (Hangai and Kawamata 1973).

Six of its seven free nodes stand on a ring: its symmetric path meets limit points, simple and double bifurcations.
The published drawing gives the lengths 25.0 and 43.30, taken here as the radii of the inner ring and of the supports,
and the heights 6.216 and 8.216. Loads are in units of the axial stiffness EA, equal for all bars.
"""

from __future__ import annotations

from math import cos, pi, sin
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

INNER, OUTER = (25.0, 6.216), (43.30, 0.0)
APEX = 8.216


@looked_at
def case(
    ring: Annotated[float, Option(help="force at each node of the inner ring over that at the apex")] = 0.0,
    to: Annotated[float, POSITIVE, Option(help="deflection of the apex at which the path ends")] = 20.0,
    step: Annotated[float, POSITIVE, Option(help="first arc length")] = 0.005,
) -> Case:
    """Star dome: limit points, simple and double bifurcations of the path that keeps all symmetries."""
    nodes, members = dome()
    mesh = read(lambda: meshes.frame(nodes, {name: (*ends, 1) for name, ends in members.items()}), 3)
    loads = [PointForce(mesh, "apex", (0.0, 0.0, -1.0))]
    if ring:
        loads += [PointForce(mesh, f"inner{i}", (0.0, 0.0, -ring)) for i in range(6)]
    return Case(
        scene=Scene(
            parts=[Bar(mesh, Rectangle(1.0, 1.0), Elastic(1.0))],
            supports=[pin(mesh, f"outer{i}") for i in range(6)], loads=loads,
            monitor=Monitor(mesh, "apex", "z", -1.0)),
        control=ArcLength(step=step), until=Until(deflection=to), quantities=quantities,
        axes=("deflection of the apex", "total load / EA"))


def dome() -> tuple[dict[str, tuple[float, float, float]], dict[str, tuple[str, str]]]:
    """Nodes with their coordinates, and members with their ends."""
    nodes, members = {"apex": (0.0, 0.0, APEX)}, {}
    for i in range(6):
        inner, after, outer = f"inner{i}", f"inner{(i + 1) % 6}", f"outer{i}"
        for name, (radius, height), angle in ((inner, INNER, i * pi / 3), (outer, OUTER, (i + 0.5) * pi / 3)):
            nodes[name] = (radius * cos(angle), radius * sin(angle), height)
        members |= {f"spoke{i}": ("apex", inner), f"ring{i}": (inner, after), f"left{i}": (inner, outer),
                    f"right{i}": (after, outer)}
    return nodes, members
