"""Surfaces and bars of one gmsh model, tables of structures, and what is refused in them."""

from __future__ import annotations

import gmsh
import numpy as np
import pytest
from dolfinx.mesh import compute_midpoints
from helpers import on_two_processes

import sheetfx as fx
from sheetfx import meshes
from sheetfx.mesh.pieces import loose_pieces

PANEL_ON_TWO_BARS = meshes.Table({"a": (0, 0, 0), "b": (2, 0, 0), "c": (2, 1, 0.5), "d": (0, 1, 0.5)},
                                 [("a", "b"), ("c", "d")], [("a", "b", "c", "d")], {"supports": ["a", "d"]})
TENT = meshes.Table({"a": (0, 0, 0), "b": (1, 0, 0), "c": (1, 1, 0), "d": (0, 1, 0), "top": (0.5, 0.5, 1),
                     "far": (3, 3, 3), "end": (4, 3, 3)},
                    [("a", "b"), ("top", "a"), ("top", "b"), ("top", "c"), ("top", "d"), ("c", "far"), ("far", "end")],
                    [("a", "b", "c", "d")])


def mixed(table, divisions=4, triangles=True, separate=False, order=1, grading=1.0):
    return fx.read_mixed(lambda: meshes.structure(table, divisions, triangles, separate, grading), ["bars"], order)


def vectors(table):
    return {name: np.array(x, dtype=float) for name, x in table.nodes.items()}


def length(table, bar):
    x = vectors(table)
    return np.linalg.norm(x[bar[1]] - x[bar[0]])


def area(table, panel):
    x = vectors(table)
    a, b, c = (x[n] for n in panel)
    return np.linalg.norm(np.cross(b - a, c - a)) / 2


def cells(mesh, group=None):
    return len(mesh.group(group))


def places(mesh, name):
    """Places of the vertices of a named point or edge."""
    return compute_midpoints(mesh.domain, 0, mesh.vertices(name))


@pytest.mark.parametrize("geometry", ["hex", "arc", "plan"])
def test_dome_has_the_nodes_bars_and_panels_that_are_known(geometry):
    """19 nodes, 42 bars, 24 panels, span 8 m and rise 1.6 m (thesis, section 5.2.2), on a sphere of radius 5.8 m."""
    table = meshes.dome(geometry)
    x = np.array([*table.nodes.values()])
    assert (len(x), len(table.bars), len(table.panels)) == (19, 42, 24)
    assert np.ptp(x[:, 0]) == 8000
    assert np.ptp(x[:, 2]) == 1600
    assert np.linalg.norm(x - (0, 0, -4200), axis=1) == pytest.approx(5800, abs=1e-3)
    assert [table.nodes[n][2] for n in table.sets["apex"]] == [1600]
    assert len(table.sets["corners"]) == 6
    assert len(table.sets["rim"]) == 12
    sides = {frozenset(side) for a, b, c in table.panels for side in ((a, b), (b, c), (c, a))}
    assert sides == {frozenset(bar) for bar in table.bars}


@pytest.mark.parametrize("divisions", [3, 4, 5, 6, 8, 12])
def test_dome_of_triangles(divisions):
    """Counts of a regular division, and areas and lengths of the table."""
    table = meshes.dome("hex")
    mesh = mixed(table, divisions)
    assert cells(mesh.surfaces) == 24 * divisions**2
    assert cells(mesh.curves) == 42 * divisions
    assert len(mesh.shared_nodes()) == len(mesh.curves.domain.geometry.x) == 19 + 42 * (divisions - 1)
    assert mesh.surfaces.measure == pytest.approx(sum(area(table, p) for p in table.panels), rel=1e-12)
    assert mesh.curves.measure == pytest.approx(sum(length(table, b) for b in table.bars), rel=1e-12)
    assert {cells(mesh.surfaces, f"panel {'-'.join(p)}") for p in table.panels} == {divisions**2}


