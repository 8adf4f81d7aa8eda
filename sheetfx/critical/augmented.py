"""Critical points found directly, by Newton's method for state, load and null vectors together.

The equations are in `critical.defining`. Both systems are regular at simple points, so that Newton's method
converges quadratically; at points of several modes together their mean is sought, which symmetry makes regular too.
Close to other points the tangent is nearly singular in modes that are not sought: they belong to the border. Where the
tangent of the solution has other null vectors as well, Newton's method goes on with all of them.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Annotated, cast

import numpy as np
from petsc4py import PETSc

from .. import rounding
from ..checks import NOT_NEGATIVE, Choice, Count, require
from ..continuation.control import ArcLength
from ..continuation.linear import SingularTangent
from ..continuation.state import CriticalPoint, State
from ..continuation.tracer import Tracer, tracer_of
from ..discrete.discretisation import Discretisation
from ..events.determinant import orthonormal
from ..model.scene import Scene
from .defining import DefiningSystem, combined, without_third_variations
from .koiter import postbuckling
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
    unfolding : norm of the forces along the null vectors that hold the state, over the load's norm; at a bifurcation
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


def load_within(tracer: Tracer, guess: State, modes: Sequence[np.ndarray], kind: str,
                share: float) -> tuple[float, float]:
    """Load of the critical point next to a guess, but for a share of the difference between both loads.

    Parameters
    ----------
    tracer, guess, modes, kind : as of `critical`; it ends at some state

    Returns
    -------
    The load, and how much of the modes there lies in the given ones: the smallest cosine between both spaces

    Raises
    ------
    ValueError, NoCriticalPoint
        As `critical`.
    """
    _require_smooth(tracer)
    tracer.back_to(guess)
    given = _given(tracer, modes)
    newton = _Newton(tracer, guess, given, len(given), kind)
    load = newton.load_within(share)
    weighted = [tracer.system.weights * mode for mode in given]
    found = [[w.dot(mode) for mode in newton.sought_modes] for w in weighted]
    return load, float(np.linalg.svd(np.array(found), compute_uv=False)[-1])


def critical(scene, guess: State, mode: np.ndarray | Sequence[np.ndarray] | None = None, *,
             kind: str | None = None, multiplicity: int = 1, beside: int | None = None) -> Critical:
    """The critical point next to a guess, without a path up to it.

    Parameters
    ----------
    scene : Scene, or a Path of it, that the guess is a state of
    guess : state near the point
    mode : increments near the null vector, this process's part, or a BucklingLoad or Branch with them; several near
        those of a multiple point; None: the modes of the guess's tangent that are nearest to zero
    kind : "limit" or "bifurcation"; None: a limit point where the response of the guess to the load is for the greater
        part along the mode
    multiplicity : number of modes where none are given; the point that is found may have more
    beside : number of further modes in the border, the guess's nearest to zero: as many as there are
        other points close to the one that is sought; None: none beside given modes, else those whose eigenvalues differ
        from the sought one's by no more than its own size

    Raises
    ------
    ValueError
        Where forces have no potential, or laws with history or contacts act.
    NoCriticalPoint
        Where Newton's method does not converge, which says what the last corrections were, or several modes do not
        become singular at one load.
    """
    require("critical", kind=(kind or KINDS[0], Annotated[str, Choice(KINDS)]), multiplicity=(multiplicity, Count),
            beside=(beside or 0, Annotated[int, NOT_NEGATIVE]))
    tracer = Tracer(Discretisation(scene), ArcLength(), "sheetfx_") if isinstance(scene, Scene) else tracer_of(scene)
    _require_smooth(tracer)
    spent = tracer.total_factorisations
    tracer.back_to(guess)
    given = _given(tracer, mode) if mode is not None else []
    modes, count = given, len(given) or multiplicity
    if beside or not given:
        modes = orthonormal(tracer.system.weights, [*given, *_softest(tracer, guess, count, beside, kind)])
    newton = _Newton(tracer, guess, modes, count, kind)
    state, nulls = newton.solution()
    while len(nulls) > newton.multiplicity:
        newton = _Newton(tracer, state, orthonormal(tracer.system.weights, [*nulls, *newton.modes]), len(nulls),
                         newton.kind)
        state, nulls = newton.solution()
    if len(nulls) < newton.multiplicity:
        tracer.back_to(guess)
        raise NoCriticalPoint(
            f"critical: near load {state.load:.6g} the tangent has {len(nulls)} null vectors and not "
            f"{newton.multiplicity}, with eigenvalues {newton.eigenvalues}; ask for fewer, with the others beside, or "
            "for the other kind")
    return newton.named(state, nulls, guess, tracer.total_factorisations - spent)


def _require_smooth(tracer: Tracer) -> None:
    if why := without_third_variations(tracer.system):
        raise ValueError(f"critical: the structure has {why}; follow its path to the point")


def _softest(tracer: Tracer, guess: State, sought: int, beside: int | None, kind: str | None) -> list[PETSc.Vec]:
    """Vectors near the sought null vectors, then those beside, from the tangent at the guess.

    Near a limit point that is the response to the load; bifurcations have the modes with eigenvalues nearest to zero
    that the response does not lie along. Beside are modes of points no farther from the sought one than the guess is.
    """
    tracer.factorise_at(guess)
    system, most = tracer.system, max(sought, tracer.system.size - 1)
    response, asked = system.create_vector(guess.response), sought + (2 if beside is None else 1 + beside)
    size = tracer.distance(0.0, response.array)
    along_response = kind == "limit" and sought == 1
    while True:
        values, modes = tracer.spectrum(min(asked, most))
        order = [int(n) for n in np.argsort(np.abs(values))]
        shares = [((system.weights * mode).dot(response) / size) ** 2 for mode in modes]
        if kind == "bifurcation":
            order.sort(key=lambda n: shares[n] > 1 / 2)
        elif along_response:
            order.sort(key=lambda n: shares[n] < max(shares))
        found = [modes[n] for n in order]
        last = tracer.load_vector().dot(response) / size**2 if along_response else values[order[sought - 1]]
        near = [modes[n] for n in order[sought:] if min(abs(values[n]), abs(values[n] - last)) <= abs(last)]
        if beside is not None or len(near) < len(found) - sought or asked >= most:
            break
        asked *= 2
    first = [response] if along_response else found[:sought]
    return first + (near if beside is None else found[sought:sought + beside])


def _given(tracer: Tracer, mode) -> list[PETSc.Vec]:
    """Given modes as vectors, orthonormal in the scaled inner product."""
    system, mode = tracer.system, getattr(mode, "mode", mode)
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
    """Newton's method about a guess, for the first `sought` of some modes.

    Attributes
    ----------
    modes : of the border
    multiplicity : number of those that are sought
    kind : of the point; None: not known yet
    """

    def __init__(self, tracer: Tracer, guess: State, modes: list[PETSc.Vec], sought: int, kind: str | None):
        self._tracer, self._system, self._guess = tracer, tracer.system, guess
        self._x, self._factor, self._zero = tracer.x, guess.factor, 0.0
        self._residual, self._load = self._system.create_vector(), self._system.create_vector()
        self._iterations: list[Iteration] = []
        self._forces, self._left, self._across = np.zeros(len(modes)), 0.0, False
        self._system.extrapolate_stress()
        self._system.tangent()
        self._defining = DefiningSystem(tracer.discretisation, tracer.stepper.linear, modes, sought, kind)

    @property
    def modes(self) -> list[PETSc.Vec]:
        return self._defining.modes

    @property
    def kind(self) -> str | None:
        return self._defining.kind

    @property
    def multiplicity(self) -> int:
        return len(self._defining.sought)

    @property
    def sought_modes(self) -> list[PETSc.Vec]:
        return self._defining.sought_modes

    @property
    def eigenvalues(self) -> str:
        return ", ".join(f"{value:.2e}" for value in self._iterations[-1].eigenvalues)

    def solution(self) -> tuple[State, list[PETSc.Vec]]:
        """The state that the iterations lead to, where the tracer ends, and null vectors of the tangent there.

        Raises
        ------
        NoCriticalPoint
        """
        self._iterate(self._is_last)
        tracer = self._tracer
        state = tracer.accept(self._factor - self._guess.factor, len(self._iterations))
        tracer.factorise_at(state)
        asked = len(self.modes)
        while True:
            asked = min(asked + 1, self._system.size)
            values, modes = tracer.spectrum(asked)
            zero = [n for n in np.argsort(np.abs(values)) if abs(values[n]) <= self._zero]
            if len(zero) < asked or asked == self._system.size:
                self._left = max((abs(values[n]) for n in zero[:self.multiplicity]), default=0.0)
                return state, [modes[n] for n in zero]

    def _iterate(self, is_last: Callable[[float, float], bool]) -> None:
        """Correct until a correction is the last one, by the change of the load factor and by its contraction."""
        with self._system.additive_increments():
            self._relax()
            for _ in range(ITERATIONS):
                try:
                    step, change = self._correction()
                    contraction = self._go(step, change)
                except (SingularTangent, np.linalg.LinAlgError):
                    raise self._failure("ends at a singular tangent") from None
                if is_last(change, contraction):
                    return
        raise self._failure(f"does not converge in {ITERATIONS} iterations")

    def load_within(self, share: float) -> float:
        """Total load of the point, within a share of its difference from the guess's."""
        load = self._tracer.discretisation.total_load

        def is_last(change: float, contraction: float) -> bool:
            before = self._iterations[-1].load
            return contraction * abs(load() - before) <= share * abs(load() - self._guess.load)

        self._iterate(is_last)
        return load()

    def _go(self, step: PETSc.Vec, change: float) -> float:
        """Go along a step, and correct the state off the modes: a long step strains stiff parts.

        The factor that there is does where its correction is less than half of the step (Deuflhard 2011, Newton
        Methods, section 2.1.2); else Newton's method with stresses that follow the step linearly, until it does.

        Returns
        -------
        The correction over the step; 1 where the factor does not do
        """
        start, size = (self._x.copy(), self._factor), self._tracer.distance(0.0, step.array)
        self._factor += change
        self._system.retract(self._x, step)
        more = self._off_modes()
        contraction = self._tracer.distance(0.0, more.array) / max(size, rounding.TINIEST)
        if contraction <= 1 / 2:
            self._system.retract(self._x, more)
            return contraction
        start[0].copy(self._x)
        self._system.configure(self._x, start[1])
        self._settle(step)
        return 1.0

    def _settle(self, step: PETSc.Vec) -> None:
        """Go along a step and on to equilibrium off the modes, with stresses that follow steps linearly."""
        for _ in range(ITERATIONS):
            self._system.extrapolate_stress(step)
            self._system.retract(self._x, step)
            self._system.configure(self._x, self._factor)
            self._defining.factorise()
            step, before = self._off_modes(), self._tracer.distance(0.0, step.array)
            if self._tracer.distance(0.0, step.array) <= before / 2:
                break
        self._system.retract(self._x, step)

    def _relax(self) -> None:
        """Leave a state that interpolation has strained so that its residual is more than the load.

        Its stresses would make the tangent worthless: the first one has none.
        """
        if not self._defining.is_strained(self._x, self._factor):
            return
        self._system.forget_stress()
        self._defining.factorise()
        response = self._system.weights * self._system.create_vector(self._guess.response)
        along = sum(response.dot(mode) ** 2 for mode in self.sought_modes)
        self._across = self.kind == "bifurcation" or (
            self.kind is None and along < self._tracer.distance(0.0, self._guess.response) ** 2 / 2)
        self._settle(self._off_modes())
        self._across = False

    def _off_modes(self) -> PETSc.Vec:
        """Newton's correction that keeps the amplitudes of the modes, and the load factor or the place on the path."""
        if not self._across:
            return self._defining.off_modes(self._x, self._factor)
        self._system.configure(self._x, self._factor)
        self._system.residual(self._residual)
        self._system.load(self._load)
        rights = [-1.0 * self._residual, self._load]
        (step, loaded), _ = self._defining.bordered.solve(rights, np.zeros((2, len(self.modes))))
        along = self._system.weights * loaded
        change = -along.dot(step) / along.dot(loaded)
        self._factor += change
        return step + change * loaded

    def _is_last(self, change: float, contraction: float) -> bool:
        """Whether the next correction of the load, which contracts as the state's did, is less than allowed."""
        if len(self._iterations) < 2:
            return False
        before, last = (iteration.correction for iteration in self._iterations[-2:])
        exact, ahead = self._tracer.control.exact, min(last / before, 1.0)
        return ahead * abs(change) <= exact * abs(self._factor) and last <= exact**0.5 * 0.1

    def _failure(self, why: str) -> NoCriticalPoint:
        said, sizes = "; ".join(map(str, self._iterations)), [i.correction for i in self._iterations]
        self._tracer.back_to(self._guess)
        why = "diverges" if len(sizes) > 1 and sizes[-1] > sizes[0] else why
        return NoCriticalPoint(f"critical: Newton's method {why} from load {self._guess.load:.6g} ({said}); give a "
                               "guess closer to the point, its mode or kind, or more modes beside")

    def _correction(self) -> tuple[PETSc.Vec, float]:
        """Newton's step of the unknowns and of the load factor."""
        self._system.configure(self._x, self._factor)
        load = self._tracer.discretisation.total_load()
        found = self._defining.linearise(self._x, self._factor)
        step, (change,), self._forces = found.solve()
        if self.kind != "bifurcation":
            self._forces[:] = 0.0
        self._zero = max(self._at_same_load(rates[0], rates[1 + n], found.pushed[0, n])
                         for rates, n in zip(found.rates, found.sought, strict=True))
        self._iterations.append(Iteration(load, self._tracer.distance(0.0, step.array),
                                          tuple(found.values[found.sought])))
        return step, change

    def _spread(self, state: State) -> tuple[float, float] | None:
        """Loads between which the point lies where rounding leaves an eigenvalue; None: it is as exact as `exact`."""
        control, share = self._tracer.control, self._left / self._zero
        off = control.same_load * share if self.kind == "bifurcation" else control.exact * share**2
        low, high = sorted((state.load * (1 - off), state.load * (1 + off)))
        return (low, high) if off > control.exact else None

    def _at_same_load(self, rate: float, bent: float, pushed: float) -> float:
        """Size of the sought eigenvalue where the load is the point's: of bifurcations by the option `same_load`.

        At a limit point, by SAFETY times the option `exact`, which the iteration leaves: the eigenvalue changes by
        `bent` a and the load by bent a^2 / (2 pushed) with the amplitude a.
        """
        control, size = self._tracer.control, max(abs(self._factor), abs(self._guess.load_increment))
        if self.kind == "bifurcation":
            return abs(rate) * control.same_load * size
        return (2 * abs(bent * pushed) * rounding.SAFETY * control.exact * size) ** 0.5

    def named(self, state: State, nulls: list[PETSc.Vec], guess: State, factorisations: int) -> Critical:
        """The point that the solution is."""
        tracer = self._tracer
        weighted = combined([self._system.weights * mode for mode in self.modes], self._forces)
        unfolding = weighted.norm() / (abs(self._factor) * tracer.load_vector().norm())
        point = CriticalPoint(cast(str, self.kind), state.load, state.deflection, state.step, name="",
                              multiplicity=len(nulls), spread=self._spread(state))
        if self.kind == "bifurcation":
            point = postbuckling(tracer, state, nulls, point, [guess, guess])
        modes = tuple(scaled(tracer.discretisation, mode) for mode in nulls)
        return Critical(point, state, modes, unfolding, tuple(self._iterations), factorisations)
