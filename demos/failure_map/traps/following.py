"""Beams under loads that turn with them: pressure on rings and arches has a potential, the others have none.

Bending stiffness and length (or radius) are 1.
"""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from math import pi

import numpy as np

from sheetfx import meshes
from sheetfx.case import Case
from sheetfx.continuation.control import LoadControl
from sheetfx.mesh.reader import NamedMesh, read
from sheetfx.model.beam import Beam
from sheetfx.model.following import FollowerForce, LinePressure
from sheetfx.model.joints import Spring
from sheetfx.model.loads import LineForce, Moment, PointForce
from sheetfx.model.scene import Monitor, Scene
from sheetfx.model.section import Elastic, Rectangle, round_bar
from sheetfx.model.supports import Support, clamp, pin, symmetry

from .trap import Expected, Trap, bifurcation

DEPTH = 0.003
SECTION, MATERIAL = Rectangle(1.0, DEPTH), Elastic(12 / DEPTH**3)


def half_ring(to: float, step: float, elements: int = 40) -> Case:
    """Half of a ring between two points of symmetry."""
    mesh = read(lambda: meshes.arc(1.0, 0.0, pi, elements, {"side": pi / 2}), 2, 2)
    beam = Beam(mesh, SECTION, MATERIAL)
    return Case(
        Scene([beam], [symmetry(mesh, "start"), symmetry(mesh, "end"), Support(mesh, "side", "y")],
              [LinePressure(beam, -1.0)], Monitor(mesh, "start", "y", -1.0)),
        LoadControl(step=step, target=to))