@pytest.mark.parametrize("triangles", [True, False])
def test_graded_cells_are_small_at_the_corners_of_each_panel(triangles):
    """Lengths grow by one factor towards the middles of edges, alike for panels and the bars between them."""
    table = meshes.dome("hex")
    bar = table.bars[0]
    ideal = length(table, bar) / 2 * 2 ** np.arange(4) / 15
    mesh = mixed(table, 8, triangles, separate=True, grading=8.0)
    assert cells(mesh.surfaces) == 24 * 3 * 4**2 * (2 if triangles else 1)
    assert mesh.surfaces.measure == pytest.approx(sum(area(table, p) for p in table.panels), rel=1e-12)
    assert mesh.curves.measure == pytest.approx(sum(length(table, b) for b in table.bars), rel=1e-12)
    beside = next(p for p in table.panels if set(bar) <= set(p))
    on_panel = places(mesh.surfaces, f"edge {'-'.join(bar)} of panel {'-'.join(beside)}")
    on_bar = compute_midpoints(mesh.curves.domain, 1, mesh.curves.group(f"bar {'-'.join(bar)}"))
    ends = np.cumsum([0, *ideal, *ideal[::-1]])
    for found, expected in ((on_panel, ends), (on_bar, (ends[1:] + ends[:-1]) / 2)):
        along = np.sort(np.linalg.norm(found - vectors(table)[bar[0]], axis=1))
        assert along == pytest.approx(expected, abs=1e-6 * length(table, bar))
    shared = mixed(table, 8, triangles, grading=8.0)
    assert len(shared.shared_nodes()) == len(shared.curves.domain.geometry.x) == 19 + 42 * 7


def test_graded_panels_of_four_nodes():
    mesh = mixed(PANEL_ON_TWO_BARS, 6, triangles=False, grading=4.0)
    assert (cells(mesh.surfaces), cells(mesh.curves)) == (36, 12)
    assert mesh.surfaces.measure == pytest.approx(2 * np.hypot(1, 0.5), rel=1e-12)


@pytest.mark.parametrize("geometry", ["arc", "plan"])
def test_dome_of_quadrilaterals(geometry):
    """Each panel is three quadrilaterals for each of its (N / 2)^2 triangles."""
    table = meshes.dome(geometry)
    mesh = mixed(table, 4, triangles=False)
    assert cells(mesh.surfaces) == 24 * 12
    assert cells(mesh.curves) == 42 * 4
    assert mesh.surfaces.measure == pytest.approx(sum(area(table, p) for p in table.panels), rel=1e-12)
    assert mesh.curves.measure == pytest.approx(sum(length(table, b) for b in table.bars), rel=1e-12)


@pytest.mark.parametrize("order", [1, 2, 3])
@pytest.mark.parametrize("triangles", [True, False])
@pytest.mark.slow(quick=1)
def test_one_panel_on_two_bars(order, triangles):
    """The smallest structure: its names, where they are, and nodes of both meshes at exactly the same places."""
    mesh = mixed(PANEL_ON_TWO_BARS, 4, triangles, order=order)
    surfaces, curves = mesh.surfaces, mesh.curves
    assert (surfaces.degree, curves.degree) == (order, order)
    assert set(surfaces.cells) == {"panel a-b-c-d", "panels"}
    assert set(surfaces.edges) == {"bar a-b", "bar c-d", "bars", "edge b-c", "edge d-a"}
    assert set(curves.cells) == {"bar a-b", "bar c-d", "bars"}
    assert set(surfaces.points) == set(curves.points) == {"a", "b", "c", "d", "supports"}
    assert surfaces.measure == pytest.approx(2 * np.sqrt(1.25), rel=1e-12)
    assert surfaces.edge_length("bar a-b") == pytest.approx(2, rel=1e-12)
    assert surfaces.edge_length("edge d-a") == pytest.approx(np.sqrt(1.25), rel=1e-12)
    assert curves.measure_of("bar c-d") == pytest.approx(2, rel=1e-12)
    shared = mesh.shared_nodes()
    assert len(shared) == 2 * (4 * order + 1)
    assert (curves.domain.geometry.x[shared[:, 0]] == surfaces.domain.geometry.x[shared[:, 1]]).all()
    for part in (surfaces, curves):
        assert (places(part, "supports")[:, 0] == 0).all()
        assert places(part, "c").tolist() == [[2, 1, 0.5]]


def test_bars_off_the_panels():
    """Bars that leave the panels are cells of the curves alone; points are on the meshes that have them."""
    mesh = mixed(TENT)
    assert set(mesh.surfaces.edges) == {"bar a-b", "bars", "edge b-c", "edge c-d", "edge d-a"}
    assert mesh.surfaces.edge_length("bars") == pytest.approx(1, rel=1e-12)
    assert set(mesh.surfaces.points) == {"a", "b", "c", "d"}
    assert set(mesh.curves.points) == set(TENT.nodes)
    assert mesh.curves.measure == pytest.approx(sum(length(TENT, b) for b in TENT.bars), rel=1e-12)
    assert len(mesh.shared_nodes()) == 5 + 2


