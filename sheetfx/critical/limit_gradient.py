"""How a limit load changes with the structure.

The load is extremal along the path there, so that it changes as the load at any amplitude that is held. State x and
load factor change by

    K dx - dfactor f = -dR,    d . dx = 0,

with the tangent K, the load f, a direction d, and the forces dR out of balance of the changed structure at the same
displacements. With the null vector phi of K that is dfactor = phi . dR / phi . f (Wu and Arora 1988). K may have
another null vector on its left, as where forces have no potential.

Where a state depends on those before, by friction or laws with history, each step of the path changes that way, along
its own increment d, and the changed structure remembers where it has gone (direct differentiation, Kleiber and others
1997). That takes a factor for each step, which serves all numbers. dR are central differences of two structures.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import pairwise
from typing import cast

import numpy as np
from petsc4py import PETSc

from .. import rounding
from ..continuation.bordered import BorderedSolver, pivots
from ..continuation.state import State
from ..continuation.tracer import Tracer
from ..discrete.discretisation import Discretisation
from ..discrete.free_motions import usual_stiffness
from ..discrete.system import System
from .changed import Change, Differences, Failure, Found, derivatives, unit_of


@dataclass
class Pair:
    """Structures that a number has changed either way.

    Attributes
    ----------
    step : of the number
    more, less : the structures
    ahead : load factor of the first less the path's, which is that of the path less the other one's
    bent : what is left of the mean of both less the path's, in the last step
    odd : part of the difference of both that one more iteration would change, as where only one of them is in contact
    pushed, work : forces on the first along modes that are held in the last step, and work of the others there
    """

    step: float
    more: Discretisation
    less: Discretisation
    ahead: float = 0.0
    bent: float = 0.0
    odd: float = 0.0
    pushed: tuple[float, ...] = ()
    work: float = 0.0

    @property
    def ways(self) -> tuple[tuple[int, Discretisation], ...]:
        return (1, self.more), (-1, self.less)


@dataclass(frozen=True)
class _Solver:
    """Solver at increments of the path and its load factor, and what these leave out of balance."""

    bordered: BorderedSolver
    increment: PETSc.Vec
    factor: float
    residual: PETSc.Vec


def rubbing(system: System) -> str | None:
    """Why friction between parts leaves critical loads without derivatives, or None."""
    if any(c.rubs for c in system.contributions):
        return ("parts that touch each other rub, and where slip began is not known of a changed structure; "
                "take a model without friction, or compare whole paths")
    return None


class LimitGradient:
    """Derivatives of the load of a limit point.

    Parameters
    ----------
    tracer, title, state : as of `bifurcation_gradient.BifurcationGradient`
    before : states that lead to it, from the first one on; used where states depend on those before

    Raises
    ------
    ValueError
        If the load is a reaction, states before it are missing, or parts rub against each other.
    """

    def __init__(self, tracer: Tracer, title: str, state: State, before: Sequence[State]):
        self._tracer, self._system, self._states = tracer, tracer.system, [state]
        if any(c.remembers or not (c.smooth or c.conservative) for c in self._system.contributions):
            self._states = [*before, state]
            if [one.step for one in before] != list(range(len(before))) or state.step - len(before) not in (0, 1):
                raise ValueError(f"gradient: {title} depends on states before it, and some are missing, or the "
                                 "structure has fallen; compare whole paths")
        if refused := rubbing(self._system):
            raise ValueError(f"gradient: {title}: {refused}")
        self._modes: list[PETSc.Vec] = []
        self._least_motion = rounding.NONE * abs(state.factor) * tracer.distance(0.0, state.response)
        self._load, self._unit = state.load, unit_of(cast(Discretisation, tracer.discretisation))

    def derivatives(self, changes: Iterable[Change]) -> Iterator[float | np.ndarray | Failure]:
        """Derivatives of the total load, or why there is none."""
        present, (first, *others) = self._tracer.state, self._states
        try:
            if others:
                yield from derivatives(list(changes), self._load, self._differences)
            else:
                solver = self._at_rest(first)
                for change in changes:
                    yield from derivatives([change], self._load, partial(self._differences, solver=solver))
        finally:
            self._tracer.back_to(present)

    def _differences(self, changes: Sequence[Change], solver: _Solver | None = None) -> list[Found]:
        """Differences by some numbers, along the states; `solver` is that at the first one."""
        found = [self._pair(change) for change in changes]
        pairs = [one for one in found if isinstance(one, Pair)]
        self._begin(self._states[0], solver or self._at_rest(self._states[0]), pairs)
        for before, after in pairwise(self._states):
            for side in (side for pair in pairs for _, side in pair.ways):
                side.system.history.commit()
            self._follow(before, after, pairs)
        return [self._of(one) if isinstance(one, Pair) else one for one in found]

    def _pair(self, change: Change) -> Pair | Failure:
        try:
            return Pair(change.step, *change.sides(self._states[0].fields))
        except (ValueError, ArithmeticError) as failure:
            return failure

    def _at_rest(self, state: State) -> _Solver:
        """Solver at a state where a load stage begins or whose past does not matter, along the response to the load."""
        self._system.restore(state.fields)
        return self._solver(state, self._system.create_vector(), state.response)

    def _solver(self, state: State, increment: PETSc.Vec, held: np.ndarray) -> _Solver:
        """Solver for increments of the unknowns off a direction, at the last state off modes too, and of the load."""
        system, residual = self._system, self._system.create_vector()
        system.configure(increment, state.factor)
        system.residual(residual)
        system.extrapolate_stress()
        system.tangent()
        modes = self._modes if state is self._states[-1] else []
        off = [system.create_vector(held), *modes]
        bordered = BorderedSolver(self._tracer.stepper.linear, pivots(off, system.weights),
                                  usual_stiffness(self._tracer.discretisation))
        rows = [system.weights * vector for vector in off]
        bordered.border([-1.0 * self._tracer.load_vector(), *rows[1:]], rows)
        return _Solver(bordered, increment, state.factor, residual)

    def _begin(self, state: State, solver: _Solver, pairs: Sequence[Pair]) -> None:
        """Let changed structures come to rest at such a state."""
        for pair in pairs:
            pair.ahead = 0.0
            for _, side in pair.ways:
                side.system.factors.enter(state.stage, state.factor)
            self._correct(pair, solver)

    def _follow(self, before: State, after: State, pairs: Sequence[Pair]) -> None:
        """Let changed structures take a step of the path."""
        if after.stage != before.stage:
            self._begin(after, self._at_rest(after), pairs)
            return
        solver = self._solver(after, self._stepped(before, after), after.increment)
        for pair in pairs:
            for _, side in pair.ways:
                _take_forces(side.system, after)
            self._correct(pair, solver)

    def _stepped(self, before: State, after: State) -> PETSc.Vec:
        """Increments of a step, the system being where it begins."""
        self._system.restore(before.fields)
        _take_forces(self._system, after)
        return self._system.create_vector(after.increment)

    def _correct(self, pair: Pair, solver: _Solver) -> None:
        """Bring changed structures to equilibrium near increments of the path's."""
        bordered, size, factor = solver.bordered, solver.bordered.size, solver.factor
        more, less = self._system.create_vector(), self._system.create_vector()
        for (way, side), residual in zip(pair.ways, (more, less), strict=True):
            side.system.configure(solver.increment, factor + way * pair.ahead)
            side.system.residual(residual)
        rights = [0.5 * (less - more), solver.residual - 0.5 * (less + more)]
        (moved, _), ((ahead, *pushed), (bent, *_)) = bordered.solve(rights, np.zeros((2, size)))
        pair.ahead, pair.bent = pair.ahead + float(ahead), float(bent)
        pair.pushed, pair.work = tuple(map(float, pushed)), abs(moved.dot(rights[0]))
        for (way, side), residual in zip(pair.ways, (more, less), strict=True):
            reached = solver.increment.copy()
            self._system.retract(reached, way * moved)
            side.system.configure(reached, factor + way * pair.ahead)
            side.system.residual(residual)
        (odd,), _ = bordered.solve([0.5 * (less - more)], np.zeros((1, size)))
        off, by = (self._tracer.distance(0.0, vector.array) for vector in (odd, moved))
        if off > self._least_motion:
            pair.odd = max(pair.odd, off / by)

    def _of(self, pair: Pair) -> Differences:
        """Those of the load factor times the load of its unit, and of the load of the unit."""
        changed = self._unit * pair.ahead + self._states[-1].factor * (unit_of(pair.more) - unit_of(pair.less)) / 2
        return Differences(changed / pair.step, abs(self._unit * pair.bent) / pair.step, pair.odd)


def _take_forces(system: System, state: State) -> None:
    """Take the contact forces that augmentation or condensation has found at a state of the path."""
    for contribution in system.contributions:
        if contribution.augments or contribution.condenses:
            contribution.restore(state.fields)
