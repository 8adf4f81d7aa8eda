"""Linear buckling against theory: bars, plates, cylinders, and nonlinear states near a bifurcation."""

import re
import warnings
from dataclasses import replace
from math import pi

import numpy as np
import pytest
from helpers import follow, hinged_arch, ring_under_pressure, whole_arch

import sheetfx as fx
from sheetfx import meshes
from sheetfx.case import trace
from sheetfx.continuation.control import ArcLength, LoadControl
from sheetfx.critical.buckling import buckling, clusters
from sheetfx.critical.modes import mode_displacement
from sheetfx.mesh.imperfection import imperfect
from sheetfx.mesh.reader import read
from sheetfx.model.beam import Beam
from sheetfx.model.loads import LineForce, PointForce, PrescribedDisplacement
from sheetfx.model.scene import Monitor, Scene
from sheetfx.model.section import Elastic, round_bar
from sheetfx.model.supports import Support, clamp, pin
from sheetfx.path import Path, Until
from sheetfx.scenes import cylinder_buckling, plate_buckling
from sheetfx.show.modes import draw_modes, mode_files

COLUMN = Elastic(1e7, 0.3)
EULER = pi**2 * 1e7 * pi * 0.01**4 / 64


def column(force=-1.0, elements=10, supports=None):
    """Round bar of length 1 along x, clamped at its base."""
    mesh = read(lambda: meshes.frame({"base": (0, 0), "tip": (1, 0)}, {"bar": ("base", "tip", elements)}), 3)
    bar = Beam(mesh, round_bar(0.01), COLUMN)
    return Scene([bar], supports(mesh) if supports else [clamp(mesh, "base")],
                 [PointForce(mesh, "tip", (force, 0.0, 0.0))], Monitor(mesh, "tip", "x", -1.0))


def unloaded(scene, **options):
    path = Path(scene)
    return path, buckling(path, path.tracer.state, **options)


@pytest.fixture(scope="module")
def swaying_arch():
    """Path of the shallow arch on hinges with its bifurcation, before its limit load."""
    return follow(hinged_arch(whole_arch(20)), ArcLength(step=0.003), 8.0)


def at_load(record, load):
    """Path and state of the same scene at a load."""
    other = follow(record.case.scene, LoadControl(step=load / 6, target=load))
    return other.path, other.states[-1]


def test_column_has_double_loads():
    """Euler's loads of a cantilever, (2 n - 1)^2 pi^2 EI / 4, twice each; 0.1 %: shear and two-noded cells."""
    _, loads = unloaded(column(), count=3)
    assert [b.cluster for b in loads] == [0, 0, 1, 1]
    assert [b.multiplicity for b in loads] == [2, 2, 2, 2]
    assert [b.factor for b in loads] == pytest.approx([EULER / 4] * 2 + [9 * EULER / 4] * 2, rel=2e-3)
    assert all(b.residual < 1e-4 for b in loads)


def test_both_signs_of_the_load():
    """A pulled column buckles at negative factors; totals have the sign of the factor."""
    _, pushed = unloaded(column(), count=2)
    _, pulled = unloaded(column(2.0), count=2)
    assert [-2 * b.factor for b in pulled] == pytest.approx([b.factor for b in pushed], rel=1e-8)
    assert [b.load for b in pulled] == pytest.approx([2 * b.factor for b in pulled], rel=1e-12)


def test_loads_of_both_signs_in_one_list():
    """A column pushed at its middle, between ends that are both held: both halves are alike, one is pulled."""
    nodes = {"base": (0, 0), "middle": (1, 0), "tip": (2, 0)}
    mesh = read(lambda: meshes.frame(nodes, {"a": ("base", "middle", 8), "b": ("middle", "tip", 8)}), 2)
    bar = Beam(mesh, round_bar(0.01), COLUMN)
    _, loads = unloaded(Scene([bar], [pin(mesh, "base"), pin(mesh, "tip")],
                              [PointForce(mesh, "middle", (-1.0, 0.0))], Monitor(mesh, "middle", "x")), count=4)
    assert [np.sign(b.factor) for b in loads[:2]] in ([1, -1], [-1, 1])
    assert loads[0].factor == pytest.approx(-loads[1].factor, rel=1e-6)
    assert loads[0].cluster != loads[1].cluster


