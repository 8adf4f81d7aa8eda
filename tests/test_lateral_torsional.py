"""Lateral-torsional buckling of open sections: beams, which lack warping, beside shells of the same plates.

A cantilever without warping buckles by a force at its tip at 4.013 sqrt(E I_z G I_t) / L^2 (Timoshenko and Gere 1961,
section 6.4). The beam has that; clamped plates, which hold warping at the root, need about twice the force where the
length is two to three times the root of E I_w / (G I_t).
"""

from __future__ import annotations

from math import sqrt

import pytest
from helpers import straight

import sheetfx as fx

MATERIAL = fx.Elastic(2.1e5, 0.3)
LENGTH, HEIGHT, WIDTH, FLANGE, WEB = 2000.0, 200.0, 100.0, 8.0, 6.0  # height between the middles of the flanges


def plates(kind):
    """Flanges across z at z = 0 and HEIGHT, on both sides of the web's plane y = 0 or on one, as gmsh source."""
    import gmsh

    geo = gmsh.model.geo
    sides = (-WIDTH / 2, WIDTH / 2) if kind == "I" else (WIDTH - WEB / 2,)
    places = {(y, z): [geo.addPoint(x, y, z) for x in (0.0, LENGTH)] for z in (0.0, HEIGHT) for y in (0.0, *sides)}
    along = {place: geo.addLine(*ends) for place, ends in places.items()}
    strips = [((0.0, z), (y, z), 2) for z in (0.0, HEIGHT) for y in sides] + [((0.0, 0.0), (0.0, HEIGHT), 4)]
    groups = {"flanges": [], "web": [], "west": [], "lower": [], "upper": [], "tip": []}
    for one, other, cells in strips:
        across = [geo.addLine(places[one][end], places[other][end]) for end in (0, 1)]
        surface = geo.addPlaneSurface([geo.addCurveLoop([along[one], across[1], -along[other], -across[0]])])
        groups["web" if cells == 4 else "flanges"].append(surface)
        groups["west"].append(across[0])
        groups["tip" if cells == 4 else "upper" if one[1] else "lower"].append(across[1])
        for line in across:
            geo.mesh.setTransfiniteCurve(line, cells + 1)
        for line in (along[one], along[other]):
            geo.mesh.setTransfiniteCurve(line, 11)
        geo.mesh.setTransfiniteSurface(surface)
        geo.mesh.setRecombine(2, surface)
    geo.synchronize()
    for name, entities in groups.items():
        gmsh.model.addPhysicalGroup(2 if name in ("flanges", "web") else 1, entities, name=name)
    gmsh.model.addPhysicalGroup(0, [places[0.0, 0.0][1]], name="corner")


def first_load(scene):
    record = fx.trace(fx.Case(scene, until=fx.Until(steps=0)))
    return min(abs(b.factor) for b in record.buckling(record.states[0], count=2))


@pytest.mark.slow
@pytest.mark.parametrize(("kind", "share"), [("I", 0.493), ("C", 0.472)])
def test_cantilever_with_a_force_at_its_tip(kind, share):
    """The force acts along the web, in the shear centre: of the C by a couple of the flanges beside it.

    `share` is the beam's load over that of the shells, by this program on these meshes.
    """
    made = fx.ISection if kind == "I" else fx.CSection
    section = made(HEIGHT + FLANGE, WIDTH, WEB, FLANGE)
    aside = 0.0 if kind == "I" else section.shear_centre[1]
    mesh = straight(8, LENGTH, dimension=3)
    with pytest.warns(UserWarning, match="do not model warping"):
        beam = fx.Beam(mesh, section, MATERIAL, up=(0.0, 0.0, 1.0))
    # The binormal is -y: a force along -z at its shear centre has the moment of its arm y = -aside about the centroid.
    loads = [fx.PointForce(mesh, "tip", (0.0, 0.0, -1.0))]
    if aside:
        loads.append(fx.Moment(mesh, "tip", (aside, 0.0, 0.0)))
    by_beam = first_load(fx.Scene([beam], [fx.clamp(mesh, "base")], loads, fx.Monitor(mesh, "tip", "z", -1.0)))
    mesh = fx.read(lambda: plates(kind), 3)
    shells = [fx.Shell(mesh, fx.Plate(t), MATERIAL, group=g) for g, t in (("flanges", FLANGE), ("web", WEB))]
    loads = [fx.EdgeForce(mesh, "tip", (0.0, 0.0, -1 / HEIGHT))]
    if aside:
        arm = abs(aside + section.centroid[1] - WEB / 2) / HEIGHT / (WIDTH - WEB / 2)
        loads += [fx.EdgeForce(mesh, "upper", (0.0, -arm, 0.0)), fx.EdgeForce(mesh, "lower", (0.0, arm, 0.0))]
    by_shells = first_load(fx.Scene(shells, [fx.clamp(mesh, "west")], loads, fx.Monitor(mesh, "corner", "z", -1.0)))
    stiff = sqrt(MATERIAL.modulus * section.second_moments[0] * MATERIAL.shear_modulus * section.torsion)
    assert by_beam == pytest.approx(4.013 * stiff / LENGTH**2, rel=1e-2)
    assert by_beam / by_shells == pytest.approx(share, rel=3e-2)
