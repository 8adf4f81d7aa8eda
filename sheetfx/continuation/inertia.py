"""Eigenvalues of an unsymmetric tangent that pass zero from one state to another.

A symmetric tangent's factor counts its negative eigenvalues; an unsymmetric one's only tells the sign of the
determinant, which pairs of eigenvalues leave as it was. Between two tangents K0 and K1 that are close to each other
those that pass zero are the real eigenvalues s between 0 and 1 of K0 + s (K1 - K0), which the factor of K1 finds: for a
symmetric pencil Sylvester's law of inertia gives the same count.

With Coulomb friction tangents jump where something begins or ceases to touch or to slip. There the other tangent is
that of the same state with which all that touches sticks: it is symmetric, so that its inertia is known, and slipping
changes it in few columns. (The symmetric part of the tangent is no help: pressure k g and traction mu k g make a matrix
of the normal stiffness k whose symmetric part is indefinite as soon as anything slips, however stable the structure.)

The SLEPc solver takes the prefix `sheetfx_crossings_`.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from math import inf

import numpy as np
from petsc4py import PETSc
from slepc4py import SLEPc

from .. import compat
from ..rounding import is_real
from .callbacks import interruptible
from .linear import DirectSolver
from .state import State

PREFIX = "sheetfx_crossings_"
FEW, MANY = 6, 48  # eigenvalues that are looked for: those that change most, at most of those that pass zero
ROUGH = 0.25  # error of the real part of 1 / (1 - s), which is not near 1 where it is smaller by twice as much
ALIKE = 1e-9  # of estimates that steps hang on, so that any number of processes takes the same steps
CLOSE = 1e-3  # relative difference of eigenvalues whose directions are found together


class Uncounted(ArithmeticError):
    """Two tangents are too far apart for what lies between them to be counted."""


class UnstableModes:
    """Counts the negative eigenvalues of tangents, where these are not symmetric from one state to the next.

    Attributes
    ----------
    critical : state at a critical point, from which nothing can be counted: the one before it serves on
    """

    def __init__(self, system, linear: DirectSolver):
        self._system, self._linear = system, linear
        self._counts, self._sticks = system.smooth and not system.conservative, can_stick(system)
        self._start: State | None = None
        self._tangent: PETSc.Mat | None = None
        self._sticking: DirectSolver | None = None
        self._pattern: tuple | None = None
        self.critical: State | None = None

    def start_from(self, state: State, increment: PETSc.Vec) -> None:
        """Count from a state on, which the present increments begin at."""
        system = self._system
        if not self._counts or state is self._start or state is self.critical:
            return
        present = system.factor
        system.configure(system.create_vector(), state.factor)
        system.extrapolate_stress()
        self._start, self._tangent = state, system.tangent().copy()
        system.configure(increment, present)

    def of_present(self, start: State | None, determinant: int | None) -> int | None:
        """Number for the tangent that is factored; None: not known.

        Parameters
        ----------
        start : None: the path begins, with no unstable modes where they cannot be counted
        determinant : its sign

        Raises
        ------
        Uncounted
        """
        if self._system.conservative:
            pivots = self._linear.negative_pivots()
            return None if pivots is None else pivots - self._system.multipliers
        if self._sticks and determinant is not None:
            return self._beside_sticking(determinant)
        if not self._counts or determinant is None:
            return None
        if start is None:
            return 0
        before = self._start
        if before is None or before.unstable_modes is None or before.determinant_sign is None:
            return None
        return self._after(before.unstable_modes, self._tangent, determinant * before.determinant_sign)

    def _beside_sticking(self, determinant: int) -> int:
        """Number for the tangent that is factored, from the number of the one with which all that touches sticks."""
        system = self._system
        earlier, pattern = sticking_tangent(system), compat.nonzero_state(system.matrix)
        if self._sticking is None or pattern != self._pattern:
            self._sticking = DirectSolver(PETSc.KSP().create(system.comm), earlier, symmetric=True)
            self._pattern = pattern
        else:
            earlier.copy(self._sticking.matrix, PETSc.Mat.Structure.SAME_NONZERO_PATTERN)
        self._sticking.factorise()
        pivots = self._sticking.negative_pivots() - system.multipliers
        return self._after(pivots, earlier, determinant * (-1) ** pivots)

    def _after(self, count: int, earlier: PETSc.Mat, signs: int) -> int:
        """Number for the tangent that is factored, from an earlier one's."""
        found = count + crossings(self._linear, earlier, self._system.weights, signs)
        if found < 0:
            raise Uncounted("more eigenvalues seem to become positive than are negative")
        return found


