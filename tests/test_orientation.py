"""Cells of random directions run alike once they are read: by the theorem of Gauss, whatever side is the first's."""

from __future__ import annotations

import gmsh
import numpy as np
import pytest
import ufl
from dolfinx import fem

import sheetfx as fx
from sheetfx import forms

SIDES = [(1, 2, 3, 4), (5, 8, 7, 6), (1, 5, 6, 2), (2, 6, 7, 3), (3, 7, 8, 4), (4, 8, 5, 1)]  # of a box, all outward
PLACES = [(x, y, z) for z in (0.0, 1.0) for x, y in ((0, 0), (1, 0), (1, 1), (0, 1))]

pytestmark = pytest.mark.filterwarnings("ignore:.*ran against:UserWarning")


def box(reversed_sides, names, triangles=False, divisions=2, web=False):
    """Faces of a box with some loops the other way; `names` gives groups of faces; a web within halves it."""

    def source():
        geo = gmsh.model.geo
        points = [geo.addPoint(*x) for x in PLACES]
        middles = [geo.addPoint(0.5, y, z) for y, z in ((0, 0), (1, 0), (1, 1), (0, 1))] if web else []
        lines, faces = {}, []

        def face(corners, against):
            loop = []
            for a, b in zip(corners, [*corners[1:], corners[0]], strict=True):
                key = min(a, b), max(a, b)
                if key not in lines:
                    lines[key] = geo.addLine(*key)
                    geo.mesh.setTransfiniteCurve(lines[key], divisions + 1)
                loop.append(lines[key] * (1 if (a, b) == key else -1))
            loop = [-c for c in loop[::-1]] if against else loop
            surface = geo.addPlaneSurface([geo.addCurveLoop(loop)])
            geo.mesh.setTransfiniteSurface(surface)
            if not triangles:
                geo.mesh.setRecombine(2, surface)
            return surface

        number = dict(enumerate(points, 1))
        for side, against in zip(SIDES, reversed_sides, strict=False):
            corners = [number[i] for i in side]
            halves = [corners]
            if web and len({PLACES[i - 1][0] for i in side}) == 2:  # across the web: in two
                halves = _halves(corners, middles, points)
            faces.append([face(half, against) for half in halves])
        if web:
            faces.append([face(middles, reversed_sides[-1])])
        geo.synchronize()
        for name, chosen in names.items():
            gmsh.model.addPhysicalGroup(2, [tag for i in chosen for tag in faces[i]], name=name)

    return source


def _halves(corners, middles, points):
    """A face between x = 0 and 1 in two at the web, each around the same way."""
    place = dict(zip(points, PLACES, strict=True)) | dict(zip(
        middles, [(0.5, y, z) for y, z in ((0, 0), (1, 0), (1, 1), (0, 1))], strict=True))
    by_place = {x: tag for tag, x in place.items()}
    ring = []
    for a, b in zip(corners, [*corners[1:], corners[0]], strict=True):
        ring.append(a)
        if place[a][0] != place[b][0]:
            ring.append(by_place[(0.5, *place[a][1:])])
    start = next(i for i, tag in enumerate(ring) if tag in middles)
    ring = ring[start:] + ring[:start]
    return [ring[:4], [ring[3], ring[4], ring[5], ring[0]]]


def enclosed(mesh, group=None):
    """Integral of x . n / 3 over the surfaces of a group: the volume in it."""
    density = ufl.dot(ufl.SpatialCoordinate(mesh.domain), forms.shell.unit_normal(mesh.domain)) / 3
    dx = mesh.integral({"quadrature_degree": 8}, group)
    return mesh.domain.comm.allreduce(fem.assemble_scalar(fem.form(density * dx)))


@pytest.mark.silent("b02")
@pytest.mark.parametrize("seed", range(6))
@pytest.mark.slow(quick=1)
def test_box_of_random_sides_encloses_its_volume(seed):
    """Curved cells of all orders too: the place moves all but the volume, by a shear that is not linear."""
    random = np.random.default_rng(seed)
    order, names = 1 + seed % 3, [{"box": range(6)}, {str(i): [i] for i in range(6)}][seed % 2]
    mesh = fx.read(box(random.integers(2, size=6), names, triangles=seed % 4 > 1), 3, order,
                   lambda x: x + 0.3 * np.column_stack((x[:, 1] ** order, 0 * x[:, 0], 0 * x[:, 0])))
    assert abs(enclosed(mesh)) == pytest.approx(1.0, rel=1e-9)
    assert not mesh.opposed


