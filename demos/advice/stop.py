"""Cantilever column beside a rigid wall that stops its sway."""

import sheetfx as fx


def case(cells: int = 16, gap: float = 20.0, sway: float = 0.02, load: float = 12000.0) -> fx.Case:
    """Lengths in mm, forces in N."""
    points, members = {"base": (0, 0), "top": (0, 1000)}, {"column": ("base", "top", cells)}
    mesh = fx.read(lambda: fx.meshes.frame(points, members), dimension=2, order=1)
    column = fx.Beam(mesh, fx.Rectangle(20.0, 20.0), fx.Elastic(210e3))
    wall = fx.RigidPlane((gap + 10.0, 0.0), (-1.0, 0.0))
    scene = fx.Scene([column], [fx.clamp(mesh, "base")], [fx.PointForce(mesh, "top", (sway, -1.0))],
                     fx.Monitor(mesh, "top", "y", -1.0), joints=[fx.ObstacleContact(mesh, "top", wall)])
    return fx.Case(scene, until=fx.Until(load=load))
