"""The balance of work and energy along a step, which holds between states of one path however its rates waver.

What the loads do on the way from one state to the next is the change of the energy, and what friction takes. With these
known a path that leads there gives its loads in between: a step whose loads do not fit has jumped to another path.
"""

from __future__ import annotations

import numpy as np

from .segment import Segment
from .state import State

UNBALANCED = 0.1  # of the work by the changes of load of this step and the one before
WAVER = 1e-3  # of the work by the whole load, that loads which waver may be off
POINTS = 5  # of integration of residuals along a straight way: exact for energies of degree 10


def work_matches(segment: Segment, earlier: State | None) -> bool:
    """Whether the work along a step is stored or dissipated; also where contributions do not tell their work.

    The load in between is that of the parabola through the states, `earlier` being the one before the step.
    """
    before, after, tracer = segment.before, segment.after, segment.tracer
    if not tracer.system.work_known:
        return True
    change, way = _energy(segment)
    rise = after.load_increment
    expected, steepest = rise * way / 2, abs(rise)
    if earlier is not None and before.stage == after.stage and before.length:
        expected += _bend(before, after) * way / 6
        steepest = max(steepest, abs(before.load_increment) * after.length / before.length)
    return abs(change - expected) <= UNBALANCED * steepest * abs(way) + WAVER * abs(after.factor * way)


def _bend(before: State, after: State) -> float:
    """Of the parabola through the loads of three states, its rise above the last chord, times 4."""
    rates = [state.load_increment / state.length for state in (before, after)]
    return (rates[0] - rates[1]) * after.length**2 / (before.length + after.length)


def _energy(segment: Segment) -> tuple[float, float]:
    """Work taken up from the first to the last state less that of the load of the first, and motion along the load."""
    before, after, tracer = segment.before, segment.after, segment.tracer
    system, increment = tracer.system, after.increment
    smooth, rough = ([c for c in system.contributions if (c.smooth or c.remembers) == wanted]
                     for wanted in (True, False))
    out, place, ways = system.create_vector(), system.create_vector(), []
    tracer.back_to(before)
    stored = -sum(c.taken() for c in rough)
    ways.append(tracer.load_vector().array @ increment)
    points, weights = np.polynomial.legendre.leggauss(POINTS)
    change = 0.0
    with system.additive_increments(frozen=False):
        for part, weight in zip((1 + points) / 2, weights / 2, strict=True):
            place.array[:] = part * increment
            system.configure(place, before.factor)
            system.residual_of(smooth, out)
            change += weight * float(out.array @ increment)
        place.array[:] = increment
        system.configure(place, before.factor)
        stored += sum(c.taken() for c in rough)
        system.load(out)
        ways.append(out.array @ increment)
    tracer.back_to(after)
    change, way = (system.comm.allreduce(float(value)) for value in (change, sum(ways) / 2))
    return change + stored, way