def test_separate_panels_share_no_nodes():
    table = meshes.dome("hex")
    mesh = mixed(table, 3, separate=True)
    assert len(mesh.shared_nodes()) == 0
    assert len(mesh.surfaces.domain.geometry.x) == 24 * 10
    assert mesh.surfaces.measure == pytest.approx(sum(area(table, p) for p in table.panels), rel=1e-12)
    assert len(mesh.surfaces.edges) == 72
    seat = "edge 1-2 of panel 1-5-2"
    assert mesh.surfaces.edge_length(seat) == pytest.approx(length(table, ("1", "2")), rel=1e-12)
    assert places(mesh.surfaces, "5 of panel 1-5-2").tolist() == [list(table.nodes["5"])]
    assert set(mesh.curves.points) == {*table.nodes, *table.sets}


def test_panels_share_nodes_with_each_other_alone():
    table = meshes.dome("hex")
    mesh, whole = mixed(table, 3, separate="bars"), mixed(table, 3)
    assert len(mesh.shared_nodes()) == 0
    assert len(mesh.surfaces.domain.geometry.x) == len(whole.surfaces.domain.geometry.x)
    assert mesh.surfaces.measure == pytest.approx(whole.surfaces.measure, rel=1e-12)
    assert len(mesh.surfaces.edges) == len(table.bars)
    assert mesh.surfaces.edge_length("edge 1-2 of panels") == pytest.approx(length(table, ("1", "2")), rel=1e-12)
    assert places(mesh.surfaces, "5 of panels").tolist() == [list(table.nodes["5"])]


def test_curved_surface_with_a_bar_on_its_edge():
    """A bar along an arc and along a generator of a cylinder: nodes are the same to the last digit.

    Cubic cells of 0.16 radians are longer than the arc by 1e-7, straight ones shorter by 1e-3.
    """
    def place(x):
        return np.column_stack([np.cos(x[:, 0]), np.sin(x[:, 0]), x[:, 1]])

    mesh = fx.read_mixed(lambda: meshes.rectangle((8, 3), (1.3, 2.0)), ["south", "west"], 3, place)
    assert mesh.curves.measure_of("south") == pytest.approx(1.3, rel=1e-6)
    assert mesh.curves.measure_of("west") == pytest.approx(2.0, rel=1e-12)
    assert mesh.surfaces.measure == pytest.approx(2.6, rel=1e-6)
    assert set(mesh.surfaces.edges) == {"south", "west", "north", "east"}
    shared = mesh.shared_nodes()
    assert len(shared) == 3 * (8 + 3) + 1
    assert (mesh.curves.domain.geometry.x[shared[:, 0]] == mesh.surfaces.domain.geometry.x[shared[:, 1]]).all()


TWO = """
import numpy as np
import sheetfx as fx
from test_mixed import TENT, mixed
from sheetfx import meshes
from sheetfx.mesh.pieces import loose_pieces

def placed(mesh):
    return set(map(tuple, mesh.domain.geometry.x.tolist()))

for table, divisions, triangles in (("hex", 2, True), ("hex", 5, True), ("plan", 4, False), (TENT, 2, True)):
    mesh = mixed(meshes.dome(table) if isinstance(table, str) else table, divisions, triangles, order=2)
    comm, surfaces, curves = mesh.surfaces.domain.comm, mesh.surfaces, mesh.curves
    everywhere = set().union(*comm.allgather(placed(surfaces)))
    unknown = comm.allreduce(len((placed(curves) & everywhere) - placed(surfaces)))
    shares = comm.allgather((len(surfaces.group(None)), len(curves.group(None))))
    figures = [part.domain.geometry.index_map().size_global for part in (surfaces, curves)]
    figures += [part.domain.topology.index_map(0).size_global for part in (surfaces, curves)]
    figures += [surfaces.measure, curves.measure, surfaces.edge_length("bars"), curves.count(next(iter(curves.points)))]
    loose = loose_pieces([surfaces, curves], [(surfaces, next(iter(surfaces.points)))])
    print(unknown, min(map(min, shares)), *map(repr, figures), len(loose), sep=";")
"""


