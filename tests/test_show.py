"""Pictures and files of a traced path: complete, not empty, and true to the record."""

import csv
import os
import shutil
import xml.etree.ElementTree as ElementTree
from collections import Counter

import numpy as np
import pytest
import ufl
from helpers import TURNED_AT_EDGES
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.image import imread
from mpi4py import MPI

from sheetfx import (
    ArcLength,
    Beam,
    Case,
    Contact,
    EdgeForce,
    Elastic,
    LoadControl,
    Monitor,
    ObstacleForce,
    Plate,
    PointForce,
    PrescribedDisplacement,
    Rectangle,
    RigidCylinder,
    Scene,
    Shell,
    Until,
    clamp,
    meshes,
    read,
    symmetry,
    trace,
)
from sheetfx.archive.folder import Archive
from sheetfx.continuation.state import CriticalPoint
from sheetfx.scenes import load_case
from sheetfx.show import contact, curves, display, pictures
from sheetfx.show.course import curve_of, monitored
from sheetfx.show.evaluate import ContactPoints, Curves, most_telling, travel, unit_of, with_unit
from sheetfx.show.files import paraview
from sheetfx.show.layout import Sheet
from sheetfx.show.measure import OF_SIZE
from sheetfx.show.surfaces import surfaces
from sheetfx.show.views import Camera, fit_titles, view

RADIUS, COPIES = 3380.6, 2


@pytest.fixture(scope="module")
def record(tmp_path_factory):
    """Half an arch under a punch, with friction, kept in an archive as a run keeps it."""
    mesh = read(lambda: meshes.arc(RADIUS, 0.0, np.radians(7.338), 10, {"crown": 0.0}), 2, 2)
    beam = Beam(mesh, Rectangle(25.4, 4.7625), Elastic(72395.0))
    punch = RigidCylinder(RADIUS, (0.0, 2 * RADIUS), travel=(0.0, -1.0))
    scene = Scene([beam], [clamp(mesh, "end"), symmetry(mesh, "crown")], [ObstacleForce(punch, 1 / COPIES)],
                  Monitor(mesh, "crown", "y", -1.0),
                  [Contact(beam, punch, "nodes", friction=0.2, distance=0.0)], COPIES)
    case = Case(scene, ArcLength(step=0.005), Until(deflection=20.0), axes=("deflection (mm)", "load (N)"))
    archive = Archive(tmp_path_factory.mktemp("run"), MPI.COMM_WORLD)
    archive.clear({})
    record = trace(case, [archive])
    record.table = archive.folder / "path.csv"
    assert record.critical_points
    return record


def assert_picture(file, shape=None):
    image = imread(file)[..., :3]
    assert shape is None or image.shape[:2] == shape
    assert 0.005 < (image < 0.9).any(axis=2).mean() < 0.7


def fields(record):
    return {k: v.copy() for k, v in record.path.discretisation.system.snapshot().items()}


@pytest.mark.slow
def test_path_curve_marks_each_state_and_critical_point(record, tmp_path):
    curves.path_curve(record, tmp_path)
    assert_picture(tmp_path / "path.png")
    lines = {line.get_label(): line.get_xydata() for line in curves.draw_path(record).axes[0].lines}
    with record.table.open() as stream:
        table = [(float(row["deflection"]), float(row["load"])) for row in csv.DictReader(stream)]
    assert np.allclose(lines["converged states"], table)
    kinds = Counter(p.kind for p in record.critical_points)
    for kind, (_, label) in curves.MARKERS.items():
        drawn = [len(xy) for name, xy in lines.items() if name.startswith(label)]
        assert drawn == ([kinds[kind]] if kinds[kind] else [])


def test_labels_name_kind_and_load(record):
    texts = [t.get_text() for t in curves.draw_path(record).axes[0].texts]
    points = most_telling(record.critical_points, curves.MOST_LABELS)
    assert texts == [f"{p.kind} {with_unit(p.load, 'N')}" for p in points]


def test_path_changes_stability_at_critical_points(record):
    class Stop:
        def __init__(self, load, unstable, *critical):
            self.step = self.deflection = self.load = load
            self.unstable_modes, self.critical, self.increment = unstable, critical, np.ones(1)

    first, second = (CriticalPoint("limit", load, load, 2) for load in (1.5, 1.7))
    knots, unstable = curves.path_knots([Stop(0, 0), Stop(1, 0), Stop(2, 0, first, second), Stop(3, 1)])
    assert knots[:, 1].tolist() == [0, 1, 1.5, 1.7, 2, 3]
    assert unstable.tolist() == [False, False, True, False, True]
    curve, segment = curves.smooth(knots)
    assert len(curve) == len(segment) + 1
    assert all(np.isclose(curve, knot).all(axis=1).any() for knot in knots)


