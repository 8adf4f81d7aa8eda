# %% [markdown]
# # The engineer's panel
#
# This demo illustrates the work of an engineer from a geometry in gmsh to a load-shortening curve: a steel plate of
# 1000 x 600 x 4 mm with a hole, two T stiffeners, and a hat on 8 bolts, shortened by 1.5 mm. Units are N and mm.
# What the answers say, and how far they can be trusted, stands on [the panel's page](pages/panel.md).
#
# `docker/run python3 demos/panel.py` does all of it; `docker/run sheetfx run demos/panel.py --size 40` one path.

# %%
import os
import time
from functools import cache
from math import ceil

import gmsh
import numpy as np

import sheetfx as fx

QUICK = bool(os.environ.get("SHEETFX_QUICK"))
LENGTH, WIDTH = 1000.0, 600.0
RIBS, WEB, FLANGE, RIB_THICKNESS = (120.0, 480.0), 40.0, 30.0, 3.0
HOLE, HOLE_AT = 45.0, (500.0, 415.0)
HAT_THICKNESS, HAT_ENDS, HAT_AT = 2.0, (100.0, 900.0), 300.0
HAT_HALF_TOP, HAT_SLOPE, HAT_FOOT, HAT_HEIGHT = 20.0, 15.0, 30.0, 30.0
YOUNG, POISSON = 210e3, 0.3
SIZE = 80.0 if QUICK else 60.0  # of cells, mm
STEEL = fx.Elastic(YOUNG, POISSON)

# %% [markdown]
# ## Geometry
#
# A function makes a model in gmsh; `fx.read` meshes it and reads its named groups. `fragment` makes plate and ribs
# one mesh with common nodes. Where a surface belongs is told from its bounding box.


# %%
def rectangle(*corners):
    """A plane surface between four corners in space."""
    occ = gmsh.model.occ
    points = [occ.addPoint(*corner) for corner in corners]
    sides = [occ.addLine(a, b) for a, b in zip(points, [*points[1:], points[0]], strict=True)]
    return 2, occ.addPlaneSurface([occ.addCurveLoop(sides)])


def name_groups(dimension, name_of):
    """Physical groups of all entities of a dimension, named by a function of the bounding box (None: no group)."""
    groups = {}
    for _, tag in gmsh.model.getEntities(dimension):
        box = np.reshape(gmsh.model.getBoundingBox(dimension, tag), (2, 3))
        if name := name_of(*box):
            groups.setdefault(name, []).append(tag)
    for name, tags in groups.items():
        gmsh.model.addPhysicalGroup(dimension, tags, name=name)


def mesh_by(size, triangles):
    """Cells of a size: triangles as gmsh makes them by default, or quadrilaterals.

    Of these an even number lies along each curve, eight at least around a hole.
    """
    by_quadrilaterals = (("RecombineAll", 1), ("Algorithm", 8), ("RecombinationAlgorithm", 3))
    for option, value in (("MeshSizeMax", size), ("MeshSizeMin", size / 2), *(() if triangles else by_quadrilaterals)):
        gmsh.option.setNumber(f"Mesh.{option}", value)
    if triangles:
        return
    for curve in gmsh.model.getEntities(1):
        least = 1 if gmsh.model.getBoundary([curve]) else 4
        pairs = max(least, ceil(gmsh.model.occ.getMass(*curve) / size / 2))
        gmsh.model.mesh.setTransfiniteCurve(curve[1], 2 * pairs + 1)


def stiffened_plate(size, hole=HOLE, ribs=RIBS, triangles=False):
    """Model of the plate with T stiffeners: groups "plate", "web", "flange", edges and two corners."""

    def surface(low, high):
        return "plate" if high[2] < 1 else "flange" if low[2] > WEB - 1 else "web"

    def edge(low, high):
        of = "plate" if high[2] < 1 else "ribs"
        if high[0] < 1:
            return f"west {of}"
        if low[0] > LENGTH - 1:
            return f"east {of}"
        return "sides" if of == "plate" and (high[1] < 1 or low[1] > WIDTH - 1) else None

    def corner(place, _):
        at = {(0.0, 0.0, 0.0): "south-west", (LENGTH, 0.0, 0.0): "south-east"}
        return at.get(tuple(np.round(place, 3) + 0.0))

    def build():
        occ = gmsh.model.occ
        plate = [(2, occ.addRectangle(0, 0, 0, LENGTH, WIDTH))]
        if hole:
            plate = occ.cut(plate, [(2, occ.addDisk(*HOLE_AT, 0, hole, hole))])[0]
        strips = []
        for y in ribs:
            strips.append(rectangle((0, y, 0), (LENGTH, y, 0), (LENGTH, y, WEB), (0, y, WEB)))
            south, north = y - FLANGE / 2, y + FLANGE / 2
            strips.append(rectangle((0, south, WEB), (LENGTH, south, WEB), (LENGTH, north, WEB), (0, north, WEB)))
        occ.fragment(plate, strips)
        occ.synchronize()
        for dimension, name_of in ((2, surface), (1, edge), (0, corner)):
            name_groups(dimension, name_of)
        mesh_by(size, triangles)

    return build


