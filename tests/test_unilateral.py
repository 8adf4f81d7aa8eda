"""Linear buckling of parts that touch without being joined."""

from dataclasses import replace

import numpy as np
import pytest
from helpers import on_two_processes

import sheetfx as fx
from sheetfx.scenes import plate_buckling

PINNED_CLAMPED = 20.1907  # P L^2 / EI of a span


def spans(count: int, cells: int = 12, push: float = 1.0) -> fx.Scene:
    """A column over equal spans of length 1 that lies on a rigid floor; EI = 1."""
    mesh = fx.read(lambda: fx.meshes.frame({f"n{i}": (float(i), 0.0) for i in range(count + 1)},
                                           {f"b{i}": (f"n{i}", f"n{i + 1}", cells) for i in range(count)}), 2, 2)
    beam = fx.Beam(mesh, fx.Rectangle(1.0, 0.01), fx.Elastic(12 / 0.01**3, 0.0))
    floor = fx.ObstacleContact(mesh, None, fx.RigidPlane((0.0, 0.0), (0.0, 1.0)), distance=0.0)
    supports = [fx.pin(mesh, "n0"), *(fx.Support(mesh, f"n{i}", "y") for i in range(1, count + 1))]
    return fx.Scene([beam], supports, [fx.PointForce(mesh, f"n{count}", (-push, 0.0))],
                    fx.Monitor(mesh, f"n{count}", "x", -1.0), joints=[floor])


def found(scene: fx.Scene, **options) -> fx.UnilateralBuckling:
    path = fx.Path(scene, until=fx.Until(steps=0))
    return fx.unilateral_buckling(path, next(iter(path)), **options)


def test_single_span_lifts_off():
    """Away from the floor nothing holds it: Euler's load, and a mode that goes up."""
    path = fx.Path(spans(1), until=fx.Until(steps=0))
    found = fx.unilateral_buckling(path, next(iter(path)))
    assert found.load == pytest.approx(np.pi**2, rel=5e-4)
    assert found.load == pytest.approx(found.lower, rel=1e-9) and found.pressed == 0
    mesh = path.scene.parts[0].mesh
    shape = fx.mode_displacement(path, mesh, found).x.array.reshape(-1, mesh.domain.geometry.dim)
    assert shape[:, 1].max() == pytest.approx(1.0, rel=1e-2) and shape[:, 1].min() > -1e-9
    assert "0 of 24 contacts pressed" in str(found)


@pytest.mark.slow
def test_two_spans_cannot_both_go_to_their_own_side():
    """Without the floor one span goes up and one down. With it one is flat, or both go up, clamped at the middle.

    Beside the middle support the floor holds at its first sample only, which is 2 % softer than a clamp with 12 cells.
    """
    solution = found(spans(2))
    assert solution.lower == pytest.approx(np.pi**2, rel=5e-4)
    assert 0.975 * PINNED_CLAMPED < solution.load < PINNED_CLAMPED < solution.upper
    assert max(solution.others) == pytest.approx(PINNED_CLAMPED, rel=5e-4)
    finer = found(spans(2, 48))
    assert solution.load < finer.load < PINNED_CLAMPED


@pytest.mark.slow
def test_loads_do_not_hang_on_the_stiffness_of_contact():
    scene = spans(2)
    loads = [found(replace(scene, joints=[replace(scene.joints[0], stiffness=times)])).load
             for times in (1e4, 1e6, 1e8)]
    assert loads == pytest.approx(3 * [loads[1]], rel=2e-3)


@pytest.mark.slow
def test_long_plate_on_a_rigid_base():
    """A bulge at an end, k = 4.5, and one between, k = 16/3 (Seide 1958): f = f' = f'' = 0 where contact begins.

    Of the sines and cosines whose wave numbers have the product (pi/b)^2 and the ratio 1/2 (at an end) or 1/3.
    """
    case = plate_buckling.case(aspect=5.0, cells=4, form="naghdi-q2", slenderness=200.0)
    mesh = case.scene.parts[0].mesh
    floor = fx.ObstacleContact(mesh, None, fx.RigidPlane((0.0, 0.0, 0.0), (0.0, 0.0, 1.0)), distance=0.0)
    solution = found(replace(case.scene, joints=[floor]))
    loads = [load * 4.0 / solution.lower for load in (solution.load, *solution.others)]
    assert loads[0] == pytest.approx(4.5, rel=5e-3)
    assert loads[-1] == pytest.approx(16 / 3, rel=5e-3)


def test_column_on_another():
    """Loaded alone it leaves the one below; joined they bend together at twice the load."""
    meshes = [fx.read(lambda y=y: fx.meshes.frame({"a": (0.0, y), "b": (1.0, y)}, {"s": ("a", "b", 16)}), 2, 2)
              for y in (0.01, 0.0)]
    columns = [fx.Beam(mesh, fx.Rectangle(1.0, 0.01), fx.Elastic(12 / 0.01**3, 0.0)) for mesh in meshes]
    touch = fx.PairContact(meshes[0], "s", (meshes[1], None), toward=(0.0, -1.0), reach=0.02)
    supports = [support for mesh in meshes for support in (fx.pin(mesh, "a"), fx.Support(mesh, "b", "y"))]
    scene = fx.Scene(columns, supports, [fx.PointForce(meshes[0], "b", (-1.0, 0.0))],
                     fx.Monitor(meshes[0], "b", "x", -1.0), joints=[touch])
    solution = found(scene)
    assert solution.load == pytest.approx(np.pi**2, rel=1e-3)
    assert solution.upper == pytest.approx(2 * np.pi**2, rel=2e-3)


@pytest.mark.slow
def test_friction_changes_nothing():
    """Modes are without it; the tangent counts as unsymmetric then."""
    scene = spans(2)
    rough = replace(scene, joints=[replace(scene.joints[0], friction=0.3)])
    assert found(rough).load == pytest.approx(found(scene).load, rel=1e-8)


@pytest.mark.slow
def test_the_same_on_two_processes():
    lines = on_two_processes("""
from test_unilateral import found, spans
solution = found(spans(2))
print(f"{solution.load:.12g}", f"{max(solution.others):.12g}", solution.pressed)""")
    solution, both = found(spans(2)), lines[-1].split()
    assert [float(load) for load in both[:2]] == pytest.approx([solution.load, max(solution.others)], rel=1e-8)
    assert int(both[2]) == solution.pressed


def test_what_cannot_be_asked_is_refused():
    scene = spans(1)
    with pytest.raises(ValueError, match="no load of this sense makes the structure buckle, even with all contacts"):
        found(spans(1, push=-1.0))
    with pytest.raises(ValueError, match="nothing touches in this state"):
        found(replace(scene, joints=()))
    contact = fx.Contact(scene.parts[0], fx.RigidPlane((0.0, -0.01), (0.0, 1.0)))
    with pytest.raises(ValueError, match="does not tell its gaps; use PairContact"):
        found(replace(scene, joints=(), contacts=[contact]))
