"""The tested structures of the thesis (section 5.4), and structures of bars and sheets from a file of one's own."""

from __future__ import annotations

import json

import numpy as np
import pytest
from helpers import on_two_processes

import sheetfx as fx
from sheetfx.meshes.tables import STRUCTURES
from sheetfx.model.assembled import flange_width, seat
from sheetfx.scenes import load_case

FRAME = {
    "nodes": {"a": [0, 0, 0], "b": [100, 0, 0], "c": [100, 80, 0], "d": [0, 80, 0]},
    "sets": {"feet": ["a", "d"], "tip": ["b"]},
    "materials": {"steel": {"modulus": 2.0e5, "poisson": 0.3}, "soft": {"modulus": 1.0e5, "yield_stress": 200.0}},
    "bars": {"long": {"section": {"Rectangle": {"width": 4, "depth": 8}}, "material": "steel",
                      "ends": [["a", "b"], ["d", "c"]]},
             "short": {"section": {"round_bar": {"diameter": 6}}, "material": "soft", "ends": [["b", "c"]]}},
    "panels": {"sheet": {"thickness": 1, "material": "steel", "corners": [["a", "d", "c", "b"]]}},
    "supports": {"feet": "x y z rx ry rz"}, "loads": {"tip": [0, 0, -1], "c": [0, 0, -1]},
    "monitor": {"at": "b", "component": "z", "sign": -1}}


def written(folder, **changes):
    file = folder / "frame.json"
    file.write_text(json.dumps(FRAME | changes))
    return file


def limit(scene: str, **options):
    record = fx.trace(load_case(scene)(**options))
    return next(p for p in record.critical_points if p.kind == "limit"), record


@pytest.mark.slow
def test_m1_coupled():
    """4.515 kN with eight cells a bar; four are 0.2 % above it."""
    point, record = limit("m1", coordinates="measured", divisions=4, to=4.4)
    assert point.load == pytest.approx(4.515e3, rel=0.01)
    assert point.deflection == pytest.approx(4.10, abs=0.1)
    assert record.case.quantities(record)["first_yield_load"] < point.load


def test_bars_alone():
    """Bars of M1, elastic-plastic: 6.33 kN, 6.347 by another program with 8 elements a bar."""
    point, _ = limit("m1", model="bars", divisions=4, to=5.5)
    assert point.load == pytest.approx(6.33e3, rel=0.01)


@pytest.mark.slow
@pytest.mark.parametrize("scene, options, load, tolerance", [
    ("m1", {"divisions": 6}, 11.03e3, 0.01), ("m1", {"divisions": 4, "eccentric": True}, 11.34e3, 0.005),
    ("m1", {"divisions": 4, "coordinates": "measured", "eccentric": True}, 6.49e3, 0.005),
    ("m2", {"model": "bars", "coordinates": "measured"}, 6.985e3, 0.01),
    ("m2", {"coordinates": "measured", "to": 2.85}, 13.76e3, 0.005),
    ("m2", {"coordinates": "measured", "eccentric": True, "to": 2.8}, 14.28e3, 0.005)])
def test_limit_loads(scene, options, load, tolerance):
    """Values of scripts outside this project, on the same meshes but for the first, which is converged to 0.5 %."""
    assert limit(scene, **options)[0].load == pytest.approx(load, rel=tolerance)


TWO = """
import sheetfx as fx
from sheetfx.scenes import load_case
for options in {options}:
    record = fx.trace(load_case("m1")(**options))
    print(*(x for p in [*record.critical_points, record.states[-1]] for x in (p.load, p.deflection)))
"""


@pytest.mark.slow
def test_two_processes_follow_the_path_of_one():
    """Coupled and yielding, welded and screwed with contact, and bars with flanges."""
    options = [{"coordinates": "measured", "divisions": 2, "to": 4.4}, {"model": "flange", "divisions": 2, "to": 2.0},
               {"model": "contact", "coordinates": "measured", "elastic": True, "screws": 1, "divisions": 2, "to": 1.0}]
    records = [fx.trace(load_case("m1")(**given)) for given in options]
    for record, line in zip(records, on_two_processes(TWO.format(options=options)), strict=True):
        found = [x for p in [*record.critical_points, record.states[-1]] for x in (p.load, p.deflection)]
        assert [float(x) for x in line.split()] == pytest.approx(found, rel=1e-8)


