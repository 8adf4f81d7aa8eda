"""Total loads as they are reported."""

from __future__ import annotations

from math import pi

import pytest
from helpers import on_two_processes

import sheetfx as fx
from sheetfx.scenes._benchmark import surface


def two_fields(width: float):
    """A rectangular plate of two groups with a width between them."""
    nodes = {"a": (0, 0, 0), "b": (width, 0, 0), "c": (1, 0, 0), "d": (1, 1, 0), "e": (width, 1, 0), "f": (0, 1, 0)}
    return fx.read(lambda: fx.meshes.panels(nodes, {"left": "abef", "right": "bcde"}, 2), 3)


def total(mesh, load) -> float:
    shell = fx.Shell(mesh, fx.Plate(0.1), fx.Elastic(1e4, 0.3), form="naghdi-q2")
    scene = fx.Scene([shell], [fx.clamp(mesh, "f-a")], [load], fx.Monitor(mesh, "c", "z"))
    return fx.trace(fx.Case(scene, fx.LoadControl(0.5, fixed=True))).states[1].load


def test_surface_force_on_a_group_counts_its_area():
    mesh = two_fields(0.25)
    part = fx.Shell(mesh, fx.Plate(0.1), fx.Elastic(1e4, 0.3), form="naghdi-q2", group="right")
    assert total(mesh, fx.SurfaceForce(part, (0.0, 0.0, 4.0))) == pytest.approx(0.5 * 4.0 * 0.75, rel=1e-12)


def test_surface_force_that_is_a_function_of_the_place():
    """4 x over 0.25 < x < 1 on a strip of unit width."""
    mesh = two_fields(0.25)
    part = fx.Shell(mesh, fx.Plate(0.1), fx.Elastic(1e4, 0.3), form="naghdi-q2", group="right")
    force = fx.SurfaceForce(part, lambda x: (0.0, 0.0, 4 * x[0]))
    assert total(mesh, force) == pytest.approx(0.5 * 2 * (1 - 0.25**2), rel=1e-12)


def test_force_at_several_vertices_counts_each():
    """Three vertices of an edge of two cells, of which those in the middle of cells get nothing."""
    mesh = two_fields(0.25)
    state = total(mesh, fx.PointForce(mesh, "c-d", (0.0, 0.0, 2.0)))
    assert state == pytest.approx(0.5 * 3 * 2.0, rel=1e-12)


def test_reaction_shows_the_forces_at_several_vertices():
    """What is reported is what acts: the same vertices under a prescribed displacement carry the sum."""
    mesh = two_fields(0.25)
    shell = fx.Shell(mesh, fx.Plate(0.1), fx.Elastic(1e4, 0.3), form="naghdi-q2")
    supports, monitor = [fx.clamp(mesh, "f-a")], fx.Monitor(mesh, "c", "z")
    load = fx.PointForce(mesh, "c-d", (0.0, 0.0, 1e-3))
    path = fx.Path(fx.Scene([shell], supports, [load], monitor))
    system = path.discretisation.system
    vector = system.create_vector()
    system.load(vector)
    assert vector.array.sum() == pytest.approx(3e-3, rel=1e-12)


def lifted(*edges, distances=(1e-3, 1e-3)):
    """A clamped plate, edges of which are lifted."""
    mesh = two_fields(0.5)
    shell = fx.Shell(mesh, fx.Plate(0.1), fx.Elastic(1e4, 0.3), form="naghdi-q2")
    loads = [fx.PrescribedDisplacement(mesh, at, "z", w) for at, w in zip(edges, distances, strict=False)]
    return fx.Scene([shell], [fx.clamp(mesh, "f-a")], loads, fx.Monitor(mesh, "d", "z"))


