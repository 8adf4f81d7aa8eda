"""Flat cells of curved surfaces, raised to second order by normals fitted to their neighbours."""

from __future__ import annotations

import warnings
from math import pi

import gmsh
import numpy as np
import pytest
from helpers import on_two_processes

import sheetfx as fx


def sphere(x):
    a, b = 1.3 * x[:, 0], 1.2 * x[:, 1] - 0.3
    return np.column_stack((np.cos(a) * np.cos(b), np.sin(a) * np.cos(b), np.sin(b)))


def cylinder(x):
    return np.column_stack((x[:, 0], np.sin(pi / 2 * x[:, 1]), np.cos(pi / 2 * x[:, 1])))


def saddle(x):
    a, b = x[:, 0] - 0.5, x[:, 1] - 0.5
    return np.column_stack((a, b, a**2 - b**2))


SHAPES = {"sphere": (sphere, lambda x: np.linalg.norm(x, axis=1) - 1),
          "cylinder": (cylinder, lambda x: np.hypot(x[:, 1], x[:, 2]) - 1),
          "saddle": (saddle, lambda x: x[:, 2] - x[:, 0] ** 2 + x[:, 1] ** 2)}


def flat(file, place, build):
    """A file of first-order cells whose vertices are on a surface."""
    gmsh.initialize()
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        build()
        gmsh.model.mesh.generate(2)
        numbers, x, _ = gmsh.model.mesh.getNodes()
        for number, at in zip(numbers, place(x.reshape(-1, 3)), strict=True):
            gmsh.model.mesh.setNode(int(number), at, [])
        gmsh.write(str(file))
    finally:
        gmsh.finalize()
    return file


def square(cells, triangles, lengths=(1.0, 1.0)):
    return lambda: fx.meshes.rectangle(cells, lengths, triangles)


def off(tmp_path, name, cells, triangles):
    """Root mean square of the distances of all nodes from the surface that the vertices are on."""
    place, distance = SHAPES[name]
    file = flat(tmp_path / f"{cells}.msh", place, square((cells, cells), triangles))
    with pytest.warns(UserWarning, match=f"raised {cells**2 * (1 + triangles)} flat cells of 'shell' to order 2, .*"
                                         "largest rise 0.*order=1 leaves them flat"):
        mesh = fx.read(file, 3)
    return np.sqrt(np.mean(distance(mesh.domain.geometry.x) ** 2))


@pytest.mark.parametrize("triangles", [True, False])
@pytest.mark.parametrize("name", SHAPES)
def test_nodes_come_to_lie_on_the_surface(tmp_path, name, triangles):
    """With the third power of the size of cells or more, the rises fall with the second."""
    coarse, fine = (off(tmp_path, name, n, triangles) for n in (8, 16))
    assert fine < coarse / 2**2.9
    assert fine < 1e-4


@pytest.mark.parametrize("triangles", [True, False])
def test_flat_cells_and_folds_stay(tmp_path, triangles):
    """Panels of several cells at 90 and at 8 degrees: nothing is raised, and nothing said."""
    nodes = {"a": (0, 0, 0), "b": (1, 0, 0), "c": (1, 1, 0), "d": (0, 1, 0), "e": (2, 0, 0.14), "f": (2, 1, 0.14),
             "g": (0, 0, 1), "h": (0, 1, 1)}
    faces = {"floor": "abcd", "ramp": "befc", "wall": "adhg"}
    file = flat(tmp_path / "panels.msh", lambda x: x, lambda: fx.meshes.panels(nodes, faces, 4, triangles))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        mesh = fx.read(file, 3)
    assert mesh.measure == pytest.approx(2 + np.hypot(1, 0.14), rel=1e-14)


@pytest.mark.parametrize("divisions, triangles", [(1, True), (2, True), (2, False), (3, True)])
def test_dome_of_flat_panels_stays(tmp_path, divisions, triangles):
    """Few cells a panel, at angles of 17 degrees: from a file as from the geometry."""
    def build():
        fx.meshes.structure(fx.meshes.dome("hex"), divisions, triangles)

    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for source in (build, flat(tmp_path / "dome.msh", lambda x: x, build)):
            assert fx.read_mixed(source, bars=["bars"]).surfaces.degree == 1


