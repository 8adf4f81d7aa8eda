"""Free vibrations against closed forms, and the dynamic criterion of stability on a column."""

from dataclasses import replace
from math import pi

import numpy as np
import pytest
from helpers import cantilever, follow, on_two_processes, straight

from sheetfx import meshes
from sheetfx.continuation.control import LoadControl
from sheetfx.critical.modes import mode_displacement
from sheetfx.critical.vibration import frequencies
from sheetfx.mesh.reader import read
from sheetfx.model.beam import Beam
from sheetfx.model.loads import EdgeForce, LineForce, PointForce, PrescribedDisplacement
from sheetfx.model.plate import Plate
from sheetfx.model.scene import Monitor, Scene
from sheetfx.model.section import Elastic, Rectangle
from sheetfx.model.shell import Shell
from sheetfx.model.supports import Support, clamp, pin
from sheetfx.path import Path
from sheetfx.scenes import plate_buckling, von_mises_truss

STEEL, SECTION = Elastic(1e7, 0.3, density=2.0), Rectangle(0.02, 0.01)
BENDING, MASS = 1e7 * 0.02 * 0.01**3 / 12, 2.0 * 0.02 * 0.01
EULER = pi**2 * BENDING


def column(dimension=2, elements=16, turn=0.0, material=STEEL):
    """Bar of length 1 on two hinges, at an angle to x in the plane of x and y, pushed by a unit of force."""
    direction = np.array([np.cos(turn), np.sin(turn)])
    nodes = {"base": (0, 0), "tip": tuple(direction)}
    mesh = read(lambda: meshes.frame(nodes, {"beam": ("base", "tip", elements)}), dimension)
    along = np.append(direction, 0.0)[:dimension]
    axes = [along, [-along[1], along[0], 0.0], [0.0, 0.0, 1.0]] if turn else None
    tip = Support(mesh, "tip", "y" if dimension == 2 else "y z rx", axes=axes)
    bar = Beam(mesh, SECTION, material)
    return Scene([bar], [pin(mesh, "base"), tip], [PointForce(mesh, "tip", tuple(-along))],
                 Monitor(mesh, "tip", "x", -1.0))


def unloaded(scene, count):
    path = Path(scene)
    return path, frequencies(path, path.tracer.state, count)


def lowest_under(load):
    """Lowest squared frequency of the column under a load."""
    path = Path(column(), LoadControl(step=load, target=load))
    *_, state = path
    return frequencies(path, state, 1)[0].squared


def timoshenko(waves, second_moment=0.02 * 0.01**3 / 12):
    """Squared frequency of half waves on a hinged Timoshenko beam of length 1, the lower root of a quadratic.

    (kGA k^2 - m w) (EI k^2 + kGA - r w) = (kGA k)^2 with w = omega^2, wave number k and rotary inertia r.
    """
    number, shear = waves * pi, 5 / 6 * STEEL.shear_modulus * SECTION.area
    rotary, stiffness = STEEL.density * second_moment, STEEL.modulus * second_moment * number**2 + shear
    roots = np.roots([MASS * rotary, -(shear * number**2 * rotary + MASS * stiffness),
                      shear * number**2 * stiffness - (shear * number) ** 2])
    return min(roots)


def test_hinged_beam():
    """Half waves of a Timoshenko beam; 1e-3 for the third: 16 quadratic cells with two points."""
    _, found = unloaded(column(), 3)
    assert [v.squared for v in found] == pytest.approx([timoshenko(n) for n in (1, 2, 3)], rel=1e-3)
    assert found[0].squared == pytest.approx(EULER * pi**2 / MASS, rel=1e-3)
    assert found[0].frequency == pytest.approx(timoshenko(1) ** 0.5 / 2 / pi, rel=1e-4)


@pytest.mark.parametrize("turn", [0.0, 0.5])
def test_hinged_beam_in_space(turn):
    """Bending about both axes, the first two of each; a bar at an angle has supports with axes of their own."""
    _, found = unloaded(column(3, turn=turn), 4)
    deep, wide = 0.02 * 0.01**3 / 12, 0.01 * 0.02**3 / 12
    expected = sorted(timoshenko(n, i) for n in (1, 2) for i in (deep, wide))
    assert [v.squared for v in found[:3]] == pytest.approx(expected[:3], rel=1e-3)


def test_twist():
    """A clamped bar's twist, (pi/2)^2 GJ / (rho I_p), is not among the frequencies of bending."""
    mesh, section = straight(20, dimension=3), Rectangle(0.2, 0.1)
    path, found = unloaded(cantilever(mesh, lambda beam: [PointForce(mesh, "tip", (0.0, 1.0, 0.0))], section=section,
                                      material=STEEL), 6)
    twist = (pi / 2) ** 2 * STEEL.shear_modulus * section.torsion / (STEEL.density * sum(section.second_moments))
    assert min(abs(v.squared / twist - 1) for v in found) < 1e-3


