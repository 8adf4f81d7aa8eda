"""Critical points found directly, by Newton's method for state, load and null vectors together.

The tangent K, bordered by weighted vectors C = W Phi near k modes, those that become unstable and others beside them,
gives V and G with

    K V = C G,    C^T V = 1,

of which G is singular where K is (Griewank and Reddien 1984; Govaerts 2000, chapter 3). Where the eigenvalue of the
sought mode is zero, with the null vector v = V u, lies

- a limit point:    R(x, factor) = 0,        u^T G u = 0;
- a bifurcation:    R(x, factor) = C t,      u^T G u = 0,    V^T f = 0,

where f is the load and the forces t vanish with the solution (Moore 1980): they are what an imperfection would have to
push with, and make the equations regular where two paths cross. The derivatives of G and of V^T f are third variations
of the energy, by differences of the exact Hessian. Both systems are regular at simple points, so that Newton's method
converges quadratically; at points of several modes together their mean is sought, which symmetry makes regular too.
Close to other points the tangent is nearly singular in modes that are not sought: they belong to the border.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Annotated

import numpy as np
from petsc4py import PETSc

from ..checks import NOT_NEGATIVE, Choice, Count, require
from ..continuation.bordered import BorderedSolver, pivots
from ..continuation.control import ArcLength
from ..continuation.linear import SingularTangent
from ..continuation.state import CriticalPoint, State
from ..continuation.tracer import Tracer, tracer_of
from ..discrete.discretisation import Discretisation
from ..discrete.free_motions import usual_stiffness
from ..events.border import orthonormal
from ..model.scene import Scene
from .koiter import Energy, postbuckling
from .modes import scaled

KINDS = "limit", "bifurcation"
ITERATIONS = 12


class NoCriticalPoint(ArithmeticError):
    """Newton's method for a critical point does not converge from the guess."""


@dataclass(frozen=True)
class Iteration:
    """One of Newton's corrections.

    Attributes
    ----------
    load : total load before it
    correction : of the state, in the scaled inner product
    eigenvalues : of G before it, in ascending order
    """

    load: float
    correction: float
    eigenvalues: tuple[float, ...]

    def __str__(self) -> str:
        values = ", ".join(f"{value:.3e}" for value in self.eigenvalues)
        return f"load {self.load:.10g}, correction {self.correction:.1e}, eigenvalues {values}"


@dataclass(frozen=True)
class Critical:
    """A critical point that was found directly.

    Attributes
    ----------
    point : kind, load, deflection, multiplicity, name, Koiter's a and b
    state : from which paths go on, and branches
    modes : null vectors, this process's part, the largest displacement being 1
    unfolding : norm of the forces along the null vectors that hold the state, over that of the load; at a bifurcation
        rounding, unless the structure is imperfect
    iterations : of Newton's method
    factorisations : that it took
    """

    point: CriticalPoint
    state: State = field(repr=False)
    modes: tuple[np.ndarray, ...] = field(repr=False)
    unfolding: float
    iterations: tuple[Iteration, ...] = field(repr=False)
    factorisations: int

    def __str__(self) -> str:
        return str(self.point)


def critical(scene, guess: State, mode: np.ndarray | Sequence[np.ndarray] | None = None, *,
             kind: str | None = None, multiplicity: int = 1, beside: int = 0) -> Critical:
    """The critical point next to a guess, without a path up to it.

    Parameters
    ----------
    scene : Scene, or a Path of it, that the guess is a state of
    guess : state near the point
    mode : increments near the null vector, this process's part, or a BucklingLoad or Branch with them; several near
        those of a multiple point; None: the modes of the guess's tangent that are nearest to zero
    kind : "limit" or "bifurcation"; None: a limit point where the response of the guess to the load is for the greater
        part along the mode
    multiplicity : number of modes where none are given
    beside : number of further modes in the border, those of the guess that are nearest to zero: as many as there are
        other points close to the one that is sought

    Raises
    ------
    ValueError
        Where forces have no potential, or laws with history or contacts act.
    NoCriticalPoint
        Where Newton's method does not converge; says what the last corrections were.
    """
    require("critical", kind=(kind or KINDS[0], Annotated[str, Choice(KINDS)]), multiplicity=(multiplicity, Count),
            beside=(beside, Annotated[int, NOT_NEGATIVE]))
    tracer = Tracer(Discretisation(scene), ArcLength(), "sheetfx_") if isinstance(scene, Scene) else tracer_of(scene)
    _require_smooth(tracer)
    spent = tracer.total_factorisations
    tracer.back_to(guess)
    sought = _modes(tracer, guess, mode, multiplicity)
    count = max(len(sought), min(len(sought) + beside, tracer.system.size - 1))
    others = _modes(tracer, guess, None, count) if count > len(sought) else []
    modes = orthonormal(tracer.system.weights, [*sought, *others])[:count]
    newton = _Newton(tracer, guess, modes, len(sought), kind)
    newton.iterate()
    return newton.found(tracer.total_factorisations - spent)


