"""Linear buckling of parts that touch and may come apart: modes lift off contacts, and press on those that they close.

With the tangent K of the structure whose contacts are open, its derivative K' along the response to load, and gaps
G v of the contacts that touch, a mode v of unilateral buckling is a solution of

    (K + increment K' + G^T k(v) G) v = 0,    k(v) = k where G v < 0, else 0,

with k the stiffness of contact, which grows until the load hardly changes: plates under unilateral conditions (Do
1977). A mode and its mirror image are two motions: one lifts off where the other presses. Each set of pressed contacts
has its linear eigenproblem; the set that a mode presses is the next one, until it stays. With all contacts open loads
are lower, with all closed they are higher. Between these there may be several solutions: they are looked for from both
signs of several modes of each.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass

import numpy as np
from petsc4py import PETSc
from scipy.sparse import csr_matrix, vstack

from ..checks import Count, require
from ..continuation.linear import DirectSolver
from ..continuation.state import State
from ..continuation.tracer import tracer_of
from ..discrete.growth import MOST, STIFFER
from ..discrete.pair_work import PairWork
from ..discrete.system import System
from ..rounding import NONE
from .buckling import BucklingProblem
from .modes import scaled

ACCURATE = 1e-3  # of a load, what contacts may still have a share in by their stiffness


@dataclass(frozen=True)
class UnilateralBuckling:
    """The lowest load found at which parts that touch buckle, lifting off each other.

    Attributes
    ----------
    factor : load factor
    load : total load on the whole structure
    increment : of the load factor from the state
    lower, upper : loads with all contacts open, and with all closed; infinite: none makes the structure buckle
    pressed, touching : number of contacts that the mode presses, and of those that touch
    others : higher loads of other solutions that were found, and of other modes at the same load
    mode : this process's part of the path's vector; the largest displacement is 1, with the sign that contacts ask for
    """

    factor: float
    load: float
    increment: float
    lower: float
    upper: float
    pressed: int
    touching: int
    others: tuple[float, ...]
    mode: np.ndarray

    def __str__(self) -> str:
        upper = f"{self.upper:.6g}" if np.isfinite(self.upper) else "never"
        others = f"; also found at {', '.join(f'{load:.6g}' for load in self.others)}" if self.others else ""
        return (f"unilateral buckling at load {self.load:.6g} (load factor {self.factor:.6g}): {self.pressed} of "
                f"{self.touching} contacts pressed; all open {self.lower:.6g}, all closed {upper}{others}")


def unilateral_buckling(path, state: State, count: int = 3) -> UnilateralBuckling:
    """The lowest load at which parts buckle that touch without being joined, each contact open or pressed.

    Contacts that are apart stay open, and those that the load presses stay closed, as those that are pressed in the
    state. There is no friction in modes, and rotations before buckling are neglected.

    Parameters
    ----------
    path : Path or Tracer that the state belongs to; it stays at its present state
    state : unloaded or loaded
    count : of modes with all contacts open, from which solutions are looked for

    Returns
    -------
    The lowest one found, with the others. The problem is not convex: that it is the lowest one of all is proved only
    where it is as low as `lower`.

    Raises
    ------
    ValueError
        If nothing touches, or contact does not tell gaps; if no load makes the structure buckle.
    """
    require("unilateral_buckling", count=(count, Count))
    home = path.discretisation
    with home.visiting(state.fields), home.system.history.frozen(), _Touching.of(home.system) as touching:
        response, closed = _response(home, state, touching)
        problem = BucklingProblem(home, state, home.system.motions(response), prebuckling=False)
        cone, same, before = _Cone(problem, touching, closed), tracer_of(path).control.same_load, np.inf
        modes = cone.starts(count)
        for _ in range(MOST):
            solutions = [cone.solution(mode, count) for mode in modes]
            found = _distinct([solution for solution in solutions if solution], same)
            if not found:
                raise ValueError("unilateral_buckling: no mode keeps the contacts that it presses; follow the path, or "
                                 "give another count")
            if abs(before - found[0][0]) <= (STIFFER - 1) * ACCURATE * found[0][0]:
                break
            before, modes = found[0][0], [mode for _, mode, _ in found]
            touching.stiffness = STIFFER * touching.stiffness
        lower, upper = (cone.modes(held, 1) for held in (cone.held, cone.every))
        return _described(problem, found, *(pairs[0][0] if pairs else np.inf for pairs in (lower, upper)))


class _Touching:
    """Contacts that touch in a state: derivatives of their gaps, the same on all processes, and stiffnesses across."""

    def __init__(self, works: Sequence[PairWork], symmetric: bool):
        self._symmetric = symmetric
        across = [work.across() for work in works]
        self.works, self.chosen = works, [work.place() <= work.pairs.tolerance for work in works]
        self.gaps = csr_matrix(vstack([g[c] for (g, _), c in zip(across, self.chosen, strict=True)]))
        self.stiffness = np.concatenate([k[c] for (_, k), c in zip(across, self.chosen, strict=True)])
        self.pressed = np.concatenate([work.evaluate().pressure[c] > 0
                                       for work, c in zip(works, self.chosen, strict=True)])

    @classmethod
    @contextmanager
    def of(cls, system: System) -> Iterator[_Touching]:
        """A system's contacts, which its tangents leave out meanwhile."""
        works = [c for c in system.rough if isinstance(c, PairWork)]
        if other := [c for c in system.rough if not isinstance(c, PairWork)]:
            name = other[0].called or type(other[0]).__name__
            raise ValueError(f"unilateral_buckling: {name} does not tell its gaps; use PairContact, SurfaceContact or "
                             "ObstacleContact for contact that buckling may open")
        touching = cls(works, system.conservative) if works else None
        if touching is None or not len(touching.stiffness):
            raise ValueError("unilateral_buckling: nothing touches in this state; use buckling, or a state in which "
                             "parts touch (gaps of zero)")
        try:
            for work, chosen in zip(works, touching.chosen, strict=True):
                work.leave_open(chosen)
            yield touching
        finally:
            for work in works:
                work.leave_open(np.zeros(work.pairs.count, dtype=bool))

    def closing(self, closed: np.ndarray, matrix: PETSc.Mat) -> PETSc.Mat:
        """A matrix with the stiffness of those that are closed."""
        gaps = self.gaps[closed]
        first, last = matrix.getOwnershipRange()
        own = csr_matrix(gaps.T.tocsr()[first:last] @ (gaps.multiply(self.stiffness[closed][:, None])))
        added = PETSc.Mat().createAIJ((matrix.getSizes()), csr=(own.indptr, own.indices, own.data), comm=matrix.comm)
        found = matrix.copy()
        found.axpy(1.0, added, PETSc.Mat.Structure.DIFFERENT_NONZERO_PATTERN)
        if self._symmetric:
            found.setOption(PETSc.Mat.Option.SYMMETRIC, True)
        return found