@pytest.mark.parametrize("seed", range(4))
def test_sides_with_a_web_run_alike(seed):
    """Three cells meet at the web's edges: the sides go on straight there, or are a group of their own."""
    random = np.random.default_rng(seed)
    names = [{"all": range(7)}, {"web": [6], "box": range(6)}][seed % 2]
    mesh = fx.read(box(random.integers(2, size=7), names, divisions=1, web=True), 3)
    web = 0.5 / 3  # x . n of the web, either way
    assert min(abs(abs(enclosed(mesh)) - volume) for volume in (1 - web, 1 + web)) < 1e-9
    assert not mesh.opposed


def arcs(reversed_arcs, one_group):
    def source():
        geo, angles = gmsh.model.geo, np.arange(4) * np.pi / 2
        centre, points = geo.addPoint(0, 0, 0), [geo.addPoint(np.cos(a), np.sin(a), 0) for a in angles]
        curves = []
        for i, against in enumerate(reversed_arcs):
            ends = (points[i], points[(i + 1) % 4])[::-1 if against else 1]
            curves.append(geo.addCircleArc(ends[0], centre, ends[1]))
            geo.mesh.setTransfiniteCurve(curves[-1], 6)
        geo.synchronize()
        for name, chosen in ({"ring": curves} if one_group else dict(zip("abcd", ([c] for c in curves), strict=True))
                             ).items():
            gmsh.model.addPhysicalGroup(1, chosen, name=name)

    return source


@pytest.mark.silent("b04")
@pytest.mark.parametrize("seed", range(4))
def test_ring_of_random_arcs_runs_round(seed):
    mesh = fx.read(arcs(np.random.default_rng(seed).integers(2, size=4), one_group=True), 2, 1 + seed % 3)
    normal = forms.beam.curve_frame(mesh.domain).normal
    area = fem.assemble_scalar(fem.form(ufl.dot(ufl.SpatialCoordinate(mesh.domain), normal) / 2 * ufl.dx))
    assert abs(area) == pytest.approx(np.pi, rel=2e-2)


def test_bars_of_groups_of_their_own_keep_their_direction():
    """Columns of a frame run from their feet; what goes by a direction is refused of them all together."""
    nodes = {"a": (0, 0), "b": (0, 1), "c": (2, 1), "d": (2, 0)}
    members = {"left": ("a", "b", 2), "top": ("b", "c", 2), "right": ("d", "c", 2)}
    mesh = fx.read(lambda: fx.meshes.frame(nodes, members), 2)
    assert mesh.chords("right")[:, 1].min() == 1.0
    frame = fx.Beam(mesh, fx.Rectangle(0.1, 0.1), fx.Elastic(1e5))
    right = fx.Beam(mesh, fx.Rectangle(0.1, 0.1), fx.Elastic(1e5), group="right")
    fx.LinePressure(right, 1.0)
    with pytest.raises(ValueError, match=r"LinePressure: cells of group 'all' run against each other at \(1.5, 1\)"):
        fx.LinePressure(frame, 1.0)
    with pytest.raises(ValueError, match="Beam: offset: cells of group 'all' run against"):
        fx.Beam(mesh, fx.Rectangle(0.1, 0.1), fx.Elastic(1e5), offset=0.1)
    space = fx.read(lambda: fx.meshes.frame({n: (*x, 0.0) for n, x in nodes.items()}, members), 3)
    fx.Beam(space, fx.Rectangle(0.1, 0.1), fx.Elastic(1e5), offset=(0.1, 0.0))
    with pytest.raises(ValueError, match="Beam: offset: cells of group 'all' run against"):
        fx.Beam(space, fx.Rectangle(0.1, 0.1), fx.Elastic(1e5), offset=(0.1, 0.1))


