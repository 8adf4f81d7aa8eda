"""Half of a hinged arch under a force at its crown: the whole buckles sideways first."""

import sheetfx as fx


def case(cells: int = 20, half_angle: float = 0.128, whole: bool = False) -> fx.Case:
    """Lengths in mm, forces in N."""
    begin, count = (-half_angle, 2 * cells) if whole else (0.0, cells)
    mesh = fx.read(lambda: fx.meshes.arc(3380.6, begin, half_angle, count, {"crown": 0.0}), dimension=2, order=2)
    arch = fx.Beam(mesh, fx.Rectangle(25.4, 4.7625), fx.Elastic(72395.0))
    middle = fx.pin(mesh, "start") if whole else fx.symmetry(mesh, "crown")
    factor = 1 if whole else 2
    scene = fx.Scene([arch], [fx.pin(mesh, "end"), middle], [fx.PointForce(mesh, "crown", (0.0, -1.0 / factor))],
                     fx.Monitor(mesh, "crown", "y", -1.0), symmetry_factor=factor)
    return fx.Case(scene, until=fx.Until(deflection=20.0))
