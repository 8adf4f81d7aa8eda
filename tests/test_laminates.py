"""Plates of plies against classical lamination theory, on axes that do not depend on the mesh."""

from __future__ import annotations

from math import pi

import gmsh
import numpy as np
import pytest
import ufl
from helpers import response
from scipy.linalg import expm

import sheetfx as fx
from sheetfx.critical.vibration import frequencies

THICKNESS = 1e-3  # of a square of side 1: shear and large deflections do not matter
ALONG, ACROSS, POISSON, SHEAR = 25e9, 1e9, 0.25, 0.5e9
CROSS, ANGLE = (0.0, 90.0, 90.0, 0.0), (45.0, -45.0)
HELD = {"west": "x z rx", "east": "x z rx", "south": "y z ry", "north": "y z ry"}
X = (1.0, 0.0, 0.0)


def laminate(angles, turned=0.0):
    return fx.Laminate([fx.Ply(THICKNESS / len(angles), a - turned, ALONG, ACROSS, POISSON, SHEAR) for a in angles])


def unstructured(size):
    """Unit square in cells that follow no direction, with its edges named and its middle a point."""
    def model():
        occ = gmsh.model.occ
        square, middle = occ.addRectangle(0, 0, 0, 1, 1), occ.addPoint(0.5, 0.5, 0)
        occ.fragment([(2, square)], [(0, middle)])
        occ.synchronize()
        gmsh.option.setNumber("Mesh.MeshSizeMax", size)
        gmsh.model.addPhysicalGroup(2, [tag for _, tag in gmsh.model.getEntities(2)], name="shell")
        for _, tag in gmsh.model.getEntities(1):
            x, y, _ = gmsh.model.occ.getCenterOfMass(1, tag)
            name = {(0, 5): "west", (10, 5): "east", (5, 0): "south", (5, 10): "north"}[round(10 * x), round(10 * y)]
            gmsh.model.addPhysicalGroup(1, [tag], name=name)
        gmsh.model.addPhysicalGroup(0, [middle], name="middle")
    return fx.read(model, 3, 3)


def structured(cells):
    nodes = {"a": (0, 0, 0), "b": (0.5, 0, 0), "c": (1, 0, 0), "d": (0, 0.5, 0), "middle": (0.5, 0.5, 0),
             "f": (1, 0.5, 0), "g": (0, 1, 0), "h": (0.5, 1, 0), "i": (1, 1, 0)}
    faces = {"1": ("a", "b", "middle", "d"), "2": ("f", "middle", "b", "c"), "3": ("d", "middle", "h", "g"),
             "4": ("middle", "f", "i", "h")}
    return fx.read(lambda: fx.meshes.panels(nodes, faces, cells), 3, 2)


MESHES = {"quadrilaterals": ("naghdi-q2", lambda: structured(4)),
          "triangles": ("naghdi-t3", lambda: unstructured(0.15))}
EDGES = {"quadrilaterals": {"west": ("a-d", "d-g"), "east": ("c-f", "f-i"), "south": ("a-b", "b-c"),
                            "north": ("g-h", "h-i")}}


def supports(mesh, kind):
    named = EDGES.get(kind, {edge: (edge,) for edge in HELD})
    return [fx.Support(mesh, part if part in mesh.edges else "-".join(part.split("-")[::-1]), held)
            for edge, held in HELD.items() for part in named[edge]]


def deflection(angles, kind, axis=X, turned=0.0):
    """Of the middle of a simply supported plate under a load of 1 per area."""
    form, mesh = MESHES[kind]
    mesh = mesh()
    shell = fx.Shell(mesh, laminate(angles, turned), form=form, axis=axis)
    small = 1e-3 * ALONG * THICKNESS**4  # deflections below the thickness
    return response(fx.Scene([shell], supports(mesh, kind), [fx.SurfaceForce(shell, (0.0, 0.0, small))],
                             fx.Monitor(mesh, "middle", "z"))) / small


