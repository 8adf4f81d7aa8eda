"""Eigenvalues that pass zero to and fro between two states, told by how fast they change at both.

Where the number of unstable modes is the same at both ends of a piece, a mode may have lost its stability within it and
regained it, such as one off the symmetry that the path keeps. An eigenvalue that dips below zero and is convex lies
above its tangents: these lead through zero within the piece, from both ends. One that is known to pass zero may do so
three times where its tangents lead there at places more than half the piece apart, the one at the left end first. The
rates are mode K' mode, of the change of the tangent K along the path, by central differences: to one side the modes of
slender parts stretch, which is of second order but stiff.
"""

from __future__ import annotations

from collections.abc import Sequence

from petsc4py import PETSc

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
    way, known, from_end = segment.distance(left, right), abs(before - after), {}
    for length in sorted((right, left), key=lambda length: length not in segment.eigenvalues):  # right has a factor
        found = from_end[length] = _headed_for(segment, length, float(length == right), way)
        if len(found) <= known and not any((place > 0.5) == (length == right) for place, _ in found):
            return False
    return min(map(len, from_end.values())) > known or any(
        later - earlier > 0.5 and one * other < 0
        for (earlier, one), (later, other) in zip(from_end[left], from_end[right], strict=False))


def _headed_for(segment: Segment, length: float, start: float, way: float) -> list[tuple[float, float]]:
    """Parts of a piece at which eigenvalues of one of its ends lead through zero, in order, and these eigenvalues."""
    return sorted((place, value) for value, rate in eigenvalues(segment, length)
                  if rate and 0 < (place := start - value / (way * rate)) < 1)


def eigenvalues(segment: Segment, length: float) -> list[tuple[float, float]]:
    """Eigenvalues nearest to zero at a state, and their rates along the path."""
    if length not in segment.eigenvalues:
        segment.eigenvalues[length] = _with_rates(segment.tracer, segment.states[length])
        if length == segment.after.length:
            segment.tracer.softest = segment.after, segment.eigenvalues[length]
    return segment.eigenvalues[length]


def _with_rates(tracer: Tracer, state: State) -> list[tuple[float, float]]:
    """The same; the infinite ones of multipliers, which have no weight, are rounding beside the nearest to zero."""
    tracer.factorise_at(state)
    values, modes = tracer.spectrum(min(MODES, tracer.system.size), ABOUT)
    nearest = min(map(abs, values), default=0.0)
    kept = [(value, mode) for value, mode in zip(values, modes, strict=True) if SAME * abs(value) <= nearest]
    ahead, behind = (_stiffnesses(tracer, state, sign * DIFFERENCE, [mode for _, mode in kept]) for sign in (1.0, -1.0))
    found = [(value, (one - other) / (2 * DIFFERENCE))
             for (value, _), one, other in zip(kept, ahead, behind, strict=True)]
    tracer.back_to(state)
    return found


def _stiffnesses(tracer: Tracer, state: State, way: float, modes: Sequence[PETSc.Vec]) -> list[float]:
    """mode K mode for each mode, where the tangent of a state leads in a way."""
    system, (rate, motion) = tracer.system, state.tangent
    tracer.back_to(state)
    with system.additive_increments():
        system.configure(system.create_vector(way * motion), state.factor + way * rate)
        system.extrapolate_stress()
        there, image, found = system.tangent(), system.create_vector(), []
        for mode in modes:
            there.mult(mode, image)
            found.append(image.dot(mode))
    return found
