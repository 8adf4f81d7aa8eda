"""Eigenvalues that pass zero to and fro between two states, told by how fast they change at both.

Where the number of unstable modes is the same at both ends of a piece, a mode may have lost its stability within it and
regained it, such as one off the symmetry that the path keeps. An eigenvalue that dips below zero and is convex lies
above its tangents: these lead through zero within the piece, from both ends. One that is known to pass zero may do so
three times where its tangents lead there at places more than half the piece apart, the one at the left end first. The
rates are mode K' mode, of the change of the tangent K along the path.
"""

from __future__ import annotations

from ..continuation.segment import Segment
from ..continuation.state import State
from ..continuation.tracer import Tracer
from ..rounding import DIFFERENCE, SAME
from .determinant import ABOUT

MODES = 4  # nearest to zero, whose eigenvalues are followed


def hides(segment: Segment, left: float, right: float) -> bool:
    """Whether eigenvalues head for zero within a piece, from both of its ends, more often than they are known to."""
    if (left, right) in segment.looked:
        return False
    segment.looked.add((left, right))
    before, after = (segment.states[length].unstable_modes for length in (left, right))
    if before is None or after is None or not segment.tracer.system.conservative:
        return False
    way, known = segment.distance(left, right), abs(before - after)
    from_right = _headed_for(segment, right, 1.0, way)  # where the factor is at hand
    if len(from_right) <= known and not any(place > 0.5 for place, _ in from_right):
        return False
    from_left = _headed_for(segment, left, 0.0, way)
    return min(len(from_left), len(from_right)) > known or any(
        later - earlier > 0.5 and one * other < 0
        for (earlier, one), (later, other) in zip(from_left, from_right, strict=False))


def _headed_for(segment: Segment, length: float, start: float, way: float) -> list[tuple[float, float]]:
    """Parts of a piece at which eigenvalues of one of its ends lead through zero, in order, and these eigenvalues."""
    return sorted((place, value) for value, rate in _eigenvalues(segment, length)
                  if rate and 0 < (place := start - value / (way * rate)) < 1)


def _eigenvalues(segment: Segment, length: float) -> list[tuple[float, float]]:
    """Eigenvalues nearest to zero at a state, and their rates along the path."""
    if length not in segment.eigenvalues:
        segment.eigenvalues[length] = _with_rates(segment.tracer, segment.states[length])
    return segment.eigenvalues[length]


def _with_rates(tracer: Tracer, state: State) -> list[tuple[float, float]]:
    """The same; the infinite ones of multipliers, which have no weight, are rounding beside the nearest to zero."""
    tracer.factorise_at(state)
    values, modes = tracer.spectrum(min(MODES, tracer.system.size), ABOUT)
    nearest = min(map(abs, values), default=0.0)
    rate, motion = state.tangent
    system, image = tracer.system, tracer.system.create_vector()
    with system.additive_increments():
        system.configure(system.create_vector(DIFFERENCE * motion), state.factor + DIFFERENCE * rate)
        system.extrapolate_stress()
        there, found = system.tangent(), []
        for value, mode in zip(values, modes, strict=True):
            if SAME * abs(value) > nearest:
                continue
            there.mult(mode, image)
            found.append((value, (image.dot(mode) - value) / DIFFERENCE))
    tracer.back_to(state)
    return found