def stiffness_of_wave(angles, m, n):
    """Load of a wave over its deflection (Jones 1975, chapter 5, antisymmetric angle-ply; uncoupled: cross-ply)."""
    s = laminate(angles).stiffness()
    a, b, d = (np.array(block) for block in (s.membrane, s.coupling, s.bending))
    x, y = m * pi, n * pi
    t = np.array([[a[0, 0] * x**2 + a[2, 2] * y**2, (a[0, 1] + a[2, 2]) * x * y,
                   -3 * b[0, 2] * x**2 * y - b[1, 2] * y**3],
                  [0.0, a[1, 1] * y**2 + a[2, 2] * x**2, -b[0, 2] * x**3 - 3 * b[1, 2] * x * y**2], [0.0] * 3])
    t[1, 0], t[2, 0], t[2, 1] = t[0, 1], t[0, 2], t[1, 2]
    t[2, 2] = d[0, 0] * x**4 + 2 * (d[0, 1] + 2 * d[2, 2]) * x**2 * y**2 + d[1, 1] * y**4
    return t[2, 2] - t[2, :2] @ np.linalg.solve(t[:2, :2], t[:2, 2])


def series(angles):
    """Deflection of the middle under a load of 1 per area."""
    odd = range(1, 40, 2)
    return sum(16 / (pi**2 * m * n) * (-1) ** ((m + n) // 2 - 1) / stiffness_of_wave(angles, m, n)
               for m in odd for n in odd)


@pytest.mark.parametrize("angles", [CROSS, ANGLE], ids=["cross-ply", "angle-ply"])
@pytest.mark.parametrize("kind", MESHES)
@pytest.mark.slow(quick=1)
def test_plate_of_plies_bends(angles, kind):
    assert deflection(angles, kind) == pytest.approx(series(angles), rel=5e-3)


@pytest.mark.slow
def test_axis_and_angles_turn_together():
    """Fibres at the same directions, told from another axis."""
    axis = (np.cos(0.3), np.sin(0.3), 0.7)  # its part along the normal does not count
    assert deflection(ANGLE, "triangles", axis, np.degrees(0.3)) == pytest.approx(
        deflection(ANGLE, "triangles"), rel=1e-6)


@pytest.mark.slow
def test_plate_with_axes_around_its_middle():
    """Circular plate, clamped, that is stiffer around than along its radius.

    Its middle moves by q / (8 D_r (3 + k) (1 + k)), k^2 = D_t / D_r (Lekhnitskii 1968, chapter 10), which solves
    D_r (w'''' + 2 w''' / r) - D_t (w'' / r^2 - w' / r^3) = q. Axes are those of the cells' middles, but turn
    within those around the plate's middle: 2.3 % with cells of 0.1, 0.7 % with 0.05.
    """
    radial, around, poisson = 1e9, 4e9, 0.25
    section = fx.Laminate([fx.Ply(THICKNESS, 0.0, radial, around, poisson, 0.4e9)])

    def model():
        disc = gmsh.model.occ.addDisk(0, 0, 0, 1, 1)
        middle = gmsh.model.occ.addPoint(0, 0, 0)
        gmsh.model.occ.fragment([(2, disc)], [(0, middle)])
        gmsh.model.occ.synchronize()
        gmsh.option.setNumber("Mesh.MeshSizeMax", 0.05)
        gmsh.model.addPhysicalGroup(2, [tag for _, tag in gmsh.model.getEntities(2)], name="shell")
        gmsh.model.addPhysicalGroup(1, [tag for _, tag in gmsh.model.getEntities(1)], name="rim")
        gmsh.model.addPhysicalGroup(0, [middle], name="middle")

    mesh = fx.read(model, 3, 2)
    shell = fx.Shell(mesh, section, form="naghdi-t2", axis=lambda x: ufl.as_vector([x[0], x[1], 0.0]))
    small = 1e-3 * radial * THICKNESS**4
    found = response(fx.Scene([shell], [fx.clamp(mesh, "rim")], [fx.SurfaceForce(shell, (0.0, 0.0, small))],
                              fx.Monitor(mesh, "middle", "z"))) / small
    k = (around / radial) ** 0.5
    bending = section.stiffness().bending[0][0]
    assert found == pytest.approx(1 / (8 * bending * (3 + k) * (1 + k)), rel=1e-2)


@pytest.mark.slow
@pytest.mark.parametrize("angles", [CROSS, ANGLE], ids=["cross-ply", "angle-ply"])
def test_plate_of_plies_buckles(angles):
    """Under a force along x, at the lowest of Jones's loads."""
    form, mesh = MESHES["triangles"]
    mesh = mesh()
    shell = fx.Shell(mesh, laminate(angles), form=form, axis=X)
    held = HELD | {"east": "z rx", "north": "z ry"}
    scene = fx.Scene([shell], [fx.Support(mesh, edge, components) for edge, components in held.items()],
                     [fx.EdgeForce(mesh, "east", (-1.0, 0.0, 0.0))], fx.Monitor(mesh, "middle", "z"),
                     joints=[fx.Uniform(mesh, "east", "x"), fx.Uniform(mesh, "north", "y")])
    loads = sorted(stiffness_of_wave(angles, m, n) / (m * pi) ** 2 for m in range(1, 5) for n in range(1, 5))
    path = fx.Path(scene)
    assert fx.buckling(path, next(iter(path)), count=1)[0].load == pytest.approx(loads[0], rel=5e-3)


def test_wrong_plies_and_axes_are_refused():
    with pytest.raises(ValueError, match="Ply: thickness is -1"):
        fx.Ply(-1, 0.0, 1.0, 1.0, 0.3, 0.4)
    with pytest.raises(ValueError, match="Ply: poisson is 1.5; its square must be below"):
        fx.Ply(1.0, 0.0, 1.0, 1.0, 1.5, 0.4)
    with pytest.raises(ValueError, match="Laminate: plies is empty"):
        fx.Laminate([])
    mesh = fx.read(lambda: fx.meshes.rectangle((1, 1)), 3)
    with pytest.raises(ValueError, match=r"Shell: axis is None, but the stiffness of its Laminate differs"):
        fx.Shell(mesh, laminate(CROSS))
    with pytest.raises(ValueError, match="Shell: axis is along the normal"):
        fx.Shell(mesh, laminate(CROSS), axis=(0.0, 0.0, 1.0))
    with pytest.raises(ValueError, match=r"Shell: axis is \(1.0, 0.0\); it must be 3 numbers"):
        fx.Shell(mesh, laminate(CROSS), axis=(1.0, 0.0))


def test_section_of_equal_directions_needs_no_axis():
    assert fx.Plate(0.1).stiffness(fx.Elastic(1.0, 0.3)).isotropic
    assert fx.Laminate([fx.Ply(0.1, 30.0, 1.0, 1.0, 0.3, 1 / 2.6)]).stiffness().isotropic
    assert not laminate((0.0,)).stiffness().isotropic


def of_plies(angles, transverse=(0.5, 0.2), **more):
    given = {"along": 25.0, "across": 1.0, "poisson": 0.25, "shear": 0.5, "transverse": transverse} | more
    return fx.Laminate([fx.Ply(1 / len(angles), a, **given) for a in angles])


@pytest.mark.parametrize(("angles", "factor"), [((0.0, 90.0), 0.8209), ((0.0, 90.0, 0.0), 0.5828),
                                                ((0.0, 90.0, 90.0, 0.0), 0.5952), ((0.0, 0.0), 5 / 6)])
def test_transverse_shear_of_cross_plies(angles, factor):
    """Factors of Whitney (1973) for E1 = 25 E2, G12 = G13 = 0.5 E2, G23 = 0.2 E2, nu12 = 0.25."""
    whole = sum(0.5 if a == 0 else 0.2 for a in angles) / len(angles)
    assert of_plies(angles).stiffness().shear[0][0] == pytest.approx(factor * whole, rel=2e-4)


@pytest.mark.parametrize("seed", range(10))
def test_transverse_shear_turns_with_the_plies(seed):
    random = np.random.default_rng(seed)
    angles, turn = random.uniform(-90, 90, random.integers(1, 6)), random.uniform(-90, 90)
    c, s = np.cos(np.radians(turn)), np.sin(np.radians(turn))
    turned = np.array([[c, s], [-s, c]])
    here, there = (np.array(of_plies(a).stiffness().shear) for a in (angles, angles - turn))
    assert turned.T @ there @ turned == pytest.approx(here, rel=1e-9, abs=1e-10)
    assert np.array(of_plies(angles[::-1]).stiffness().shear) == pytest.approx(here, rel=1e-9, abs=1e-10)


@pytest.mark.silent("q01")
@pytest.mark.parametrize("seed", range(10))
def test_transverse_shear_of_random_sandwiches(seed):
    """G d^2 / c for thin stiff faces a distance d apart on a core c (Allen 1969), also of faces that are not equal."""
    random = np.random.default_rng(seed)
    core, faces, angle = random.uniform(0.5, 2.0), random.uniform(0.002, 0.01, 2), random.uniform(-90, 90)
    moduli = random.uniform(1e3, 5e3, 2)
    face = {"along": 1e7, "across": 1e7, "poisson": 0.3, "shear": 1e7 / 2.6}
    with pytest.warns(UserWarning, match="transverse shear moduli of its plies differ by a factor"):
        section = fx.Laminate([fx.Ply(faces[0], 0.0, **face),
                               fx.Ply(core, angle, 1e2, 1e2, 0.0, 1e2, transverse=tuple(moduli)),
                               fx.Ply(faces[1], 0.0, **face)])
    c, s = np.cos(np.radians(angle)), np.sin(np.radians(angle))
    turned = np.array([[c, s], [-s, c]])
    right = turned.T @ np.diag(moduli) @ turned * (core + faces.mean()) ** 2 / core
    assert np.array(section.stiffness().shear) == pytest.approx(right, rel=2e-3, abs=2e-3 * right.max())


def test_plies_of_one_material_have_five_sixths():
    """However many they are; a factor that is given is taken on the sum."""
    for count in (1, 2, 5):
        plies = [fx.Ply(0.3 / (i + 1), 20.0, 2.0, 2.0, 0.3, 2 / 2.6) for i in range(count)]
        whole = sum(p.thickness for p in plies) * 2 / 2.6
        assert fx.Laminate(plies).stiffness().shear[1][1] == pytest.approx(5 / 6 * whole, rel=1e-12)
        assert fx.Laminate(plies, shear_factor=0.7).stiffness().shear[0][0] == pytest.approx(0.7 * whole)


def test_plies_have_their_own_mass():
    """Mass, its centre and the inertia about that; plies without a density have that of the material."""
    plies = [fx.Ply(t, 0.0, 1.0, 1.0, 0.3, 0.4, density=d) for t, d in ((0.1, 8.0), (0.3, None), (0.2, 2.0))]
    section, material = fx.Laminate(plies), fx.Elastic(1.0, 0.3, density=0.5)
    pieces = [(-0.25, 0.1, 8.0), (-0.05, 0.3, 0.5), (0.2, 0.2, 2.0)]  # middle, thickness, density
    mass = sum(t * d for _, t, d in pieces)
    centre = sum(z * t * d for z, t, d in pieces) / mass
    rotary = sum(d * (t**3 / 12 + t * (z - centre) ** 2) for z, t, d in pieces)
    assert [*section.inertia(material), section.mass_centre(material)] == pytest.approx([mass, rotary, centre])
    assert not section.weighs(None)
    assert fx.Laminate([plies[0], plies[2]]).weighs(None)


def swings(section, material=None):
    mesh = fx.read(lambda: fx.meshes.rectangle((6, 1), (1.0, 0.2)), 3, 2)
    shell = fx.Shell(mesh, section, material, axis=X)
    scene = fx.Scene([shell], [fx.clamp(mesh, "west")], [fx.EdgeForce(mesh, "east", (0.0, 0.0, 1.0))],
                     fx.Monitor(mesh, "south-east", "z"))
    path = fx.Path(scene)
    return [v.frequency for v in frequencies(path, next(iter(path)), 3)]


@pytest.mark.silent("q16")
def test_frequencies_of_plies_with_densities():
    """Those of a plate of one material; without densities plies are named."""
    ply = {"angle": 0.0, "along": 1.0, "across": 1.0, "poisson": 0.3, "shear": 1 / 2.6}
    right = swings(fx.Plate(0.04), fx.Elastic(1.0, 0.3, density=2.0))
    assert swings(fx.Laminate([fx.Ply(0.01, density=2.0, **ply)] * 4)) == pytest.approx(right, rel=1e-6)
    heavy = [fx.Ply(0.01, density=d, **ply) for d in (1.0, 3.0, 1.0, 3.0)]  # of the same mean
    assert swings(fx.Laminate(heavy))[0] == pytest.approx(right[0], rel=1e-2)
    with pytest.raises(ValueError, match="has no density; give each Ply one"):
        swings(fx.Laminate([fx.Ply(0.04, **ply)]))


@pytest.mark.parametrize("seed", range(6))
def test_stiffness_of_random_plies_is_that_of_turned_tensors(seed):
    """Compliances of an orthotropic solid in plane stress, turned as tensors and summed over thin slices."""
    random = np.random.default_rng(seed)
    plies = [fx.Ply(*random.uniform((0.1, -90.0, 5.0, 1.0, 0.1, 0.5), (1.0, 90.0, 20.0, 3.0, 0.4, 1.0)))
             for _ in range(random.integers(1, 6))]
    blocks, bottom = np.zeros((3, 3, 3)), -sum(ply.thickness for ply in plies) / 2
    for ply in plies:
        side = -ply.poisson / ply.along
        own = np.linalg.inv([[1 / ply.along, side, 0], [side, 1 / ply.across, 0], [0, 0, 1 / ply.shear]])
        tensor = np.zeros((2, 2, 2, 2))
        pairs = [(0, 0), (1, 1), (0, 1)]
        for i, one in enumerate(pairs):
            for j, two in enumerate(pairs):
                for a, b in (one, one[::-1]):
                    tensor[a, b, two[0], two[1]] = tensor[a, b, two[1], two[0]] = own[i, j]
        c, s = np.cos(np.radians(ply.angle)), np.sin(np.radians(ply.angle))
        turn = np.array([[c, -s], [s, c]])
        tensor = np.einsum("ai,bj,ck,dl,ijkl", turn, turn, turn, turn, tensor)
        turned = np.array([[tensor[(*one, *two)] for two in pairs] for one in pairs])
        points, weights = np.polynomial.legendre.leggauss(2)
        for z, weight in zip(bottom + ply.thickness * (1 + points) / 2, weights * ply.thickness / 2, strict=True):
            blocks += weight * turned * np.array([1.0, z, z * z])[:, None, None]
        bottom += ply.thickness
    found = fx.Laminate(plies).stiffness()
    for block, given in zip(blocks, (found.membrane, found.coupling, found.bending), strict=True):
        assert np.array(given) == pytest.approx(block, rel=1e-9, abs=1e-9 * np.abs(block).max() + 1e-12)


def solid_strip(plies, wave):
    """Deflection of the middle of a strip under a load sin(wave x) of 1 on its top, as a solid in plane strain.

    Displacements and stresses (u, w, s_z, t_xz) of a ply have constant rates along z (Pagano 1969, in the form of a
    state space); those of its faces are joined by matrix exponentials. Plies are as stiff along z as across.
    """
    through = np.eye(4)
    for ply in plies:
        order = [0, 1, 2] if ply.angle == 0 else [1, 0, 2]
        n1, n2 = ply.poisson / ply.along, ply.poisson / ply.across  # contraction across fibres by stress along, across
        own = np.array([[1 / ply.along, -n1, -n1], [-n1, 1 / ply.across, -n2], [-n1, -n2, 1 / ply.across]])
        stiffness, shear = np.linalg.inv(own[order][:, order]), ply.transverse[order[0]]
        c11, c13, c33 = stiffness[0, 0], stiffness[0, 2], stiffness[2, 2]
        rate = np.array([[0, -wave, 0, 1 / shear], [wave * c13 / c33, 0, 1 / c33, 0], [0, 0, 0, wave],
                         [wave**2 * (c11 - c13**2 / c33), 0, -wave * c13 / c33, 0]])
        through = expm(rate * ply.thickness) @ through
    free = np.linalg.solve(through[2:, :2], [1.0, 0.0])  # the bottom is free of stress, the top carries s_z
    return (free[1] + (through @ [*free, 0.0, 0.0])[1]) / 2


@pytest.mark.silent("q01")
@pytest.mark.parametrize("seed", range(8))
def test_transverse_shear_of_random_cross_plies_against_the_solid(seed):
    """Deflections of strips ten times as long as thick: 1 / (D w^4) + 1 / (S w^2) is within 1.5 % of the solid's.

    D is the bending stiffness without membrane forces.
    """
    random = np.random.default_rng(seed)
    plies = [fx.Ply(thickness, angle, 25.0, 1.0, 0.25, 0.5, transverse=(0.5, 0.2))
             for thickness, angle in zip(random.uniform(0.5, 1.0, 4), random.choice((0.0, 90.0), 4), strict=True)]
    section = fx.Laminate(plies)
    wave, found = pi / 10 / section.thickness, section.stiffness()
    bending = found.bending[0][0] - found.coupling[0][0] ** 2 / found.membrane[0][0]
    deflection = 1 / bending / wave**4 + 1 / found.shear[0][0] / wave**2
    assert deflection == pytest.approx(solid_strip(plies, wave), rel=1.5e-2)


@pytest.mark.silent("q01")
def test_sandwich_of_a_soft_core():
    """NAFEMS R0031/3: hinged, 10 in square, under 100 psi; 0.1222 in by Navier's series with the core's shear."""
    face = {"along": 1e7, "across": 4e6, "poisson": 0.3, "shear": 1.875e6}
    core = fx.Ply(0.75, 0.0, 10.0, 10.0, 0.0, 10.0, transverse=(3e4, 1.2e4))
    with pytest.warns(UserWarning, match="transverse shear moduli of its plies differ by a factor"):
        section = fx.Laminate([fx.Ply(0.028, 0.0, **face), core, fx.Ply(0.028, 0.0, **face)])
    mesh = fx.read(lambda: fx.meshes.rectangle((4, 4), (5.0, 5.0)), 3, 2)
    shell = fx.Shell(mesh, section, axis=X)
    scene = fx.Scene([shell], [fx.symmetry(mesh, "east", "x"), fx.symmetry(mesh, "north", "y"),
                               fx.Support(mesh, "west", "y z rx"), fx.Support(mesh, "south", "x z ry")],
                     [fx.SurfaceForce(shell, (0.0, 0.0, -100.0))], fx.Monitor(mesh, "north-east", "z", -1.0))
    assert response(scene) == pytest.approx(0.1222, rel=5e-3)