def test_bars_follow_the_surfaces_to_two_processes():
    """Each node of a bar on a surface is known to the surface there, nothing comes apart, both processes have work."""
    lines = on_two_processes(TWO)
    cases = [(meshes.dome("hex"), 2, True), (meshes.dome("hex"), 5, True), (meshes.dome("plan"), 4, False),
             (TENT, 2, True)]
    for line, (table, divisions, triangles) in zip(lines, cases, strict=True):
        unknown, share, *figures, loose = line.split(";")
        mesh = mixed(table, divisions, triangles, order=2)
        alone = [len(part.domain.geometry.x) for part in (mesh.surfaces, mesh.curves)]
        alone += [part.domain.topology.index_map(0).size_global for part in (mesh.surfaces, mesh.curves)]
        alone += [mesh.surfaces.measure, mesh.curves.measure, mesh.surfaces.edge_length("bars"), 1]
        assert [float(f) for f in figures] == pytest.approx(alone, rel=1e-12)
        assert unknown == "0"
        assert int(share) > 0
        assert loose == "1"


def save(file, build, version=4.1, order=1, dimension=2):
    """Mesh what a function builds and save it as a user would."""
    gmsh.initialize(interruptible=False)
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        build()
        gmsh.model.mesh.generate(dimension)
        gmsh.model.mesh.setOrder(order)
        gmsh.option.setNumber("Mesh.MshFileVersion", version)
        gmsh.write(str(file))
    finally:
        gmsh.finalize()
    return file


@pytest.mark.parametrize("version", [2.2, 4.0, 4.1])
@pytest.mark.parametrize("order", [1, 2])
def test_files_of_gmsh(tmp_path, version, order):
    """Version 2 saves cells once for each of their groups; they are read once. The order is that of the file."""
    file = save(tmp_path / "tent.msh", lambda: meshes.structure(TENT, 3), version, order)
    mesh, own = fx.read_mixed(file, ["bars"]), mixed(TENT, 3, order=order)
    for part, other in ((mesh.surfaces, own.surfaces), (mesh.curves, own.curves)):
        assert part.degree == order
        assert part.measure == pytest.approx(other.measure, rel=1e-12)
        assert {n: len(c) for n, c in part.cells.items()} == {n: len(c) for n, c in other.cells.items()}
        assert {n: len(c) for n, c in part.edges.items()} == {n: len(c) for n, c in other.edges.items()}
        assert set(part.points) == set(other.points)
    assert fx.read_mixed(str(file), "bars", 3).curves.degree == 3


def test_read_takes_files(tmp_path):
    """Surfaces alone and curves alone, in space and in the plane; groups without a name have their number."""
    surface = save(tmp_path / "surface.msh", lambda: meshes.rectangle((3, 2)), 1)
    assert fx.read(surface, 3).measure == pytest.approx(1)
    assert set(fx.read(surface, 3).cells) == {"1"}
    arc = save(tmp_path / "arc.msh", lambda: meshes.arc(2.0, 0.0, 1.0, 8), 4.1, 2, 1)
    curve = fx.read(arc, 2)
    assert curve.degree == 2
    assert curve.measure == pytest.approx(2, rel=1e-6)
    assert set(curve.points) == {"start", "end"}


def test_tables_are_read_from_json_and_csv(tmp_path):
    csv, json = tmp_path / "panel.csv", tmp_path / "panel.json"
    csv.write_text("# a panel\nnode, a, 0, 0, 0\nnode, b, 2, 0, 0\nnode, c, 2, 1, 0.5,,\nnode, d, 0, 1, 0.5\n\n"
                   "bar, a, b\nbar, c, d\npanel, a, b, c, d\nset, supports, a, d\n")
    json.write_text('{"nodes": {"a": [0, 0, 0], "b": [2, 0, 0], "c": [2, 1, 0.5], "d": [0, 1, 0.5]}, "note": 1, '
                    '"bars": [["a", "b"], ["c", "d"]], "panels": [["a", "b", "c", "d"]], '
                    '"sets": {"supports": ["a", "d"]}}')
    for file in (csv, json):
        table = meshes.read_table(file)
        assert {n: tuple(x) for n, x in table.nodes.items()} == PANEL_ON_TWO_BARS.nodes
        for of in ("bars", "panels"):
            assert [tuple(row) for row in getattr(table, of)] == getattr(PANEL_ON_TWO_BARS, of)
        assert {n: list(row) for n, row in table.sets.items()} == PANEL_ON_TWO_BARS.sets
    json.write_text('{"nodes": [{"id": 1, "ideal": [0, 0, 0], "measured": [0, 0, 0.1]}, '
                    '{"id": 2, "ideal": [1, 0, 0], "measured": [1, 0, 0.2]}], "bars": [[1, 2]]}')
    assert meshes.dome(json).nodes["2"] == [1, 0, 0]
    assert meshes.dome(json, "measured").nodes["2"] == [1, 0, 0.2]


