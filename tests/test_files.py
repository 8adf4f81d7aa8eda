"""Meshes and geometry from files of other programs, each to the buckling load of one plate."""

from __future__ import annotations

import subprocess
import sys

import gmsh
import numpy as np
import pytest

import sheetfx as fx
from sheetfx.critical.buckling import buckling

meshio = pytest.importorskip("meshio")
EDGES = "south", "east", "north", "west"


def buckling_load(mesh, skin="skin", west="west", east="east", corner="corner"):
    """Clamped at one end, pressed at the other, which stays in its plane."""
    shell = fx.Shell(mesh, fx.Plate(0.01), fx.Elastic(2e11, 0.3), group=skin)
    scene = fx.Scene([shell], [fx.clamp(mesh, west), fx.Support(mesh, east, "y z")],
                     [fx.EdgeForce(mesh, east, (-1.0, 0, 0))], fx.Monitor(mesh, corner, "x"))
    path = fx.Path(scene, until=fx.Until(steps=0))
    (state,) = path
    return buckling(path, state, 1)[0].factor


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    """A plate of 2 x 1 by gmsh, as geometry and as meshes with groups of elements and nodes."""
    folder = tmp_path_factory.mktemp("files")
    gmsh.initialize(interruptible=False)
    gmsh.option.setNumber("General.Terminal", 0)
    gmsh.model.occ.addRectangle(0, 0, 0, 2, 1)
    gmsh.model.occ.synchronize()
    for name in ("plate.step", "plate.brep"):
        gmsh.write(str(folder / name))
    gmsh.model.addPhysicalGroup(2, [1], name="skin")
    for tag, name in enumerate(EDGES, 1):
        gmsh.model.addPhysicalGroup(1, [tag], name=name)
    gmsh.model.addPhysicalGroup(0, [3], name="corner")
    gmsh.option.setNumber("Mesh.MeshSizeMax", 0.34)
    gmsh.model.mesh.generate(2)
    gmsh.option.setNumber("Mesh.SaveGroupsOfNodes", 1)
    for name in ("plate.msh", "plate.inp", "plate.bdf", "plate.unv"):
        gmsh.write(str(folder / name))
    gmsh.finalize()
    given = meshio.read(folder / "plate.inp")
    triangles, *_ = (c.data for c in given.cells if c.type == "triangle")
    sets = {name: nodes for name, nodes in given.point_sets.items() if name != "skin"}
    meshio.Mesh(given.points, [("triangle", triangles)], point_sets=sets,
                cell_sets={"skin": [np.arange(len(triangles))]}).write(folder / "sets.inp")
    numbers, names = np.zeros(len(given.points), dtype=int), {}
    for name, nodes in sets.items():  # corners belong to two edges: a family of their own
        for node in np.asarray(nodes, dtype=int):
            together = (*names.get(numbers[node], ()), name)
            numbers[node] = next((n for n, own in names.items() if own == together), len(names) + 1)
            names[int(numbers[node])] = together
    med = meshio.Mesh(given.points, [("triangle", triangles)], point_data={"point_tags": numbers},
                      cell_data={"cell_tags": [np.full(len(triangles), -1)]})
    med.cell_tags, med.point_tags = {-1: ["skin"]}, {n: list(own) for n, own in names.items()}
    med.write(folder / "plate.med")
    return folder


@pytest.fixture(scope="module")
def right(files):
    return buckling_load(fx.read(files / "plate.msh", 3))


@pytest.mark.parametrize("name", ["plate.inp", "sets.inp", "plate.med"])
@pytest.mark.slow(quick=1)
def test_groups_and_sets_have_their_names(files, right, name):
    """As lines in a set, and as sets of nodes alone."""
    mesh = fx.read(files / name, 3)
    assert set(EDGES) <= mesh.edges.keys() and list(mesh.points) == ["corner"] and "skin" in mesh.cells
    assert buckling_load(mesh) == pytest.approx(right, rel=1e-6)


@pytest.mark.parametrize("name", ["plate.step", "plate.brep"])
def test_geometry_is_meshed(files, right, name):
    """By numbers of what has no name; finer cells by `size`, and read again with curved ones."""
    mesh = fx.read(files / name, 3, size=0.34)
    found = buckling_load(mesh, "surface 1", "curve 4", "curve 2", "point 3")
    assert found == pytest.approx(right, rel=1e-3)
    finer = fx.read(files / name, 3, size=0.15)
    assert finer.mean_cell < 0.8 * mesh.mean_cell and mesh.reading is not None


