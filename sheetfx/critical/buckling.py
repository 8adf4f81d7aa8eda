"""Linear buckling about a state: loads at which the tangent, taken as linear in the load, turns singular.

With the tangent K and its derivative K' along the response of the state to load,

    (K + increment K') mode = 0,

solved as K' mode = -(1 / increment) K mode, that is shift and invert about the state itself: the loads nearest
to the state, of both signs, are the eigenvalues of largest magnitude.

The SLEPc objects take the prefix `sheetfx_buckling_`, for example
`PETSC_OPTIONS="-sheetfx_buckling_eps_view -sheetfx_buckling_eps_tol 1e-12"`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from petsc4py import PETSc
from slepc4py import SLEPc

from ..checks import Count, Positive, require
from ..continuation.linear import DirectSolver
from ..continuation.spectrum import solve, solve_by
from ..continuation.state import State
from ..discrete.discretisation import Discretisation
from ..notices import warn
from ..rounding import DIFFERENCE, NONE, is_real
from .modes import scaled

PREFIX = "sheetfx_buckling_"


class MissedModes(ArithmeticError):
    """The inertia of the tangent shows buckling loads that the eigensolver did not find."""


@dataclass(frozen=True)
class BucklingLoad:
    """A buckling load and its mode.

    Attributes
    ----------
    factor : load factor at buckling
    load : total load on the whole structure
    increment : of the load factor from the state; of either sign
    cluster : number of the group of neighbouring loads that it belongs to, 0 for the one nearest to the state
    multiplicity : number of loads in that group
    residual : bound on the relative algebraic error of 1 / increment (of a stable state)
    mode : this process's part of the path's vector, also where modes have other supports; the largest displacement
        is 1
    """

    factor: float
    load: float
    increment: float
    cluster: int
    multiplicity: int
    residual: float
    mode: np.ndarray

    def __str__(self) -> str:
        among = f", one of {self.multiplicity} in a cluster" if self.multiplicity > 1 else ""
        return f"buckling at load {self.load:.6g} (load factor {self.factor:.6g}{among})"


def buckling(path, state: State, count: int = 6, *, supports: Sequence | None = None, prebuckling: bool | None = None,
             tolerance: float = 1e-3) -> list[BucklingLoad]:
    """Buckling loads nearest to a state, the nearest first.

    The tangent counts as linear in the load. By how much it is not, at the nearest load, is told where that is more
    than `tolerance`; and that contact stays as it is, where the scene has any: modes pass through what does not touch.

    Parameters
    ----------
    path : Path or Tracer that the state belongs to; it stays at its present state
    state : unloaded or loaded; contact stays as it is
    count : number of loads; more are returned where the last one would cut a cluster
    supports : of the modes, where they differ from the response's: modes of the other symmetry, or edges
        that move freely before they buckle
    prebuckling : whether the tangent changes with the displacement of the response too, so that the error falls
        with the square of the distance to a bifurcation; False: with its stress alone, by the initial-stress
        matrix, which neglects rotations before buckling: the error falls linearly, but can be the smaller one from
        afar (unloaded shallow arch on hinges: 11 % instead of 46 %); None: True about loaded states, False about
        the unloaded one, the classical problem
    tolerance : largest relative distance of neighbours in a cluster

    Raises
    ------
    ValueError
        If no load makes the structure buckle, or a number is not what it must be.
    MissedModes
        If the number of loads found about a stable state contradicts the inertia of the tangent.
    """
    require("buckling", count=(count, Count), tolerance=(tolerance, Positive))
    home = path.discretisation
    discretisation = home if supports is None else Discretisation(replace(home.scene, supports=supports))
    with (home.visiting(state.fields), discretisation.visiting(state.fields), home.system.history.frozen(),
          discretisation.system.history.frozen()):
        motions = home.system.motions(home.system.create_vector(state.response))
        prebuckling = state.step > 0 if prebuckling is None else prebuckling
        problem = BucklingProblem(discretisation, state, motions, prebuckling)
        found = _complete(problem, count, tolerance)
        problem.tell(*found[0], tolerance, state.contact_points)
        return problem.describe(found, tolerance, home)


class BucklingProblem:
    """LoadResponse of a state, its derivative along the response, and the eigenproblem of both."""

    def __init__(self, discretisation: Discretisation, state: State, motions: Sequence, prebuckling: bool):
        self.discretisation, self.system, self.state = discretisation, discretisation.system, state
        self.prebuckling = prebuckling
        self.response = self.system.step_by(motions)
        length = ((self.system.weights * self.response).dot(self.response) + state.least_weight) ** 0.5
        if not length > 0:
            raise ValueError("buckling: the structure does not respond to its load; check loads and supports")
        self.tangent = self._tangent_at(0.0)
        self.slope = self._by_differences(DIFFERENCE / length) if prebuckling else self._by_stress(1 / length)
        if not self.slope.norm() > 0:
            raise ValueError("buckling: no stress changes with the load; with mixed_points=False give prebuckling=True")
        self.take(self.tangent)

    def take(self, tangent: PETSc.Mat) -> None:
        """Have a tangent of the state, and its factor."""
        self.tangent, self.solver = tangent, DirectSolver(self._ksp(), tangent, self.system.conservative)
        self.solver.factorise()
        pivots = self.solver.negative_pivots()
        self.definite, self.stable = pivots == 0, pivots == self.system.multipliers

    def _tangent_at(self, step: float, held: float = 0.0) -> PETSc.Mat:
        """LoadResponse where response and load have gone on by `step`, and stress and load further by `held`."""
        system, x = self.system, self.response.copy()
        x.scale(step)
        system.configure(x, self.state.factor + step + held)
        x.array[:] = held * self.response.array
        system.extrapolate_stress(x)
        matrix = system.tangent().copy()
        if system.conservative:
            matrix.setOption(PETSc.Mat.Option.SYMMETRIC, True)
        return matrix

    def _by_differences(self, step: float) -> PETSc.Mat:
        slope = self._tangent_at(step)
        slope.axpy(-1.0, self._tangent_at(-step), PETSc.Mat.Structure.SAME_NONZERO_PATTERN)
        slope.scale(0.5 / step)
        return slope

    def _by_stress(self, step: float) -> PETSc.Mat:
        """Exact, since the tangent is linear in the held stress and in follower loads."""
        slope = self._tangent_at(0.0, step)
        slope.axpy(-1.0, self.tangent, PETSc.Mat.Structure.SAME_NONZERO_PATTERN)
        slope.scale(1 / step)
        return slope

    def _ksp(self) -> PETSc.KSP:
        return PETSc.KSP().create(self.system.comm)

    def solve(self, count: int) -> list[tuple[float, PETSc.Vec]]:
        """At least `count` increments and modes where there are as many, the smallest increment first."""
        eps = SLEPc.EPS().create(self.system.comm)
        eps.setOptionsPrefix(PREFIX)
        eps.setOperators(self.slope, self.tangent)
        kinds = SLEPc.EPS.ProblemType
        eps.setProblemType(kinds.GHEP if self.definite else kinds.GNHEP)
        eps.setWhichEigenpairs(SLEPc.EPS.Which.LARGEST_MAGNITUDE)
        eps.setDimensions(min(count, self.system.size))
        eps.setTolerances(1e-10, 500)
        solve_by(self.solver, eps.getST().getKSP())
        eps.setFromOptions()
        values = [eps.getEigenvalue(i) for i in range(eps.getConverged())] if solve(eps) else []
        largest = max(map(abs, values), default=0.0)
        pairs = []
        for i, value in enumerate(values):
            if abs(value) > NONE * largest and is_real(value):
                mode = self.tangent.createVecRight()
                eps.getEigenvector(i, mode)
                pairs.append((-1 / value.real, mode))
        if not pairs:
            raise ValueError("buckling: no load of this kind makes the structure buckle")
        return sorted(pairs, key=lambda pair: abs(pair[0]))

    def below(self, increment: float) -> int:
        """Number of buckling loads of a stable state between the state and an increment."""
        matrix = self.tangent.copy()
        matrix.axpy(increment, self.slope, PETSc.Mat.Structure.SAME_NONZERO_PATTERN)
        matrix.setOption(PETSc.Mat.Option.SYMMETRIC, True)
        solver = DirectSolver(self._ksp(), matrix, True)
        solver.factorise()
        return solver.negative_pivots() - self.system.multipliers

    def residual(self, increment: float, mode: PETSc.Vec) -> float:
        """Ratio of the energy norms of the residual and of the mode."""
        force, change, answer = mode.duplicate(), mode.duplicate(), mode.duplicate()
        self.tangent.mult(mode, force)
        energy = mode.dot(force)
        self.slope.mult(mode, change)
        force.axpy(increment, change)
        self.solver.solve(force, answer)
        return abs(force.dot(answer) / energy) ** 0.5

    def tell(self, increment: float, mode: PETSc.Vec, tolerance: float, touching: int) -> None:
        """Warn where contact stays as it is, or else where the tangent is not linear as far as a buckling load."""
        if self.system.rough:
            warn(f"buckling: contact stays as it is in the state, where {touching} points touch: modes hold these "
                 "together and pass through all others. unilateral_buckling lets modes lift off; the path itself finds "
                 "where structures with contact buckle")
        elif self.prebuckling and abs((share := self.nonlinear(increment, mode)) - 1) > tolerance:
            where = (f"to second order the nearest increment of the load factor is {increment * share:.6g} instead of "
                     f"{increment:.6g}" if np.isfinite(share) else
                     f"at the nearest increment of the load factor, {increment:.6g}, it is far from singular")
            warn(f"buckling: the tangent is not linear in the load; {where}. Ask about a state closer to it, let the "
                 "path find it, or compare with prebuckling=False")

    def nonlinear(self, increment: float, mode: PETSc.Vec) -> float:
        """Of a mode the increment at which it buckles, over that where the tangent is linear; infinite: none.

        The second derivative of the tangent K along the response is taken from its value at the increment s, where the
        mode's energy is c of that at the state instead of zero: 1 - t + c t^2 = 0 at t s, with the root next to 1.
        """
        force = mode.duplicate()
        self.tangent.mult(mode, force)
        energy = mode.dot(force)
        self._tangent_at(increment).mult(mode, force)
        left = 4 * mode.dot(force) / energy
        return 2 / (1 + (1 - left) ** 0.5) if left <= 1 else np.inf

    def describe(self, pairs: list[tuple[float, PETSc.Vec]], tolerance: float,
                 home: Discretisation) -> list[BucklingLoad]:
        """Loads with their clusters, and modes in the components of another discretisation of the structure."""
        numbers = clusters([increment for increment, _ in pairs], tolerance)
        return [BucklingLoad(
            self.state.factor + increment, self.total_load(increment), increment, number, numbers.count(number),
            self.residual(increment, mode), scaled(home, self._in_components_of(home, mode)))
                for (increment, mode), number in zip(pairs, numbers, strict=True)]

    def _in_components_of(self, home: Discretisation, mode: PETSc.Vec) -> PETSc.Vec:
        """The same motions, of nodes that may have other axes there."""
        if home is self.discretisation:
            return mode
        self.system.configure(self.system.create_vector(), self.state.factor)
        return home.system.step_by(self.system.motions(self.system.create_vector(mode.array)))

    def total_load(self, increment: float) -> float:
        """On the whole structure, at an increment of the load factor."""
        x = self.response.copy()
        x.scale(increment)
        self.system.configure(x, self.state.factor + increment)
        return self.discretisation.total_load()


def clusters(increments: Sequence[float], tolerance: float) -> list[int]:
    """For each increment the number of its cluster: neighbours of one sign closer than the relative tolerance."""
    numbers: list[int] = []
    last: dict[bool, tuple[float, int]] = {}
    for increment in increments:
        before = last.get(increment > 0)
        if before is not None and abs(increment - before[0]) <= tolerance * abs(increment):
            number = before[1]
        else:
            number = max(numbers, default=-1) + 1
        last[increment > 0] = increment, number
        numbers.append(number)
    return numbers


def _complete(problem: BucklingProblem, count: int, tolerance: float) -> list[tuple[float, PETSc.Vec]]:
    """The pairs nearest to the state, at least `count`, up to the end of a cluster, and none missed."""
    asked = count + 4
    while True:
        pairs = problem.solve(asked)
        end = _end(pairs, count, tolerance)
        exhausted = len(pairs) < asked
        if end is None and exhausted:
            return pairs
        if end is not None and (not problem.stable or _all_found(problem, pairs, end)):
            return pairs[:end]
        if exhausted or asked > 8 * (count + 4):
            raise MissedModes(
                f"buckling: the eigensolver finds {len(pairs)} loads, fewer than the inertia of the tangent shows; "
                f"try another tolerance (PETSC_OPTIONS='-{PREFIX}eps_tol 1e-12') or another count")
        asked *= 2


def _end(pairs, count: int, tolerance: float) -> int | None:
    """Number of pairs, at least `count`, behind which a cluster of each sign has ended; None: not known."""
    for end in range(count, len(pairs)):
        if abs(pairs[end][0]) - abs(pairs[end - 1][0]) > tolerance * abs(pairs[end][0]):
            return end
    return None


def _all_found(problem: BucklingProblem, pairs, end: int) -> bool:
    middle = (abs(pairs[end - 1][0]) + abs(pairs[end][0])) / 2
    return all(problem.below(sign * middle) == sum(sign * increment > 0 for increment, _ in pairs[:end])
               for sign in (1.0, -1.0))
