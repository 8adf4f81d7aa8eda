"""What a run draws by itself, and what records draw, animate and view."""

import os
import re
import shlex
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from helpers import on_two_processes
from matplotlib.image import imread
from PIL import Image

import sheetfx as fx
from sheetfx.scenes import load_case
from sheetfx.show import viewer
from sheetfx.show.measure import Measure
from sheetfx.show.views import draw_states, view
from sheetfx.studies.diagram import Traced
from sheetfx.studies.diagram_picture import branch_key

PAGE = (Path(__file__).parents[1] / "demos" / "pages" / "first_scene.md").read_text()
SIGNATURES = {"png": b"\x89PNG", "svg": b"<?xml", "pdf": b"%PDF", "gif": b"GIF8"}


def truss(**how):
    """Two bars under a force at their apex, which snap through; how: attributes of the case."""
    nodes = {"left": (-1.0, 0.0), "right": (1.0, 0.0), "apex": (0.0, 0.3)}
    mesh = fx.read(lambda: fx.meshes.frame(nodes, {"one": ("left", "apex", 1), "two": ("apex", "right", 1)}), 2)
    bars = fx.Bar(mesh, fx.Rectangle(0.01, 0.01), fx.Elastic(2.1e11))
    scene = fx.Scene([bars], [fx.pin(mesh, "left"), fx.pin(mesh, "right")],
                     [fx.PointForce(mesh, "apex", (0.0, -1.0))], fx.Monitor(mesh, "apex", "y", -1.0))
    return fx.Case(**{"scene": scene, "control": fx.ArcLength(0.02), "until": fx.Until(deflection=0.6),
                      "axes": ("deflection (m)", "load (N)")} | how)


def corner(**how):
    """Two plates at right angles and a bar along one of them."""
    nodes = {"a": (0, 0, 0), "b": (1, 0, 0), "c": (1, 1, 0), "d": (0, 1, 0), "e": (0, 0, 0.4), "f": (1, 0, 0.4)}
    sheets = fx.read(lambda: fx.meshes.panels(nodes, {"skin": "abcd", "web": "abfe"}, 2), 3, 2)
    line = fx.read(lambda: fx.meshes.frame({"p": (0, 1, 0), "q": (1, 1, 0)}, {"bar": ("p", "q", 2)}), 3)
    soft = fx.Elastic(1e6, 0.3)
    parts = [*(fx.Shell(sheets, fx.Plate(0.01), soft, group=g) for g in ("skin", "web")),
             fx.Beam(line, fx.Rectangle(0.05, 0.05), soft)]
    scene = fx.Scene(parts, [fx.clamp(sheets, "d-a"), fx.clamp(line, "p")],
                     [fx.EdgeForce(sheets, "b-c", (0.0, 0.0, -0.02))], fx.Monitor(sheets, "b", "z", -1.0),
                     joints=[fx.weld(line, "bar", (sheets, "skin"))])
    return fx.Case(**{"scene": scene, "control": fx.LoadControl(0.5),
                      "buckling": lambda path, state: fx.buckling(path, state, 1),
                      "axes": ("deflection (m)", "load (N)")} | how)


@pytest.fixture(scope="module")
def snapped():
    return fx.trace(truss())


@pytest.fixture(scope="module")
def bent():
    return fx.trace(corner())


def files_of(folder):
    return {f.relative_to(folder).as_posix() for f in folder.rglob("*") if f.is_file()}


def test_first_scene_leaves_every_file_that_its_page_names(tmp_path):
    """The script and the command of the page, literally."""
    script, = re.findall(r"^```python\n(.*?)^```", PAGE, re.MULTILINE | re.DOTALL)
    command, = re.findall(r"^docker/run sheetfx (.*)$", PAGE, re.MULTILINE)
    (tmp_path / "truss.py").write_text(script)
    result = subprocess.run([sys.executable, "-m", "sheetfx", *shlex.split(command)], cwd=tmp_path,
                            capture_output=True, text=True, timeout=300, env=os.environ | {
                                "PYTHONPATH": str(Path(__file__).parents[1])})
    assert result.returncode == 0, result.stderr
    told = PAGE[PAGE.index("\nwrites `path.csv`"):].split("into")[0]
    named = re.findall(r"`([\w/]+\.\w+)`", told)
    assert {"path.csv", "path.png", "shape.png", "summary.json", "paraview/path.pvd"} == set(named)
    assert set(named) <= files_of(tmp_path / "results" / "truss")


def test_no_pictures_where_none_are_asked_for(tmp_path):
    fx.run(truss(pictures=()), "truss", {}, tmp_path, False)
    assert {f.split("/")[0] for f in files_of(tmp_path)} - {".lock"} == {
        "manifest.json", "parameters.json", "path.csv", "summary.json", "states"}