def _require_smooth(tracer: Tracer) -> None:
    system = tracer.system
    if not (system.smooth and system.conservative) or system.history.moved:
        raise ValueError("critical: the structure has contact, history or forces without a potential; follow its path "
                         "to the point")


def _modes(tracer: Tracer, guess: State, mode, multiplicity: int) -> list[PETSc.Vec]:
    """Vectors near the null vectors, orthonormal in the scaled inner product."""
    system = tracer.system
    if mode is None:
        tracer.factorise_at(guess)
        return tracer.spectrum(multiplicity)[1][:multiplicity]
    mode = getattr(mode, "mode", mode)
    given = [mode] if isinstance(mode, np.ndarray) and mode.ndim == 1 else [getattr(m, "mode", m) for m in mode]
    size = len(system.create_vector().array)
    vectors = []
    for values in given:
        if np.shape(values) != (size,):
            raise ValueError(f"critical: a mode has {np.size(values)} increments and the structure {size}; give modes "
                             "of this scene")
        vectors.append(system.create_vector(np.asarray(values, dtype=float)))
        vectors[-1].array[system.fixed_rows] = 0
    found = orthonormal(system.weights, vectors)
    if len(found) < len(vectors):
        raise ValueError("critical: a mode has no free increments, or is a sum of the others; leave it out")
    return found


