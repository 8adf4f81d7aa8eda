"""Shells whose mid-surface stands off the meshed surface, against the same shells meshed there and closed forms."""

from __future__ import annotations

from math import pi, radians

import numpy as np
import pytest
from helpers import energy_and_residual, response, turn_rigidly

import sheetfx as fx
from sheetfx.critical.vibration import frequencies
from sheetfx.discrete.discretisation import Discretisation

RADIUS, THICKNESS, LENGTH, MODULUS = 100.0, 10.0, 100.0, 2e5
OWN = {"naghdi": fx.forms.shell.naghdi, "biot": fx.forms.shell.biot}


def pipe(radius, cells=6):
    """A quarter of a pipe that is meshed at a radius, and its supports."""
    mesh = fx.read(lambda: fx.meshes.rectangle((cells, 2)), 3, 2, lambda x: np.column_stack(
        (radius * np.cos(x[:, 0] * pi / 2), radius * np.sin(x[:, 0] * pi / 2), LENGTH * x[:, 1])))
    shell = fx.Shell(mesh, fx.Plate(THICKNESS), fx.Elastic(MODULUS, 0.0), offset=RADIUS - radius)
    return shell, [fx.symmetry(mesh, "west", "y"), fx.symmetry(mesh, "east", "x"), fx.symmetry(mesh, "south", "z"),
                   fx.Support(mesh, "north", "rx ry")]


@pytest.mark.silent("q02")
@pytest.mark.parametrize("radius", [90.0, 95.0, 105.0, 115.0])
@pytest.mark.slow(quick=1)
def test_pipe_is_the_same_on_whichever_face_it_is_meshed(radius):
    """A force q per area of the meshed surface at r, and T per length of its edge: q r R / E t and T r L / (R E t)."""
    shell, supports = pipe(radius)
    mesh = shell.mesh
    hoop = fx.Scene([shell], supports, [fx.Pressure(shell, 1.0)], fx.Monitor(mesh, "north-west", "x"))
    axial = fx.Scene([shell], supports, [fx.EdgeForce(mesh, "north", (0.0, 0.0, 1.0))],
                     fx.Monitor(mesh, "north-west", "z"))
    assert response(hoop) == pytest.approx(radius * RADIUS / MODULUS / THICKNESS, rel=3e-3)
    assert response(axial) == pytest.approx(radius / RADIUS * LENGTH / MODULUS / THICKNESS, rel=1e-3)


def curved(offset, bends, cells=5):
    """Panel of two curvatures and a twist, whose mid-surface is the same wherever it is meshed."""
    def place(x):
        (a, b, c), s, t = bends, x[:, 0], x[:, 1]
        middle = np.column_stack((s, t, a * s**2 + b * t**2 + c * s * t))
        normal = np.column_stack((-2 * a * s - c * t, -2 * b * t - c * s, np.ones_like(s)))
        return middle - offset * normal / np.linalg.norm(normal, axis=1)[:, None]

    mesh = fx.read(lambda: fx.meshes.rectangle((cells, cells)), 3, 2, place)
    shell = fx.Shell(mesh, fx.Plate(0.1), fx.Elastic(1.0, 0.3, density=1.0), offset=offset)
    return fx.Scene([shell], [fx.clamp(mesh, "west")], [fx.EdgeForce(mesh, "east", (0.0, 0.0, 1.0))],
                    fx.Monitor(mesh, "south-east", "z"))


def swings(scene):
    path = fx.Path(scene)
    return [v.frequency for v in frequencies(path, next(iter(path)), 4)]


@pytest.mark.silent("q02")
@pytest.mark.parametrize("bends", [(0.3, 0.0, 0.0), (0.3, 0.4, 0.0), (-0.4, 0.5, 0.3)])
@pytest.mark.slow(quick=1)
def test_curved_panel_swings_the_same_on_whichever_face_it_is_meshed(bends):
    """Stiffness and mass of the mid-surface; per length and area of the meshed one frequencies are up to 9 % off."""
    right = swings(curved(0.0, bends))
    for offset in (0.05, -0.05):
        assert swings(curved(offset, bends)) == pytest.approx(right, rel=4e-3)