COMMAS = """# a tür
node, 1, 0, 0, 0
node, tür, 1000.5, 0, 0

bar, 1, tür
set, ends, 1, tür
"""
AS_SAVED = {
    "byte order mark": (COMMAS, "utf-8-sig"), "Latin-1": (COMMAS, "latin-1"), "UTF-16": (COMMAS, "utf-16"),
    "CRLF": (COMMAS.replace("\n", "\r\n"), "utf-8"), "trailing commas": (COMMAS.replace("\n", ",,,\n"), "utf-8"),
    "spaces around": (COMMAS.replace(",", "  , ").replace("node", "  node"), "utf-8"),
    "semicolons": (COMMAS.replace(", ", ";").replace(".", ","), "utf-8"),
    "semicolons and points": ("sep=;\n" + COMMAS.replace(",", " ;"), "utf-8"),
    "tabulators": (COMMAS.replace(", ", "\t").replace(".", ","), "latin-1"),
    "columns": (COMMAS.replace(", ", "   "), "utf-8"), "capitals": (COMMAS.replace("node", "Node"), "utf-8"),
    "quoted": (COMMAS.replace("tür", '"tür"').replace("bar", '"bar"').replace("1000.5", '"1000.5"'), "utf-8"),
    "quoted, with semicolons": (COMMAS.replace(", ", '";"').replace("\n", '"\n').replace("node", '"node').replace(
        "bar", '"bar').replace("set", '"set').replace("#", '"#').replace('\n"\n', "\n\n"), "utf-8"),
}


@pytest.mark.parametrize("how", AS_SAVED)
def test_tables_are_read_as_spreadsheets_save_them(tmp_path, how):
    text, encoding = AS_SAVED[how]
    (tmp_path / "t.CSV").write_bytes(text.encode(encoding))
    table = meshes.read_table(tmp_path / "t.CSV")
    assert table.nodes == {"1": [0, 0, 0], "tür": [1000.5, 0, 0]}
    assert table.bars == [["1", "tür"]] and table.sets == {"ends": ["1", "tür"]}


def test_panels_without_support_are_named():
    """Pieces of two meshes, joined where their nodes meet or by named points."""
    whole, apart = mixed(TENT), mixed(PANEL_ON_TWO_BARS, separate=True)
    held = [(whole.surfaces, "a")]
    loose = loose_pieces([whole.surfaces, whole.curves], held)
    assert len(loose) == 1
    assert loose[0].startswith("'bar top-a', 'bar top-b'")
    assert not loose_pieces([whole.surfaces, whole.curves], held, compatible=[(whole.curves, whole.surfaces)])
    both, held = [apart.curves, apart.surfaces], [(apart.curves, "bar a-b"[4]), (apart.curves, "c")]
    assert loose_pieces(both, held)[0].startswith("'panel a-b-c-d'")
    assert not loose_pieces(both, held, [[(apart.curves, "a"), (apart.surfaces, "a of panel a-b-c-d")]])
    assert len(loose_pieces(both, held[:1])) == 2


def table(**changes):
    """The panel on two bars with other nodes, bars, panels or sets."""
    own = {name: getattr(PANEL_ON_TWO_BARS, name) for name in ("nodes", "bars", "panels", "sets")}
    return meshes.Table(**own | changes)


NODES = PANEL_ON_TWO_BARS.nodes
MORE = NODES | {"e": (5, 5, 5), "f": (6, 5, 5), "g": (5, 6, 5)}
BARS = PANEL_ON_TWO_BARS.bars


