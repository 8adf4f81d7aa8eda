"""Forty structures beside the traps: columns, frames, arches, links, trusses, beams in space and shells, with sources.

Each is a case and what is known of it: loads of its first critical points by a closed form or a publication.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import cos, pi, radians, sin, sqrt, tan

import numpy as np
import ufl
from scipy.optimize import brentq

import sheetfx as fx
from sheetfx.scenes._benchmark import cylinder, surface

DEEP = 0.01
BENDS = fx.Elastic(12 / DEEP**3, 0.0)  # with a section of 1 x DEEP: EI = 1
THIN = 0.001
FORM = "naghdi-q3"


@dataclass(frozen=True)
class Structure:
    """A structure that has not been tried before.

    Attributes
    ----------
    case : makes its path
    loads : of its first critical points that are known, in the order of the path
    source : of the loads; "": nobody's, they are compared with those of short steps alone
    error : relative, of the mesh, of shear and of the source
    """

    case: Callable[[], fx.Case]
    loads: tuple[float, ...] = ()
    source: str = ""
    error: float = 2e-3


def plane(nodes, members, order=1, releases=()):
    return fx.read(lambda: fx.meshes.frame(nodes, members, releases), 2, order)


def slender(mesh, **how):
    return fx.Beam(mesh, fx.Rectangle(1.0, DEEP), BENDS, **how)


def column(ends, *joints, until, cells=12, size=1.0, middle=None):
    """A column of EI = 1 and length 1 along x that a force presses; components held at its ends and its middle."""
    mesh = plane({"a": (0, 0), "m": (0.5, 0), "b": (1, 0)}, {"l": ("a", "m", cells // 2), "r": ("m", "b", cells // 2)})
    beam = slender(mesh)
    supports = [fx.Support(mesh, at, held) for at, held in zip("ab", ends, strict=True) if held]
    supports += [fx.Support(mesh, "m", middle)] if middle else []
    scene = fx.Scene([beam], supports, [fx.PointForce(mesh, "b", (-size, 0.0))], fx.Monitor(mesh, "b", "x", -1.0),
                     joints=[joint(mesh, beam) for joint in joints])
    return fx.Case(scene, until=fx.Until(load=until))


def stepped():
    """A pinned column of half the length with four times the stiffness."""
    mesh = plane({"a": (0, 0), "m": (0.5, 0), "b": (1, 0)}, {"l": ("a", "m", 6), "r": ("m", "b", 6)})
    beams = [fx.Beam(mesh, fx.Rectangle(width, DEEP), BENDS, group=group) for group, width in (("l", 4.0), ("r", 1.0))]
    scene = fx.Scene(beams, [fx.pin(mesh, "a"), fx.Support(mesh, "b", "y")], [fx.PointForce(mesh, "b", (-1.0, 0.0))],
                     fx.Monitor(mesh, "b", "x", -1.0))
    return fx.Case(scene, until=fx.Until(load=80.0))


def heavy_column():
    """A cantilever under its weight."""
    mesh = plane({"a": (0, 0), "b": (0, 1)}, {"s": ("a", "b", 12)})
    beam = slender(mesh)
    scene = fx.Scene([beam], [fx.clamp(mesh, "a")], [fx.LineForce(beam, (0.0, -1.0))], fx.Monitor(mesh, "b", "y", -1.0))
    return fx.Case(scene, until=fx.Until(load=60.0))


def portal(foot, until, storeys=1):
    """Frames of equal members, a force on each column."""
    nodes = {f"{side}{level}": (x, float(level)) for side, x in (("l", 0.0), ("r", 1.0))
             for level in range(storeys + 1)}
    members = {f"c{side}{level}": (f"{side}{level}", f"{side}{level + 1}", 8) for side in "lr"
               for level in range(storeys)}
    members |= {f"b{level}": (f"l{level}", f"r{level}", 8) for level in range(1, storeys + 1)}
    mesh = plane(nodes, members)
    scene = fx.Scene([slender(mesh)], [fx.Support(mesh, f"{side}0", foot) for side in "lr"],
                     [fx.PointForce(mesh, f"{side}{storeys}", (0.0, -0.5)) for side in "lr"],
                     fx.Monitor(mesh, f"l{storeys}", "y", -1.0))
    return fx.Case(scene, until=fx.Until(load=until))


def portal_loads(clamped):
    """Sway and symmetric mode: stiffness of a column's end against turning, by stability functions."""
    def symmetric(k):
        near = k * (k * cos(k) - sin(k)) / (2 * cos(k) - 2 + k * sin(k)) if clamped else k**2 * tan(k) / (tan(k) - k)
        return near + 2

    sway = brentq(lambda k: k / tan(k) + 6, 2.0, 3.1) if clamped else brentq(lambda k: k * tan(k) - 6, 0.5, 1.5)
    second = brentq(symmetric, 4.6, 6.2) if clamped else brentq(symmetric, 3.2, 4.4)
    return 2 * sway**2, 2 * second**2


