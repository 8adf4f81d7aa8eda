"""Curves that others slide along: smooth over nodes of their cells, but not over corners."""

from __future__ import annotations

import basix
import numpy as np
import pytest

import sheetfx as fx
from sheetfx.mesh.projection import Cells
from sheetfx.mesh.track import SmoothRows, Track

QUADRATIC = basix.create_element(basix.ElementFamily.P, basix.CellType.interval, 2)


def bent(angle):
    """Two straight lines of three cells each, which meet under an angle."""
    nodes = {"a": (0.0, 0.0), "b": (1.0, 0.0), "c": (1.0 + np.cos(angle), np.sin(angle))}
    mesh = fx.read(lambda: fx.meshes.frame(nodes, {"ab": ("a", "b", 3), "cb": ("c", "b", 3)}), 2)
    return Track(Cells(mesh, mesh.group(None)))


def slopes(track, values, end):
    """Slopes by arc length of interpolated random values at ends of cells, in the sense of the cells."""
    rows = SmoothRows(track, QUADRATIC)
    every, reference = np.arange(len(values)), np.full((len(values), 1), float(end))
    table = rows.table(every, reference)
    pace = np.linalg.norm(track.slopes(every, reference), axis=1)
    gathered = rows.gathered(values)
    return np.einsum("nk,nk->n", table[0], gathered), np.einsum("nk,nk->n", table[1], gathered) / pace


@pytest.mark.parametrize("angle, jumps", [(0.1, 0), (0.5, 1)])
def test_slope_is_continuous_but_over_corners(angle, jumps):
    track = bent(angle)
    random, nodes = np.random.default_rng(1), {}
    cells = len(track.following)
    values = np.empty((cells, 3))
    for cell in range(cells):
        for k in (0, 1):
            place = tuple(np.round(track.cells.nodes[cell, k], 9))
            values[cell, k] = nodes.setdefault(place, random.normal())
        values[cell, 2] = random.normal()
    found = [slopes(track, values, end) for end in (0, 1)]
    jumped = 0
    for cell in range(cells):
        for end in (0, 1):
            other, enters = track.following[cell, end], track.enters[cell, end]
            assert found[end][0][cell] == pytest.approx(values[cell, end], abs=1e-14)
            if other >= 0:
                sense = -1 if enters == end else 1
                jumped += abs(found[end][1][cell] - sense * found[enters][1][other]) > 1e-12
    assert jumped == 2 * jumps


def test_derivatives_are_those_of_the_rows():
    track = bent(0.1)
    rows, every, step = SmoothRows(track, QUADRATIC), np.arange(len(track.following)), 1e-4
    at = [rows.table(every, np.full((len(every), 1), 0.3 + d)) for d in (-step, 0.0, step)]
    for order in (0, 1):
        assert np.abs((at[2][order] - at[0][order]) / (2 * step) - at[1][order + 1]).max() < 1e-6