@pytest.mark.parametrize("changes, message", [
    ({"nodes": {"a": (0, 0), "b": (1, 0, 0)}}, r"node a: its place is \[0, 0\]; give three finite numbers"),
    ({"nodes": {"a": (0, 0, np.nan)}}, r"node a: its place is \[0, 0, nan\]"),
    ({"bars": [("a", "x")]}, "bar a-x: there is no node 'x'; nodes are a, b, c, d"),
    ({"panels": ["abx"]}, "panel a-b-x: there is no node 'x'"),
    ({"sets": {"rim": ["a", "x"]}}, "set rim: there is no node 'x'"),
    ({"sets": {"a": ["b"]}}, "set a has the name of a node; give it another"),
    ({"bars": [("a", "b", "c")]}, "bar a-b-c has 3 nodes; give 2"),
    ({"panels": ["ab"]}, "panel a-b has 2 nodes; give 3 or 4"),
    ({"bars": [("a", "a")]}, "bar a-a has the node a twice; give different nodes"),
    ({"panels": ["abca"]}, "panel a-b-c-a has the node a twice"),
    ({"bars": [*BARS, ("b", "a")]}, "bar b-a has the same nodes as bar a-b; remove one"),
    ({"panels": ["abcd", "bcda"]}, "panel b-c-d-a has the same nodes as panel a-b-c-d; remove one"),
    ({"panels": ["abcd", "adcb"]}, "panel a-d-c-b has the same nodes as panel a-b-c-d; remove one"),
    ({"nodes": NODES | {"e": (2, 1, 0.5 + 1e-7)}, "bars": [*BARS, ("a", "e")]},
     r"nodes c and e are both at \[2.  1.  0.5\]; make one"),
    ({"nodes": NODES | {"b": (0, 2, 1)}, "panels": ["abd"], "bars": [("c", "d")]},
     "panel a-b-d: its nodes are in one line; give three corners"),
    ({"nodes": NODES | {"d": (0, 1, 0.6)}}, "panel a-b-c-d is not flat: its last node is 0.0894.* off"),
    ({"panels": ["acbd"]}, "panel a-c-b-d: its nodes do not go round it"),
    ({"nodes": NODES | {"c": (0.5, 0.2, 0.1)}}, "panel a-b-c-d: its nodes do not go round it"),
    ({"nodes": NODES | {"e": (5, 5, 5)}}, "node e belongs to no bar and no panel; remove it"),
    ({"nodes": MORE, "bars": [*BARS, ("e", "f"), ("c", "g")]}, "bar e-f meets no bar and no panel at any of its nodes"),
    ({"nodes": MORE, "panels": ["abcd", "efg"]}, "panel e-f-g meets no bar and no panel"),
])
def test_wrong_tables_are_refused(changes, message):
    with pytest.raises(ValueError, match=message):
        table(**changes)


@pytest.mark.parametrize("name, text, message", [
    ("t.csv", "node, a, 0, 0, 0\nrod, a, b\n", "t.csv': line 2 is 'rod, a, b'; begin it with node, bar"),
    ("t.csv", "node, a, 0, 0, 0\nnode, a, 1, 0, 0\n", "node a stands twice"),
    ("t.csv", "node, a, 0, 0, zero\n", "t.csv': line 1: the coordinate 'zero' is no number; write"),
    ("t.csv", "node; a; 0; 0; 1.000,5\n", "t.csv': line 1: the coordinate '1.000,5' is no number; write it like"),
    ("t.csv", "node: a: 0: 0: 0\n", "t.csv': line 1 is 'node: a: 0: 0: 0'; begin it with node, bar"),
    ("t.csv", "bar, a, b\n", "bar a-b: there is no node 'a'"),
    ("t.json", "{]", "t.json': Expecting property name"),
    ("t.json", "[1, 2]", "no nodes; give an object with nodes, bars and panels"),
    ("t.json", '{"nodes": [{"id": 1, "ideal": [0, 0, 0]}, {"id": 1, "ideal": [1, 0, 0]}]}', "node 1 stands twice"),
    ("t.json", '{"nodes": [{"id": 7, "ideal": null, "measured": [0, 0, 1]}]}',
     "node 7 has no coordinates 'ideal'; it has measured"),
    ("t.xls", "", "t.xls': the name ends in '.xls'; give a file .json or .csv"),
])
def test_wrong_files_of_tables_are_refused(tmp_path, name, text, message):
    (tmp_path / name).write_text(text)
    with pytest.raises(ValueError, match=message):
        meshes.read_table(tmp_path / name)


def test_unknown_tables_are_refused():
    with pytest.raises(ValueError, match="no geometry 'kiewitt'; choose from arc, hex, plan, or give the path"):
        meshes.dome("kiewitt")
    with pytest.raises(ValueError, match="'nowhere.json': there is no such file"):
        meshes.dome("nowhere.json")


