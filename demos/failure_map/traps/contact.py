"""Structures whose parts touch: shallow trusses that meet springs or a wall, and a strip that is peeled off.

The load of a truss at a deflection is a closed form, and so are springs' and friction's that are added to it, so
that all extrema of the path are known, also those at which the rate of the load jumps past zero.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial

import numpy as np

from sheetfx import meshes
from sheetfx.case import Case
from sheetfx.continuation.control import ArcLength, LoadControl, StepRule
from sheetfx.mesh.reader import NamedMesh, read
from sheetfx.model.beam import Bar, Beam
from sheetfx.model.interface import hinge
from sheetfx.model.joints import Joint, Spring
from sheetfx.model.loads import LineForce, PointForce
from sheetfx.model.pair_contact import PairContact
from sheetfx.model.scene import Monitor, Scene, Stage
from sheetfx.model.section import Elastic, Rectangle
from sheetfx.model.supports import Support, pin
from sheetfx.path import Until

from .trap import Trap, limits

RISE = 0.2  # of the apex over half the span
STEEPEST = 0.0395  # at which the load of such a truss falls with its deflection, of EA
STIFF = 1e4  # of contact, over EA
DOWN = (0.0, -1.0)
SHORT = ArcLength(step=0.005, largest=1.0)


def resistance(deflection, rise: float = RISE):
    """Load over EA of a truss of two bars, half its span being 1, at a deflection of its apex."""
    height = rise - np.asarray(deflection)
    now, before = np.hypot(1.0, height), np.hypot(1.0, rise)
    return 2 * (before - now) / before * height / now


def extrema(load: Callable[[np.ndarray], np.ndarray], to: float) -> tuple[float, ...]:
    """Loads at which a path turns before a deflection, from a function that is sampled finely."""
    loads = load(np.linspace(0.0, to, 2_000_001))
    rise = np.diff(loads)
    return tuple(float(loads[i + 1]) for i in np.flatnonzero(rise[1:] * rise[:-1] < 0))


MOST_AT = float(np.linspace(0.0, RISE, 200_001)[resistance(np.linspace(0.0, RISE, 200_001)).argmax()])


def truss(rise: float, height: float = 0.0) -> tuple[NamedMesh, Bar, list[Support]]:
    """Two bars under an apex at (0, height), EA = 1, with their supports."""
    nodes = {"left": (-1.0, height - rise), "apex": (0.0, height), "right": (1.0, height - rise)}
    mesh = read(lambda: meshes.frame(nodes, {"one": ("left", "apex", 1), "other": ("apex", "right", 1)}), 2)
    return mesh, Bar(mesh, Rectangle(1.0, 1.0), Elastic(1.0)), [pin(mesh, "left"), pin(mesh, "right")]


def rod(middle: Sequence[float], half: Sequence[float], modulus: float = 1e8) -> tuple[NamedMesh, Beam]:
    """A stiff beam with nodes "first", "middle" and "last"."""
    nodes = {"first": np.subtract(middle, half), "middle": middle, "last": np.add(middle, half)}
    members = {"a": ("first", "middle", 1), "b": ("middle", "last", 1)}
    mesh = read(lambda: meshes.frame({n: tuple(x) for n, x in nodes.items()}, members), 2)
    return mesh, Beam(mesh, Rectangle(1.0, 0.1), Elastic(modulus))


def _pressed(mesh: NamedMesh, parts, supports, joints: list[Joint], to: float, control: StepRule = SHORT,
             **how) -> Case:
    scene = Scene(parts, supports, [PointForce(mesh, "apex", DOWN)], Monitor(mesh, "apex", "y", -1.0), joints=joints,
                  **how)
    return Case(scene, control, Until(deflection=to))


def onto_spring(gap: float, stiffness: float, to: float, control: StepRule = SHORT) -> Case:
    """A truss whose apex meets a spring after a deflection."""
    mesh, bars, supports = truss(RISE)
    table, beam = rod((0.0, -gap), (1.0, 0.0))
    touch = PairContact(mesh, "apex", (table, None), toward=DOWN, gap=gap, reach=gap, stiffness=STIFF)
    return _pressed(mesh, [bars, beam], [*supports, Support(table, "middle", "x rz")],
                    [touch, Spring(table, "middle", "y", stiffness)], to, control)


def onto_two_springs(gap: float, stiffness: float, to: float) -> Case:
    """A truss that carries a crossbeam, both ends of which meet a spring at the same deflection."""
    mesh, bars, supports = truss(RISE)
    cross, beam = rod((0.0, 0.0), (0.5, 0.0))
    parts, joints = [bars, beam], [hinge(cross, "middle", (mesh, "apex")), Spring(cross, "middle", "rz", 1e-2)]
    for end, x in (("first", -0.5), ("last", 0.5)):
        table, support = rod((x, -gap), (1.0, 0.0))
        parts.append(support)
        supports.append(Support(table, "middle", "x rz"))
        joints += [Spring(table, "middle", "y", stiffness / 2),
                   PairContact(cross, end, (table, None), toward=DOWN, gap=gap, reach=gap, stiffness=STIFF)]
    return _pressed(mesh, parts, supports, joints, to)


def along_wall(force: float, friction: float, tangential: float, to: float) -> Case:
    """A truss whose apex slides down a wall, which a force presses against it beforehand."""
    mesh, bars, supports = truss(RISE)
    wall, beam = rod((0.1, 0.0), (0.0, 1.0))
    touch = PairContact(mesh, "apex", (wall, None), toward=(1.0, 0.0), reach=0.1, stiffness=STIFF, friction=friction,
                        tangential=tangential)
    stage = Stage([PointForce(wall, "middle", (-force, 0.0))], control=LoadControl(step=1.0))
    return _pressed(mesh, [bars, beam], [*supports, Support(mesh, "apex", "x"), Support(wall, "middle", "y rz")],
                    [touch, Spring(wall, "middle", "x", 1e-6)], to, stages=[stage])


def under_spring(force: float, stiffness: float, to: float) -> Case:
    """A truss under a spring that is compressed by a force, and lets go where it has none left."""
    mesh, bars, supports = truss(RISE)
    table, beam = rod((0.0, 0.1), (1.0, 0.0))
    touch = PairContact(mesh, "apex", (table, None), toward=(0.0, 1.0), reach=0.1, stiffness=STIFF)
    stage = Stage([PointForce(table, "middle", (0.0, -force))], control=LoadControl(step=0.2))
    return _pressed(mesh, [bars, beam], [*supports, Support(table, "middle", "x rz")],
                    [touch, Spring(table, "middle", "y", stiffness)], to, stages=[stage])


def peeled() -> Case:
    """A heavy strip on a stiff beam, lifted at one end: its pairs open one after the other."""
    def strip(name, height):
        nodes = {"start": (0.0, height), "end": (4.0, height)}
        return read(lambda: meshes.frame(nodes, {name: ("start", "end", 32)}), 2)

    upper, lower = strip("strip", 0.0), strip("ground", -0.1)
    parts = [Beam(upper, Rectangle(0.1, 0.1), Elastic(1.2e5)), Beam(lower, Rectangle(1.0, 1.0), Elastic(1e7))]
    touch = PairContact(upper, "strip", (lower, None), reach=0.1, stiffness=1e3)
    scene = Scene(parts, [Support(upper, "end", "x rz"), *(Support(lower, at, "x y rz") for at in ("start", "end"))],
                  [PointForce(upper, "start", (0.0, 1.0))], Monitor(upper, "start", "y"), joints=[touch],
                  stages=[Stage([LineForce(parts[0], DOWN)], control=LoadControl(step=1.0))])
    return Case(scene, SHORT, Until(deflection=0.3))


def _with_spring(gap: float, stiffness: float, deflection):
    series = stiffness * STIFF / (stiffness + STIFF)
    return resistance(deflection) + series * np.maximum(deflection - gap, 0.0)


def _along_wall(force: float, tangential: float, deflection):
    return resistance(deflection) + np.minimum(tangential * deflection, force)


def _under_spring(force: float, stiffness: float, deflection):
    return resistance(deflection) - np.maximum(force - stiffness * deflection, 0.0)


AT_LIMIT, BOTH, SLIPS, RELEASED = 1.05 * MOST_AT, 0.1, 1.05 * MOST_AT, 0.1
CORNER = 2e-3  # tolerance of loads: corners of paths are found to a fiftieth of a step
CONTACT = (
    Trap("contact-at-limit",
         "A spring is touched just behind the maximum: the rate of the load jumps from falling to rising, and is zero "
         "nowhere in between. (Steps that are longer than the way between both miss them.)",
         partial(onto_spring, AT_LIMIT, 2 * STEEPEST, 0.12, ArcLength(step=0.001, largest=4.0)),
         limits(*extrema(partial(_with_spring, AT_LIMIT, 2 * STEEPEST), 0.12), tolerance=CORNER),
         "closed form of the truss and its spring"),
    Trap("contact-chatter",
         "Two contacts close at once while the load falls: an iteration that closes one opens the other.",
         partial(onto_two_springs, BOTH, 0.5 * STEEPEST, 0.45),
         limits(*extrema(partial(_with_spring, BOTH, 0.5 * STEEPEST), 0.45), tolerance=CORNER),
         "closed form of the truss and its springs", slow=True),
    Trap("contact-stick-slip",
         "A wall that sticks to the apex lets go just behind the maximum: rate and tangent jump, and no energy tells.",
         partial(along_wall, 0.02, 0.1, 0.002 / SLIPS, 0.38),
         limits(*extrema(partial(_along_wall, 0.002, 0.002 / SLIPS), 0.38), tolerance=CORNER),
         "closed form of the truss and Coulomb's law"),
    Trap("contact-release",
         "A compressed spring lets go of a truss that it has helped to snap: the load turns where the contact opens.",
         partial(under_spring, STEEPEST * RELEASED, STEEPEST, 0.38),
         limits(*extrema(partial(_under_spring, STEEPEST * RELEASED, STEEPEST), 0.38), tolerance=CORNER),
         "closed form of the truss and its spring"),
    Trap("contact-peeling",
         "Pairs open one after the other as a strip is lifted: each makes the tangent jump, and none is critical.",
         peeled, (), "the load over the lifted length of a heavy strip rises, Timoshenko 1956", slow=True),
)
