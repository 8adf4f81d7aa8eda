"""Viscous fall from where no equilibrium lies ahead, or from an unstable one, of structures with friction.

Friction has no energy that could be descended. A structure in a viscous fluid moves with W dx/dt = -R; an implicit step

    R(x) + viscosity W (x - x before) = 0

is solved as a step of a path is, and then accepted: what has slipped by then has taken its work. The viscosity, one
over the length of the step in time, falls as long as steps converge and stay short, until equilibrium is found.
"""

from __future__ import annotations

from dataclasses import replace
from math import copysign

from ..continuation.control import DisplacementControl, LoadControl
from ..continuation.state import State
from .descent import AMPLITUDE, LARGEST_SHIFT, MOST, NEARLY_CRITICAL, Fall, SnapFailure, unstable

PUSH = 1e-3  # of the load, by which it changes where the state is stable, or that moves what is held in proportion
FARTHEST = 0.05  # of any step, in the scaled norm
CALMER, FASTER = 8.0, 4.0  # factors on the viscosity after steps that fail and that converge


class ViscousFall(Fall):
    """Damped motion from the current state of a tracer, to a stable one."""

    def run(self) -> None:
        self._assemble()
        pushed = self._push()
        while len(self.history) <= MOST:
            if not self._move_on(pushed):
                self._shift *= CALMER
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
            self._shift /= FASTER
        raise SnapFailure(f"snap: no stable state after {MOST} steps from load {self.before.load:.6g}, deflection "
                          f"{self.before.deflection:.6g}; the fall is at deflection {self._deflection:.6g}; follow it "
                          "by a listener")

    def state(self) -> State:
        return replace(self._found, step=self.before.step + 1)

    def _push(self) -> float:
        """Leave an unstable state along its lowest mode; from a stable one, by how much to go on as the path did."""
        tracer = self.tracer
        tracer.factorise_at(tracer.state)
        values, modes = tracer.spectrum(2)
        self._scale = self._shift = max(abs(values[0]), NEARLY_CRITICAL * abs(values[-1]))
        if not unstable(tracer.state, self.hold):
            return copysign(PUSH * self.system.factor, tracer.state.load_rate)
        self._step.array[:] = AMPLITUDE * self._sense(modes[0], len(self.history) == 1) * modes[0].array
        self._energy += self._move(self._step, 0.0)
        return 0.0

    def _move_on(self, pushed: float) -> bool:
        """One step of the motion, with an increment of the load factor to begin with; whether it converges."""
        tracer, system, x = self.tracer, self.system, self.tracer.x
        stepper, start = tracer.stepper, system.factor
        tangent = replace(tracer.tangent, functional=self._load.copy())
        control = LoadControl() if self.hold == "load" else DisplacementControl()
        length = control.measure(tangent, pushed * tangent.solution, pushed)
        x.zeroEntries()
        system.configure(x, start)
        stepper.elimination, stepper.viscosity = None, self._shift
        stepper.begin(control, tangent, length, pushed)
        moved = tracer.enforcement.solve(tracer.correct, [1.0])
        stepper.viscosity = 0.0
        if not moved or self._inner(x, x) > FARTHEST**2:
            x.zeroEntries()
            system.history.rewind()
            system.configure(x, start)
            return False
        system.configure(x, start)
        self._step.array[:] = x.array
        self._energy += self._move(self._step, stepper.load_increment)
        system.history.commit()
        self._assemble()
        return True

    def _at_rest(self) -> bool:
        """Whether nothing but a rounded residual is left."""
        return self.history[-1].residual <= max(self.history[0].residual, self.tracer.snes.getTolerances()[0])
