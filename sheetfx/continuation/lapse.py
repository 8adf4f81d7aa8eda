"""What steps forget: strains that turn back within them, as where points cease to flow and unload.

A law with history goes from the strains at the start of a step to those at its end at once. Along one axis that is
exact where they go one way (Simo and Hughes 1998, section 1.4.3); what flowed on a way that turned back is forgotten.
Along the cubic through both states with their tangents the law is therefore followed in short pieces too. The
resultants by which both differ are forgotten: what they tell of the load is their power along the way over that of all
resultants, and how far the step has led off the path is the correction of their forces by the tangent. Both fall with
the square of the length; a step is divided until they are small (as by the local errors of methods for differential
equations; Hairer, Norsett and Wanner 1993, section II.4).
"""

from __future__ import annotations

from dataclasses import replace
from math import inf, sqrt

import numpy as np

from ..notices import warn
from .control import StepRule
from .segment import Jump, Segment
from .state import State


def remembering(tracer, before: State, after: State) -> State:
    """A step with what it forgets; the tracer ends at it.

    Raises
    ------
    Jump
        If it forgets too much, with the state halfway, unless that is too near or the control is not guarded.
    """
    control = tracer.control
    load, off = _forgotten(tracer, before, after)
    if load > control.forgotten or off > control.astray:
        if control.guarded and after.length / 2 > control.smallest * tracer.shortest:
            tracer.back_to(before)
            raise Jump("strains turn back within it", tracer.attempt(after.length / 2))
        warn(f"step {after.step}: strains turn back within it, which its law forgets: the load {after.load:.6g} is off "
             f"by {load:.1%} and the step by {off:.1%} of its length; follow the path by shorter steps")
    tracer.state = replace(after, forgotten=load, astray=off)
    return tracer.state


def growth_by_history(control: StepRule, state: State) -> float:
    """Factor on the next step's length, with which it forgets as much as is allowed; infinite: the last forgot nothing."""
    ratios = (state.forgotten / control.forgotten, state.astray / control.astray)
    return 1 / sqrt(max(ratios)) if max(ratios) else inf


def _forgotten(tracer, before: State, after: State) -> tuple[float, float]:
    """Share of resultants that a step forgets, and its error off the path over its length; the tracer ends at its end."""
    system = tracer.system
    laws = [c for c in system.contributions if c.remembers]
    if not laws:
        return 0.0, 0.0
    middle = Segment(tracer, before, after).curve(0.0, after.length)(after.length / 2)
    tracer.back_to(before)
    system.configure(system.create_vector(middle[:-1]), before.factor + middle[-1])
    for law in laws:
        law.keep_halfway()
    system.configure(system.create_vector(after.increment), after.factor)
    lost, powers = system.create_vector(), np.zeros(2)
    system.residual_of(laws, lost, lambda law, forces: np.add(powers, law.forgotten(forces), out=powers))
    tracer.back_to(after)
    if not lost.norm() > 0:
        return 0.0, 0.0
    tracer.factorise_at(after)
    error, response, inner = lost.duplicate(), system.create_vector(after.response), tracer.tangent.inner
    tracer.stepper.linear.solve(lost, error)
    error.axpy(-inner(error, response) / inner(response, response), response)
    forgotten, whole = system.comm.allreduce(powers)
    return forgotten / whole, sqrt(inner(error, error)) / tracer.distance(*after.direction)
