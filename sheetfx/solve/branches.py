"""Branches of a bifurcation: a converged state on each of them, from which a path goes on.

With the m null vectors of the tangent at the bifurcation, a direction c of R^m and a small amplitude r,

    R(x, factor) = W Phi t,    t orthogonal to c,    Phi^ W x = r c

has one solution (x, factor, t) near the bifurcation (Lyapunov and Schmidt's reduction; Golubitsky and Schaeffer 1985,
chapter VII). W holds the weights of the scaled inner product, Phi^ the vectors dual to Phi that are orthogonal to the
path on which the bifurcation lies, so that this path has amplitude zero. Where the forces t vanish, the solution is an
equilibrium: c is the direction of a branch. All multiplicities are treated alike; what differs is how the directions
without forces are found.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from petsc4py import PETSc
from scipy.interpolate import RBFInterpolator
from scipy.optimize import brentq, root

from ..state import CriticalPoint, State
from .critical import state_at
from .linear import SingularTangent
from .modes import largest_displacement
from .spectrum import diagonal, nearest_to_zero

ANGLES = 48  # on the circle of directions of a double bifurcation
SAMPLES, STARTS = 100, 200  # on the sphere of a higher one, for each null vector
ITERATIONS = 12
CONVERGED = 1e-7  # last correction over the amplitude; with Newton's method the next one is its square
NEAR = 0.02  # change of load between bifurcation and start, over the load
SMALLEST = 1e-4  # amplitude over the first one tried
NO_FORCE = 1e-10  # forces along null vectors over the load
SAME = 1e-3  # distance of unit vectors


class NoBranch(ArithmeticError):
    """The equations of branches do not converge for any amplitude tried."""


@dataclass(frozen=True)
class Branch:
    """A half-branch: a bifurcation in one direction.

    Attributes
    ----------
    start : state on the branch, from which `Path(scene, control, until, start=[branch.start])` leads away from the
        bifurcation
    direction : of the null vectors' space, a unit vector
    mode : null vector in this direction, this process's part, the largest displacement being 1 (see
        `mode_displacement`)
    amplitude : largest displacement of the mode's share in the start
    family : whether it stands for a continuum of branches, in all directions
    """

    start: State
    direction: np.ndarray
    mode: np.ndarray
    amplitude: float
    family: bool = False


def branches(path, states: Sequence[State], point: CriticalPoint,
             amplitude: float = 0.05) -> list[Branch]:
    """A start on every half-branch of a bifurcation but those of the path itself.

    A simple bifurcation has two. Those of a double one are complete but for pairs closer than 8 degrees; those of
    higher ones are sought from many directions, and some may be missed.

    Parameters
    ----------
    path : Path or Tracer that the states belong to; it stays at its present state
    states : of the path, among them those before and after the bifurcation
    point : the bifurcation, one of `critical` of these states
    amplitude : of the modes at the starts, in the scaled inner product (of the size of rotations in radians); it is
        halved until Newton's method converges quickly, to loads within 2 %, in all directions

    Raises
    ------
    ValueError
        For a limit point, or if the states around the point are not given.
    NoBranch
    """
    before, after = _step_of(states, point)
    tracer = getattr(path, "tracer", path)
    present = tracer.state
    try:
        state_at(tracer, before, after, point)
        reduction = _Reduction(tracer, point.multiplicity, after)
        return _found(reduction, amplitude)
    finally:
        tracer.back_to(present)


def _step_of(states: Sequence[State], point: CriticalPoint) -> tuple[State, State]:
    if point.kind != "bifurcation":
        raise ValueError(f"branches: a {point.kind} point (load {point.load:.6g}) has no branches; "
                         "the path itself goes on through it")
    by_step = {state.step: state for state in states}
    if not {point.step - 1, point.step} <= set(by_step):
        raise ValueError(f"branches: the states of steps {point.step - 1} and {point.step} around the bifurcation at "
                         f"load {point.load:.6g} are missing; give the states of the whole path")
    return by_step[point.step - 1], by_step[point.step]


class _Missed(ArithmeticError):
    """The reduced equations do not converge for this direction and amplitude."""


@dataclass(frozen=True)
class _Solution:
    """Increments from the bifurcation, and the forces t along the null vectors that hold them."""

    increment: np.ndarray
    load_increment: float
    forces: np.ndarray
    iterations: int


class _Reduction:
    """Equilibrium in all but the space of null vectors, about the current state of a tracer, factored there.

    Parameters
    ----------
    after : state at the end of the step that the bifurcation lies in
    """

    def __init__(self, tracer, multiplicity: int, after: State):
        self.tracer, self.system, self.bifurcation = tracer, tracer.system, tracer.state
        self.linear = tracer.stepper.linear
        _, self.modes = nearest_to_zero(self.linear, diagonal(self.system.weights), multiplicity)
        if len(self.modes) < multiplicity:
            raise NoBranch(f"only {len(self.modes)} of {multiplicity} null vectors at load "
                           f"{self.bifurcation.load:.6g} converge")
        self.weighted = [self._weighted(mode) for mode in self.modes]
        self.measures = self._measures(after.increment)
        self.reach = NEAR * max(abs(self.bifurcation.factor), abs(after.load_increment))
        self.springs = self._pivots()
        self._residual, self._load = self.system.create_vector(), self.system.create_vector()

    def norm(self, array: np.ndarray) -> float:
        vector = self.system.create_vector(array)
        return vector.dot(self._weighted(vector)) ** 0.5

    def _weighted(self, vector: PETSc.Vec) -> PETSc.Vec:
        product = vector.duplicate()
        product.pointwiseMult(self.system.weights, vector)
        return product

    def _measures(self, along: np.ndarray) -> list[PETSc.Vec]:
        """Vectors whose products with increments are the amplitudes of the null vectors, zero along the path."""
        across = self.system.create_vector(along)
        shares = [across.dot(weighted) for weighted in self.weighted]
        whole = self.norm(along)
        for share, mode in zip(shares, self.modes, strict=True):
            across.axpy(-share, mode)
        across = self._weighted(across)
        rest2 = whole**2 - sum(share**2 for share in shares)
        if rest2 < 1e-4 * whole**2:
            raise ValueError(f"branches: at load {self.bifurcation.load:.6g} the path goes along a null vector; "
                             "bifurcations that are limit points too cannot be switched")
        measures = []
        for share, weighted in zip(shares, self.weighted, strict=True):
            measure = weighted.copy()
            measure.axpy(-share / rest2, across)
            measures.append(measure)
        return measures

    def _pivots(self) -> list[int]:
        """Unknowns by which the null vectors can be told apart, one for each, by elimination."""
        rest, chosen = [], []
        root_weights = self.system.weights.copy()
        root_weights.sqrtabs()
        for mode in self.modes:
            scaled = mode.duplicate()
            scaled.pointwiseMult(root_weights, mode)
            rest.append(scaled)
        for n, vector in enumerate(rest):
            size = vector.copy()
            size.abs()
            chosen.append(size.max()[0])
            value = self._entry(vector, chosen[-1])
            for other in rest[n + 1:]:
                other.axpy(-self._entry(other, chosen[-1]) / value, vector)
        return chosen

    def _entry(self, vector: PETSc.Vec, number: int) -> float:
        first, last = vector.getOwnershipRange()
        own = vector.array[number - first] if first <= number < last else 0.0
        return self.system.comm.allreduce(float(own))

    def solve(self, direction: np.ndarray, amplitude: float) -> _Solution:
        """Solution in one direction, by Newton's method from the null vector.

        Raises
        ------
        _Missed
        """
        with self.system.additive_increments():
            return self._iterated(direction, amplitude)

    def _iterated(self, direction: np.ndarray, amplitude: float) -> _Solution:
        system, x = self.system, self.tracer.x
        system.factor, load_increment, forces = self.bifurcation.factor, 0.0, np.zeros(len(direction))
        x.zeroEntries()
        system.configure(x)
        step = self._combined(self.modes, amplitude * direction)
        taken, allowed = np.inf, 4 * amplitude
        tangential = np.linalg.svd(direction[None, :])[2][1:]
        for iteration in range(ITERATIONS):
            system.extrapolate_stress(step)
            system.retract(x, step)
            system.factor = self.bifurcation.factor + load_increment
            system.configure(x)
            system.residual(self._residual)
            system.load(self._load)
            size = max(abs(system.factor) * self._load.norm(), system.reaction)
            self._residual.axpy(-1.0, self._combined(self.weighted, forces))
            if self._residual.norm() <= 1e-8 * size and taken <= CONVERGED * amplitude:
                if abs(load_increment) > self.reach:
                    break
                return _Solution(x.array.copy(), load_increment, forces, iteration)
            missing = amplitude * direction - [measure.dot(x) for measure in self.measures]
            try:
                step, change, more = self._correction(tangential, missing)
            except (SingularTangent, np.linalg.LinAlgError):
                break
            load_increment, forces = load_increment + change, forces + more
            taken = self.norm(step.array)
            if not taken <= allowed:
                break
            allowed = taken / 2
        raise _Missed

    def _combined(self, vectors: Sequence[PETSc.Vec], factors) -> PETSc.Vec:
        total = self.system.create_vector()
        total.maxpy(list(factors), list(vectors))
        return total

    def _correction(self, tangential: np.ndarray, missing: np.ndarray) -> tuple[PETSc.Vec, float, np.ndarray]:
        """Newton's step of unknowns, load factor and forces.

        The tangent may be singular. Springs at as many unknowns as there are null vectors are added before it is
        factored, and forces that cancel those of the springs are further unknowns.
        """
        stiffness, count = self._factor_with_springs(), len(missing)
        pushes = [self._load, *(self._combined(self.weighted, row) for row in tangential)]
        columns = [self._solved(push) for push in pushes]
        columns += [self._solved(self._unit(number, k)) for number, k in zip(self.springs, stiffness, strict=True)]
        rows = self.measures + [self._unit(number, 1.0) for number in self.springs]
        part = self._solved(self._residual)
        matrix = np.array([[row.dot(column) for column in columns] for row in rows])
        matrix[count:, count:] -= np.eye(count)
        right = np.concatenate((missing, np.zeros(count))) + [row.dot(part) for row in rows]
        solution = np.linalg.solve(matrix, right)
        step = self._combined([part, *columns], [-1.0, *solution])
        return step, float(solution[0]), solution[1:count] @ tangential

    def _factor_with_springs(self) -> list[float]:
        """Factor the tangent with the springs, and return their stiffness."""
        matrix = self.system.tangent()
        diagonal_entries = matrix.getDiagonal()
        stiffness = [abs(self._entry(diagonal_entries, number)) for number in self.springs]
        first, last = matrix.getOwnershipRange()
        for number, k in zip(self.springs, stiffness, strict=True):
            if first <= number < last:
                matrix.setValue(number, number, k, addv=PETSc.InsertMode.ADD)
        matrix.assemble()
        self.linear.factor()
        return stiffness

    def _solved(self, right: PETSc.Vec) -> PETSc.Vec:
        solution = right.duplicate()
        self.linear.solve(right, solution)
        return solution

    def _unit(self, number: int, value: float) -> PETSc.Vec:
        vector = self.system.create_vector()
        first, last = vector.getOwnershipRange()
        if first <= number < last:
            vector.array[number - first] = value
        return vector

    def relative_forces(self, solution: _Solution) -> float:
        """Norm of the forces along the null vectors over that of the loads."""
        self.system.load(self._load)
        total = self._combined(self.weighted, solution.forces)
        return total.norm() / (abs(self.bifurcation.factor) * self._load.norm())

    def branch(self, direction: np.ndarray, amplitude: float, family: bool) -> Branch:
        """The half-branch in a direction without forces."""
        solution, mode = self.solve(direction, amplitude), self._combined(self.modes, direction)
        self.tracer.back_to(self.bifurcation)
        self.tracer.x.array[:] = solution.increment
        self.system.factor = self.bifurcation.factor + solution.load_increment
        state = self.tracer.accept(solution.load_increment, solution.iterations)
        self.tracer.back_to(self.bifurcation)
        size = largest_displacement(self.tracer.discretisation, mode)
        return Branch(state, direction, mode.array / size, amplitude * size, family)


def _found(reduction: _Reduction, amplitude: float) -> list[Branch]:
    """Branches at the largest amplitude for which the search converges."""
    search = {1: _both_ways, 2: _around_circle}.get(len(reduction.modes), _over_sphere)
    smallest = SMALLEST * amplitude
    while amplitude > smallest:
        try:
            directions, family = search(reduction, amplitude)
            return [reduction.branch(c, amplitude, family) for c in directions]
        except _Missed:
            amplitude /= 2
    raise NoBranch(f"no solution beside the path converges at the bifurcation at load "
                   f"{reduction.bifurcation.load:.6g}, down to amplitude {amplitude:.2g}; check with smaller steps "
                   "that it is one")


def _both_ways(reduction: _Reduction, amplitude: float) -> tuple[list[np.ndarray], bool]:
    return [np.array([1.0]), np.array([-1.0])], False


def _around_circle(reduction: _Reduction, amplitude: float) -> tuple[list[np.ndarray], bool]:
    """Zeros of the one force that is left, between samples on a circle."""
    def direction(angle):
        return np.array([np.cos(angle), np.sin(angle)])

    def force(angle):
        return float(reduction.solve(direction(angle), amplitude).forces @ direction(angle + np.pi / 2))

    angles = np.linspace(0, 2 * np.pi, ANGLES + 1) + 0.1
    solutions = [reduction.solve(direction(angle), amplitude) for angle in angles[:-1]]
    if max(map(reduction.relative_forces, solutions)) < NO_FORCE:
        return [direction(angles[0])], True
    forces = [s.forces @ direction(a + np.pi / 2) for s, a in zip(solutions, angles, strict=False)]
    forces.append(forces[0])
    zeros = [brentq(force, a, b, xtol=1e-12) for a, b, left, right in zip(
        angles[:-1], angles[1:], forces[:-1], forces[1:], strict=True) if left * right < 0]
    return [direction(angle) for angle in zeros], False


def _over_sphere(reduction: _Reduction, amplitude: float) -> tuple[list[np.ndarray], bool]:
    """Zeros of the forces on a sphere of any dimension, near those of an interpolation between samples."""
    multiplicity = len(reduction.modes)
    samples = _scattered(SAMPLES * multiplicity, multiplicity)
    solutions = [reduction.solve(c, amplitude) for c in samples]
    if max(map(reduction.relative_forces, solutions)) < NO_FORCE:
        return [samples[0]], True
    forces = np.array([solution.forces for solution in solutions])
    size = np.abs(forces).max()
    estimate = RBFInterpolator(samples, forces / size, kernel="cubic")
    guesses = _zeros(lambda c: estimate(c[None, :])[0], _scattered(STARTS * multiplicity, multiplicity))
    return _zeros(lambda c: reduction.solve(c, amplitude).forces / size, guesses), False


def _scattered(count: int, dimension: int) -> np.ndarray:
    """Unit vectors in rows."""
    vectors = np.random.default_rng(count).standard_normal((count, dimension))
    return vectors / np.linalg.norm(vectors, axis=1, keepdims=True)


def _zeros(force: Callable[[np.ndarray], np.ndarray], starts: Sequence[np.ndarray]) -> list[np.ndarray]:
    """Different directions without forces that are found from some starts."""
    def equations(z):
        length = np.linalg.norm(z)
        return force(z / length) + (length**2 - 1) * z

    found: list[np.ndarray] = []
    for start in starts:
        solution = root(equations, start, tol=1e-10)
        c = solution.x / np.linalg.norm(solution.x)
        if solution.success and all(np.linalg.norm(c - other) > SAME for other in found):
            found.append(c)
    return found
