"""Structures beside traps and random ones: contact, friction, plasticity, springs with laws; small, and hard to follow.

Some are followed wrongly today: `WRONG` says what is right. Their golden figures are what comes out now.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from math import pi, radians

import numpy as np
from forty import STRUCTURES
from helpers import hinged_arch, whole_arch
from random_shapes import truss
from random_stacks import stack
from random_structures import scene as random_scene
from test_contact_by_steps import landing, lifted_corner
from test_following import pressure, ring
from test_pair_contact import arch_above_a_beam, graded_leaves, plate_on_a_frame, sliding_tip, two_leaves
from test_plastic_paths import hinged_beam
from test_plastic_steps import dome, portal
from test_surface_contact import strips_case

import sheetfx as fx
from sheetfx.scenes import load_case

WRONG = {
    "dome-contact-lifts": "limits at 282.1 and 271.2 kN, where edges lift; steps go straight past (0.001 finds them)",
}


def frame(nodes: dict, members: dict, order: int = 1):
    return fx.read(lambda: fx.meshes.frame(nodes, members), 2, order)


def chain(step: float | None) -> fx.Case:
    """Four springs in series whose laws have a maximum and a minimum each."""
    scales = [1 + 1e-4 * i for i in range(4)]
    mesh = frame({f"n{i}": (float(i), 0.0) for i in range(5)}, {f"b{i}": (f"n{i}", f"n{i + 1}", 1) for i in range(4)})
    springs = [fx.Spring(mesh, f"n{i}", "x", s, to=(mesh, f"n{i + 1}"),
                         law=lambda e, k: k * (e**3 - 4.5 * e**2 + 6 * e)) for i, s in enumerate(scales)]
    supports = [fx.pin(mesh, "n0"), *(fx.Support(mesh, f"n{i}", "y") for i in range(1, 5))]
    scene = fx.Scene([fx.Bar(mesh, fx.Rectangle(1, 1), fx.Elastic(1e-9))], supports,
                     [fx.PointForce(mesh, "n4", (1.0, 0.0))], fx.Monitor(mesh, "n4", "x"), joints=springs)
    return fx.Case(scene, fx.ArcLength(step), fx.Until(load=3.5, steps=20))


def pressed_ring() -> fx.Case:
    """Half a ring so slender that rounding moves its states along the modes by more than bifurcations are exact."""
    return fx.Case(ring(pressure, 2, 10), fx.ArcLength(1.5e-6), fx.Until(load=20.0))


def toggle_on_floor() -> fx.Case:
    """A rod whose foot slides on a floor against a spring."""
    mesh = frame({"apex": (0.0, 0.6), "foot": (1.0, 0.0)}, {"rod": ("apex", "foot", 1)})
    beam = fx.Beam(mesh, fx.Rectangle(0.1, 10.0), fx.Elastic(1.0, 0.0))
    touch = fx.ObstacleContact(mesh, "foot", fx.RigidPlane((0.0, 0.0), (0.0, 1.0)), distance=0.0)
    scene = fx.Scene([beam], [fx.Support(mesh, "apex", "x")], [fx.PointForce(mesh, "apex", (0.0, -1.0))],
                     fx.Monitor(mesh, "apex", "y", -1.0), joints=[touch, fx.Spring(mesh, "foot", "x", 0.05)])
    return fx.Case(scene, fx.ArcLength(), fx.Until(deflection=0.54))


def plastic_toggle(rise: float, to: float) -> fx.Case:
    """Two bars of a law with history that never yield, or that are strained back behind the flat position."""
    mesh = frame({"a": (-1000.0, 0.0), "top": (0.0, rise), "b": (1000.0, 0.0)}, {"l": ("a", "top", 1),
                                                                               "r": ("top", "b", 1)})
    bar = fx.Bar(mesh, fx.Rectangle(10.0, 10.0), fx.Plastic(200e3, 0.3, yield_stress=235.0, hardening=2e3))
    scene = fx.Scene([bar], [fx.pin(mesh, "a"), fx.pin(mesh, "b"), fx.Support(mesh, "top", "x")],
                     [fx.PointForce(mesh, "top", (0, -1.0))], fx.Monitor(mesh, "top", "y", -1.0))
    return fx.Case(scene, until=fx.Until(deflection=to))


def plastic_dome(times: float) -> fx.Case:
    """A dome of round bars that leans to one side as they flow, with limits at 7153.9, by multiples of a first step."""
    return fx.Case(dome(3), fx.ArcLength(times * 1.25e-3), fx.Until(deflection=2.9))


def column_at_wall(**how) -> fx.Case:
    """A clamped column that is bent against a wall, then loaded."""
    deep = 0.01
    mesh = frame({"base": (0, 0), "mid": (0.5, 0), "top": (1, 0)}, {"a": ("base", "mid", 10), "b": ("mid", "top", 10)})
    beam = fx.Beam(mesh, fx.Rectangle(1.0, deep), fx.Elastic(12 / deep**3, 0.0))
    touch = fx.ObstacleContact(mesh, None, fx.RigidPlane((0.0, 0.015), (0.0, -1.0)), **how)
    scene = fx.Scene([beam], [fx.clamp(mesh, "base"), fx.Support(mesh, "top", "y rz")],
                     [fx.PointForce(mesh, "top", (-1.0, 0))], fx.Monitor(mesh, "mid", "y"), joints=[touch],
                     stages=[fx.Stage([fx.PointForce(mesh, "mid", (0.0, 0.02))], "push")])
    return fx.Case(scene, until=fx.Until(load=14 * pi**2))


def column_beside_wall() -> fx.Case:
    """A pinned column that buckles against a wall beside it (Domokos, Holmes and Royce 1997)."""
    deep = 0.01
    mesh = frame({"a": (0, 0), "q": (0.0, 0.5), "b": (0, 1.0)}, {"l": ("a", "q", 10), "r": ("q", "b", 10)}, 2)
    mesh = fx.imperfect(mesh, lambda x: np.column_stack((1e-4 * np.sin(pi * x[:, 1]), 0 * x[:, 1])))
    beam = fx.Beam(mesh, fx.Rectangle(1.0, deep), fx.Elastic(1e9, 0.0), shear_rigidity=1e2)
    wall = fx.RigidPlane((0.01, 0.0), (-1.0, 0.0))
    scene = fx.Scene([beam], [fx.pin(mesh, "a"), fx.Support(mesh, "b", "x")], [fx.PointForce(mesh, "b", (0.0, -1.0))],
                     fx.Monitor(mesh, "b", "y", -1.0), contacts=[fx.Contact(beam, wall, distance=0.0)])
    return fx.Case(scene, until=fx.Until(load=20 * pi**2 * 1e9 * deep**3 / 12, steps=24))


def friction_limit(control) -> fx.Case:
    """A node on a rough floor that sticks, slips back and opens (Klarbring 1990)."""
    unit, length = 1e-2, 10.0
    slope = length / 2**0.5
    ends = {"dia end": (slope, slope), "ver end": (0.0, length), "hor end": (length, 0.0)}
    mesh = frame({"n": (0.0, 0.0), **ends}, {end[:3]: ("n", end, 1) for end in ends})
    bars = [fx.Bar(mesh, fx.Rectangle(1.0, 1.0), fx.Elastic(k * length), group=g)
            for g, k in (("dia", 1.0), ("ver", 0.1), ("hor", 0.1))]
    touch = fx.ObstacleContact(mesh, "n", fx.RigidPlane((0.0, 0.0), (0.0, 1.0)), distance=0.0, friction=1.5,
                               stiffness=1e3, tangential=1e3)
    press = fx.Stage([fx.PointForce(mesh, "n", (0.0, -unit))], control=fx.LoadControl(1.0, fixed=True))
    scene = fx.Scene(bars, [fx.pin(mesh, end) for end in ends], [fx.PointForce(mesh, "n", (-unit, 0.0))],
                     fx.Monitor(mesh, "n", "x", -1.0), joints=[touch], stages=[press])
    return fx.Case(scene, control, fx.Until(deflection=3.5 * unit))


def arch_on_floor(exact: bool) -> fx.Case:
    """A shallow arch that snaps onto a floor below its supports."""
    span, rise, deep, cells = 100.0, 1.2, 0.5, 20
    nodes = {f"n{i}": (float(x), float(rise * np.sin(pi * x / span)))
             for i, x in enumerate(np.linspace(0, span / 2, cells + 1))}
    mesh = frame(nodes, {f"b{i}": (f"n{i}", f"n{i + 1}", 1) for i in range(cells)})
    beam = fx.Beam(mesh, fx.Rectangle(1.0, deep), fx.Elastic(1e4, 0.0), shear_rigidity=1e3)
    plane = fx.RigidPlane((0.0, -0.3), (0.0, 1.0))
    how = ({"contacts": [fx.Contact(beam, plane, distance=0.0)]} if exact else
           {"joints": [fx.ObstacleContact(mesh, None, plane, distance=0.0, samples=4)]})
    scene = fx.Scene([beam], [fx.pin(mesh, "n0"), fx.symmetry(mesh, f"n{cells}")],
                     [fx.LineForce(beam, (0.0, -4e-4))], fx.Monitor(mesh, f"n{cells}", "y", -1.0), **how)
    return fx.Case(scene, until=fx.Until(deflection=1.3, steps=24))


def leaves() -> fx.Case:
    """Two leaves that are pressed together and bent, with friction between them (Goodman and Klumpp 1956)."""
    deep, press = 0.05, 4.0
    up, low = (frame({"a": (0, y), "b": (1.0, y)}, {"s": ("a", "b", 10)}, 2) for y in (deep, 0.0))
    beams = [fx.Beam(m, fx.Rectangle(1.0, deep), fx.Elastic(1e6, 0.0)) for m in (up, low)]
    touch = fx.PairContact(up, "s", (low, None), toward=(0, -1.0), reach=1.5 * deep, friction=0.5)
    pressed = fx.Stage([fx.LineForce(beams[0], (0.0, -press)), fx.LineForce(beams[1], (0.0, press))],
                       control=fx.LoadControl(1.0, fixed=True))
    scene = fx.Scene(beams, [fx.clamp(m, "a") for m in (up, low)],
                     [fx.PointForce(m, "b", (0, -press * deep / 4)) for m in (up, low)], fx.Monitor(up, "b", "y", -1.0),
                     joints=[touch], stages=[pressed])
    return fx.Case(scene, fx.LoadControl(0.1, target=2.0))


def drawn_tip(**how) -> fx.Case:
    """A rod that is pressed on a bar and drawn along it: it sticks, then slips."""
    bar = frame({"p": (-1, 0), "q": (0.5, 0)}, {"bar": ("p", "q", 6)})
    rod = frame({"top": (0, 0.5), "tip": (0, 0.05)}, {"rod": ("top", "tip", 1)})
    beams = [fx.Beam(m, fx.Rectangle(0.05, 0.05), fx.Elastic(2e7, 0.0)) for m in (bar, rod)]
    touch = fx.PairContact(rod, "tip", (bar, None), toward=(0, -1.0), reach=0.1, friction=0.3, **how)
    press = fx.Stage([fx.PointForce(rod, "top", (0.0, -0.01))], control=fx.LoadControl(1.0, fixed=True))
    scene = fx.Scene(beams, [fx.clamp(bar, "p"), fx.Support(rod, "top", "rz")],
                     [fx.PrescribedDisplacement(rod, "top", "x", 1.0)], fx.Monitor(rod, "top", "x"),
                     joints=[touch, fx.Spring(rod, "top", "y", 0.1)], stages=[press])
    return fx.Case(scene, fx.LoadControl(0.05, target=0.3), fx.Until(steps=60))


def wedge(stiffness: float | None) -> fx.Case:
    """A free rigid wedge that is pushed under the tip of a cantilever."""
    mesh = frame({"a": (0, 0), "b": (1, 0)}, {"s": ("a", "b", 8)}, 2)
    beam = fx.Beam(mesh, fx.Rectangle(0.02, 0.02), fx.Elastic(1e6, 0.0))
    plane = fx.RigidPlane((1.0, 0.0), (-np.sin(0.5), np.cos(0.5)), travel=(-1.0, 0.0))
    touch = fx.ObstacleContact(mesh, "b", plane, distance=0.0, stiffness=stiffness)
    scene = fx.Scene([beam], [fx.clamp(mesh, "a")], [fx.ObstacleForce(plane, 1.0)], fx.Monitor(plane), joints=[touch])
    return fx.Case(scene, fx.DisplacementControl(0.01), fx.Until(deflection=0.2))


def plastic_bar() -> fx.Case:
    """A bar of perfect plasticity that is pulled over its plateau."""
    mesh = frame({"a": (0, 0), "b": (100.0, 0)}, {"l": ("a", "b", 1)})
    bar = fx.Bar(mesh, fx.Rectangle(10.0, 10.0), fx.Plastic(200e3, 0.3, yield_stress=200.0))
    scene = fx.Scene([bar], [fx.pin(mesh, "a"), fx.Support(mesh, "b", "y")], [fx.PointForce(mesh, "b", (2e4, 0.0))],
                     fx.Monitor(mesh, "b", "x"))
    return fx.Case(scene, fx.DisplacementControl(0.02), fx.Until(deflection=1.0))


def plastic_portal() -> fx.Case:
    """A pinned portal of perfect plasticity under a force in the middle of its beam."""
    high, long = 1000.0, 2000.0
    nodes = {"A": (0, 0), "B": (0, high), "C": (long / 2, high), "D": (long, high), "F": (long, 0)}
    mesh = frame(nodes, {a + b: (a, b, 6) for a, b in ("AB", "BC", "CD", "DF")})
    beam = fx.Beam(mesh, fx.Rectangle(20.0, 60.0, points=8), fx.Plastic(200e3, 0.3, yield_stress=200.0, hardening=1e3))
    scene = fx.Scene([beam], [fx.pin(mesh, "A"), fx.pin(mesh, "F")], [fx.PointForce(mesh, "C", (0.0, -1.0))],
                     fx.Monitor(mesh, "C", "y", -1.0))
    return fx.Case(scene, fx.ArcLength(), fx.Until(deflection=60.0, steps=60))


def lying_plate() -> fx.Case:
    """A plate under a pressure of its own weight's kind that is bent onto another along an edge (surfaces touch)."""
    def plate(z, cells):
        return fx.read(lambda: fx.meshes.rectangle((cells, 2), (1.0, 0.4)), 3, 2,
                       lambda x: np.column_stack((x[:, 0], x[:, 1], np.full(len(x), z))))

    up, low = plate(0.03, 4), plate(0.0, 4)
    shells = [fx.Shell(mesh, fx.Plate(0.01), fx.Elastic(1e6, 0.3)) for mesh in (up, low)]
    touch = fx.SurfaceContact(up, "east", (low, None), toward=(0.0, 0.0, -1.0))
    scene = fx.Scene(shells, [fx.clamp(up, "west"), fx.clamp(low, "west")],
                     [fx.EdgeForce(up, "east", (0.0, 0.0, -0.5))], fx.Monitor(up, "north-east", "z", -1.0),
                     joints=[touch])
    return fx.Case(scene, fx.ArcLength(), fx.Until(deflection=0.08, steps=30))