def can_stick(system) -> bool:
    """Whether all that has no potential is friction between parts, which has one where it sticks."""
    return not system.conservative and all(c.conservative or c.sticks for c in system.contributions)


@contextmanager
def sticking(system) -> Iterator[None]:
    """Have all that touches answer as if it stuck where it is."""
    for contribution in system.contributions:
        contribution.stick()
    try:
        yield
    finally:
        for contribution in system.contributions:
            contribution.release()


def sticking_tangent(system) -> PETSc.Mat:
    """The tangent of a system as if all that touches stuck where it is; the system's own stays as it is."""
    present = system.matrix.copy()
    with sticking(system):
        found = system.tangent(only=[c for c in system.contributions if c.sticks]).copy()
    present.copy(system.matrix, PETSc.Mat.Structure.SAME_NONZERO_PATTERN)
    return found


def first_critical(system, linear: DirectSolver, response: PETSc.Vec, ahead: float) -> float:
    """Increment of the load factor, from the last converged state, at which the first eigenvalue passes zero, roughly.

    Parameters
    ----------
    linear : with the factor of the tangent there
    response : to a unit of load
    ahead : increment of the load factor at which the change of the tangent is looked at
    """
    start, rest, along = system.factor, system.create_vector(), response.copy()
    here = system.matrix.copy()
    along.scale(ahead)
    system.configure(along, start + ahead)
    system.extrapolate_stress()
    change = system.tangent().copy()
    change.axpy(-1.0, here, PETSc.Mat.Structure.SAME_NONZERO_PATTERN)
    found = ahead * first_passing(linear, change)
    system.configure(rest, start)
    system.extrapolate_stress()
    system.tangent()
    return found


def crossings(solver: DirectSolver, earlier: PETSc.Mat, weights: PETSc.Vec, signs: int) -> int:
    """Change of the number of negative eigenvalues of a tangent since an earlier one.

    Parameters
    ----------
    solver : with the factor of the tangent now
    earlier : the tangent then, on the same entries
    weights : diagonal of the inner product in which eigenvalues are meant
    signs : product of the signs of both determinants, which the count must agree with

    Raises
    ------
    Uncounted
    """
    change = solver.matrix.copy()
    change.axpy(-1.0, earlier, PETSc.Mat.Structure.SAME_NONZERO_PATTERN)
    if not change.norm() > 0:
        return 0
    near = _near(solver, change)
    if signs > 0 and not near:
        return 0
    asked = max(near, 1)
    eps = _solver(solver, change, asked)
    values = _values(eps)
    passed = [v for v in values if _passes(v)]
    too_many = len(values) >= MANY and values.real.min() >= 1
    if too_many or (-1) ** len(passed) != signs:
        raise Uncounted("the tangent changes too much for the eigenvalues that pass zero to be counted")
    return _towards_negative(eps, solver, change, weights, asked) if passed else 0


def first_passing(solver: DirectSolver, change: PETSc.Mat) -> float:
    """Multiple of a change of the factored tangent with which an eigenvalue passes zero, roughly.

    Infinite where none does. Where the tangent is not symmetric all changes count, since those that do not pass zero
    may lead to flutter.
    """
    if not change.norm() > 0:
        return inf
    count, which = (1, SLEPc.EPS.Which.SMALLEST_REAL) if solver.symmetric else (FEW, SLEPc.EPS.Which.LARGEST_MAGNITUDE)
    values = _values(_solver(solver, change, count, ALIKE, which))
    fastest = max((-values.real) if solver.symmetric else np.abs(values))
    return 1 / fastest if fastest > 0 else inf


def _near(solver: DirectSolver, change: PETSc.Mat) -> int:
    """Number of eigenvalues that pass zero, or nearly do, as a rough look shows, at most MANY; 1 where it fails."""
    asked, most = 1, min(MANY, change.getSize()[0])
    while True:
        eps = _solver(solver, change, asked, ROUGH)
        values = _values(eps).real
        near = int((values >= 1 - 2 * ROUGH).sum())
        if near < len(values) or len(values) < asked or len(values) >= most:
            return min(near, MANY) if eps.getConverged() else 1
        asked = min(2 * len(values), most)


def _passes(value: complex) -> bool:
    """Whether the reciprocal of 1 - s belongs to a real s between 0 and 1."""
    return value.real > 1 and is_real(value)


