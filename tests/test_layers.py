"""Stresses within sections: transverse shear from equilibrium, and of plastic layers and fibres."""

from __future__ import annotations

from math import pi

import numpy as np
import pytest
from helpers import on_two_processes

import sheetfx as fx


def strip(section, material=None, cells=16, form="naghdi-q2"):
    """A strip of 10 x 1 that spans along x under a uniform load of 1, its long edges free."""
    mesh = fx.read(lambda: fx.meshes.rectangle((cells, 1), (10.0, 1.0), "-t" in form), 3, 2)
    shell = fx.Shell(mesh, section, material, axis=(1, 0, 0), form=form)
    held = [fx.Support(mesh, "west", "x z"), fx.Support(mesh, "east", "z"), fx.Support(mesh, "south-west", "y")]
    scene = fx.Scene([shell], held, [fx.SurfaceForce(shell, (0.0, 0.0, 1.0))], fx.Monitor(mesh, "north-west", "ry"))
    return shell, fx.trace(fx.Case(scene, until=fx.Until(steps=0)))


SANDWICH = fx.Laminate([fx.Ply(0.1, 0.0, 10.0e6, 10.0e6, 0.25, 4e6), fx.Ply(0.8, 0.0, 1e5, 1e5, 0.25, 4e4),
                        fx.Ply(0.1, 0.0, 10.0e6, 10.0e6, 0.25, 4e6)])
SKEW = fx.Laminate([fx.Ply(0.2, 0.0, 25e6, 1e6, 0.25, 0.5e6), fx.Ply(0.3, 90.0, 25e6, 1e6, 0.25, 0.5e6),
                    fx.Ply(0.5, 0.0, 25e6, 1e6, 0.25, 0.5e6)])


@pytest.mark.parametrize("section", [fx.Plate(1.0), SANDWICH, SKEW], ids=["plate", "sandwich", "unsymmetric"])
@pytest.mark.slow(quick=1)
def test_shear_between_layers_is_that_of_equilibrium(section):
    """Its integral is the shear force, it is zero on both faces, and minus its rate that of the stress along x."""
    shell, record = strip(section, fx.Elastic(1e6, 0.3) if isinstance(section, fx.Plate) else None)
    places, _ = record.section_points(shell).reference, record.linear()
    linear = record.linear(1e-3)
    forces = linear.forces(shell)

    def shear(z):
        return fx.transverse_shear(shell, forces, z)[..., 0]

    assert np.abs(shear(-0.5)).max() < 1e-9 and np.abs(shear(0.5)).max() < 1e-9 * np.abs(forces[..., 6]).max()
    nodes, weights = np.polynomial.legendre.leggauss(8)
    borders = np.cumsum([-0.5, *(p.thickness for p in getattr(section, "plies", [fx.Plate(1.0)]))])
    integral = sum((b - a) / 2 * w * shear((a + b) / 2 + (b - a) / 2 * n)
                   for a, b in zip(borders[:-1], borders[1:], strict=True) for n, w in zip(nodes, weights, strict=True))
    assert integral == pytest.approx(forces[..., 6], rel=1e-9)
    x, height = places[..., 0].ravel(), 0.37
    inner = np.abs(x - 5.0) < 4.0
    stress, thin = linear.stresses(shell, height)[..., 0].ravel(), (shear(height + 1e-4) - shear(height - 1e-4)) / 2e-4
    rate = np.polynomial.Polynomial.fit(x[inner], stress[inner], 2).deriv()(x)
    assert -thin.ravel()[inner] == pytest.approx(rate[inner], abs=0.03 * np.abs(rate[inner]).max())


def test_sandwich_carries_its_shear_in_the_core():
    """All but uniform there: q / d, d being the distance of the faces' middles."""
    shell, record = strip(SANDWICH)
    forces = record.linear().forces(shell)
    core = fx.transverse_shear(shell, forces, 0.0)[..., 0]
    assert core == pytest.approx(forces[..., 6] / 0.9, rel=0.02)


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.slow
def test_stresses_of_a_plastic_beam(dimension):
    """Pure bending: fibres beyond the elastic core are at the yield stress, those within as far as they are out."""
    ends = {"a": (0, 0, 0)[:dimension], "b": (10.0, 0, 0)[:dimension]}
    mesh = fx.read(lambda: fx.meshes.frame(ends, {"l": ("a", "b", 2)}), dimension)
    steel = fx.Plastic(2e5, 0.3, yield_stress=200.0, hardening=1.0)
    beam = fx.Beam(mesh, fx.Rectangle(1.0, 1.0, points=9), steel, **({"up": (0, 1, 0)} if dimension == 3 else {}))
    most = 200.0 / 4
    load = fx.Moment(mesh, "b", -0.9 * most if dimension == 2 else (0.0, 0.0, -0.9 * most))
    scene = fx.Scene([beam], [fx.clamp(mesh, "a")], [load], fx.Monitor(mesh, "b", "y"))
    record = fx.trace(fx.Case(scene, fx.LoadControl(turn=pi)))
    core = np.sqrt((1 - 0.9) * 3) / 2  # of the depth, half of what is elastic

    def stress(y):
        return record.stresses(beam, y if dimension == 2 else (y, 0.0))

    assert stress(0.5) == pytest.approx(200.0, rel=5e-3) and stress(-0.5) == pytest.approx(-200.0, rel=5e-3)
    assert np.abs(stress(0.0)).max() < 200 * 0.06 / core


