"""Full compatibility by shared unknowns: two meshes with common nodes are one model."""

from __future__ import annotations

import numpy as np
import pytest
from helpers import distance, move_at_random, tangents
from test_joints import member

import sheetfx as fx
from sheetfx.discrete.discretisation import Discretisation


def twofold(twice: bool, supports=lambda m: [fx.clamp(m, "start")], load=(0.3, 0.4, 0.5), **scene):
    """A beam in space of double stiffness: by one of double width, or by two that share all their nodes."""
    ends = (0.0, 0.0, 0.0), (1.0, 0.0, 0.0)
    meshes = [member(*ends, dimension=3) for _ in range(1 + twice)]
    material = fx.Elastic(1.2e5 * (2 - twice), 0.0, density=1.0 * (2 - twice))
    beams = [fx.Beam(m, fx.Rectangle(0.1, 0.1), material) for m in meshes]
    joints = [fx.Compatible(meshes[1], meshes[0])] if twice else []
    return fx.Scene(beams, supports(meshes[-1]), [fx.PointForce(meshes[-1], "end", load)],
                    fx.Monitor(meshes[-1], "middle", "z"), joints=joints, **scene)


TURNED = [[0.8, 0.6, 0.0], [-0.6, 0.8, 0.0], [0.0, 0.0, 1.0]]


@pytest.mark.parametrize("supports", [
    lambda m: [fx.clamp(m, "start")],
    lambda m: [fx.pin(m, "start"), fx.Support(m, "start", "rx"), fx.Support(m, "end", "y z")],
], ids=["clamped", "partly fixed rotation"])
def test_two_beams_on_the_same_nodes_are_one(supports):
    """Supports, loads and the monitor of the mesh whose unknowns are eliminated reach the other one."""
    found = []
    for twice in (False, True):
        record = fx.trace(fx.Case(twofold(twice, supports), fx.LoadControl(0.25)))
        found.append([record.states[-1].deflection, *record.displacement("middle", record.case.scene.parts[-1].mesh),
                      *(v.squared for v in record.frequencies(record.states[-1], 3)),
                      *(b.factor for b in record.buckling(record.states[0], count=2))])
    assert found[1] == pytest.approx(found[0], rel=1e-8)


def test_axes_of_supports_are_shared():
    """A support along axes of its own on the kept mesh holds the eliminated nodes along them too."""
    def supports(mesh):
        return [fx.clamp(mesh, "start"), fx.Support(mesh, "end", "y", axes=TURNED)]

    one = fx.trace(fx.Case(twofold(False, supports), fx.LoadControl(0.25)))
    scene = twofold(True)
    kept = scene.parts[0].mesh
    scene = fx.Scene(scene.parts, supports(kept), scene.loads, scene.monitor, joints=scene.joints)
    two = fx.trace(fx.Case(scene, fx.LoadControl(0.25)))
    assert two.states[-1].deflection == pytest.approx(one.states[-1].deflection, rel=1e-9)
    own = scene.parts[1].mesh
    with pytest.raises(ValueError, match="share the unknowns of another mesh; name a"):
        fx.Path(fx.Scene(scene.parts, supports(own), scene.loads, scene.monitor, joints=scene.joints))


def test_critical_points_are_those_of_one_model():
    """A column of two meshes that meet in its middle: bifurcations, Koiter's b, branches."""
    options = {"section": fx.Rectangle(0.01, 0.01), "material": fx.Elastic(1e9, density=1.0)}
    found = []
    for shared in (True, False):
        meshes = [member((0.0, 0.0), (0.5 if shared else 1.0, 0.0), elements=8 if shared else 16)]
        joints = []
        if shared:
            meshes.append(member((0.5, 0.0), (1.0, 0.0), elements=8))
            joints = [fx.Compatible(meshes[1], meshes[0])]
        scene = fx.Scene([fx.Beam(m, **options) for m in meshes],
                         [fx.pin(meshes[0], "start"), fx.Support(meshes[-1], "end", "y")],
                         [fx.PointForce(meshes[-1], "end", (-1.0, 0.0))],
                         fx.Monitor(meshes[0], "end" if shared else "middle", "y"), joints=joints)
        record = fx.trace(fx.Case(scene, fx.LoadControl(3.0, target=36.0)))
        points = record.critical_points
        (branch, _) = record.branches(points[0])
        rise = points[0].curvature * branch.amplitude**2
        assert branch.start.load / points[0].load - 1 == pytest.approx(rise, rel=0.05)
        found.append([*(p.load for p in points), *(p.curvature for p in points),
                      *(v.squared for v in record.frequencies(record.states[1], 3))])
    assert len(found[0]) == len(found[1]) == 7
    assert found[0] == pytest.approx(found[1], rel=2e-6)


def test_hinge_of_shared_displacements():
    """The middle of a beam on two supports hinges where rotations are not shared: it can only hang as two ropes."""
    left, right = member((-1.0, 0.0), (0.0, 0.2), elements=2), member((1.0, 0.0), (0.0, 0.2), elements=2)
    stocky = {"section": fx.Rectangle(1.0, 1.0), "material": fx.Elastic(1.0, 0.0)}
    scene = fx.Scene([fx.Beam(m, **stocky) for m in (left, right)], [fx.pin(m, "start") for m in (left, right)],
                     [fx.PointForce(left, "end", (0.0, -1.0))], fx.Monitor(right, "end", "y", -1.0),
                     joints=[fx.Compatible(right, left, "end", rotations=False)])
    record = fx.trace(fx.Case(scene, fx.ArcLength(0.01), fx.Until(deflection=0.2)))
    length, base = np.hypot(1.0, 0.2), 1.0
    at_limit = (length * base**2) ** (1 / 3)
    exact = 2 * (length - at_limit) / length * np.sqrt(at_limit**2 - base**2) / at_limit
    assert record.critical_points[0].load == pytest.approx(exact, rel=1e-9), "von Mises truss, closed form"


