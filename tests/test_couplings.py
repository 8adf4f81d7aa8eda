"""Rigid bodies and mean motions about a reference point, bolts over discs, and the forces of joints."""

from __future__ import annotations

import numpy as np
import pytest
from helpers import on_two_processes

import sheetfx as fx

STEEL = fx.Elastic(2e5, 0.3)


def stub(place=(0.0, 0.0, 1.0), long=0.1):
    """A short beam whose one end is a reference point."""
    x, y, z = place
    mesh = fx.read(lambda: fx.meshes.frame({"hub": place, "tip": (x, y, z + long)}, {"stub": ("hub", "tip", 1)}), 3)
    return fx.Beam(mesh, fx.Rectangle(1.0, 1.0), STEEL, up=(1, 0, 0))


def legs(stiff=(1.0, 2.0, 3.0, 4.0), places=((1, 1), (-1, 1), (-1, -1), (1, -1))):
    """Four upright bars of EA = 1000 times `stiff`, their tops, named one by one and all together, held sideways."""
    import gmsh

    def tops():
        fx.meshes.frame({f"{end}{i}": (*place, z) for i, place in enumerate(places) for end, z in (("g", 0), ("t", 1))},
                        {f"leg{i}": (f"g{i}", f"t{i}", 1) for i in range(4)})
        found = [tag for _, tag in gmsh.model.getEntities(0) if abs(gmsh.model.getValue(0, tag, [])[2] - 1) < 1e-9]
        gmsh.model.addPhysicalGroup(0, found, name="tops")

    mesh = fx.read(tops, 3)
    bars = [fx.Bar(mesh, fx.Rectangle(1.0, 1.0), fx.Elastic(1000.0 * k), group=f"leg{i}") for i, k in enumerate(stiff)]
    held = [fx.pin(mesh, f"g{i}") for i in range(4)] + [fx.Support(mesh, "tops", "x y")]
    return mesh, bars, held


def pressed(kind, force=(0.0, 0.0, -1.0), at="hub", scale=1e-3, **how):
    mesh, bars, held = legs()
    hub = stub()
    coupling = kind(hub.mesh, "hub", (mesh, "tops"), **how)
    held += [fx.Support(hub.mesh, "hub", "x y rz")] if how else []
    scene = fx.Scene([*bars, hub], held, [fx.PointForce(hub.mesh, at, tuple(scale * f for f in force))],
                     fx.Monitor(hub.mesh, "hub", "z"), joints=[coupling])
    record = fx.trace(fx.Case(scene, fx.LoadControl(1.0, fixed=True)))
    forces = [value / scale for bar in bars for value in record.forces(bar).ravel()]
    return record, forces, coupling


def test_mean_motion_shares_a_force_whatever_resists():
    """A quarter for each leg; the reference goes down by the mean of what they do."""
    record, forces, coupling = pressed(fx.DistributingCoupling)
    assert forces == pytest.approx([-0.25] * 4, rel=1e-4)
    mean = np.mean([1, 1 / 2, 1 / 3, 1 / 4])
    assert record.states[-1].deflection == pytest.approx(-1e-3 * 0.25 * mean / 1000, rel=1e-4)
    found = record.joint_forces(coupling, about=(0.0, 0.0, 1.0))
    assert found.force[-1] / 1e-3 == pytest.approx([0, 0, -1], abs=1e-6)


def test_mean_motion_shares_a_moment_by_the_levers():
    """A force along x at the stub's tip is a moment F h about y: pairs of F h / 4 at levers of 1."""
    _, forces, _ = pressed(fx.DistributingCoupling, (1.0, 0.0, 0.0), "tip")
    assert forces == pytest.approx(0.1 / 4 * np.array([-1, 1, 1, -1]), abs=1e-5)


