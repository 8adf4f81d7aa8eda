"""Steps that lead to another path where rates of the load waver, as with contact, so that these do not tell.

Where a step has left its path for another one its states, as functions of their lengths, have a gap somewhere: however
close the lengths are there, the states stay apart.
"""

from __future__ import annotations

from ..continuation.segment import Jump, Segment
from ..continuation.state import State

LEAP = 4  # of as much of the step on average, distance of neighbouring states from which no path joins them


def leads_around_corner(segment: Segment) -> bool:
    """Whether a step turns more than steps may but around a corner of the path."""
    tracer = segment.tracer
    return tracer.turn(segment.before, segment.after) > tracer.control.turn


def _guarded(segment: Segment) -> bool:
    return segment.wavering and segment.tracer.control.guarded and not leads_around_corner(segment)


def require_convergence(segment: Segment, sound: float) -> None:
    """Refuse a step whose states do not converge between some of its lengths, `sound` being the lower one.

    Raises
    ------
    Jump
    """
    if _guarded(segment):
        raise Jump("states within the step, beside a critical point, do not converge", _sound(segment, sound))


def _sound(segment: Segment, length: float) -> State | None:
    return segment[length] if length else None


def require_path(segment: Segment, left: float, right: float) -> None:
    """Refuse neighbouring states that are further apart than as much of the step is elsewhere.

    Parameters
    ----------
    left, right : their lengths

    Raises
    ------
    Jump
    """
    if not _guarded(segment):
        return
    near, whole = ((segment.distance(a, b), b - a) for a, b in ((left, right), (0.0, segment.after.length)))
    if near[0] * whole[1] > LEAP * near[1] * whole[0]:
        raise Jump("states within the step are apart, however close their lengths", _sound(segment, left))
