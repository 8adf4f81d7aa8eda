"""Modes as displacements: of a model's parts, and scaled to a largest displacement of 1."""

from __future__ import annotations

import numpy as np
from dolfinx import fem
from mpi4py import MPI
from petsc4py import PETSc

from ..discretise import Discretisation
from ..mesh.reader import Model


def mode_displacement(path, model: Model, mode) -> fem.Function:
    """Displacement of a model's parts in a mode.

    Parameters
    ----------
    path : Path or Tracer that the mode belongs to
    mode : BucklingLoad or Vibration
    """
    vector = path.discretisation.system.create_vector()
    vector.array[:] = mode.mode
    u = path.discretisation.kinematics(model).u
    displacement = fem.Function(u.function_space, name="displacement")
    displacement.x.array[:] = _displacement(path.discretisation, model, vector)
    return displacement


def scaled(discretisation: Discretisation, mode: PETSc.Vec) -> np.ndarray:
    """The mode with a largest displacement of 1, its largest component being positive."""
    vector, sizes, signs = discretisation.system.create_vector(), [], []
    vector.array[:] = mode.array
    for model in dict.fromkeys(part.model for part in discretisation.scene.parts):
        table = _displacement(discretisation, model, vector).reshape(-1, model.dimension)
        sizes.append(np.linalg.norm(table, axis=1).max(initial=0.0))
        signs += [table.max(initial=0.0), table.min(initial=0.0)]
    comm = discretisation.system.comm
    size, *signs = (comm.allreduce(float(v), op=MPI.MAX) for v in (max(sizes), max(signs), -min(signs)))
    sign = 1.0 if signs[0] >= signs[1] else -1.0
    return sign * mode.array / (size or 1.0)


def _displacement(discretisation: Discretisation, model: Model, step: PETSc.Vec) -> np.ndarray:
    """Change of a model's displacement by a step."""
    values = [f.value for f in discretisation.unknowns.fields]
    return discretisation.system.changes(step)[values.index(discretisation.kinematics(model).u)]
