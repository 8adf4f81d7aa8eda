"""Defects inside of a piece of path between the states that it is interpolated from.

A defect between the points that an interpolation is made for shows what it misses (Kierzenka and Shampine 2001): a
loop, or another path that runs alongside. It is corrected off the path, by the factor at hand, and in the load, by the
work that is done along the path; if that asks for much, as in slender parts that have turned, by the tangent of that
place.

The leading error of a cubic by values and slopes at its ends is a 16 s^2 (1 - s)^2 with its largest slope 3.08 a: where
it is 0.32 of what the steeper tangent makes of the piece the load may turn within, unseen. A fifth of that is allowed.
"""

from __future__ import annotations

from petsc4py import PETSc

from ..rounding import off_path
from .segment import Segment

INSIDE = 0.875  # of a piece, the place of that: near the end whose tangent is factored
MINOR = 1e-6  # of the load itself, correction that matters little


def interpolates(segment: Segment, left: float, right: float) -> bool:
    """Whether places inside of a piece, as its ends interpolate them, need small corrections only."""
    if segment.close & {left, right}:
        return True
    return _is_near(segment, left, right) and _load_is_near(segment, left, right)


def _is_near(segment: Segment, left: float, right: float) -> bool:
    """Whether a place inside is near the path."""
    tracer, system = segment.tracer, segment.tracer.system
    place, residual = _out_of_balance(segment, left, right, left + INSIDE * (right - left))
    response = system.create_vector(segment.states[right].response)
    small = tracer.control.off_path * segment.distance(left, right)
    off = _across(tracer, residual, response)
    if off > small:
        off = _across(tracer, residual, _response_at(tracer, place))
    system.configure(tracer.x, segment.before.factor)
    return off <= small or off <= max(off_path(tracer, segment.states[s]) for s in (left, right))


def _load_is_near(segment: Segment, left: float, right: float) -> bool:
    """Whether the load that belongs to the middle is near the interpolated one: a loop may end where it began."""
    tracer, system, middle = segment.tracer, segment.tracer.system, (left + right) / 2
    place, residual = _out_of_balance(segment, left, right, middle)
    along = system.create_vector(segment.curve(left, right).derivative()(middle)[:-1])
    steepest = max(abs(segment.states[s].load_rate) for s in (left, right))
    small = tracer.control.off_load * segment.distance(left, right) * steepest + MINOR * abs(system.factor)
    near = abs(residual.dot(along)) <= small * abs(tracer.load_vector().dot(along))
    if not near:
        response, correction, inner = _response_at(tracer, place), residual.duplicate(), tracer.tangent.inner
        tracer.stepper.linear.solve(residual, correction)
        near = abs(inner(correction, response)) <= small * inner(response, response)
    system.configure(tracer.x, segment.before.factor)
    return near


def _out_of_balance(segment: Segment, left: float, right: float, length: float) -> tuple[PETSc.Vec, PETSc.Vec]:
    """Increments at a length, as two states interpolate them, and the residual there; the system stays there."""
    load, increment = segment.interpolated(left, right, length)
    segment.tracer.back_to(segment.before)
    system = segment.tracer.system
    place, residual = system.create_vector(increment), system.create_vector()
    system.configure(place, segment.before.factor + load)
    system.residual(residual)
    return place, residual


def _response_at(tracer, place: PETSc.Vec) -> PETSc.Vec:
    """Response to the load by the tangent of a place where the system is; this is the factor at hand then."""
    response = place.duplicate()
    tracer.system.extrapolate_stress()
    tracer.stepper.factorise(tracer.snes, place)
    tracer.stepper.linear.solve(tracer.load_vector(), response)
    return response


def _across(tracer, residual: PETSc.Vec, response: PETSc.Vec) -> float:
    """Length of the correction by the factor at hand, off the response to the load."""
    correction, inner = residual.duplicate(), tracer.tangent.inner
    tracer.stepper.linear.solve(residual, correction)
    correction.axpy(-inner(correction, response) / inner(response, response), response)
    return inner(correction, correction) ** 0.5
