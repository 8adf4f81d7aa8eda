"""How the load of a bifurcation changes with the structure, where forces have no potential or depend on the way.

With the null vectors Phi of the tangent K and Psi on its left, which are the same where K is symmetric, the matrix
M = Psi^T K Phi is singular at the bifurcation. A changed structure is brought to rest where the path's has the
bifurcation, and has M + dM there at the load dfactor; along the path M changes by M' for each unit of its length s:

    Psi^T (dM + M' ds) Phi u = 0,    dfactor_bifurcation = dfactor + (dfactor / ds) ds.

The path of a number that keeps the symmetry has no share of the modes. Tangents are those of loading (Hill 1958), taken
about states that are reached by the path's last step, as its numbers of unstable modes are. dM and M' are central
differences of two tangents.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from petsc4py import PETSc

from .. import rounding
from ..continuation.bordered import BorderedSolver, pivots
from ..continuation.state import State
from ..continuation.tracer import Tracer
from ..discrete.free_motions import usual_stiffness
from ..discrete.system import System
from ..events.determinant import orthonormal
from .bifurcation_gradient import NoDerivative, require_perfect
from .changed import Differences
from .limit_gradient import LimitGradient, Pair


class FollowedBifurcation(LimitGradient):
    """Derivatives of the load of a bifurcation by following changed structures along the states before it.

    Parameters
    ----------
    tracer, title, state, before : as of `LimitGradient`
    modes : null vectors at the bifurcation

    Raises
    ------
    ValueError
        As of `LimitGradient`.
    NoDerivative
        If the stiffness along a mode jumps past zero, as where points begin to flow or to touch.
    """

    def __init__(self, tracer: Tracer, title: str, state: State, modes: Sequence[np.ndarray], before: Sequence[State]):
        super().__init__(tracer, title, state, before)
        self._title, present = title, tracer.state
        self._modes = orthonormal(self._system.weights, [self._system.create_vector(mode) for mode in modes])
        self._steps = len(self._states) > 1 and self._states[-2].stage == state.stage
        try:
            self._modes, self._left = self._null_vectors()
            self._reach()
            self._here = self._matrix(self._system)
            self._rates = self._rates_of_load(f"gradient: {title}")
            self._least = rounding.NONE * abs(state.factor) * tracer.load_vector().norm() * max(
                mode.norm() for mode in self._modes)
        finally:
            tracer.back_to(present)

    def _rates_of_load(self, said: str) -> np.ndarray:
        """Rates of M by the load factor along the path."""
        state, tracer = self._states[-1], self._tracer
        last = state.direction if self._steps else (state.factor, state.factor * state.response)
        way = rounding.DIFFERENCE * tracer.distance(*last) / tracer.distance(1.0, state.response)
        rates, closer = map(self._rate, (way, way / 2))
        off = np.abs(np.linalg.solve(rates, self._here)).max()
        if off > way or np.linalg.norm(closer - rates) > np.linalg.norm(rates) / 2:
            raise NoDerivative(f"{said}: the stiffness along the mode jumps past zero there, as where points begin to "
                               "flow; compare whole paths")
        return rates

    def _rate(self, way: float) -> np.ndarray:
        """Rate of M by the load factor along the path, over a way to each side."""
        response, sides = self._system.create_vector(self._states[-1].response), []
        for part in (way, -way):
            self._reach(part * response, part)
            sides.append(self._matrix(self._system))
        return (sides[0] - sides[1]) / (2 * way)

    def _null_vectors(self) -> tuple[list[PETSc.Vec], list[PETSc.Vec]]:
        """Those of the tangent, and those on its left."""
        system, linear, count = self._system, self._tracer.stepper.linear, len(self._modes)
        self._reach()
        _tangent(system)
        weighted = [system.weights * mode for mode in self._modes]
        bordered = BorderedSolver(linear, pivots(self._modes, system.weights),
                                  usual_stiffness(self._tracer.discretisation))
        bordered.border(weighted, weighted)
        modes, _ = bordered.solve([], np.eye(count))
        return modes, modes if linear.symmetric else bordered.left(count)

    def _of(self, pair: Pair) -> Differences:
        if (pushed := np.abs(pair.pushed).max()) > self._least:
            require_perfect(self._title, pushed, pair.work, float(np.abs(np.diag(self._rates)).max()))
        more, less = (self._matrix(side.system) for _, side in pair.ways)
        shifts = np.linalg.solve(self._rates, (more - less) / 2)
        bend = np.abs(np.linalg.solve(self._rates, (more + less) / 2 - self._here)).max()
        found, size = super()._of(pair), self._unit / pair.step
        shift = np.sort(np.linalg.eigvals(-shifts).real) * size
        first = found.first + (shift if len(shift) > 1 else float(shift[0]))
        return Differences(first, found.half_second + bend * size, found.odd)

    def _reach(self, further: PETSc.Vec | None = None, load: float = 0.0) -> None:
        """Put the system to the bifurcation and a further step, with the last step's increments."""
        state = self._states[-1]
        if self._steps:
            increment = self._stepped(self._states[-2], state)
        else:
            self._system.restore(state.fields)
            increment = self._system.create_vector()
        if further is not None:
            self._system.retract(increment, further)
        self._system.configure(increment, state.factor + load)

    def _matrix(self, system: System) -> np.ndarray:
        """M where a system is."""
        tangent, image, columns = _tangent(system), system.create_vector(), []
        for mode in self._modes:
            tangent.mult(system.create_vector(mode.array), image)
            columns.append([one.dot(image) for one in self._left])
        return np.array(columns).T


def _tangent(system: System) -> PETSc.Mat:
    """Tangent of loading where a system is, as unstable modes are counted by."""
    system.history.update_history()
    system.extrapolate_stress()
    return system.tangent()
