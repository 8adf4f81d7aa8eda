"""Modes as displacements: of a mesh's parts, and scaled to a largest displacement of 1."""

from __future__ import annotations

import numpy as np
from dolfinx import fem
from mpi4py import MPI
from petsc4py import PETSc

from ..continuation.problem import Problem
from ..discrete.discretisation import Discretisation
from ..mesh.reader import NamedMesh


def mode_displacement(path, mesh: NamedMesh, mode) -> fem.Function:
    """Displacement of a mesh's parts in a mode.

    Parameters
    ----------
    path : Path or Tracer that the mode belongs to
    mode : array of increments on this process, or a BucklingLoad, Vibration or Branch with one
    """
    return mode_on(path.discretisation, mesh, getattr(mode, "mode", mode))


def mode_on(discretisation: Discretisation, mesh: NamedMesh, mode: np.ndarray) -> fem.Function:
    """Displacement of a mesh's parts in a mode of a discretisation, given by increments."""
    displacement = fem.Function(discretisation.kinematics(mesh).u.function_space, name="displacement")
    displacement.x.array[:] = _displacement(discretisation, mesh, discretisation.system.create_vector(mode))
    return displacement


def scaled(discretisation: Problem, mode: PETSc.Vec) -> np.ndarray:
    """The mode with a largest displacement of 1, its largest component being positive."""
    mode = discretisation.system.create_vector(mode.array)
    comm, tables = discretisation.system.comm, discretisation.nodal_changes(mode)
    highest, lowest = (comm.allreduce(max(float((sign * t).max(initial=0.0)) for t in tables), op=MPI.MAX)
                       for sign in (1.0, -1.0))
    sign = 1.0 if highest >= lowest else -1.0
    return sign * mode.array / (largest_displacement(discretisation, mode) or 1.0)


def largest_displacement(discretisation: Problem, mode: PETSc.Vec) -> float:
    """Length of the largest displacement of any node, on all processes."""
    largest = max(float(np.linalg.norm(t, axis=1).max(initial=0.0)) for t in discretisation.nodal_changes(mode))
    return discretisation.system.comm.allreduce(largest, op=MPI.MAX)


def _displacement(discretisation: Discretisation, mesh: NamedMesh, step: PETSc.Vec) -> np.ndarray:
    """Change of a mesh's displacement by a step."""
    values = [f.value for f in discretisation.unknowns.fields]
    return discretisation.system.changes(step)[values.index(discretisation.kinematics(mesh).u)]