def hat(size, gap, bolts, triangles=False):
    """Model of the hat: five strips at a distance `gap` of mid-surfaces, groups "feet" and "hat", `bolts` in a row."""
    middle = HAT_HALF_TOP + HAT_SLOPE + HAT_FOOT / 2
    half = [(HAT_HALF_TOP, HAT_HEIGHT), (HAT_HALF_TOP + HAT_SLOPE, 0.0), (HAT_HALF_TOP + HAT_SLOPE + HAT_FOOT, 0.0)]
    outline = [*((-y, z) for y, z in reversed(half)), *half]
    places = [(x, HAT_AT + side * middle, gap)
              for side in (-1, 1) for x in np.linspace(HAT_ENDS[0] + 50, HAT_ENDS[1] - 50, bolts)]

    def surface(_, high):
        return "feet" if high[2] < gap + 1 else "hat"

    def bolt(place, _):
        near = [i for i, at in enumerate(places) if np.allclose(place, at, atol=1e-3)]
        return f"bolt {near[0] + 1}" if near else None

    def build():
        occ = gmsh.model.occ
        for (y0, z0), (y1, z1) in zip(outline[:-1], outline[1:], strict=True):
            a, b = (HAT_AT + y0, gap + z0), (HAT_AT + y1, gap + z1)
            rectangle((HAT_ENDS[0], *a), (HAT_ENDS[1], *a), (HAT_ENDS[1], *b), (HAT_ENDS[0], *b))
        occ.fragment([(2, tag) for _, tag in occ.getEntities(2)], [(0, occ.addPoint(*place)) for place in places])
        occ.synchronize()
        name_groups(2, surface)
        name_groups(0, bolt)
        mesh_by(size, triangles)

    return build


@cache
def meshes(size, gap, bolts, hole=HOLE, ribs=RIBS, triangles=False):
    """The meshes of the stiffened plate and, where there are bolts, of the hat."""
    models = [stiffened_plate(size, hole, ribs, triangles)] + ([hat(size, gap, bolts, triangles)] if bolts else [])
    return tuple(fx.read(model, dimension=3) for model in models)


# %% [markdown]
# ## Parts, bolts, supports
#
# Each group becomes a part with a thickness. All edges of the plate are held across it, the west end along x, the east
# end is pushed along x by one displacement of plate and ribs; two corners keep the panel in place along y. A bolt joins
# a point of the hat's foot to the plate below. Between bolts foot and plate are free, also to pass through each other,
# unless `case(clearance=0.15)` lets them touch where a clearance closes (`python3 -m sheetfx run panel.py --clearance
# 0.15`, three to seven times the CPU time).


# %%
def scene_of(plate, *cap, thickness=4.0, clearance=None):
    """The panel on its supports, shortened by 1 mm for a load factor of 1; feet touch where a clearance closes."""
    parts = [fx.Shell(plate, fx.Plate(t), STEEL, group=group)
             for group, t in (("plate", thickness), ("web", RIB_THICKNESS), ("flange", RIB_THICKNESS))]
    joints = []
    for mesh in cap:
        parts.append(fx.Shell(mesh, fx.Plate(HAT_THICKNESS), STEEL))
        reach = (thickness + HAT_THICKNESS) / 2 + 0.1
        joints += [fx.bolt(mesh, name, (plate, "plate"), reach=reach) for name in mesh.points]
        if clearance is not None:
            joints.append(fx.SurfaceContact(mesh, "feet", (plate, "plate"), adjust=clearance,
                                            distance=(thickness + HAT_THICKNESS) / 2 - clearance))
    supports = [fx.Support(plate, "west plate", "x z"), fx.Support(plate, "west ribs", "x"),
                fx.Support(plate, "east plate", "z"), fx.Support(plate, "sides", "z"),
                fx.Support(plate, "south-west", "y"), fx.Support(plate, "south-east", "y")]
    loads = [fx.PrescribedDisplacement(plate, f"east {of}", "x", -1.0) for of in ("plate", "ribs")]
    return fx.Scene(parts, supports, loads, fx.Monitor(plate, "south-east", "x", -1.0), joints=joints)


def unloaded(scene):
    """A record of the unloaded panel, about which it is asked when it buckles."""
    return fx.trace(fx.Case(scene, fx.LoadControl(1.0), fx.Until(steps=0)))


def answers(record):
    """Largest von Mises stress in the skin, and reactions along x at both ends, of the last state."""
    record.show(record.states[-1])
    skin = record.case.scene.parts[0]
    faces = [record.stresses(skin, side * skin.section.thickness / 2) for side in (-1, 1)]
    mises = fx.von_mises(np.array(faces))
    west, east = (sum(record.reactions(f"{end} {of}").force[-1][0] for of in ("plate", "ribs"))
                  for end in ("west", "east"))
    return {"mises": float(mises.max()), "west": float(west), "east": float(east)}


