"""Why a step fails, and what to do about it, as the states and the residuals before it tell."""

from __future__ import annotations

from math import copysign, inf

from .control import ArcLength, DisplacementControl, LoadControl, StepRule
from .state import State
from .tracer import Tracer

THROUGH = "follow the path through it by fx.ArcLength() or fx.DisplacementControl(...)"


def explained_failure(control: StepRule, tracer: Tracer, before: State | None, state: State,
                      length: float) -> tuple[str, str] | None:
    """Cause and remedy of a failure of steps from a state; None: nothing tells.

    Parameters
    ----------
    before : state before that one
    length : of the shortest step that has been tried
    """
    if any(point.name == "comparison solid" and point.length == state.length for point in state.critical):
        return ("points that begin to flow there take the stability of the comparison solid (Hill 1958): a "
                "bifurcation, and no state close behind it is found", "follow the path by another control or steps")
    limit = _limit_ahead(before, state, length) if before and isinstance(control, LoadControl) else None
    if limit is not None:
        return (f"a limit point lies just ahead, at a load of about {limit:.6g}, as the stiffness along the path falls "
                "to zero; load control finds no state beyond it",
                f"{THROUGH}, or let the structure fall from the last state by `record.snap(state)`")
    flowing = _plastic_limit(tracer, before, state, length) if before and isinstance(control, LoadControl) else None
    if flowing is not None:
        return (f"points flow, so that the load has its limit at about {flowing:.6g} (plastic collapse); load control "
                "finds no state beyond it", THROUGH)
    if found := _unfinished(tracer, state):
        return found, "look at the strains and the law of that part, and at its numbers"
    if tracer.stepper.rounds:
        return (f"the residual is rounding (relative residuals {tracer.stepper.history[-1]:.1e} at last), as the load "
                "is too small beside the stiffness of the structure", "give a larger load and scale the results")
    return None


def several_modes(count: int, state: State) -> tuple[str, str]:
    """What a refusal means where the number of unstable modes changes by several within a step, and a remedy."""
    return (f"; {count} modes change their stability together in a step from there, at a multiple point or points very "
            "close to each other, which this path does not tell apart",
            "find it by fx.critical(path, state, kind=...), or make parts slightly unequal")


def _plastic_limit(tracer: Tracer, before: State, state: State, length: float) -> float | None:
    """Load at the monitored displacement of one step more, where points flow; None: it is beyond the last try."""
    way = abs(state.deflection - before.deflection)
    tracer.back_to(state)
    if not any(c.remembers for c in tracer.system.contributions) or not way or not tracer.rate("deflection"):
        return None
    beyond = tracer.attempt_by(DisplacementControl(), way)
    tracer.back_to(state)
    return beyond.load if beyond is not None and abs(beyond.factor - state.factor) <= length else None


def at_rest(control: StepRule, tracer: Tracer, state: State) -> tuple[str, str] | None:
    """Cause and remedy where the structure answers more load with almost no displacement; None: it does not."""
    cylindrical = isinstance(control, ArcLength) and control.shape == "cylindrical"
    if tracer.system.smooth or not cylindrical or not state.factor:
        return None
    by_load = LoadControl(target=copysign(inf, control.direction(state)))
    for power in (1, 2, 3):
        tracer.back_to(state)
        beyond = tracer.attempt_by(by_load, control.with_contact**power * abs(state.factor))
        tracer.back_to(state)
        if beyond is not None:
            if tracer.distance(0.0, beyond.response) > control.smallest * tracer.distance(0.0, state.response):
                return None
            return ("what the load acts on rests against something, so that displacements no longer grow with the "
                    "load, by which a cylindrical arc length measures steps",
                    "give fx.ArcLength(shape='elliptical'), which measures the load too, or fx.LoadControl(...)")
    return None


def _unfinished(tracer: Tracer, state: State) -> str:
    """What had no numbers in the last step that has been tried from a state; "": nothing."""
    stepper = tracer.stepper
    if stepper.unfinished is None:
        return ""
    tracer.x.array[:] = stepper.unfinished
    tracer.system.configure(tracer.x, stepper.factor_now)
    found = tracer.discretisation.without_numbers(f"in step {state.step + 1}")
    tracer.back_to(state)
    return found


def _limit_ahead(before: State, state: State, length: float) -> float | None:
    """Load of a limit point within a step of load control; None: nothing tells of one.

    About a limit point the load lacks of its extreme what is proportional to the square of its rate, which is that of
    the current stiffness parameter.
    """
    now, then = state.current_stiffness, before.current_stiffness
    if before.stage != state.stage or now * then <= 0 or abs(now) >= abs(then):
        return None
    part = now**2 / (then**2 - now**2)
    if part * abs(state.factor - before.factor) > length:
        return None
    return state.load + part * (state.load - before.load)