def test_rigid_body_keeps_a_plane():
    """The tops stay in a plane: displacements, and their forces those of least energy with it."""
    record, forces, _ = pressed(fx.KinematicCoupling, held="z")
    down = np.array(forces) / np.array([1, 2, 3, 4])
    assert down[0] + down[2] == pytest.approx(down[1] + down[3], rel=1e-4)
    assert sum(forces) == pytest.approx(-1, rel=1e-4)
    places = np.array([(1, 1), (-1, 1), (-1, -1), (1, -1)])
    weights = np.column_stack((np.ones(4), places))
    stiffness = weights.T @ np.diag([1.0, 2, 3, 4]) @ weights
    assert down == pytest.approx(weights @ np.linalg.solve(stiffness, [-1, 0, 0]), rel=1e-3)


def test_rigid_head_turns_as_far_as_a_frame_does():
    """Two cantilevers with a rigid head, far beyond small rotations, beside a head that is a stiff beam."""
    def swayed(rigid):
        ends = {"a": (0, 0), "b": (0, 1), "c": (1, 0), "d": (1, 1)}
        bars = {"left": ("a", "b", 8), "right": ("c", "d", 8)} | ({} if rigid else {"head": ("b", "d", 4)})
        mesh = fx.read(lambda: fx.meshes.frame(ends, bars), 2)
        beams = [fx.Beam(mesh, fx.Rectangle(0.01, 0.01), STEEL, group=g) for g in ("left", "right")]
        beams += [] if rigid else [fx.Beam(mesh, fx.Rectangle(0.1, 0.1), STEEL, group="head")]
        return fx.trace(fx.Case(fx.Scene(
            beams, [fx.clamp(mesh, "a"), fx.clamp(mesh, "c")],
            [fx.PointForce(mesh, "b", (2e-3, 0.0)), fx.Moment(mesh, "b", -2e-3)], fx.Monitor(mesh, "b", "x"),
            joints=[fx.KinematicCoupling(mesh, "b", (mesh, "d"))] if rigid else []), fx.LoadControl())).states[-1]

    rigid = swayed(True).deflection
    assert rigid == pytest.approx(swayed(False).deflection, rel=3e-4) and rigid > 0.1


def lap(cells, radius=5.0, y=20.0, **how):
    """Two strips of 100 x 40 x 2 that lap by 40, joined by one bolt in the middle of the lap, and pulled by 1000."""
    lower, upper = (fx.read(lambda: fx.meshes.rectangle((4 * cells, 2 * cells), (100.0, 40.0)), 3, 2,
                            place=lambda x, off=off: x + np.array(off)) for off in ((0, 0, 0), (60, 0, 2)))
    strips = [fx.Shell(mesh, fx.Plate(2.0), STEEL) for mesh in (lower, upper)]
    bolt = fx.bolt(lower, fx.Disc((80.0, y, 0.0), radius, **how), (upper, None), reach=2.1)
    scene = fx.Scene(strips, [fx.clamp(lower, "west"), fx.Support(upper, "east", "y z ry")],
                     [fx.EdgeForce(upper, "east", (25.0, 0, 0))], fx.Monitor(upper, "north-east", "x"), joints=[bolt])
    return scene, bolt


@pytest.mark.slow
def test_bolt_over_a_disc_has_a_limit_and_a_force():
    """Its stiffness hardly depends on the mesh, that of a bolt at a point does; its force is what pulls."""
    found = []
    for cells in (3, 6):
        scene, bolt = lap(cells)
        record = fx.trace(fx.Case(scene, fx.LoadControl(1.0, fixed=True)))
        found.append(record.states[-1].deflection)
        on_second = record.joint_forces(bolt, about=(80.0, 20.0, 1.0))
        on_first = record.joint_forces(bolt, on=bolt.mesh, about=(80.0, 20.0, 1.0))
        assert on_second.force[-1][:2] == pytest.approx([-1000.0, 0.0], abs=1e-6)
        assert on_first.force[-1] == pytest.approx(-on_second.force[-1], abs=1e-6)
        assert on_first.moment[-1] == pytest.approx(-on_second.moment[-1], abs=1e-5)
    assert found[0] == pytest.approx(found[1], rel=4e-3)
    softer = fx.trace(fx.Case(lap(6, radius=2.5)[0], fx.LoadControl(1.0, fixed=True))).states[-1].deflection
    assert softer > 1.005 * found[1]


