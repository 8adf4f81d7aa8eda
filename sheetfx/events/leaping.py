"""Steps that lead to another path where rates of the load waver, as with contact, so that these do not tell.

Where a step has left its path for another one, states of some of its lengths do not converge.
"""

from __future__ import annotations

from ..continuation.segment import Jump, Segment


def leads_around_corner(segment: Segment) -> bool:
    """Whether a step turns more than steps may but around a corner of the path."""
    tracer = segment.tracer
    return tracer.turn(segment.before, segment.after) > tracer.control.turn


def require_convergence(segment: Segment, sound: float) -> None:
    """Refuse a step whose states do not converge between some of its lengths, `sound` being the lower one.

    Raises
    ------
    Jump
    """
    if segment.nonsmooth and segment.tracer.control.guarded and not leads_around_corner(segment):
        state = segment[sound] if sound else None
        raise Jump("states within the step, beside a critical point, do not converge", state)