def test_rigid_rotation_leaves_no_strain():
    discretisation = Discretisation(curved(0.05, (-0.4, 0.5, 0.3), 2))
    discretisation.system.fixed_rows = np.empty(0, dtype=np.int32)
    discretisation.system.factors.set(0.0)
    turn_rigidly(discretisation, radians(800.0), (1.0, 2.0, 3.0), steps=7)
    energy, residual = energy_and_residual(discretisation)
    assert abs(energy) < 1e-15
    assert residual < 1e-13


@pytest.mark.silent("f01")
@pytest.mark.parametrize("name", ["naghdi", pytest.param("biot", marks=pytest.mark.slow)])
def test_strains_of_ones_own_are_those_of_the_mid_surface(name):
    """A force N on the meshed edge bends a strip with N e: its tip moves by N e L^2 / 2 D."""
    for offset in (0.02, -0.05):
        mesh = fx.read(lambda: fx.meshes.rectangle((8, 1), (1.0, 0.2)), 3, 2)
        shell = fx.Shell(mesh, fx.Plate(0.01), fx.Elastic(1.0, 0.0), strains=OWN[name], offset=offset)
        scene = fx.Scene([shell], [fx.clamp(mesh, "west")], [fx.EdgeForce(mesh, "east", (1.0, 0.0, 0.0))],
                         fx.Monitor(mesh, "south-east", "z"))
        assert response(scene) == pytest.approx(offset / 2 / (0.01**3 / 12), rel=1e-5)


def test_offset_beyond_the_centre_of_curvature_is_refused():
    """Of one curvature, of both, and of a saddle by either; just before it none is."""
    def shell(offset, bends):
        mesh = fx.read(lambda: fx.meshes.rectangle((4, 4)), 3, 2, lambda x: np.column_stack(
            (x[:, 0], x[:, 1], bends[0] * x[:, 0] ** 2 + bends[1] * x[:, 1] ** 2)))
        return fx.Shell(mesh, fx.Plate(0.01), fx.Elastic(1.0), offset=offset)

    for offset, bends in ((1.2, (0.5, 0.0)), (3.0, (0.5, 0.5)), (1.2, (0.5, -0.5)), (-1.2, (0.5, -0.5))):
        with pytest.raises(ValueError, match=f"Shell: offset {offset:g} lies beyond the centre of curvature"):
            shell(offset, bends)
        shell(offset / 2 if bends != (0.5, 0.5) else 0.8, bends)


def octant(radius):
    """An eighth of a sphere in three patches of quadrilaterals."""
    nodes = {"x": (1, 0, 0), "y": (0, 1, 0), "z": (0, 0, 1)}
    return fx.read(lambda: fx.meshes.panels(nodes, {"sphere": ("x", "y", "z")}, 4), 3, 2,
                   lambda x: radius * x / np.linalg.norm(x, axis=1, keepdims=True))


@pytest.mark.silent("q02")
@pytest.mark.parametrize("seed", range(6))
def test_sphere_is_the_same_on_whichever_surface_it_is_meshed(seed):
    """A pressure p on the meshed surface at r moves it by w = p r^2 (1 - nu) / (2 E t), with the work p w pi r^2 / 4.

    Nodes of three cells move by 3 % less with these cells, on the mid-surface too.
    """
    random = np.random.default_rng(seed)
    middle, thickness, poisson = 10.0, random.uniform(0.2, 1.0), random.uniform(0.0, 0.4)
    radius = middle + random.uniform(-1.0, 1.0) * thickness
    mesh = octant(radius)
    shell = fx.Shell(mesh, fx.Plate(thickness), fx.Elastic(MODULUS, poisson), offset=middle - radius)
    supports = [fx.symmetry(mesh, edge, normal) for edge, normal in (("x-y", "z"), ("y-z", "x"), ("z-x", "y"))]
    scene = fx.Scene([shell], supports, [fx.Pressure(shell, 1.0)], fx.Monitor(mesh, "x", "x"))
    record = fx.trace(fx.Case(scene, fx.LoadControl(1.0, fixed=True)))
    moved = radius**2 * (1 - poisson) / (2 * MODULUS * thickness)
    assert record.energies()[0] == pytest.approx(moved * np.pi * radius**2 / 4, rel=5e-3)
