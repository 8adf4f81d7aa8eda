"""Steps along a path from one converged state to the next, and back."""

from __future__ import annotations

from dataclasses import replace
from math import copysign, inf, sqrt
from typing import cast

import numpy as np
from petsc4py import PETSc

from ..discrete.free_motions import usual_stiffness
from ..discrete.functional import Functional
from .callbacks import interruptible
from .control import DisplacementControl, LoadResponse, StepRule, weight_where_nothing_moves
from .corrector import FLOWS_TO_AND_FRO, TO_AND_FRO, create, fewer_iterations
from .enforcement import Enforcement
from .first_state import PROBE, FirstState
from .inertia import Uncounted, UnstableModes, first_critical
from .linear import SingularTangent
from .problem import Problem
from .spectrum import diagonal, nearest_to_zero
from .state import State

NEAR = 1e-9  # of a step, distance of a state from where the tangent was factored that serves as its own


class Tracer(FirstState):
    """Takes single steps from the current state with a SNES, and returns to earlier states.

    Attributes
    ----------
    usual, first : lengths of the first step in general, and here
    shortest : length of which the shortest step allowed is a part
    softest : state at the end of a step, its eigenvalues nearest to zero and their rates; None: none are known
    """

    def __init__(self, discretisation: Problem, control: StepRule, prefix: str):
        self.discretisation, self.system, self.control = discretisation, discretisation.system, control
        self.snes = create(self.system.comm, self.system, prefix, control.iterations_allowed)
        self.stepper = self.snes.getPythonContext()
        self.enforcement = Enforcement(self.system)
        self._elimination = self.enforcement.elimination(self.stepper.linear)
        self.x = self.system.create_vector()
        self._response, self._load = self.system.create_vector(), self.system.create_vector()
        self._monitor = discretisation.functional()
        self.tangent = LoadResponse(self._response, self.system.weights, self._controlled(control))
        self._reference: tuple[float, float] | None = None
        self._stuck: State | None = None
        self.iterations, self._most, self.failure = 0, 0, ""
        self._factored: tuple[np.ndarray | None, int] = None, 0
        self.softest: tuple[State | None, list[tuple[float, float]]] = None, []
        self._count = UnstableModes(self.system, self.stepper.linear)
        self.system.history.rebase()
        if first := self._at_first(0):
            self.system.factors.enter(0, first)
        try:
            self.state = self._converged(None)
            self._load.array[:] = np.cos(np.arange(self._load.local_size))
            self._load.array[self.system.multiplier_rows] = 0  # gaps of such a size would need forces that only round
            self.stepper.linear.check(self._load, usual_stiffness(discretisation))
        except SingularTangent:
            raise ValueError(discretisation.why_singular()) from None
        self._mark_factored(moved=False)
        self._balance()
        self._look_ahead()
        self._choose_first_length()
        self.state = replace(self.state, next_length=self.first)

    @property
    def total_factorisations(self) -> int:
        return self.stepper.linear.factorisations

    def rate(self, name: str) -> float:
        """Change of the monitored "deflection", or of the "load", by a unit of the load factor; 0: not known."""
        if name == "deflection":
            return self.monitored_rate(self._response)
        return self.discretisation.load_of_unit() or 0.0

    def attempt(self, length: float, guess: tuple[float, np.ndarray] | None = None, part: float = 1.0) -> State | None:
        """Try one step of a given length from the current state; None if it does not converge.

        Parameters
        ----------
        guess : increments of the load factor and of the unknowns (this process's part) to begin with
        part : of the iterations that a step is given
        """
        with fewer_iterations(self.snes, part):
            return self._attempted(self.control, self.tangent, length, guess)

    def attempt_along(self, solution: PETSc.Vec, sign: float, length: float) -> State | None:
        """Try one step along a response to the load, or back along it, that is not the one of the current state."""
        return self._attempted(self.control, replace(self.tangent, solution=solution), length, sign=sign)

    def attempt_by(self, control: StepRule, length: float) -> State | None:
        """Try one step by another control, of the monitored displacement where it is one of displacements.

        It is given half as many iterations as others.
        """
        tangent = replace(self.tangent, functional=self._monitor)
        with fewer_iterations(self.snes, 1 / 2):
            found = self._attempted(control, tangent, length)
        if found is not None:
            x = self.system.create_vector(found.increment)
            self.state = replace(found, length=self.control.measure(self.tangent, x, found.load_increment))
            self._mark_factored()
            return self.state
        return None

    def _attempted(self, control: StepRule, tangent: LoadResponse, length: float,
                   guess: tuple[float, np.ndarray] | None = None, sign: float | None = None) -> State | None:
        start, before, spent = self.state, self.total_factorisations, self.iterations
        self._count.start_from(start, self.x)
        anew, again = self.control.newton == "full", self._stuck is start
        for eliminates, multiples in self.enforcement.approaches(anew, again, not start.length):
            self._most, self.failure, self.stepper.patient = 0, "", again and not start.length and len(multiples) > 1
            self.stepper.elimination = self._elimination if eliminates else None
            if eliminates:
                self._elimination.begins = not start.length
                self.factorise_at(start)
            first = guess or (control.predict(length, sign or control.direction(start), tangent),)
            self.stepper.begin(control, tangent, length, *first, stable=start.unstable_modes == 0)
            if self.enforcement.solve(self.correct, multiples, self.control.augmentations):
                try:
                    factored = self.stepper.behind <= NEAR * self.tangent.inner(self.x, self.x) ** 0.5
                    self.state = self._converged(start, self.iterations - spent, length, before, factored)
                    self._mark_factored()
                    return self.state
                except (SingularTangent, Uncounted) as failure:
                    self.failure = str(failure)
                    self.system.history.rewind()
            self._undo(start)
        self._stuck = start
        return None

    def accept(self, load_increment: float, iterations: int = 0) -> State:
        """Commit the current configuration, which equilibrium was found for by other means than a step.

        Parameters
        ----------
        load_increment : of the load factor since the current state; the increments of the unknowns are those in `x`

        Raises
        ------
        SingularTangent
        """
        before, self.stepper.load_increment, self._most = self.total_factorisations, load_increment, iterations
        self._count.start_from(self.state, self.x)
        self.state = replace(self._converged(self.state, iterations, factorisations=before), next_length=0.0)
        self._mark_factored()
        return self.state

    def settle(self) -> State | None:
        """Come to equilibrium at the same amplitude along the response, from a state that is not in balance.

        It stays the state of its step, on a path that goes on in the same sense. None: it does not converge.
        """
        start, nothing = self.state, np.zeros(self.x.local_size)
        across = replace(self.tangent, functional=Functional(self.system.weights * self._response))
        found = self._attempted(DisplacementControl(), across, 0.0, (0.0, nothing))
        if found is not None:
            modes = start.unstable_modes if found.unstable_modes is None else found.unstable_modes
            self.state = replace(found, step=start.step, load_sense=start.load_sense, unstable_modes=modes,
                                 load_increment=start.load_increment, increment=start.increment,
                                 load_rate=copysign(found.load_rate, start.load_rate), next_length=0.0)
            self._mark_factored()
        return found and self.state

    def adopt(self, increment: np.ndarray, load_increment: float, most: float) -> State | None:
        """Accept increments since the current state if they are in equilibrium, else stay.

        Parameters
        ----------
        increment, load_increment : of the unknowns (this process's part) and of the load factor
        most : residual over the load
        """
        start, residual = self.state, self.system.create_vector()
        self.x.array[:] = increment
        self.system.configure(self.x, start.factor + load_increment)
        self.system.residual(residual)
        self.system.load(self._load)
        size = max(abs(self.system.factor) * self._load.norm(), self.system.reaction)
        try:
            if residual.norm() <= most * size:
                self._count.critical = self.accept(load_increment)
                return self._count.critical
        except (SingularTangent, Uncounted):
            self.system.history.rewind()
        self._undo(start)
        return None

    def enter(self, stage: int, control: StepRule) -> State:
        """Begin a load stage at the current state: its load factor varies from zero, the last one's stays."""
        if control.newton != self.control.newton:
            self.snes.setTolerances(max_it=control.iterations_allowed)
        self.control, self.tangent.functional = control, self._controlled(control)
        before, spent = self.state, self.total_factorisations
        self.system.factors.enter(stage, self._at_first(stage))
        self._reference, self._most = None, 0
        begun = self._converged(None, factorisations=spent)
        self.state = replace(begun, step=before.step + 1, deflection=before.deflection)
        if not self.system.conservative:
            self.state = replace(self.state, unstable_modes=before.unstable_modes)
        self._mark_factored(moved=False)
        if self.system.factor:
            self._balance()
        self._look_ahead()
        self._choose_first_length()
        self.state = replace(self.state, next_length=self.first)
        return self.state

    def _choose_first_length(self) -> None:
        """Have the first step end before the first critical point where its length is not given.

        That point is estimated by the tangent a small way along the response to the load, with the factor that is
        there. With contact, where it says little, the first step is a part of the control's: a long one from no load
        finds states of other paths, which nothing that came before would tell.
        """
        control, system = self.control, self.system
        self.usual = self.first = self.shortest = control.usual(self.discretisation.size)
        if control.guarded and not system.smooth and control.step is None:
            self.first = control.with_contact * self.usual
        if not control.guarded or not system.smooth:
            return
        estimate = first_critical(system, self.stepper.linear, self._response, PROBE / sqrt(
            self.tangent.norm2 + self.tangent.least_weight))
        self.shortest = min(self.usual, control.before_critical * estimate
                            / abs(control.predict(1.0, 1.0, self.tangent)))
        if control.step is None:
            self.first = self.shortest

    def correct(self) -> bool:
        """Solve for the step that has begun, or on from where its last solution ended; whether that converges."""
        with interruptible():
            self.snes.solve(None, self.x)
        self.stepper.continue_step()
        self.iterations += self.snes.getIterationNumber()
        self._most = max(self._most, self.snes.getIterationNumber() + self._elimination.found_since())
        return self.snes.getConvergedReason() > 0

    def factorise_at(self, state: State) -> None:
        """Return to a state and factor its tangent, unless that is the last one factored."""
        if self.state is not state:
            self.back_to(state)
        factored, count = self._factored
        if factored is not state.response or count != self.total_factorisations:
            self._respond()
            self._mark_factored(moved=False)

    def _mark_factored(self, moved: bool = True) -> None:
        """Remember that the last factor belongs to the current state, unless axes of nodes have turned since then."""
        if not (moved and self.system.unknowns.charted):
            self._factored = self.state.response, self.total_factorisations

    def spectrum(self, count: int, tolerance: float = 1e-12) -> tuple[list[float], list[PETSc.Vec]]:
        """Eigenvalues of the last factored tangent nearest to zero in the scaled inner product, and modes."""
        with self.system.clock("solve"):
            values, modes = nearest_to_zero(self.stepper.linear, diagonal(self.system.weights), count, tolerance)
        return values, [self.system.create_vector(mode.array) for mode in modes]

    def load_vector(self) -> PETSc.Vec:
        """Derivative of the external forces with respect to the load factor, in the current state."""
        self.system.load(self._load)
        return self._load.copy()

    def _undo(self, start: State) -> None:
        """Put the fields back to the state that the last attempt started from."""
        self.x.zeroEntries()
        self.system.configure(self.x, start.factor)
        if self.control.newton == "modified":
            self.system.extrapolate_stress()
            self.stepper.factorise(self.snes, self.x)

    def reason(self) -> str:
        """Why the last attempt failed."""
        if self.failure or self.stepper.cycles:
            return self.failure or (TO_AND_FRO if self.system.rough else FLOWS_TO_AND_FRO)
        names = {v: k for k, v in vars(PETSc.SNES.ConvergedReason).items() if isinstance(v, int)}
        return names.get(self.snes.getConvergedReason(), "contact augmentation did not converge")

    def back_to(self, state: State) -> None:
        """Return to an earlier state of this path."""
        self.system.restore(state.fields)
        self._response.array[:] = state.response
        self._reference = state.reference
        self.tangent.initial_norm2, self.tangent.least_weight = state.reference[0], state.least_weight
        self.tangent.current_stiffness = state.current_stiffness
        self._undo(state)
        self.state = state

    def _converged(self, start: State | None, iterations=0, length=0.0, factorisations=0, factored=False) -> State:
        """Describe the current configuration with its tangent, which may be factored already, then commit it."""
        system, tangent = self.system, self.tangent
        softened = system.history.update_history()
        self._respond(factored and not softened)
        weight = self._load_weight()
        load_increment = self.stepper.load_increment if start else 0.0
        extremes = start.displacement_extremes + self._passes_extreme(start) if start else 0
        determinant = self.stepper.linear.determinant_sign()
        determinant = determinant and determinant * (-1) ** system.multipliers
        unstable = self._count.of_present(start, determinant)
        along = tangent.inner(self.x, self._response) + weight * load_increment
        if start and not system.smooth and unstable == 0 == start.unstable_modes:
            along = start.load_rate  # what touches may turn displacements back, but the load of stable states goes on
        sign = -1.0 if start and along < 0 else 1.0
        touching, penetration, apart = self.enforcement.summary()
        increment, deflection = self.x.array.copy(), self.monitored(self.x)
        self.system.history.commit()
        self.x.zeroEntries()
        return State(
            step=start.step + 1 if start else 0, stage=system.factors.stage, factor=system.factor,
            load=self.discretisation.total_load(),
            deflection=start.deflection + deflection if start else self._monitor.initial,
            unstable_modes=unstable, determinant_sign=determinant,
            load_rate=sign / sqrt(tangent.norm2 + weight),
            iterations=iterations, hardest=self._most, factorisations=self.total_factorisations - factorisations,
            length=length, next_length=length, load_increment=load_increment,
            current_stiffness=tangent.current_stiffness, displacement_extremes=extremes,
            reference=cast(tuple[float, float], self._reference), contact_points=touching, penetration=penetration,
            apart=apart and (start is not None or not system.history.moved),
            increment=increment, response=self._response.array.copy(), fields=system.snapshot(),
            scene=getattr(self.discretisation, "scene", None))

    def _load_weight(self) -> float:
        return getattr(self.control, "load_weight", lambda tangent: tangent.least_weight)(self.tangent)

    def _respond(self, factored: bool = False) -> None:
        """Response of the current configuration to a unit of load; its tangent may be factored already."""
        system = self.system
        system.configure(self.x, system.factor)
        if not factored:
            system.extrapolate_stress()
            self.stepper.factorise(self.snes, self.x)
        held = system.load(self._load)
        with system.clock("solve"):
            self.stepper.linear.solve(self._load, self._response)
        only_stressed = self._is_held(held) and (
            self._load_stiffens() if self._reference is None else self.tangent.least_weight > 0)
        if only_stressed:
            self._response.zeroEntries()
        work = self._load.dot(self._response)
        if self._reference is None:
            if self.tangent.norm2 != self.tangent.norm2:
                raise SingularTangent("the tangent has no numbers")
            if not (only_stressed or self.tangent.norm2 > 0):
                raise ValueError(self.discretisation.unresponsive)
            self.tangent.least_weight = weight_where_nothing_moves() if only_stressed else 0.0
            self._reference = (self.tangent.least_weight, 0.0) if only_stressed else (self.tangent.norm2, work)
        self.tangent.initial_norm2 = self._reference[0]
        self.tangent.current_stiffness = self._reference[1] / work if work else 1.0

    def _passes_extreme(self, start: State) -> bool:
        """Whether the displacement along the load has had an extreme since a state.

        The current stiffness parameter then changes sign through infinity, not through zero as at an extreme of the
        load: its value for the chord of the step lies beyond those at both ends.
        """
        ends, work_of_first = (start.current_stiffness, self.tangent.current_stiffness), start.reference[1]
        work = self._load.dot(self.x)
        chord = self.stepper.load_increment * work_of_first / work if work else inf
        return ends[0] * ends[1] < 0 and not min(ends) < chord < max(ends)


def tracer_of(path) -> Tracer:
    """The tracer of a Path, or the Tracer given."""
    return getattr(path, "tracer", path)