@pytest.mark.parametrize("build, message", [
    (lambda: meshes.structure(meshes.dome("hex"), 5, triangles=False),
     "5 cells along the edges of panels of three nodes, in quadrilaterals; the number must be even, or the cells"),
    (lambda: meshes.structure(PANEL_ON_TWO_BARS, 0), "divisions is 0; it must be at least 1"),
    (lambda: meshes.structure(PANEL_ON_TWO_BARS, 5, grading=2.0),
     "5 divisions with a grading of 2.0; the number must be even"),
    (lambda: meshes.structure(PANEL_ON_TWO_BARS, 4, grading=0.5), "grading is 0.5; it must be at least 1"),
    (lambda: meshes.structure(table(nodes=NODES | {"e": (1, 0, 0)}, bars=[*BARS, ("e", "d")]), 2),
     "bar a-b passes the node e and does not meet it; divide it there"),
    (lambda: meshes.structure(table(nodes=NODES | {"e": (2, 0.5, 0.25)}, bars=[*BARS, ("e", "d")]), 2),
     "edge b-c passes the node e"),
])
def test_structures_that_cannot_be_meshed_are_refused(build, message):
    with pytest.raises(ValueError, match=message):
        fx.read_mixed(build, ["bars"])


def sheet(mixed_kinds=False, twice=False, line="tail", **names):
    """Two squares side by side with a line that leaves them; names of groups by their keys."""
    geo = gmsh.model.geo
    p = [geo.addPoint(*x, 0) for x in ((0, 0), (1, 0), (2, 0), (2, 1), (1, 1), (0, 1), (3, 3))]
    middle, tail = geo.addLine(p[1], p[4]), geo.addLine(p[3], p[6])
    rest = [geo.addLine(p[i], p[(i + 1) % 6]) for i in range(6)]
    left = geo.addPlaneSurface([geo.addCurveLoop([rest[0], middle, rest[4], rest[5]])])
    right = geo.addPlaneSurface([geo.addCurveLoop([rest[1], rest[2], rest[3], -middle])])
    surfaces = [left, right]
    for curve in (middle, tail, *rest):
        geo.mesh.setTransfiniteCurve(curve, 3)
    for surface in surfaces:
        geo.mesh.setTransfiniteSurface(surface)
    geo.mesh.setRecombine(2, left)
    if not mixed_kinds:
        geo.mesh.setRecombine(2, right)
    if twice:
        surfaces.append(geo.addPlaneSurface([geo.addCurveLoop([rest[0], middle, rest[4], rest[5]])]))
        geo.mesh.setTransfiniteSurface(surfaces[-1])
        geo.mesh.setRecombine(2, surfaces[-1])
    geo.synchronize()
    for name, surface in zip(("left", "right", "again"), surfaces, strict=False):
        gmsh.model.addPhysicalGroup(2, [surface], name=name)
    for name, (dimension, tags) in {"seam": (1, [middle]), "tail": (1, [tail]), "both": (1, [middle, tail]),
                                    "tip": (0, [p[6]]), "corner": (0, [p[0]])}.items():
        if name in names:
            gmsh.model.addPhysicalGroup(dimension, tags, name=names[name])


@pytest.mark.parametrize("build, bars, message", [
    (lambda: sheet(tail="tail", tip="tip"), ["frame"], "'frame' in bars is no group; give groups of curves"),
    (lambda: sheet(tail="tail"), ["left"], "'left' in bars is a group of surfaces; give groups of curves"),
    (lambda: sheet(tail="tail", corner="corner"), ["corner"], "'corner' in bars is a group of points"),
    (lambda: sheet(tail="tail"), [], "bars names no group; give groups of curves .there are tail., or read surfaces"),
    (lambda: sheet(seam="seam", tail="tail"), ["seam"], "the curves 'tail' are no bars, and not all of them are"),
    (lambda: sheet(both="both", tail="tail"), ["tail"], "the curves 'both' are no bars, and not all of them are on"),
    (lambda: sheet(seam="left", tail="tail"), ["tail"], "the group 'left' is one of curves and of surfaces; give each"),
    (lambda: sheet(seam="seam", tip="tip"), ["seam"], "the point 'tip' is on no cell of a named group"),
    (lambda: sheet(mixed_kinds=True, tail="tail"), ["tail"],
     "mixed kinds of cells, 'Quadrilateral 4' in the group 'left' and 'Triangle 3' in 'right'; mesh all surfaces"),
    (lambda: sheet(twice=True, tail="tail"), ["tail"],
     "cells of the groups 'left' and 'again' share two edges at .*; remove what stands twice"),
    (lambda: meshes.frame({"a": (0, 0, 0), "b": (1, 0, 0)}, {"bar": ("a", "b", 2)}), ["bar"],
     "no group of surfaces; read bars alone with read"),
    (lambda: gmsh.model.geo.addPoint(0, 0, 0), ["bar"], "no physical group of curves or surfaces; name those"),
])
def test_wrong_mixed_models_are_refused(build, bars, message):
    with pytest.raises(ValueError, match=f"read_mixed: .*{message}"):
        fx.read_mixed(build, bars)


