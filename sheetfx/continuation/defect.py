"""The defect of a piece of path: how far off the path Hermite's cubic is that its two states and their tangents make.

Inside of the piece the cubic is out of balance; one Newton correction there tells by how much, off the path and in the
load (Enright 2000; Kierzenka and Shampine 2001). The defect shows a loop, another path that runs alongside, and
tangents that do not lead along the piece. The correction uses the factor at hand, and only if that asks for much, as in
slender parts that have turned, the tangent of that place.

Where s runs from 0 to 1, the error of the cubic is s^2 (1 - s)^2 (a + b (s - 1/2)) to the first two orders. A single
place shows both: at 0.65 the first term has 0.83 of its largest value and the second 0.87.

Where points begin or cease to flow within the piece it may have a corner instead.
"""

from __future__ import annotations

import numpy as np
from petsc4py import PETSc
from scipy.optimize import nnls

from ..rounding import SAFETY, noise
from .segment import Segment

INSIDE = 0.65  # of a piece, the place whose defect is taken
SHORTEST = 1 / 64  # of a step, or of the amplitude of a branch, piece whose defect must be small


def has_small_defect(segment: Segment, left: float, right: float) -> bool:
    """Whether the cubic between two states has a small defect.

    Off the path the defect counts over the length of the piece, in the load over the way that the load goes to and fro,
    beyond what the solver leaves of the load itself: that stays as it is where a structure collapses.
    """
    tracer, system, allowed = segment.tracer, segment.tracer.system, segment.tracer.control.defect
    cubic, (exact, *_) = segment.curve(left, right), tracer.snes.getTolerances()
    loads = cubic(np.sort([left, right, *_turns(cubic, left, right)]))[:, -1]
    place, residual = _out_of_balance(segment, cubic(left + INSIDE * (right - left)))
    least = SAFETY * exact * abs(system.factor)
    most = allowed * segment.distance(left, right), allowed * np.abs(np.diff(loads)).sum() + least
    off, load = _correction(tracer, residual, system.create_vector(segment.states[right].response))
    if off > most[0] or load > most[1]:
        response = _response_at(tracer, place)
        off, load = _correction(tracer, residual, response)
        if off > most[0]:
            off -= SAFETY * _correction(tracer, noise(system, place), response)[0]
    system.configure(tracer.x, segment.before.factor)
    return off <= most[0] and load <= most[1]


def cornered(segment: Segment, left: float, right: float) -> bool:
    """Whether the tangents at the ends of a piece lead along it to a corner and on from there, in motions and load.

    Loads count over the steeper rate of both. What laws with history may forget of the first rate of the path is the
    least: where all points flow little is left of stiffness, and none of resistance.
    """
    tracer, states = segment.tracer, [segment.states[s] for s in (left, right)]
    ways = [*(state.tangent for state in states), segment.chord(left, right)]
    steepest = max(*(abs(state.load_rate) for state in states),
                   tracer.control.forgotten / segment.before.reference[0] ** 0.5)
    products = np.array([[tracer.inner((0.0, one[1]), (0.0, other[1])) + one[0] * other[0] / steepest**2
                          for one in ways] for other in ways])
    _, rest = nnls(*_rooted(products))
    return bool(rest <= tracer.control.defect * segment.distance(left, right))


def _turns(cubic, left: float, right: float) -> list[float]:
    """Lengths between two ends at which the load of a piece is stationary."""
    roots = cubic.derivative().c[:, 0, -1]
    return [left + float(r.real) for r in np.roots(roots) if not r.imag and 0 < r.real < right - left]


def _out_of_balance(segment: Segment, increments: np.ndarray) -> tuple[PETSc.Vec, PETSc.Vec]:
    """Increments of the unknowns since a step began, without the load's, and the residual; the system stays there."""
    segment.tracer.back_to(segment.before)
    system = segment.tracer.system
    place, residual = system.create_vector(increments[:-1]), system.create_vector()
    system.configure(place, segment.before.factor + float(increments[-1]))
    system.residual(residual)
    return place, residual


def _response_at(tracer, place: PETSc.Vec) -> PETSc.Vec:
    """Response to the load by the tangent of a place where the system is; this is the factor at hand then."""
    response = place.duplicate()
    tracer.system.extrapolate_stress()
    tracer.stepper.factorise(tracer.snes, place)
    tracer.stepper.linear.solve(tracer.load_vector(), response)
    return response


def _correction(tracer, residual: PETSc.Vec, response: PETSc.Vec) -> tuple[float, float]:
    """Length of the correction by the factor at hand, off the response to the load, and its size in the load factor."""
    correction, inner = residual.duplicate(), tracer.tangent.inner
    tracer.stepper.linear.solve(residual, correction)
    load = inner(correction, response) / (inner(response, response) + tracer.tangent.least_weight)
    correction.axpy(-load, response)
    return inner(correction, correction) ** 0.5, abs(load)


def _rooted(products: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Coordinates of two vectors as columns, and a third one's, by the products of all three."""
    values, vectors = np.linalg.eigh(products)
    places = np.sqrt(np.maximum(values, 0.0))[:, None] * vectors.T
    return places[:, :2], places[:, 2]
