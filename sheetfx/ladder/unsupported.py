"""Rows that hold a structure which can move freely, one for each motion, so that it is not strained."""

from __future__ import annotations

import numpy as np
from mpi4py import MPI
from petsc4py import PETSc
from scipy.linalg import eigh

from ..discrete.free_body import rigid_motions

FREE = 1e-9  # stiffness of a motion over that of its unknowns one by one, that is rounding
HELD = 1e-12  # sum of squares of what a motion moves at supports over that of all, that is rounding


def rows_that_hold(discretisation, tangent: PETSc.Mat) -> np.ndarray:
    """Rows of the unstressed tangent whose unknowns, held, leave no rigid motion of the whole; this process's ones.

    Supports hold the displacements of their nodes. Springs and obstacles count by their stiffness.
    """
    system, comm = discretisation.system, discretisation.system.comm
    motions = [motion.array.copy() for motion in rigid_motions(discretisation).values()]
    moved = np.array([motion[system.fixed_rows] for motion in motions])
    whole = np.array(motions)
    sizes = np.sqrt(comm.allreduce((whole**2).sum(axis=1)))
    values, vectors = np.linalg.eigh(comm.allreduce(moved @ moved.T) / np.outer(sizes, sizes))
    free = (vectors[:, values <= HELD].T / sizes) @ whole
    free[:, system.fixed_rows] = 0
    free = _without_stiffness(free, tangent, comm)
    first, rows = tangent.getOwnershipRange()[0], []
    for n in range(len(free)):
        own = np.abs(free[n]).argmax() if free.shape[1] else 0
        size = abs(free[n, own]) if free.shape[1] else -1.0
        _, rank = comm.allreduce((size, comm.rank), op=MPI.MAXLOC)
        if rank == comm.rank:
            rows.append(first + own)
        column = comm.bcast(free[:, own] if rank == comm.rank else None, root=rank)
        free = free - np.outer(column / column[n], free[n]) * (np.arange(len(free)) > n)[:, None]
    return np.array(rows, dtype=PETSc.IntType)


def _without_stiffness(motions: np.ndarray, tangent: PETSc.Mat, comm) -> np.ndarray:
    """Motions among those given that the tangent does not resist."""
    if not len(motions):
        return motions
    forces, vector = [], tangent.createVecRight()
    for motion in motions:
        vector.array[:] = motion
        forces.append((tangent * vector).array.copy())
    diagonal = np.abs(tangent.getDiagonal().array)
    resisted, alone = comm.allreduce(motions @ np.array(forces).T), comm.allreduce((motions * diagonal) @ motions.T)
    values, vectors = eigh((resisted + resisted.T) / 2, alone)
    return vectors[:, np.abs(values) <= FREE].T @ motions
