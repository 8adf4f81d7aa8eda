"""Bodies that sections make: where their faces are, and what they are told by."""

from __future__ import annotations

import numpy as np
import pytest

import sheetfx as fx

STEEL = fx.Elastic(2e11, 0.3)


@pytest.fixture(scope="module")
def record():
    """An I-beam along x, a tube along y, a bar, and a plate that thickens along x."""
    ends = {"a": (0, 0, 2), "b": (1, 0, 2), "c": (1, 1, 2)}
    frame = fx.read(lambda: fx.meshes.frame(ends, {"ab": ("a", "b", 2), "bc": ("b", "c", 2)}), 3)
    bars = fx.read(lambda: fx.meshes.frame({"d": (0, 0, 4), "e": (1, 0, 4)}, {"de": ("d", "e", 1)}), 3)
    sheet = fx.read(lambda: fx.meshes.rectangle((3, 3)), 3, 2)
    parts = [fx.Beam(frame, fx.ISection(0.2, 0.1, 0.01, 0.02), STEEL, group="ab"),
             fx.Beam(frame, fx.Tube(0.1, 0.01), STEEL, group="bc"), fx.Bar(bars, fx.Rectangle(0.04, 0.06), STEEL),
             fx.Shell(sheet, fx.Plate(lambda x: 0.02 + 0.06 * x[0]), STEEL, offset=0.0)]
    held = [fx.clamp(frame, "a"), fx.pin(bars, "d"), fx.Support(bars, "e", "y z"), fx.clamp(sheet, "west")]
    with pytest.warns(UserWarning, match="nothing joins"):
        scene = fx.Scene(parts, held, [fx.PointForce(frame, "c", (0, 0, -1.0))], fx.Monitor(frame, "c", "z"))
    return fx.trace(fx.Case(scene, until=fx.Until(steps=0)))


def test_faces_are_where_the_sections_say(record):
    made = fx.show.solids(record)
    corners = {part: made.points[np.unique(np.concatenate([made.get_cell(i).point_ids for i in
                                                           np.flatnonzero(made.cell_data["part"] == part)]))]
               for part in range(4)}
    low, high = corners[0].min(axis=0), corners[0].max(axis=0)
    assert [*low, *high] == pytest.approx([0, -0.05, 1.9, 1, 0.05, 2.1], abs=1e-9)
    radii = np.hypot(corners[1][:, 0] - 1, corners[1][:, 2] - 2)
    assert {round(float(r), 9) for r in radii} == {0.05, 0.04}
    assert np.ptp(corners[2], axis=0)[1:].max() == pytest.approx(0.06) and np.ptp(corners[2][:, 0]) == pytest.approx(1)
    thick = made.cell_data["thickness"][made.cell_data["part"] == 3]
    assert sorted({round(float(t), 9) for t in thick}) == pytest.approx([0.03, 0.05, 0.07], abs=1e-3)
    assert np.ptp(corners[3][:, 2]) == pytest.approx(thick.max())
    normals = made.point_data["normal"][np.isin(np.arange(made.n_points), np.flatnonzero(made.points[:, 2] < 1))]
    assert np.abs(normals) == pytest.approx(np.tile([0, 0, 1], (len(normals), 1)))


def test_files(record, tmp_path):
    import pyvista

    fx.show.solids(record, tmp_path / "model.vtp")
    assert pyvista.read(tmp_path / "model.vtp").n_cells == fx.show.solids(record, tmp_path / "model.png").n_cells
    assert (tmp_path / "model.png").stat().st_size > 5000
    with pytest.raises(ValueError, match="solids"):
        fx.show.solids(record, tmp_path / "model.stl")