class _Newton:
    """Newton's method about a guess."""

    def __init__(self, tracer: Tracer, guess: State, modes: list[PETSc.Vec], sought: int, kind: str | None):
        self._tracer, self._system, self._guess, self._kind = tracer, tracer.system, guess, kind
        self._modes, self._sought = modes, np.arange(sought)
        self._energy = Energy(tracer)
        self._x, self._factor = tracer.x, guess.factor
        self._residual, self._load = self._system.create_vector(), self._system.create_vector()
        self._iterations: list[Iteration] = []
        self._forces = np.zeros(len(modes))
        self._system.extrapolate_stress()
        self._system.tangent()
        self._springs, self._least = pivots(modes, self._system.weights), usual_stiffness(tracer.discretisation)

    def iterate(self) -> None:
        """Correct until a further correction would be rounding.

        Raises
        ------
        NoCriticalPoint
        """
        with self._system.additive_increments():
            for _ in range(ITERATIONS):
                try:
                    step, change = self._correction()
                    self._go(step, change)
                except (SingularTangent, np.linalg.LinAlgError):
                    raise self._failure("the tangent with its border is singular") from None
                if self._is_last(change):
                    return
        raise self._failure(f"{len(self._iterations)} iterations do not converge")

    def _go(self, step: PETSc.Vec, change: float) -> None:
        """Go along a step, and correct the state off the modes: a long step strains stiff parts.

        The factor that there is does where its correction is less than half of the step (Deuflhard 2011, Newton
        Methods, section 2.1.2); else Newton's method with stresses that follow the step linearly, until it does.
        """
        start, size = (self._x.copy(), self._factor), self._tracer.distance(0.0, step.array)
        self._factor += change
        self._system.retract(self._x, step)
        more = self._off_modes()
        if self._tracer.distance(0.0, more.array) <= size / 2:
            self._system.retract(self._x, more)
            return
        start[0].copy(self._x)
        self._system.configure(self._x, start[1])
        for _ in range(ITERATIONS):
            self._system.extrapolate_stress(step)
            self._system.retract(self._x, step)
            self._system.configure(self._x, self._factor)
            self._factorise()
            step, before = self._off_modes(), self._tracer.distance(0.0, step.array)
            if self._tracer.distance(0.0, step.array) <= before / 2:
                break
        self._system.retract(self._x, step)

    def _off_modes(self) -> PETSc.Vec:
        """Newton's correction that keeps the load factor and the amplitudes of the modes."""
        self._system.configure(self._x, self._factor)
        self._system.residual(self._residual)
        (step,), _ = self._bordered.solve([-1.0 * self._residual], np.zeros((1, len(self._modes))))
        return step

    def _factorise(self) -> None:
        """Factor the tangent with the stresses that are set."""
        border = [self._system.weights * mode for mode in self._modes]
        self._system.tangent()
        self._bordered = BorderedSolver(self._tracer.stepper.linear, self._springs, self._least)
        self._bordered.border(border, border)

    def _is_last(self, change: float) -> bool:
        """Whether the next correction, the square of this one, is less than the error that is allowed."""
        exact = self._tracer.control.exact
        return abs(change) <= exact**0.5 * abs(self._factor) and self._iterations[-1].correction <= exact**0.5 * 0.1

    def _failure(self, why: str) -> NoCriticalPoint:
        said = "; ".join(map(str, self._iterations))
        self._tracer.back_to(self._guess)
        return NoCriticalPoint(f"critical: {why} from load {self._guess.load:.6g} ({said}); give a guess closer to the "
                               "point, its mode or kind, or more modes beside")

    def _correction(self) -> tuple[PETSc.Vec, float]:
        """Newton's step of the unknowns and of the load factor."""
        system, count = self._system, len(self._modes)
        system.configure(self._x, self._factor)
        system.residual(self._residual)
        system.load(self._load)
        load = self._tracer.discretisation.total_load()
        system.extrapolate_stress()
        self._factorise()
        bordered = self._bordered
        vectors, numbers = bordered.solve([], np.eye(count))
        matrix = -(numbers + numbers.T) / 2
        (left, loaded), (held, pushed) = bordered.solve([-1.0 * self._residual, self._load], np.zeros((2, count)))
        values, turned = np.linalg.eigh(matrix)
        self._sought = np.sort(np.argsort(-np.linalg.norm(turned[self._sought], axis=0))[:len(self._sought)])
        modes = [_combined(vectors, column) for column in turned.T]
        held, pushed = held @ turned, pushed @ turned
        self._kind = self._kind or self._likely(values, pushed, modes, loaded)
        change, shares = self._solved(values, modes, left, loaded, held, pushed)
        self._forces = np.zeros(count)
        if self._kind == "bifurcation":
            self._forces[self._sought] = (values * shares - held - pushed * change)[self._sought]
        step = left + change * loaded + _combined(modes, shares)
        self._iterations.append(Iteration(load, self._tracer.distance(0.0, step.array), tuple(values[self._sought])))
        self._modes = orthonormal(system.weights, modes)
        return step, change

    def _likely(self, values, pushed, modes, loaded) -> str:
        """Whether the response to the load, loaded + sum of mode pushed / value, is along the sought mode or not."""
        if len(self._sought) > 1:
            return "bifurcation"
        (n,), shares = self._sought, pushed / values
        rest = loaded + _combined(modes, np.where(np.arange(len(values)) == n, 0.0, shares))
        along = abs(shares[n]) * self._tracer.distance(0.0, modes[n].array)
        return "limit" if along > self._tracer.distance(0.0, rest.array) else "bifurcation"

    def _solved(self, values, modes, left, loaded, held, pushed) -> tuple[float, np.ndarray]:
        """Changes of the load factor and of the modes' amplitudes.

        The state changes by left + change * loaded + sum of shares * modes.
        """
        along_path = self._third(modes, loaded, 1.0)
        matrix, right = np.column_stack((-pushed, np.diag(values))), held.copy()
        rates = np.zeros((len(self._sought), len(values) + 1))
        here = np.zeros(len(self._sought))
        for row, n in enumerate(self._sought):
            bent = self._third(modes, modes[n])
            rates[row] = [modes[n].dot(along_path[n]), *(mode.dot(bent[n]) for mode in modes)]
            here[row] = values[n] + left.dot(bent[n])
            if self._kind == "bifurcation":
                matrix[n] = [-loaded.dot(along_path[n]), *(-mode.dot(along_path[n]) for mode in modes)]
                right[n] = left.dot(along_path[n]) - pushed[n]
        solution = np.linalg.solve(np.vstack((rates.mean(axis=0), matrix)), [-here.mean(), *right])
        return float(solution[0]), solution[1:]

    def _third(self, modes: Sequence[PETSc.Vec], along: PETSc.Vec, load: float = 0.0) -> list[PETSc.Vec]:
        """Change of the Hessian's products with modes along an increment of unknowns and load factor, from here."""
        return self._energy.third(modes, along, load, about=(self._x, self._factor))

    def found(self, factorisations: int) -> Critical:
        """The point that the iterations have led to; the tracer ends there."""
        tracer, guess = self._tracer, self._guess
        weighted = _combined([self._system.weights * mode for mode in self._modes], self._forces)
        unfolding = weighted.norm() / (abs(self._factor) * self._load.norm())
        state = tracer.accept(self._factor - guess.factor, len(self._iterations))
        point = CriticalPoint(self._kind, state.load, state.deflection, state.step, name="",
                              multiplicity=len(self._sought))
        nulls = [self._modes[n] for n in self._sought]
        if self._kind == "bifurcation":
            tracer.factorise_at(state)
            values, modes = tracer.spectrum(len(self._modes) + 1)
            nulls = [modes[i] for i in np.argsort(np.abs(values))[:len(self._sought)]]
            point = postbuckling(tracer, state, nulls, point, [guess, guess])
        modes = tuple(scaled(tracer.discretisation, mode) for mode in nulls)
        return Critical(point, state, modes, unfolding, tuple(self._iterations), factorisations)


def _combined(vectors: Sequence[PETSc.Vec], factors) -> PETSc.Vec:
    total = vectors[0].duplicate()
    total.maxpy(list(map(float, factors)), list(vectors))
    return total