def test_a_plan_for_m3():
    """Ribs, edges and columns by their own sections; the five loads add up to one."""
    case = load_case("m3")(model="bars", elastic=True, divisions=2, to=0.5)
    assert len(case.scene.loads) == 5
    assert sum(load.force[2] for load in case.scene.loads) == pytest.approx(-1.0)
    assert [part.section.depth for part in case.scene.parts] == [20.19, 20.21, 40.0]
    assert fx.trace(case).states[-1].load > 0


def test_own_structure(tmp_path):
    """Two cantilevers that sink alike: the work of both unit forces in closed form, by Timoshenko's beam."""
    structure = fx.read_structure(written(tmp_path))
    scene = fx.skeleton(structure, fx.Cells(2))
    state = fx.trace(fx.Case(scene, fx.ArcLength(step=1e-3), fx.Until(steps=1))).states[0]
    inertia, shear = 4 * 8**3 / 12, 5 / 6 * 32 * 2.0e5 / 2.6
    assert state.reference[1] == pytest.approx(2 * (100**3 / (3 * 2.0e5 * inertia) + 100 / shear), rel=1e-6)


def test_kinds_have_their_own_material(tmp_path):
    scene = fx.coupled(fx.read_structure(written(tmp_path)), fx.Cells(2))
    assert [type(part.material).__name__ for part in scene.parts] == ["Elastic", "Plastic", "Elastic"]
    unyielding = fx.read_structure(written(tmp_path)).elastic()
    assert type(unyielding.bars["short"].material).__name__ == "Elastic"
    assert unyielding.bars["short"].material.modulus == 1.0e5


def test_normals_point_away_from_the_bars(tmp_path):
    """Whatever the order of corners, an offset is above the bars."""
    turned = {"sheet": FRAME["panels"]["sheet"] | {"corners": [["a", "b", "c", "d"]]}}
    one, other = (fx.read_structure(written(tmp_path, **{"panels": p})).table.panels
                  for p in (FRAME["panels"], turned))
    assert {tuple(row) for row in one} == {("b", "c", "d", "a")}
    assert {tuple(row) for row in other} == {("a", "b", "c", "d")}


def test_flanges_and_seats(tmp_path):
    """Own width and six thicknesses of the sheet on its one side, at most; nothing where there is no sheet."""
    structure = fx.read_structure(written(tmp_path))
    assert flange_width(structure, structure.bars["long"], ("a", "b")) == pytest.approx(4 + 12 * 1.0)
    assert seat(structure) == pytest.approx(4 + 0.5)


@pytest.mark.parametrize("screws, radius", [(0, 1.0), (1, 1.0), (2, 3.0)])
@pytest.mark.slow
def test_screws_stiffen(tmp_path, screws, radius):
    """Between what welds at the corners alone and full compatibility do."""
    structure = fx.read_structure(written(tmp_path)).elastic()

    def stiffness(scene):
        return 1 / fx.trace(fx.Case(scene, fx.ArcLength(), fx.Until(steps=1))).states[0].reference[1]

    bounds = [stiffness(fx.touching(structure, fx.Cells(4), fx.Joining(5.0, faces="seat", gap=1.0))),
              stiffness(fx.coupled(structure, fx.Cells(4)))]
    found = stiffness(fx.touching(structure, fx.Cells(4), fx.Joining(5.0, screws, radius, faces="seat", gap=1.0)))
    assert bounds[0] * (1 - 1e-9) <= found < bounds[1]
    assert (found > bounds[0] * (1 + 1e-6)) == (screws > 0)


@pytest.mark.parametrize(("after", "length"), [(0.0, 0.5), (0.1, 0.2), (0.25, 0.25), (0.3, 0.7), (0.55, 0.1)])
def test_a_stretch_begins_behind_the_start_of_an_edge(after, length):
    """Within cells, at their ends, over several, from both ends of the edge."""
    mesh = fx.read(lambda: fx.meshes.rectangle((4, 1), (1.0, 1.0)), 3)
    for start, sign in (("south-west", 1), ("south-east", -1)):
        line, = fx.Stretch(start, along="south", length=length, after=after).lines(mesh)
        first, last = line[0].places(np.array([0.0]))[0, 0], line[-1].places(np.array([1.0]))[0, 0]
        assert [first, last] == pytest.approx([0.5 - sign * (0.5 - after), 0.5 - sign * (0.5 - after - length)])
        assert sum(piece.length() for piece in line) == pytest.approx(length)
    with pytest.raises(ValueError, match="its length 1.1 is more than the 1 of 'south'"):
        fx.Stretch("south-west", along="south", length=0.8, after=0.3).lines(mesh)
    with pytest.raises(ValueError, match="after is 0.1 along no edge or curves"):
        fx.Stretch("south-west", end="south-east", after=0.1)


