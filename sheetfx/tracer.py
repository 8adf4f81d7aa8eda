"""Steps along a path from one converged state to the next, and back."""

from __future__ import annotations

from math import acos, sqrt

import numpy as np
from petsc4py import PETSc

from .discretise import Discretisation
from .solve.arclength import PathStep
from .solve.control import StepRule, Tangent
from .solve.linear import SingularTangent
from .state import State


class Tracer:
    """Takes single steps from the current state with a SNES, and returns to earlier states."""

    def __init__(self, discretisation: Discretisation, control: StepRule, prefix: str):
        self.discretisation, self.system, self.control = discretisation, discretisation.system, control
        self.snes = PETSc.SNES().create(self.system.comm)
        self.snes.setOptionsPrefix(prefix)
        self.stepper = PathStep()
        self.snes.setType("python")
        self.snes.setPythonContext(self.stepper)
        self.stepper.attach(self.snes, self.system)
        self.x = self.system.create_vector()
        self._unit, self._load, self._last = (self.system.create_vector() for _ in range(3))
        self._functional = self._monitor()
        self._reference: tuple[float, float] | None = None
        self.iterations = 0
        discretisation.commit()
        try:
            self.state = self._converged(0, 0.0, 0, 0.0, 0)
        except SingularTangent:
            raise ValueError(
                "the unloaded structure can move freely (its tangent is singular): check that the supports "
                "hold all rigid motions of every part") from None

    @property
    def total_factorisations(self) -> int:
        return self.stepper.linear.factorisations

    def _monitor(self) -> PETSc.Vec:
        """Vector whose product with increments is the monitored displacement."""
        block, dofs = self.discretisation.monitored(self.discretisation.scene.monitor)
        vector, offset = self.system.create_vector(), 0
        for b in self.discretisation.unknowns.blocks:
            if b is block:
                break
            offset += b.space.dofmap.index_map.size_local * b.space.dofmap.index_map_bs
        vector.array[offset + dofs] = self.discretisation.scene.monitor.sign
        return vector

    def attempt(self, length: float) -> State | None:
        """Try one step of a given length from the current state; None if it does not converge."""
        start, before = self.state, self.total_factorisations
        load_increment = self.control.predict(length, self.sign, self.tangent)
        self.stepper.begin(self.control, self.tangent, length, load_increment)
        most = 0

        def correct() -> bool:
            nonlocal most
            self.snes.solve(None, self.x)
            self.stepper.continue_step()
            self.iterations += self.snes.getIterationNumber()
            most = max(most, self.snes.getIterationNumber())
            return self.snes.getConvergedReason() > 0

        if not self.discretisation.enforcement.solve(correct):
            return self._undo(start)
        deflection = start.deflection + self._functional.dot(self.x)
        self.discretisation.commit()
        try:
            self.state = self._converged(start.step + 1, deflection, most, length, before)
        except SingularTangent:
            self.back_to(start)
            return None
        return self.state

    def _undo(self, start: State) -> None:
        self.system.factor = start.factor
        self.x.zeroEntries()
        self.system.configure(self.x)

    def reason(self) -> str:
        """Why the last attempt failed."""
        names = {v: k for k, v in vars(PETSc.SNES.ConvergedReason).items() if isinstance(v, int)}
        return names.get(self.snes.getConvergedReason(), "contact augmentation did not converge")

    def back_to(self, state: State) -> None:
        """Return to an earlier state of this path."""
        self.discretisation.restore(state.fields)
        self.system.factor = state.factor
        self.stepper.load_increment = state.load_increment
        self._reference = state.reference
        self.x.array[:] = state.increment
        self._converged(state.step, state.deflection, state.iterations, state.length, self.total_factorisations)
        self.state = state

    def _converged(self, step, deflection, iterations, length, factorisations) -> State:
        """Factor the tangent of the last converged configuration and describe it.

        On entry the solver's vector holds the increment that led to it.
        """
        system = self.system
        self._last.array[:] = self.x.array
        self.x.zeroEntries()
        system.configure(self.x)
        self._respond()
        tangent, weight = self.tangent, self._load_weight()
        load_increment = self.stepper.load_increment if step else 0.0
        along = tangent.inner(self._last, self._unit) + weight * load_increment
        self.sign = -1.0 if step and along < 0 else 1.0
        pivots = self.stepper.linear.negative_pivots()
        states = [self.discretisation.enforcement.state(c) for c in self.discretisation.contacts]
        touching = sum(int((s.status != "open").sum()) for s in states)
        penetration = [self.discretisation.enforcement.penetration(c, s)
                       for c, s in zip(self.discretisation.contacts, states, strict=True)]
        return State(
            step=step, factor=system.factor,
            load=self.discretisation.total_load(), deflection=deflection,
            unstable=None if pivots is None else pivots - system.multipliers,
            load_rate=self.sign / sqrt(tangent.norm2 + weight),
            iterations=iterations, factorisations=self.total_factorisations - factorisations,
            length=length, next_length=length or self.control.first, load_increment=load_increment,
            reference=self._reference, contact_points=system.comm.allreduce(touching),
            penetration=max(penetration, default=0.0),
            increment=self._last.array.copy(), fields=self.discretisation.snapshot())

    def _load_weight(self) -> float:
        weight = getattr(self.control, "load_weight", None)
        return weight(self.tangent) if weight else 0.0

    def _respond(self) -> None:
        """Response of the converged state to a unit of load."""
        system = self.system
        system.extrapolate_stress()
        self.stepper.factor(self.snes, self.x)
        system.load(self._load)
        with system.clock("solve"):
            self.stepper.linear.solve(self._load, self._unit)
        work = self._load.dot(self._unit)
        tangent = Tangent(self._unit, system.weights, self._functional)
        if self._reference is None:
            self._reference = tangent.norm2, work
        tangent.initial_norm2 = self._reference[0]
        tangent.current_stiffness = self._reference[1] / work if work else 1.0
        self.tangent = tangent

    def turn(self, before: State) -> float:
        """Angle between the last step's increment and the increment before it, in load-displacement space."""
        vector = self._last
        inner = self.tangent.inner
        earlier = self.system.create_vector()
        earlier.array[:] = before.increment
        weight = self._load_weight()
        a = inner(vector, vector) + weight * self.state.load_increment**2
        b = inner(earlier, earlier) + weight * before.load_increment**2
        ab = inner(vector, earlier) + weight * self.state.load_increment * before.load_increment
        return acos(np.clip(ab / sqrt(a * b), -1.0, 1.0)) if a * b else 0.0
