"""Shells of revolution under pressure that follows them, and under dead pressure, against an independent theory."""

from __future__ import annotations

from dataclasses import dataclass
from math import pi, sqrt

import gmsh
import numpy as np
import pytest
import ufl
from revolution import Revolution, U, V, W

import sheetfx as fx

RADIUS, THICKNESS, MODULUS, POISSON = 1.0, 0.01, 1.0, 0.3
BENDING = MODULUS * THICKNESS**3 / 12 / (1 - POISSON**2)
STIFF = 20.0  # factor of the transverse shear stiffness, which the reference takes for infinite
MIDDLE = [[(1.0, W, 0, 0)], [(1.0, U, 0, 1)], [(1.0, V, 0, 1)]]  # plane of symmetry at the start of the meridian
DIAPHRAGM = [[(1.0, U, 1, 0)], [(1.0, V, 1, 0)]]


@dataclass(frozen=True, eq=False)
class DeadPressure(fx.Load):
    """Pressure per first area along the first normal."""

    shell: fx.Shell
    pressure: float

    def work(self, fields):
        u = fields.displacement(self.shell.mesh)
        return fields.factor * self.pressure * ufl.inner(self.shell.frame().axes[2], fields.vary(u)) * (
            self.shell.measure())

    def total(self, fields) -> float:
        return abs(self.pressure)


def cylinder(length: float, held, live: bool, elements: int = 8) -> Revolution:
    """Half a cylinder from its middle, under a pressure from outside."""
    def curve(s):
        return RADIUS + 0 * s, 0 * s, 0 * s, s, 1 + 0 * s, 0 * s

    ends = 1 - (1 - np.linspace(0, 1, elements + 1)) ** 1.5
    return Revolution(curve, length / 2, MODULUS, POISSON, THICKNESS, held, live, tuple(ends))


@pytest.mark.parametrize(("live", "factor"), [(True, 3.0), (False, 4.0)])
def test_reference_has_the_pressure_of_a_ring(live, factor):
    """3 D / R^3 and 4 D / R^3 for a cylinder without end (Bodner 1958), but for the square of the thickness."""
    plane = [(1.0, W, 1, 0)], [(1.0, U, 1, 1)], [(1.0, V, 1, 1)]
    ring = cylinder(0.5, lambda waves: [*MIDDLE, *plane], live, elements=2)
    assert ring.bifurcation(2, np.linspace(2, 5, 7) * BENDING) == pytest.approx(factor * BENDING, rel=3e-4)


def test_reference_has_the_pressures_of_a_cylinder_between_diaphragms():
    """Von Mises 1914 in the form of Timoshenko and Gere 1961, section 11.5, which neglects terms of 1 / n^2.

    Dead pressure is borne n^2 / (n^2 - 1) times as well by rings, a little less than that by cylinders.
    """
    length = 2.0
    for waves in (4, 6, 8):
        beta = 1 + (waves * length / pi / RADIUS) ** 2
        bending = THICKNESS**2 / 12 / (1 - POISSON**2) * (waves**2 - 1 + (2 * waves**2 - 1 - POISSON) / beta)
        mises = MODULUS * THICKNESS / RADIUS * (1 / ((waves**2 - 1) * beta**2) + bending)
        found = [cylinder(length, lambda n: MIDDLE + DIAPHRAGM * (n > 0), live).bifurcation(
            waves, np.linspace(0.8, 1.3, 6) * mises) for live in (True, False)]
        assert found[0] == pytest.approx(mises, rel=0.2 / waves**2 + 0.005)
        assert 1 < found[1] / found[0] < waves**2 / (waves**2 - 1)


def torus(bow: float, live: bool) -> Revolution:
    """Half a segment of a torus of length 1 from its widest or (bow < 0) narrowest place to a diaphragm."""
    def curve(s):
        a = s / bow
        return (RADIUS + bow * (np.cos(a) - 1), -np.sin(a), -np.cos(a) / bow,
                bow * np.sin(a), np.cos(a), -np.sin(a) / bow)

    ends = 1 - (1 - np.linspace(0, 1, 13)) ** 1.5
    return Revolution(curve, 0.5, MODULUS, POISSON, THICKNESS, lambda n: MIDDLE + DIAPHRAGM, live, tuple(ends))


def quarter_cylinder(cells: tuple[int, int], bow: float = np.inf, length: float = 2.0):
    """A quarter of a cylinder or segment of a torus from its middle to a diaphragm, and its planes of symmetry.

    Parameters
    ----------
    bow : radius of the meridian, positive outwards
    """
    def place(x):
        angle, s = pi / 2 * x[:, 0], length / 2 * x[:, 1]
        radius, height = (RADIUS + 0 * s, s) if np.isinf(bow) else (
            RADIUS + bow * (np.cos(s / bow) - 1), bow * np.sin(s / bow))
        return np.column_stack((radius * np.cos(angle), radius * np.sin(angle), height))

    mesh = fx.read(lambda: fx.meshes.rectangle(cells), 3, 3, place)
    planes = [fx.symmetry(mesh, "west", "y"), fx.symmetry(mesh, "east", "x"), fx.symmetry(mesh, "south", "z")]
    return mesh, stiff_shell(mesh), planes