def test_curve_has_no_extremes_but_at_states():
    knots = np.array([(0, 0), (60, 10), (58, -10), (86, 1), (92, 16), (95, 150)], dtype=float)
    curve, _ = curves.smooth(knots)
    turns = [(np.diff(np.sign(np.diff(points, axis=0)), axis=0) != 0).sum(axis=0) for points in (knots, curve)]
    assert turns[0].tolist() == turns[1].tolist()


def distances(points, curve):
    """Distances of points to a polygon, both over its extent."""
    extent = np.ptp(curve, axis=0)
    start, way = curve[:-1] / extent, np.diff(curve, axis=0) / extent
    arms = points[:, None] / extent - start
    part = np.clip((arms * way).sum(axis=2) / (way**2).sum(axis=1), 0, 1)
    return np.linalg.norm(arms - part[..., None] * way, axis=2).min(axis=1)


def test_drawn_curve_meets_states_between():
    """Lee's frame in steps of usual length, against its states in five times shorter steps, through the snap-back."""
    coarse, fine = (trace(load_case("lee-frame")(elements=5, step=step, to=85.0)) for step in (0.02, 0.004))
    states = np.array([(s.deflection, s.load) for s in fine.states])
    knots, _ = curves.path_knots(coarse.states)
    values, rates = monitored(coarse, coarse.states)
    curve, segment = curve_of(coarse, coarse.states, values, rates, lambda p: (p.deflection, p.load), stationary=1)
    assert len(fine.states) > 3 * len(coarse.states) and len(segment) == len(curve) - 1
    assert segment[-1] == len(knots) - 2, "an interval for each that has a stability"
    assert distances(knots, curve).max() < 1e-9
    assert distances(states, curve).max() < 2e-3 < distances(states, curves.smooth(knots)[0]).max()


def test_rate_of_a_reaction_is_that_of_the_load():
    """A tip that is moved: rates of the reported reaction against its differences."""
    mesh = read(lambda: meshes.frame({"base": (0, 0), "tip": (1, 0)}, {"beam": ("base", "tip", 4)}), 2)
    beam = Beam(mesh, Rectangle(0.1, 0.1), Elastic(1.2e5, 0.0))
    scene = Scene([beam], [clamp(mesh, "base")], [PrescribedDisplacement(mesh, "tip", "y", 0.5)],
                  Monitor(mesh, "tip", "y"))
    found = trace(Case(scene, LoadControl(0.01, fixed=True), Until(steps=20)))
    values, rates = monitored(found, found.states)
    slopes = (values[2:] - values[:-2]) / (values[2:, :1] - values[:-2, :1])
    assert slopes[:, 1] == pytest.approx(rates[1:-1, 1] / rates[1:-1, 0], rel=1e-3)


def test_critical_points_are_drawn_in_their_own_states():
    """Not at the end of their step: the state drawn has the load and deflection of the point."""
    found = trace(load_case("lee-frame")(elements=5))
    drawn = pictures.states_to_draw(found)
    titles = [label.split(":")[0] for _, label, _, _ in drawn]
    assert titles == ["limit point (maximum)", "limit point (minimum)", "end"]
    for (state, label, _, _), point in zip(drawn, found.critical_points, strict=False):
        assert state.load == pytest.approx(point.load, rel=1e-6)
        assert state.deflection == pytest.approx(point.deflection, rel=1e-4) and "drawn at" not in label
    assert found.path.tracer.state is found.states[-1]


def test_one_long_last_step_does_not_rule_the_axes():
    """Lee's frame goes up to four times its limit load in its last step, which leaves the frame."""
    found = trace(load_case("lee-frame")(elements=5))
    axes = curves.draw_path(found).axes[0]
    assert found.states[-1].load > 60000 and 20000 < axes.get_ylim()[1] < 40000
    assert any(t.get_text().startswith("goes on to 95.00, 7") for t in axes.texts)
    (legend,) = [axes.get_legend()]
    renderer = axes.figure.canvas.get_renderer()
    assert legend.get_window_extent(renderer).y0 >= axes.get_window_extent(renderer).y1, "above the data"