@pytest.mark.slow
def test_tangent_is_the_derivative():
    """Beams that share unknowns, with forms and point work on the eliminated ones, far from equilibrium."""
    scene = twofold(True)
    own, kept = scene.parts[1].mesh, scene.parts[0].mesh
    joints = [*scene.joints, fx.Spring(own, "middle", "rx", 3.0), fx.Foundation(scene.parts[1], (0.0, 2.0, 3.0)),
              fx.Spring(own, "middle", "y", 2.0, (kept, "end"))]
    discretisation = Discretisation(fx.Scene(scene.parts, scene.supports, scene.loads, scene.monitor, joints=joints),
                                    mixed_points=False)
    x = move_at_random(discretisation)
    assembled, differences = tangents(discretisation.system, x)
    assert distance(assembled, assembled.T) < 1e-13
    assert distance(assembled + assembled.T, differences + differences.T) < 1e-7


def test_misuse_is_named():
    one, other, far = (member((x, 0.0), (x + 1.0, 0.0)) for x in (0.0, 0.0, 5.0))
    with pytest.raises(ValueError, match="joins a mesh to itself"):
        fx.Compatible(one, one)
    with pytest.raises(ValueError, match="no point, edge or group of cells named 'top'"):
        fx.Compatible(one, other, "top")

    def scene(*joints):
        meshes = (one, other, far)
        return fx.Scene([fx.Beam(m, fx.Rectangle(0.1, 0.1), fx.Elastic(1.0)) for m in meshes],
                        [fx.clamp(m, "start") for m in meshes], [fx.PointForce(one, "end", (0.0, 1.0))],
                        fx.Monitor(one, "end", "y"), joints=joints)

    with pytest.warns(UserWarning, match="nothing joins"), pytest.raises(ValueError, match="no node of beam 1, beam 2"):
        fx.Path(scene(fx.Compatible(far, other)))
    with pytest.warns(UserWarning, match="nothing joins"), pytest.raises(ValueError, match="share others' themselves"):
        fx.Path(scene(fx.Compatible(one, other), fx.Compatible(other, one)))


def test_modes_and_shares_of_energy():
    """At Euler's load both halves of a column store as much."""
    meshes = [member((0.0, 0.0), (0.5, 0.0), elements=8), member((0.5, 0.0), (1.0, 0.0), elements=8)]
    beams = [fx.Beam(m, fx.Rectangle(0.01, 0.01), fx.Elastic(1e9)) for m in meshes]
    scene = fx.Scene(beams, [fx.pin(meshes[0], "start"), fx.Support(meshes[1], "end", "y")],
                     [fx.PointForce(meshes[1], "end", (-1.0, 0.0))], fx.Monitor(meshes[0], "end", "y"),
                     joints=[fx.Compatible(meshes[1], meshes[0])])
    record = fx.trace(fx.Case(scene, fx.LoadControl(3.0, target=12.0)))
    (point,) = record.critical_points
    modes = record.critical_modes(point)
    assert len(modes) == 1
    assert record.energy_shares(modes) == pytest.approx([0.5, 0.5], rel=1e-6)
    with pytest.raises(ValueError, match="critical_modes: the states of steps .* are missing"):
        fx.Record(record.case, record.path, record.states[:1]).critical_modes(point)


def seam(cells, forms, at=None):
    """Tip of a plate in two halves whose nodes along the seam are shared."""
    def half(count, way, form):
        mesh = fx.read(lambda: fx.meshes.rectangle((2, count), (0.5, 0.4)), 3, 2, lambda x: x + np.array((way, 0, 0)))
        return fx.Shell(mesh, fx.Plate(0.03), fx.Elastic(2e4, 0.3), form=form)

    parts = [half(*one) for one in zip(cells, (0.0, 0.5), forms, strict=True)]
    left, right = (part.mesh for part in parts)
    scene = fx.Scene(parts, [fx.clamp(left, "west")], [fx.EdgeForce(right, "east", (0.0, 0.0, 0.05))],
                     fx.Monitor(right, "north-east", "z"), joints=[fx.Compatible(left, right, at)])
    return fx.Path(scene)


@pytest.mark.silent("g03")
@pytest.mark.parametrize(("cells", "forms", "alone"), [
    ((2, 2), ("naghdi-q2", "naghdi-q2"), 0), ((2, 2), ("naghdi-q3", "naghdi-q3"), 0),
    ((2, 2), ("naghdi-q2", "naghdi-q3"), 2), ((2, 2), ("naghdi-q3", "naghdi-q2"), 4),
    ((2, 4), ("naghdi-q2", "naghdi-q2"), 4), ((4, 2), ("naghdi-q2", "naghdi-q2"), 4),
    ((2, 3), ("naghdi-q2", "naghdi-q2"), 2)])
@pytest.mark.parametrize("at", [None, "east"])
@pytest.mark.slow(quick=2)
def test_nodes_without_a_partner_on_a_seam_are_told(cells, forms, alone, at, recwarn):
    seam(cells, forms, at)
    said = [str(w.message) for w in recwarn if "gape between common nodes" in str(w.message)]
    assert len(said) == bool(alone)
    assert not alone or said[0].startswith(f"Compatible: {alone} nodes of shell stand on shell where it has no node")