@pytest.mark.slow
def test_linear_buckling_draws_its_modes_alone(tmp_path):
    fx.run(corner(until=fx.Until(steps=0)), "corner", {}, tmp_path, False)
    found = files_of(tmp_path)
    assert {"modes.png", "buckling.csv", "paraview/modes.pvd", "paraview/modes1.pvd"} <= found
    assert not {"path.png", "shape.png", "paraview/path.pvd"} & found
    fx.show.view_folder(tmp_path, file=tmp_path / "view.png")
    assert (imread(tmp_path / "view.png")[..., :3] < 0.9).any()


def test_scenes_draw_the_standard_pictures():
    for name in ("column", "lee-frame", "plate-buckling"):
        assert tuple(load_case(name)().pictures)[:len(fx.show.STANDARD)] == fx.show.STANDARD, name


@pytest.mark.parametrize("ending", ["png", "svg", "pdf"])
@pytest.mark.slow(quick=1)
def test_pictures_have_the_format_of_their_ending(snapped, tmp_path, ending):
    for name in ("curve", "shapes"):
        figure = getattr(snapped, name)(tmp_path / f"{name}.{ending}")
        assert figure.axes[0].get_xlabel()
        assert (tmp_path / f"{name}.{ending}").read_bytes().startswith(SIGNATURES[ending])
    assert snapped.curve()._repr_png_().startswith(SIGNATURES["png"])


@pytest.mark.parametrize(("draw", "file"), [("curve", "a.txt"), ("shapes", "b"), ("modes", "c.gif"),
                                            ("animate", "d.png"), ("view", "e.svg")])
def test_endings_that_name_no_format_are_refused(snapped, tmp_path, draw, file):
    with pytest.raises(ValueError, match=f"{draw}: file is .*{file}.*must end with"):
        getattr(snapped, draw)(tmp_path / file)


@pytest.mark.parametrize("along", ["r", (1.0, 0.0), (0.0, 0.0, 0.0), 3])
def test_directions_of_colours_are_looked_at(snapped, along):
    with pytest.raises(ValueError, match="along is .*must be"):
        snapped.shapes(along=along)


@pytest.mark.parametrize(("along", "direction"), [(None, None), ("z", (0, 0, 1)), ((0.0, 3.0, -4.0), (0, 0.6, -0.8))])
@pytest.mark.slow(quick=1)
def test_all_parts_are_coloured_by_one_measure(bent, along, direction):
    """Plates at right angles and a bar: each place by its displacement, whatever its normal is."""
    measure = Measure(along)
    shown = view(bent, "end", measure)
    surfaces = [(s.current - s.undeformed, s.values) for s in shown.surfaces]
    assert len(surfaces) == 1 and shown.beam_values is not None
    for moved, values in surfaces:
        expected = np.linalg.norm(moved, axis=1) if direction is None else moved @ direction
        assert values == pytest.approx(expected, abs=1e-12)
    figure = draw_states(bent, [shown], measure)
    (bar,) = [axes for axes in figure.axes if axes.get_ylabel()]
    assert bar.get_ylabel() == f"{measure.name} (m)"
    low, high = bar.get_ylim()
    assert (low == 0) == (direction is None) and high == pytest.approx(max(np.abs(c).max() for c in shown.colours))


def test_modes_are_coloured_by_one_measure(bent, tmp_path):
    figure = bent.modes(tmp_path / "modes.png", along="y")
    assert [a.get_ylabel() for a in figure.axes if a.get_ylabel()] == ["displacement along y, over the largest"]
    assert bent.modes().axes[-1].get_ylabel() == "size of the displacement, over the largest"


def test_animation_has_a_frame_for_each_state(bent, tmp_path):
    bent.animate(tmp_path / "motion.gif")
    with Image.open(tmp_path / "motion.gif") as motion:
        assert motion.n_frames == len(bent.states)
        frames = []
        for number in range(motion.n_frames):
            motion.seek(number)
            frames.append(np.array(motion.convert("L")))
    assert all((one != other).any() for one, other in zip(frames, frames[1:], strict=False))
    assert bent.path.tracer.state is bent.states[-1]


def test_view_of_a_record(bent, tmp_path, monkeypatch):
    """A picture where a file is given, and in a notebook without trame; elsewhere a screen is needed."""
    bent.view(tmp_path / "view.png", along="z")
    assert (imread(tmp_path / "view.png")[..., :3] < 0.9).any()
    monkeypatch.setattr(viewer, "answers", lambda: False)
    with pytest.raises(ValueError, match="no X server answers.*write a picture"):
        bent.view()
    monkeypatch.setattr(viewer, "_in_notebook", lambda: True)
    monkeypatch.setattr(viewer.importlib.util, "find_spec", lambda name: None)
    assert (np.array(bent.view())[..., :3] < 230).any()


