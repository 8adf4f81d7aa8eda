"""Damped falls from an unstable equilibrium, or from where no equilibrium lies ahead, to a stable one.

A structure in a viscous fluid moves with W dx/dt = -R; an implicit step

    R(x) + viscosity W (x - x before) = 0

is solved as a step of a path is, and then accepted: what has slipped by then has taken its work. The viscosity, one
over the length of the step in time, changes with the norm of R (pseudo-transient continuation, Kelley and Keyes 1998),
and is raised where a step does not converge, or is too long. Without friction that is the gradient flow of the energy.

It leaves an unstable equilibrium in a fluid that flows along the mode: steep walls of a curved valley push it to the
floor. With a viscosity below the growth of that mode a step can lead back to the unstable equilibrium, or past it. So
the flow is so short that the step gives energy, and each step after it must begin down the forces and give energy. That
is the integral of all forces along the motion, the held load's and friction's included: the work that the fluid takes.
Forces of contact change within a small part of a step, so that their work comes from its closed form
(`Contribution.work_between`) where there is one.

With friction a mode may grow at once as pairs begin to slip, so that its eigenvalue lies far below zero, and in that
sense only in which they slip on.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import copysign

import numpy as np
from petsc4py import PETSc

from .. import rounding
from ..continuation.control import DisplacementControl, LoadControl
from ..continuation.spectrum import diagonal, nearest_to_zero
from ..continuation.state import State
from ..discrete.contribution import Contribution
from ..discrete.functional import Functional
from .modes import scaled

AMPLITUDE = 0.02  # of the first push, in the scaled norm
FARTHEST = 0.2  # of any step, in the scaled norm
PUSH = 1e-3  # of the load, by which it changes where friction holds a stable state, or that moves the held node
FACTOR = 4.0  # on the viscosity after a step, and on a push that takes energy
NEARLY_CRITICAL = 1e-3  # lowest eigenvalue over the next, of a stable state taken for critical
PERPENDICULAR = 1e-3  # cosine of the angle between mode and path
ROUNDING = 1e-6  # of the energy given so far, energy that steps may take by rounding
LOOKS = 8  # for modes that grow, each farther from zero
MOST = 500  # steps and pushes, tried ones included
POINTS, WEIGHTS = np.polynomial.legendre.leggauss(6)
POINTS, WEIGHTS = (POINTS + 1) / 2, WEIGHTS / 2


class SnapFailure(ArithmeticError):
    """A fall that does not find a stable state; says how far it came."""


@dataclass(frozen=True)
class FallStep:
    """One of the configurations of a fall.

    Attributes
    ----------
    energy : change since the start, of the whole structure and its loads
    residual : ratio of the norms of the forces out of balance and of loads or reactions
    shift : damping of the step that led here
    load, deflection : as of a State
    """

    energy: float
    residual: float
    shift: float
    load: float
    deflection: float


def unstable(state: State, hold: str) -> int:
    """Unstable directions that are left while the load or the displacement is held; 0 where they are not known."""
    return (state.unstable_modes or 0) - (hold == "displacement" and state.current_stiffness < 0)


class _Held:
    """Factor of the tangent plus shift W under a held load or displacement; a solver for `spectrum`."""

    def __init__(self, tracer, hold: str):
        self.system, self._linear, self.matrix = tracer.system, tracer.stepper.linear, tracer.system.matrix
        self.symmetric = self._linear.symmetric
        self._load = self.system.create_vector() if hold == "displacement" else None
        self._response, self._diagonal = self.system.create_vector(), self.system.create_vector()

    def assemble(self) -> None:
        """Assemble the tangent of the current configuration."""
        self.system.extrapolate_stress()
        self.system.tangent().getDiagonal(self._diagonal)
        if self._load is not None:
            self.system.load(self._load)

    def factorise(self, shift: float) -> None:
        """Factor the tangent plus shift W.

        Raises
        ------
        SingularTangent
        """
        self.matrix.setDiagonal(self._diagonal + shift * self.system.weights)
        self._linear.factorise()
        if self._load is not None:
            self._linear.solve(self._load, self._response)
            self._compliance = self._load.dot(self._response)

    def solve(self, right: PETSc.Vec, solution: PETSc.Vec) -> float:
        """Solve for the unknowns, and return the change of the load factor that holds the displacement."""
        self._linear.solve(right, solution)
        if self._load is None:
            return 0.0
        change = -self._load.dot(solution) / self._compliance
        solution.axpy(change, self._response)
        return change


class Fall:
    """Damped motion from the current state of a tracer, to a stable one."""

    def __init__(self, tracer, hold: str, side: int, listener):
        self.tracer, self.system, self.before = tracer, tracer.system, tracer.state
        self.hold, self.side, self._listener = hold, side, listener
        self._held = _Held(tracer, hold)
        self._residual, self._load, self._step, self._along = (self.system.create_vector() for _ in range(4))
        self.history: list[FallStep] = []
        self._energy, self._deflection, self._spent = 0.0, self.before.deflection, tracer.total_factorisations
        self._viscosity = self._scale = 0.0
        self._rough = [c for c in self.system.contributions
                       if not (c.smooth or c.augments) and c.touch() is not None]
        self._even = [c for c in self.system.contributions if c not in self._rough]

    def run(self) -> State:
        """Fall until equilibrium is stable; the state there.

        Raises
        ------
        SnapFailure
        """
        self._note()
        pushed, calmed = self._push(), False
        for _ in range(MOST):
            before = self._residual.norm()
            if not self._move_on(pushed):
                self._viscosity, calmed = FACTOR * self._viscosity, True
                continue
            if not pushed:
                change = self._residual.norm() / before
                self._viscosity *= change if calmed else min(change, 1 / FACTOR)
            pushed, calmed = 0.0, False
            if self._at_rest():
                found = self._state()
                if not unstable(found, self.hold):
                    return found
                self._push()
        raise SnapFailure(
            f"snap: no stable state in {MOST} steps from load {self.before.load:.6g}, deflection "
            f"{self.before.deflection:.6g}; the fall is at deflection {self._deflection:.6g} with a relative residual "
            f"of {self.history[-1].residual:.1e}; follow it by a listener, and start from a state nearer to the "
            "critical point")

    def _state(self) -> State:
        """The current configuration as a state of the path."""
        found = self.tracer.accept(0.0, len(self.history) - 1)
        self._along.array[:] = found.response
        growing = found.factor if self.hold == "load" else self._deflection * self.tracer.monitored_rate(self._along)
        return replace(
            found, step=self.before.step + 1, deflection=self._deflection, displacement_extremes=0,
            factorisations=self.tracer.total_factorisations - self._spent,
            load_rate=copysign(found.load_rate, growing or 1.0))

    def _note(self) -> None:
        """Forces of the current configuration, and its entry in the history."""
        system, discretisation = self.system, self.tracer.discretisation
        system.load(self._load)
        system.residual(self._residual)
        size = max(system.reaction, abs(system.factor) * self._load.norm())
        residual = self._residual.norm() / size if size else 0.0
        system.extrapolate_stress()
        self.history.append(FallStep(discretisation.scene.symmetry_factor * self._energy, residual, self._viscosity,
                                     discretisation.total_load(), self._deflection))
        self._listener(self.history[-1])

    def _at_rest(self) -> bool:
        """Whether the residual is as small as at the start, as in a step of the path, or rounding of no viscosity."""
        residuals = [step.residual for step in self.history]
        if self._viscosity > self._scale:
            return False
        if residuals[-1] <= max(residuals[0], self.tracer.snes.getTolerances()[0]):
            return True
        stays = rounding.SAFETY * residuals[-1] > residuals[-2]
        return stays and self._residual.norm() <= rounding.residual(self.system, self.tracer.x)

    def _push(self) -> float:
        """Leave an unstable state along its lowest mode; from a stable one, by how much to go on as the path did."""
        first, growing = len(self.history) == 1, unstable(self.tracer.state, self.hold)
        self._held.assemble()
        values, modes = self._modes(growing)
        self._scale = self._viscosity = max(abs(values[0]), abs(values[-1]))
        if not growing and not self.system.conservative:
            return copysign(PUSH * self.system.factor, self.tracer.state.load_rate)
        rest = values[0] / values[-1] if len(values) > 1 else self.before.current_stiffness
        if not growing and rest > NEARLY_CRITICAL:
            raise ValueError(f"snap: the state at load {self.before.load:.6g}, deflection {self.before.deflection:.6g} "
                             f"is stable while the {self.hold} is held; take one beyond the critical point")
        for side in (self.side,) if first else (1, -1):
            for mode in modes[:max(growing, 1)]:
                if self._gives(mode, side * self._sense(mode, first)):
                    return 0.0
        raise SnapFailure(f"snap: the structure resists pushes along its unstable modes at deflection "
                          f"{self._deflection:.6g}; try the other side or a state further on")

    def _sense(self, mode: PETSc.Vec, first: bool) -> float:
        """Sign of the mode along the path; where it is perpendicular to the path its largest component's."""
        along = self._along
        along.array[:] = self.before.load_rate * self.before.response
        cosine = self._inner(mode, along) / self._inner(along, along) ** 0.5
        if not first or abs(cosine) < PERPENDICULAR:
            along.array[:] = scaled(self.tracer.discretisation, mode)
            cosine = self._inner(mode, along)
        return copysign(1.0, cosine)

    def _inner(self, one: PETSc.Vec, other: PETSc.Vec) -> float:
        return self.tracer.tangent.inner(one, other)

    def _gives(self, mode: PETSc.Vec, sense: float) -> bool:
        """Go a short way with a fluid that flows along a mode; whether that gives energy, as friction may hold here."""
        length, flow, start = AMPLITUDE, self.tracer.stepper.flow, self.system.factor
        for _ in range(MOST):
            flow.array[:] = sense * length * mode.array
            motion = self._motion(0.0)
            flow.zeroEntries()
            if motion and motion[0] < 0:
                self._accept(*motion)
                self.system.residual(self._residual)
                return True
            self._back(start)
            if motion is None or not motion[0]:
                self._viscosity *= FACTOR
            elif (length := length / FACTOR) < rounding.DIFFERENCE**2:
                break
        return False

    def _modes(self, growing: int) -> tuple[list[float], list[PETSc.Vec]]:
        """Some eigenvalues in ascending order, and modes: all that grow, where they can be found.

        Those may be far from zero behind many others, as friction lets modes grow at once: the shift looks there.
        """
        weights, shift, count = self.system.weights, 0.0, max(growing + 1, 2)
        best: tuple[list[float], list[PETSc.Vec]] | None = None
        mass = diagonal(weights)
        for _ in range(LOOKS):
            try:
                self._held.factorise(shift)
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
        start, motion, allowed = self.system.factor, self._motion(pushed), ROUNDING * abs(self._energy)
        if motion and (pushed or (motion[0] <= allowed and self._residual.dot(self._step) <= allowed)):
            self._accept(*motion)
            self._note()
            return True
        self._back(start)
        return False

    def _motion(self, pushed: float) -> tuple[float, float] | None:
        """Change of the energy and load increment of a step, at whose end the system is then; None: there is none."""
        tracer, system, x = self.tracer, self.system, self.tracer.x
        stepper, start = tracer.stepper, system.factor
        tangent = replace(tracer.tangent, functional=Functional(self._load.copy()))
        control = LoadControl() if self.hold == "load" else DisplacementControl()
        length = control.measure(tangent, pushed * tangent.solution, pushed)
        x.zeroEntries()
        system.configure(x, start)
        stepper.elimination, stepper.viscosity = None, self._viscosity
        stepper.begin(control, tangent, length, pushed)
        moved = tracer.enforcement.solve(tracer.correct, [1.0], control.augmentations)
        stepper.viscosity = 0.0
        if not moved or self._inner(x, x) > FARTHEST**2:
            return None
        self._step.array[:] = x.array
        increment = stepper.load_increment
        x.zeroEntries()
        system.configure(x, start)
        return self._work(self._step, increment), increment

    def _work(self, way: PETSc.Vec, load_increment: float) -> float:
        starts = [c.touch() for c in self._rough]
        change = self._integral(self._even, way, load_increment)
        return change + sum(c.work_between(start, c.touch()) for c, start in zip(self._rough, starts, strict=True))

    def _accept(self, change: float, load_increment: float) -> None:
        """Accept the end of a step, where the system is, with what has slipped on its way."""
        self._energy += change
        self._follow(self._step, load_increment)
        self.system.history.commit()

    def _back(self, factor: float) -> None:
        """Return to where increments count from."""
        self.tracer.x.zeroEntries()
        self.system.history.rewind()
        self.system.configure(self.tracer.x, factor)

    def _integral(self, contributions: Sequence[Contribution], way: PETSc.Vec, load_increment: float) -> float:
        """Integral of the residual of some contributions along a straight way, at whose end the system is then."""
        system, x, force = self.system, self.tracer.x, self.system.create_vector()
        start, change = system.factor, 0.0
        with system.additive_increments():
            for point, weight in zip(POINTS, WEIGHTS, strict=True):
                x.array[:] = point * way.array
                system.configure(x, start + point * load_increment)
                system.residual_of(contributions, force)
                change += weight * force.dot(way)
        x.array[:] = way.array
        system.configure(x, start + load_increment)
        return float(change)

    def _follow(self, way: PETSc.Vec, load_increment: float) -> None:
        """Let increments count from the end of a straight way, where the system is."""
        system, x = self.system, self.tracer.x
        factor = system.factor
        x.zeroEntries()
        system.configure(x, factor - load_increment)
        x.array[:] = way.array
        system.extrapolate_stress(x)
        system.configure(x, factor)
        self._deflection += self.tracer.monitored(x)
        system.history.rebase()
        x.zeroEntries()
        system.configure(x, factor)
