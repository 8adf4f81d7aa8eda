"""Viscous fall from where no equilibrium lies ahead, or from an unstable one, of structures with friction.

Friction has no energy that could be descended. A structure in a viscous fluid moves with W dx/dt = -R; an implicit step

    R(x) + viscosity W (x - x before) = 0

is solved as a step of a path is, and then accepted: what has slipped by then has taken its work. The viscosity, one
over the length of the step in time, falls as long as steps converge and stay short, until equilibrium is found.

With a viscosity below the growth of the mode that the structure leaves along, a step can lead back to the unstable
equilibrium, or past it. So a push along the mode is so short that it gives energy, and each step must begin down the
forces and give energy. That is the integral of all forces along the motion, those of the held load and of friction
included: what the fluid takes. Forces of contact change within a small part of a step, so that their work comes from
its closed form (`Contribution.work_between`) where there is one.

With friction a mode may grow at once as pairs begin to slip, so that its eigenvalue lies far below zero, and in that
sense only in which they slip on.
"""

from __future__ import annotations

from dataclasses import replace
from math import copysign

from petsc4py import PETSc

from ..continuation.control import DisplacementControl, LoadControl
from ..continuation.spectrum import diagonal, nearest_to_zero
from ..continuation.state import State
from ..discrete.functional import Functional
from .descent import AMPLITUDE, LARGEST_SHIFT, MOST, NEARLY_CRITICAL, POOR, SMALLEST_PART, Fall, SnapFailure, unstable

PUSH = 1e-3  # of the load, by which it changes where the state is stable, or that moves what is held in proportion
FARTHEST = 0.05  # of any step, in the scaled norm
CALMER, FASTER = 4.0, 4.0  # factors on the viscosity after steps that fail and that converge
FIRST = 2.0  # viscosity over the growth of the mode that the structure leaves along: with 1 a step has no end
SHORTER = 4.0  # a push, than the one before that takes energy
ROUNDING = 1e-6  # of the energy given so far, energy that steps may take by rounding
LOOKS = 8  # for modes that grow, each farther from zero