def gable():
    """A gable frame with a force at its ridge."""
    mesh = plane({"a": (0, 0), "b": (0, 1), "c": (1, 1.4), "d": (2, 1), "e": (2, 0)},
                 {f"{i}{j}": (i, j, 4) for i, j in ("ab", "bc", "cd", "de")})
    scene = fx.Scene([slender(mesh)], [fx.pin(mesh, "a"), fx.pin(mesh, "e")], [fx.PointForce(mesh, "c", (0.0, -1.0))],
                     fx.Monitor(mesh, "c", "y", -1.0))
    return fx.Case(scene, until=fx.Until(deflection=0.6))


def williams():
    """Two rigidly joined rods at a small slope (Williams 1964)."""
    mesh = plane({"a": (-12.943, 0), "t": (0, 0.386), "b": (12.943, 0)}, {"l": ("a", "t", 6), "r": ("t", "b", 6)})
    beam = fx.Beam(mesh, fx.Rectangle(0.753, 0.243), fx.Elastic(1.03e7, 0.3))
    scene = fx.Scene([beam], [fx.clamp(mesh, "a"), fx.clamp(mesh, "b")], [fx.PointForce(mesh, "t", (0.0, -1.0))],
                     fx.Monitor(mesh, "t", "y", -1.0))
    return fx.Case(scene, until=fx.Until(deflection=0.8))


def battened():
    """A column of two chords with battens."""
    nodes = {f"{side}{i}": (float(i), y) for side, y in (("l", 0.0), ("r", 0.4)) for i in range(7)}
    members = {f"{side}{i}{i + 1}": (f"{side}{i}", f"{side}{i + 1}", 2) for side in "lr" for i in range(6)}
    mesh = plane(nodes, members | {f"b{i}": (f"l{i}", f"r{i}", 2) for i in range(7)})
    scene = fx.Scene([slender(mesh)], [fx.pin(mesh, "l0"), fx.pin(mesh, "r0"),
                                       *(fx.Support(mesh, f"{side}6", "y") for side in "lr")],
                     [fx.PointForce(mesh, f"{side}6", (-0.5, 0.0)) for side in "lr"], fx.Monitor(mesh, "l6", "x", -1.0))
    return fx.Case(scene, until=fx.Until(load=16.0))