def test_cells_on_the_rim_of_a_fold_share_its_circle(tmp_path):
    """A cup: wall of a cylinder on a flat floor. The wall is raised, and the floor's rim with it."""
    def build():
        disk = gmsh.model.occ.addDisk(0, 0, 0, 1, 1)
        gmsh.model.occ.synchronize()
        gmsh.model.occ.extrude(gmsh.model.getBoundary([(2, disk)]), 0, 0, 1)
        gmsh.model.occ.synchronize()
        surfaces = [tag for _, tag in gmsh.model.getEntities(2)]
        gmsh.model.addPhysicalGroup(2, surfaces, name="cup")
        gmsh.option.setNumber("Mesh.MeshSizeMax", 0.3)

    with pytest.warns(UserWarning, match="raised .* flat cells of 'cup'"):
        mesh = fx.read(flat(tmp_path / "cup.msh", lambda x: x, build), 3)
    x = mesh.domain.geometry.x
    radius, rim = np.hypot(x[:, 0], x[:, 1]), np.isclose(x[:, 2], 0.0)
    assert radius[x[:, 2] > 1e-9] == pytest.approx(1.0, abs=2e-4)
    assert x[rim, 2] == pytest.approx(0.0, abs=1e-12)
    assert mesh.measure == pytest.approx(3 * pi, rel=2e-4)


def test_order_1_leaves_cells_flat(tmp_path):
    file = flat(tmp_path / "flat.msh", cylinder, square((4, 8), True))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        mesh = fx.read(file, 3, order=1)
    assert mesh.measure == pytest.approx(16 * np.sin(pi / 32), rel=1e-12)


@pytest.mark.parametrize(("form", "cells", "tolerance"), [("naghdi-t2", 24, 0.02), ("naghdi-q2", 24, 0.02)])
def test_twisted_strip_of_flat_cells(tmp_path, form, cells, tolerance):
    """MacNeal and Harder 1985, thin, by a force at its end, 0.005256; flat triangles gave a fifth of it."""
    def twisted(x):
        y, a = x[:, 1] - 0.55, x[:, 0] / 12 * pi / 2
        return np.column_stack((x[:, 0], y * np.cos(a), y * np.sin(a)))

    mesh = fx.read(flat(tmp_path / "strip.msh", twisted, square((cells, 2), form == "naghdi-t2", (12.0, 1.1))), 3)
    shell = fx.Shell(mesh, fx.Plate(0.0032), fx.Elastic(29e6, 0.22), form=form)
    scene = fx.Scene([shell], [fx.clamp(mesh, "west")], [fx.EdgeForce(mesh, "east", (0.0, 0.0, 1e-6 / 1.1))],
                     fx.Monitor(mesh, "south-east", "z"))
    record = fx.trace(fx.Case(scene, fx.LoadControl(1.0, fixed=True)))
    record.show(record.states[-1])
    ends = [record.displacement(at, mesh)[2] for at in ("south-east", "north-east")]
    assert np.mean(ends) == pytest.approx(0.005256, rel=tolerance)


def test_bars_on_a_raised_skin_move_with_it(tmp_path):
    """Ribs along edges of cells of a cylinder: nodes that were one stay one."""
    def build():
        square((6, 12), True)()
        gmsh.model.geo.synchronize()

    file = flat(tmp_path / "ribs.msh", cylinder, build)
    mesh = fx.read_mixed(file, bars=["west"])
    skin, rib = mesh.surfaces.domain.geometry.x, mesh.curves.domain.geometry.x
    assert np.hypot(rib[:, 1], rib[:, 2]) == pytest.approx(1.0, abs=1e-6)
    assert all(np.linalg.norm(skin - at, axis=1).min() < 1e-12 for at in rib)
    assert len(rib) == 25


def test_two_processes_read_the_same(tmp_path):
    file = flat(tmp_path / "two.msh", sphere, square((6, 6), True))
    lines = on_two_processes(f"""
import warnings
import sheetfx as fx
warnings.simplefilter("ignore")
print(repr(float(fx.read({str(file)!r}, 3).measure)))
""")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        assert float(lines[-1]) == pytest.approx(fx.read(file, 3).measure, rel=1e-13)
