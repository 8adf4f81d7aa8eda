"""What a record answers: resultants, displacements and rotations of the shown state."""

from __future__ import annotations

import numpy as np
import pytest
import ufl
from helpers import cantilever, straight

import sheetfx as fx


def test_resultants_of_a_beam():
    """A slender cantilever under a small tip force: N = 0, V = F, M = F (L - x), at the points of each cell."""
    mesh, force = straight(4), 1e-6
    record = fx.trace(fx.Case(cantilever(mesh, lambda b: [fx.PointForce(mesh, "tip", (0.0, force))]),
                              fx.LoadControl(1.0, fixed=True)))
    beam = record.case.scene.parts[0]
    normal, shear, moment = np.moveaxis(record.forces(beam), 2, 0)
    assert moment.shape == (4, 2)
    points = (1 + np.array([-1, 1]) / np.sqrt(3)) / 2
    x = np.sort((np.arange(4)[:, None] + points).ravel() / 4)
    assert np.sort(moment.ravel())[::-1] == pytest.approx(force * (1 - x), rel=1e-6)
    assert shear == pytest.approx(force, rel=1e-6) and np.abs(normal).max() < 1e-3 * force
    assert record.energies() == pytest.approx([force * record.states[-1].deflection / 2], rel=1e-6), "half the work"
    record.show(record.states[0])
    assert not record.forces(beam).any()


@pytest.mark.slow
def test_resultants_of_bars_and_shells():
    """A strip pulled at its end carries the force per width, and nothing else; so does a bar."""
    mesh = fx.read(lambda: fx.meshes.rectangle((2, 1), (2.0, 0.5)), 3)
    shell = fx.Shell(mesh, fx.Plate(0.1), fx.Elastic(1e5, 0.0), form="naghdi-q2")
    scene = fx.Scene([shell], [fx.clamp(mesh, "west")], [fx.EdgeForce(mesh, "east", (1e-3, 0.0, 0.0))],
                     fx.Monitor(mesh, "north-east", "x"))
    record = fx.trace(fx.Case(scene, fx.LoadControl(1.0, fixed=True)))
    forces = record.forces(shell)
    axis = 0 if abs(forces[0, 0, 0]) > abs(forces[0, 0, 1]) else 1
    assert forces[:, :, axis] == pytest.approx(1e-3, rel=1e-6)
    assert np.abs(np.delete(forces, axis, axis=2)).max() < 1e-9
    line = fx.read(lambda: fx.meshes.frame({"a": (0.0, 0.0), "b": (2.0, 0.0)}, {"bar": ("a", "b", 1)}), 2)
    bar = fx.Bar(line, fx.Rectangle(0.1, 0.1), fx.Elastic(1e5))
    pulled = fx.Scene([bar], [fx.pin(line, "a"), fx.Support(line, "b", "y")], [fx.PointForce(line, "b", (0.5, 0.0))],
                      fx.Monitor(line, "b", "x"))
    assert fx.trace(fx.Case(pulled, fx.LoadControl(1.0))).forces(bar) == pytest.approx(0.5, rel=1e-6)


def test_rotation_of_bars_is_refused():
    mesh = straight(1)
    scene = fx.Scene([fx.Bar(mesh, fx.Rectangle(0.1, 0.1), fx.Elastic(1e5))],
                     [fx.pin(mesh, "base"), fx.Support(mesh, "tip", "y")], [fx.PointForce(mesh, "tip", (0.5, 0.0))],
                     fx.Monitor(mesh, "tip", "x"))
    record = fx.trace(fx.Case(scene, fx.LoadControl(1.0)))
    assert record.displacement("tip")[0] > 0
    with pytest.raises(ValueError, match="rotation of 'tip': bars have no rotations"):
        record.rotation("tip")


def test_energy_of_a_law_of_higher_power():
    """A bar with s = EA (e + c e^3): the energy EA (e^2 / 2 + c e^4 / 4) l of the law, not half of force times way."""
    def hardening(strains, stiffness):
        e = strains[0]
        return ufl.as_vector([stiffness[0] * (e + 50 * e**3)])

    mesh = straight(1, 2.0)
    bar = fx.Bar(mesh, fx.Rectangle(1.0, 1.0), fx.Elastic(1.0), law=hardening)
    scene = fx.Scene([bar], [fx.pin(mesh, "base"), fx.Support(mesh, "tip", "y")],
                     [fx.PointForce(mesh, "tip", (0.15, 0.0))], fx.Monitor(mesh, "tip", "x"))
    record = fx.trace(fx.Case(scene, fx.LoadControl(0.25, fixed=True)))
    strain = record.states[-1].deflection / 2
    assert record.energies() == pytest.approx([2 * (strain**2 / 2 + 50 * strain**4 / 4)], rel=1e-10)
