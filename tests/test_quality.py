"""Cells that no strain can be computed on, and cells of no part: named before any solve."""

from __future__ import annotations

import gmsh
import numpy as np
import pytest
from helpers import on_two_processes

import sheetfx as fx
from sheetfx.mesh.groups import ONE_KIND

PLATE, MATERIAL = fx.Plate(0.01), fx.Elastic(2e11, 0.3)


def squares(move=(0.0, 0.0, 0.0), of: int = 5, qualities: list | None = None):
    """Model of 2 x 2 quadrilaterals in the groups left and right, of which one node (5: the middle) is moved."""
    def build():
        x = np.array([(i, j, 0) for j in range(3) for i in range(3)], dtype=float)
        x[of - 1] += move
        left, right, west, middle = (gmsh.model.addDiscreteEntity(d) for d in (2, 2, 1, 0))
        gmsh.model.mesh.addNodes(2, left, list(range(1, 10)), x.ravel())
        gmsh.model.mesh.addElementsByType(left, 3, [1, 2], [1, 2, 5, 4, 4, 5, 8, 7])
        gmsh.model.mesh.addElementsByType(right, 3, [3, 4], [2, 3, 6, 5, 5, 6, 9, 8])
        gmsh.model.mesh.addElementsByType(west, 1, [5, 6], [1, 4, 4, 7])
        gmsh.model.mesh.addElementsByType(middle, 15, [7], [5])
        for dimension, name, tag in ((2, "left", left), (2, "right", right), (1, "west", west), (0, "middle", middle)):
            gmsh.model.addPhysicalGroup(dimension, [tag], name=name)
        if qualities is not None:
            qualities.extend(gmsh.model.mesh.getElementQualities([1, 2, 3, 4], "minSJ"))
    return build


def refusal(build, place=None) -> str | None:
    """What a mesh is refused by; None: it is read."""
    try:
        fx.read(build, 3, place=place)
    except ValueError as error:
        return str(error)
    return None


@pytest.mark.parametrize("turn", [False, True])
def test_concave_cells_are_those_of_gmsh(turn):
    """In the plane, and as it stands in space: refused where the least scaled Jacobian of gmsh is not positive."""
    axes = np.linalg.qr(np.random.default_rng(0).normal(size=(3, 3)))[0]
    place, outcomes = (lambda x: 1e3 + x @ axes) if turn else None, set()
    for move in np.random.default_rng(1).uniform(-1.3, 1.3, size=(25, 2)):
        qualities: list = []
        build = squares((*move, 0.0), qualities=qualities)
        said = refusal(build, place)
        outcomes.add(said is None)
        assert (min(qualities) > 0) == (said is None)
        assert said is None or ("of the group '" in said and ("correct place" if turn else "Mesh.Algorithm") in said)
    assert outcomes == {True, False}


@pytest.mark.parametrize(("move", "of", "words"), [
    ((0.7, 0.7, 0), 1, "1 cell of the group 'left' is concave or folded over, at .0.7, 0.7, 0.0., where the scaled"),
    ((0.5, 0.5, 0), 1, r"'left' is concave or folded over, at .*, where the scaled Jacobian is -?\d\S* and"),
    ((1.0, 0.0, 0), 1, "1 cell of the group 'left' is concave"),
    ((0.5, 0.0, 0), 9, None), ((0, 0, 0.9), 5, None), ((-0.4, -0.45, 0), 9, None)])
def test_cells_at_a_moved_node(move, of, words):
    """A corner on the diagonal makes a triangle of its cell; warped cells, and small ones, are right."""
    if words is None:
        assert len(fx.read(squares(move, of), 3).cells["left"]) == 2
        return
    with pytest.raises(ValueError, match=f"read: .*{words}"):
        fx.read(squares(move, of), 3)


@pytest.mark.parametrize("order", [1, 2, 3])
@pytest.mark.parametrize("triangles", [False, True])
def test_strongly_curved_and_slender_cells_are_right(order, triangles):
    """Half a cylinder in a single row of cells, a thousand times as long as wide."""
    def place(x):
        return np.column_stack((1e3 * x[:, 0], np.cos(np.pi * x[:, 1]), np.sin(np.pi * x[:, 1])))

    cells = (1, 1) if order > 1 else (1, 3)
    assert fx.read(lambda: fx.meshes.rectangle(cells, triangles=triangles), 3, order, place).measure > 2e3