def test_column_loses_its_frequency_at_the_critical_load():
    """omega^2 / omega_0^2 = 1 - P / P_critical, as the mode stays a half sine, and below zero beyond it; 0.1 %."""
    record = follow(column(), LoadControl(step=0.3 * EULER, target=1.2 * EULER))
    critical = next(p.load for p in record.critical_points if p.kind == "bifurcation")
    assert critical == pytest.approx(EULER, rel=1e-3)
    shares = np.array([0.3, 0.6, 0.9, 0.99, 1.1])
    squared = np.array([lowest_under(share * critical) for share in shares])
    assert squared / timoshenko(1) == pytest.approx(1 - shares, abs=1e-3)
    slope, start = np.polyfit(shares[:4], squared[:4], 1)
    assert -start / slope == pytest.approx(1.0, rel=1e-3)


def test_unstable_state_comes_first():
    """As many negative squares as the inertia shows unstable directions, in ascending order."""
    path = Path(column(), LoadControl(step=4.5 * EULER, target=4.5 * EULER))
    *_, state = path
    found = [v.squared for v in frequencies(path, state, 4)]
    assert state.unstable_modes == 2 == sum(s < 0 for s in found)
    assert found == sorted(found)


def test_modes_are_displacements():
    """The first mode of the column is a half sine of amplitude 1; the path stays at its state."""
    scene = column()
    path, (mode,) = unloaded(scene, 1)
    mesh = scene.parts[0].mesh
    shape = mode_displacement(path, mesh, mode)
    x = shape.function_space.tabulate_dof_coordinates()[:, 0]
    np.testing.assert_allclose(shape.x.array[1::2], np.sin(pi * x), atol=1e-3)


def test_plate():
    """Simply supported square plate: omega = 2 pi^2 sqrt(D / m) / b^2 (Leissa 1969); 0.1 %."""
    case = plate_buckling.case(cells=4)
    shell = case.scene.parts[0]
    thickness, modulus = shell.section.thickness, shell.material.modulus
    heavy = replace(shell, material=replace(shell.material, density=7.85e-9))
    _, (first,) = unloaded(replace(case.scene, parts=[heavy]), 1)
    ratio = modulus * thickness**3 / 12 / (1 - 0.3**2) / (7.85e-9 * thickness)
    assert first.squared == pytest.approx(4 * pi**4 * ratio / plate_buckling.WIDTH**4, rel=1e-3)


def strip_frequencies(offset):
    """Clamped strip of a shell with its mid-surface off the meshed surface."""
    mesh = read(lambda: meshes.rectangle((6, 1)), 3, 2, lambda x: x * (10.0, 1.0, 1.0))
    shell = Shell(mesh, Plate(0.5), STEEL, offset=offset)
    scene = Scene([shell], [clamp(mesh, "west")], [EdgeForce(mesh, "east", (0.0, 0.0, 1.0))],
                  Monitor(mesh, "south-east", "z"))
    return [v.squared for v in unloaded(scene, 3)[1]]


def test_mass_of_a_shell_with_offset():
    """That of the mid-surface: the clamped strip swings as one whose mesh lies there."""
    assert strip_frequencies(0.2) == pytest.approx(strip_frequencies(0.0), rel=1e-6)


def test_prescribed_motion_is_a_support():
    """A reaction that is a multiplier has no mass: a cantilever whose tip is moved swings as one whose tip is held."""
    mesh = straight(10)
    moved = cantilever(mesh, lambda beam: [PrescribedDisplacement(mesh, "tip", "y", 1.0)], material=STEEL)
    held = cantilever(mesh, lambda beam: [LineForce(beam, (0.0, 1.0))], "x", material=STEEL)
    held = replace(held, supports=[*held.supports, Support(mesh, "tip", "y")])
    one, other = ([v.squared for v in unloaded(scene, 3)[1]] for scene in (moved, held))
    assert one == pytest.approx(other, rel=1e-8)


def test_truss():
    """One free node of two bars: 2 EA sin^2 / L upwards, 2 EA cos^2 / L sideways, on two thirds of a bar's mass."""
    case = von_mises_truss.case(0.5)
    bars = replace(case.scene.parts[0], material=Elastic(1.0, density=3.0))
    length = 1.25**0.5
    mass = 2 / 3 * 3.0 * length
    _, found = unloaded(replace(case.scene, parts=[bars]), 2)
    assert [v.squared for v in found] == pytest.approx([2 * s / 1.25 / length / mass for s in (0.25, 1.0)], rel=1e-12)


def test_no_density():
    with pytest.raises(ValueError, match="Beam on group 'all' has no density.*density="):
        unloaded(column(material=Elastic(1e7)), 1)
    with pytest.raises(ValueError, match="count is 0"):
        unloaded(column(material=Elastic(1e7)), 0)
    with pytest.raises(ValueError, match="density is -1"):
        Elastic(1.0, density=-1.0)


def test_two_processes():
    """The frequencies of a bar at an angle, under load."""
    expected = [f"{v.squared:.7e}" for v in unloaded(column(3, turn=0.5), 4)[1]]
    lines = on_two_processes("""
from test_vibration import column, unloaded
print(*(f"{v.squared:.7e}" for v in unloaded(column(3, turn=0.5), 4)[1]))""")
    assert lines == [" ".join(expected)]
