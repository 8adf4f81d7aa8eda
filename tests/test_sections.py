"""Sections of beams whose axes are not principal, or whose centroid is not in the middle, against closed forms."""

from __future__ import annotations

from math import cos, radians, sin

import numpy as np
import pytest
import ufl
from helpers import response, straight

import sheetfx as fx
from sheetfx.critical.buckling import buckling
from sheetfx.critical.vibration import frequencies
from sheetfx.model.plasticity import Fibres
from sheetfx.model.stresses import stresses

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


@pytest.mark.silent("b01")
@pytest.mark.parametrize("angle", [30.0, -70.0])
@pytest.mark.slow
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


@pytest.mark.silent("b01")
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


@pytest.mark.slow
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


@pytest.mark.silent("u06")
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


def polygon(random, hollow):
    """Fibres of a polygon about its inner point, with a hole like it: its area, and its second moments by Green.

    The sums over corners are those of Steger (1996). Middles of the sides of triangles integrate the second degree.
    """
    count = random.integers(4, 8)
    angles = 2 * np.pi * (np.arange(count) + random.uniform(0, 0.8, count)) / count
    outer = random.uniform(0.5, 1.5, (count, 1)) * np.column_stack((np.cos(angles), np.sin(angles)))
    rings = [(1.0, outer)] + ([(-1.0, random.uniform(0.5, 0.9) * outer)] if hollow else [])
    places, areas, moments = [], [], np.zeros(6)  # of degree 0 to 2
    for sign, corners in rings:
        after = np.roll(corners, -1, axis=0)
        twice = np.cross(np.pad(corners, [(0, 0), (0, 1)]), np.pad(after, [(0, 0), (0, 1)]))[:, 2]
        (x, y), (a, b) = corners.T, after.T
        moments += sign * np.array([twice.sum() / 2, twice @ (x + a) / 6, twice @ (y + b) / 6,
                                    twice @ (x * x + x * a + a * a) / 12, twice @ (y * y + y * b + b * b) / 12,
                                    twice @ (2 * x * y + x * b + a * y + 2 * a * b) / 24])
    inner = rings[-1][1] if hollow else 0 * outer
    for i in range(count):
        j = (i + 1) % count
        for triangle in ([outer[i], outer[j], inner[i]], [inner[i], outer[j], inner[j]])[:1 + hollow]:
            (p, q, r), area = np.array(triangle), _area(triangle)
            places += [(p + q) / 2, (q + r) / 2, (r + p) / 2]
            areas += 3 * [area / 3]
    area, *first = moments[:3]
    x, y = np.array(first) / area
    return places, areas, area, moments[3:] - area * np.array((x * x, y * y, x * y))


def _area(triangle):
    a, b, c = np.array(triangle)
    return abs(float(np.linalg.det([b - a, c - a]))) / 2


def walls(random):
    """Fibres of an open section of thin walls, each by two of Gauss's points, and its moments in closed form."""
    corners = np.cumsum(random.normal(size=(random.integers(3, 6), 2)), axis=0)
    thickness = random.uniform(0.01, 0.05, len(corners) - 1)
    middle, along = (corners[1:] + corners[:-1]) / 2, np.diff(corners, axis=0)
    areas = thickness * np.linalg.norm(along, axis=1)
    places = np.concatenate([middle + s * along / 12**0.5 for s in (-1, 1)])
    apart = middle - areas @ middle / areas.sum()
    tensor = np.einsum("w,wi,wj", areas, apart, apart) + np.einsum("w,wi,wj", areas / 12, along, along)
    return places, np.tile(areas / 2, 2), areas.sum(), np.array([tensor[0, 0], tensor[1, 1], tensor[0, 1]])


KINDS = {"polygon": lambda random: polygon(random, hollow=False), "hollow": lambda random: polygon(random, hollow=True),
         "walls": walls}


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("kind", KINDS)
def test_random_sections_against_closed_forms(kind, seed):
    """Area, second moments and product; a cantilever buckles about the weakest principal axis, pi^2 E I / (4 L^2)."""
    places, areas, area, (along, across, product) = KINDS[kind](np.random.default_rng(seed))
    size = 0.01  # of length 1, so that shear does not matter
    section = fibres(size * np.array(places), size**2 * np.array(areas), shear_centre=(0.0, 0.0))
    assert section.area == pytest.approx(size**2 * area)
    assert (*section.second_moments, section.product) == pytest.approx(
        size**4 * np.array((across, along, product)), rel=1e-9, abs=1e-9 * size**4 * (along + across))
    weakest, _ = np.linalg.eigvalsh([[along, product], [product, across]]) * size**4
    if not seed:
        path = fx.Path(cantilever(section, (-1.0, 0.0, 0.0)))
        (first, *_) = sorted(abs(b.factor) for b in buckling(path, next(iter(path)), 1))
        assert first == pytest.approx(np.pi**2 * MATERIAL.modulus * weakest / 4, rel=2e-3)


@pytest.mark.parametrize("seed", range(6))
def test_flanges_on_bars_of_all_kinds(seed):
    """One or two flanges on a tube, a round bar or an angle of fibres, against the sum over the fibres of all."""
    random = np.random.default_rng(seed)
    places = random.normal(size=(6, 2))
    bars = fx.Tube(4.0, random.uniform(0.2, 1.0)), fx.round_bar(3.0), fibres(places, random.uniform(0.5, 1.0, 6))
    section = bars[seed % 3]
    for _ in range(1 + seed // 3):
        section = fx.Flanged(section, *random.uniform(1.0, 5.0, 2), random.uniform(-4.0, 4.0))
    (y, z), areas = section.fibres()[0].T, section.fibres()[1]
    assert section.area == pytest.approx(areas.sum())
    assert (areas @ y, areas @ z) == pytest.approx((0.0, 0.0), abs=1e-9 * areas.sum())
    assert (*section.second_moments, section.product) == pytest.approx((areas @ z**2, areas @ y**2, areas @ (y * z)))
    assert section.faces[0] <= y.min() and section.faces[1] >= y.max()


@pytest.mark.silent("b01")
@pytest.mark.parametrize("material", [fx.Elastic(2.1e5, 0.3), fx.Plastic(2.1e5, 0.3, yield_stress=1e9)],
                         ids=["elastic", "never yields"])
def test_angle_buckles_about_its_weak_axis(material):
    """An L 100 x 100 x 10 of twenty fibres on two hinges 3000 apart: 165 610 N, of the least principal moment."""
    legs = np.arange(10) + 0.5
    places = [(5.0, 10 * i) for i in legs] + [(10 + 9 * i, 5.0) for i in legs]
    areas = [100.0] * 10 + [90.0] * 10
    section = fibres(places, areas, torsion=1900 * 10**2 / 3, shear_centre=(0.0, 0.0))
    mesh = straight(4, 3000.0, dimension=3)
    held = [fx.Support(mesh, "base", "x y z rx"), fx.Support(mesh, "tip", "y z")]
    scene = fx.Scene([fx.Beam(mesh, section, material)], held, [fx.PointForce(mesh, "tip", (-1.0, 0.0, 0.0))],
                     fx.Monitor(mesh, "tip", "x"))
    path = fx.Path(scene)
    assert buckling(path, next(iter(path)), 1)[0].load == pytest.approx(165_610, rel=2e-3)
