"""Surfaces that others slide along: smooth over the borders of their cells, but not over folds."""

from __future__ import annotations

import basix
import numpy as np
import pytest
from dolfinx import fem

import sheetfx as fx
from sheetfx import meshes
from sheetfx.mesh.patch import Patch
from sheetfx.mesh.projection import Cells
from sheetfx.mesh.smoothing import SmoothSurface


def skewed(x):
    return np.column_stack((x[:, 0] + 0.15 * np.sin(3 * x[:, 0] * x[:, 1]),
                            x[:, 1] + 0.1 * x[:, 0] * x[:, 1] + 0.1 * x[:, 0] ** 2, x[:, 2]))


def cone(x):
    return np.column_stack((np.sin(x[:, 0]), x[:, 1] * (1 + 0.3 * x[:, 0]), np.cos(x[:, 0])))


def folded(angle):
    def place(x):
        off = np.maximum(x[:, 0] - 0.5, 0.0)
        return np.column_stack((x[:, 0] - off * (1 - np.cos(angle)), x[:, 1], off * np.sin(angle)))
    return place


class Wavy:
    """A surface with values of three functions at its nodes, seen with and without smoothing."""

    def __init__(self, cells, degree=2, triangles=False, place=None, order=1, values=None):
        mesh = fx.read(lambda: meshes.rectangle(cells, (1.0, 1.0), triangles), 3, order, place)
        space = fem.functionspace(mesh.domain, ("Lagrange", degree))
        self.patch = Patch(Cells(mesh, mesh.group(None)))
        self.surface = SmoothSurface(self.patch)
        self.shapes = self.surface.shapes(space.ufl_element().basix_element,
                                          space.dofmap.list[self.patch.cells.cells])
        self.places = space.tabulate_dof_coordinates()
        x, y, z = self.places.T
        wave = 0.1 * np.sin(7 * x + 2 * y) * np.cos(5 * y - x + z)
        self.values = self.places + wave[:, None] * [0.2, 0.0, 1.0] if values is None else values(self.places)

    def at(self, cell, reference, smooth=True, order=1):
        """Values and derivatives, shape (rows, 3)."""
        which = np.array([cell])
        table = self.shapes.table(which, reference, smooth * self.surface.blends(reference, order), order)
        return np.einsum("onk,nkd->od", table, self.values[self.shapes.nodes[which]])

    def borders(self):
        """Number of a cell and reference point in it on both sides of borders, and whether they are smooth there."""
        for cell, border in zip(*np.nonzero(self.patch.beyond >= 0), strict=True):
            for s in (1e-3, 0.05, 0.37, 0.6, 0.9):
                here = ((1 - s) * self.patch.ends[border, 0] + s * self.patch.ends[border, 1])[None]
                other, there, _ = self.patch.pass_on(np.array([cell]), np.array([border]), here)
                yield (cell, here), (other[0], there), self.surface.smooth[cell, border]

    def bend(self, one, two, smooth=True):
        """Sine of the angle between the normals in two cells."""
        normals = [np.cross(*self.at(*side, smooth)[1:3]) for side in (one, two)]
        return np.linalg.norm(np.cross(*(n / np.linalg.norm(n) for n in normals)))


@pytest.mark.parametrize("how, most", [
    ({"cells": (4, 3)}, 1e-7), ({"cells": (3, 2), "degree": 3}, 1e-7), ({"cells": (3, 2), "triangles": True}, 1e-7),
    ({"cells": (6, 3), "place": cone}, 1e-7), ({"cells": (6, 3), "place": cone, "triangles": True}, 1e-7),
    ({"cells": (4, 3), "place": skewed}, 2e-4), ({"cells": (3, 2), "place": skewed, "order": 2}, 2e-3)])
@pytest.mark.slow(quick=1)
def test_normal_is_continuous(how, most):
    """The same on both sides of borders, where cells are no parallelograms up to interpolation along these."""
    surface = Wavy(**how)
    before = 0.0
    for one, two, smooth in surface.borders():
        assert smooth
        assert surface.at(*one)[0] == pytest.approx(surface.at(*two)[0], abs=1e-13)
        assert surface.bend(one, two) < most
        before = max(before, surface.bend(one, two, smooth=False))
    assert before > 0.04


@pytest.mark.parametrize("triangles", [False, True])
def test_what_has_no_jump_stays(triangles):
    """Linear functions on any plane mesh; derivatives are those of the rows, up to the third."""
    def linear(x):
        return x @ [[1.0, 0.3, -0.2], [0.1, 1.2, 0.4], [0.0, 0.0, 1.0]]

    surface, step = Wavy((3, 2), 2, triangles, skewed, values=linear), 1e-4
    reference = np.array([[0.31, 0.23]])
    for cell in range(len(surface.patch.beyond)):
        assert surface.at(cell, reference) == pytest.approx(surface.at(cell, reference, smooth=False), abs=1e-12)
    bent = Wavy((3, 2), 2, triangles, skewed)
    rows = [bent.at(2, reference + step * np.array(by), order=3) for by in ((1, 0), (-1, 0), (0, 1), (0, -1))]
    here = bent.at(2, reference, order=3)
    for start, along in ((0, [(0, 1), (2, 2)]), (1, [(0, 3), (2, 4)]), (4, [(0, 7), (2, 8)]), (5, [(0, 8), (2, 9)])):
        for first, row in along:
            difference = (rows[first][start] - rows[first + 1][start]) / (2 * step)
            assert difference == pytest.approx(here[row], abs=2e-5 * np.abs(here).max())


@pytest.mark.parametrize("angle, stays", [(0.1, False), (0.4, True)])
def test_folds_stay(angle, stays):
    surface = Wavy((4, 2), place=folded(angle), values=lambda x: x)
    for one, two, smooth in surface.borders():
        at_fold = abs(surface.at(*one)[0][0] - 0.5) < 1e-9 and surface.bend(one, two, smooth=False) > 0.05
        assert smooth != (at_fold and stays)
        assert surface.bend(one, two) == pytest.approx(np.sin(angle) if at_fold and stays else 0.0, abs=1e-8)


def test_values_at_vertices_and_sums_of_weights_stay():
    surface = Wavy((3, 2))
    corners = basix.geometry(basix.CellType.quadrilateral)
    for cell, corner in np.ndindex(6, 4):
        reference = corners[corner][None]
        assert surface.at(cell, reference)[0] == pytest.approx(surface.at(cell, reference, smooth=False)[0], abs=1e-13)
    which, reference = np.arange(6), np.random.default_rng(0).uniform(0, 1, (6, 2))
    table = surface.shapes.table(which, reference, surface.surface.blends(reference, 1), 1)
    assert table.sum(axis=2) == pytest.approx(np.repeat([[1.0], [0.0], [0.0]], 6, axis=1), abs=1e-12)
