"""Whether a state on a branch lies on its first piece, before other critical points of the branch.

States between the bifurcation and the start must have one number of unstable modes and a load that runs one way, both
as the type of the bifurcation asks, and lie on one smooth curve. A branch of a simple bifurcation has the stability
that the path has on the other side of the critical load (exchange of stability: Crandall and Rabinowitz 1973), so that
halves of a stable symmetric one are stable, whatever the load does (Koiter 1945). Where branches are a family, the
modes that lead from one to another are neutral: rounding decides their signs and their shares in tangents.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from scipy.linalg import null_space

from ..continuation.defect import SHORTEST, has_small_defect
from ..continuation.segment import Segment
from ..continuation.state import CriticalPoint, State
from ..rounding import NONE
from .reduction import NoSolution, Reduction

RUNGS = (1 / 4, 1.0)  # amplitudes over the start's, where the branch is looked at


class FirstPiece:
    """States on the branches of a bifurcation, and what the first pieces of these should be like.

    Parameters
    ----------
    reduction : about the bifurcation
    point : the bifurcation
    neighbours : states on the path, before and behind
    """

    def __init__(self, reduction: Reduction, point: CriticalPoint, neighbours: Sequence[State]):
        self._reduction, self._point, self._neighbours = reduction, point, neighbours
        self._bifurcation = reduction.bifurcation
        self._states: dict[tuple[bytes, float], State] = {}
        counted = self._bifurcation.unstable_modes
        self._others = (counted or 0) - reduction.negative

    def state(self, direction: np.ndarray, amplitude: float, family: bool, free: bool = False) -> State:
        """The state of a branch at an amplitude in a direction.

        Parameters
        ----------
        family : whether there are branches in all directions; the tangent is then the one that keeps its direction
        free : whether the direction belongs to another amplitude of the branch, which may turn

        Raises
        ------
        NoSolution
        """
        key = direction.tobytes(), amplitude
        if key not in self._states:
            state = self._reduction.state(self._reduction.solve(direction, amplitude, free))
            self._states[key] = self._keeping(direction, state) if family else state
        return self._states[key]

    def _keeping(self, direction: np.ndarray, state: State) -> State:
        """A state with the tangent that has no share of modes across a direction, and leads on from the bifurcation."""
        reduction, tracer = self._reduction, self._reduction.tracer
        response = reduction.system.create_vector(state.response)
        for across in null_space(direction[None, :]).T:
            share = response.dot(reduction.combined(reduction.weighted, across))
            response.axpy(-share, reduction.combined(reduction.modes, across))
        tangent = 1.0, response.array.copy()
        rate = np.copysign(1.0, tracer.inner(state.direction, tangent)) / tracer.distance(*tangent)
        return replace(state, response=tangent[1], load_rate=float(rate))

    def doubt(self, direction: np.ndarray, amplitude: float, family: bool) -> str:
        """Why a start is not known to lie on the first piece; "" where it does."""
        start = self.state(direction, amplitude, family)
        try:
            rungs = {part: self._turned(direction, part * amplitude, family) for part in RUNGS[:-1]} | {1.0: start}
        except NoSolution:
            return "the branch cannot be followed from the start back to the bifurcation"
        return (self._disagreement(list(rungs.values()), family * (len(direction) - 1)) or self._mistaken(start)
                or self._rough(direction, amplitude, family, rungs))

    def _turned(self, direction: np.ndarray, amplitude: float, family: bool) -> State:
        """The state at another amplitude of a branch, where the direction of several modes may have turned."""
        return self.state(direction, amplitude, family, free=not family and len(direction) > 1)

    def _disagreement(self, states: Sequence[State], neutral: int) -> str:
        """What changes between states of a branch, but the signs of neutral modes, which rounding decides."""
        counts, start = [_stability(state) for state in states], states[-1]
        if max(counts) - min(counts) > neutral and (start.unstable_modes is not None or not neutral):
            return (f"the number of unstable modes changes on the way to the start ({', '.join(map(str, counts))}): "
                    "a critical point of the branch lies before it")
        if any(self._rise(state) * state.load_rate < 0 or self._rise(state) * self._rise(start) < 0
               for state in states):
            return "the load turns on the way to the start: a limit point of the branch lies before it"
        return ""

    def _mistaken(self, start: State) -> str:
        """What a start has that a branch of this type of bifurcation has not."""
        point, found = self._point, start.unstable_modes
        if found is None:
            return ""
        expected = self._expected(start)
        if found not in expected:
            numbers = " or ".join(map(str, expected))
            return (f"the start has {found} unstable modes, where the branches of this "
                    f"{point.title.replace(' point', '')} have {numbers}")
        if point.slope == 0 and point.curvature and self._rise(start) * self._bifurcation.factor * point.curvature < 0:
            falls = "falls" if point.curvature > 0 else "rises"
            return f"the load {falls} along the branch, against Koiter's b of {point.curvature:.3g}"
        return ""

    def _expected(self, start: State) -> list[int]:
        """Numbers of unstable modes that branches may have."""
        if self._point.name.endswith("symmetric") and self._point.slope == 0:
            return [self._others + (self._point.name == "unstable symmetric")]
        sides = {np.sign(self._rise(s)): s.unstable_modes or 0 for s in self._neighbours}
        possible = list(range(self._others, self._others + len(self._reduction.modes) + 1))
        if len(possible) == 2 and sorted(sides.values()) == possible and self._rise(start):
            return [sides[-np.sign(self._rise(start))]]
        return possible

    def _rise(self, state: State) -> float:
        """Change of the load factor since the bifurcation; zero where it is rounding."""
        change = state.factor - self._bifurcation.factor
        return change if abs(change) > NONE * self._reduction.size else 0.0

    def _rough(self, direction: np.ndarray, amplitude: float, family: bool, rungs: dict[float, State]) -> str:
        """Why the pieces between states are not known to be smooth; their middles are looked at where need be."""
        if not self._reduction.system.smooth or not any(map(self._rise, rungs.values())):
            return ""
        segment = Segment(self._reduction.tracer, self._bifurcation, replace(rungs[1.0], length=1.0))
        segment.states = dict(rungs)
        pieces = segment.pairs()
        while pieces:
            left, right = pieces.pop()
            if has_small_defect(segment, left, right):
                continue
            if right - left < SHORTEST:
                return "states of the branch do not lie on the curve that their tangents make on the way to the start"
            middle = (left + right) / 2
            try:
                segment.states[middle] = self._turned(direction, middle * amplitude, family)
            except NoSolution:
                return "the branch cannot be followed from the start back to the bifurcation"
            if doubt := self._disagreement([segment.states[s] for s in sorted(segment.states)],
                                           family * (len(direction) - 1)):
                return doubt
            pieces += [(left, middle), (middle, right)]
        return ""


def _stability(state: State) -> int:
    """What counts unstable modes, or the sign that a simple bifurcation changes where they cannot be counted."""
    return (state.determinant_sign or 0) if state.unstable_modes is None else state.unstable_modes
