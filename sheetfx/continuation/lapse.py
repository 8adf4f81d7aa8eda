"""What steps forget: strains that turn back within them, as where points cease to flow and unload.

A law with history goes from the strains at the start of a step to those at its end at once. That is exact where they
have gone in proportion (Simo and Hughes 1998, section 1.4.3, along one axis): what flowed on a way that turned back is
forgotten. Along the parabola through the strains at the start, halfway and at the end the law is therefore followed in
short pieces too. The power of the resultants by which both differ, over that of all resultants, is the share of the
load that is forgotten, since loads do the power of resultants along a path. A step that forgets more is divided.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..notices import warn
from .segment import Jump
from .state import State

PIECES = 4  # of a step, along which laws are followed


def remembering(tracer, before: State, after: State) -> State:
    """A step with the share of the load that it forgets; the tracer ends at it.

    Raises
    ------
    Jump
        If a step up to an earlier place forgets less, and is not too short, where the control is guarded.
    """
    control = tracer.control
    shares = _forgotten(tracer, before, after)
    wrong = np.flatnonzero(shares > control.forgotten)
    length = after.length * max(int(wrong[0]), 1) / PIECES if len(wrong) else after.length
    if control.guarded and control.smallest * tracer.shortest < length < after.length:
        tracer.back_to(before)
        raise Jump("strains turn back within it", tracer.attempt(length))
    if shares[-1] > control.forgotten:
        warn(f"step {after.step}: strains turn back within it, which its law forgets: loads from {after.load:.6g} on may "
             f"be off by {shares[-1]:.1%}; follow the path by shorter steps")
    tracer.state = replace(after, forgotten=float(shares[-1]))
    return tracer.state


def _forgotten(tracer, before: State, after: State) -> np.ndarray:
    """Share of the load that a step forgets, had it ended after each of its pieces; the tracer ends at its end."""
    system = tracer.system
    laws, x = [c for c in system.contributions if c.remembers], system.create_vector()
    if not laws:
        return np.zeros(PIECES)
    tracer.back_to(before)
    x.array[:] = after.increment / 2
    system.configure(x, before.factor + after.load_increment / 2)
    for law in laws:
        law.keep_halfway()
    x.array[:] = after.increment
    system.configure(x, after.factor)
    lost, whole = system.comm.allreduce(sum(law.forgotten(PIECES) for law in laws))
    tracer.back_to(after)
    return np.abs(lost) / np.maximum(whole, np.finfo(float).tiny)
