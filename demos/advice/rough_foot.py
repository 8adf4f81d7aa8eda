"""Two struts, of which one stands on a rough floor and against a soft spring."""

import sheetfx as fx


def case(cells: int = 8, friction: float = 0.1, rise: float = 100.0, spring: float = 2000.0) -> fx.Case:
    """Lengths in mm, forces in N."""
    points = {"left": (-500, 0), "top": (0, rise), "right": (500, 0)}
    members = {"one": ("left", "top", cells), "other": ("top", "right", cells)}
    mesh = fx.read(lambda: fx.meshes.frame(points, members), dimension=2, order=1)
    struts = fx.Beam(mesh, fx.Rectangle(20.0, 20.0), fx.Elastic(210e3))
    floor = fx.RigidPlane((0.0, -10.0), (0.0, 1.0))
    joints = [fx.ObstacleContact(mesh, "right", floor, friction=friction), fx.Spring(mesh, "right", "x", spring)]
    scene = fx.Scene([struts], [fx.pin(mesh, "left")], [fx.PointForce(mesh, "top", (0.0, -1.0))],
                     fx.Monitor(mesh, "top", "y", -1.0), joints=joints)
    return fx.Case(scene, until=fx.Until(deflection=1.5 * rise))
