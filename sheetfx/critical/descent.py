"""Damped descent of the energy from an unstable equilibrium to a stable one.

A heavily damped structure follows the gradient flow W dx/dt = -R of its energy. One implicit step of it,

    (K + shift W) step = -R,

is Newton's for a shift of zero, and a short way down the gradient for a large one. The shift is as small as the matrix
is definite, which its factor's inertia tells, and as the energy falls the way its quadratic model says (Levenberg 1944;
Kelley and Keyes 1998). The energy itself need not be known: its change along a step is the integral of R along it,
loads and contact layers included. Slender structures fall along curved valleys with steep walls: steps are bent back
to their floors.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import copysign

import numpy as np
from petsc4py import PETSc

from .. import rounding
from ..continuation.linear import SingularTangent
from ..continuation.spectrum import diagonal, lowest, nearest_to_zero
from ..continuation.state import State
from ..discrete.contribution import Contribution
from .modes import scaled

AMPLITUDE, LONGEST = 0.02, 0.2  # of the first and of any step, in the scaled norm
GOOD, POOR = 0.7, 0.1  # change of the energy over the expected one: less damping, shorter step
SMALLEST_PART = 1e-6  # of a step
SMALLEST_SHIFT, LARGEST_SHIFT = 1e-3, 1e15  # over the lowest eigenvalue where it leaves
NEARLY_CRITICAL = 1e-3  # lowest eigenvalue over the next, of a stable state taken for critical
PERPENDICULAR = 1e-3  # cosine of the angle between mode and path
MOST = 300  # steps
CORRECTIONS, SMALL_CORRECTION = 6, 1e-3  # back into the valley, and size of the last one over the step
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
    residual : norm of the forces out of balance over that of loads or reactions
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

    def assemble(self, extrapolated: bool = False) -> None:
        """Assemble the tangent of the current configuration."""
        if not extrapolated:
            self.system.extrapolate_stress()
        self.system.tangent().getDiagonal(self._diagonal)
        if self._load is not None:
            self.system.load(self._load)

    def factorise(self, shift: float) -> int:
        """Number of directions in which the quadratic form falls; at least 1 where it is singular."""
        self.matrix.setDiagonal(self._diagonal + shift * self.system.weights)
        try:
            self.factorise_matrix()
        except SingularTangent:
            return 1
        negative = self._linear.negative_pivots() - self.system.multipliers
        return negative - (self._load is not None and self._compliance < 0)

    def factorise_matrix(self) -> None:
        """Factor the matrix as it is."""
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


@dataclass
class _Step:
    """A step and what it is expected to do: energy = slope part + curvature part^2 / 2.

    The shift is that of the factor it was found with; None: it was not found by one.
    """

    load_increment: float
    slope: float
    curvature: float
    shift: float | None

    def expected(self, part: float) -> float:
        return part * self.slope + part**2 * self.curvature / 2


class Fall:
    """Damped descent of the energy from the current state of a tracer."""

    def __init__(self, tracer, hold: str, side: int, listener):
        self.tracer, self.system, self.before = tracer, tracer.system, tracer.state
        self.hold, self.side, self._listener = hold, side, listener
        self._held = _Held(tracer, hold)
        self._residual, self._load, self._step = (self.system.create_vector() for _ in range(3))
        self._mode = self.system.create_vector()
        self.history: list[FallStep] = []
        self._energy, self._deflection, self._spent = 0.0, self.before.deflection, tracer.total_factorisations
        self._shift = self._scale = self._way = self._length = 0.0

    def run(self) -> None:
        """Fall until equilibrium is stable."""
        while len(self.history) <= MOST:
            self._assemble()
            step = self._leave() if self._balanced() else self._descend()
            if step is None:
                return
            self._take(step)
        last = self.history[-1]
        raise SnapFailure(
            f"snap: no stable state after {MOST} steps from load {self.before.load:.6g}, deflection "
            f"{self.before.deflection:.6g}; the fall is at deflection {last.deflection:.6g} with a relative residual "
            f"of {last.residual:.1e}; follow it by a listener, and start from a state nearer to the critical point")

    def state(self) -> State:
        """The current configuration as a state of the path."""
        found = self.tracer.accept(0.0, len(self.history) - 1)
        growing = found.factor if self.hold == "load" else self._deflection * self._monitor_rate(found)
        return replace(
            found, deflection=self._deflection, displacement_extremes=0,
            factorisations=self.tracer.total_factorisations - self._spent,
            load_rate=copysign(found.load_rate, growing or 1.0))

    def _monitor_rate(self, state: State) -> float:
        self._step.array[:] = state.response
        return self.tracer.monitored_rate(self._step)

    def _assemble(self) -> None:
        """Forces and tangent of the current configuration, and its entry in the history."""
        system, discretisation = self.system, self.tracer.discretisation
        system.load(self._load)
        system.residual(self._residual)
        size = max(system.reaction, abs(system.factor) * self._load.norm())
        residual = self._residual.norm() / size if size else 0.0
        self._held.assemble()
        self.history.append(FallStep(discretisation.scene.symmetry_factor * self._energy, residual, self._shift,
                                     discretisation.total_load(), self._deflection))
        self._listener(self.history[-1])

    def _balanced(self) -> bool:
        """Whether the residual is as small as at the start, as in a step of the path, or as rounding lets it be."""
        residuals = [step.residual for step in self.history]
        if residuals[-1] <= max(residuals[0], self.tracer.snes.getTolerances()[0]):
            return True
        stays = rounding.SAFETY * residuals[-1] > residuals[-2]
        return stays and self._residual.norm() <= rounding.residual(self.system, self.tracer.x)

    def _leave(self) -> _Step | None:
        """A step out of an unstable equilibrium along its lowest mode; None from a stable one."""
        unstable = self._held.factorise(0.0)
        first = len(self.history) == 1
        if not unstable and not first:
            return None
        weights = diagonal(self.system.weights)
        values, modes = lowest(self._held, weights, 2, unstable) if unstable else nearest_to_zero(
            self._held, weights, 2)
        rest = values[0] / values[-1] if len(values) > 1 else self.before.current_stiffness
        if not unstable and rest > NEARLY_CRITICAL:
            raise ValueError(f"snap: the state at load {self.before.load:.6g}, deflection {self.before.deflection:.6g} "
                             f"is stable while the {self.hold} is held; take one beyond the critical point")
        self._scale = self._shift = max(abs(values[0]), NEARLY_CRITICAL * abs(values[-1]))
        self._step.array[:] = AMPLITUDE * self._sense(modes[0], first) * modes[0].array
        return _Step(0.0, self._residual.dot(self._step), AMPLITUDE**2 * values[0], None)

    def _sense(self, mode: PETSc.Vec, first: bool) -> float:
        """Sign of the mode in the sense of the fall; where it is perpendicular to the path its largest component's."""
        side, along = (self.side if first else 1), self._mode
        along.array[:] = self.before.load_rate * self.before.response
        cosine = self._inner(mode, along) / self._inner(along, along) ** 0.5
        if not first or abs(cosine) < PERPENDICULAR:
            along.array[:] = scaled(self.tracer.discretisation, mode)
            cosine = self._inner(mode, along)
        return copysign(1.0, cosine) * side

    def _inner(self, one: PETSc.Vec, other: PETSc.Vec) -> float:
        return self.tracer.tangent.inner(one, other)

    def _descend(self) -> _Step:
        """The least damped step for which the matrix is definite."""
        while self._held.factorise(self._shift) > 0:
            self._raise_shift()
            if not self._shift < LARGEST_SHIFT * self._scale:
                raise SnapFailure(f"snap: no damping makes the tangent definite at deflection {self._deflection:.6g}; "
                                  "start from a state nearer to the critical point")
        load_increment = self._held.solve(-self._residual, self._step)
        slope = self._residual.dot(self._step)
        return _Step(load_increment, slope, -slope - self._shift * self._inner(self._step, self._step), self._shift)

    def _raise_shift(self) -> None:
        self._shift = max(4 * self._shift, SMALLEST_SHIFT * self._scale)

    def _take(self, step: _Step) -> None:
        """Move by that part of a step over which the energy falls, and adapt the shift."""
        start = self.system.snapshot()
        length, deflection = self._inner(self._step, self._step) ** 0.5, self._deflection
        part = min(1.0, LONGEST / length)
        while not (change := self._try(part, step)) < min(POOR * step.expected(part), 0.0):
            self.system.restore(start)
            self._deflection = deflection
            part /= 2
            if part < SMALLEST_PART:
                raise SnapFailure(f"snap: the energy does not fall along a step from deflection "
                                  f"{self._deflection:.6g}; try the other side or a state further on")
        if part < 1:
            self._raise_shift()
        elif change < GOOD * step.expected(part):
            self._shift = self._shift / 8 if self._shift > 8 * SMALLEST_SHIFT * self._scale else 0.0
        self._energy += change
        self._length = part * length
        self._way += self._length

    def _try(self, part: float, step: _Step) -> float:
        """Follow a part of a step, bend it back into the valley, and return the change of the energy."""
        moved, expected = part * self._step, step.expected(part)
        change = self._move(moved, part * step.load_increment)
        if abs(expected) <= rounding.NONE * abs(self._energy):
            return expected
        if step.shift is not None and change > GOOD * expected:
            change += self._bend_back(moved, (1 - part) * self._residual, step.shift)
        return change

    def _bend_back(self, moved: PETSc.Vec, wanted: PETSc.Vec, shift: float) -> float:
        """Correct what has been moved, and return the change of the energy.

        Along a curved valley a straight step climbs its wall, however well it follows the valley (Maratos's effect).
        Newton's iteration with the tangent of the mixed integration points leads back to its floor: to where the
        forces are as wanted but for those of the damping.
        """
        change, force, correction = 0.0, self.system.create_vector(), self.system.create_vector()
        for _ in range(CORRECTIONS):
            self._held.assemble(extrapolated=True)
            if self._held.factorise(shift) > 0:
                break
            self.system.residual(force)
            force += shift * self.system.weights * moved - wanted
            load_increment = self._held.solve(-force, correction)
            size = self._inner(correction, correction) / self._inner(moved, moved)
            if size > 1:
                break
            change += self._move(correction, load_increment)
            moved += correction
            if size < SMALL_CORRECTION**2:
                break
        return change

    def _move(self, way: PETSc.Vec, load_increment: float) -> float:
        """Follow a straight way, let increments count from its end, and return the change of the energy."""
        change = self._work(way, load_increment)
        self._follow(way, load_increment)
        return change

    def _work(self, way: PETSc.Vec, load_increment: float) -> float:
        """Change of the energy along a straight way, at whose end the system is then."""
        return self._integral(self.system.contributions, way, load_increment)

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