def test_rounding_is_not_drawn_as_a_path():
    """The corner of Roorda's perfect frame does not turn."""
    record = trace(load_case("roorda-frame")())
    assert 0 < max(abs(s.deflection) for s in record.states) < 1e-9
    assert not curves.path_knots(record.states)[0][:, 0].any()
    assert curves.draw_path(record).axes[0].get_xlim() == (-1.0, 1.0)
    assert all(label.endswith("deflection 0") for _, label, _, _ in pictures.states_to_draw(record))


def test_long_legends_fit_into_the_picture(tmp_path):
    sheet = Sheet((1600, 900), True, "", 1, entries=1)
    for label in ("one", "limit point (maximum): load 0.01670, deflection 11.62 (drawn at 12.88); " * 2, "short"):
        sheet.line(label, "#000000", np.array([[[0.0, 0, 0], [1.0, 1, 1]]]), 2.0)
    sheet.fit()
    figure = Figure(figsize=(16, 9), dpi=100)
    FigureCanvasAgg(figure)
    sheet.add_legend(figure)
    (legend,) = figure.legends
    box = legend.get_window_extent(figure.canvas.get_renderer())
    assert box.width > 1500 and box.x0 >= 0 and box.x1 <= 1600


def test_long_titles_of_views_do_not_overlap():
    figure = Figure(figsize=(16, 9), dpi=100)
    FigureCanvasAgg(figure)
    for i, title in enumerate(("short", "bifurcation point (unstable symmetric): load 0.8331 (drawn at 0.0026) " * 2)):
        figure.add_axes((0.5 * i, 0.0, 0.5, 0.9)).set_title(title, fontsize=14)
    fit_titles(figure, 800)
    renderer = figure.canvas.get_renderer()
    widths = [axes.title.get_window_extent(renderer).width for axes in figure.axes]
    assert 700 < max(widths) <= 800


def test_contact_forces_add_up_to_the_load(record, tmp_path):
    before, state = fields(record), record.nearest(150.0)
    contact.tractions(150.0)(record, tmp_path)
    assert_picture(tmp_path / "tractions.png")
    record.show(state)
    (points,) = ContactPoints(record).evaluate()
    record.show(record.states[-1])
    assert len(points.pressure) == 21
    assert COPIES * (points.weight @ points.pressure) == pytest.approx(state.load, rel=1e-3)
    assert all(np.array_equal(v, before[k]) for k, v in fields(record).items())


def test_contact_history(record, tmp_path):
    contact.contact_history(record, tmp_path)
    assert_picture(tmp_path / "contact_history.png")
    row = contact.summarise(ContactPoints(record).evaluate())
    assert row["touching"] == row["sticking"] + row["slipping"] > 0
    assert row["first"] <= row["peak"] <= row["last"]


def test_curves_and_obstacle_follow_the_state(record):
    undeformed, current = Curves(record).evaluate()
    assert np.allclose(np.linalg.norm(undeformed, axis=2), RADIUS, rtol=1e-6)
    crown = np.unravel_index(undeformed[..., 0].argmin(), undeformed.shape[:2])
    assert undeformed[crown][1] - current[crown][1] == pytest.approx(record.states[-1].deflection)
    assert -25 < travel(record, record.case.scene.contacts[0].obstacle)[1] < -10


def test_shapes(record, tmp_path):
    before = fields(record)
    pictures.shapes(record, tmp_path)
    pictures.shapes(record, tmp_path, "again.png")
    assert_picture(tmp_path / "shape.png", (900, 1600))
    assert_picture(tmp_path / "again.png", (900, 1600))
    assert all(np.array_equal(v, before[k]) for k, v in fields(record).items())


@pytest.mark.slow
def test_shapes_without_display(record, sheet, tmp_path, monkeypatch):
    """Curves do without; surfaces are left out with a remedy."""
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.setattr(display, "_window", lambda: None)
    monkeypatch.setattr(display.shutil, "which", lambda name: None)
    pictures.shapes(record, tmp_path)
    assert_picture(tmp_path / "shape.png", (900, 1600))
    with pytest.warns(UserWarning, match="install the package xvfb"):
        pictures.shapes(sheet, tmp_path, "sheet.png")
    assert not (tmp_path / "sheet.png").exists()


