"""Whether the tangents at the ends of a piece of path lead along it, and give its load and reactions."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from mpi4py import MPI
from scipy.optimize import nnls

from .. import rounding
from .segment import Segment

MINOR = 1e-6  # of the forces that an increment adds, reactions that matter little: those of ties that are not pulled


def explained(segment: Segment, left: float, right: float) -> bool:
    """Whether the tangents at the ends of a piece lead along it, and their mean gives its load and reactions."""
    tracer, distance = segment.tracer, segment.distance(left, right)
    load, x = segment.chord(left, right)
    rates, motions = zip(*(segment.states[s].tangent for s in (left, right)), strict=True)
    options = tracer.control
    return (all(tracer.angle((load, x), tangent) <= options.turning for tangent in zip(rates, motions, strict=True))
            and _follows(load, rates, distance, options.unexplained)
            and _is_monotone(load, rates, distance)
            and _follows(_reactions(tracer, x), [_reactions(tracer, motion) for motion in motions],
                         distance, options.unexplained, _reaction_noise(tracer, load, x)))


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
    return bool(rest <= tracer.control.off_load * segment.distance(left, right))


def _rooted(products: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Coordinates of two vectors as columns, and those of a third one, by the products of all three."""
    values, vectors = np.linalg.eigh(products)
    places = np.sqrt(np.maximum(values, 0.0))[:, None] * vectors.T
    return places[:, :2], places[:, 2]


def _reactions(tracer, increment: np.ndarray) -> np.ndarray:
    """Multipliers of prescribed motions, which the inner product does not weigh, on all processes."""
    system = tracer.system
    return np.concatenate(system.comm.allgather(increment[system.multiplier_rows]))


def _reaction_noise(tracer, load_increment: float, increment: np.ndarray) -> float:
    """Rounding of reactions along an increment, and what matters little beside the forces that are added in it."""
    system, added = tracer.system, tracer.load_vector()
    added.array[system.multiplier_rows] = 0.0
    small = MINOR * abs(load_increment) * added.norm()
    moves = np.abs(np.delete(increment, system.multiplier_rows)).max(initial=0.0)
    return small + rounding.last_digits(system, system.comm.allreduce(float(moves), op=MPI.MAX))


def _follows(change, rates: Sequence, distance: float, share: float, noise: float = 0.0) -> bool:
    """Whether a change along a piece is what the mean of its rates makes of it, but for a share of the steeper one."""
    error = np.linalg.norm(change - distance * (rates[0] + rates[1]) / 2)
    return error <= share * distance * max(map(np.linalg.norm, rates)) + noise


def _is_monotone(change: float, rates: Sequence[float], distance: float) -> bool:
    """Whether a value that changes to one side at both ends does so between, and does not turn twice.

    A cubic does if its rates are within a circle of three times that of the chord (Fritsch and Carlson 1980, the region
    S1); a parabola has twice that rate at one end.
    """
    if rates[0] * rates[1] <= 0:
        return True
    return rates[0] * change > 0 and distance * np.hypot(*rates) <= 3 * abs(change)