def test_modes_with_other_supports():
    """A column whose tip slides in line: modes held sideways at the tip have Euler's second case."""
    def free(mesh):
        return [Support(mesh, "base", "x y z rx")] + [Support(mesh, "tip", "y z")]

    path = Path(column(supports=free))
    mesh = path.scene.parts[0].mesh
    clamped = [clamp(mesh, "base"), Support(mesh, "tip", "y z")]
    state = path.tracer.state
    assert buckling(path, state, 1)[0].factor == pytest.approx(EULER, rel=2e-3)
    assert buckling(path, state, 1, supports=clamped)[0].factor == pytest.approx(2.0457 * EULER, rel=3e-3)


def turned(angle):
    """Directions of x, y and z turned about the column."""
    return np.array([[1, 0, 0], [0, np.cos(angle), np.sin(angle)], [0, -np.sin(angle), np.cos(angle)]])


@pytest.mark.parametrize("own", [None, turned(0.9)], ids=["along space", "along axes of their own"])
@pytest.mark.parametrize("angle", [0.0, 0.5, -1.2])
def test_modes_with_other_supports_along_axes_of_their_own(own, angle):
    """A tip held along one direction across: modes across it are those of a cantilever, along it Euler's second case.

    The column is round, so that neither the direction nor the axes of the supports of the path change the loads.
    """
    def slides(mesh):
        return [clamp(mesh, "base"), Support(mesh, "tip", "y z ry", own)]

    path = Path(column(supports=slides))
    mesh, state, axes = path.scene.parts[0].mesh, path.tracer.state, turned(angle)
    found = buckling(path, state, 3, supports=[clamp(mesh, "base"), Support(mesh, "tip", "y", axes)])
    assert [b.factor / EULER for b in found] == pytest.approx([1 / 4, 2.0457, 9 / 4], rel=3e-3)
    for mode, direction in zip(found, (axes[2], axes[1], axes[2]), strict=True):
        table = mode_displacement(path, mesh, mode).x.array.reshape(-1, 3)
        largest = table[np.linalg.norm(table, axis=1).argmax()]
        assert abs(largest @ direction) == pytest.approx(1.0, abs=1e-6)
        assert table - np.outer(table @ direction, direction) == pytest.approx(0 * table, abs=1e-6)


@pytest.mark.parametrize("fixed", ["x y z rx", "x y z rx ry rz"])
def test_modes_about_a_bent_state_do_not_depend_on_the_axes_of_supports(fixed):
    """The same supports along other axes, about a column that has bent and twisted far."""
    scene = column(supports=lambda mesh: [Support(mesh, "base", fixed), Support(mesh, "tip", "y z")])
    mesh = scene.parts[0].mesh
    middle = PointForce(mesh, "tip", (-0.5 * EULER, 0.0, 0.0))
    across = LineForce(scene.parts[0], (0.0, 3.0 * EULER, 1.0 * EULER))
    path = Path(replace(scene, loads=[middle, across]), LoadControl(step=0.25))
    *_, state = path
    other = [Support(mesh, "base", fixed, turned(0.7)), Support(mesh, "tip", "y z", turned(-0.4))]
    ones, others = buckling(path, state, 3), buckling(path, state, 3, supports=other)
    assert [b.factor for b in others] == pytest.approx([b.factor for b in ones], rel=1e-8)
    for one, same in zip(ones, others, strict=True):
        shapes = [mode_displacement(path, mesh, mode).x.array for mode in (one, same)]
        assert shapes[1] == pytest.approx(shapes[0], abs=1e-6)


def test_response_is_that_of_the_supports_of_the_path():
    """A column loaded at its middle: what holds its tip along the axis in buckling has not stretched its upper half."""
    nodes = {"base": (0, 0), "middle": (1, 0), "tip": (2, 0)}
    mesh = read(lambda: meshes.frame(nodes, {"a": ("base", "middle", 8), "b": ("middle", "tip", 8)}), 2)
    held, slides = [pin(mesh, "base"), pin(mesh, "tip")], [pin(mesh, "base"), Support(mesh, "tip", "y")]
    force, monitor = PointForce(mesh, "middle", (-1.0, 0.0)), Monitor(mesh, "middle", "x")
    path, other = (Path(Scene([Beam(mesh, round_bar(0.01), COLUMN)], s, [force], monitor)) for s in (slides, held))
    sliding, alike, pulled = (buckling(p, p.tracer.state, 1, supports=s)[0].factor for p, s in (
        (path, None), (path, held), (other, held)))
    assert sliding == pytest.approx(alike, rel=1e-8)
    assert abs(pulled) > 1.2 * sliding


