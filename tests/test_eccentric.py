"""Beams whose centroid stands off the meshed line, against the same beams on the line of their centroids."""

from __future__ import annotations

from math import pi, radians

import numpy as np
import pytest
from helpers import distance, energy_and_residual, follow, move_at_random, straight, tangents, turn_rigidly

from sheetfx import meshes
from sheetfx.continuation.control import LoadControl
from sheetfx.critical.buckling import buckling
from sheetfx.critical.vibration import frequencies
from sheetfx.discrete.discretisation import Discretisation
from sheetfx.mesh.reader import read
from sheetfx.model.beam import Beam
from sheetfx.model.interface import weld
from sheetfx.model.loads import PointForce
from sheetfx.model.scene import Monitor, Scene
from sheetfx.model.section import Elastic, Rectangle
from sheetfx.model.supports import clamp
from sheetfx.path import Path

MATERIAL, SECTION = Elastic(1.2e5, 0.0, density=2.0), Rectangle(0.2, 0.05)


def arc(radius, dimension, cells=8, degree=2, opening=1.5, **beam):
    """Arc from the top towards x, clamped at its start; its normal in the plane points outwards."""
    mesh = read(lambda: meshes.arc(radius, 0.0, opening, cells), dimension, degree)
    return Beam(mesh, SECTION, MATERIAL, degree=degree, **beam)


def pushed(beam, force, at="end", others=(), joints=(), component="y", start="start", mesh=None):
    """Clamped at its start, with a force on the end of it or of a link welded to it."""
    mesh = mesh or beam.mesh
    return Scene([beam, *others], [clamp(beam.mesh, start)], [PointForce(mesh, at, force)],
                 Monitor(mesh, at, component), joints=joints)


def linked(beam, at, places, force, component="y", start="start"):
    """The same where the force acts at the end of a stiff link, between places: 1e7 times the beam's stiffness."""
    mesh = read(lambda: meshes.frame(dict(zip(("from", "to"), places, strict=True)), {"link": ("from", "to", 1)}),
                beam.mesh.dimension)
    link = Beam(mesh, Rectangle(1.0, 1.0), Elastic(1e7, 0.0), up=(1.0, 0.3, 0.2))
    return pushed(beam, force, "to", [link], [weld(beam.mesh, at, (mesh, "from"))], component, start, mesh)


CASES = [(2, 2, 0.3), (2, 3, -0.2), (3, 2, (0.3, -0.2)), pytest.param(3, 3, (0.3, -0.2), marks=pytest.mark.slow)]


@pytest.mark.parametrize(("dimension", "degree", "offset"), CASES)
@pytest.mark.slow(quick=1)
def test_tangent_is_the_symmetric_derivative_of_the_residual(dimension, degree, offset):
    beam = arc(1.0, dimension, 3, degree, offset=offset)
    discretisation = Discretisation(pushed(beam, (1.0, 2.0, 3.0)[:dimension]))
    assembled, differences = tangents(discretisation.system, move_at_random(discretisation))
    assert distance(assembled + assembled.T, differences + differences.T) < 1e-7
    assert distance(assembled, assembled.T) < 1e-12


@pytest.mark.slow
def test_rigid_rotation_leaves_no_strain():
    """To roundoff of the stiffness 1e5: a curved beam off its line, turned beyond a full turn."""
    beam = arc(1.0, 3, 3, offset=(0.3, -0.2))
    discretisation = Discretisation(pushed(beam, (0.0, 0.0, 1.0)))
    discretisation.system.fixed_rows = np.empty(0, dtype=np.int32)
    discretisation.system.factors.set(0.0)
    turn_rigidly(discretisation, radians(800.0), (1.0, 2.0, 3.0), steps=7)
    assert np.abs(discretisation.kinematics(beam.mesh).displacement(beam.mesh, "end")).max() > 0.1
    energy, residual = energy_and_residual(discretisation)
    assert energy < 1e-12
    assert residual < 1e-8


def last_deflection(scene, load):
    *_, state = Path(scene, LoadControl(step=load / 4, target=load, fixed=True))
    return state.deflection


