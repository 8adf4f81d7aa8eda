"""What became of a traced path, judged by a reference path and by the critical points that it should have."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from sheetfx.continuation.state import CriticalPoint, State

from .traps import Expected

PASSED, WRONG, JUMPED, BACK, STALLED, CRASHED = OUTCOMES = (
    "passed", "wrong value", "jumped silently", "turned back", "stalled", "crashed")
OFF = 0.02  # of the largest displacements and load, distance from the trail that is still close
BACKWARDS = 0.005  # of the length of the trail, way back that does not count
ABRUPT = 0.3  # of the chord of a step, growth of the distance by which it has jumped rather than drifted
AHEAD = 0.7  # cosine of the angle to the tangent at an end of the trail, from which a state lies beyond it
PIECES = 20  # of the curve between two states


class Trail:
    """A reference path as a curve in the space of all displacements, over their largest size, and of the load.

    It begins with the last stage of loads, as those before have loads of their own.
    """

    def __init__(self, states: Sequence[State]):
        from scipy.interpolate import Akima1DInterpolator

        self.states = states = [s for s in states if s.stage == states[-1].stage]
        self._size = max(np.linalg.norm(_displacements(s)) for s in states) or 1.0
        self._load = max(abs(s.factor) for s in states) or 1.0
        knots = np.array([self.place(s) for s in states])
        self.steps = np.linalg.norm(np.diff(knots, axis=0), axis=1)
        self._knots = np.concatenate([[0.0], np.cumsum(self.steps)])
        fine = np.interp(np.arange(PIECES * len(self.steps) + 1) / PIECES, np.arange(len(knots)), self._knots)
        self._lengths, self._curve = fine, Akima1DInterpolator(self._knots, knots)(fine)

    @property
    def length(self) -> float:
        return float(self._knots[-1])

    def place(self, state: State) -> np.ndarray:
        return np.append(_displacements(state) / self._size, state.factor / self._load)

    def project(self, state: State, after: float = 0.0) -> tuple[float, float, float]:
        """Length along the curve of the nearest place, distance from there, and the distance that is still close.

        Where the curve passes a place several times, as a closed one does, that nearest to the length `after` counts.
        """
        distances = np.linalg.norm(self._curve - self.place(state), axis=1)
        padded = np.pad(distances, 1, constant_values=np.inf)
        passes = (distances <= padded[:-2]) & (distances <= padded[2:]) & (distances <= distances.min() + OFF / 2)
        nearest = int(min(np.flatnonzero(passes), key=lambda n: abs(self._lengths[n] - after)))
        step = self.steps[min(nearest // PIECES, len(self.steps) - 1)]
        return float(self._lengths[nearest]), float(distances[nearest]), OFF + 0.05 * float(step)

    def beyond(self, state: State) -> int:
        """-1 before the start of the curve, 1 behind its end, as its tangents there lead on; 0 elsewhere."""
        for sign, (tip, inside) in ((-1, self._curve[:2]), (1, self._curve[:-3:-1])):
            ahead, away = tip - inside, self.place(state) - tip
            if ahead @ away > AHEAD * np.linalg.norm(ahead) * np.linalg.norm(away):
                return sign
        return 0

    def unstable_modes(self, along: float) -> int | None:
        """Unstable directions at a length along the curve; None: not known, or changing nearby."""
        after = int(np.clip(np.searchsorted(self._knots, along), 1, len(self.steps)))
        near = {s.unstable_modes for s in self.states[max(after - 2, 0):after + 2]}
        return near.pop() if len(near) == 1 else None

    def limits(self, along: float) -> list[CriticalPoint]:
        """Limit points up to a length along the curve."""
        def where(point: CriticalPoint) -> float:
            number = point.step - self.states[0].step
            return self._knots[number - 1] + point.length / self.states[number].length * self.steps[number - 1]

        return [p for s in self.states for p in s.critical if p.kind == "limit" and where(p) < along]


def _displacements(state: State) -> np.ndarray:
    return np.concatenate([v for name, v in state.fields.items() if name.startswith("displacement")])


class Judge:
    """Watches a path state by state.

    Parameters
    ----------
    expected : critical points in their order
    trail : reference path; None: only the points count
    """

    def __init__(self, expected: Sequence[Expected], trail: Trail | None):
        self._expected, self._trail = expected, trail
        self._along, self._distance, self._before, self._limits = 0.0, 0.0, trail and trail.states[0], 0

    def watch(self, state: State) -> tuple[str, str] | None:
        """Outcome and reason where the path leaves the trail or goes back on it; states behind its end are free."""
        trail, before = self._trail, self._before
        if trail is None or state.stage < trail.states[0].stage:
            return None
        along, distance, close = trail.project(state, self._along)
        beyond = trail.beyond(state) if along in (0.0, trail.length) else 0
        if beyond > 0:
            return None
        step = trail.place(state) - trail.place(before)
        chord = np.linalg.norm(step)
        wanted = trail.unstable_modes(along)
        off = distance > close and not beyond
        if off and distance - self._distance > ABRUPT * chord:
            return JUMPED, f"leaves the path between {place(before)} and {place(state)}"
        if off:
            return WRONG, f"drifts off the path, by {100 * distance:.2g} % at {place(state)}"
        if None not in (state.unstable_modes, wanted) and not state.contact_points and state.unstable_modes != wanted:
            return JUMPED, f"has {state.unstable_modes} unstable modes at {place(state)}, where the path has {wanted}"
        self._limits += sum(point.kind == "limit" for point in state.critical)
        passed = trail.limits(self._along - BACKWARDS * trail.length)
        if len(passed) > self._limits:
            return JUMPED, f"passes the limit point at load {passed[self._limits].load:.5g} without finding it"
        if along < self._along - BACKWARDS * trail.length:
            onward = np.dot(step, trail.place(trail.states[-1]) - trail.place(trail.states[-2])) > 0
            if onward and self._along + chord > trail.length:  # behind the end, which a closed path passes earlier too
                self._trail = None
                return None
            return BACK, f"returns over its own path from {place(before)}"
        self._along, self._distance, self._before = along, distance, state
        return None

    def conclude(self, found: Sequence[CriticalPoint]) -> tuple[str, str]:
        """Outcome and reason of a path that reached its end: are all expected points, and no others, found?"""
        expected = self._expected
        for kind, outcome in (("limit", JUMPED), ("bifurcation", WRONG), ("flutter", WRONG)):
            wanted, got = ([p for p in points if p.kind == kind] for points in (expected, found))
            if len(got) < len(wanted):
                missed = next((w for w, g in zip(wanted, got, strict=False) if not _agree(w, g)), wanted[len(got)])
                return outcome, f"passes the {kind} point at load {missed.load:.5g} without finding it"
            if len(got) > len(wanted):
                extra = next((g for w, g in zip(wanted, got, strict=False) if not _agree(w, g)), got[len(wanted)])
                return WRONG, f"finds a {kind} point at load {extra.load:.5g} that is not there"
        for wanted, point in zip(expected, found, strict=True):
            if not _agree(wanted, point):
                return WRONG, f"finds a {point.kind} point at load {point.load:.8g} instead of {wanted.load:.8g}"
            if point.multiplicity != wanted.multiplicity:
                return WRONG, (f"finds {point.multiplicity} null vectors at load {point.load:.5g}, where there are "
                               f"{wanted.multiplicity}")
            if wanted.name not in (None, point.name):
                return WRONG, f"names the point at load {point.load:.5g} {point.name!r} instead of {wanted.name!r}"
        return PASSED, ""


def place(state: State) -> str:
    return f"load {state.load:.5g}, deflection {state.deflection:.5g}"


def _agree(wanted: Expected, point: CriticalPoint) -> bool:
    return point.kind == wanted.kind and abs(point.load - wanted.load) <= wanted.tolerance * abs(wanted.load)