def test_stresses_of_a_plastic_shell():
    """In tension all layers carry what the force says; elastic ones are those of the elastic section."""
    mesh = fx.read(lambda: fx.meshes.rectangle((2, 2)), 3, 2)
    steel = fx.Plastic(2e5, 0.3, yield_stress=200.0, hardening=2000.0)
    shell = fx.Shell(mesh, fx.Plate(0.01), steel, axis=(1, 0, 0))
    held = [fx.symmetry(mesh, "west", "x"), fx.symmetry(mesh, "south", "y"), fx.Support(mesh, "south-west", "z rx ry"),
            fx.Support(mesh, "north-west", "z")]
    scene = fx.Scene([shell], held, [fx.EdgeForce(mesh, "east", (2.5, 0, 0))], fx.Monitor(mesh, "north-east", "x"))
    record = fx.trace(fx.Case(scene, fx.LoadControl(turn=pi)))
    for at in (-0.005, 0.0, 0.005):
        found = record.stresses(shell, at)
        assert found[..., 0] == pytest.approx(250.0, rel=3e-2) and np.abs(found[..., 1:]).max() < 5.0
    assert record.plastic_share() == pytest.approx(1.0)


def test_what_is_refused():
    shell, record = strip(fx.Plate(1.0), fx.Elastic(1e6, 0.3))
    with pytest.raises(ValueError, match="at is 0.6, outside of its thickness 1"):
        record.transverse_shear(shell, 0.6)


def test_values_at_points_and_places():
    """Of a strip under a uniform load: m11 = x (L - x) / 2 about its middle, at a named corner, and off it."""
    shell, record = strip(SANDWICH)
    linear = record.linear()
    forces = linear.forces(shell)
    for x in (2.0, 5.1, 7.77):
        moment = record.value_at(shell, forces, (x, 0.5, 0.0))[3]
        assert abs(moment) == pytest.approx(x * (10.0 - x) / 2, rel=5e-3)
    assert np.abs(record.value_at(shell, forces, "south-west")[3]) < 0.3
    assert record.value_at(shell, linear.stresses(shell, 0.5), (5.0, 0.5, 0.0)).shape == (3,)
    with pytest.raises(ValueError, match="is 2 off the Shell; give one on it"):
        record.value_at(shell, forces, (12.0, 0.5, 0.0))


def test_values_on_two_processes():
    script = """
from test_layers import SANDWICH, strip
shell, record = strip(SANDWICH)
forces = record.linear().forces(shell)
print(*record.value_at(shell, forces, (5.0, 0.5, 0.0))[:6], *record.value_at(shell, forces, "north-east")[:6])
"""
    shell, record = strip(SANDWICH)
    forces = record.linear().forces(shell)
    own = [*record.value_at(shell, forces, (5.0, 0.5, 0.0))[:6], *record.value_at(shell, forces, "north-east")[:6]]
    assert list(map(float, on_two_processes(script)[0].split())) == pytest.approx(own, abs=1e-5 * np.abs(own).max())


@pytest.mark.parametrize("form", ["naghdi-q2", "naghdi-q3", "naghdi-t2", "naghdi-t3"])
@pytest.mark.slow(quick=1)
def test_stresses_at_nodes_for_paraview(form, tmp_path):
    """Of a strip in cylindrical bending the von Mises stress of both faces, at nodes and by cells."""
    import pyvista

    shell, record = strip(fx.Plate(1.0), fx.Elastic(1e6, 0.0), 8, form)
    record = fx.trace(fx.Case(record.case.scene, fx.LoadControl(0.5), fx.Until(steps=2)))
    fx.show.paraview(record, tmp_path)
    made = pyvista.get_reader(str(tmp_path / "paraview" / "path.pvd"))
    made.set_active_time_value(made.time_values[-1])
    grid = made.read()[0]
    stress = grid.point_data["von Mises stress, upper face at nodes"]
    middle = np.abs(grid.points[:, 0] - 5.0) < 1e-9
    right = np.abs(record.value_at(shell, record.stresses(shell, 0.5), (5.0, 0.5, 0.0))[0])
    assert stress[middle].mean() == pytest.approx(right, rel=0.02)
    assert grid.cell_data["thickness"] == pytest.approx(np.ones(grid.n_cells))