@pytest.mark.parametrize("window", [None, "vtkEGLRenderWindow"])
def test_display_leaves_the_environment_as_it_was(window, monkeypatch):
    """It starts an X server, or has VTK draw without one where it can."""
    if window is None and shutil.which("Xvfb") is None:
        pytest.skip("Xvfb is missing")
    monkeypatch.setenv("DISPLAY", ":12345")
    monkeypatch.setattr(display, "_window", lambda: window)
    before = dict(os.environ)
    with display.display():
        assert os.environ.get(display.CHOICE) == window
        assert (os.environ["DISPLAY"] == ":12345") == (window is not None)
    assert os.environ == before


@pytest.mark.skipif(shutil.which("Xvfb") is None, reason="Xvfb is missing")
@pytest.mark.parametrize("deaf", [1, display.STARTS])
def test_xvfb_that_accepts_no_connection_is_started_again(deaf, monkeypatch):
    """VTK ends the process where it finds none; here only the last of some servers answer, or none does."""
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.setattr(display, "_window", lambda: None)
    answers = iter([False, *deaf * [False], True])
    monkeypatch.setattr(display, "answers", lambda: next(answers))
    if deaf < display.STARTS:
        with display.display():
            assert os.environ["DISPLAY"].startswith(":")
    else:
        with pytest.raises(display.NoDisplay, match="accepts no connection"), display.display():
            pass


def test_paraview_has_every_state(record, tmp_path):
    import pyvista

    paraview(record, tmp_path)
    entries = list(ElementTree.parse(tmp_path / "paraview" / "path.pvd").iter("DataSet"))
    assert [float(e.get("timestep")) for e in entries] == [s.step for s in record.states]
    grid = pyvista.read(tmp_path / "paraview" / entries[-1].get("file"))
    crown = np.argmin(grid.points[:, 0])
    assert grid["displacement"].shape == grid["rotation"].shape == (21, 3)
    assert -grid["displacement"][crown, 1] == pytest.approx(record.states[-1].deflection)


@pytest.fixture(scope="module")
def sheet():
    """A strip of shell, whose rotations are at edges, beside a bar, both clamped and lifted at their ends."""
    mesh = read(lambda: meshes.rectangle((6, 2), (1.0, 0.2), triangles=True), 3, 2)
    shell = Shell(mesh, Plate(0.01), Elastic(1.2e6, 0.0), form=TURNED_AT_EDGES)
    line = read(lambda: meshes.frame({"base": (0, 0.4), "tip": (1, 0.4)}, {"bar": ("base", "tip", 4)}), 3)
    bar = Beam(line, Rectangle(0.1, 0.01), Elastic(1.2e6, 0.0))
    scene = Scene([shell, bar], [clamp(mesh, "west"), clamp(line, "base")],
                  [EdgeForce(mesh, "east", (0.0, 0.0, 1.0)), PointForce(line, "tip", (0.0, 0.0, 0.1))],
                  Monitor(mesh, "south-east", "z"))
    return trace(Case(scene, LoadControl(step=0.5, fixed=True), axes=("deflection (mm)", "load (N)")))


def test_surfaces_follow_the_state(sheet):
    (surface,) = surfaces(sheet)
    corner = np.argmin(np.linalg.norm(surface.undeformed - (1.0, 0.0, 0.0), axis=1))
    assert surface.current[corner, 2] == pytest.approx(sheet.states[-1].deflection)
    assert surface.mesh(surface.undeformed).area == pytest.approx(0.2)
    assert surface.edges(surface.undeformed).length > 0.2
    assert len(surface.borders) == sheet.case.scene.parts[0].mesh.domain.topology.index_map(2).size_local


def test_surfaces_with_a_displacement_of_the_user(sheet):
    mesh = sheet.case.scene.parts[0].mesh
    x = ufl.SpatialCoordinate(mesh.domain)
    (surface,) = surfaces(sheet, {mesh: ufl.as_vector([0.0, 0.0, x[0] * x[1]])})
    moved = surface.undeformed[:, 0] * surface.undeformed[:, 1]
    assert np.allclose(surface.current - surface.undeformed, np.column_stack([0 * moved, 0 * moved, moved]))


def test_shapes_of_surfaces(sheet, tmp_path):
    before = fields(sheet)
    pictures.shapes(sheet, tmp_path)
    curves.path_curve(sheet, tmp_path)
    assert_picture(tmp_path / "shape.png", (900, 1600))
    assert_picture(tmp_path / "path.png")
    assert all(np.array_equal(v, before[k]) for k, v in fields(sheet).items())