def test_curves_that_turn_back():
    """The middle node of a quadratic cell beyond its end, and a ring of three cells, which is right."""
    def straight(x):
        return np.column_stack((np.where(np.isclose(x[:, 0], 0.5), 1.5, x[:, 0]), 0 * x[:, 0], 0 * x[:, 0]))

    line = lambda cells: lambda: fx.meshes.frame({"a": (0, 0, 0), "b": (1, 0, 0)}, {"bar": ("a", "b", cells)})  # noqa: E731
    with pytest.raises(ValueError, match="1 cell of the group 'bar' is folded back, at .*; correct place"):
        fx.read(line(1), 3, 2, straight)
    arc = fx.read(line(2), 3, 2, lambda x: np.column_stack((np.cos(5 * x[:, 0]), np.sin(5 * x[:, 0]), 0 * x[:, 0])))
    assert arc.measure == pytest.approx(5, rel=0.05)


def waves(x):
    return np.column_stack((np.sin(40 * x[:, 0]) * np.cos(30 * x[:, 1]), 0 * x[:, 0], 0 * x[:, 0]))


def test_an_imperfection_that_folds_cells():
    mesh = fx.read(lambda: fx.meshes.rectangle((8, 8)), 3)
    assert fx.imperfect(mesh, waves, 0.01).measure > 0.9
    with pytest.raises(ValueError, match="imperfect: .* cells of the group 'shell' are concave or folded over, the "
                                         "worst at .*; make the amplitude smaller, or the cells smaller than"):
        fx.imperfect(mesh, waves, 1.0)


REFUSED = """
import sheetfx as fx
from test_quality import cantilever_and_boom, squares, waves
mesh = fx.read(lambda: fx.meshes.rectangle((8, 8)), 3)
for wrong in (lambda: fx.imperfect(mesh, waves, 1.0), lambda: fx.read(squares((0.6, 0.6, 0), 1), 3),
              lambda: cantilever_and_boom("post"), lambda: cantilever_and_boom("post", "boom", at="a")):
    try:
        wrong()
    except ValueError as error:
        print(error)
"""


def test_what_is_refused_is_refused_on_all_processes():
    words = ["imperfect: ", "read: 1 cell of", "Scene: 3 cells of the group 'boom'", "Monitor at 'a': its component y"]
    for line, start in zip(on_two_processes(REFUSED), words, strict=True):
        assert line.startswith(start)


def test_mixed_cells_are_told_how_to_be_one_kind():
    assert "Mesh.RecombinationAlgorithm = 3" in ONE_KIND[2] and not ONE_KIND[1]


@pytest.mark.parametrize(("version", "binary"), [(2.2, 0), (2.2, 1), (4.1, 0), (4.1, 1)])
def test_partitioned_files(tmp_path, version, binary):
    """As gmsh -part writes them, with ghost cells and the borders of the pieces."""
    gmsh.initialize(interruptible=False)
    gmsh.option.setNumber("General.Terminal", 0)
    fx.meshes.rectangle((4, 4))
    gmsh.model.mesh.generate(2)
    for option, value in {"MshFileVersion": version, "Binary": binary, "PartitionCreateGhostCells": 1}.items():
        gmsh.option.setNumber(f"Mesh.{option}", value)
    gmsh.model.mesh.partition(3)
    gmsh.write(str(tmp_path / "parts.msh"))
    gmsh.finalize()
    mesh = fx.read(tmp_path / "parts.msh", 3)
    assert {name: len(cells) for name, cells in mesh.cells.items()} == {"shell": 16}
    assert {len(facets) for facets in mesh.edges.values()} == {4} and len(mesh.points) == 4
    assert mesh.measure == pytest.approx(1)


