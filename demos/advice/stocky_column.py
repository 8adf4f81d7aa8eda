"""Stocky column of steel under an eccentric force."""

import sheetfx as fx


def case(cells: int = 16, length: float = 1500.0, yield_stress: float = 235.0, eccentricity: float = 5.0) -> fx.Case:
    """Lengths in mm, forces in N."""
    points, members = {"base": (0, 0), "top": (0, length)}, {"column": ("base", "top", cells)}
    mesh = fx.read(lambda: fx.meshes.frame(points, members), dimension=2, order=1)
    steel = fx.Plastic(210e3, 0.3, yield_stress=yield_stress, hardening=2100.0)
    column = fx.Beam(mesh, fx.Rectangle(50.0, 50.0), steel)
    loads = [fx.PointForce(mesh, "top", (0.0, -1.0)), fx.Moment(mesh, "top", eccentricity)]
    scene = fx.Scene([column], [fx.pin(mesh, "base"), fx.Support(mesh, "top", "x")], loads,
                     fx.Monitor(mesh, "top", "y", -1.0))
    return fx.Case(scene, until=fx.Until(deflection=length / 20))