def whole_ring(to: float, step: float, pressure: bool = True, elements: int = 48) -> Case:
    """Ring under pressure, or under forces that turn with its sections, held against motions of the whole."""
    corners = {"east": (1.0, 0.0), "north": (0.0, 1.0), "west": (-1.0, 0.0), "south": (0.0, -1.0)}
    names = list(corners)
    members = {f"{a}-{b}": (a, b, elements // 4) for a, b in zip(names, [*names[1:], names[0]], strict=True)}

    def place(x):
        angle = pi / 2 * np.abs(x[:, 1]) / (np.abs(x[:, 0]) + np.abs(x[:, 1]))
        return np.column_stack((np.copysign(np.cos(angle), x[:, 0]), np.copysign(np.sin(angle), x[:, 1]), x[:, 2]))

    mesh = read(lambda: meshes.frame(corners, members), 2, 2, place)
    beam = Beam(mesh, SECTION, MATERIAL)
    supports = [Support(mesh, "east", "y"), Support(mesh, "west", "y"), Support(mesh, "north", "x")]
    load = LinePressure(beam, 1.0) if pressure else LineForce(beam, (0.0, 1.0), follower=True)
    return Case(Scene([beam], supports, [load], Monitor(mesh, "east", "x", -1.0)),
                LoadControl(step=step, target=to))


def pressed_arch(ends: str, to: float, step: float, elements: int = 40) -> Case:
    """Semicircular arch under pressure, on hinges or clamped."""
    mesh = read(lambda: meshes.arc(1.0, -pi / 2, pi / 2, elements, {"crown": 0.0}), 2, 2)
    beam, hold = Beam(mesh, SECTION, MATERIAL), {"hinged": pin, "clamped": clamp}[ends]
    return Case(Scene([beam], [hold(mesh, "start"), hold(mesh, "end")],
                      [LinePressure(beam, -1.0)], Monitor(mesh, "crown", "y", -1.0)),
                LoadControl(step=step, target=to))


def straight(elements: int = 24, dimension: int = 2) -> NamedMesh:
    nodes = {"base": (0.0, 0.0), "middle": (0.5, 0.0), "top": (1.0, 0.0)}
    members = {"lower": ("base", "middle", elements // 2), "upper": ("middle", "top", elements // 2)}
    return read(lambda: meshes.frame(nodes, members), dimension)


def hinged_pflueger(to: float, step: float) -> Case:
    """Column on two hinges under axial forces along it that turn with it (Pflueger 1950)."""
    beam = Beam(mesh := straight(), SECTION, MATERIAL)
    return Case(Scene([beam], [pin(mesh, "base"), Support(mesh, "top", "y")],
                      [LineForce(beam, (-1.0, 0.0), follower=True)], Monitor(mesh, "top", "x", -1.0)),
                LoadControl(step=step, target=to))


def partly_following(share: float, to: float, step: float) -> Case:
    """Cantilever with mass under a force at its tip of which a share turns with it (Dzhanelidze 1958)."""
    beam = Beam(mesh := straight(), SECTION, replace(MATERIAL, density=1 / DEPTH))
    loads = [PointForce(mesh, "top", (share - 1, 0.0)), FollowerForce(mesh, "top", (-share, 0.0))]
    return Case(Scene([beam], [clamp(mesh, "base")], loads, Monitor(mesh, "top", "x", -1.0)),
                LoadControl(step=step, target=to))


def twisted_shaft(to: float, step: float) -> Case:
    """Shaft on spherical hinges under moments of fixed axis at its ends, twisted by them (Greenhill 1883)."""
    section = round_bar(DEPTH)
    mesh = straight(dimension=3)
    beam = Beam(mesh, section, Elastic(1 / section.second_moments[0], poisson=0.0))
    return Case(Scene([beam], [pin(mesh, "base"), Support(mesh, "top", "y z")],
                      [Moment(mesh, "base", (-1.0, 0.0, 0.0)), Moment(mesh, "top", (1.0, 0.0, 0.0))],
                      Monitor(mesh, "top", "rx"), joints=[Spring(mesh, "middle", "rx", 1.0)]),
                LoadControl(step=step, target=to))


def _divergence(*loads: float, tolerance: float = 1e-4) -> tuple[Expected, ...]:
    return tuple(bifurcation(load, None, tolerance) for load in loads)


def _double(load: float) -> Expected:
    """Bifurcation with two null vectors of a tangent that is not symmetric, which has no name."""
    return Expected("bifurcation", load, 1e-4, 2)


FOLLOWING = (
    Trap("half-ring",
         "The load turns with the ring; between planes of symmetry it has a potential all the same, and each number of "
         "waves has its load.",
         partial(half_ring, 20.0, 0.7), _divergence(3.0, 8.0, 15.0),
         "p R^3 / EI = n^2 - 1 (Levy 1884)"),
    Trap("whole-ring",
         "All bifurcations are double, so that the determinant keeps its sign throughout.",
         partial(whole_ring, 10.0, 0.7), tuple(bifurcation(p, "multiple", 1e-4) for p in (3.0, 8.0)),
         "p R^3 / EI = n^2 - 1 (Levy 1884)"),
    Trap("whole-ring-turning",
         "Forces that turn with the sections, and do not grow as these move apart, have no potential, and the tangent "
         "is not symmetric; the bifurcations are double as under pressure.",
         partial(whole_ring, 10.0, 0.7, False), tuple(_double(p * 2 * pi) for p in (3.0, 8.0)),
         "the same loads, since the ring hardly stretches"),
    Trap("pressed-arch-hinged",
         "The load turns with the arch and has a potential, since its ends are held; the arch sways at the load of the "
         "ring.",
         partial(pressed_arch, "hinged", 6.0, 0.7), _divergence(3.0),
         "p R^3 / EI = (pi / half-angle)^2 - 1 (Hurlbrink 1908)"),
    Trap("pressed-arch-clamped",
         "As pressed-arch-hinged, with clamped ends.",
         partial(pressed_arch, "clamped", 10.0, 0.7), _divergence(8.0),
         "p R^3 / EI = k^2 - 1 with k tan(half-angle) = tan(k half-angle): 8 (Nicolai 1918)"),
    Trap("pflueger-hinged",
         "The load has no potential and the tangent is not symmetric, yet the column buckles without vibrating.",
         partial(hinged_pflueger, 200.0, 3.0), _divergence(18.95626, 81.88658, 189.22093, tolerance=2e-4),
         "zeros of the Bessel function of order 1/3; Pflueger 1950"),
    Trap("partly-following",
         "A little less than half of the load turns with the tip: the column buckles, becomes stable again, and "
         "flutters while its tangent stays regular.",
         partial(partly_following, 0.49, 30.0, 0.7),
         (*_divergence(8.183108, 11.713999, tolerance=1e-3), Expected("flutter", 16.055016, 1e-3, name="begins")),
         "cos(sqrt(P)) = share / (share - 1) (Dzhanelidze 1958)"),
    Trap("twisted-shaft",
         "Moments about axes that do not turn have no potential in space; the bifurcation is double, and the ends have "
         "turned by more than pi when it comes.",
         partial(twisted_shaft, 8.0, 0.5), (_double(4 * pi),),
         "M L / EI = 2 pi (Greenhill 1883)"),
)
