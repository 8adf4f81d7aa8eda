"""Solutions of a tangent with a border, which may be singular itself.

    [K   C] [y ]   [r]
    [D^T 0] [mu] = [d]

The tangent K is factored with springs at as many unknowns as the border has columns. Further unknowns cancel the
springs, so that K itself is solved with, near a critical point and at it (Govaerts 2000, section 3.6, has other ways).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from petsc4py import PETSc

from ..communicators import lasting
from .linear import DirectSolver


class BorderedSolver:
    """The tangent that a direct solver has, factored with springs.

    Parameters
    ----------
    solver : whose matrix is assembled
    springs : numbers of unknowns that are held, one for each null vector to be expected
    least : for each unknown the least stiffness of a spring

    Raises
    ------
    SingularTangent
    """

    def __init__(self, solver: DirectSolver, springs: Sequence[int], least: PETSc.Vec):
        self._solver, self._springs = solver, springs
        matrix = solver.matrix
        here, (first, last) = matrix.getDiagonal(), matrix.getOwnershipRange()
        stiffness = [2 * max(abs(entry(here, n)), entry(least, n)) for n in springs]
        for number, k in zip(springs, stiffness, strict=True):
            if first <= number < last:
                matrix.setValue(number, number, k, addv=PETSc.InsertMode.ADD)
        matrix.assemble()
        solver.factorise()
        self._stiffness = np.array(stiffness)
        self._held = self._solved([self._unit(n, k) for n, k in zip(springs, stiffness, strict=True)])
        self._columns: list[PETSc.Vec] = []
        self._rows: list[PETSc.Vec] = []

    def border(self, columns: Sequence[PETSc.Vec], rows: Sequence[PETSc.Vec]) -> None:
        """Take the columns C and as many rows D."""
        self._rows = list(rows)
        self._columns = [*self._solved(columns), *(-1.0 * vector for vector in self._held)]
        probes = [*rows, *(self._unit(n, 1.0) for n in self._springs)]
        self._matrix = np.array([[probe.dot(column) for column in self._columns] for probe in probes])
        self._matrix[len(rows):, len(rows):] += np.eye(len(self._springs))
        self._probes = probes

    @property
    def size(self) -> int:
        """Number of rows of the border, which are as many as its columns."""
        return len(self._rows)

    def left(self, count: int) -> list[PETSc.Vec]:
        """Vectors that the transposed tangent without its border makes smallest, as null vectors are."""
        solutions = []
        for number, stiffness in zip(self._springs, self._stiffness, strict=True):
            solutions.append(self._solver.matrix.createVecLeft())
            self._solver.solve_transposed(self._unit(number, float(stiffness)), solutions[-1])
        told = np.array([[entry(one, number) for one in solutions] for number in self._springs])
        vectors = []
        for shares in np.linalg.svd(np.eye(len(told)) - told)[2][len(told) - count:]:
            vectors.append(solutions[0].duplicate())
            vectors[-1].maxpy(list(map(float, shares)), solutions)
        return vectors

    def negative(self) -> int | None:
        """Number of negative eigenvalues of the tangent on what the rows leave, which are the columns; None: not known.

        It follows from the factored matrix's and a Schur complement's (Haynsworth 1968, inertia additivity).
        """
        factored = self._solver.negative_pivots()
        if factored is None:
            return None
        complement = self._matrix.copy()
        complement[:, len(self._rows):] /= -self._stiffness
        positive = np.linalg.eigvalsh((complement + complement.T) / 2) > 0
        return factored + int(positive.sum()) - len(self._rows)

    def solve(self, rights: Sequence[PETSc.Vec], below: np.ndarray) -> tuple[list[PETSc.Vec], np.ndarray]:
        """Solutions y, and in a row for each the numbers mu.

        Parameters
        ----------
        rights : r of each; none: zero
        below : d of each, shape (solutions, rows)

        Raises
        ------
        numpy.linalg.LinAlgError
            If the border leaves the tangent singular.
        """
        solutions = self._solved(rights) if rights else [self._probes[0].duplicate() for _ in below]
        told = np.array([[probe.dot(one) for probe in self._probes] for one in solutions])
        told[:, :len(self._rows)] -= below
        numbers = np.linalg.solve(self._matrix, told.T).T
        for one, row in zip(solutions, numbers, strict=True):
            one.maxpy(list(-row), self._columns)
        return solutions, numbers[:, :len(self._rows)]

    def _solved(self, rights: Sequence[PETSc.Vec]) -> list[PETSc.Vec]:
        solutions = [right.duplicate() for right in rights]
        if solutions:
            self._solver.solve_all(list(rights), solutions)
        return solutions

    def _unit(self, number: int, value: float) -> PETSc.Vec:
        vector = self._solver.matrix.createVecRight()
        first, last = vector.getOwnershipRange()
        if first <= number < last:
            vector.array[number - first] = value
        return vector


def entry(vector: PETSc.Vec, number: int) -> float:
    """An entry of a vector, the same on all processes."""
    first, last = vector.getOwnershipRange()
    own = vector.array[number - first] if first <= number < last else 0.0
    return lasting(vector.comm.tompi4py()).allreduce(float(own))


def pivots(vectors: Sequence[PETSc.Vec], weights: PETSc.Vec) -> list[int]:
    """Unknowns by which vectors can be told apart, one for each, by elimination with scaled pivots."""
    roots, chosen = weights.copy(), []
    roots.sqrtabs()
    rest = [roots * vector for vector in vectors]
    for n, vector in enumerate(rest):
        size = vector.copy()
        size.abs()
        chosen.append(size.max()[0])
        value = entry(vector, chosen[-1])
        for other in rest[n + 1:]:
            other.axpy(-entry(other, chosen[-1]) / value, vector)
    return chosen
