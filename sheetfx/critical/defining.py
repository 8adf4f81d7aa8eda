"""The equations of a critical point, linearised: what Newton's method for a point, or for a curve of points, solves.

The tangent K, bordered by weighted vectors C = W Phi near k modes, those that become unstable and others beside them,
gives V and G with

    K V = C G,    C^T V = 1,

of which G is singular where K is (Griewank and Reddien 1984; Govaerts 2000, chapter 3). Where the eigenvalue of the
sought mode is zero, with the null vector v = V u, lies

- a limit point:    R(x, factor) = 0,        u^T G u = 0;
- a bifurcation:    R(x, factor) = C t,      u^T G u = 0,    V^T f = 0,

where f is the load and the forces t vanish with the solution (Moore 1980): they are what an imperfection would have to
push with, and make the equations regular where two paths cross. The derivatives of G and of V^T f are third variations
of the energy, by differences of the exact Hessian. Of several sought modes the mean of the eigenvalues is zero. Numbers
of the structure enter by their influence on forces, load and tangent.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np
from petsc4py import PETSc

from .. import rounding
from ..continuation.bordered import BorderedSolver, pivots
from ..continuation.linear import DirectSolver
from ..continuation.problem import Problem
from ..discrete.free_motions import usual_stiffness
from ..discrete.system import System
from ..events.determinant import orthonormal
from .koiter import Energy


@dataclass(frozen=True)
class Influence:
    """Derivatives of a configuration by a number of the structure.

    Attributes
    ----------
    residual, load : of the forces out of balance and of the load
    images : function from vectors to derivatives of the tangent's products with these
    """

    residual: PETSc.Vec
    load: PETSc.Vec
    images: Callable[[Sequence[PETSc.Vec]], list[PETSc.Vec]]


@dataclass(frozen=True)
class Linearised:
    """Linear equations for a correction of the state, the load factor and numbers of the structure.

    The state changes by left + sum of changes * responses + sum of shares * modes, with the changes of the load factor
    and of the numbers first among the unknowns of the matrix, and the shares of modes behind them.

    Attributes
    ----------
    values, modes : eigenvalues of G in ascending order, and vectors V along its eigenvectors
    sought : numbers of those that are sought
    left : change of the state that leaves forces out of balance along the border only
    responses : to the load factor, and to the numbers
    held, pushed : forces along the modes with these
    rates : of each sought eigenvalue by the unknowns
    matrix, right : the equations
    """

    values: np.ndarray
    modes: list[PETSc.Vec]
    sought: np.ndarray
    left: PETSc.Vec = field(repr=False)
    responses: list[PETSc.Vec] = field(repr=False)
    held: np.ndarray = field(repr=False)
    pushed: np.ndarray = field(repr=False)
    rates: np.ndarray = field(repr=False)
    matrix: np.ndarray = field(repr=False)
    right: np.ndarray = field(repr=False)

    def solve(self) -> tuple[PETSc.Vec, np.ndarray, np.ndarray]:
        """The corrections of state, load factor and numbers, and the forces t."""
        return self.step(np.linalg.solve(self.matrix, self.right))

    def step(self, solution: np.ndarray) -> tuple[PETSc.Vec, np.ndarray, np.ndarray]:
        """Correction and forces that a solution of the equations is."""
        changes, shares = np.split(solution, [len(self.responses)])
        forces = np.zeros(len(self.values))
        forces[self.sought] = (self.values * shares - self.held - changes @ self.pushed)[self.sought]
        return self.left + combined([*self.responses, *self.modes], solution), changes, forces

    @property
    def directions(self) -> list[PETSc.Vec]:
        """Changes of the state by the unknowns of the matrix."""
        return [*self.responses, *self.modes]


class DefiningSystem:
    """Equations of a critical point, for the first `sought` of some modes.

    Parameters
    ----------
    problem : whose tangent is assembled
    linear : solver with its matrix

    Attributes
    ----------
    modes : of the border, orthonormal in the scaled inner product
    sought : numbers of those that are sought
    kind : of the point; None: not known yet
    bordered : the bordered tangent that was factored last
    """

    def __init__(self, problem: Problem, linear: DirectSolver, modes: Sequence[PETSc.Vec], sought: int,
                 kind: str | None):
        self.modes, self.sought, self.kind = list(modes), np.arange(sought), kind
        self._system, self._linear = problem.system, linear
        self._energy = Energy(problem.system)
        self._springs, self._least = pivots(self.modes, self._system.weights), usual_stiffness(problem)

    @property
    def sought_modes(self) -> list[PETSc.Vec]:
        """The modes that are sought, as far as is known."""
        return [self.modes[n] for n in self.sought]

    def factorise(self) -> None:
        """Factor the tangent with the stresses that are set.

        Raises
        ------
        SingularTangent
        """
        border = [self._system.weights * mode for mode in self.modes]
        self._system.tangent()
        self.bordered = BorderedSolver(self._linear, self._springs, self._least)
        self.bordered.border(border, border)

    def is_strained(self, x: PETSc.Vec, factor: float) -> bool:
        """Whether the forces out of balance at increments are more than the load, as interpolation makes them."""
        residual, load = self._system.create_vector(), self._system.create_vector()
        self._system.configure(x, factor)
        self._system.residual(residual)
        self._system.load(load)
        return residual.norm() > abs(factor) * load.norm()

    def off_modes(self, x: PETSc.Vec, factor: float, more: PETSc.Vec | None = None) -> PETSc.Vec:
        """Correction at increments that keeps the amplitudes of the modes, with the factor that there is.

        Parameters
        ----------
        more : forces out of balance besides the system's
        """
        residual = self._system.create_vector()
        self._system.configure(x, factor)
        self._system.residual(residual)
        if more is not None:
            residual.axpy(1.0, more)
        (step,), _ = self.bordered.solve([-1.0 * residual], np.zeros((1, len(self.modes))))
        return step

    def linearise(self, x: PETSc.Vec, factor: float, numbers: Sequence[Influence] = ()) -> Linearised:
        """The equations at increments and a load factor, after which the modes of the border are those found there.

        Raises
        ------
        SingularTangent, numpy.linalg.LinAlgError
        """
        system, count = self._system, len(self.modes)
        residual, load = system.create_vector(), system.create_vector()
        system.configure(x, factor)
        system.residual(residual)
        system.load(load)
        system.extrapolate_stress()
        self.factorise()
        vectors, below = self.bordered.solve([], np.eye(count))
        rights = [-1.0 * residual, load, *(-1.0 * number.residual for number in numbers)]
        (left, *responses), (held, *pushed) = self.bordered.solve(rights, np.zeros((len(rights), count)))
        values, turned = np.linalg.eigh(-(below + below.T) / 2)
        self.sought = np.sort(np.argsort(-np.linalg.norm(turned[self.sought], axis=0))[:len(self.sought)])
        modes = [combined(vectors, column) for column in turned.T]
        held, pushed = held @ turned, np.array(pushed) @ turned
        self.kind = self.kind or self._likely(values, pushed[0], modes, responses[0])
        rates, matrix, right = self._equations((x, factor), values, modes, left, responses, held, pushed, numbers)
        self.modes = orthonormal(system.weights, modes)
        return Linearised(values, modes, self.sought, left, responses, held, pushed, rates, matrix, right)

    def _likely(self, values, pushed, modes, loaded) -> str:
        """Whether the response to the load, loaded + sum of mode pushed / value, is along the sought mode or not."""
        if len(self.sought) > 1:
            return "bifurcation"
        (n,), shares = self.sought, pushed / values
        rest = loaded + combined(modes, np.where(np.arange(len(values)) == n, 0.0, shares))
        along = abs(shares[n]) * self._energy.length(modes[n])
        return "limit" if along > self._energy.length(rest) else "bifurcation"

    def _equations(self, about, values, modes, left, responses, held, pushed, numbers):
        """Rates of the sought eigenvalues, matrix and right side of the equations."""
        along = [self._energy.third(modes, responses[0], 1.0, about)]
        images = [number.images(modes) for number in numbers]
        for response, own in zip(responses[1:], images, strict=True):
            along.append([a + b for a, b in zip(self._energy.third(modes, response, 0.0, about), own, strict=True)])
        matrix, right = np.column_stack((-pushed.T, np.diag(values))), held.copy()
        rates = np.zeros((len(self.sought), matrix.shape[1]))
        here = np.zeros(len(self.sought))
        for row, n in enumerate(self.sought):
            bent = self._energy.third(modes, modes[n], 0.0, about)
            rates[row] = [*(modes[n].dot(one[n]) for one in along), *(mode.dot(bent[n]) for mode in modes)]
            here[row] = values[n] + left.dot(bent[n])
            if self.kind == "bifurcation":
                turning = along[0][n] + self._turning(n, about, values, modes, pushed[0])
                matrix[n] = [-direction.dot(turning) for direction in (*responses, *modes)]
                matrix[n, 1:len(responses)] += [modes[n].dot(number.load) - responses[0].dot(own[n])
                                                for number, own in zip(numbers, images, strict=True)]
                right[n] = left.dot(turning) - pushed[0, n]
        return rates, np.vstack((rates.mean(axis=0), matrix)), np.array([-here.mean(), *right])

    def _turning(self, n: int, about, values, modes, pushed) -> PETSc.Vec:
        """Change of the Hessian's product with mode n along what the response to the load has of modes not sought.

        As the state changes the mode turns towards these, and with it the work of the load along the mode.
        """
        others = [m for m in range(len(values))
                  if m not in self.sought and abs(values[m] - values[n]) > rounding.NONE * abs(values[m])]
        if not others:
            return 0.0 * modes[n]
        along = combined([modes[m] for m in others], pushed[others] / (values[others] - values[n]))
        return self._energy.third([modes[n]], along, 0.0, about)[0]


def without_third_variations(system: System) -> str:
    """Why the equations do not hold, which need a potential with third derivatives; "": they do."""
    if system.rough:
        return "contact or friction"
    if any(contribution.remembers for contribution in system.contributions):
        return "laws with history"
    if not system.conservative:
        return "forces without a potential"
    return "" if system.smooth else "laws with cases"


def combined(vectors: Sequence[PETSc.Vec], factors) -> PETSc.Vec:
    """Sum of vectors with factors."""
    total = vectors[0].duplicate()
    total.maxpy(list(map(float, factors)), list(vectors))
    return total
