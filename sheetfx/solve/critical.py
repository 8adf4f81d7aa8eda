"""Critical points between two converged states: found by sign changes, refined by restarts."""

from __future__ import annotations

from scipy.optimize import brentq

from ..state import CriticalPoint, State


def locate(tracer, before: State, after: State) -> tuple[CriticalPoint, ...]:
    """Critical points inside the step from `before` to `after`; the tracer ends at `after`.

    A change of sign of the load rate is a limit point; another change in the number of unstable
    directions is a bifurcation. Both are refined by repeating the step with other lengths.
    """
    if before.step == 0 and before.length == 0 and after.length == 0:
        return ()
    point = None
    if before.load_rate * after.load_rate < 0:
        point = _refine(tracer, before, after, "limit", lambda s: s.load_rate)
    elif None not in (before.unstable, after.unstable) and before.unstable != after.unstable:
        point = _refine(tracer, before, after, "bifurcation",
                        lambda s: 0.5 if s.unstable == before.unstable else -0.5)
    if point is None:
        return ()
    tracer.back_to(after)
    return (point,)


class _Missed(ArithmeticError):
    """A step of a shorter length does not converge."""


def _refine(tracer, before, after, kind, test) -> CriticalPoint:
    tried = {0.0: before, after.length: after}

    def value(length: float) -> float:
        if length not in tried:
            tracer.back_to(before)
            state = tracer.attempt(length)
            if state is None:
                raise _Missed
            tried[length] = state
        return test(tried[length])

    try:
        brentq(value, 0.0, after.length, xtol=1e-7 * after.length)
    except _Missed:
        pass
    if kind == "limit":
        best = (max if before.load_rate > 0 else min)(tried.values(), key=lambda s: s.factor)
    else:
        best = _last_like(tried, before)
    return CriticalPoint(kind, best.load, best.deflection, after.step)


def _last_like(tried: dict[float, State], before: State) -> State:
    """The longest step that still has as many unstable directions as the state before."""
    return tried[max(length for length, s in tried.items() if s.unstable == before.unstable)]
