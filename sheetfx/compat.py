"""Differences between DOLFINx versions, and nothing else."""

from __future__ import annotations

import dolfinx.fem.petsc as petsc_fem

try:
    from dolfinx.io import gmsh as _gmshio
except ImportError:
    from dolfinx.io import gmshio as _gmshio

JIT = {"timeout": 600, "cffi_extra_compile_args": ["-O2"]}


def model_to_mesh(model, comm, dimension):
    """Mesh, cell tags and point (or facet) tags of the current gmsh model of process 0."""
    result = _gmshio.model_to_mesh(model, comm, 0, gdim=dimension)
    if isinstance(result, tuple):
        return result[:3]
    return result.mesh, result.cell_tags, result.facet_tags


def create_matrix(forms):
    """Sparse matrix of a square array of forms."""
    if hasattr(petsc_fem, "create_matrix_block"):
        return petsc_fem.create_matrix_block(forms)
    return petsc_fem.create_matrix(forms, kind="mpi")


def assemble_matrix(matrix, forms, conditions):
    """Assemble a square array of forms; ones on the diagonal of fixed unknowns."""
    matrix.zeroEntries()
    if hasattr(petsc_fem, "assemble_matrix_block"):
        petsc_fem.assemble_matrix_block(matrix, forms, bcs=conditions)
    else:
        petsc_fem.assemble_matrix(matrix, forms, bcs=conditions)
    matrix.assemble()
    return matrix