def test_views_fill_their_places_and_show_beams(sheet):
    shown = view(sheet, "end", OF_SIZE)
    assert shown.beams.shape[2] == 3
    camera = Camera([shown, shown])
    columns, rows = camera.fit(2)
    assert (columns, rows) in ((1, 2), (2, 1))
    across = camera.place(shown.places) @ camera.frame.T
    filled = np.ptp(across, axis=0)[:2] / (2 * camera.scale * camera.pixels / camera.pixels[1])
    assert 0.9 < filled.max() < 1.0


def test_paraview_of_shells(sheet, tmp_path):
    """The free end turns about y by 1.430 (Mattiasson 1981, table 1: P L^2 / EI = 10), coarse triangles by 3 % less."""
    import pyvista

    paraview(sheet, tmp_path)
    for name in ("path.pvd", "path1.pvd"):
        entries = list(ElementTree.parse(tmp_path / "paraview" / name).iter("DataSet"))
        assert len(entries) == len(sheet.states)
    entries = list(ElementTree.parse(tmp_path / "paraview" / "path.pvd").iter("DataSet"))
    grid = pyvista.read(tmp_path / "paraview" / entries[-1].get("file"))
    end = grid.points[:, 0] > 1 - 1e-9
    assert grid["displacement"][end, 2] == pytest.approx(sheet.states[-1].deflection, rel=2e-2)
    assert -grid["rotation"][end, 1] == pytest.approx(1.430, rel=0.05)


def test_numbers_and_units():
    assert unit_of("load on the arch (N)") == "N"
    assert unit_of("load") == ""
    assert with_unit(159.137, "N") == "159.1 N"
    assert with_unit(242858.3, "") == "242858"


def test_most_telling_points_include_first_highest_and_lowest():
    points = [CriticalPoint("limit", load, i, i) for i, load in enumerate([3, 9, 4, 4, 4, 4, -1, 4, 4, 4])]
    chosen = most_telling(points, 5)
    assert len(chosen) <= 5
    assert {points[0], points[1], points[6], points[-1]} <= set(chosen)
    assert most_telling(points, 10) == points


@pytest.fixture(scope="module")
def snapped_dome():
    """A shallow truss in space past its limit points."""
    from sheetfx.scenes import star_dome

    return trace(star_dome.case(to=4.0))


def test_configurations_of_a_dome_stand_side_by_side(snapped_dome, tmp_path, monkeypatch):
    """One view for each, coloured by displacement, with the undeformed bars behind; nothing over one another."""
    drawn = []
    monkeypatch.setattr(pictures, "draw_states", lambda record, views, measure: drawn.extend(views))
    pictures.picture_of_shapes(snapped_dome)()
    states = pictures.states_to_draw(snapped_dome, pictures.MOST_VIEWS - 1)
    assert len(drawn) == len(states) > 2 and [v.title.split("\n")[0] for v in drawn][-1] == "end"
    for shown, (state, *_) in zip(drawn, states, strict=True):
        assert shown.beam_values.max() == pytest.approx(state.deflection, rel=0.2)
        assert np.array_equal(shown.beams_before, drawn[0].beams_before)
    monkeypatch.undo()
    pictures.shapes(snapped_dome, tmp_path)
    assert_picture(tmp_path / "shape.png", (900, 1600))


def test_modes_are_drawn_to_a_scale_that_is_told(snapped_dome, monkeypatch):
    from sheetfx.show import modes

    point = snapped_dome.critical_points[0]
    shape = modes.shape_of(snapped_dome, snapped_dome.critical_modes(point)[0], "mode", OF_SIZE)
    drawn = []
    monkeypatch.setattr(modes, "draw_views", lambda views, manner: drawn.append((views, manner)))
    modes.draw_shapes(snapped_dome, [shape], OF_SIZE)
    (moved,), manner = drawn[0]
    size = float(np.linalg.norm(np.ptp(shape.beams_before.reshape(-1, 3), axis=0)))
    largest = np.linalg.norm(moved.beams - moved.beams_before, axis=2).max()
    assert largest == pytest.approx(modes.SHARE * size, rel=1e-6)
    assert manner.remarks[0] == f"largest displacement of a mode drawn as {largest:#.4g}".rstrip(".")