def test_bulk_data_has_groups_by_number(files, right):
    mesh = fx.read(files / "plate.bdf", 3)
    assert list(mesh.cells) == ["surface 1"] and list(mesh.edges) == [f"curve {n}" for n in (1, 2, 3, 4)]
    assert mesh.measure == pytest.approx(2.0)


def test_a_file_that_ends_gmsh_ends_a_process_of_its_own(files, tmp_path):
    """gmsh 4.13 ends on groups of nodes in .unv; a later version may read it."""
    script = tmp_path / "read.py"
    script.write_text(f"import sheetfx as fx\ntry:\n    fx.read({str(files / 'plate.unv')!r}, 3)\nexcept ValueError as "
                      "refusal:\n    assert 'gmsh cannot read the file' in str(refusal)\n")
    assert subprocess.run([sys.executable, script]).returncode == 0


def test_eight_nodes_are_nine(tmp_path):
    """Serendipity cells get the middle that their eight nodes have, on a plane and on a cylinder."""
    corners = [(0, 0, 0), (1, 0, 0), (1, 2, 0), (0, 2, 0)]
    x = np.array([*corners, (0.5, 0, 0.2), (1, 1, 0), (0.5, 2, 0.2), (0, 1, 0)], float)
    meshio.Mesh(x, [("quad8", [range(8)])], point_sets={"left": [0, 3, 7]}).write(tmp_path / "one.inp")
    mesh = fx.read(tmp_path / "one.inp", 3)
    assert mesh.degree == 2 and list(mesh.edges) == ["left"] and list(mesh.cells) == ["surfaces"]
    middle = mesh.domain.geometry.x[np.abs(mesh.domain.geometry.x[:, :2] - (0.5, 1)).max(axis=1) < 1e-9]
    assert middle == pytest.approx(np.array([[0.5, 1.0, 0.2]]))


def test_what_is_left_out_is_named(tmp_path):
    x = np.array([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (2, 0, 0), (3, 3, 3)], float)
    cells = [("quad", [[0, 1, 2, 3]]), ("tetra", [[0, 1, 2, 4]]), ("line", [[1, 5]])]
    meshio.Mesh(x, cells, point_sets={"off": [6], "end": [0]}).write(tmp_path / "solid.inp")
    with pytest.warns(UserWarning, match=r"1 cells 'tetra' left out; sets of nodes .* left out: off"):
        mesh = fx.read_mixed(tmp_path / "solid.inp", bars=["curves"])
    assert list(mesh.surfaces.points) == ["end"] and list(mesh.curves.cells) == ["curves"]


def test_mixed_kinds_are_read_by_their_reader(tmp_path):
    x = np.array([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (2, 0, 0)], float)
    meshio.Mesh(x, [("quad", [[0, 1, 2, 3]]), ("triangle", [[1, 4, 2]])]).write(tmp_path / "both.inp")
    with pytest.raises(ValueError, match="mixed kinds of cells, .* read both with read_kinds"):
        fx.read(tmp_path / "both.inp", 3)
    both = fx.read_kinds(tmp_path / "both.inp")
    assert both.triangles.measure == pytest.approx(0.5) and both.quadrilaterals.measure == pytest.approx(1.0)


def test_what_cannot_be_read(tmp_path, files):
    (tmp_path / "empty.inp").write_text("*HEADING\nnothing\n")
    (tmp_path / "wrong.step").write_text("nothing")
    for name, words in (("empty.inp", "has no lines, triangles or quad"), ("none.inp", "there is no such file"),
                        ("wrong.step", "gmsh cannot read the file")):
        with pytest.raises(ValueError, match=words):
            fx.read(tmp_path / name, 3)
    gmsh.initialize(interruptible=False)
    gmsh.option.setNumber("General.Terminal", 0)
    gmsh.model.occ.addBox(0, 0, 0, 1, 1, 1)
    gmsh.model.occ.synchronize()
    gmsh.write(str(tmp_path / "box.step"))
    gmsh.finalize()
    with pytest.raises(ValueError, match="has 1 volumes; export the surfaces of a shell model"):
        fx.read(tmp_path / "box.step", 3)