def test_column_under_its_own_weight():
    """7.8373 EI / L^3 (Timoshenko and Gere 1961, section 2.12); 0.2 %."""
    scene = column()
    bar = scene.parts[0]
    dead = replace(scene, loads=[LineForce(bar, (-1.0, 0.0, 0.0))])
    assert unloaded(dead, count=1)[1][0].factor == pytest.approx(7.8373 * EULER / pi**2, rel=2e-3)


def test_ring_under_pressure():
    """A follower load that stays normal to a ring: 3 EI / R^3, with an unsymmetric solver."""
    lowest = next(b for b in unloaded(ring_under_pressure(), count=2)[1] if b.factor > 0)
    assert lowest.factor == pytest.approx(3.0, rel=2e-3)


def test_prescribed_motion():
    """A column shortened by a prescribed motion, a multiplier in the tangent: the reaction along it is Euler's load."""
    scene = column()
    mesh = scene.parts[0].mesh
    loads = unloaded(replace(scene, loads=[PrescribedDisplacement(mesh, "tip", "x", -1.0)]), count=2)[1]
    assert [b.load for b in loads] == pytest.approx([EULER / 4] * 2, rel=2e-3)


def test_clusters():
    assert clusters([1.0, -1.0, 1.0005, 1.2, -1.2003, 1.2004], 1e-3) == [0, 1, 0, 2, 3, 2]


def test_no_buckling_load():
    path = Path(column(), mixed_points=False)
    with pytest.raises(ValueError, match="mixed_points"):
        buckling(path, path.tracer.state)


@pytest.mark.parametrize("prebuckling", [True, False])
def test_error_about_nonlinear_states_falls_quadratically(swaying_arch, prebuckling):
    """Half the distance to the bifurcation: a quarter of the error, in the limit."""
    bifurcation = next(p.load for p in swaying_arch.critical_points if p.kind == "bifurcation")
    errors = []
    for gap in (0.01, 0.005, 0.0025):
        path, state = at_load(swaying_arch, bifurcation * (1 - gap))
        errors.append(abs(buckling(path, state, 1, prebuckling=prebuckling)[0].load / bifurcation - 1))
    assert errors[1] < 0.3 * errors[0] and errors[2] < 0.3 * errors[1]
    assert errors[-1] < 2e-4


@pytest.mark.slow
def test_error_about_loaded_shells_falls_quadratically():
    """A cylinder whose ends are held before buckling; with the stress alone the error falls linearly."""
    scene = cylinder_buckling.case(cells=(6, 4)).scene
    mesh = scene.parts[0].mesh
    held = replace(scene, supports=[*scene.supports, *(Support(mesh, end, "x y rz") for end in ("south", "north"))])

    def about(factor, **options):
        path = Path(held, LoadControl(step=0.5, largest=1.0, target=factor))
        *_, state = path
        assert state.unstable_modes == 0
        return buckling(path, state, 1, **options)[0].factor

    bifurcation = about(0.7)
    for share in (0.98, 0.998):
        bifurcation = about(share * bifurcation)
    gaps = [bifurcation * 0.96, bifurcation * 0.98]
    full = [abs(about(g) / bifurcation - 1) for g in gaps]
    alone = [abs(about(g, prebuckling=False) / bifurcation - 1) for g in gaps]
    assert full[1] < 0.3 * full[0] and full[1] < 1e-3
    assert alone[1] > 0.4 * alone[0]


def test_stress_alone_from_afar(swaying_arch):
    """About the unloaded arch: 11 % with the stress alone, 46 % with the displacement of the response."""
    bifurcation = next(p.load for p in swaying_arch.critical_points if p.kind == "bifurcation")
    first = swaying_arch.states[0]
    alone, full = (buckling(swaying_arch.path, first, 1, prebuckling=p)[0].load for p in (False, True))
    assert abs(alone / bifurcation - 1) < 0.12 < abs(full / bifurcation - 1)


def test_unstable_state(swaying_arch):
    """Beyond the bifurcation the tangent is indefinite; the load passed lies behind the state."""
    bifurcation = next(p.load for p in swaying_arch.critical_points if p.kind == "bifurcation")
    path, state = at_load(swaying_arch, 1.01 * bifurcation)
    assert state.unstable_modes == 1
    nearest = buckling(path, state, 2)[0]
    assert nearest.increment < 0
    assert nearest.load == pytest.approx(bifurcation, rel=3e-3)


