"""The corrector of one step of a path, as a SNES type written in Python.

A SNES of `-snes_type python -snes_python_type sheetfx.continuation.corrector.BorderedNewton`; with the prefix of
a path (default `sheetfx_`) the options `-sheetfx_snes_rtol`, `-sheetfx_snes_max_it`,
`-sheetfx_snes_monitor`, those of the KSP and PC, and `-sheetfx_snes_python_type` for a variant of one's
own work as in any SNES.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from math import inf

import numpy as np
from petsc4py import PETSc

from ..compat import NOT_A_NUMBER
from ..discrete.system import System
from ..rounding import SAFETY, residual
from .control import LoadResponse, StepRule
from .elimination import Elimination
from .linear import DirectSolver

Reason = PETSc.SNES.ConvergedReason
SLOW = 0.1  # ratio of a residual to the last iteration's, from which a guess is corrected with a new factor
WRONG = 1e-3  # residual over the load, above which a guess is given up that grows, or steps that lead nowhere
SPARE = 10.0  # of the fall of the residual in an iteration, what one more with the same tangent may leave
UNDAMPED = 5  # iterations, after which half steps are taken where it cycles
VAIN = 5  # iterations, after which a residual that has not fallen to half gives up
SAME = 1e-2  # relative difference of residuals that are the same
TO_AND_FRO = ("contact changes to and fro, as where no equilibrium lies ahead; `record.snap(state, 'displacement')` "
              "finds what the structure falls to")
FLOWS_TO_AND_FRO = "points flow and unload to and fro, as where no equilibrium lies ahead"
FARTHEST = 100.0  # increment in the scaled norm (sizes of the structure, radians), beyond which an iteration is lost


def create(comm, system, prefix: str, iterations: int) -> PETSc.SNES:
    """A SNES of this type with at most so many iterations, and options of the given prefix, for a system."""
    snes = PETSc.SNES().create(comm)
    snes.setOptionsPrefix(prefix)
    snes.setTolerances(rtol=1e-8, atol=0.0, stol=0.0, max_it=iterations)
    snes.setType("python")
    snes.setPythonType(f"{__name__}.BorderedNewton")
    snes.setFromOptions()
    snes.getPythonContext().attach(snes, system)
    return snes


@contextmanager
def fewer_iterations(snes: PETSc.SNES, part: float) -> Iterator[None]:
    """Have a SNES give up after a part of its iterations."""
    _, _, _, most = snes.getTolerances()
    snes.setTolerances(max_it=int(part * most))
    try:
        yield
    finally:
        snes.setTolerances(max_it=most)


class BorderedNewton:
    """Newton iteration on equilibrium and a control equation together.

    Each iteration solves the bordered system with one factorisation and two back-substitutions:
    for the residual and for the load (Batoz and Dhatt 1979). Modified Newton keeps the factor that
    it finds, of the state that the step starts from. A guess is so near that its own factor serves all iterations as
    long as each takes most of the residual away.

    Attributes
    ----------
    rounding : largest residual that was accepted because rounding keeps it from falling
    behind : length of the corrections since the factor at hand was made, of the tangent near a guess; infinite: it was
        not
    elimination : of contact forces from each step; None: they are part of the iteration
    viscosity : of a fluid around the structure, in the inner product's weights, for a step of a slow motion
    flow : increments of the fluid in the step; zero: it rests
    unfinished : increments (this process's part) at which the residual of the last step had no numbers; None: nowhere
    patient : whether it goes on where iterations lead nowhere for long, as where each peels off some points of contact
    """

    system: System
    control: StepRule

    def __init__(self):
        self.history: list[float] = []
        self._corrections: list[float] = []
        self.start = self.load_increment = self.rounding = self.viscosity = self._noise = 0.0
        self.behind, self.patient = inf, False
        self.unfinished: np.ndarray | None = None
        self.elimination: Elimination | None = None

    def attach(self, snes: PETSc.SNES, system: System) -> None:
        """Let the SNES solve this system; called once."""
        self.system = system
        self._residual, self._load = system.create_vector(), system.create_vector()
        self._part, self._step, self._unit, self._answered, self.flow = (system.create_vector() for _ in range(5))
        snes.setFunction(self._evaluate, self._residual)
        snes.setJacobian(lambda snes, x, a, p: self._linearise(), system.matrix)
        self.linear = DirectSolver(snes.getKSP(), system.matrix, system.conservative)

    def _evaluate(self, snes, x, out) -> None:
        self.system.configure(x, self.factor_now)
        self.system.residual(out)
        if self.viscosity:
            out.axpy(self.viscosity, self.system.weights * (x - self.flow))

    def _linearise(self) -> None:
        matrix = self.system.tangent()
        if self.viscosity:
            matrix.setDiagonal(matrix.getDiagonal() + self.viscosity * self.system.weights)

    @property
    def factor_now(self) -> float:
        """The load factor of the present iterate."""
        return self.start + self.load_increment

    def begin(self, control, tangent: LoadResponse, length: float, load_increment: float, guess=None,
              stable: bool = False) -> None:
        """Set the step that the next `solve` takes from the converged state.

        Parameters
        ----------
        load_increment : of the predictor
        guess : increments to begin with, this process's part of the vector, for a solution a thousand times more
            exact than a step's and corrected at least once, since a small residual leaves much of a mode that
            is about to buckle; None: along the tangent
        stable : whether the converged state is known to be
        """
        self.control, self.tangent, self.length = control, tangent, length
        self.start, self.load_increment = self.system.factor, load_increment
        self._predict, self._guess, self._stable, self.behind = True, guess, stable, inf

    def continue_step(self) -> None:
        """Let the next `solve` correct from where the last one ended."""
        self._predict = False

    def solve(self, snes, b, x) -> None:
        self.history, self._corrections, self.unfinished, self._noise = [], [], None, 0.0
        self._tolerance = snes.getTolerances()[0] * (1.0 if self._guess is None else 1e-3)
        if self._predict:
            x.zeroEntries()
            self._step.zeroEntries()
            if self._guess is None:
                self._step.axpy(self.load_increment, self.tangent.solution)
            else:
                self._step.array[:] = self._guess
            self.system.foresee(x, self._step, self.factor_now)
            try:
                self._hold_contacts(x, self.tangent, self._step)
            except ArithmeticError:
                snes.setIterationNumber(0)
                snes.setConvergedReason(Reason.DIVERGED_LINEAR_SOLVE)
                return
            self._move(x, self._step)
        snes.setConvergedReason(self._iterate(snes, x))

    def _iterate(self, snes, x) -> int:
        rtol, most = self._tolerance, snes.getTolerances()[3]
        for iteration in range(most + 1):
            snes.computeFunction(x, self._residual)
            self.system.load(self._load)
            size = max(abs(self.system.factor) * self._load.norm(), self.system.reaction)
            norm = self._residual.norm()
            snes.setIterationNumber(iteration)
            snes.setFunctionNorm(norm)
            snes.monitor(iteration, norm)
            self.history.append(norm / size if size else norm)
            if norm <= rtol * size and (iteration or self._guess is None):
                return Reason.CONVERGED_FNORM_RELATIVE
            if iteration > 1 and self._at_rounding(x):
                self.rounding = max(self.rounding, norm)
                return Reason.CONVERGED_SNORM_RELATIVE
            if norm != norm and np.isfinite(x.norm()):
                self.unfinished = x.array.copy()
            if not np.isfinite(norm) or self.tangent.inner(x, x) > FARTHEST**2:
                return NOT_A_NUMBER
            if iteration == most or self._is_lost():
                return Reason.DIVERGED_MAX_IT
            try:
                self._correct_holding(snes, x)
            except ArithmeticError:
                return Reason.DIVERGED_LINEAR_SOLVE
        return Reason.DIVERGED_MAX_IT

    def _correct_holding(self, snes, x) -> None:
        if self._guess is not None:
            self._correct(snes, x)
            return
        with self.system.held(found=self._eliminating is not None) as holding:
            if holding:
                snes.computeFunction(x, self._residual)
            self._correct(snes, x)

    def _correct(self, snes, x) -> None:
        anew = self._factorise_anew(snes, x)
        with self.system.clock("solve"):
            if anew or len(self.history) == 1 or not self._load.equal(self._answered):
                self.linear.solve_all((self._residual, self._load), (self._part, self._unit))
                self._load.copy(self._answered)
            else:
                self.linear.solve(self._residual, self._part)
            self._part.scale(-1)
            tangent = replace(self.tangent, solution=self._unit)
            change, part = self.control.correct(self.length, tangent, x, self.load_increment, self._part)
            damping = self._damping()
            self._step.zeroEntries()
            self._step.axpy(damping * part, self._part)
            self._step.axpy(damping * change, self._unit)
        self.load_increment += damping * change
        if anew and damping == 1:
            self._hold_contacts(x, tangent, x)
        self._corrections.append(self.tangent.inner(self._step, self._step) ** 0.5)
        self.behind += self._corrections[-1]
        self._move(x, self._step)

    def _factorise_anew(self, snes, x) -> bool:
        """Factor the tangent of the iterate, unless the one at hand serves on."""
        if self._guess is None:
            anew = self.control.newton == "full" and not self._is_near
        else:
            anew = len(self.history) == 1 or (self.history[-1] > SLOW * self.history[-2] and not (
                self._is_fresh and self._residual.norm() <= residual(self.system, x)))
        if anew:
            if self._guess is not None:
                self.system.extrapolate_stress()
                self.behind = 0.0
            self.factorise(snes, x)
        return anew

    @property
    def _is_fresh(self) -> bool:
        """Whether the last correction was by its own iterate's factor, or a step's."""
        return self._guess is None or self.behind <= self._corrections[-1]

    @property
    def _is_near(self) -> bool:
        """Whether the last iterate's tangent takes away the rest, as the last correction's size tells."""
        if len(self.history) < 2:
            return False
        before, now = self.history[-2:]
        return SPARE * now**2 <= self._tolerance * before

    @property
    def _eliminating(self) -> Elimination | None:
        """What finds contact forces from a step, until they are nearly exact, and where plain steps are in vain.

        Where parts rub it does so throughout: plain steps would slip back and forth.
        """
        if self.elimination is None or not self.history or self.elimination.throughout:
            return self.elimination
        in_vain = len(self.history) > 2 and 2 * self.history[-1] > self.history[-3]
        return self.elimination if self.history[-1] > self.elimination.exact or in_vain else None

    def _hold_contacts(self, x, tangent: LoadResponse, along) -> None:
        """Change a step, with `load_increment` at its end, so that contacts hold after it; the control's is `along`.

        They do so as exactly as equilibrium at its start at least; throughout, to a part of what it leaves (a forcing
        term: Dembo, Eisenstat and Steihaug 1982).
        """
        if elimination := self._eliminating:
            self.system.load(self._load)
            size = max(abs(self.factor_now) * self._load.norm(), self.system.reaction)
            left = self.history[-1] if self.history else inf
            exact = (max(elimination.exact * min(left, 1.0), self._tolerance) if elimination.throughout
                     else min(elimination.exact, left))
            held = [self.control.gradient(tangent, along, self.load_increment)]
            if held[0][0] is not None and self._gives_way(tangent):
                held.append((self._load, 0.0))
            self.load_increment += elimination.correct(x, self.factor_now, self._step, tangent.solution, held, size,
                                                       exact)

    def _gives_way(self, tangent: LoadResponse) -> bool:
        """Whether places where something presses give way to that, the work of the loads being held.

        Where the control's measure is held they may move against it, as loads rise for that (Bathe and Dvorkin 1983).
        """
        return self._stable and self._load.dot(tangent.solution) > 0

    def _at_rounding(self, x) -> bool:
        """Whether the residual is rounding: as small as that may be, no longer falling, and nothing left to correct.

        The last correction is within the tolerance, or no less than the one before. Axial forces of slender beams round
        to more than bending leaves while corrections still bend them.
        """
        (before, now), (longer, last) = self.history[-2:], self._corrections[-2:]
        if before >= SAFETY * now or not self._is_fresh:
            return False
        still = last <= self._tolerance * self.tangent.inner(x, x) ** 0.5 or longer < SAFETY * last
        if still:
            self._noise = residual(self.system, x)
        return still and self._residual.norm() <= self._noise

    @property
    def rounds(self) -> bool:
        """Whether a residual that rounding can explain is too large beside the load."""
        size = max(self._load.norm(), self.system.reaction)
        return self._residual.norm() <= self._noise and self._noise >= WRONG * size

    def _is_lost(self) -> bool:
        """Whether what began with a guess leads away from it, or Newton's steps have long led nowhere."""
        if self._guess is not None:
            return len(self.history) > 1 and self.history[-1] > max(WRONG, self.history[-2])
        before, last = self.history[:-VAIN], self.history[-VAIN:]
        newton = self.control.guarded and self.control.newton == "full" and not self.patient
        vain = bool(before) and 2 * min(last) > min(before) > WRONG
        return newton and (vain or self.cycles)

    @property
    def cycles(self) -> bool:
        """Whether two residuals in turn come again in spite of half steps, as between two sets of contact points."""
        damped = np.array(self.history[UNDAMPED:])
        if self.system.smooth or len(damped) < 4:
            return False
        last = damped[-2:]
        return bool((np.abs(np.column_stack((damped[:-3], damped[1:-2])) - last) < SAME * last).all(axis=1).any())

    def _damping(self) -> float:
        """Half steps where the iteration cycles, as between two sets of contact points."""
        cycling = len(self.history) > UNDAMPED and self.history[-1] > 0.9 * self.history[-3]
        return 0.5 if cycling else 1.0

    def factorise(self, snes, x) -> None:
        """Assemble and factor the tangent of the current configuration."""
        snes.computeJacobian(x, self.system.matrix)
        with self.system.clock("factorisation"):
            self.linear.factorise()

    def _move(self, x, step) -> None:
        if self._guess is None:
            self.system.extrapolate_stress(step)
        with self.system.clock("solve"):
            self.system.retract(x, step)