def test_forces_of_welds_springs_and_what_has_none():
    """Equilibrium of a beam of two welded halves and a spring at its end."""
    halves = [fx.read(lambda ends=ends: fx.meshes.frame(ends, {"l": (*ends, 4)}), 2)
              for ends in ({"a": (0, 0), "m": (1, 0)}, {"m": (1, 0), "b": (2, 0)})]
    beams = [fx.Beam(mesh, fx.Rectangle(0.1, 0.1), STEEL) for mesh in halves]
    weld, spring = fx.weld(halves[0], "m", (halves[1], "m")), fx.Spring(halves[1], "b", "y", 3.0)
    scene = fx.Scene(beams, [fx.clamp(halves[0], "a")], [fx.PointForce(halves[1], "b", (0.0, 1e-3))],
                     fx.Monitor(halves[1], "b", "y"), joints=[weld, spring])
    record = fx.trace(fx.Case(scene, fx.LoadControl()))
    up, last = record.states[-1].deflection, record.joint_forces(weld, about=(1.0, 0.0))
    assert last.force[-1] == pytest.approx([0.0, 3.0 * up - 1e-3], abs=1e-9)
    assert last.moment[-1] == pytest.approx([3.0 * up - 1e-3], rel=1e-3)
    assert record.joint_forces(spring, on=halves[1]).force[-1] == pytest.approx([0.0, -3.0 * up], abs=1e-9)
    with pytest.raises(ValueError, match="is on one mesh alone; name in `on`"):
        record.joint_forces(spring)
    with pytest.raises(ValueError, match="Spring: is no joint of this scene"):
        record.joint_forces(fx.Spring(halves[1], "b", "y", 3.0), on=halves[1])


def test_what_is_refused():
    mesh, bars, held = legs()
    hub = stub()
    with pytest.raises(ValueError, match="Disc at 'p': inner is 3, not below its radius 2"):
        fx.Disc("p", 2.0, 3.0)
    with pytest.raises(ValueError, match="its point .* off the surface; keep the disc of radius 5"):
        lap(2, y=39.0)
    with pytest.raises(ValueError, match="has 4 vertices; name a single point as the reference"):
        fx.KinematicCoupling(mesh, "tops", (hub.mesh, "hub"))
    load, monitor = fx.PointForce(hub.mesh, "hub", (0.0, 0, 1.0)), fx.Monitor(hub.mesh, "hub", "z")
    scene = fx.Scene([*bars, hub], held, [load], monitor, joints=[fx.KinematicCoupling(mesh, "t0", (hub.mesh, "hub"))])
    with pytest.raises(ValueError, match="the reference is on bars, which do not turn"):
        fx.Path(scene)
    two = fx.DistributingCoupling(hub.mesh, "hub", (mesh, "t0"))
    with pytest.raises(ValueError, match="are on a line"):
        fx.Path(fx.Scene([*bars, hub], held, scene.loads, scene.monitor, joints=[two]))
    turned = fx.KinematicCoupling(hub.mesh, "hub", (mesh, "tops"), held="z rx")
    with pytest.raises(ValueError, match="holds rx, but bars have no rotations"):
        fx.Path(fx.Scene([*bars, hub], held, scene.loads, scene.monitor, joints=[turned]))


@pytest.mark.slow
def test_on_two_processes():
    script = """
from test_couplings import fx, lap, pressed
record, forces, coupling = pressed(fx.DistributingCoupling)
scene, bolt = lap(3)
joined = fx.trace(fx.Case(scene, fx.LoadControl(1.0, fixed=True)))
rigid, _, _ = pressed(fx.KinematicCoupling, held="z")
print(*(r.states[-1].deflection for r in (record, rigid, joined)), *joined.joint_forces(bolt).force[-1])
"""
    *moved, x, y, z = map(float, on_two_processes(script)[0].split())
    own = [pressed(fx.DistributingCoupling)[0], pressed(fx.KinematicCoupling, held="z")[0],
           fx.trace(fx.Case(lap(3)[0], fx.LoadControl(1.0, fixed=True)))]
    assert moved == pytest.approx([r.states[-1].deflection for r in own], rel=1e-8)
    assert (x, y) == pytest.approx((-1000.0, 0.0), abs=1e-6)
