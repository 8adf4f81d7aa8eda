"""States on other meshes, degrees and models."""

from __future__ import annotations

import numpy as np
import pytest
from helpers import cantilever, follow, on_two_processes, shallow_arch, straight

import sheetfx as fx
from sheetfx import meshes
from sheetfx.discrete.discretisation import Discretisation
from sheetfx.scenes import cantilever as strip
from sheetfx.scenes import cylinder_panel, deep_arch, dome, lee_frame, roof, sinusoidal_arch, slit_annulus


def energy(scene, state):
    discretisation = Discretisation(scene)
    discretisation.system.restore(state.fields)
    return sum(discretisation.strain_energy(part) for part in scene.parts)


def bent(cells, degree=3, dimension=2):
    turned = {"up": (0.0, 0.0, 1.0)} if dimension == 3 else {}
    return cantilever(straight(cells, dimension=dimension),
                      lambda beam: [fx.PointForce(beam.mesh, "tip", (0.0, 1e-3, 2e-3)[:dimension])],
                      degree=degree, **turned)


def stretched(cells, form):
    """A strip without lateral contraction under an axial force: strains are uniform."""
    scene = strip.case(cells=cells, form=form).scene
    mesh = scene.meshes[0]
    return fx.Scene(scene.parts, [fx.Support(mesh, "west", "x y z rx ry rz")],
                    [fx.EdgeForce(mesh, "east", (1e4, 0.0, 0.0))], fx.Monitor(mesh, "tip", "x"))


@pytest.mark.parametrize("make", [
    lambda n: bent(n), lambda n: bent(n, dimension=3), lambda n: stretched(n, "naghdi-q2"),
    lambda n: stretched(n, "naghdi-t2")], ids=["planar beam", "beam", "quadrilaterals", "triangles"])
@pytest.mark.slow(quick=1)
def test_energy_on_a_nested_mesh(make):
    """Where strains are among those that the forms assume, and rotations small or none: the same."""
    coarse, fine = make(3), make(6)
    state = follow(coarse, fx.LoadControl(0.5)).states[-1]
    assert energy(fine, state.on(fine)) == pytest.approx(energy(coarse, state), rel=1e-10)


@pytest.mark.parametrize("one, other", [
    (lambda: roof.case(cells=4).scene, lambda: roof.case(cells=6).scene),
    (lambda: roof.case(cells=4, form="naghdi-q2").scene, lambda: roof.case(cells=4).scene),
    (lambda: roof.case(cells=4).scene, lambda: roof.case(cells=6, form="naghdi-t2").scene),
    (lambda: roof.case(cells=4).scene, lambda: roof.case(cells=4, thickness=12.4).scene)],
    ids=["mesh", "degree", "triangles", "thickness"])
@pytest.mark.parametrize("with_mode", [True, False])
@pytest.mark.slow(quick=1)
def test_limit_points_directly_on_the_other_mesh(one, other, with_mode):
    record = follow_roof(one())
    point = record.critical_points[0]
    state, target = record.state_at(point), other()
    guess, modes = fx.transferred(state, target, record.critical_modes(point))
    found = fx.critical(target, guess, modes if with_mode else None, kind="limit")
    wanted = follow_roof(target).critical_points[0]
    assert found.point.load == pytest.approx(wanted.load, rel=1e-8)
    assert found.point.deflection == pytest.approx(wanted.deflection, rel=1e-6)


def follow_roof(scene):
    case = roof.case()
    return fx.trace(fx.Case(scene, case.control, fx.Until(deflection=15.0)))


@pytest.mark.parametrize("make, cells, count", [
    (lambda n: lee_frame.case(elements=n), (10, 20), 2), (lambda n: deep_arch.case(elements=n), (20, 40), 2),
    (lambda n: sinusoidal_arch.case(elements=n), (8, 16), 3),
    pytest.param(lambda n: cylinder_panel.case(cells=(n, n)), (4, 8), 2, marks=pytest.mark.slow),
    pytest.param(lambda n: dome.case(divisions=n), (4, 8), 2, marks=pytest.mark.slow)],
    ids=["Lee frame", "deep arch", "sinusoidal arch", "cylindrical panel", "coupled dome"])