def test_bars_of_a_structure_keep_their_direction(recwarn):
    """In spite of a group of all of them."""
    table = fx.meshes.Table(nodes={"a": (0, 0, 0), "b": (1, 0, 0), "c": (1, 1, 0)}, bars=[("a", "b"), ("c", "b")])
    mesh = fx.read(lambda: fx.meshes.structure(table, 2), 3)
    assert mesh.chords("bar c-b")[:, 1].max() == -1.0
    assert set(mesh.opposed) == {"bars", None}
    assert not [w for w in recwarn if "ran against" in str(w.message)]


def test_turned_cells_are_said_once(recwarn):
    fx.read(box([1, 0, 0, 1, 0, 0], {"box": range(6)}), 3)
    said = [str(w.message) for w in recwarn if "ran against" in str(w.message)]
    assert len(said) == 1
    assert "16 cells of 'box' ran against" in said[0] or "8 cells of 'box' ran against" in said[0]


def strip(turns):
    """A band with half turns, closed by hand: its last cell meets the first either way."""
    count, angles = 12, np.arange(12) * 2 * np.pi / 12
    rows = [[(np.cos(a) * (1 + r * np.cos(turns * a / 2)), np.sin(a) * (1 + r * np.cos(turns * a / 2)),
              r * np.sin(turns * a / 2)) for a in angles] for r in (-0.2, 0.2)]

    def source():
        tag = gmsh.model.addDiscreteEntity(2)
        gmsh.model.mesh.addNodes(2, tag, list(range(1, 2 * count + 1)), np.ravel(rows))
        ends = [(i, (i + 1) % count) for i in range(count)]
        cells = [(i + 1, j + 1, count + j + 1, count + i + 1) for i, j in ends[:-1]]
        cells.append((count, 1 + count, 1, 2 * count) if turns % 2 else (count, 1, 1 + count, 2 * count))
        gmsh.model.mesh.addElementsByType(tag, 3, [], np.ravel(cells))
        gmsh.model.addPhysicalGroup(2, [tag], name="strip")

    return source


def test_strip_of_one_side_is_refused_where_sides_matter():
    for turns in (1, 2):
        mesh = fx.read(strip(turns), 3)
        shell = fx.Shell(mesh, fx.Plate(0.01), fx.Elastic(1e5))
        if turns == 2:
            fx.Pressure(shell, 1.0)
            continue
        with pytest.raises(ValueError, match="Pressure: cells of group 'all' run against each other at .* Möbius"):
            fx.Pressure(shell, 1.0)
        with pytest.raises(ValueError, match="Shell: offset: cells of group 'all' run against each other"):
            fx.Shell(mesh, fx.Plate(0.01), fx.Elastic(1e5), offset=0.1)


def tube(sides, reversed_panels, triangles=False):
    """A prism of a unit radius and length 2, open at its ends, of panels of which some run the other way."""

    def source():
        geo, count = gmsh.model.geo, len(reversed_panels)
        rings = [[geo.addPoint(x, np.cos(a), np.sin(a)) for a in 2 * np.pi * np.arange(count) / count] for x in (0, 2)]
        around = [[geo.addLine(ring[i], ring[(i + 1) % count]) for i in range(count)] for ring in rings]
        along = [geo.addLine(a, b) for a, b in zip(*rings, strict=True)]
        faces = []
        for i, against in enumerate(reversed_panels):
            loop = [around[0][i], along[(i + 1) % count], -around[1][i], -along[i]]
            faces.append(geo.addPlaneSurface([geo.addCurveLoop([-c for c in loop[::-1]] if against else loop)]))
        for curve in (*around[0], *around[1], *along):
            geo.mesh.setTransfiniteCurve(curve, 2)
        for face in faces:
            geo.mesh.setTransfiniteSurface(face)
            if not triangles:
                geo.mesh.setRecombine(2, face)
        geo.synchronize()
        for name, chosen in sides.items():
            gmsh.model.addPhysicalGroup(2, [faces[i] for i in chosen], name=name)
        gmsh.model.addPhysicalGroup(1, around[0], name="foot")
        gmsh.model.addPhysicalGroup(1, around[1], name="head")
        gmsh.model.addPhysicalGroup(0, [rings[1][0]], name="corner")

    return source


