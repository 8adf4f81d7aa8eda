"""Half of a plate twice as long as wide, in compression: the whole buckles in two half waves, the half cannot."""

import sheetfx as fx


def case(cells: int = 4, width: float = 200.0, thickness: float = 2.0, yield_stress: float = 355.0,
         whole: bool = False) -> fx.Case:
    """Lengths in mm, forces in N."""
    factor = 1 if whole else 2
    length = 2 * width / factor
    mesh = fx.read(lambda: fx.meshes.rectangle((2 * cells // factor, cells)), dimension=3, order=3,
                   place=lambda x: x * (length, width, 0.0))
    plate = fx.Shell(mesh, fx.Plate(thickness), fx.Plastic(210e3, 0.3, yield_stress=yield_stress), form="naghdi-q3")
    edges = [fx.Support(mesh, side, "z") for side in ("south", "north", "east")]
    held = [fx.Support(mesh, "west", "z"), fx.Support(mesh, "south-west", "x y"), fx.Support(mesh, "south-east", "y")]
    cut = [fx.symmetry(mesh, "west", "x"), fx.Support(mesh, "south-west", "y")]
    loads = [fx.EdgeForce(mesh, "east", (-1.0, 0.0, 0.0)), fx.EdgeForce(mesh, "west", (1.0, 0.0, 0.0))]
    scene = fx.Scene([plate], edges + (held if whole else cut), loads if whole else loads[:1],
                     fx.Monitor(mesh, "south-east", "x", -1.0), symmetry_factor=factor)
    return fx.Case(scene, until=fx.Until(deflection=1.0))
