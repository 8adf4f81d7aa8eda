"""Sections of beams whose axes are not principal, or whose centroid is not in the middle, against closed forms."""

from __future__ import annotations

from math import cos, radians, sin

import numpy as np
import pytest
import ufl
from helpers import response, straight

import sheetfx as fx
from sheetfx.model.plasticity import Fibres
from sheetfx.model.stresses import stresses
from sheetfx.stability.buckling import buckling
from sheetfx.stability.vibration import frequencies

MATERIAL = fx.Elastic(2e5, 0.3, density=7.85e-9)
SIDES = 0.02, 0.05  # width and depth of a rectangle


def fibres(places, areas, **more):
    """Section of fibres about their centroid."""
    places, areas = np.asarray(places, float), np.asarray(areas, float)
    places = places - areas @ places / areas.sum()
    given = {"torsion": float(areas @ (places**2).sum(axis=1))} | more
    return fx.FibreList(tuple(map(tuple, places)), tuple(areas), **given)


def turned(angle):
    """A rectangle as fibres whose depth is at an angle (degrees) from the depth of the beam, towards its width."""
    places, areas = fx.Rectangle(*SIDES).fibres()
    c, s = cos(radians(angle)), sin(radians(angle))
    return fibres(places @ np.array([[c, s], [-s, c]]), areas, torsion=fx.Rectangle(*SIDES).torsion)


@pytest.mark.parametrize("seed", range(20))
def test_stiffness_of_random_fibres_is_that_of_their_sum(seed):
    """Elastic moduli of the fibres' own law, which knows their places, and stresses at each of them."""
    random = np.random.default_rng(seed)
    section = fibres(random.normal(size=(7, 2)), random.uniform(0.1, 1.0, 7), shear_centre=(0.3, -0.2))
    law = Fibres(*section.fibres(), fx.Plastic(2e5, 0.3, yield_stress=1e9), section.stiffness(MATERIAL, 3))
    strains = 1e-4 * random.normal(size=(1, 6))
    forces, moduli, _ = law.update(strains, np.zeros((1, law.remembered)))
    assert np.array(section.stiffness(MATERIAL, 3)) == pytest.approx(moduli[0], rel=1e-9, abs=1e-9 * moduli.max())
    beam = fx.Beam(straight(1, dimension=3), section, MATERIAL)
    e, _, _, _, normal, binormal = strains[0]
    for y, z in section.places:
        assert stresses(beam, forces, (y, z))[0, 0] == pytest.approx(2e5 * (e + z * normal - y * binormal), rel=1e-9)


def cantilever(section, force, component="z", **beam):
    mesh = straight(4, dimension=3)
    return fx.Scene([fx.Beam(mesh, section, MATERIAL, **beam)], [fx.clamp(mesh, "base")],
                    [fx.PointForce(mesh, "tip", force)], fx.Monitor(mesh, "tip", component))


@pytest.mark.parametrize("angle", [30.0, -70.0])
def test_turned_fibres_are_the_rectangle_turned(angle):
    """Large deflection by a skew force, frequencies and buckling loads of a rectangle with its own direction."""
    up, found = (0.0, -sin(radians(angle)), cos(radians(angle))), []  # the width is along -y
    for section, direction in ((turned(angle), (0.0, 0.0, 1.0)), (fx.Rectangle(*SIDES), up)):
        path = fx.Path(cantilever(section, (-1.0, 0.0, 0.0), up=direction))
        state = next(iter(path))
        found.append([response(cantilever(section, (0.0, 1e4, 2e3), up=direction)),
                      *(v.frequency for v in frequencies(path, state, 4)),
                      *sorted(b.factor for b in buckling(path, state, 2))])
    assert found[0] == pytest.approx(found[1], rel=1e-6)
    assert abs(found[0][0]) > 0.05


@pytest.mark.parametrize("seed", range(2))
def test_random_fibres_bend_askew(seed):
    """F L^3 / 3 times the inverse of all second moments, and F L / (k G A) (Timoshenko)."""
    random = np.random.default_rng(seed)
    section = fibres(0.05 * random.normal(size=(6, 2)), random.uniform(1e-4, 1e-3, 6), shear_centre=(0.0, 0.0))
    places, areas = section.fibres()
    moments = 2e5 * np.einsum("f,fi,fj", areas, places, places)
    shear = 5 / 6 * MATERIAL.shear_modulus * section.area
    force = np.array([3e-3, 1e-3])  # along normal z and binormal -y
    right = np.linalg.solve(moments, force) / 3 + force / shear
    given = (0.0, -force[1], force[0])
    assert response(cantilever(section, given, "z")) == pytest.approx(right[0], rel=1e-5)
    assert response(cantilever(section, given, "y")) == pytest.approx(-right[1], rel=1e-5)


