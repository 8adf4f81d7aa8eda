"""Differences between DOLFINx versions and what each asks of the system, and nothing else."""

from __future__ import annotations

import ctypes
import gc
import logging
import os
import shutil
import sysconfig
from inspect import signature
from pathlib import Path

import dolfinx.cpp.fem.petsc as cpp_petsc
import dolfinx.fem.petsc as petsc_fem
import dolfinx.mesh
import numpy as np
import ufl
from dolfinx.common import IndexMap
from dolfinx.graph import adjacencylist
from mpi4py import MPI
from petsc4py import PETSc

try:
    from dolfinx.io import gmsh as _gmshio
except ImportError:
    from dolfinx.io import gmshio as _gmshio


def require_compiler():
    """Refuse a system on which no form can be compiled, which DOLFINx would say by a list of failed commands.

    Raises
    ------
    FileNotFoundError
        Where the compiler that Python was built with (or CC names) or Python's headers are missing.
    """
    compiler = (os.environ.get("CC") or sysconfig.get_config_var("CC") or "cc").split()[0]
    if not shutil.which(compiler):
        raise FileNotFoundError(f"the C compiler {compiler!r} is missing, which compiles weak forms: install one "
                                "(apt-get install gcc), or name it by the variable CC")
    header = Path(sysconfig.get_path("include")) / "Python.h"
    if not header.exists():
        raise FileNotFoundError(f"{header} is missing, without which no weak form compiles: install the headers of "
                                "this Python (apt-get install python3-dev)")


require_compiler()


def show_warnings():
    """Have Python show warnings again where FFCx, as it is imported, sends them to a logger that nobody reads."""
    handlers = logging.getLogger("py.warnings").handlers + logging.getLogger().handlers
    if all(isinstance(handler, logging.NullHandler) for handler in handlers):
        logging.captureWarnings(False)


show_warnings()

# DOLFINx and all that it imports stay loaded: Python need not look through them for garbage again and again, nor at its
# end, which is a fifth of the time to a first step.
gc.freeze()

# Reason to stop at a residual that is not a number: DIVERGED_FNORM_NAN in PETSc 3.22, DIVERGED_FUNCTION_NANORINF later.
_reasons = vars(PETSc.SNES.ConvergedReason)
NOT_A_NUMBER = _reasons.get("DIVERGED_FNORM_NAN", _reasons.get("DIVERGED_FUNCTION_NANORINF"))


def adjacency_list(rows):
    """DOLFINx's list of rows of numbers, as its partitioners give it."""
    rows = adjacencylist(rows)
    return getattr(rows, "_cpp_object", rows)


# Later versions take two for the largest number of cells that meet at a facet; at a junction there are more.
_JUNCTIONS = {}
if "max_facet_to_cell_links" in signature(dolfinx.mesh.create_mesh).parameters:
    _JUNCTIONS["max_facet_to_cell_links"] = None


def default_partition(comm, parts, cell_types, cells):
    """DOLFINx's own partition of cells, with no ghosts."""
    partitioner = dolfinx.mesh.create_cell_partitioner(dolfinx.mesh.GhostMode.none, *_JUNCTIONS.values())
    return partitioner(comm, parts, cell_types, cells)


def gmsh_mesh(comm, kind, cells, x, partitioner):
    """Mesh of cells of gmsh, by its number of their kind and with its order of their nodes.

    Parameters
    ----------
    cells, x : nodes of each cell, and places of nodes; process 0's are distributed
    partitioner : None: DOLFINx's own
    """
    domain, cells = _gmshio.ufl_mesh(kind, x.shape[1], x.dtype), gmsh_cells(kind, cells)[1]
    return dolfinx.mesh.create_mesh(comm, cells=cells, x=x, e=domain, partitioner=partitioner, **_JUNCTIONS)


def serial_mesh(mesh, cells, x):
    """A mesh of cells like another one's, with their order of nodes, on this process alone."""
    return dolfinx.mesh.create_mesh(MPI.COMM_SELF, cells=cells, x=np.ascontiguousarray(x),
                                    e=ufl.Mesh(mesh.ufl_domain().ufl_coordinate_element()), **_JUNCTIONS)


def gmsh_cells(kind, cells):
    """Basix element of the geometry of cells of gmsh, by its number of their kind, and their nodes in its order."""
    domain = _gmshio.ufl_mesh(kind, 3, np.float64)
    order = _gmshio.cell_perm_array(dolfinx.mesh.to_type(str(domain.ufl_cell())), cells.shape[1])
    return domain.ufl_coordinate_element().basix_element, cells[:, order]


def geometry_degree(mesh):
    """Degree of the geometry of a mesh's cells."""
    return _coordinate_element(mesh.geometry).degree


def _coordinate_element(geometry):
    """Of a mesh with cells of one type, for which later versions have a list."""
    return geometry.cmaps[0] if hasattr(geometry, "cmaps") else geometry.cmap


def geometry_nodes(mesh):
    """Numbers of the nodes of each cell of a mesh, of which later versions have a list by types of cells."""
    geometry = mesh.geometry
    return geometry.dofmaps[0] if hasattr(geometry, "dofmaps") else geometry.dofmap


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
    geometry = type(old._cpp_object)(old.index_map(), geometry_nodes(mesh), _coordinate_element(old)._cpp_object, x,
                                     old.input_global_indices)
    copy = type(mesh._cpp_object)(mesh.comm, mesh.topology._cpp_object, geometry)
    return dolfinx.mesh.Mesh(copy, ufl.Mesh(mesh.ufl_domain().ufl_coordinate_element()))


def index_map(comm, size, ghosts, owners):
    """Distribution of so many entries of this process, and ghosts: later versions ask for a tag of their messages."""
    try:
        return IndexMap(comm, size, ghosts, owners)
    except TypeError:
        return IndexMap(comm, size, ghosts, owners, 0)


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
    matrix.setAttr("patterns", (matrix.getAttr("patterns") or 0) + 1)  # on several processes PETSc's own may stay
    return matrix


def nonzero_state(matrix):
    """Numbers that change whenever entries of a matrix get other places (petsc4py does not tell)."""
    state = ctypes.c_int64()
    _check(_petsc.MatGetNonzeroState(ctypes.c_void_p(matrix.handle), ctypes.byref(state)))
    return matrix.getAttr("patterns"), state.value


def set_coo_values(matrix, values):
    """Give the entries their values, in the order of `create_coo_matrix`."""
    values = np.ascontiguousarray(values, dtype=PETSc.ScalarType)
    _check(_petsc.MatSetValuesCOO(ctypes.c_void_p(matrix.handle), values.ctypes.data_as(ctypes.c_void_p),
                                  ctypes.c_int(int(PETSc.InsertMode.INSERT_VALUES))))


def _check(code):
    if code:
        raise PETSc.Error(code)


def create_matrix(forms):
    """Sparse matrix of a square array of forms: a function of its own in DOLFINx 0.9."""
    if hasattr(petsc_fem, "create_matrix_block"):
        return petsc_fem.create_matrix_block(forms)
    return petsc_fem.create_matrix(forms)


def assemble_matrix(matrix, forms):
    """Assemble a square array of forms: a function of its own in DOLFINx 0.9."""
    matrix.zeroEntries()
    if hasattr(petsc_fem, "assemble_matrix_block"):
        petsc_fem.assemble_matrix_block(matrix, forms)
    else:
        petsc_fem.assemble_matrix(matrix, forms)
    matrix.assemble()
    return matrix
