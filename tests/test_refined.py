"""Critical points on finer meshes, found without their paths."""

import json
import time

import pytest
from typer.testing import CliRunner

import sheetfx as fx
from sheetfx.cli import app
from sheetfx.ladder.meshes import by_option
from sheetfx.ladder.refined import Refinement
from sheetfx.scenes import arch, cylinder_panel, dome, m1, roof


def refined(function, within, **parameters):
    record = fx.trace(function(**parameters))
    told = []
    found = Refinement(record, by_option(function, parameters, 4), within, told.append).all()
    assert set(found) <= set(told)
    return found


@pytest.mark.slow
def test_loads_are_those_of_the_path_on_the_finer_mesh():
    first, second = refined(roof.case, 5e-4, cells=4, form="naghdi-q2", to=20.0)
    assert (first.mesh, second.mesh) == ("cells 8", "cells 16")
    for one, cells in ((first, 8), (second, 16)):
        points = fx.trace(roof.case(cells=cells, form="naghdi-q2", to=20.0)).critical_points
        there = next(point for point in points if point.name == one.point.name)
        assert one.load == pytest.approx(there.load, rel=1e-8)
        assert abs(one.error) < 5e-4 * one.load and not one.reason
    exact = fx.trace(roof.case(cells=32, form="naghdi-q2", to=20.0)).critical_points[1].load
    assert 0.5 < second.error / (second.load - exact) < 1.7


@pytest.mark.parametrize(("how", "within", "mesh"), [
    ({}, 1e-3, "elements 80"),
    pytest.param({"yield_stress": 40.0, "to": 30.0}, 1e-2, "elements 40", marks=pytest.mark.slow)],
    ids=["contact", "yielding"])
@pytest.mark.slow
def test_pieces_of_finer_paths_lead_where_these_lead(how, within, mesh):
    """Whole paths have other steps, which counts where states depend on those before."""
    first = refined(arch.case, within, elements=20, **how)[0]
    assert first.mesh == mesh
    points = fx.trace(arch.case(elements=int(mesh.split()[1]), **how)).critical_points
    there = next(point for point in points if point.kind == "limit")
    assert first.load == pytest.approx(there.load, rel=1e-4)


@pytest.mark.slow
def test_modes_that_change_places_are_noticed():
    """The first two modes of the panel do so from 2 cells to 4."""
    found = refined(cylinder_panel.case, 1e-3, cells=(2, 2))
    assert any("points have changed places" in one.reason for one in found)


@pytest.mark.slow
def test_the_coupled_dome_without_its_path():
    record = fx.trace(dome.case(divisions=4))
    point = next(p for p in record.critical_points if p.kind == "limit")
    (found,) = Refinement(record, by_option(dome.case, {"divisions": 4}, 1), 1e-4).all([point])
    begun = time.process_time()
    path = fx.trace(dome.case(divisions=8))
    assert found.seconds < (time.process_time() - begun) / 2  # half of it the error bar
    there = next(p for p in path.critical_points if p.kind == "limit")
    assert found.load == pytest.approx(there.load, rel=1e-8)
    assert "no finer mesh is allowed" in found.reason


@pytest.mark.slow
def test_the_plastic_dome_of_the_tests():
    (found,) = refined(m1.case, 3e-2, divisions=2)
    assert found.load == pytest.approx(11.1e3, rel=2e-2) and abs(found.error) < 3e-2 * found.load


@pytest.mark.slow
def test_a_run_refines(tmp_path):
    words = ["roof", "--cells", "2", "--form", "naghdi-q2", "--to", "15", "--no-pictures", "--within", "0.5%"]
    result = CliRunner().invoke(app, ["run", *words, "-o", str(tmp_path)])
    assert result.exit_code == 0, result.output
    (found,) = json.loads((tmp_path / "summary.json").read_text())["refined"]
    assert found["point"] == 0 and abs(found["error"]) < 5e-3 * found["load"]
    cells = int(found["mesh"].split()[1])
    (there,) = fx.trace(roof.case(cells=cells, form="naghdi-q2", to=15.0)).critical_points
    assert found["load"] == pytest.approx(there.load, rel=1e-8)
    assert f"with {found['mesh']}" in result.output


def test_bad_share_is_refused(command):
    status, _, said = command("run", "roof", "--within", "3")
    assert status == 2 and "--within is '3'; it must be a share above 0 and below 1" in said
