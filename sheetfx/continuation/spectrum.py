"""Eigenvalues of a factored tangent nearest to zero, against any mass.

The SLEPc solver takes the prefix `sheetfx_spectrum_`.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Protocol

import numpy as np
from mpi4py import MPI
from petsc4py import PETSc
from slepc4py import SLEPc

from ..communicators import lasting
from ..rounding import UNIT, is_real
from .callbacks import interruptible

PREFIX = "sheetfx_spectrum_"


class Factored(Protocol):
    """A tangent with its factor, such as a `linear.DirectSolver`."""

    matrix: PETSc.Mat
    symmetric: bool

    def solve(self, right: PETSc.Vec, solution: PETSc.Vec) -> Any: ...


def nearest_to_zero(solver: Factored, mass: PETSc.Mat, count: int, tolerance: float = 1e-12,
                    without: Sequence[PETSc.Vec] = ()) -> tuple[list[float], list[PETSc.Vec]]:
    """Eigenvalues of K mode = value M mode nearest to zero, in ascending order, and modes with mode M mode = 1.

    Parameters
    ----------
    solver : with the factor of the tangent K, which is not factored again
    mass : symmetric and semidefinite, on the rows of K
    count : number of eigenvalues; fewer where the mass has a lower rank or, of an unsymmetric tangent, some are not
        real
    without : modes that are known and left out; others are orthogonal to them by the mass

    Raises
    ------
    ArithmeticError
        If none converges. Where multipliers hold all that has mass there are only infinite ones, and none is returned.
    """
    eps, infinite = _solved(solver, mass, count, tolerance, without), _infinite(solver, mass)
    if eps is None:
        return [], []
    found, farthest = [], max((abs(eps.getEigenvalue(i)) for i in range(min(count, eps.getConverged()))), default=0.0)
    for i in range(min(count, eps.getConverged())):
        real, imaginary = mass.createVecRight(), mass.createVecRight()
        value = eps.getEigenpair(i, real, imaginary)
        if abs(value) < infinite and is_real(value, farthest):
            found.append((value.real, _normed(imaginary if value.imag < 0 else real, mass)))
    if not found and not any(abs(eps.getEigenvalue(i)) >= infinite for i in range(eps.getConverged())):
        raise ArithmeticError(f"no eigenvalue of the tangent converges; try PETSC_OPTIONS='-{PREFIX}eps_tol 1e-8'")
    found.sort(key=lambda pair: pair[0])
    return [value for value, _ in found], [mode for _, mode in found]


def _infinite(solver: Factored, mass: PETSc.Mat) -> float:
    """Size beyond all eigenvalues: without mass, as of multipliers, they are infinite but for rounding."""
    stiff, heavy = solver.matrix.getDiagonal().array, mass.getDiagonal().array
    there = heavy > 0
    largest = float(np.max(np.abs(stiff[there]) / heavy[there], initial=0.0))
    return lasting(mass.comm.tompi4py()).allreduce(largest, op=MPI.MAX) / UNIT**0.5 or np.inf


def nearest_pairs(solver: Factored, mass: PETSc.Mat, count: int,
                  tolerance: float = 1e-12) -> list[tuple[complex, PETSc.Vec, PETSc.Vec]]:
    """Complex eigenvalues of K mode = value M mode nearest to zero, and the real and imaginary parts of modes.

    Parameters as of `nearest_to_zero`; the modes are not scaled, and conjugate values come in pairs.
    """
    eps = _solved(solver, mass, count, tolerance)
    if eps is None:
        return []
    found = []
    for i in range(eps.getConverged()):
        real, imaginary = mass.createVecRight(), mass.createVecRight()
        found.append((complex(eps.getEigenpair(i, real, imaginary)), real, imaginary))
    found.sort(key=lambda pair: (abs(pair[0]), pair[0].imag))
    if len(found) > count and found[count - 1][0].imag < 0 and found[count][0] == found[count - 1][0].conjugate():
        count += 1
    return found[:count]


def _solved(solver: Factored, mass: PETSc.Mat, count: int, tolerance: float,
            without: Sequence[PETSc.Vec] = ()) -> SLEPc.EPS | None:
    """Solved eigenproblem for the values nearest to zero; None where nothing that has mass can move."""
    eps, kinds = about_zero(solver, mass, PREFIX), SLEPc.EPS.ProblemType
    eps.setProblemType(kinds.GHEP if solver.symmetric else kinds.GNHEP)
    eps.setDimensions(count, min(max(2 * count + 4, 12), mass.getSize()[0]))
    eps.setTolerances(tolerance, 300)
    if without:
        eps.setDeflationSpace(list(without))
    eps.setFromOptions()
    return eps if solve(eps) else None


def solve(eps: SLEPc.EPS) -> bool:
    """Solve an eigenproblem; False where the operator takes all to zero, as where nothing that has mass can move."""
    try:
        with interruptible():
            eps.solve()
    except PETSc.Error as error:
        if "Initial vector is zero" in str(error):
            return False
        raise
    return True


def lowest(solver: Factored, mass: PETSc.Mat, count: int, negative: int,
           without: Sequence[PETSc.Vec] = ()) -> tuple[list[float], list[PETSc.Vec]]:
    """Algebraically lowest eigenvalues of K mode = value M mode, in ascending order, and modes with mode M mode = 1.

    Parameters
    ----------
    solver, mass, count, without : as of `nearest_to_zero`
    negative : number of negative eigenvalues, from the inertia of K

    Raises
    ------
    ArithmeticError
        If not all negative ones are found.
    """
    asked, size = count + negative, mass.getSize()[0]
    while True:
        values, modes = nearest_to_zero(solver, mass, min(asked, size), without=without)
        if sum(value < 0 for value in values) == negative:
            return values[:count], modes[:count]
        if asked >= size or asked > 16 * (count + negative):
            raise ArithmeticError(
                f"the inertia shows {negative} negative eigenvalues, the eigensolver finds "
                f"{sum(value < 0 for value in values)}; try PETSC_OPTIONS='-{PREFIX}eps_tol 1e-8'")
        asked *= 2


def _normed(mode: PETSc.Vec, mass: PETSc.Mat) -> PETSc.Vec:
    weighted = mode.duplicate()
    mass.mult(mode, weighted)
    mode.scale(1 / mode.dot(weighted) ** 0.5)
    return mode


def about_zero(solver: Factored, right: PETSc.Mat, prefix: str) -> SLEPc.EPS:
    """Eigensolver of K mode = value (right) mode for values about zero, with the factor of K that is there."""
    eps = SLEPc.EPS().create(right.comm)
    eps.setOptionsPrefix(prefix)
    eps.setOperators(solver.matrix, right)
    eps.setTarget(0.0)
    eps.setWhichEigenpairs(SLEPc.EPS.Which.TARGET_MAGNITUDE)
    transformation = eps.getST()
    transformation.setType(SLEPc.ST.Type.SINVERT)
    solve_by(solver, transformation.getKSP())
    return eps


def solve_by(solver: Factored, ksp: PETSc.KSP) -> None:
    """Have a KSP solve with the factor that a direct solver has."""
    ksp.setType(PETSc.KSP.Type.PREONLY)
    ksp.getPC().setType(PETSc.PC.Type.PYTHON)
    ksp.getPC().setPythonContext(_Factored(solver))


class _Factored:
    """A preconditioner that is the factor of a direct solver."""

    def __init__(self, solver: Factored):
        self._solver = solver

    def apply(self, pc, right, solution):
        self._solver.solve(right, solution)

    def applyTranspose(self, pc, right, solution):
        self._solver.solve_transposed(right, solution)


def diagonal(weights: PETSc.Vec) -> PETSc.Mat:
    """Matrix with the given diagonal."""
    matrix = PETSc.Mat().createAIJ(((weights.getLocalSize(), None),) * 2, nnz=1, comm=weights.comm)
    matrix.setDiagonal(weights)
    matrix.assemble()
    return matrix