def pushed_out(mesh, offset, angles):
    """Energy of a clamped tube under a pressure and a force at its head, and what of these its foot carries."""
    section = fx.Plate(0.05)
    if len(angles):
        section = fx.Laminate([fx.Ply(0.03, a, along=20.0, across=1.0, poisson=0.3, shear=0.5) for a in angles])
    shell = fx.Shell(mesh, section, fx.Elastic(10.0, 0.3), offset=offset, axis=(1.0, 0.0, 0.0))
    loads = [fx.Pressure(shell, 1e-3), fx.PointForce(mesh, "corner", (0.0, 2e-4, 1e-4))]
    scene = fx.Scene([shell], [fx.clamp(mesh, "foot")], loads, fx.Monitor(mesh, "corner", "y"))
    record = fx.trace(fx.Case(scene, fx.LoadControl(1.0, fixed=True)))
    record.show(record.states[-1])
    return record.energies()[0], record.reactions("foot").force[-1]


@pytest.mark.silent("b02")
@pytest.mark.parametrize("seed", [3, *(pytest.param(s, marks=pytest.mark.slow) for s in (0, 1, 2, 4, 5))])
def test_tube_of_random_panels_is_one_of_two(seed):
    """All its normals point in or out: with plies or an offset it is one of these, and pressure carries itself."""
    random = np.random.default_rng(seed)
    count = random.integers(3, 6)
    offset, angles = [(random.uniform(0.02, 0.05), ()), (0.0, random.uniform(-90, 90, 2))][seed % 2]
    group = {"tube": range(count)}
    right = [pushed_out(fx.read(tube(group, [way] * count), 3, 2), offset, angles)[0] for way in (0, 1)]
    mesh = fx.read(tube(group, random.integers(2, size=count)), 3, 2)
    energy, force = pushed_out(mesh, offset, angles)
    assert min(abs(energy / one - 1) for one in right) < 1e-6
    assert max(right) / min(right) - 1 > 1e-3, "the sides differ"
    assert force[1:] == pytest.approx((-2e-4, -1e-4), abs=1e-5), "a pressure within a tube carries itself"
    assert abs(enclosed(mesh)) == pytest.approx(2 * count * np.sin(2 * np.pi / count) / 3, rel=1e-9)


@pytest.mark.silent("b04")
@pytest.mark.parametrize("opposite", [False, True])
def test_pressure_on_an_arch_of_two_curves(opposite):
    """Clamped, of a radius of 100 and 2 thick: clamps carry (82.0, 56.5) and (-82.0, 56.5), or these away from it."""
    def source():
        geo, angles = gmsh.model.geo, (-0.6, 0.0, 0.6)
        centre, points = geo.addPoint(0, 0, 0), [geo.addPoint(100 * np.sin(a), 100 * np.cos(a), 0) for a in angles]
        ends = [points[:2], points[1:][::-1 if opposite else 1]]
        curves = [geo.addCircleArc(a, centre, b) for a, b in ends]
        geo.synchronize()
        for curve in curves:
            gmsh.model.mesh.setTransfiniteCurve(curve, 11)
        gmsh.model.addPhysicalGroup(1, curves, name="arch")
        for name, point in (("left", points[0]), ("top", points[1]), ("right", points[2])):
            gmsh.model.addPhysicalGroup(0, [point], name=name)

    mesh = fx.read(source, 2, order=2)
    beam = fx.Beam(mesh, fx.Rectangle(1.0, 2.0), fx.Elastic(1e5))
    scene = fx.Scene([beam], [fx.clamp(mesh, "left"), fx.clamp(mesh, "right")], [fx.LinePressure(beam, -1.0)],
                     fx.Monitor(mesh, "top", "y"))
    record = fx.trace(fx.Case(scene, fx.LoadControl(0.5)))
    left, right = (record.reactions(name).force[-1] for name in ("left", "right"))
    assert left * np.sign(left[1]) == pytest.approx((82.0, 56.5), abs=0.1)
    assert right == pytest.approx(left * (-1, 1), rel=1e-6)