def test_path_goes_on_after_buckling(swaying_arch):
    """Buckling analyses between steps leave the path as it is."""
    path = Path(swaying_arch.case.scene, swaying_arch.case.control, swaying_arch.case.until)
    loads = []
    for state in path:
        buckling(path, state, 1, prebuckling=True)
        loads.append(state.load)
    assert loads == [s.load for s in swaying_arch.states]


def test_mode_as_imperfection(swaying_arch):
    """The arch with its first mode as imperfection sways, and its limit load is below the bifurcation."""
    scene = swaying_arch.case.scene
    mesh = scene.parts[0].mesh
    mode = buckling(swaying_arch.path, swaying_arch.states[0], 1)[0]
    shape = mode_displacement(swaying_arch.path, mesh, mode)
    assert np.linalg.norm(shape.x.array.reshape(-1, 2), axis=1).max() == pytest.approx(1.0)
    before = mesh.domain.geometry.x.copy()
    bent = imperfect(mesh, shape, 0.5)
    assert np.abs(bent.domain.geometry.x - before).max() == pytest.approx(0.5, rel=0.02)
    assert (mesh.domain.geometry.x == before).all()
    record = follow(hinged_arch(bent), ArcLength(step=0.003), 20.0)
    bifurcation = next(p.load for p in swaying_arch.critical_points if p.kind == "bifurcation")
    assert 0.8 * bifurcation < record.critical_points[0].load < bifurcation
    assert record.critical_points[0].kind == "limit"


def test_plate_with_its_mode_as_imperfection():
    """At half the buckling load a small imperfection has doubled (1 / (1 - N / N_cr), Timoshenko and Gere 1961)."""
    record = trace(plate_buckling.case(cells=4))
    mesh, scene = record.case.scene.parts[0].mesh, record.case.scene
    mode = record.buckling()[0]
    bent = imperfect(mesh, mode_displacement(record.path, mesh, mode), 1e-3)
    shell = replace(scene.parts[0], mesh=bent)
    loaded = Scene([shell], [replace(s, mesh=bent) for s in scene.supports],
                   [replace(load, mesh=bent) for load in scene.loads], replace(scene.monitor, on=bent))
    path = Path(loaded, LoadControl(step=mode.factor / 2, target=mode.factor / 2))
    *_, state = path
    deflection = path.discretisation.kinematics(bent).u.x.array[2::3]
    assert np.abs(deflection).max() == pytest.approx(1e-3, rel=2e-3)


@pytest.mark.parametrize("edges, expected", [
    ("simply-supported", 4.0), ("clamped-loaded", 6.7432), ("clamped-unloaded", 7.6913), ("free", 1.4016),
    ("clamped-free", 1.6525)])
@pytest.mark.slow(quick=1)
def test_square_plate(edges, expected):
    """Factors of Kirchhoff's plate within 0.1 %."""
    case = plate_buckling.case(edges=edges, cells=6)
    values = case.quantities(trace(case))
    assert values["theory"] == pytest.approx(expected, rel=1e-4)
    assert values["factor"] == pytest.approx(values["theory"], rel=1e-3)


@pytest.mark.parametrize("edges, aspect, expected", [
    ("simply-supported", 1.5, 4.3403), ("clamped-unloaded", 0.661, 6.9709), ("free", 4.0, 0.4860)])
@pytest.mark.slow(quick=1)
def test_long_plate(edges, aspect, expected):
    """The minimum over the number of half waves: k = 6.97 between clamped edges, 0.425 + (b/a)^2 with a free edge."""
    case = plate_buckling.case(edges=edges, aspect=aspect, cells=6)
    assert plate_buckling.buckling_factor(edges, aspect, 0.3) == pytest.approx(expected, rel=1e-4)
    assert case.quantities(trace(case))["factor"] == pytest.approx(expected, rel=1e-3)


def test_higher_modes_of_the_plate():
    """(m + 1/m)^2 and its generalisation (m + n^2 / m)^2 for m waves along and n across."""
    record = trace(plate_buckling.case(cells=6))
    expected = sorted((m + n * n / m) ** 2 for m in range(1, 9) for n in range(1, 6))[:6]
    assert [b.factor for b in record.buckling()] == pytest.approx(expected, rel=2e-3)


def test_pictures_and_files_of_beams(swaying_arch, tmp_path):
    """The modes about the last state of a path, here a planar one."""
    draw_modes(swaying_arch, tmp_path)
    mode_files(swaying_arch, tmp_path)
    assert (tmp_path / "modes.png").stat().st_size > 10000
    assert (tmp_path / "buckling.csv").exists()


