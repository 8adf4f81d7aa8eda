"""Direct solution with one factor for many right-hand sides, and the factor's inertia."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from mpi4py import MPI
from petsc4py import PETSc
from scipy.sparse import csc_matrix, issparse

from .. import compat
from ..communicators import lasting

TOGETHER = 128  # right-hand sides in one block of MUMPS; more gain little
SPARE, MOST_SPARE = 20, 2000  # percent of working space for pivots that are put off, beyond what analysis estimates


class SingularTangent(ArithmeticError):
    """The factorisation met a zero pivot: the structure can move freely or is at a critical point."""


class DirectSolver:
    """A KSP that only factors; MUMPS LDL^T where the matrix is symmetric, LU otherwise.

    PETSc options with the KSP's prefix override the choice.
    """

    def __init__(self, ksp: PETSc.KSP, matrix: PETSc.Mat, symmetric: bool):
        self.ksp, self.matrix, self.symmetric = ksp, matrix, symmetric
        self.factorisations, self._spare = 0, SPARE
        self._pattern: tuple | None = None
        self._analysed = self._has_zeros_on_diagonal = False
        self._set_up()

    def _set_up(self) -> None:
        ksp = self.ksp
        ksp.setOperators(self.matrix)
        ksp.setType(PETSc.KSP.Type.PREONLY)
        pc = ksp.getPC()
        pc.setType(PETSc.PC.Type.CHOLESKY if self.symmetric else PETSc.PC.Type.LU)
        pc.setFactorSolverType(PETSc.Mat.SolverType.MUMPS)
        ksp.setFromOptions()

    def factorise(self) -> None:
        """Factor the matrix as it is now.

        Raises
        ------
        SingularTangent
        """
        pattern = compat.nonzero_state(self.matrix)
        if pattern != self._pattern:  # PETSc takes a new factor then, which would lack the settings below
            self._begin_anew()
            self._pattern = pattern
        if not self._analysed:
            diagonal = self.matrix.getDiagonal()
            diagonal.abs()
            self._has_zeros_on_diagonal = not diagonal.min()[1] > 0
        analysed, self._analysed, pc = self._analysed, True, self.ksp.getPC()
        self.ksp.setOperators(self.matrix)
        if pc.getFactorSolverType() == PETSc.Mat.SolverType.MUMPS:
            pc.setFactorSetUpSolverType()
            # Inertia needs null pivot detection (ICNTL 24); the threshold keeps it from replacing any.
            pc.getFactorMatrix().setMumpsIcntl(24, 1)
            pc.getFactorMatrix().setMumpsCntl(3, -1e-100)
            pc.getFactorMatrix().setMumpsIcntl(14, self._spare)
            pc.getFactorMatrix().setMumpsIcntl(27, TOGETHER)
            if self.symmetric and not self._has_zeros_on_diagonal:
                pc.getFactorMatrix().setMumpsIcntl(8, 1)  # scaled by its roots, which sweeps over all rows only refine
            if pc.getType() == PETSc.PC.Type.LU:
                pc.getFactorMatrix().setMumpsIcntl(33, 1)  # the determinant, in place of the inertia
        self.factorisations += 1
        pc.setReusePreconditioner(False)
        pc.setUp()
        pc.setReusePreconditioner(True)  # until `factorise` is called again, whatever is assembled meanwhile
        reason = pc.getFailedReason()
        if reason == PETSc.PC.FailedReason.FACTOR_OUTMEMORY and self._spare < MOST_SPARE:
            self._spare *= 4
            self._begin_anew()
            self.factorisations -= 1
            self.factorise()
        elif reason != PETSc.PC.FailedReason.NOERROR or self._null_pivots():
            self._begin_anew()
            if not analysed:
                raise SingularTangent("the tangent is singular")
            self.factorise()  # the analysis of other values may have chosen pivots that have become zero

    def _begin_anew(self) -> None:
        """Drop the factor, and the analysis of the matrix that it was made with."""
        self.ksp.getPC().reset()
        self._set_up()
        self._analysed = False

    def _null_pivots(self) -> int:
        """Number of pivots that are zero to the last digit, which MUMPS replaces: the mode there would be lost."""
        pc = self.ksp.getPC()
        return pc.getFactorMatrix().getMumpsInfog(28) if pc.getFactorSolverType() == PETSc.Mat.SolverType.MUMPS else 0

    def solve(self, right: PETSc.Vec, solution: PETSc.Vec) -> None:
        self.ksp.getPC().apply(right, solution)

    def solve_all(self, rights: Sequence[PETSc.Vec], solutions: Sequence[PETSc.Vec]) -> None:
        """Solve for several right-hand sides, on one process together: two take little more time than one."""
        if self.matrix.comm.size > 1 or len(rights) == 1:
            for right, solution in zip(rights, solutions, strict=True):
                self.solve(right, solution)
            return
        found = self.responses(np.column_stack([right.array_r for right in rights]))
        for solution, row in zip(solutions, found, strict=True):
            solution.array[:] = row

    def responses(self, rights: np.ndarray | csc_matrix) -> np.ndarray:
        """Solutions for the columns of an array, as rows; both have the rows of all processes.

        Of a sparse one MUMPS leaves out what of its forward substitution stays zero.
        """
        comm, pc, (begin, end) = self.ksp.comm, self.ksp.getPC(), self.matrix.getOwnershipRange()
        count, columns = end - begin, rights.shape[1]
        if issparse(rights) and pc.getFactorSolverType() == PETSc.Mat.SolverType.MUMPS:
            rows = rights.T.tocsr()
            rows.sum_duplicates()
            if comm.rank:  # MUMPS takes all from process 0
                rows = rows[:0, :0]
            entries = rows.indptr.astype(PETSc.IntType), rows.indices.astype(PETSc.IntType), rows.data
            sizes = (rows.shape[0], columns), (rows.shape[1], rights.shape[0])
            right = PETSc.Mat().createTranspose(PETSc.Mat().createAIJ(sizes, csr=entries, comm=comm))
        else:
            own = rights[begin:end] if isinstance(rights, np.ndarray) else rights.tocsr()[begin:end].toarray()
            right = PETSc.Mat().createDense(((count, None), (None, columns)), array=np.asfortranarray(own), comm=comm)
        found = np.empty((count, columns), order="F")
        solution = PETSc.Mat().createDense(((count, None), (None, columns)), array=found, comm=comm)
        pc.getFactorMatrix().matSolve(right, solution)
        return found.T if comm.size == 1 else np.concatenate(lasting(comm.tompi4py()).allgather(found.T), axis=1)

    def solve_transposed(self, right: PETSc.Vec, solution: PETSc.Vec) -> None:
        self.ksp.getPC().applyTranspose(right, solution)

    def check(self, pattern: PETSc.Vec, usual: PETSc.Vec) -> None:
        """Solve for any loads and see whether the solution satisfies the equations.

        Rounding hides a zero pivot; the solution is then so large that its residual is too. Each unknown counts in
        units of its own stiffness, the diagonal of the matrix, so that units of lengths and forces do not matter;
        where it has none, of the stiffest.

        Parameters
        ----------
        pattern : loads over the roots of the diagonal
        usual : for each unknown the usual diagonal entry of those in its unit, beside which no stiffness can be less
            than rounding unless a multiplier holds the unknown; 0 for multipliers

        Raises
        ------
        SingularTangent
        """
        roots, right, held = self.matrix.getDiagonal(), pattern.duplicate(), pattern.duplicate()
        roots.sqrtabs()
        idle = roots.array**2 < np.finfo(float).eps * usual.array
        right.array[:] = np.where(usual.array > 0, 0.0, np.cos(np.arange(usual.local_size)))
        self.matrix.mult(right, held)
        if lasting(self.matrix.comm.tompi4py()).allreduce(bool((idle & (held.array == 0)).any()), op=MPI.LOR):
            raise SingularTangent("the tangent is singular")
        largest = roots.max()[1]
        roots.array[idle | ~(roots.array > 0)] = largest
        right.pointwiseMult(pattern, roots)
        solution, residual = right.duplicate(), right.duplicate()
        self.solve(right, solution)
        self.matrix.mult(solution, residual)
        residual.axpy(-1.0, right)
        residual.pointwiseDivide(residual, roots)
        if not residual.norm() <= 1e-3 * pattern.norm():
            raise SingularTangent("the tangent is singular")

    def negative_pivots(self) -> int | None:
        """Number of negative eigenvalues of the factored matrix; None for LU."""
        pc = self.ksp.getPC()
        if pc.getType() != PETSc.PC.Type.CHOLESKY:
            return None
        return pc.getFactorMatrix().getInertia()[0]

    def determinant_sign(self) -> int | None:
        """Sign of the determinant of the factored matrix; None where the factor's package does not tell."""
        negative, pc = self.negative_pivots(), self.ksp.getPC()
        if negative is not None:
            return (-1) ** negative
        if pc.getFactorSolverType() != PETSc.Mat.SolverType.MUMPS:
            return None
        return 1 if pc.getFactorMatrix().getMumpsRinfog(12) > 0 else -1