def _response(home, state: State, touching: _Touching) -> tuple[PETSc.Vec, np.ndarray]:
    """Response to a unit of load, and the contacts that it presses, with those that are pressed already.

    Each set of closed contacts tells the next one, as an active set method does for a quadratic programme.
    """
    system, load, response = home.system, home.system.create_vector(), home.system.create_vector()
    system.configure(system.create_vector(), state.factor)
    system.extrapolate_stress()
    matrix = system.tangent().copy()
    system.load(load)
    closed = np.ones(len(touching.stiffness), dtype=bool)
    for _ in range(len(closed) + 1):
        solver = DirectSolver(PETSc.KSP().create(system.comm), touching.closing(closed, matrix), system.conservative)
        solver.factorise()
        solver.solve(load, response)
        gaps = touching.gaps @ system.everywhere(response)
        small = NONE * max(np.abs(gaps).max(initial=0.0), np.abs(system.everywhere(response)).max())
        after = touching.pressed | np.where(np.abs(gaps) <= small, closed, gaps < 0)
        if (after == closed).all():
            return response, touching.pressed | (closed & (gaps < -small))
        closed = after
    raise ValueError("unilateral_buckling: the contacts that the load presses are not found; follow the path")


class _Cone:
    """Modes whose closed contacts are those that they press, and those that the load does.

    Attributes
    ----------
    held, every : contacts that the load presses, and all, as whether each is closed
    """

    def __init__(self, problem: BucklingProblem, touching: _Touching, held: np.ndarray):
        self._problem, self._touching, self.held, self._open = problem, touching, held, problem.tangent
        self.every = np.ones_like(held)
        self._known: dict[tuple, list] = {}

    def starts(self, count: int) -> list[PETSc.Vec]:
        """Both signs of the first modes with no contacts closed but those that the load presses, and of one with all.

        Raises
        ------
        ValueError
            If no load is critical with contacts open.
        """
        if not (open_ones := self.modes(self.held, count)):
            raise ValueError("unilateral_buckling: no load of this sense makes the structure buckle, even with all "
                             "contacts open")
        return [mode * sign for _, mode in [*open_ones, *self.modes(self.every, 1)] for sign in (1.0, -1.0)]

    def modes(self, closed: np.ndarray, count: int) -> list[tuple[float, PETSc.Vec]]:
        """Increments and modes with some contacts closed, the smallest first; none where no load is critical."""
        key = closed.tobytes(), self._touching.stiffness.tobytes(), count
        if key not in self._known:
            self._problem.take(self._touching.closing(closed, self._open))
            try:
                self._known[key] = [pair for pair in self._problem.solve(count + 2) if pair[0] > 0][:count]
            except ValueError:
                self._known[key] = []
        return self._known[key]

    def solution(self, mode: PETSc.Vec, count: int) -> tuple[float, PETSc.Vec, np.ndarray] | None:
        """Increment, mode and closed contacts of the solution that a mode leads to; None: sets come again."""
        known: dict[bytes, float] = {}
        weights, before = self._problem.system.weights, self.held
        for _ in range(len(self.held) + 1):
            closed = self._pressed(mode, before)
            if known and (closed == before).all():
                return known[closed.tobytes()], mode, closed
            if closed.tobytes() in known or not (modes := self.modes(closed, count)):
                return None
            products = [(weights * other).dot(mode) / (weights * other).dot(other) ** 0.5 for _, other in modes]
            nearest = int(np.argmax(np.abs(products)))
            known[closed.tobytes()], mode = modes[nearest][0], modes[nearest][1] * float(np.sign(products[nearest]))
            before = closed
        return None

    def _pressed(self, mode: PETSc.Vec, before: np.ndarray) -> np.ndarray:
        """Contacts that a mode presses, with those that are held; those that it hardly moves stay as before."""
        gaps = self._touching.gaps @ self._problem.system.everywhere(mode)
        still = np.abs(gaps) <= NONE * np.abs(gaps).max(initial=0.0)
        return self.held | np.where(still, before, gaps < 0)


def _distinct(found: Sequence[tuple], same: float) -> list[tuple]:
    """Solutions that differ in their load or in the contacts that they close, the lowest first."""
    distinct: list[tuple] = []
    for increment, mode, closed in sorted(found, key=lambda solution: solution[0]):
        if not any(abs(increment - other) <= same * increment and (closed == kept).all()
                   for other, _, kept in distinct):
            distinct.append((increment, mode, closed))
    return distinct


def _described(problem: BucklingProblem, found: Sequence[tuple], lower: float, upper: float) -> UnilateralBuckling:
    (increment, mode, closed), *others = found
    shape = scaled(problem.discretisation, mode)
    sign = np.sign(problem.system.create_vector(shape).dot(mode))
    load, low, high, *more = (problem.total_load(i) if np.isfinite(i) else np.inf
                              for i in (increment, lower, upper, *(i for i, *_ in others)))
    return UnilateralBuckling(problem.state.factor + increment, load, increment, low, high, int(closed.sum()),
                              len(closed), tuple(more), sign * shape)