def test_forces_beside_the_shear_centre_twist():
    """A channel, e from its centroid: a force F on that twists by F e L / (G J), one on the shear centre not at all."""
    y, z = np.array([-0.05, -0.025, 0.0, 0.025, 0.05]), np.array([0.01, 0.02, 0.03])
    places = [(h, 0.0) for h in y] + [(h, w) for h in (-0.05, 0.05) for w in z]
    section = fibres(places, [1e-4] * len(places), torsion=1e-7, shear_centre=(0.0, -0.04))
    force, e, right = 1e-3, 0.04, 1e-3 * 0.04 / MATERIAL.shear_modulus / 1e-7
    twist = response(cantilever(section, (0.0, 0.0, force), "rx"))
    assert twist == pytest.approx(-force * e / MATERIAL.shear_modulus / 1e-7, rel=1e-4)
    free = response(cantilever(section, (0.0, 0.0, force), "rx", offset=(0.0, e)))
    assert abs(free) < 1e-6 * right


def test_unknown_shear_centre_is_said():
    """Of fibres that are not alike on both sides, in space."""
    angle = [(0.0, 0.0), (1.0, 0.0), (2.0, 0.0), (0.0, 1.0), (0.0, 2.0)]
    zed = [(-1.0, -1.0), (-1.0, 0.0), (0.0, 0.0), (1.0, 0.0), (1.0, 1.0)]
    with pytest.warns(UserWarning, match="the shear centre of its FibreList is taken as the centroid"):
        fx.Beam(straight(1, dimension=3), fibres(angle, [1.0] * 5), MATERIAL)
    fx.Beam(straight(1, dimension=3), fibres(zed, [1.0] * 5), MATERIAL)
    fx.Beam(straight(1, dimension=3), fibres(angle, [1.0] * 5, shear_centre=(-0.6, -0.6)), MATERIAL)
    fx.Beam(straight(1), fibres(angle, [1.0] * 5), MATERIAL)


def test_own_law_of_one_number_a_strain_is_refused():
    def law(strains, stiffness):
        return ufl.as_vector([k * e for k, e in zip(stiffness, strains, strict=True)])

    with pytest.raises(ValueError, match="rows of a matrix"):
        fx.Beam(straight(1, dimension=3), turned(30.0), MATERIAL, law=law)


def built_up(random, pieces):
    """Flanges one upon another, each beside a Flanged of those before, and all as rectangles: (place, depth, width)."""
    width, depth = random.uniform(1.0, 10.0, 2)
    section, axis, rectangles = fx.Rectangle(width, depth), 0.0, [(0.0, depth, width)]
    for _ in range(pieces):
        width, thickness, offset = random.uniform(1.0, 20.0), random.uniform(0.5, 2.0), random.uniform(-12.0, 12.0)
        section = fx.Flanged(section, width, thickness, offset)
        rectangles.append((axis + offset, thickness, width))
        axis += section.centroid
    return section, np.array(rectangles)


@pytest.mark.parametrize("seed", range(20))
def test_nested_flanges_are_their_rectangles(seed):
    """Depth, faces, centroid, second moments and fibres of one to four flanges."""
    section, rectangles = built_up(np.random.default_rng(seed), 1 + seed % 4)
    place, depth, width = rectangles.T
    areas = depth * width
    place = place - areas @ place / areas.sum()
    low, high = (place - depth / 2).min(), (place + depth / 2).max()
    assert (*section.faces, section.depth) == pytest.approx((low, high, high - low))
    right = (areas @ width**2 / 12, areas @ (depth**2 / 12 + place**2))
    assert section.second_moments == pytest.approx(right)
    places, weights = section.fibres()
    assert weights @ places == pytest.approx(np.zeros(2), abs=1e-9 * areas.sum())
    assert weights @ places**2 == pytest.approx(right[::-1])
    assert section.shear_centre[0] == pytest.approx((areas * width**2) @ place / (areas @ width**2))