@pytest.mark.parametrize("offset", [0.1, -0.2])
def test_arc_in_the_plane_is_the_arc_of_its_centroids(offset):
    """Sections turn as much along a longer line outside the arc, a shorter one inside: tips move by twice the radius.

    The difference falls by more than four from 8 to 16 cells, where it is 4e-5.
    """
    beam, other, force = arc(1.0, 2, 16, offset=offset), arc(1.0 + offset, 2, 16), (0.2, 0.4)
    places = [(radius * np.sin(1.5), radius * np.cos(1.5)) for radius in (1.0 + offset, 1.0)]
    value = last_deflection(pushed(beam, force), 40.0)
    assert value == pytest.approx(last_deflection(linked(other, "end", places, force), 40.0), rel=5e-5)
    assert value > 1.8


def bar(offset, cells=16, **beam):
    """Bar meshed along x."""
    settings = {"section": SECTION, "material": MATERIAL, "offset": offset} | beam
    return Beam(straight(cells, dimension=3), **settings)


OFFSET = (0.1, 0.05)
TIP = (1.0, -OFFSET[1], OFFSET[0])  # its depth is along z, its width along tangent x depth = -y


def of_centroids(cells=16):
    """The bar meshed along the line of its centroids."""
    nodes = {"base": (0.0, *TIP[1:]), "tip": TIP}
    mesh = read(lambda: meshes.frame(nodes, {"beam": ("base", "tip", cells)}), 3)
    return Beam(mesh, SECTION, MATERIAL)


def both(force, component):
    """The bar off its line, and the bar on the line of its centroids pushed at the end of a stiff link."""
    return (pushed(bar(OFFSET), force, "tip", component=component, start="base"),
            linked(of_centroids(), "tip", [TIP, (1.0, 0.0, 0.0)], force, component, "base"))


@pytest.mark.slow
def test_bar_in_space_is_the_bar_of_its_centroids():
    """Large deflections, bent about both axes and twisted by the eccentric force."""
    values = [last_deflection(scene, 1.5) for scene in both((0.2, 1.0, 1.0), "z")]
    assert values[0] == pytest.approx(values[1], rel=1e-5)
    assert values[0] > 0.2


def test_bar_buckles_as_the_bar_of_its_centroids():
    """Lateral-torsional buckling under an eccentric compression, the initial-stress problem."""
    factors = []
    for scene in both((-1.0, 0.0, 0.0), "z"):
        path = Path(scene)
        factors.append([b.factor for b in buckling(path, path.tracer.state, 2) if b.factor > 0][:2])
    assert factors[0] == pytest.approx(factors[1], rel=1e-6)
    assert factors[0][0] < pi**2 / 4 * MATERIAL.modulus * min(SECTION.second_moments), "less than a centric column"


def test_forces_are_those_of_the_centroid():
    """A force N on the meshed line: N, and moments that balance N e about both axes; 1e-3: the bar has bent by then."""
    beam, force = bar(OFFSET), 1e-3
    record = follow(pushed(beam, (1.0, 0.0, 0.0), "tip", start="base"), LoadControl(force, target=force, fixed=True))
    record.show(record.states[-1])
    forces = record.forces(beam).reshape(-1, 6).mean(axis=0) / force
    assert forces == pytest.approx([1.0, 0.0, 0.0, 0.0, -OFFSET[1], OFFSET[0]], abs=3e-4)


def test_mass_is_that_of_the_centroids():
    """Clamped, the bar swings as one whose mesh lies there; in the plane too."""
    for beam, other in ((bar(OFFSET), of_centroids()),
                        (Beam(straight(8), SECTION, MATERIAL, offset=0.1), Beam(straight(8), SECTION, MATERIAL))):
        squares = []
        for part in (beam, other):
            force = (0.0, 1.0, 0.0)[: part.mesh.dimension]
            path = Path(pushed(part, force, "tip", start="base"))
            squares.append([v.squared for v in frequencies(path, path.tracer.state, 4)])
        assert squares[0] == pytest.approx(squares[1], rel=1e-6)


@pytest.mark.parametrize(("beam", "message"), [
    (lambda: bar((0.1, 0.2, 0.3)), "offset .* must be 2 numbers, not 3"),
    (lambda: bar(0.1), "offset .* has 1 components; give 2"),
    (lambda: Beam(straight(1), SECTION, MATERIAL, offset=(0.1, 0.2)), "offset .* has 2 components; give 1"),
    (lambda: bar((0.1, float("nan"))), "offset is .*must be finite"),
    (lambda: bar(OFFSET, degree=5), "degree is 5; it must be one of 1, 2, 3, 4"),
    (lambda: arc(1.0, 2, offset=-1.1), "offset .* lies beyond the centre of curvature"),
])
def test_misuse_is_named(beam, message):
    with pytest.raises(ValueError, match=message):
        beam()
