"""Total loads as they are reported."""

from __future__ import annotations

import pytest
from helpers import on_two_processes

import sheetfx as fx


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


def test_totals_on_two_processes():
    lines = on_two_processes('''
import sheetfx as fx
from test_loads import total, two_fields
mesh = two_fields(0.25)
part = fx.Shell(mesh, fx.Plate(0.1), fx.Elastic(1e4, 0.3), form="naghdi-q2", group="right")
print(total(mesh, fx.SurfaceForce(part, (0.0, 0.0, 4.0))), total(mesh, fx.PointForce(mesh, "c-d", (0.0, 0.0, 2.0))))
''')
    assert [float(word) for word in lines[0].split()] == pytest.approx([1.5, 3.0], rel=1e-12)