def stiff_shell(mesh: fx.NamedMesh) -> fx.Shell:
    return fx.Shell(mesh, fx.Plate(THICKNESS, shear_factor=STIFF), fx.Elastic(MODULUS, POISSON), form="naghdi-q3")


@pytest.mark.slow
@pytest.mark.parametrize("live", [True, False])
def test_cylinder_between_diaphragms(live):
    """Twice as long as its radius: the lowest even numbers of waves are 6 and 8, with one half wave along.

    The diaphragms, "x y rz", are simply supported edges along a circle; the axes of the fixed rotations turn with them.
    First modes of a cylinder that moves freely before it buckles, by the classical problem of the unloaded state and
    from near, then a path with the boundary layers of a held one.
    """
    pressure = 4.8e-6
    mesh, shell, planes = quarter_cylinder((12, 6))
    load = (fx.Pressure if live else DeadPressure)(shell, -pressure)
    monitor = fx.Monitor(mesh, "north-east", "z")
    held = [*planes, fx.Support(mesh, "north", "x y rz")]
    free = cylinder(2.0, lambda n: MIDDLE + DIAPHRAGM * (n > 0), live, 12)
    path = fx.Path(fx.Scene([shell], planes, [load], monitor), fx.LoadControl(0.3, target=0.9, fixed=True))
    first, *_, last = path
    found = [b.factor for b in fx.buckling(path, first, 2, supports=held)]
    assert found == pytest.approx([free.linear_buckling(n, 1e-3 * pressure) / pressure for n in (6, 8)], rel=2e-3)
    near = fx.buckling(path, last, 1, supports=held)[0].factor
    assert near == pytest.approx(free.bifurcation(6, np.linspace(0.8, 1.2, 5) * pressure) / pressure, rel=1e-3)
    path = fx.Path(fx.Scene([shell], held, [load], monitor), fx.LoadControl(target=1.6))
    points = [point for state in path for point in state.critical]
    assert path.discretisation.system.conservative
    reference = cylinder(2.0, lambda n: MIDDLE + DIAPHRAGM, live, 12)
    expected = [reference.bifurcation(n, np.linspace(0.8, 1.6, 5) * pressure) for n in (6, 8)]
    assert [point.kind for point in points] == ["bifurcation", "bifurcation"]
    assert [point.load for point in points] == pytest.approx(expected, rel=1e-3)


@pytest.mark.slow
@pytest.mark.parametrize(("bow", "live", "waves", "pressure"), [
    (-4.0, True, (6, 8), 5.5e-6), (-4.0, False, (6, 8), 5.5e-6), (4.0, True, (10, 12), 2.06e-5)])
def test_torus_segment_between_diaphragms(bow, live, waves, pressure):
    """A waist is weaker than a barrel, whose two lowest modes with even numbers of waves lie within 2 %."""
    mesh, shell, planes = quarter_cylinder((14, 4), bow, 1.0)
    scene = fx.Scene([shell], [*planes, fx.Support(mesh, "north", "x y rz")],
                     [(fx.Pressure if live else DeadPressure)(shell, -pressure)], fx.Monitor(mesh, "north-east", "z"))
    reference = torus(bow, live)
    expected = [reference.bifurcation(n, np.linspace(0.8, 1.8, 9) * pressure) for n in waves]
    path = fx.Path(scene, fx.LoadControl(target=1.01 * expected[-1] / pressure))
    points = [point for state in path for point in state.critical]
    assert path.discretisation.system.conservative
    assert [(point.kind, point.multiplicity) for point in points] == [("bifurcation", 1)] * 2
    assert [point.load for point in points] == pytest.approx(expected, rel=2e-3)