@pytest.mark.slow
def test_edges_that_are_lifted_together_may_have_a_corner_in_common():
    """Their corner is lifted once, and the structure is stable; from either side with the same work."""
    works = []
    for edges in (("b-c", "c-d"), ("c-d", "b-c")):
        _, state = fx.trace(fx.Case(lifted(*edges), fx.LoadControl(1.0, fixed=True))).states
        assert state.unstable_modes == 0 and state.deflection == pytest.approx(1e-3, rel=1e-9)
        works.append(state.load)
    assert works[0] == pytest.approx(works[1], rel=1e-6)


def test_edges_with_a_corner_in_common_that_are_lifted_differently():
    with pytest.raises(ValueError, match=r"'c-d'.* 0\.002 .*'b-c'.* 0\.001"):
        lifted("b-c", "c-d", distances=(1e-3, 2e-3))
    lifted("b-c", "d-e", distances=(1e-3, 2e-3))


class Own(fx.Load):
    """A load of one's own on a shell, by what it says of itself."""

    def __init__(self, shell):
        self.shell = shell

    def work(self, fields):
        return fields.factor * fields.vary(fields.displacement(self.shell.mesh)[2]) * self.shell.measure()


class OwnPressure(Own):
    reports = "pressure"

    def total(self, fields):
        return 7.0


LOADS = [  # what, of both halves; the load of a quarter, and what it is called
    (lambda m, one, two: [fx.Pressure(one, 3.0)], 3.0, "pressure (N/mm²)"),
    (lambda m, one, two: [fx.Pressure(one, 3.0), fx.Pressure(two, -3.0)], 3.0, "pressure (N/mm²)"),
    (lambda m, one, two: [fx.Pressure(one, 3.0), fx.Pressure(two, 5.0)], 5.0, "pressure (N/mm²)"),
    (lambda m, one, two: [Own(one)], 1.0, "load factor"),
    (lambda m, one, two: [Own(one), Own(two)], 1.0, "load factor"),
    (lambda m, one, two: [OwnPressure(one), Own(two)], 7.0, "pressure (N/mm²)"),
    (lambda m, one, two: [fx.PointForce(m, "c", (0.0, 0.0, 2.0)), fx.Pressure(two, 3.0)], 8.0, "load (N)"),
    (lambda m, one, two: [fx.PointForce(m, n, (0.0, 0.0, 2.0)) for n in "cd"], 16.0, "load (N)"),
    (lambda m, one, two: [fx.Moment(m, "c", (0.0, 2.0, 0.0)), Own(one)], 8.0, "moment (N mm)"),
    (lambda m, one, two: [fx.SurfaceForce(p, (0.0, 0.0, 2.0)) for p in (one, two)], 8.0, "load (N)"),
]


@pytest.mark.silent("f03")
@pytest.mark.parametrize(("loads", "size", "name"), LOADS)
@pytest.mark.slow(quick=3)
def test_what_is_no_force_is_neither_multiplied_nor_added(loads, size, name):
    """A quarter of a structure in two groups: forces and moments count four times, all of them."""
    mesh = two_fields(0.25)
    parts = [fx.Shell(mesh, fx.Plate(0.1), fx.Elastic(1e4, 0.3), group=group) for group in ("left", "right")]
    scene = fx.Scene(parts, [fx.clamp(mesh, "f-a")], loads(mesh, *parts), fx.Monitor(mesh, "c", "z"), symmetry_factor=4)
    case = fx.Case(scene, until=fx.Until(steps=0))
    assert fx.Path(scene).discretisation.load_of_unit() == pytest.approx(size, rel=1e-12)
    assert case.axes == ("deflection (mm)", name)