@pytest.mark.parametrize("changes, message", [
    ({"materials": {"steel": {"modulus": 2e5, "E": 1.0}}}, "material 'steel': no 'E'; choose from modulus, poisson"),
    ({"materials": {"steel": {"poisson": 0.3}}}, "material 'steel' has no 'modulus'"),
    ({"materials": {"steel": {"modulus": 2e5}}}, "bars 'short': material: no 'soft'; choose from steel"),
    ({"supports": {"foot": "x"}}, "Structure: supports: no 'foot'; choose from feet, tip, a"),
    ({"loads": {"tip": [0, 1]}}, r"load at 'tip' \(0.0, 1.0\) has 2 components"),
    ({"loads": {"tip": [0, 0, 0]}}, "loads is"),
    ({"monitor": {"component": "z"}}, "monitor has no 'at'"),
    ({"bars": {}, "panels": {}}, "node a belongs to no bar"),
    ({"bars": {"long": FRAME["bars"]["long"] | {"section": {"Square": {}}}}}, "section: no 'Square'; choose from"),
    ({"bars": {"long": FRAME["bars"]["long"] | {"section": "round"}}}, "section is 'round'; write it like"),
    ({"panels": {"sheet": {"material": "steel", "corners": [["a", "b", "c"]]}}}, "panels 'sheet' has no 'thickness'"),
    ({"sets": {"feet": ["e"]}}, "set feet: there is no node 'e'")])
def test_wrong_files_are_refused(tmp_path, changes, message):
    with pytest.raises(ValueError, match=message):
        fx.read_structure(written(tmp_path, **changes))


def test_wrong_joints_are_refused(tmp_path):
    structure = fx.read_structure(written(tmp_path))
    with pytest.raises(ValueError, match="weld is 40; give a length below half of the shortest edge, 40"):
        fx.touching(structure, fx.Cells(2), fx.Joining(40.0))
    with pytest.raises(ValueError, match="5 screws with radius 10 overlap on"):
        fx.touching(structure, fx.Cells(2), fx.Joining(5.0, 5, 10.0))
    bare = {"panels": {}}
    for scene in (fx.coupled, lambda *given: fx.touching(*given, fx.Joining(1.0))):
        with pytest.raises(ValueError, match="panels is empty; give some, or take its `skeleton`"):
            scene(fx.read_structure(written(tmp_path, **bare)), fx.Cells(2))
    with pytest.raises(ValueError, match="give a JSON file"):
        fx.read_structure(tmp_path / "frame.csv")


def test_tables_of_the_thesis():
    for name, nodes, bars, panels in (("m1", 25, 56, 40), ("m2", 37, 90, 54)):
        for coordinates in ("ideal", "measured"):
            table = fx.read_structure(STRUCTURES[name], coordinates).table
            assert (len(table.nodes), len(table.bars), len(table.panels)) == (nodes, bars, panels)
    radius = np.linalg.norm(np.array([*fx.read_structure(STRUCTURES["m1"]).nodes.values()]) + [0, 0, 843.75], axis=1)
    assert radius == pytest.approx(993.75, rel=1e-3), "on one sphere"


@pytest.mark.slow
def test_feet_of_m3_slide():
    """On a smooth floor columns spread, on a rough one less; held feet carry most."""
    loads = [fx.trace(load_case("m3")(model="bars", elastic=True, divisions=2, to=2.0, **feet)).states[-1].load
             for feet in ({"slide": 0.0}, {"slide": 0.2}, {})]
    assert 0 < loads[0] < loads[1] < loads[2]


@pytest.mark.slow
@pytest.mark.parametrize(("divisions", "limit"), [(4, 3920.0), (6, 3705.0)])
def test_panels_that_rub_on_their_bars(divisions, limit):
    """M1, measured and eccentric: friction 0.2 raises the limit without it (3701 N with 6 divisions) by 0.1 %.

    Independent: 3.92 kN with 4 divisions; finer meshes were given up. Limits depend on steps by some 0.01 %.
    """
    case = load_case("m1")(model="contact", coordinates="measured", eccentric=True, divisions=divisions, to=5.0)
    record = fx.trace(case)
    first = next(point for point in record.critical_points if point.kind == "limit")
    assert first.load == pytest.approx(limit, rel=1e-3)
    assert len(record.states) < 20
