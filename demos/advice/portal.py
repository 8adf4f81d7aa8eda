"""Portal frame of steel under forces on its beam and a smaller one that makes it sway."""

import sheetfx as fx


def case(cells: int = 8, height: float = 4000.0, span: float = 6000.0, yield_stress: float = 235.0,
         sway: float = 0.2) -> fx.Case:
    """Lengths in mm, forces in N."""
    points = {"a": (0, 0), "b": (0, height), "m": (span / 2, height), "c": (span, height), "d": (span, 0)}
    ends = {"left": "ab", "beam": "bm", "rest": "mc", "right": "cd"}
    members = {name: (*pair, cells) for name, pair in ends.items()}
    mesh = fx.read(lambda: fx.meshes.frame(points, members), dimension=2, order=1)
    steel = fx.Plastic(210e3, 0.3, yield_stress=yield_stress)
    frame = fx.Beam(mesh, fx.Rectangle(100.0, 200.0), steel)
    loads = [fx.PointForce(mesh, at, force) for at, force in
             (("b", (sway, -0.5)), ("m", (0.0, -1.0)), ("c", (0.0, -0.5)))]
    scene = fx.Scene([frame], [fx.clamp(mesh, "a"), fx.clamp(mesh, "d")], loads, fx.Monitor(mesh, "b", "x"))
    return fx.Case(scene, until=fx.Until(deflection=span / 6))