class ViscousFall(Fall):
    """Damped motion from the current state of a tracer, to a stable one."""

    def run(self) -> None:
        self._rough = [c for c in self.system.contributions
                       if not (c.smooth or c.augments) and c.touch() is not None]
        self._even = [c for c in self.system.contributions if c not in self._rough]
        self._assemble()
        pushed, calmed = self._push(), False
        while len(self.history) <= MOST:
            if not self._move_on(pushed):
                self._shift *= CALMER
                calmed = True
                if self._shift > LARGEST_SHIFT * self._scale:
                    raise SnapFailure(f"snap: no viscosity lets the structure move on at deflection "
                                      f"{self._deflection:.6g}; start from a state nearer to the critical point")
                continue
            pushed = 0.0
            if self._at_rest():
                self._found = super().state()
                if not unstable(self._found, self.hold):
                    return
                self._push()
            elif not calmed:
                self._shift /= FASTER
            calmed = False
        raise SnapFailure(f"snap: no stable state after {MOST} steps from load {self.before.load:.6g}, deflection "
                          f"{self.before.deflection:.6g}; the fall is at deflection {self._deflection:.6g}; follow it "
                          "by a listener")

    def state(self) -> State:
        return replace(self._found, step=self.before.step + 1)

    def _push(self) -> float:
        """Leave an unstable state along its lowest mode; from a stable one, by how much to go on as the path did."""
        tracer, system = self.tracer, self.system
        self._held.assemble()
        growing = unstable(tracer.state, self.hold)
        values, modes = self._modes(growing)
        self._scale = max(abs(values[0]), NEARLY_CRITICAL * abs(values[-1]))
        self._shift = FIRST * self._scale
        if not growing:
            return copysign(PUSH * system.factor, tracer.state.load_rate)
        first = len(self.history) == 1
        for side in (1,) if first else (1, -1):
            for value, mode in zip(values, modes, strict=True):
                if value < 0 and self._gives(value, mode, side * self._sense(mode, first)):
                    return 0.0
        raise SnapFailure(f"snap: the structure resists pushes along its unstable modes at deflection "
                          f"{self._deflection:.6g}; try the other side or a state further on")

    def _gives(self, value: float, mode: PETSc.Vec, sense: float) -> bool:
        """Go a short way along a mode that gives energy; whether there is one, as friction may hold in this sense."""
        length = AMPLITUDE
        while length > SMALLEST_PART * AMPLITUDE:
            self._step.array[:] = sense * length * mode.array
            change = self._work(self._step, 0.0)
            if change < POOR * length**2 * value / 2:
                self._accept(change, 0.0)
                self.system.residual(self._residual)
                return True
            self._back(self.system.factor)
            length /= SHORTER
        return False

    def _modes(self, growing: int) -> tuple[list[float], list[PETSc.Vec]]:
        """Some eigenvalues in ascending order, and modes: all that grow, where they can be found.

        Those may be far from zero behind many others, as friction lets modes grow at once: the shift looks there.
        """
        weights, shift, count = self.system.weights, 0.0, max(growing + 1, 2)
        best: tuple[list[float], list[PETSc.Vec]] | None = None
        mass, unshifted = diagonal(weights), self._held.matrix.getDiagonal()
        for _ in range(LOOKS):
            self._held.matrix.setDiagonal(unshifted + shift * weights)
            try:
                self._held.factorise_matrix()
                values, modes = nearest_to_zero(self._held, mass, count)
            except ArithmeticError:  # none is real there
                if best is None:
                    raise
                break
            farthest, values = max(map(abs, values)), [value - shift for value in values]
            if best is None or values[0] < best[0][0]:
                best = values, [self.system.create_vector(mode.array) for mode in modes]
            if sum(value < 0 for value in values) >= growing:
                break
            shift = farthest + shift
        assert best is not None, LOOKS
        return best

    def _move_on(self, pushed: float) -> bool:
        """One step of the motion, with an increment of the load factor to begin with; whether it is one."""
        tracer, system, x = self.tracer, self.system, self.tracer.x
        stepper, start = tracer.stepper, system.factor
        tangent = replace(tracer.tangent, functional=Functional(self._load.copy()))
        control = LoadControl() if self.hold == "load" else DisplacementControl()
        length = control.measure(tangent, pushed * tangent.solution, pushed)
        x.zeroEntries()
        system.configure(x, start)
        stepper.elimination, stepper.viscosity = None, self._shift
        stepper.begin(control, tangent, length, pushed)
        moved = tracer.enforcement.solve(tracer.correct, [1.0], control.augmentations)
        stepper.viscosity = 0.0
        if moved and self._inner(x, x) <= FARTHEST**2:
            self._step.array[:] = x.array
            increment = stepper.load_increment
            x.zeroEntries()
            system.configure(x, start)
            change, allowed = self._work(self._step, increment), ROUNDING * abs(self._energy)
            if pushed or (change <= allowed and self._residual.dot(self._step) <= allowed):
                self._accept(change, increment)
                self._assemble()
                return True
        self._back(start)
        return False

    def _work(self, way: PETSc.Vec, load_increment: float) -> float:
        starts = [c.touch() for c in self._rough]
        change = self._integral(self._even, way, load_increment)
        return change + sum(c.work_between(start, c.touch()) for c, start in zip(self._rough, starts, strict=True))

    def _accept(self, change: float, load_increment: float) -> None:
        """Accept the end of a step, where the system is, with what has slipped on its way."""
        self._length = self._inner(self._step, self._step) ** 0.5
        self._way += self._length
        self._energy += change
        self._follow(self._step, load_increment)
        self.system.history.commit()

    def _back(self, factor: float) -> None:
        """Return to where increments count from."""
        self.tracer.x.zeroEntries()
        self.system.history.rewind()
        self.system.configure(self.tracer.x, factor)

    def _at_rest(self) -> bool:
        """Whether nothing but a rounded residual is left, which no viscosity keeps so."""
        return self._shift <= self._scale and self._balanced()