def parabolic(rise, kind, until, cells=24):
    """A parabolic arch of span 1 and EI = 1 under a force that is uniform along its span."""
    x = np.linspace(0, 1, cells + 1)
    nodes = {f"n{i}": (float(s), float(4 * rise * s * (1 - s))) for i, s in enumerate(x)}
    crown = f"n{cells // 2}"
    releases = [(f"b{cells // 2}", crown)] if kind == "three" else []
    mesh = plane(nodes, {f"b{i}": (f"n{i}", f"n{i + 1}", 1) for i in range(cells)}, releases=releases)
    beam = slender(mesh)
    hold = fx.clamp if kind == "clamped" else fx.pin
    joints = [fx.hinge(mesh, f"{crown} of b{cells // 2}", (mesh, crown))] if releases else []
    weight = fx.LineForce(beam, lambda x: (0.0, -1 / ufl.sqrt(1 + (4 * rise * (1 - 2 * x[0])) ** 2)))
    scene = fx.Scene([beam], [hold(mesh, "n0"), hold(mesh, f"n{cells}")], [weight], fx.Monitor(mesh, crown, "y", -1.0),
                     joints=joints)
    return fx.Case(scene, until=fx.Until(load=until, deflection=0.3))


def pressed_arch(half_angle, until):
    """A hinged circular arch of radius 1 and EI = 1 under pressure."""
    mesh = fx.read(lambda: fx.meshes.arc(1.0, -half_angle, half_angle, 24, {"left": -half_angle, "crown": 0.0,
                                                                           "right": half_angle}), 2, 2)
    beam = slender(mesh)
    pressure = fx.LinePressure(beam, 1.0, side="positive")
    scene = fx.Scene([beam], [fx.pin(mesh, "left"), fx.pin(mesh, "right")], [pressure],
                     fx.Monitor(mesh, "crown", "y", -1.0))
    return fx.Case(scene, until=fx.Until(load=until, deflection=0.5))


def rigid_column(*springs, until):
    """A rigid column of length 1 on a hinge; springs as a function of the mesh."""
    mesh = plane({"a": (0, 0), "b": (0, 1)}, {"s": ("a", "b", 1)})
    beam = fx.Beam(mesh, fx.Rectangle(1.0, 1.0), fx.Elastic(1e7, 0.0))
    scene = fx.Scene([beam], [fx.pin(mesh, "a")], [fx.PointForce(mesh, "b", (0.0, -1.0))], fx.Monitor(mesh, "b", "x"),
                     joints=[spring(mesh) for spring in springs])
    return fx.Case(scene, until=fx.Until(load=until, deflection=0.5))


def guyed():
    """A rigid link that a bar at 45 degrees holds."""
    mesh = plane({"a": (0, 0), "b": (0, 1), "c": (1, 0)}, {"link": ("a", "b", 1), "guy": ("b", "c", 1)})
    link, guy = (fx.Bar(mesh, fx.Rectangle(1.0, 1.0), fx.Elastic(e), group=group)
                 for group, e in (("link", 1e4), ("guy", 2**0.5)))
    scene = fx.Scene([link, guy], [fx.pin(mesh, "a"), fx.pin(mesh, "c")], [fx.PointForce(mesh, "b", (0.0, -1.0))],
                     fx.Monitor(mesh, "b", "x"))
    return fx.Case(scene, until=fx.Until(load=0.9, deflection=0.3))


def links(count, ends, until):
    """Rigid links of length 1 with rotational springs between them (Hencky 1920), pinned or clamped and free."""
    nodes = {f"n{i}": (float(i), 0.0) for i in range(count + 1)}
    members = {f"b{i}": (f"n{i}", f"n{i + 1}", 1) for i in range(count)}
    releases = [(f"b{i}", f"n{i}") for i in range(1, count)]
    mesh = plane(nodes, members, releases=releases)
    beam = fx.Beam(mesh, fx.Rectangle(1.0, 1.0), fx.Elastic(1e7, 0.0))
    joints = [fx.hinge(mesh, f"n{i} of b{i}", (mesh, f"n{i}")) for i in range(1, count)]
    joints += [fx.Spring(mesh, f"n{i} of b{i}", "rz", 1.0, to=(mesh, f"n{i}")) for i in range(1, count)]
    if ends == "free":
        joints.append(fx.Spring(mesh, "n0", "rz", 1.0))
    supports = [fx.pin(mesh, "n0"), *([fx.Support(mesh, f"n{count}", "y")] if ends == "pinned" else [])]
    scene = fx.Scene([beam], supports, [fx.PointForce(mesh, f"n{count}", (-1.0, 0.0))],
                     fx.Monitor(mesh, f"n{count}", "x", -1.0), joints=joints)
    return fx.Case(scene, until=fx.Until(load=until))