def test_pictures_and_files(tmp_path):
    record = trace(plate_buckling.case(cells=4, count=2))
    mode_files(record, tmp_path)
    draw_modes(record, tmp_path)
    lines = (tmp_path / "buckling.csv").read_text().splitlines()
    assert len(lines) == 1 + len(record.buckling()) and lines[0].startswith("factor,load")
    assert (tmp_path / "modes.png").stat().st_size > 10000
    assert (tmp_path / "paraview" / "modes.pvd").exists()


def test_cylinder_cluster():
    """The classical load within 0.5 %, and its cluster of nine modes as the exact waves (0.1 %)."""
    case = cylinder_buckling.case()
    values = case.quantities(trace(case))
    assert values["factor"] == pytest.approx(1.0, rel=5e-3)
    assert values["cluster"] == 9
    assert values["largest_difference_percent"] < 0.1


@pytest.mark.slow
def test_cylinder_converges_to_its_waves():
    """A finer mesh: all loads within 0.01 % of the exact waves."""
    case = cylinder_buckling.case(cells=(32, 6), count=10)
    assert case.quantities(trace(case))["largest_difference_percent"] < 0.01


@pytest.mark.slow
@pytest.mark.parametrize("edges", plate_buckling.EDGES)
def test_plate_converges(edges):
    """The default mesh: 0.02 %."""
    case = plate_buckling.case(edges=edges)
    assert abs(case.quantities(trace(case))["difference_percent"]) < 0.02


def test_path_of_no_steps():
    record = trace(replace(plate_buckling.case(cells=2), until=Until(steps=0)))
    assert [s.step for s in record.states] == [0]
    with pytest.raises(ValueError, match="steps is -1; it must be zero or positive"):
        Until(steps=-1)


def loaded_column(preload, rigidity, joints=lambda mesh: ()):
    """A hinged column whose dead load is a part of Euler's, and a further load of 1 for that."""
    mesh = fx.read(lambda: fx.meshes.frame({"a": (0, 0), "b": (1, 0)}, {"m": ("a", "b", 6)}), 2)
    euler = np.pi**2 * 2e11 * 0.01**4 / 12
    push = [fx.PointForce(mesh, "b", (-share * euler, 0.0)) for share in (preload, 1.0)]
    scene = fx.Scene([fx.Beam(mesh, fx.Rectangle(0.01, 0.01), fx.Elastic(2e11, 0.3), shear_rigidity=rigidity)],
                     [fx.pin(mesh, "a"), fx.Support(mesh, "b", "y")], push[1:], fx.Monitor(mesh, "b", "x", -1.0),
                     joints=joints(mesh), stages=[fx.Stage(push[:1], "dead", fx.LoadControl(1.0, fixed=True))])
    return fx.trace(fx.Case(scene, fx.LoadControl(0.01), fx.Until(steps=2)))


@pytest.mark.silent("q04")
@pytest.mark.parametrize(("preload", "rigidity"), [(0.5, 1.0), (0.5, 1e3), (0.5, 1e4), (-1.0, 1e3)])
def test_tangents_that_are_not_linear_in_the_load_are_told(preload, rigidity):
    """Shear that is all but rigid adds the square of the axial strain; what is told is right to 0.5 %, and not 12."""
    record = loaded_column(preload, rigidity)
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        (load,) = record.buckling(record.states[-1], count=1)
        record.buckling(record.states[-1], count=1, prebuckling=False)
    left = 1 - preload - record.states[-1].factor
    if rigidity == 1.0:
        assert not told and load.increment == pytest.approx(left, rel=1e-3)
        return
    (one,) = told
    words = re.search(r"load factor is (\S+) instead of (\S+)\. ", str(one.message))
    to_second_order, linear = map(float, words.groups())
    assert linear == pytest.approx(load.increment, rel=1e-5)
    assert abs(linear / left - 1) > 1e-2
    assert to_second_order == pytest.approx(left, rel=5e-3)
    assert one.filename == __file__


@pytest.mark.silent("linear")
def test_contact_that_stays_is_told():
    def floor(mesh):
        return [fx.ObstacleContact(mesh, "m", fx.RigidPlane((0.0, -0.01), (0.0, 1.0)))]

    record = loaded_column(0.2, 1.0, floor)
    with pytest.warns(UserWarning, match="buckling: contact stays as it is in the state, where 0 points touch"):
        (load,) = record.buckling(record.states[-1], count=1)
    assert load.factor == pytest.approx(0.8, rel=1e-3), "as without the floor"