def prop(control: fx.ArcLength) -> fx.Case:
    """A clamped column that is pressed against a prop, which lets go at a load of 100 (Timoshenko and Gere 1961)."""
    column = frame({"start": (0.0, 0.0), "end": (1.0, 0.0)}, {"bar": ("start", "end", 8)})
    wall = frame({"start": (0.9, 0.0), "end": (1.1, 0.0)}, {"wall": ("start", "end", 2)})
    beams = [fx.Beam(mesh, fx.Rectangle(0.1, 0.1), fx.Elastic(1.2e6, 0.0)) for mesh in (column, wall)]
    touch = fx.PairContact(column, "end", (wall, None), moving=False, toward=(0.0, -1.0))
    scene = fx.Scene(beams, [fx.clamp(column, "start"), fx.clamp(wall, "start"), fx.clamp(wall, "end")],
                     [fx.PointForce(column, "end", (-1.0, 0.01))], fx.Monitor(column, "end", "y"), joints=[touch],
                     stages=[fx.Stage([fx.PointForce(column, "end", (0.0, -1.0))])])
    return fx.Case(scene, control, fx.Until(deflection=0.02))


def imperfect_arch(amplitude: float, step: float | None) -> fx.Case:
    """A hinged arch whose path bends away from the perfect one's beside its bifurcation at 129.761."""
    def deviation(x):
        return np.sin(pi * np.arctan2(x[:, 0], x[:, 1]) / radians(7.338))

    mesh = fx.imperfect(whole_arch(40), deviation, amplitude * 4.7625)
    return fx.Case(hinged_arch(mesh), fx.ArcLength(step), fx.Until(deflection=20.0))