def bars(nodes, members, top, supports, deflection, dimension=2, spring=None, step=None, axis=None):
    """A truss of bars of EA = 1 under a force downwards."""
    mesh = fx.read(lambda: fx.meshes.frame(nodes, {f"{i}-{j}": (i, j, 1) for i, j in members}), dimension)
    axis = axis or "xyz"[dimension - 1]
    down = tuple(-1.0 if c == axis else 0.0 for c in "xyz"[:dimension])
    bar = fx.Bar(mesh, fx.Rectangle(1.0, 1.0), fx.Elastic(1.0))
    scene = fx.Scene([bar], [fx.Support(mesh, at, held) for at, held in supports.items()],
                     [fx.PointForce(mesh, top, down)], fx.Monitor(mesh, top, axis, -1.0),
                     joints=[spring(mesh)] if spring else [])
    return fx.Case(scene, fx.ArcLength(step), fx.Until(deflection=deflection))


def pyramid(feet, rise, turn=0.0):
    """Bars from a regular polygon of feet to an apex."""
    nodes = {f"f{i}": (cos(2 * pi * i / feet + turn), sin(2 * pi * i / feet + turn), 0.0) for i in range(feet)}
    return bars(nodes | {"top": (0.0, 0.0, rise)}, [(f"f{i}", "top") for i in range(feet)], "top",
                {f"f{i}": "x y z" for i in range(feet)}, 2.2 * rise, 3)


def stacked():
    """Two toggles, one above the other."""
    nodes = {"a": (-1, 0), "b": (1, 0), "m": (0, 0.3), "t": (0, 0.7), "c": (-1, 0.4), "d": (1, 0.4)}
    return bars(nodes, ["am", "bm", "ct", "dt", "mt"], "t",
                {"a": "x y", "b": "x y", "c": "x y", "d": "x y", "m": "x", "t": "x"}, 1.0)


def uneven():
    """A toggle of bars of unequal length."""
    return bars({"a": (-1, 0), "b": (1.5, 0), "t": (0, 0.5)}, ["at", "bt"], "t", {"a": "x y", "b": "x y"}, 1.1)


def toggle_on_spring():
    """A toggle that a soft bar presses: it snaps back."""
    return bars({"a": (-1, 0), "b": (1, 0), "t": (0, 0.3), "p": (0, 60.0)}, ["at", "bt", "tp"], "p",
                {"a": "x y", "b": "x y", "t": "x", "p": "x"}, 1.0)