@pytest.mark.silent("f03")
def test_pressure_of_a_quarter_of_a_ring_is_that_of_the_ring():
    """Critical at 3 E I / R^3 (Levy 1884), where linear buckling has it and a path that is bounded by it ends."""
    mesh = fx.read(lambda: fx.meshes.arc(1.0, 0.0, pi / 2, 8), 2, 2)
    ring = fx.Beam(mesh, fx.Rectangle(1.0, 0.05), fx.Elastic(1e4, 0.0))
    scene = fx.Scene([ring], [fx.symmetry(mesh, "start", "x"), fx.symmetry(mesh, "end", "y")],
                     [fx.LinePressure(ring, -1.0)], fx.Monitor(mesh, "start", "y", -1.0), symmetry_factor=4)
    record = fx.trace(fx.Case(scene, until=fx.Until(load=0.2)))
    assert (record.states[-1].load, record.states[-1].factor) == pytest.approx((0.2, 0.2), rel=1e-5)
    assert record.buckling(record.states[0])[0].load == pytest.approx(3 * 1e4 * 0.05**3 / 12, rel=1e-2)


def test_totals_on_two_processes():
    lines = on_two_processes('''
import sheetfx as fx
from test_loads import total, two_fields
mesh = two_fields(0.25)
part = fx.Shell(mesh, fx.Plate(0.1), fx.Elastic(1e4, 0.3), form="naghdi-q2", group="right")
print(total(mesh, fx.SurfaceForce(part, (0.0, 0.0, 4.0))), total(mesh, fx.PointForce(mesh, "c-d", (0.0, 0.0, 2.0))))
''')
    assert [float(word) for word in lines[0].split()] == pytest.approx([1.5, 3.0], rel=1e-12)


def turned(tip: str, rotation) -> list[float]:
    """Moments at the tip of a cantilever in space that is turned there, and components that a support holds besides."""
    mesh = fx.read(lambda: fx.meshes.frame({"a": (0, 0, 0), "b": (1, 0, 0)}, {"s": ("a", "b", 4)}), 3)
    beam = fx.Beam(mesh, fx.Rectangle(0.1, 0.2), fx.Elastic(1e4, 0.0))
    held = [fx.Support(mesh, "b", tip)] if tip else []
    scene = fx.Scene([beam], [fx.clamp(mesh, "a"), *held], [fx.PrescribedRotation(mesh, "b", rotation)],
                     fx.Monitor(mesh, "b", "x"))
    return [state.load for state in fx.trace(fx.Case(scene, fx.LoadControl(0.5, target=1.0))).states]


@pytest.mark.parametrize("tip", ["rx", "rz", "rx rz", "y rx rz"])
@pytest.mark.slow(quick=1)
def test_what_is_turned_may_be_held_about_other_axes(tip):
    """As in half of a symmetric structure: the moment is the same, where the tangent was singular."""
    assert turned(tip, (0.0, 0.6, 0.0)) == pytest.approx(turned("", (0.0, 0.6, 0.0)), rel=1e-9)


@pytest.mark.parametrize(("tip", "rotation", "name"), [("ry", (0.0, 0.6, 0.0), "ry"), ("rx rz", (0.3, 0.6, 0.0), "rx")])
def test_what_is_held_is_not_turned(tip, rotation, name):
    with pytest.raises(ValueError, match=f"PrescribedRotation at 'b': the support at 'b' holds {name}, and 0"):
        turned(tip, rotation)


@pytest.mark.slow
def test_an_edge_that_is_turned_ends_on_a_line_of_symmetry():
    """Half of a strip that is bent into a roll has half of the moment."""
    def moment(cells, low):
        mesh = surface("naghdi-q2", (4, cells), lambda s, t: (10 * s, low + (1 - low) * t, 0.0), {})
        shell = fx.Shell(mesh, fx.Plate(0.1), fx.Elastic(1e6, 0.3), form="naghdi-q2")
        held = fx.Support(mesh, "south-west", "y") if low else fx.symmetry(mesh, "south", "y")
        scene = fx.Scene([shell], [fx.Support(mesh, "west", "x z ry"), held],
                         [fx.PrescribedRotation(mesh, "east", (0.0, -1.0, 0.0))], fx.Monitor(mesh, "north-east", "z"))
        return fx.trace(fx.Case(scene, fx.LoadControl(0.5, target=1.0))).states[-1].load

    assert moment(2, 0.0) == pytest.approx(moment(4, -1.0) / 2, rel=1e-8)