@pytest.mark.slow(quick=1)
def test_points_of_every_kind_directly_on_twice_as_many_cells(make, cells, count):
    """By their modes, in at most seven factorisations, beams from guesses that interpolation strains much."""
    coarse, fine = (make(n) for n in cells)
    record, wanted = fx.trace(coarse), fx.trace(fine)
    found = []
    for point in record.critical_points[:count]:
        guess, modes = fx.transferred(record.state_at(point), fine.scene, record.critical_modes(point))
        found.append(fx.critical(fine.scene, guess, modes, kind=point.kind))
        assert found[-1].factorisations <= 7
    for one, like in zip(in_order(f.point for f in found), in_order(wanted.critical_points[:count]), strict=True):
        assert one.kind == like.kind
        assert one.load == pytest.approx(like.load, rel=1e-8)


def in_order(points):
    """Of their loads: points close together may come in another order on another mesh."""
    return sorted(points, key=lambda point: point.load)


def test_the_same_scene_goes_on_alike():
    scene = shallow_arch(12)
    record = follow(scene, fx.ArcLength(0.01), deflection=8.0)
    state, own = record.states[2].on(scene), record.states[2]
    assert state.load == pytest.approx(own.load, rel=1e-12)
    assert state.response == pytest.approx(own.response, rel=1e-6, abs=1e-9 * np.abs(own.response).max())
    assert all(np.array_equal(state.fields[name], values) for name, values in own.fields.items() if name != "load")
    points = [p for s in fx.Path(scene, fx.ArcLength(0.01), fx.Until(deflection=8.0), start=[state])
              for p in s.critical]
    assert [p.load for p in points] == pytest.approx([p.load for p in record.critical_points], rel=1e-8)


def test_a_path_goes_on_upon_a_finer_mesh():
    """From halfway to the limit point: the limit point of the finer mesh."""
    coarse, fine = shallow_arch(10), shallow_arch(20)
    state = follow(coarse, fx.ArcLength(0.01), deflection=2.0).states[-1]
    points = [p for s in fx.Path(fine, fx.ArcLength(0.01), fx.Until(deflection=10.0), start=[state.on(fine)])
              for p in s.critical]
    wanted = follow(fine, fx.ArcLength(0.01), deflection=10.0).critical_points
    assert [p.load for p in points] == pytest.approx([p.load for p in wanted], rel=1e-7)


def test_lips_of_a_slit_stay_apart():
    """Nodes upon each other, one clamped and the other lifted: each comes from its own side."""
    one, other = (slit_annulus.case(cells=n, form="naghdi-q2", load=0.05) for n in (10, 20))
    record = fx.trace(one)
    state = record.states[-1].on(other.scene)
    mesh = other.scene.meshes[0]
    discretisation = Discretisation(other.scene)
    discretisation.system.restore(state.fields)
    kinematics = discretisation.kinematics(mesh)
    at = {name: kinematics.displacement(mesh, name)[2] for name in ("A", "B")}
    own = record.path.discretisation.kinematics(one.scene.meshes[0])
    record.path.tracer.back_to(record.states[-1])
    for name, lifted in at.items():
        assert lifted == pytest.approx(own.displacement(one.scene.meshes[0], name)[2], rel=1e-10)
    lowest, highest = (np.array([f(k.u.x.array.reshape(-1, 3)[:, 2]) for k in (kinematics, own)])
                       for f in (np.min, np.max))
    assert lowest[0] == pytest.approx(lowest[1], rel=0.05) and highest[0] == pytest.approx(highest[1], rel=0.05)


def leaves(cells):
    """Two strips upon each other in groups of one mesh, of which the upper is pulled."""
    nodes = {"a": (0, 0, 0), "b": (1, 0, 0), "c": (1.0, 1e-9, 0), "d": (0, 1e-9, 0)}
    mesh = fx.read(lambda: meshes.frame(nodes, {"lower": ("a", "b", cells), "upper": ("d", "c", cells)}), 3)
    parts = [fx.Beam(mesh, fx.Rectangle(0.1, 0.1), fx.Elastic(1e3), up=(0.0, 0.0, 1.0), group=name)
             for name in ("lower", "upper")]
    return fx.Scene(parts, [fx.clamp(mesh, "a"), fx.clamp(mesh, "d")], [fx.PointForce(mesh, "c", (0.0, 0.0, 1e-3))],
                    fx.Monitor(mesh, "c", "z"))