def test_view_wants_a_run_with_files_for_paraview(tmp_path):
    with pytest.raises(ValueError, match=r"view: .* holds no paraview/path.pvd .*give the folder of a finished run"):
        fx.show.view_folder(tmp_path)


def test_curve_points_are_on_the_path(snapped):
    points = fx.show.curve_points(snapped)
    assert len(points) > 20 * len(snapped.states)
    for state in snapped.states:
        assert np.abs(points - (state.deflection, state.load)).sum(axis=1).min() < 1e-9 * abs(state.load) + 1e-12


def test_branches_of_a_diagram_have_a_key():
    points = [{"title": "bifurcation point (stable symmetric)", "load": 2.5},
              {"title": "bifurcation point (asymmetric)", "load": 12345.678}]
    branches = [Traced("0"), *(Traced(name, origin=points[name[0] == "2"]) for name in ("1a", "1b", "2a"))]
    assert branch_key(branches, "load (N)") == ["1a, 1b: bifurcation point (stable symmetric),\nload 2.500 N",
                                                "2a: bifurcation point (asymmetric),\nload 12346 N"]
    many = [Traced("0"), Traced("1a", origin=points[0]), *(Traced(f"1a.{n}a", origin=points[1]) for n in range(20))]
    assert branch_key(many, "load") == ["1a: bifurcation point (stable symmetric),\nload 2.500"]


@pytest.mark.parametrize(("distance", "sign"), [(-1.0, -1.0), (1.0, 1.0), (-0.5, 1.0), (2.0, -1.0)])
def test_load_of_a_prescribed_displacement_is_along_it(distance, sign):
    """A structure that resists has a positive load, whichever way it is moved, as under a force that way."""
    nodes = {"base": (0.0, 0.0), "tip": (1.0, 0.0)}
    mesh = fx.read(lambda: fx.meshes.frame(nodes, {"beam": ("base", "tip", 4)}), 2)
    beam = fx.Beam(mesh, fx.Rectangle(0.1, 0.1), fx.Elastic(1.2e5, 0.0), degree=2)
    way, monitor = np.sign(distance), fx.Monitor(mesh, "tip", "y", sign)
    moved = fx.PrescribedDisplacement(mesh, "tip", "y", distance)
    pushed = fx.PointForce(mesh, "tip", (0.0, float(way)))
    by_motion = fx.trace(fx.Case(fx.Scene([beam], [fx.clamp(mesh, "base")], [moved], monitor), fx.LoadControl(
        0.01, target=0.02, fixed=True))).states[-1]
    by_force = fx.trace(fx.Case(fx.Scene([beam], [fx.clamp(mesh, "base")], [pushed], monitor), fx.LoadControl(
        by_motion.load, target=by_motion.load, fixed=True))).states[-1]
    assert by_motion.load > 0 and by_motion.deflection == pytest.approx(0.02 * distance * sign)
    assert by_force.deflection == pytest.approx(by_motion.deflection, rel=1e-6)


def test_panel_in_end_shortening_has_a_positive_load():
    """Two edges that are moved inwards together, the monitor counting inwards: the whole reaction is positive."""
    mesh = fx.read(lambda: fx.meshes.rectangle((2, 2)), 3, 2)
    shell = fx.Shell(mesh, fx.Plate(0.1), fx.Elastic(1e4, 0.0))
    scene = fx.Scene([shell], [fx.Support(mesh, "west", "x"), fx.Support(mesh, "south", "y"), *(
        fx.Support(mesh, e, "z") for e in ("west", "east"))], [fx.PrescribedDisplacement(mesh, "east", "x", -1e-3)],
        fx.Monitor(mesh, "south-east", "x", -1.0))
    state = fx.trace(fx.Case(scene, fx.LoadControl(1.0, fixed=True))).states[-1]
    assert state.deflection == pytest.approx(1e-3)
    assert state.load == pytest.approx(1e4 * 0.1 * 1e-3, rel=5e-3)


def test_pictures_on_two_processes(tmp_path):
    """One figure, on process 0; what it refuses, both do."""
    lines = on_two_processes(f'''
from pathlib import Path
import sheetfx as fx
from test_pictures import truss
record, folder = fx.trace(truss(until=fx.Until(deflection=0.2))), Path({str(tmp_path)!r})
figures = [record.curve(folder / "curve.svg"), record.shapes(folder / "shapes.png")]
record.animate(folder / "motion.gif")
record.view(folder / "view.png")
try:
    record.curve(folder / "missing" / "curve.png")
except OSError as error:
    print([f is not None for f in figures], type(error).__name__)
''')
    assert lines == ["[True, True] FileNotFoundError"]
    assert {"curve.svg", "shapes.png", "motion.gif", "view.png"} <= files_of(tmp_path)
