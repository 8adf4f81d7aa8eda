"""Plates whose buckling loads cluster, a layered one, and a column of two plates that meet at a junction.

Loads are given as Bryan's factor k, of pi^2 D / b^2 for the width b = 1 (E h^3 for the layered plate).
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from math import pi

from sheetfx import meshes
from sheetfx.case import Case
from sheetfx.continuation.control import LoadControl
from sheetfx.mesh.reader import NamedMesh, read
from sheetfx.model.joints import Uniform
from sheetfx.model.laminate import Laminate, Ply
from sheetfx.model.loads import EdgeForce
from sheetfx.model.plate import Plate
from sheetfx.model.scene import Monitor, Scene
from sheetfx.model.section import Elastic
from sheetfx.model.shell import Shell
from sheetfx.model.supports import Support
from sheetfx.scenes._benchmark import surface

from .trap import STABLE, Trap, bifurcation

THICKNESS, FORM = 0.001, "naghdi-q3"
DIRECTIONS = {"west": (1.0, 0.0), "east": (-1.0, 0.0), "south": (0.0, 1.0), "north": (0.0, -1.0)}


def _material(loaded_edges: int, poisson: float = 0.3) -> Elastic:
    """Material with which the forces on so many edges of length 1 sum up to k where each is k pi^2 D."""
    rigidity = 1 / (loaded_edges * pi**2)
    return Elastic(12 * (1 - poisson**2) * rigidity / THICKNESS**3, poisson)


def _compressed(mesh: NamedMesh, edges: int) -> list[EdgeForce]:
    forces: Mapping[str, tuple[float, float]] = dict(list(DIRECTIONS.items())[:edges])
    return [EdgeForce(mesh, at, (x / edges, y / edges, 0.0)) for at, (x, y) in forces.items()]


def simply_supported(aspect: float, cells: tuple[int, int], to: float, loaded_edges: int = 2,
                     step: float = 0.5) -> Case:
    """Plate on simple supports, compressed at two or at all four edges."""
    mesh = surface(FORM, cells, lambda x, y: (aspect * x, y, 0.0), {})
    shell = Shell(mesh, Plate(THICKNESS), _material(loaded_edges), form=FORM)
    supports = [Support(mesh, edge, "z rx" if edge in ("west", "east") else "z ry") for edge in DIRECTIONS]
    in_plane = [Support(mesh, "south-west", "x y"), Support(mesh, "south-east", "y")]
    return Case(Scene([shell], [*supports, *in_plane], _compressed(mesh, loaded_edges),
                      Monitor(mesh, "south-east", "x", -1.0)), LoadControl(step=step, target=to))


def angle_ply(aspect: float, cells: tuple[int, int], to: float, step: float = 1.0) -> Case:
    """Plate of two layers at 45 and -45 degrees: stretching twists it, but edges that stay straight keep it flat."""
    mesh = surface(FORM, cells, lambda x, y: (aspect * x, y, 0.0), {})
    across = THICKNESS**-3
    plies = [Ply(THICKNESS / 2, angle, 10 * across, across, 0.25, across / 2) for angle in (45.0, -45.0)]
    shell = Shell(mesh, Laminate(plies), form=FORM, axis=(1.0, 0.0, 0.0))
    supports = [Support(mesh, "west", "x z rx"), Support(mesh, "east", "z rx"), Support(mesh, "south", "y z ry"),
                Support(mesh, "north", "z ry")]
    scene = Scene([shell], supports, [EdgeForce(mesh, "east", (-1.0, 0.0, 0.0))],
                  Monitor(mesh, "south-east", "x", -1.0),
                  joints=[Uniform(mesh, "east", "x"), Uniform(mesh, "north", "y")])
    return Case(scene, LoadControl(step=step, target=to))


def angle_column(length: float, cells: int, to: float, step: float = 0.2) -> Case:
    """Column of two equal legs at right angles, whose ends keep their shape and are free to tilt."""
    nodes = {f"{name} {end}": (*place, z) for end, z in (("foot", 0.0), ("head", length))
             for name, place in (("corner", (0.0, 0.0)), ("one", (1.0, 0.0)), ("other", (0.0, 1.0)))}
    faces = {leg: ("corner foot", f"{leg} foot", f"{leg} head", "corner head") for leg in ("one", "other")}
    mesh = read(lambda: meshes.panels(nodes, faces, cells), 3)
    shell = Shell(mesh, Plate(THICKNESS), _material(4, 0.0), form=FORM)
    ends = {"foot": ("corner foot-one foot", "corner foot-other foot"),
            "head": ("one head-corner head", "other head-corner head")}
    supports = [Support(mesh, edge, "x y rz") for edges in ends.values() for edge in edges]
    loads = [EdgeForce(mesh, edge, (0.0, 0.0, push)) for end, push in (("foot", 0.25), ("head", -0.25))
             for edge in ends[end]]
    return Case(Scene([shell], [*supports, Support(mesh, "corner foot", "z")], loads,
                      Monitor(mesh, "corner head", "z", -1.0)), LoadControl(step=step, target=to))


PLATES = (
    Trap("plate-root-2",
         "One and two half waves buckle at the same load, which a mesh splits by less than a thousandth.",
         partial(simply_supported, 2**0.5, (6, 4), 8.0),
         tuple(bifurcation(k, None, 5e-4) for k in (4.5, 4.5, 6.722222)),
         "Bryan 1891: k = (m / a + a / m)^2", slow=True),
    Trap("plate-long",
         "Five numbers of half waves buckle within 5 % of the load, two of them within 0.2 %.",
         partial(simply_supported, 10.0, (20, 2), 4.25),
         tuple(bifurcation(k, STABLE, 1e-3) for k in (4.0, 4.036446, 4.044568, 4.134444, 4.2025)),
         "Bryan 1891: k = (m / a + a / m)^2", slow=True),
    Trap("plate-all-round",
         "Compressed along both sides, a square plate buckles in two modes at once that symmetry makes equal.",
         partial(simply_supported, 1.0, (4, 4), 9.0, 4),
         (bifurcation(2.0, STABLE), bifurcation(5.0, "multiple"), bifurcation(8.0, STABLE)),
         "Bryan 1891: k = m^2 + n^2", slow=True),
    Trap("angle-ply",
         "Layers at 45 and -45 degrees: stretching is coupled with twisting, which lowers the loads.",
         partial(angle_ply, 1.0, (4, 4), 25.0),
         tuple(bifurcation(load, STABLE, 4e-3) for load in (9.066418, 12.643517, 20.387367)),
         "Jones 1975, chapter 5: antisymmetric angle-ply laminates", slow=True),
    Trap("angle-column",
         "Two plates that meet at a junction: it turns in one family of modes and holds in the other, whose loads "
         "meet within 0.2 %.",
         partial(angle_column, 3.0, 4, 1.7),
         tuple(bifurcation(k, STABLE, 4e-3) for k in (0.698508, 1.000310, 1.532277, 1.535179)),
         "Levy's solution for plates hinged or clamped at one side and free at the other", slow=True),
)