def test_groups_upon_each_other_stay_apart():
    coarse, fine = leaves(3), leaves(5)
    state = follow(coarse, fx.LoadControl(1.0)).states[-1].on(fine)
    discretisation = Discretisation(fine)
    discretisation.system.restore(state.fields)
    kinematics, mesh = discretisation.kinematics(fine.meshes[0]), fine.meshes[0]
    assert kinematics.displacement(mesh, "b") == pytest.approx(np.zeros(3), abs=1e-15)
    assert kinematics.displacement(mesh, "c")[2] == pytest.approx(state.deflection, rel=1e-12)


def plastic(cells):
    return cantilever(straight(cells), lambda beam: [fx.PointForce(beam.mesh, "tip", (12.0, 0.0))], "x",
                      section=fx.Rectangle(0.1, 0.1, points=10),
                      material=fx.Plastic(1e5, 0.0, yield_stress=1000.0, hardening=1e3))


def test_what_points_remember():
    """A bar drawn beyond its yield: strains that stay are uniform, and unloading goes on with them."""
    coarse, fine = plastic(3), plastic(5)
    state = follow(coarse, fx.LoadControl(0.1)).states[-1]
    guess = state.on(fine)
    back = fx.LoadControl(0.1, target=0.0)
    ends = [[*fx.Path(scene, back, start=[one])][-1] for scene, one in ((coarse, state), (fine, guess))]
    assert ends[0].deflection > 0.01
    assert ends[1].deflection == pytest.approx(ends[0].deflection, rel=1e-6)


def test_what_supports_hold_is_put_back():
    """A state of a free edge, on a scene that holds it, and rotations of which one component is held."""
    scene = strip.case(cells=4).scene
    mesh = scene.meshes[0]
    loads, monitor = [fx.EdgeForce(mesh, "east", (1.0, 0.2, 4.0))], fx.Monitor(mesh, "tip", "x")
    held = fx.Scene(scene.parts, [*scene.supports, fx.Support(mesh, "east", "z rx")], loads, monitor)
    free = fx.Scene(scene.parts, scene.supports, loads, monitor)
    state = follow(free, fx.LoadControl(0.05, target=0.1)).states[-1].on(held)
    discretisation = Discretisation(held)
    discretisation.system.restore(state.fields)
    kinematics = discretisation.kinematics(mesh)
    assert kinematics.displacement(mesh, "tip")[2] == 0.0
    field = kinematics.block.fields[1]
    turned = field.table[field.partly_fixed.nodes]
    assert np.abs(turned[:, 2]).max() > 1e-3
    assert field.partly_fixed.nearest(turned) == pytest.approx(turned, abs=1e-14)
    assert np.linalg.norm(field.table, axis=1) == pytest.approx(1.0, abs=1e-14)


@pytest.mark.slow
def test_two_processes():
    lines = on_two_processes("""
import sheetfx as fx
from sheetfx.scenes import roof
from test_transfer import follow_roof
record, target = follow_roof(roof.case(cells=4).scene), roof.case(cells=6).scene
point = record.critical_points[0]
guess, modes = fx.transferred(record.state_at(point), target, record.critical_modes(point))
print(repr(float(fx.critical(target, guess, modes, kind="limit").point.load)))
""")
    wanted = follow_roof(roof.case(cells=6).scene).critical_points[0].load
    assert float(lines[-1]) == pytest.approx(wanted, rel=1e-8)


def test_refusals(tmp_path):
    scene, other = shallow_arch(6), strip.case(cells=4).scene
    state = follow(scene, fx.LoadControl(0.5, target=0.5)).states[-1]
    with pytest.raises(ValueError, match="as many dimensions"):
        state.on(other)
    state.save(tmp_path / "state.npz")
    read = type(state).load_from(tmp_path / "state.npz")
    with pytest.raises(ValueError, match="does not know its scene"):
        read.on(scene)
    path = fx.Path(scene, start=[read])
    assert path.start[-1].on(shallow_arch(12)).load == pytest.approx(state.load, rel=1e-12)
