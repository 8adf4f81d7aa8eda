"""Quarter of a ring under pressure from outside."""

from math import pi

import sheetfx as fx


def case(cells: int = 16, radius: float = 100.0, depth: float = 2.0) -> fx.Case:
    """Lengths in mm, forces in N."""
    mesh = fx.read(lambda: fx.meshes.arc(radius, 0.0, pi / 2, cells, {}), dimension=2, order=2)
    ring = fx.Beam(mesh, fx.Rectangle(1.0, depth), fx.Elastic(70e3))
    scene = fx.Scene([ring], [fx.symmetry(mesh, "start", "x"), fx.symmetry(mesh, "end", "y")],
                     [fx.LinePressure(ring, -1.0)], fx.Monitor(mesh, "start", "y", -1.0), symmetry_factor=4)
    return fx.Case(scene, until=fx.Until(deflection=radius / 20))