def _solver(solver: DirectSolver | _Transposed, change: PETSc.Mat, count: int, tolerance: float = 1e-6,
            which=SLEPc.EPS.Which.LARGEST_REAL) -> SLEPc.EPS:
    """Solved eigenproblem K1^-1 (K1 - K0) mode = mode / (1 - s)."""
    eps = SLEPc.EPS().create(change.comm)
    eps.setOptionsPrefix(PREFIX)
    eps.setOperators(PETSc.Mat().createPython(change.getSizes(), _Change(solver, change), comm=change.comm))
    eps.setProblemType(SLEPc.EPS.ProblemType.NHEP)
    eps.setWhichEigenpairs(which)
    size = change.getSize()[0]
    columns = min(max(2 * count + 8, 20), size)
    if columns == size:
        eps.setType(SLEPc.EPS.Type.LAPACK)  # Arnoldi's process would come to its end
    eps.setDimensions(count, columns)
    eps.setTolerances(tolerance, 30)
    if which == SLEPc.EPS.Which.LARGEST_REAL:
        eps.setConvergenceTest(SLEPc.EPS.Conv.ABS)
    eps.setFromOptions()
    with interruptible():
        eps.solve()
    return eps


class _Change:
    """The change of a tangent, relative to the tangent."""

    def __init__(self, solver: DirectSolver | _Transposed, change: PETSc.Mat):
        self._solver, self._change, self._right = solver, change, change.createVecLeft()

    def mult(self, matrix, vector, out) -> None:
        self._change.mult(vector, self._right)
        self._solver.solve(self._right, out)


def _values(eps: SLEPc.EPS) -> np.ndarray:
    """1 / (1 - s) for each eigenvalue found."""
    values = np.array([eps.getEigenvalue(i) for i in range(eps.getConverged())], dtype=complex)
    return values if len(values) else np.zeros(1)


def _towards_negative(eps: SLEPc.EPS, solver: DirectSolver, change: PETSc.Mat, weights: PETSc.Vec, asked: int) -> int:
    """Number of eigenvalues that become negative, less the number that become positive.

    A simple eigenvalue of K0 + s (K1 - K0) changes at zero by (left mode) (K1 - K0) (mode) over their inner product;
    several together by the eigenvalues of the same with matrices.
    """
    right = [pair for pair in _modes(eps) if _passes(pair[0])]
    left = _modes(_solver(_Transposed(solver), change.transpose(PETSc.Mat()), asked))
    if len(left) < len(right):
        raise Uncounted("not all eigenvalues of the transposed tangent that pass zero converge")
    count, group = 0, []
    for n, (value, mode) in enumerate(right):
        group.append((mode, left.pop(int(np.argmin([abs(other - value) for other, _ in left])))[1]))
        if n + 1 == len(right) or abs(right[n + 1][0] - value) > CLOSE * abs(value):
            slopes = _slopes(group, change, weights)
            count += int((slopes < 0).sum()) - int((slopes > 0).sum())
            group = []
    return count


def _modes(eps: SLEPc.EPS) -> list[tuple[complex, PETSc.Vec]]:
    """1 / (1 - s) for each eigenvalue found, by their real parts, and modes; of a pair both parts of one."""
    found = []
    for i, value in enumerate(_values(eps)):
        real, imaginary = eps.getOperators()[0].createVecs()
        eps.getEigenvector(i, real, imaginary)
        found.append((complex(value), imaginary if value.imag > 0 else real))
    return sorted(found, key=lambda pair: pair[0].real)


class _Transposed:
    """The factor of the transposed matrix."""

    def __init__(self, solver: DirectSolver):
        self.matrix, self._solver = solver.matrix.transpose(PETSc.Mat()), solver

    def solve(self, right: PETSc.Vec, solution: PETSc.Vec) -> None:
        self._solver.solve_transposed(right, solution)


def _slopes(modes: list[tuple[PETSc.Vec, PETSc.Vec]], change: PETSc.Mat, weights: PETSc.Vec) -> np.ndarray:
    """Rates at which eigenvalues in the inner product pass zero together."""
    moved, weighed = np.empty((len(modes),) * 2), np.empty((len(modes),) * 2)
    work = modes[0][0].duplicate()
    for j, (right, _) in enumerate(modes):
        for matrix, apply in ((moved, change.mult), (weighed, lambda x, y: y.pointwiseMult(weights, x))):
            apply(right, work)
            for i, (_, left) in enumerate(modes):
                matrix[i, j] = left.dot(work)
    return np.linalg.eigvals(np.linalg.solve(weighed, moved)).real
