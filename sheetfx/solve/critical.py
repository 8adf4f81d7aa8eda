"""Critical points between two converged states: found by sign changes, refined by restarts."""

from __future__ import annotations

from scipy.optimize import brentq, minimize_scalar

from ..state import CriticalPoint, State


def locate(tracer, earlier: State | None, before: State, after: State) -> tuple[CriticalPoint, ...]:
    """Critical points that the step from `before` to `after` brings to light; the tracer ends at `after`.

    A change of sign of the load rate is a limit point, which changes the number of unstable directions
    by one; any other change in that number is a bifurcation. Both are refined by repeating the step
    with other lengths.

    As a contact slides over contact points the load rate wavers about that of the smooth path, while
    the load itself hardly does. With contact a limit point is therefore a step in which the load
    turns, and is searched there and in the step before it, which starts at `earlier`.
    """
    found = []
    if tracer.discretisation.contacts:
        if before.load_increment * after.load_increment < 0:
            steps = [(before, after)] if earlier is None else [(earlier, before), (before, after)]
            found.append(("limit", _highest(tracer, steps, 1.0 if before.load_increment > 0 else -1.0)))
    elif before.load_rate * after.load_rate < 0:
        found.append(("limit", _limit(tracer, before, after)))
    if _beyond_limits(before) != _beyond_limits(after):
        found.append(("bifurcation", _bifurcation(tracer, before, after)))
    if not found:
        return ()
    tracer.back_to(after)
    found.sort(key=lambda item: (item[1].step, item[1].length))
    return tuple(CriticalPoint(kind, s.load, s.deflection, s.step) for kind, s in found)


def _beyond_limits(state: State) -> int | None:
    """Unstable directions beyond the one that a falling load brings; changes at bifurcations only."""
    return None if state.unstable is None else state.unstable - (state.load_rate < 0)


class _Missed(ArithmeticError):
    """A step of a shorter length does not converge."""


class _Tries:
    """The step from a state repeated with other lengths."""

    def __init__(self, tracer, before: State, after: State):
        self.tracer, self.before = tracer, before
        self.states = {0.0: before, after.length: after}

    def __getitem__(self, length: float) -> State:
        if length not in self.states:
            self.tracer.back_to(self.before)
            state = self.tracer.attempt(length, self._guess(length)) or self.tracer.attempt(length)
            if state is None:
                raise _Missed
            self.states[length] = state
        return self.states[length]

    def neighbours(self, length: float) -> list[tuple[float, State]]:
        """Lengths and states of the nearest tries on both sides."""
        below, above = [s for s in self.states if s < length], [s for s in self.states if s > length]
        return [(s, self.states[s]) for s in (max(below, default=None), min(above, default=None)) if s is not None]

    def _guess(self, length: float):
        """Cubic interpolation between the nearest states on both sides, from their tangents."""
        (a, left), (b, right) = self.neighbours(length)
        span, t = b - a, (length - a) / (b - a)
        weights = ((1 + 2 * t) * (1 - t) ** 2, t * t * (3 - 2 * t), span * t * (1 - t) ** 2, span * t * t * (t - 1))
        ends = [left, right]
        values = [(0.0, 0.0) if s is self.before else (s.load_increment, s.increment) for s in ends]
        slopes = [(s.load_rate, s.load_rate * s.response) for s in ends]
        return tuple(sum(w * v[n] for w, v in zip(weights, values + slopes, strict=True)) for n in range(2))


def _limit(tracer, before: State, after: State) -> State:
    """State within a step whose load rate is zero; its load differs by about 1e-12 from the limit."""
    tries, sign = _Tries(tracer, before, after), 1.0 if before.load_rate > 0 else -1.0

    def rate(length):
        state = tries[length]
        slopes = [abs((s.load_rate - state.load_rate) / (other - length)) for other, s in tries.neighbours(length)]
        close = len(slopes) == 2 and state.load_rate**2 < 2e-12 * min(slopes) * abs(state.factor)
        return 0.0 if close else state.load_rate

    try:
        brentq(rate, 0.0, after.length, xtol=1e-7 * after.length)
    except _Missed:
        pass
    return max(tries.states.values(), key=lambda s: sign * s.factor)


def _highest(tracer, steps, sign: float) -> State:
    """State of the highest load (lowest for a negative sign) within steps."""
    found = []
    for before, after in steps:
        tries = _Tries(tracer, before, after)

        def opposite_load(length, tries=tries, before=before):
            try:
                return -sign * tries[length].factor
            except _Missed:
                return -sign * before.factor

        minimize_scalar(opposite_load, bounds=(0.0, after.length), method="bounded",
                        options={"xatol": 0.02 * after.length})
        found += tries.states.values()
    return max(found, key=lambda s: sign * s.factor)


def _bifurcation(tracer, before: State, after: State) -> State:
    """Last state within a step that has not passed a bifurcation."""
    tries, low, high = _Tries(tracer, before, after), 0.0, after.length
    try:
        while high - low > 1e-7 * after.length:
            middle = (low + high) / 2
            if _beyond_limits(tries[middle]) == _beyond_limits(before):
                low = middle
            else:
                high = middle
    except _Missed:
        pass
    return tries.states[low]
