"""What steps forget: strains that turn back within them, as where points cease to flow and unload.

A law with history goes from the strains at the start of a step to those at its end at once. Along one axis that is
exact where they go one way (Simo and Hughes 1998, section 1.4.3); what flowed on a way that turned back is forgotten.
The law is therefore also followed in short pieces, along the curve through all known states of the step with their
tangents. The resultants by which both differ are forgotten.

Their power along the way, over all resultants' power, tells how far the load is off, at the end of the step or at a
state within it. The correction of their forces by the tangent tells how far the step has led off the path. Both fall
with the square of the length. A step is divided until they are small, as by the local errors of methods for
differential equations (Hairer, Norsett and Wanner 1993, section II.4).
"""

from __future__ import annotations

from dataclasses import replace
from math import inf, sqrt

import numpy as np

from ..notices import warn
from .control import StepRule
from .segment import Jump, Segment
from .state import State


def remembering(segment: Segment) -> State:
    """The end of a step with what the step forgets; the tracer ends there.

    Raises
    ------
    Jump
        If it forgets too much, with the state halfway, unless that is too near or the control is not guarded.
    """
    tracer, control, after = segment.tracer, segment.tracer.control, segment.after
    half = after.length / 2
    load, off = _forgotten(segment)
    if load > control.forgotten or off > control.astray:
        if control.guarded and half > control.smallest * tracer.shortest:
            raise Jump("strains turn back within it", segment.states[half] if segment.reach(half) else None)
        warn(f"step {after.step}: strains turn back within it, which its law forgets: the load {after.load:.6g} is off "
             f"by {load:.1%} and the step by {off:.1%} of its length; follow the path by shorter steps")
    tracer.state = replace(after, forgotten=load, astray=off)
    return tracer.state


def growth_by_history(control: StepRule, state: State) -> float:
    """Factor on the next step's length, with which it forgets what it may; infinite: the last one forgot nothing."""
    ratios = (state.forgotten / control.forgotten, state.astray / control.astray)
    return 1 / sqrt(max(ratios)) if max(ratios) else inf


def _forgotten(segment: Segment) -> tuple[float, float]:
    """Largest share of resultants that a step forgets on its way, and its error off the path over its length.

    The tracer ends at its end.
    """
    tracer, system, before, after = segment.tracer, segment.tracer.system, segment.before, segment.after
    laws = [c for c in system.contributions if c.remembers]
    for left, right in segment.pairs():
        for length in ((left + right) / 2, right):
            load, x = segment.dense.at(length, segment.states)
            system.configure(system.create_vector(x), before.factor + load)
            for law in laws if length < after.length else ():
                law.pass_by(begins=not left and length < right)
    lost, powers = system.create_vector(), []
    system.residual_of(laws, lost, lambda law, forces: powers.append(law.forgotten(forces)))
    tracer.back_to(after)
    forgotten, whole = system.comm.allreduce(sum(powers)).T
    share = float(np.max(forgotten / np.maximum(whole, np.finfo(float).tiny)))
    if not lost.norm() > 0:
        return share, 0.0
    tracer.factorise_at(after)
    error, response, inner = lost.duplicate(), system.create_vector(after.response), tracer.tangent.inner
    tracer.stepper.linear.solve(lost, error)
    error.axpy(-inner(error, response) / (inner(response, response) + after.least_weight), response)
    return share, sqrt(inner(error, error)) / tracer.distance(*after.direction)
