"""Square plate of steel with a bar along its middle, in compression along the bar."""

import gmsh

import sheetfx as fx


def build(cells: int, side: float) -> None:
    """Two rectangles of cells, with the bar between them."""
    geo, half = gmsh.model.geo, max(cells // 2, 1)
    west, east = ([geo.addPoint(x, y * side / 2, 0.0) for y in range(3)] for x in (0.0, side))
    along = [geo.addLine(a, b) for a, b in zip(west, east, strict=True)]
    ends = [[geo.addLine(points[n], points[n + 1]) for n in range(2)] for points in (west, east)]
    plates = []
    for n in range(2):
        loop = geo.addCurveLoop([along[n], ends[1][n], -along[n + 1], -ends[0][n]])
        plates.append(geo.addPlaneSurface([loop]))
    for curves, count in ((along, cells), (ends[0] + ends[1], half)):
        for curve in curves:
            geo.mesh.setTransfiniteCurve(curve, count + 1)
    for plate in plates:
        geo.mesh.setTransfiniteSurface(plate)
        geo.mesh.setRecombine(2, plate)
    geo.synchronize()
    for dimension, tags, name in ((2, plates, "plate"), (1, ends[0], "west"), (1, ends[1], "east"),
                                  (1, [along[1]], "rib"), (1, [along[0], along[2]], "sides"),
                                  (0, [west[0]], "origin"), (0, [east[0]], "corner")):
        gmsh.model.addPhysicalGroup(dimension, tags, name=name)


def case(cells: int = 8, side: float = 400.0, thickness: float = 3.0, depth: float = 12.0,
         yield_stress: float = 235.0) -> fx.Case:
    """Lengths in mm, forces in N."""
    both = fx.read_mixed(lambda: build(cells, side), ["rib"])
    mesh, bar = both.surfaces, both.curves
    steel = fx.Plastic(210e3, 0.3, yield_stress=yield_stress, hardening=1000.0)
    plate = fx.Shell(mesh, fx.Plate(thickness), steel, form="naghdi-q2")
    rib = fx.Beam(bar, fx.Rectangle(thickness, depth), steel)
    supports = [fx.Support(mesh, *held) for held in
                (("west", "x z"), ("east", "z"), ("sides", "z"), ("origin", "y"))]
    scene = fx.Scene([plate, rib], supports, [fx.PrescribedDisplacement(mesh, "east", "x", -1.0)],
                     fx.Monitor(mesh, "corner", "x", -1.0), joints=[fx.Compatible(bar, mesh)])
    return fx.Case(scene, until=fx.Until(deflection=2.0))