def stacked(seed: int) -> fx.Case:
    """Leaves or an arch on an obstacle, up to their load."""
    structure = stack(seed)
    return fx.Case(structure.scene, until=fx.Until(load=structure.load))


def nearly_straight_column() -> fx.Case:
    """A column that is bent by a ten-millionth of its length: its path bends away where the straight one's branches."""
    mesh = fx.read(lambda: fx.meshes.frame({"a": (0, 0), "m": (0.5, 1e-7), "b": (1, 0)},
                                           {"l": ("a", "m", 8), "r": ("m", "b", 8)}), 2)
    beam = fx.Beam(mesh, fx.Rectangle(0.01, 0.01), fx.Elastic(2.1e11))
    euler = np.pi**2 * 2.1e11 * 0.01**4 / 12
    scene = fx.Scene([beam], [fx.Support(mesh, "a", "x y"), fx.Support(mesh, "b", "y")],
                     [fx.PointForce(mesh, "b", (-euler, 0.0))], fx.Monitor(mesh, "m", "y"))
    return fx.Case(scene, fx.ArcLength(0.05), fx.Until(deflection=0.2, steps=60))


def scene(name: str, steps: int | None = None, **options) -> Callable[[], fx.Case]:
    """A built-in scene, or its first steps."""
    def case() -> fx.Case:
        made = load_case(name)(**options)
        return replace(made, until=replace(made.until, steps=steps)) if steps else made

    return case