@pytest.mark.parametrize(("off", "plane"), [(1e-10, True), (1e-7, True), (1e-4, False)])
@pytest.mark.parametrize("size", [1e-3, 1.0, 1e4])
def test_rounding_out_of_the_plane(off, plane, size):
    def build():
        fx.meshes.frame({"a": (0, 0, 0), "b": (size, 0, off * size)}, {"bar": ("a", "b", 2)})

    if plane:
        assert fx.read(build, 2).measure == pytest.approx(size)
    else:
        with pytest.raises(ValueError, match=f"out of the x-y plane, by up to {off * size:.3g}; read it in 3 .*place="):
            fx.read(build, 2)


def cantilever_and_boom(*names, at="b") -> fx.Path:
    """Path of beams on some of two groups, that starts with its checks."""
    mesh = fx.read(lambda: fx.meshes.frame({"a": (0, 0), "b": (1, 0), "c": (1, 1)},
                                           {"post": ("a", "b", 2), "boom": ("b", "c", 3)}), 2)
    beams = [fx.Beam(mesh, fx.Rectangle(0.1, 0.1), fx.Elastic(1e4), group=name) for name in names]
    return fx.Path(fx.Scene(beams, [fx.clamp(mesh, "a")], [fx.PointForce(mesh, "b", (0.0, 1.0))],
                            fx.Monitor(mesh, at, "y")))


def test_cells_of_no_part():
    """Named by their group; where a part has them there is nothing to say."""
    cantilever_and_boom("post", "boom")
    with pytest.raises(ValueError, match="3 cells of the group 'boom' belong to no part, the first at .1.0, "):
        cantilever_and_boom("post")


def test_shells_of_a_part_of_the_groups():
    mesh = fx.read(squares(), 3)
    shell = fx.Shell(mesh, PLATE, MATERIAL, group="left")
    scene = fx.Scene([shell], [fx.clamp(mesh, "west")], [fx.SurfaceForce(shell, (0, 0, 1.0))],
                     fx.Monitor(mesh, "middle", "z"))
    with pytest.raises(ValueError, match="Scene: 2 cells of the group 'right' belong to no part, the first at .*; "):
        fx.Path(scene)


@pytest.mark.silent("q17")
@pytest.mark.parametrize(("place", "order"), [
    (lambda x: np.column_stack((x[:, 0], x[:, 1], x[:, 0] ** 2 - x[:, 1] ** 2)), 2),
    (lambda x: np.column_stack((np.cos(x[:, 0]), np.sin(x[:, 0]), x[:, 1])), 2),
    (lambda x: np.column_stack((x[:, 0], x[:, 1], np.abs(x[:, 0] - 0.5))), 1),  # a fold between cells
    (lambda x: 3 * x @ np.array([[0.6, 0.8, 0], [-0.8, 0.6, 0], [0, 0, 1]]) + 1e3, 1),
    (None, 1)])
@pytest.mark.parametrize("triangles", [False, True])
def test_cells_that_a_place_bends_are_curved(place, order, triangles):
    """Without an order; with one it is that."""
    for given, found in ((None, order), (1, 1), (3, 3)):
        mesh = fx.read(lambda: fx.meshes.rectangle((2, 2), triangles=triangles), 3, given, place)
        assert mesh.degree == found


@pytest.mark.silent("q17")
def test_shell_on_a_bent_place_needs_no_order():
    """Hyperbolic paraboloid clamped along one side (Bathe, Iosilevich and Chapelle 2000), cubic cells: 6.3941e-6."""
    mesh = fx.read(lambda: fx.meshes.rectangle((8, 4), (1.0, 0.5)), 3, place=lambda x: np.column_stack(
        (x[:, 0] - 0.5, x[:, 1], (x[:, 0] - 0.5) ** 2 - x[:, 1] ** 2)))
    shell = fx.Shell(mesh, fx.Plate(1e-3), fx.Elastic(2e11, 0.3), form="naghdi-q3")
    scene = fx.Scene([shell], [fx.clamp(mesh, "west"), fx.symmetry(mesh, "south", "y")],
                     [fx.SurfaceForce(shell, (0.0, 0.0, -8e-3))], fx.Monitor(mesh, "south-east", "z", -1.0))
    record = fx.trace(fx.Case(scene, fx.LoadControl(1.0, fixed=True)))
    assert record.states[-1].deflection == pytest.approx(6.3941e-6, rel=1e-2)