def box():
    gmsh.model.occ.addBox(0, 0, 0, 1, 1, 1)
    gmsh.model.occ.synchronize()
    gmsh.model.addPhysicalGroup(2, [1], name="face")
    gmsh.model.addPhysicalGroup(3, [1], name="solid")


@pytest.mark.parametrize("source, settings, message", [
    (lambda: sheet(tail="tail"), {},
     r"the curves 'tail' are not on edges of surfaces; .*read_mixed\(..., bars=\['tail'\]"),
    (lambda: sheet(tip="tip"), {}, "the point 'tip' is on no cell of a named group; add its curve or surface"),
    (box, {}, "the group 'solid' is one of volumes; only curves and surfaces"),
    (sheet, {"order": 4}, "order is 4; it must be one of 1, 2, 3"),
    (sheet, {"place": lambda x: x / 0}, "place gives no finite coordinates for"),
    (sheet, {"place": lambda x: x * (1, 0, 1)}, "4 cells of the group 'left' have no area, the first at .*; correct"),
    (lambda: meshes.frame({"a": (0, 0), "b": (1, 0)}, {"bar": ("a", "b", 2)}), {"place": np.zeros_like},
     "2 cells of the group 'bar' have no length"),
    (sheet, {"place": lambda x: x + np.outer(x[:, 0], (0, 0, 1)), "dimension": 2},
     "the structure has places out of the x-y plane, by up to 2; read it in 3 dimensions, or in its plane with place="),
])
@pytest.mark.filterwarnings("ignore:divide by zero", "ignore:invalid value")
def test_wrong_models_are_refused(source, settings, message):
    with pytest.raises(ValueError, match=f"read: .*{message}"):
        fx.read(source, **{"dimension": 3} | settings)


def test_wrong_files_are_refused(tmp_path):
    def refused(file, message):
        with pytest.raises(ValueError, match=f"read .*{file.name}': .*{message}"):
            fx.read(file, 3)

    refused(tmp_path / "missing.msh", "there is no such file in .*; give the path of a .msh file")
    (tmp_path / "notes.msh").write_text("Dear reader")
    (tmp_path / "cut.msh").write_text("$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Nodes\n1 2\n")
    refused(tmp_path / "notes.msh", "the file is none of gmsh's; save the mesh from gmsh")
    refused(tmp_path / "cut.msh", "gmsh cannot read the file .*; save the mesh from gmsh again")
    nameless = save(tmp_path / "nameless.msh", lambda: (gmsh.model.occ.addRectangle(0, 0, 0, 1, 1),
                                                        gmsh.model.occ.synchronize()))
    refused(nameless, "no physical group of curves or surfaces; name those")
    refused(save(tmp_path / "tail.msh", lambda: sheet(tail="tail")), "read both with read_mixed")
    refused(save(tmp_path / "kinds.msh", lambda: sheet(mixed_kinds=True)), "mixed kinds of cells, .*'left'")

    def incomplete():
        gmsh.option.setNumber("Mesh.SecondOrderIncomplete", 1)
        meshes.rectangle((2, 2))

    refused(save(tmp_path / "eight.msh", incomplete, order=2), "the group 'shell' has cells 'Quadrilateral 8'; only")


WRONG = """
import sheetfx as fx
from test_mixed import sheet
for bars in (["frame"], []):
    try:
        fx.read_mixed(lambda: sheet(tail="tail"), bars)
    except ValueError as error:
        print(error)
try:
    fx.read_mixed(lambda: 1 / 0, ["bars"])
except ZeroDivisionError as error:
    print(error)
"""


def test_errors_reach_all_processes():
    lines = on_two_processes(WRONG)
    assert [line.split(";")[0] for line in lines] == ["read_mixed: 'frame' in bars is no group",
                                                      "read_mixed: bars names no group", "division by zero"]
