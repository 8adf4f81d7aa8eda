"""Meshes and tags of DOLFINx as meshes with names."""

from __future__ import annotations

import numpy as np
import pytest
from dolfinx.mesh import CellType, create_unit_square, meshtags
from helpers import on_two_processes
from mpi4py import MPI

import sheetfx as fx
from sheetfx import meshes
from sheetfx.scenes import lee_frame

COPY = """
import numpy as np
import sheetfx as fx
from dolfinx.mesh import meshtags
from sheetfx import meshes

def tags_of(mesh, dimension, groups):
    entities = np.concatenate([np.empty(0, dtype=np.int32), *groups.values()]).astype(np.int32)
    values = np.repeat(np.arange(1, 1 + len(groups)), [len(own) for own in groups.values()]).astype(np.int32)
    entities, first = np.unique(entities, return_index=True)
    mesh.domain.topology.create_connectivity(dimension, mesh.domain.topology.dim)
    return meshtags(mesh.domain, dimension, entities, values[first])

def copied(mesh, edges=True):
    top = mesh.domain.topology.dim
    tags = {top: tags_of(mesh, top, mesh.cells), 0: tags_of(mesh, 0, mesh.points)}
    names = {(top, n): name for n, name in enumerate(mesh.cells, 1)} | {
        (0, n): name for n, name in enumerate(mesh.points, 1)}
    facets = None
    if top == 2:
        facets = tags_of(mesh, 1, mesh.edges)
        names |= {(1, n): name for n, name in enumerate(mesh.edges, 1)}
    return fx.NamedMesh.from_dolfinx(mesh.domain, tags[top], facets, names, tags[0])

def arched(mesh, form):
    shell = fx.Shell(mesh, fx.Plate(0.01), fx.Elastic(1e6, 0.3), form=form)
    scene = fx.Scene([shell], [fx.clamp(mesh, "west"), fx.pin(mesh, "east"), fx.Support(mesh, "north-west", "y")],
                     [fx.EdgeForce(mesh, "south", (0.0, 0.0, -0.1))], fx.Monitor(mesh, "south-east", "ry"))
    return [state.deflection for state in fx.trace(fx.Case(scene, fx.LoadControl(0.5))).states]

def both(form):
    order = int(form[-1])
    mesh = fx.read(lambda: meshes.rectangle((4, 3), triangles="-t" in form), 3, order,
                   lambda x: np.column_stack((x[:, :2], 0.1 * np.sin(np.pi * x[:, 0]))))
    return [*arched(mesh, form), *arched(copied(mesh), form)]
"""
exec(COPY)  # two processes run it as well


@pytest.mark.parametrize("form", ["naghdi-q2", "naghdi-t2", "naghdi-q3"])
@pytest.mark.slow(quick=1)
def test_shells_go_the_same_way(form):
    found = both(form)  # noqa: F821
    assert found[3:] == pytest.approx(found[:3], rel=1e-9) and abs(found[2]) > 1e-3


def test_beams_go_the_same_way():
    """Vertices are points of curves by either tags."""
    case = lee_frame.case(elements=10)
    (mesh,) = case.scene.meshes
    again = fx.trace(fx.Case(fx.remade(case.scene, {mesh: copied(mesh)}), case.control, case.until))  # noqa: F821
    wanted = fx.trace(case)
    assert [p.load for p in again.critical_points] == pytest.approx([p.load for p in wanted.critical_points], rel=1e-8)


def test_two_processes_find_the_same():
    (line,) = on_two_processes(COPY + "\nfound = both('naghdi-t2')\nif fx.NamedMesh and __import__('mpi4py.MPI').MPI."
                               "COMM_WORLD.rank == 0:\n    print(*found)\n")
    found = list(map(float, line.split()))
    assert found[3:] == pytest.approx(found[:3], rel=1e-8)


def rectangle():
    return fx.read(lambda: meshes.rectangle((2, 2)), 3).domain


def tagged(domain, dimension, *values):
    domain.topology.create_entities(dimension)
    return meshtags(domain, dimension, np.arange(len(values), dtype=np.int32), np.array(values, dtype=np.int32))


def test_what_has_no_name_is_called_by_its_number():
    domain = rectangle()
    mesh = fx.NamedMesh.from_dolfinx(domain)
    assert list(mesh.cells) == ["cells"] and mesh.measure == pytest.approx(1.0)
    mesh = fx.NamedMesh.from_dolfinx(domain, tagged(domain, 2, 1, 1, 7, 7), names={7: "right"})
    assert {name: mesh.measure_of(name) for name in mesh.cells} == pytest.approx({"surface 1": 0.5, "right": 0.5})
    mesh = fx.NamedMesh.from_dolfinx(domain, tagged(domain, 2, 1, 1, 1))
    assert mesh.measure == pytest.approx(0.75), "cells without a tag are left out"


def test_a_plane_mesh_comes_to_lie_in_space():
    domain = create_unit_square(MPI.COMM_WORLD, 3, 2, CellType.quadrilateral)
    mesh = fx.NamedMesh.from_dolfinx(domain)
    assert mesh.dimension == 3 and mesh.measure == pytest.approx(1.0)
    assert np.allclose(np.sort(domain.geometry.x, axis=0), np.sort(mesh.domain.geometry.x, axis=0))


def test_wrong_tags_are_refused():
    domain = rectangle()
    with pytest.raises(ValueError, match="facet_tags are of dimension 2; give tags of dimension 1"):
        fx.NamedMesh.from_dolfinx(domain, None, tagged(domain, 2, 1))
    line = fx.read(lambda: meshes.frame({"a": (0, 0), "b": (1, 0)}, {"l": ("a", "b", 1)}), 2).domain
    with pytest.raises(ValueError, match="both of points of curves; give one of them"):
        fx.NamedMesh.from_dolfinx(line, None, tagged(line, 0, 1), None, tagged(line, 0, 1))
    with pytest.raises(ValueError, match="'skin' is to be the name of tag 5, which no tags have; there are surface 1"):
        fx.NamedMesh.from_dolfinx(domain, tagged(domain, 2, 1, 1, 1, 1), names={5: "skin"})
