"""Bend of 45 degrees loaded out of its plane (Bathe and Bolourchi 1979).

The converged tip (15.558, 46.892, 53.61) belongs to Saint-Venant's torsion constant of the unit
square, 0.1406; some authors take the polar moment 1/6, which moves the tip by 0.3.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import pi
from typing import Annotated

import numpy as np
from typer import Option

from .. import meshes
from ..case import Case
from ..checks import AT_LEAST_1, NONZERO, Choice
from ..continuation.control import LoadControl
from ..mesh.reader import read
from ..model.beam import Beam
from ..model.loads import PointForce
from ..model.scene import Monitor, Scene
from ..model.section import Elastic, Rectangle
from ..model.supports import clamp
from ..record import Record
from . import looked_at

RADIUS = 100.0


@dataclass(frozen=True)
class PolarSection(Rectangle):
    """Rectangle twisted with its polar second moment of area, as some authors take it."""

    @property
    def torsion(self):
        return sum(self.second_moments)


@looked_at
def case(
    elements: Annotated[int, AT_LEAST_1, Option(help="elements on the bend")] = 32,
    degree: Annotated[int, Choice((1, 2, 3)), Option(help="of the elements: 1 (two nodes) or 2")] = 2,
    force: Annotated[float, NONZERO, Option(help="tip force out of the plane")] = 600.0,
    steps: Annotated[int, AT_LEAST_1, Option(help="load steps")] = 6,
    plain_tangent: Annotated[bool, Option("--plain-tangent", help="Newton's tangent without mixed points")] = False,
    polar: Annotated[bool, Option("--polar", help="polar moment 1/6 as torsion constant, not Saint-Venant's")] = False,
) -> Case:
    """Bathe and Bolourchi's bend: bending, twist and large rotations in space."""
    mesh = read(lambda: meshes.arc(RADIUS, -pi / 2, -pi / 4, elements), 3, min(degree, 2))
    section = (PolarSection if polar else Rectangle)(1.0, 1.0)
    beam = Beam(mesh, section, Elastic(1e7, 0.0), degree=degree, up=(0.0, 0.0, 1.0))
    return Case(
        scene=Scene(
            parts=[beam], supports=[clamp(mesh, "start")], loads=[PointForce(mesh, "end", (0.0, 0.0, force))],
            monitor=Monitor(mesh, "end", "z")),
        control=LoadControl(step=1 / steps, fixed=True), quantities=quantities,
        axes=("displacement of the tip out of the plane", "force"), mixed_points=not plain_tangent)


def quantities(record: Record) -> dict[str, float]:
    """Place of the tip with the clamp at the origin, and the iterations of the steps."""
    record.show(record.states[-1])
    displacement = record.displacement("end")
    tip = RADIUS * np.array([1 - np.cos(pi / 4), np.sin(pi / 4), 0.0]) + displacement
    iterations = [s.iterations for s in record.states[1:]]
    return dict(zip(("tip_x", "tip_y", "tip_z"), tip.tolist(), strict=True)) | {
        "most_iterations": max(iterations), "iterations": sum(iterations)}
