"""The equations of the branches of a bifurcation: all of equilibrium but its part in the space of null vectors.

With the m null vectors Phi of the tangent at the bifurcation, a direction c of R^m and a small amplitude r,

    R(x, factor) = W Phi t,    t orthogonal to c,    Phi^ W x = r c

has one solution (x, factor, t) near the bifurcation (Lyapunov and Schmidt's reduction; Golubitsky and Schaeffer 1985,
chapter VII). W holds the weights of the scaled inner product, Phi^ the vectors dual to Phi that are orthogonal to the
path on which the bifurcation lies, so that this path has amplitude zero. Where the forces t vanish, the solution is an
equilibrium. Where points have yielded they hold for the structure itself, not for its comparison solid: the load rises
along a branch in proportion to the amplitude, so that nothing unloads at first (Shanley 1947; Hutchinson 1974).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from petsc4py import PETSc

from ..continuation.bordered import BorderedSolver, pivots
from ..continuation.linear import SingularTangent
from ..continuation.spectrum import PREFIX
from ..continuation.state import State

ITERATIONS = 12
CONVERGED = 1e-7  # last correction over the amplitude; with Newton's method the next one is its square
NEAR, NEAR_YIELDED = 0.02, 0.2  # change of load between bifurcation and solution, over the load


class NoSolution(ArithmeticError):
    """The reduced equations do not converge for this direction and amplitude."""


@dataclass(frozen=True)
class Solution:
    """Increments from the bifurcation, and the forces t along the null vectors that hold them."""

    increment: np.ndarray
    load_increment: float
    forces: np.ndarray
    iterations: int


class Reduction:
    """Equilibrium in all but the space of null vectors, about the current state of a tracer, factored there.

    Parameters
    ----------
    tracer : at the state of the bifurcation
    multiplicity : number of null vectors
    after : state at the end of the step that the bifurcation lies in

    Attributes
    ----------
    bifurcation : the state
    modes : null vectors, orthonormal in the scaled inner product
    weighted : null vectors times the weights of the inner product
    measures : dual vectors, whose products with increments are the amplitudes of the null vectors
    negative : number of the null vectors' eigenvalues that are below zero by rounding
    size : load factor that changes of it are compared with
    springs : numbers of unknowns, one for each null vector, that springs hold while the tangent is factored

    Raises
    ------
    ArithmeticError
        If fewer null vectors converge than there should be.
    ValueError
        If the path itself goes along a null vector.
    """

    def __init__(self, tracer, multiplicity: int, after: State):
        self.tracer, self.system, self.bifurcation = tracer, tracer.system, tracer.state
        self.linear = tracer.stepper.linear
        pairs = sorted(zip(*tracer.spectrum(multiplicity + 1), strict=True), key=lambda pair: abs(pair[0]))
        self.modes = [mode for _, mode in pairs[:multiplicity]]
        if len(pairs) <= multiplicity:
            raise ArithmeticError(f"branches: only {len(pairs)} of the {multiplicity + 1} modes nearest to zero at "
                                  f"load {self.bifurcation.load:.6g} converge; try "
                                  f"PETSC_OPTIONS='-{PREFIX}eps_tol 1e-8'")
        self.negative = sum(value < 0 for value, _ in pairs[:multiplicity])
        self._least_stiffness = abs(pairs[-1][0])
        self.weighted = [self.system.weights * mode for mode in self.modes]
        self.measures = self._measures(after)
        self.size = max(abs(self.bifurcation.factor), abs(after.load_increment))
        self.springs = pivots(self.modes, self.system.weights)
        self._yielded = self.system.history.moved
        self._residual, self._load = self.system.create_vector(), self.system.create_vector()

    def _measures(self, after: State) -> list[PETSc.Vec]:
        """Vectors whose products with increments are the amplitudes of the null vectors, zero along the path."""
        across = self.system.create_vector(after.increment)
        shares = [across.dot(weighted) for weighted in self.weighted]
        whole2 = self.tracer.distance(0.0, after.increment) ** 2 + after.least_weight * after.load_increment**2
        for share, mode in zip(shares, self.modes, strict=True):
            across.axpy(-share, mode)
        across = self.system.weights * across
        rest2 = whole2 - sum(share**2 for share in shares)
        if rest2 < 1e-4 * whole2:
            raise ValueError(f"branches: at load {self.bifurcation.load:.6g} the path goes along a null vector; "
                             "bifurcations that are limit points too cannot be switched; come to the other path by "
                             "an imperfect shape")
        measures = []
        for share, weighted in zip(shares, self.weighted, strict=True):
            measure = weighted.copy()
            measure.axpy(-share / rest2, across)
            measures.append(measure)
        return measures

    def solve(self, direction: np.ndarray, amplitude: float, free: bool = False) -> Solution:
        """Solution in one direction, by Newton's method from the null vector.

        Parameters
        ----------
        free : whether the direction may turn, without forces, until there is equilibrium; the amplitude is then that
            along the direction

        Raises
        ------
        NoSolution
        """
        with self.system.additive_increments(frozen=not self._yielded):
            return self._iterated(direction, amplitude, free)

    def _iterated(self, direction: np.ndarray, amplitude: float, free: bool) -> Solution:
        system, x = self.system, self.tracer.x
        load_increment, forces = 0.0, np.zeros(len(direction))
        x.zeroEntries()
        system.configure(x, self.bifurcation.factor)
        step = self.combined(self.modes, amplitude * direction)
        taken, allowed = np.inf, 4 * amplitude
        tangential = np.linalg.svd(direction[None, :])[2][1:]
        measures, amplitudes = self.measures, amplitude * direction
        if free:
            tangential, measures = tangential[:0], [self.combined(self.measures, direction)]
            amplitudes = np.array([amplitude])
        for iteration in range(ITERATIONS):
            system.extrapolate_stress(step)
            system.retract(x, step)
            system.configure(x, self.bifurcation.factor + load_increment)
            system.residual(self._residual)
            system.load(self._load)
            self._residual.axpy(-1.0, self.combined(self.weighted, forces))
            if taken <= CONVERGED * amplitude:
                if abs(load_increment) > (NEAR_YIELDED if self._yielded else NEAR) * self.size:
                    break
                return Solution(x.array.copy(), load_increment, forces, iteration)
            missing = amplitudes - [measure.dot(x) for measure in measures]
            try:
                step, change, more = self._correction(tangential, measures, missing)
            except (SingularTangent, np.linalg.LinAlgError):
                break
            load_increment, forces = load_increment + change, forces + more
            taken = self.tracer.distance(0.0, step.array)
            if not taken <= allowed:
                break
            allowed = np.inf if self._yielded else taken / 2
        raise NoSolution

    def combined(self, vectors: Sequence[PETSc.Vec], factors) -> PETSc.Vec:
        """Sum of vectors times factors."""
        total = self.system.create_vector()
        total.maxpy(list(factors), list(vectors))
        return total

    def _correction(self, tangential: np.ndarray, measures: Sequence[PETSc.Vec],
                    missing: np.ndarray) -> tuple[PETSc.Vec, float, np.ndarray]:
        """Newton's step of unknowns, load factor and forces."""
        least = self._least_stiffness * self.system.weights
        self.system.tangent()
        bordered = BorderedSolver(self.linear, self.springs, least)
        pushes = [self._load, *(self.combined(self.weighted, row) for row in tangential)]
        bordered.border([-1.0 * push for push in pushes], measures)
        (step,), ((change, *forces),) = bordered.solve([-1.0 * self._residual], missing[None, :])
        return step, float(change), np.array(forces) @ tangential

    def relative_forces(self, solution: Solution) -> float:
        """Ratio of the norms of the forces along the null vectors and of the loads."""
        self.system.load(self._load)
        total = self.combined(self.weighted, solution.forces)
        return total.norm() / (self.size * self._load.norm())

    def state(self, solution: Solution) -> State:
        """The solution as a state that follows the bifurcation."""
        self.tracer.back_to(self.bifurcation)
        self.tracer.x.array[:] = solution.increment
        self.system.configure(self.tracer.x, self.bifurcation.factor + solution.load_increment)
        state = self.tracer.accept(solution.load_increment, solution.iterations)
        self.tracer.back_to(self.bifurcation)
        return state
