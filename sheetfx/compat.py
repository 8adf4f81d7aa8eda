"""Differences between DOLFINx versions, and nothing else."""

from __future__ import annotations

import ctypes

import dolfinx.cpp.fem.petsc as cpp_petsc
import dolfinx.fem.petsc as petsc_fem
import dolfinx.mesh
import numpy as np
import ufl
from dolfinx.graph import adjacencylist
from petsc4py import PETSc

try:
    from dolfinx.io import gmsh as _gmshio
except ImportError:
    from dolfinx.io import gmshio as _gmshio

JIT = {"timeout": 600, "cffi_extra_compile_args": ["-O2"]}


def adjacency_list(rows):
    """DOLFINx's list of rows of numbers, as its partitioners give it."""
    rows = adjacencylist(rows)
    return getattr(rows, "_cpp_object", rows)


def model_to_mesh(model, comm, dimension, partitioner):
    """Mesh, cell tags and point (or facet) tags of the current gmsh model of process 0."""
    result = _gmshio.model_to_mesh(model, comm, 0, gdim=dimension, partitioner=partitioner)
    if isinstance(result, tuple):
        return result[:3]
    return result.mesh, result.cell_tags, result.facet_tags


def geometry_degree(mesh):
    """Degree of the geometry of a mesh's cells."""
    return mesh.geometry.cmap.degree


def topological_dimension(domain):
    """Of a UFL mesh: a method in DOLFINx 0.9, an attribute later."""
    dimension = domain.topological_dimension
    return dimension() if callable(dimension) else dimension


def interpolation_points(space):
    """Points of a cell at which functions of a space are interpolated: a method in DOLFINx 0.9, an attribute later."""
    points = space.element.interpolation_points
    return points() if callable(points) else points


def moved_mesh(mesh, x):
    """A mesh of the same topology with its nodes at other places, shape (nodes of this process, dimension)."""
    old = mesh.geometry
    geometry = type(old._cpp_object)(old.index_map(), old.dofmap, old.cmap._cpp_object, x, old.input_global_indices)
    copy = type(mesh._cpp_object)(mesh.comm, mesh.topology._cpp_object, geometry)
    return dolfinx.mesh.Mesh(copy, ufl.Mesh(mesh.ufl_domain().ufl_coordinate_element()))


def create_vector(maps):
    """Ghosted vector for blocks with the given index maps and block sizes."""
    return cpp_petsc.create_vector_block(maps)


_petsc = ctypes.CDLL(PETSc.__file__)


def create_coo_matrix(comm, size, rows, columns, matrix=None):
    """Sparse matrix that sums its entries by coordinates (petsc4py 3.22 lacks these calls of PETSc).

    Parameters
    ----------
    size : number of rows of this process
    rows, columns : global places of the entries; an entry at a negative place is ignored
    matrix : an earlier one that is given these entries instead of its own; None: a new one
    """
    if matrix is None:
        matrix = PETSc.Mat().create(comm)
        matrix.setSizes(((size, None), (size, None)))
        matrix.setType(PETSc.Mat.Type.AIJ)
    rows, columns = (np.array(x, dtype=PETSc.IntType) for x in (rows, columns))
    _check(_petsc.MatSetPreallocationCOO(ctypes.c_void_p(matrix.handle), ctypes.c_ssize_t(len(rows)),
                                         rows.ctypes.data_as(ctypes.c_void_p), columns.ctypes.data_as(ctypes.c_void_p)))
    return matrix


def set_coo_values(matrix, values):
    """Give the entries their values, in the order of `create_coo_matrix`."""
    values = np.ascontiguousarray(values, dtype=PETSc.ScalarType)
    _check(_petsc.MatSetValuesCOO(ctypes.c_void_p(matrix.handle), values.ctypes.data_as(ctypes.c_void_p),
                                  ctypes.c_int(int(PETSc.InsertMode.INSERT_VALUES))))


def _check(code):
    if code:
        raise PETSc.Error(code)


def create_matrix(forms):
    """Sparse matrix of a square array of forms."""
    if hasattr(petsc_fem, "create_matrix_block"):
        return petsc_fem.create_matrix_block(forms)
    return petsc_fem.create_matrix(forms, kind="mpi")


def assemble_matrix(matrix, forms):
    """Assemble a square array of forms."""
    matrix.zeroEntries()
    if hasattr(petsc_fem, "assemble_matrix_block"):
        petsc_fem.assemble_matrix_block(matrix, forms)
    else:
        petsc_fem.assemble_matrix(matrix, forms)
    matrix.assemble()
    return matrix
