"""Structures with close modes, with a path that changes its mode, and with a path that closes on itself."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from math import pi, sqrt

import numpy as np
import ufl

from sheetfx import meshes
from sheetfx.case import Case
from sheetfx.continuation.control import ArcLength, LoadControl
from sheetfx.mesh.reader import NamedMesh, read
from sheetfx.model.beam import Bar, Beam
from sheetfx.model.joints import Foundation, Spring
from sheetfx.model.loads import LineForce, Moment, PointForce
from sheetfx.model.scene import Monitor, Scene
from sheetfx.model.section import Elastic, Rectangle
from sheetfx.model.supports import Support, pin
from sheetfx.path import Until
from sheetfx.scenes import sinusoidal_arch, von_mises_truss

from .trap import Expected, Trap, and_mirrored, bifurcation, limits

UNIT = Rectangle(1.0, 1.0), Elastic(1.0)


def pyramid(half_span: float, rise: float = 3.0) -> Case:
    """Four bars of axial stiffness 1 under a force at their apex, two of half-span 1 and two of another one."""
    feet = {"west": (-1.0, 0.0), "east": (1.0, 0.0), "south": (0.0, -half_span), "north": (0.0, half_span)}
    nodes = {name: (*foot, 0.0) for name, foot in feet.items()} | {"apex": (0.0, 0.0, rise)}
    mesh = read(lambda: meshes.frame(nodes, {f"{foot} bar": (foot, "apex", 1) for foot in feet}), 3)
    scene = Scene([Bar(mesh, *UNIT)], [pin(mesh, foot) for foot in feet], [PointForce(mesh, "apex", (0.0, 0.0, -1.0))],
                  Monitor(mesh, "apex", "z", -1.0))
    return Case(scene, ArcLength(step=0.02), Until(deflection=2.2 * rise))


def sprung_strut(ratio: float, tilt: float) -> Case:
    """Augusti's column: strut of length 1 on a joint in space, its head on springs of stiffness 1 along x and another.

    Parameters
    ----------
    ratio : stiffness of the spring along y
    tilt : distance of the head from the vertical, along x
    """
    mesh = read(lambda: meshes.frame({"foot": (0.0, 0.0, 0.0), "head": (tilt, 0.0, sqrt(1 - tilt**2))},
                                     {"strut": ("foot", "head", 1)}), 3)
    scene = Scene([Bar(mesh, UNIT[0], Elastic(100.0))], [pin(mesh, "foot")],
                  [PointForce(mesh, "head", (0.0, 0.0, -1.0))], Monitor(mesh, "head", "x"),
                  joints=[Spring(mesh, "head", "x", 1.0), Spring(mesh, "head", "y", ratio)])
    return Case(scene, ArcLength(step=0.01), Until(deflection=0.5))


def founded_strut(linear: float = 3.0, cubic: float = 8e4, imperfection: float = 1e-4, elements: int = 16) -> Case:
    """Slightly bent strut of length 1 on a foundation that stiffens, loaded in units of Euler's load.

    Its pressure is pi^2 (linear w + cubic w^3) in these units.
    """
    nodes = {"base": (0.0, 0.0), "middle": (0.5, 0.0), "top": (1.0, 0.0)}
    members = {"lower": ("base", "middle", elements // 2), "upper": ("middle", "top", elements // 2)}

    def place(x):
        return np.column_stack((x[:, 0], imperfection * np.sin(pi * x[:, 0]), x[:, 2]))

    mesh, depth = read(lambda: meshes.frame(nodes, members), 2, 2, place), 0.005
    beam = Beam(mesh, Rectangle(1.0, depth), Elastic(12 / (pi**2 * depth**3)))
    foundation = Foundation(beam, (0.0, pi**2), lambda u, k: k * (linear * u + cubic * u**3))
    scene = Scene([beam], [pin(mesh, "base"), Support(mesh, "top", "y")], [PointForce(mesh, "top", (-1.0, 0.0))],
                  Monitor(mesh, "middle", "y"), joints=[foundation])
    return Case(scene, LoadControl(step=0.25, target=7.0))


def crank(stiffness: float = 3.0, start: float = 0.5, turns: int = 2) -> Case:
    """Stiff arm of length 1 turned by a moment against springs on its tip, of stiffness 1 along x and another along y.

    The springs are free of force where the arm stands at an angle `start` to the x axis, once in each turn.
    """
    mesh = read(lambda: meshes.frame({"pivot": (0.0, 0.0), "tip": (np.cos(start), np.sin(start))},
                                     {"arm": ("pivot", "tip", 1)}), 2)
    scene = Scene([Beam(mesh, Rectangle(1.0, 1.0), Elastic(1e6))], [pin(mesh, "pivot")], [Moment(mesh, "pivot", 1.0)],
                  Monitor(mesh, "pivot", "rz"),
                  joints=[Spring(mesh, "tip", "x", 1.0), Spring(mesh, "tip", "y", stiffness)])
    return Case(scene, ArcLength(step=0.05), Until(deflection=2 * pi * turns))


def offset_arch(part: float, alpha: float = 2.8) -> Case:
    """Shallow sinusoidal arch whose load has a part of two half waves of opposite signs, which shifts it sideways."""
    case, span = sinusoidal_arch.case(alpha), sinusoidal_arch.SPAN

    def force(x):
        wave = pi * x[0] / span
        return 0.0, -pi / (2 * span) * (ufl.sin(wave) + part * ufl.sin(2 * wave))

    return replace(case, scene=replace(case.scene, loads=[LineForce(case.scene.parts[0], force)]))


def off_centre(shift: float) -> Case:
    """Von Mises truss whose apex stands a little to one side: it follows half a loop between two bifurcations."""
    case = von_mises_truss.case()
    mesh: NamedMesh = case.scene.meshes[0]
    mesh.domain.geometry.x[np.abs(mesh.domain.geometry.x[:, 0]) < 0.5, 0] += shift
    return case


def _pyramid(name: str, half_span: float, first: tuple[Expected, ...], limit: float) -> Trap:
    points = and_mirrored(*first, *limits(limit, tolerance=1e-6))
    return Trap(name, "Two ways to sway, along x and along y, at loads that a step does not tell apart: the "
                "determinant keeps its sign, and eigenvectors of one may be taken for eigenvectors of the other.",
                partial(pyramid, half_span), points,
                "closed form: stiffness of four bars along x, y and z for each height of the apex")


MODES = (
    _pyramid("close-modes-exact", 1.0, (bifurcation(0.2115170600, "multiple", 1e-6),), 1.5689678489),
    _pyramid("close-modes-0.1-percent", 1.00053,
             (bifurcation(0.2115193156, None, 1e-6), bifurcation(0.2117293917, None, 1e-6)), 1.5686437676),
    _pyramid("close-modes-5-percent", 1.0272,
             (bifurcation(0.2116341804, None, 1e-6), bifurcation(0.2225233281, None, 1e-6)), 1.5524878892),
    Trap("augusti-5-percent",
         "A limit point and, 0.03 % of the load before it, a bifurcation into the other mode, which interacts with it.",
         partial(sprung_strut, 0.95, 0.01),
         (bifurcation(0.9216798756, None, 1e-7), *limits(0.9219707346, tolerance=1e-7)),
         "closed form; Augusti 1964, Thompson and Hunt 1973"),
    Trap("augusti-0.1-percent",
         "As augusti-5-percent, with the points within a millionth of the load, and hardly any imperfection: long "
         "steps cross to the path on the other side of the bifurcation of the perfect column.",
         partial(sprung_strut, 0.999, 3e-5),
         (bifurcation(0.9886645589, None, 1e-8), *limits(0.9886654609, tolerance=1e-8)),
         "closed form"),
    Trap("augusti-exact",
         "The other mode comes close to instability and stays stable: only the limit point is there.",
         partial(sprung_strut, 1.0, 1e-3), limits(0.9752847156, tolerance=1e-7), "closed form"),
    Trap("mode-jump",
         "The strut has buckled in one half wave, smoothly, before it loses stability to two: loads do not show it.",
         founded_strut, (bifurcation(5.65226, None, 5e-4),),
         "Galerkin's method with eight half waves; Everall and Hunt 2000"),
    Trap("closed-path",
         "The path is closed: each turn of the arm leads through the same states, and the monitored angle goes on.",
         crank, limits(*2 * (0.9780450326, 0.6041232828, 1.7004308595, -2.6514959357), tolerance=1e-5),
         "closed form: moment of two springs on a circle"),
    Trap("half-loop",
         "The path follows half of the loop that joins two bifurcations of the perfect truss; the other is an isola.",
         partial(off_centre, 1e-3), limits(0.2457432775, -0.2457432775, tolerance=1e-7),
         "an independent truss, tests/truss.py"),
    Trap("offset-load",
         "The load, shifted to one side, breaks the bifurcations; the path passes near them in tight loops, with a "
         "deflection that moves back and a load below zero.",
         partial(offset_arch, 0.02), limits(8.3064902, -4.0844142, 9.6796451, -2.8947939, tolerance=1e-4),
         "closed form: shallow arch with two waves, after Fung and Kaplan 1952"),
)