def whole_truss() -> fx.Case:
    """A random dome to its end, beyond the steps that random structures are given; limits at 1e-3 of its loads."""
    structure = truss(0)
    return fx.Case(random_scene(structure), until=fx.Until(deflection=structure.deflection))


CASES: dict[str, Callable[[], fx.Case]] = {
    "chain": lambda: chain(None),
    "chain-long-steps": lambda: chain(0.08),
    "toggle-on-floor": toggle_on_floor,
    "plastic-toggle": lambda: plastic_toggle(30.0, 58.5),
    "plastic-toggle-yielding": lambda: plastic_toggle(100.0, 195.0),
    "plastic-dome": lambda: plastic_dome(1.0),
    "plastic-dome-long-steps": lambda: plastic_dome(8.0),
    "column-at-wall": column_at_wall,
    "column-at-stiff-wall": lambda: column_at_wall(stiffness=1e5),
    "column-beside-wall": column_beside_wall,
    "friction-limit": lambda: friction_limit(fx.ArcLength()),
    "friction-limit-by-displacement": lambda: friction_limit(fx.DisplacementControl(0.002)),
    "arch-on-floor": lambda: arch_on_floor(False),
    "arch-on-floor-exact": lambda: arch_on_floor(True),
    "leaves": leaves,
    "arch-meets-beam": lambda: fx.Case(arch_above_a_beam("condensed")[0], until=fx.Until(deflection=30.0)),
    "whole-truss": whole_truss,
    "ring-pressed": pressed_ring,
    "leaves-in-line": lambda: two_leaves(0.3, 0.05),
    "leaves-apart": lambda: two_leaves(0.3, -0.05),
    "leaves-graded": lambda: graded_leaves(24, 0.3),
    "leaves-on-plane": lambda: stacked(14),
    "leaves-without-gap": lambda: stacked(86),
    "arch-turns-on-plane": lambda: stacked(59),
    "plate-lifts-corners": lambda: fx.Case(plate_on_a_frame(12), until=fx.Until(deflection=1e-5)),
    "arch-punch-yielding": scene("arch", elements=80, yield_stress=40.0, to=30.0),
    "drawn-tip": drawn_tip,
    "drawn-tip-uzawa": lambda: drawn_tip(enforcement="uzawa"),
    "wedge": lambda: wedge(None),
    "wedge-stiff": lambda: wedge(1e4),
    "prop": lambda: prop(fx.ArcLength(step=0.02)),
    "prop-long-steps": lambda: prop(fx.ArcLength()),
    "tip-slides": lambda: replace(sliding_tip(0.2), until=fx.Until(deflection=30.6403, steps=40)),
    "column-nearly-straight": nearly_straight_column,
    "imperfect-arch": lambda: imperfect_arch(1e-4, None),
    "imperfect-arch-short": lambda: imperfect_arch(1e-4, 4.672885757e-3),
    "imperfect-arch-shorter": lambda: imperfect_arch(3e-6, 2.871219167e-3),
    "plastic-bar": plastic_bar,
    "plastic-beam": lambda: fx.Case(hinged_beam(), fx.DisplacementControl(step=1e-4), fx.Until(deflection=6e-4)),
    "plastic-portal": plastic_portal,
    "lying-plate": lying_plate,
    "corner-lifted": lambda: lifted_corner(5e-3, 5e6, 55.0, 2e-6),
    "cantilever-lands": lambda: landing(fx.ArcLength(), True)[0],
    "arch-semismooth": scene("arch", elements=40, enforcement="semismooth", to=20.0),
    "arch-nodes-friction": scene("arch", elements=40, contact="nodes", friction=0.3, to=20.0),
    "arch-yielding": scene("arch", elements=20, no_punch=True, yield_stress=200.0, to=20.0),
    "roof-yielding": scene("roof", cells=3, form="naghdi-q2", yield_stress=15.0, to=20.0),
    "portal-sways": portal,
    "dome-double": scene("dome", divisions=5, form="naghdi-t2", to=39.0),
    "plastic-cylinder": scene("plastic-cylinder", cells=6, layers=3, to=30.0),
    "double-plate-elastic": scene("double-plate", 10, elastic=True, cells=4),
    "double-plate": scene("double-plate", 20, cells=4, layers=2),
    "double-plate-touches": lambda: replace(strips_case(4), until=fx.Until(deflection=24.0)),
    "dome-coupled": scene("dome", divisions=2, to=30.0),
    "dome-triangles-long-steps": scene("dome", divisions=5, form="naghdi-t2", step=0.006, to=45.0),
    "dome-contact-lifts": scene("dome", model="contact", divisions=4, to=6.5),
    "dome-contact": scene("dome", model="contact", divisions=2, weld=400.0, to=8.0),
    "dome-contact-friction": scene("dome", model="contact", divisions=2, weld=400.0, friction=0.2, to=8.0),
    "dome-contact-uzawa": scene("dome", model="contact", divisions=2, weld=400.0, enforcement="uzawa", to=8.0),
    "m1-contact-friction": scene("m1", model="contact", divisions=2, friction=0.2, to=3.0),
    "channel": scene("channel", cells=12),
    "slit-annulus": scene("slit-annulus"),
    "hemisphere": scene("hemisphere", cells=4),
    "whole-roof": STRUCTURES["whole-roof"].case,
    "plate-buckling": scene("plate-buckling", cells=4),
    "cylinder-buckling": scene("cylinder-buckling", cells=(8, 2)),
}