def case(size: float = 60.0, bolts: int = 4, imperfection: float = 0.4, thickness: float = 4.0,
         to: float = 1.5, triangles: bool = False, clearance: float | None = None) -> fx.Case:
    """Stiffened panel with a bolted hat in end shortening.

    Parameters
    ----------
    size : of cells, mm
    bolts : in each of two rows; 0 is a panel without a hat
    imperfection : amplitude of the first buckling mode, mm, positive towards the ribs; 0 is a perfect panel
    thickness : of the skin, mm
    to : end shortening, mm
    triangles : in the place of quadrilaterals
    clearance : between the feet of the hat and the skin, mm, beyond what an imperfection leaves; default: no contact
    """
    perfect = meshes(size, (thickness + HAT_THICKNESS) / 2, bolts, triangles=triangles)
    scene = scene_of(*perfect, thickness=thickness, clearance=clearance)
    if imperfection:
        record = unloaded(scene_of(*perfect, thickness=thickness))
        mode = record.buckling(count=1)[0]
        scene = scene_of(*(fx.imperfect(mesh, fx.mode_displacement(record.path, mesh, mode), imperfection)
                           for mesh in perfect), thickness=thickness, clearance=clearance)
    return fx.Case(scene, fx.LoadControl(0.1, target=to), quantities=answers,
                   axes=("end shortening (mm)", "load (N)"))


# %% [markdown]
# ## Stiffness and buckling of the bare panel, against closed forms
#
# Without hole and hat the stiffness is $EA/L$ of all that is pushed. A hole of a radius $a$ takes the share
# $3 \pi a^2 / (LB)$ from the stiffness of the plate (a single hole in a large sheet). The bay between the stiffeners
# buckles between the loads of a long plate with simply supported and with clamped sides, $k = 4$ and $6.97$ in
# $k \pi^2 E t^2 / (12 (1 - \nu^2) b^2)$: webs and outer bays resist its rotation.

# %%
if __name__ == "__main__":
    area = 4.0 * WIDTH + len(RIBS) * RIB_THICKNESS * (WEB + FLANGE)
    for hole in (0.0, HOLE):
        record = unloaded(scene_of(*meshes(SIZE, 3.0, 0, hole)))
        modes = record.buckling(count=3)
        stiffness = modes[0].load / modes[0].factor
        exact = YOUNG / LENGTH * (area - 4.0 * 3 * np.pi * hole**2 / LENGTH)
        k = modes[0].load / area * 12 * (1 - POISSON**2) / (np.pi**2 * YOUNG) * (np.diff(RIBS)[0] / 4.0) ** 2
        print(f"hole of {hole:g} mm: {stiffness / 1e3:.1f} kN/mm (closed form {exact / 1e3:.1f}), buckling at",
              *(f"{m.load / 1e3:.1f}" for m in modes), f"kN, k = {k:.2f}")
        assert abs(stiffness / exact - 1) < (5e-3 if hole else 1e-6)
        assert 4 < k < 6.97

# %% [markdown]
# ## The panel with its hat: first modes, and the path to 1.5 mm
#
# The imperfection is the first mode. Load and reactions at both ends are the same force.


# %%
def followed(**options):
    """A record of a path, and its line of a table: load, stress, states, CPU time."""
    begin = time.process_time()
    record = fx.trace(case(**options))
    last, found = record.states[-1], answers(record)
    assert np.allclose([found["west"], -found["east"]], last.load, rtol=1e-6)
    print(f"{last.load / 1e3:7.1f} kN {found['mises']:6.0f} MPa, {len(record.states)} states,",
          f"{time.process_time() - begin:.1f} s,", *[p.title for p in record.critical_points], options, flush=True)
    return record, last.load, found["mises"]


if __name__ == "__main__":
    record = unloaded(scene_of(*meshes(SIZE, 3.0, 4)))
    buckling = record.buckling(count=3)
    print("with the hat: buckling at", *(f"{m.load / 1e3:.1f}" for m in buckling), "kN")
    assert buckling[0].load > modes[0].load, "the hat stiffens the bay"
    record.modes("panel_modes.png")
    record, load, stress = followed(**{"size": SIZE, "bolts": 0, "to": 0.3} if QUICK else {})
    record.curve("panel_curve.png")
    record.view("panel_shape.png", along="z")
    print(f"energy off by {record.balance().off:.1e} of the work")
    assert record.balance().off < 1e-3

# %% [markdown]
# ## What the answers depend on
#
# From 60 to 40 mm the load changes by 0.5 % and the largest stress by 4 %. It lies at the edge of the hole.

# %%
if __name__ == "__main__" and not QUICK:
    _, fine, peak = followed(size=40.0)
    assert abs(fine / load - 1) < 0.01 and abs(peak / stress - 1) < 0.1
    _, bare, _ = followed(bolts=0)
    assert bare < 0.99 * load, "the hat carries more than the mesh error"
    for amplitude in (0.1, 0.8):
        _, other, _ = followed(imperfection=amplitude)
        assert abs(other / load - 1) < 0.01, "far behind buckling the amplitude is within the mesh error"