def truss_arch(panels=10):
    """A shallow arch of two chords."""
    half = radians(25.0)
    places = np.linspace(-half, half, panels + 1)
    nodes = {f"{chord}{i}": (radius * sin(t), radius * cos(t)) for chord, radius in (("o", 10.3), ("i", 10.0))
             for i, t in enumerate(places)}
    members = [(f"{c}{i}", f"{c}{i + 1}") for c in "oi" for i in range(panels)]
    members += [(f"o{i}", f"i{i}") for i in range(panels + 1)]
    members += [(f"o{i}", f"i{i + 1}") if i < panels // 2 else (f"i{i}", f"o{i + 1}") for i in range(panels)]
    return bars(nodes, members, f"o{panels // 2}", {"i0": "x y", f"i{panels}": "x y"}, 1.6)


def ribbed_dome(rings=2, around=8):
    """A ribbed dome with diagonals one way (Schwedler 1863)."""
    angles, radius = np.linspace(0, radians(30.0), rings + 2)[1:], 10.0
    nodes = {"top": (0.0, 0.0, radius)}
    for r, a in enumerate(angles):
        nodes |= {f"r{r}n{k}": (radius * sin(a) * cos(2 * pi * k / around), radius * sin(a) * sin(2 * pi * k / around),
                                radius * cos(a)) for k in range(around)}
    members = [("top", f"r0n{k}") for k in range(around)]
    for r in range(rings + 1):
        if r < rings:
            members += [(f"r{r}n{k}", f"r{r}n{(k + 1) % around}") for k in range(around)]
        if r:
            members += [(f"r{r - 1}n{k}", f"r{r}n{k}") for k in range(around)]
            members += [(f"r{r - 1}n{k}", f"r{r}n{(k + 1) % around}") for k in range(around)]
    return bars(nodes, members, "top", {f"r{rings}n{k}": "x y z" for k in range(around)}, 0.8, 3)


def space(nodes, members, order=1):
    return fx.read(lambda: fx.meshes.frame(nodes, members), 3, order)




def angle_frame():
    """A right-angled frame of thin strips with a force in its plane at its end (Argyris 1979)."""
    mesh = space({"a": (0, 0, 0), "k": (240, 0, 0), "b": (240, -240, 0)}, {"s": ("a", "k", 8), "t": ("k", "b", 8)})
    beams = [fx.Beam(mesh, fx.Rectangle(0.6, 30.0), fx.Elastic(71240.0, 0.31), group=group, up=up)
             for group, up in (("s", (0.0, 1.0, 0.0)), ("t", (1.0, 0.0, 0.0)))]
    scene = fx.Scene(beams, [fx.clamp(mesh, "a")], [fx.PointForce(mesh, "b", (1.0, 0.0, 0.0))],
                     fx.Monitor(mesh, "b", "x"))
    return fx.Case(scene, until=fx.Until(load=3.0))


def bent_strip():
    """A narrow strip on forked ends under end moments."""
    mesh = space({"a": (0, 0, 0), "m": (50, 0, 0), "b": (100, 0, 0)}, {"l": ("a", "m", 6), "r": ("m", "b", 6)})
    beam = fx.Beam(mesh, fx.Rectangle(0.1, 2.0), fx.Elastic(2e5, 0.25))
    scene = fx.Scene([beam], [fx.Support(mesh, "a", "x y z rx"), fx.Support(mesh, "b", "y z rx")],
                     [fx.Moment(mesh, "a", (0.0, 1.0, 0.0)), fx.Moment(mesh, "b", (0.0, -1.0, 0.0))],
                     fx.Monitor(mesh, "b", "ry", -1.0))
    return fx.Case(scene, until=fx.Until(load=9.0))


def strip_moment():
    """Sum of both end moments at which it turns over, with the bending before (Trahair 1993)."""
    weak, strong = 2e5 * 2 * 0.1**3 / 12, 2e5 * 0.1 * 2**3 / 12
    turning = 8e4 * 2 * 0.1**3 / 3 * (1 - 0.63 * 0.1 / 2)
    return 2 * pi / 100 * sqrt(weak * turning / ((1 - weak / strong) * (1 - turning / strong)))


def pressed_strip():
    """A cantilever of equal stiffness both ways under a force at its tip: both directions buckle together."""
    mesh = space({"a": (0, 0, 0), "b": (0, 0, 1)}, {"s": ("a", "b", 8)})
    beam = fx.Beam(mesh, fx.Rectangle(0.01, 0.01), fx.Elastic(12e8, 0.0), up=(1.0, 0.0, 0.0))
    scene = fx.Scene([beam], [fx.clamp(mesh, "a")], [fx.PointForce(mesh, "b", (0.0, 0.0, -1.0))],
                     fx.Monitor(mesh, "b", "z", -1.0))
    return fx.Case(scene, until=fx.Until(load=25.0))


def twisted_ring():
    """A ring, cut open and hinged there, that is turned by one end about its diameter (Goto, Watanabe et al. 1992)."""
    radius, number = 20.0, 24
    nodes = {f"n{i}": (radius * cos(2 * pi * i / number), radius * sin(2 * pi * i / number), 0.0)
             for i in range(number)}
    mesh = space(nodes, {f"b{i}": (f"n{i}", f"n{(i + 1) % number}", 1) for i in range(number)})
    beam = fx.Beam(mesh, fx.Rectangle(1 / 3, 1.0), fx.Elastic(21000.0, 0.3), up=(0.0, 0.0, 1.0))
    opposite = f"n{number // 2}"
    scene = fx.Scene([beam], [fx.Support(mesh, opposite, "x y z rx ry rz"), fx.Support(mesh, "n0", "y z ry rz")],
                     [fx.Moment(mesh, "n0", (1.0, 0.0, 0.0))], fx.Monitor(mesh, "n0", "rx"))
    return fx.Case(scene, until=fx.Until(deflection=3.0))


def plate(loads, held, until, cells=6, foundation=0.0, aspect=1.0, step=None):
    """A square plate of width 1 whose load factor is Bryan's k."""
    mesh = surface(FORM, (round(cells * aspect), cells), lambda x, y: (aspect * x, y, 0.0), {})
    rigid = 1 / (len(loads) * pi**2)
    shell = fx.Shell(mesh, fx.Plate(THIN), fx.Elastic(12 * 0.91 * rigid / THIN**3, 0.3), form=FORM)
    supports = [fx.Support(mesh, edge, held(edge)) for edge in ("west", "east", "south", "north")]
    supports += [fx.Support(mesh, "south-west", "x y"), fx.Support(mesh, "south-east", "y")]
    forces = [fx.EdgeForce(mesh, edge, tuple(c / len(loads) for c in force)) for edge, force in loads.items()]
    scene = fx.Scene([shell], supports, forces,
                     fx.Monitor(mesh, "north-east", "x", 1.0),
                     joints=[fx.Foundation(shell, (0.0, 0.0, foundation * rigid))] if foundation else [])
    return fx.Case(scene, fx.LoadControl(step or until / 8, target=until))


def simple(edge):
    return "z rx" if edge in ("west", "east") else "z ry"


SHEAR = {"north": (1.0, 0, 0), "south": (-1.0, 0, 0), "east": (0, 1.0, 0), "west": (0, -1.0, 0)}
PUSH = {"west": (1.0, 0, 0), "east": (-1.0, 0, 0)}


def whole_roof(thickness, to):
    """The whole hinged roof, free to leave its symmetry (Sabir and Lock 1972)."""
    nodes = {f"n{i}{j}": (i / 2, j / 2, 0.0) for i in range(3) for j in range(3)}
    faces = {f"f{i}{j}": (f"n{i}{j}", f"n{i + 1}{j}", f"n{i + 1}{j + 1}", f"n{i}{j + 1}")
             for i in (0, 1) for j in (0, 1)}
    mesh = fx.read(lambda: fx.meshes.panels(nodes, faces, 3, triangles=False), 3, 3, lambda x: np.column_stack(
        (508 * (x[:, 0] - 0.5), 2540 * np.sin(0.2 * x[:, 1] - 0.1), 2540 * np.cos(0.2 * x[:, 1] - 0.1))))
    shell = fx.Shell(mesh, fx.Plate(thickness), fx.Elastic(3102.75, 0.3), form="naghdi-q3")
    sides = "n00-n10", "n10-n20", "n12-n02", "n22-n12"
    scene = fx.Scene([shell], [fx.Support(mesh, side, "x y z") for side in sides],
                     [fx.PointForce(mesh, "n11", (0.0, 0.0, -1.0))], fx.Monitor(mesh, "n11", "z", -1.0))
    return fx.Case(scene, until=fx.Until(deflection=to))


def tape_spring(sense, to):
    """A tape spring that is bent at its ends, in the sense of its curvature or against it (Seffen, Pellegrino 1999)."""
    radius, angle, length = 13.3, 0.85, 200.0
    mesh = cylinder("naghdi-q2", (10, 6), radius, length / 2, angle, {"mid": (0, 0), "end": (1, 0)})
    shell = fx.Shell(mesh, fx.Plate(0.1), fx.Elastic(131e3, 0.3), form="naghdi-q2")
    supports = [fx.symmetry(mesh, "west", "x"), fx.symmetry(mesh, "south", "y"), fx.Support(mesh, "mid", "z")]
    scene = fx.Scene([shell], supports, [fx.PrescribedRotation(mesh, "east", (0.0, sense * 0.3, 0.0))],
                     fx.Monitor(mesh, "end", "ry", sense))
    return fx.Case(scene, until=fx.Until(deflection=to))


def _column_on_spring(k):
    """Symmetric mode of a pinned column on a spring at its middle (Timoshenko and Gere 1961, section 2.6)."""
    return brentq(lambda u: k * (1 - tan(u) / u) - 16 * u**2, pi / 2 + 1e-9, 3 * pi / 2 - 1e-9)


ARCHES = ("phi'' + N phi + V cos = 0 of the inextensible arch whose load moves with it, by shooting; "
          "Dinnik's 28.5, 45.4, 46.5, 101 and 115 are of a load that stays uniform along the span")
STRUCTURES = {
    "clamped-pinned": Structure(lambda: column(("x y rz", "y"), until=130.0), (20.190729, 59.679516, 118.89987),
                                "Euler: tan k = k"),
    "clamped-guided": Structure(lambda: column(("x y rz", "rz"), until=95.0), (pi**2, 4 * pi**2, 9 * pi**2), "Euler"),
    "clamped-free": Structure(lambda: column(("x y rz", ""), until=65.0), (pi**2 / 4, 9 * pi**2 / 4, 25 * pi**2 / 4),
                              "Euler"),
    "two-spans": Structure(lambda: column(("x y", "y"), middle="y", until=90.0), (4 * pi**2, 80.762916),
                           "Euler: one half wave a span; both spans clamped at the prop"),
    "column-on-spring": Structure(
        lambda: column(("x y", "y"), lambda m, b: fx.Spring(m, "m", "y", 100.0), until=60.0),
        (4 * _column_on_spring(100.0) ** 2, 4 * pi**2), "Timoshenko and Gere 1961, section 2.6"),
    "column-on-foundation": Structure(
        lambda: column(("x y", "y"), lambda m, b: fx.Foundation(b, (0.0, 1000.0)), until=115.0, cells=16),
        tuple(sorted(m**2 * pi**2 + 1000 / (m**2 * pi**2) for m in (1, 2, 3))), "Hetenyi 1946"),
    "stepped-column": Structure(stepped, tuple(
        brentq(lambda k: k / 2 / tan(k / 4) + k / tan(k / 2), *ends) ** 2 for ends in ((3.2, 6.2), (6.5, 12.5))),
        "Timoshenko and Gere 1961, section 2.14: two pieces"),
    "heavy-column": Structure(heavy_column, (7.837347, 55.977), "Greenhill 1881"),
    "portal-pinned": Structure(lambda: portal("x y", 30.0), portal_loads(False), "stability functions"),
    "portal-clamped": Structure(lambda: portal("x y rz", 60.0), portal_loads(True), "stability functions"),
    "three-storeys": Structure(lambda: portal("x y rz", 24.0, 3)),
    "gable-frame": Structure(gable),
    "williams-toggle": Structure(williams),
    "battened-column": Structure(battened),
    "parabolic-hinged-0.1": Structure(lambda: parabolic(0.1, "hinged", 40.0), (29.074,), ARCHES, 1e-2),
    "parabolic-hinged-0.2": Structure(lambda: parabolic(0.2, "hinged", 60.0), (46.103,), ARCHES, 1e-2),
    "parabolic-hinged-0.3": Structure(lambda: parabolic(0.3, "hinged", 60.0), (49.457,), ARCHES, 1e-2),
    "parabolic-clamped-0.2": Structure(lambda: parabolic(0.2, "clamped", 130.0), (103.106,), ARCHES, 1e-2),
    "parabolic-clamped-0.3": Structure(lambda: parabolic(0.3, "clamped", 140.0), (120.041,), ARCHES, 1e-2),
    "parabolic-three-hinged-0.2": Structure(lambda: parabolic(0.2, "three", 60.0)),
    "pressed-arch-60": Structure(lambda: pressed_arch(radians(60.0), 12.0), (8.0,), "Boussinesq 1883"),
    "column-turning": Structure(lambda: rigid_column(lambda m: fx.Spring(m, "a", "rz", 1.0), until=1.3), (1.0,),
                                "Thompson and Hunt 1973"),
    "column-sliding": Structure(lambda: rigid_column(lambda m: fx.Spring(m, "b", "x", 1.0), until=1.3), (1.0,),
                                "Thompson and Hunt 1973"),
    "guyed-column": Structure(guyed, (0.5,), "Thompson and Hunt 1973: asymmetric; the link yields a little", 2e-2),
    "links-free": Structure(lambda: links(2, "free", 3.0), ((3 - sqrt(5)) / 2, (3 + sqrt(5)) / 2), "Ziegler 1968"),
    "links-3": Structure(lambda: links(3, "pinned", 3.3), (1.0, 3.0), "Hencky 1920"),
    "links-4": Structure(lambda: links(4, "pinned", 3.6), tuple(4 * sin(m * pi / 8) ** 2 for m in (1, 2, 3)),
                         "Hencky 1920"),
    "tripod": Structure(lambda: pyramid(3, 0.5)),
    "tripod-steep": Structure(lambda: pyramid(3, 2.0)),
    "pyramid": Structure(lambda: pyramid(4, 1.5, 0.3)),
    "pyramid-5": Structure(lambda: pyramid(5, 1.0)),
    "stacked-toggles": Structure(stacked),
    "uneven-toggle": Structure(uneven),
    "toggle-on-spring": Structure(toggle_on_spring),
    "truss-arch": Structure(truss_arch),
    "ribbed-dome": Structure(ribbed_dome),
    "angle-frame": Structure(angle_frame, (1.088,), "Simo and Vu-Quoc 1986", 1e-2),
    "bent-strip": Structure(bent_strip, tuple(n * strip_moment() for n in (1, 2, 3)), "Trahair 1993", 5e-3),
    "pressed-strip": Structure(pressed_strip, (pi**2 / 4, 9 * pi**2 / 4), "Euler, twice"),
    "twisted-ring": Structure(twisted_ring),
    "plate-sheared": Structure(lambda: plate(SHEAR, simple, 13.0), (9.325,), "Stein and Neff 1947", 5e-3),
    "plate-sheared-clamped": Structure(lambda: plate(SHEAR, lambda edge: "z rx ry", 16.0), (14.64,),
                                       "Budiansky 1948", 5e-3),
    "plate-clamped": Structure(lambda: plate(PUSH, lambda e: "z rx ry", 11.0), (10.07,), "Levy 1942", 5e-3),
    "plate-on-foundation": Structure(lambda: plate(PUSH, simple, 13.0, foundation=1000.0), tuple(sorted(
        (m + 1 / m) ** 2 + 1000 / (pi**4 * m**2) for m in (2, 3))), "Timoshenko and Gere 1961", 5e-3),
    "whole-roof": Structure(lambda: whole_roof(12.7, 30.0), (2220.971, 1701.154, 852.0226, 505.7155),
                            "this program with a first step of an eighth", 1e-6),
    "whole-roof-thin": Structure(lambda: whole_roof(6.35, 30.0)),
    "tape-spring": Structure(lambda: tape_spring(1.0, 0.6)),
    "tape-spring-opposite": Structure(lambda: tape_spring(-1.0, 0.3)),
}