def cap(parameter: float, live: bool) -> tuple[Revolution, float, float]:
    """Clamped spherical cap under a pressure from outside, the classical pressure of the sphere, and the half angle.

    The parameter is Budiansky's (1959), 2 (3 (1 - nu^2))^(1/4) (rise / thickness)^(1/2).
    """
    rise = THICKNESS * (parameter / 2) ** 2 / sqrt(3 * (1 - POISSON**2))
    angle = float(np.arccos(1 - rise / RADIUS))

    def curve(s):
        a = s / RADIUS
        return (RADIUS * np.sin(a), np.cos(a), -np.sin(a) / RADIUS, RADIUS * np.cos(a), -np.sin(a), -np.cos(a) / RADIUS)

    def held(waves):
        rim = [[(1.0, c, 1, 0)] for c in (U, V, W)] + [[(np.sin(angle), U, 1, 1), (np.cos(angle), W, 1, 1)]]
        if not waves:
            return [*rim, [(1.0, U, 0, 0)], [(1.0, W, 0, 1)]]
        return [*rim, *([(1.0, c, 0, 0)] for c in (U, V, W)), [(1.0, W, 0, 1)]]

    classical = 2 * MODULUS * (THICKNESS / RADIUS) ** 2 / sqrt(3 * (1 - POISSON**2))
    return Revolution(curve, angle * RADIUS, MODULUS, POISSON, THICKNESS, held, live,
                      tuple(np.linspace(0, 1, 17))), classical, angle


def quarter_disc(cells: int) -> None:
    """A quarter of a disc of radius 1 in three quadrilaterals."""
    geo, half = gmsh.model.geo, sqrt(0.5)
    places = {"o": (0, 0), "a": (0.5, 0), "b": (0, 0.5), "c": (0.38, 0.38), "A": (1, 0), "B": (0, 1), "C": (half, half)}
    points, lines, faces = {name: geo.addPoint(*place, 0) for name, place in places.items()}, {}, []

    def line(one, other):
        if (other, one) in lines:
            return -lines[other, one]
        if (one, other) not in lines:
            ends = points[one], points[other]
            round_one = one.isupper() and other.isupper()
            lines[one, other] = geo.addCircleArc(ends[0], points["o"], ends[1]) if round_one else geo.addLine(*ends)
            geo.mesh.setTransfiniteCurve(lines[one, other], cells + 1)
        return lines[one, other]

    for corners in ("oacb", "aACc", "bcCB"):
        sides = zip(corners, corners[1:] + corners[0], strict=True)
        faces.append(geo.addPlaneSurface([geo.addCurveLoop([line(*ends) for ends in sides])]))
        geo.mesh.setTransfiniteSurface(faces[-1], "Left", [points[c] for c in corners])
        geo.mesh.setRecombine(2, faces[-1])
    geo.synchronize()
    gmsh.model.addPhysicalGroup(2, faces, name="cap")
    for name, pieces in {"south": ("oa", "aA"), "west": ("bo", "Bb"), "rim": ("AC", "CB")}.items():
        gmsh.model.addPhysicalGroup(1, [abs(line(*ends)) for ends in pieces], name=name)
    gmsh.model.addPhysicalGroup(0, [points["o"]], name="apex")


def quarter_cap(angle: float, load, pressure: float, cells: int = 3) -> fx.Scene:
    def place(x):
        polar = angle * np.minimum(np.hypot(x[:, 0], x[:, 1]), 1.0)
        azimuth = np.arctan2(x[:, 1], x[:, 0])
        return RADIUS * np.column_stack((np.sin(polar) * np.cos(azimuth), np.sin(polar) * np.sin(azimuth),
                                         np.cos(polar)))

    mesh = fx.read(lambda: quarter_disc(cells), 3, 3, place)
    shell = stiff_shell(mesh)
    supports = [fx.symmetry(mesh, "south", "y"), fx.symmetry(mesh, "west", "x"), fx.clamp(mesh, "rim")]
    return fx.Scene([shell], supports, [load(shell, -pressure)], fx.Monitor(mesh, "apex", "z", -1.0))


@pytest.mark.slow
@pytest.mark.parametrize("live", [True, False])
def test_cap_buckles_in_two_waves(live):
    """Before its limit load, as Huang (1964) found; the dead pressure is the lower one."""
    reference, classical, angle = cap(6.0, live)
    expected = reference.bifurcation(2, -np.linspace(0.6, 0.9, 7) * classical)
    path = fx.Path(quarter_cap(angle, fx.Pressure if live else DeadPressure, classical),
                   until=fx.Until(event=lambda state: state.factor > 0.85))
    points = [point for state in path for point in state.critical]
    assert path.discretisation.system.conservative
    assert [point.kind for point in points] == ["bifurcation", "event"]
    assert points[0].load == pytest.approx(-expected, rel=1e-3)


@pytest.mark.slow
def test_shallow_cap_snaps():
    """Budiansky (1959): below a parameter of 5.5 it has a limit point and no waves."""
    reference, classical, angle = cap(4.0, True)
    expected = reference.limit(-np.linspace(0.0005, 0.012, 24), -0.1 * classical)
    path = fx.Path(quarter_cap(angle, fx.Pressure, classical), until=fx.Until(deflection=0.012))
    points = [point for state in path for point in state.critical]
    assert points[0].kind == "limit"
    assert points[0].load == pytest.approx(expected, rel=1e-3)
