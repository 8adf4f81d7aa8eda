"""Shallow sinusoidal arch on hinges under a sinusoidal load (Fung and Kaplan 1952; Timoshenko and Gere 1961).

With rise = 2 i alpha, i the section's radius of gyration, and the crown's height 2 i b, shallow-arch theory gives the
whole load alpha - b + b (alpha^2 - b^2), in units of 4 i EI (pi / span)^3, which are one here. It has an extremum
where 3 b^2 = alpha^2 - 1; the arch sways sideways where b^2 = alpha^2 - 4: before the first extremum if alpha^2 > 5.5,
after it if 4 < alpha^2 < 5.5.
"""

from __future__ import annotations

from math import pi, sqrt
from typing import Annotated

import numpy as np
import ufl
from typer import Option

from .. import meshes
from ..case import Case
from ..checks import AT_LEAST_1, POSITIVE, Choice
from ..continuation.control import ArcLength
from ..mesh.reader import read
from ..model.beam import Beam
from ..model.loads import LineForce
from ..model.scene import Monitor, Scene
from ..model.section import Elastic, Rectangle
from ..model.supports import pin
from ..path import Until
from . import looked_at
from .lee_frame import quantities

SPAN = 100.0


@looked_at
def case(
    alpha: Annotated[float, POSITIVE, Option(help="rise of the crown over twice the radius of gyration")] = 2.8,
    depth: Annotated[float, POSITIVE, Option(help="depth of the section; the span is 100")] = 0.1,
    elements: Annotated[int, AT_LEAST_1, Option(help="elements on the arch, an even number")] = 24,
    degree: Annotated[int, Choice((1, 2, 3)), Option(help="of the elements: 1 (two nodes) or 2")] = 2,
    step: Annotated[float, POSITIVE, Option(help="first arc length over the rise and span")] = 0.02,
) -> Case:
    """Sinusoidal arch: limit points and sideways bifurcations, in an order that depends on the rise."""
    if elements < 2 or elements % 2:
        raise ValueError(f"sinusoidal-arch: elements is {elements}; a node at the crown needs an even number")
    gyration = depth / sqrt(12)
    rise = 2 * gyration * alpha

    def place(x):
        return np.column_stack((x[:, 0], rise * np.sin(pi * x[:, 0] / SPAN), x[:, 2]))

    half = elements // 2
    nodes = {"left": (0.0, 0.0), "crown": (SPAN / 2, 0.0), "right": (SPAN, 0.0)}
    members = {"one": ("left", "crown", half), "other": ("crown", "right", half)}
    mesh = read(lambda: meshes.frame(nodes, members), 2, min(degree, 2), place)
    bending = SPAN**3 / (4 * pi**3 * gyration)
    beam = Beam(mesh, Rectangle(1.0, depth), Elastic(12 * bending / depth**3), degree=degree)
    load = LineForce(beam, lambda x: (0.0, -pi / (2 * SPAN) * ufl.sin(pi * x[0] / SPAN)))
    return Case(
        scene=Scene(
            parts=[beam], supports=[pin(mesh, "left"), pin(mesh, "right")], loads=[load],
            monitor=Monitor(mesh, "crown", "y", -1.0)),
        control=ArcLength(step=step * rise / SPAN), until=Until(deflection=2.2 * rise), quantities=quantities,
        axes=("deflection of the crown", "load / 4 i EI (pi / span)^3"))
