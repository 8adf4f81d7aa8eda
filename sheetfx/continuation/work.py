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
ASIDE = 0.1  # of the motion of the step before, least one that counts: others go on where the load's own stands still
POINTS = 5  # of integration of residuals along a straight way: exact for energies of degree 10


def work_matches(segment: Segment, earlier: State | None) -> bool:
    """Whether the work along a step is stored or dissipated; also where contributions do not tell their work.

    Load and motion in between are those of parabolas through the states, `earlier` being the one before the step.
    """
    before, after, tracer = segment.before, segment.after, segment.tracer
    if not tracer.system.work_known:
        return True
    change, way = _energy(segment)
    rise = after.load_increment
    expected, steepest, farthest = rise * way / 2, abs(rise), abs(way)
    if earlier is not None and before.stage == after.stage and before.length:
        share, way_before = after.length / before.length, _way(segment, before)
        bends = [share * (share * a - b) / (1 + share) for a, b in ((before.load_increment, rise), (way_before, way))]
        expected += (bends[0] * way - bends[1] * rise) / 6
        steepest = max(steepest, share * abs(before.load_increment))
        farthest = max(farthest, share * abs(way_before))
    allowed = UNBALANCED * steepest + WAVER * abs(after.factor)
    return abs(change - expected) <= allowed * max(abs(way), ASIDE * farthest)


def _way(segment: Segment, state: State) -> float:
    """Motion of the step that led to a state, along the load where the segment starts."""
    segment.tracer.back_to(segment.before)
    load = segment.tracer.load_vector().array
    segment.tracer.back_to(segment.after)
    return segment.tracer.system.comm.allreduce(float(load @ state.increment))


def _energy(segment: Segment) -> tuple[float, float]:
    """Work taken up from the first to the last state less that of the load of the first, and motion along the load."""
    before, after, tracer = segment.before, segment.after, segment.tracer
    system, increment = tracer.system, after.increment
    smooth, rough = ([c for c in system.contributions if (c.smooth or c.remembers) == wanted]
                     for wanted in (True, False))
    out, moved, ways = system.create_vector(), system.create_vector(), []
    tracer.back_to(before)
    places = [c.place() for c in rough]

    def taken():
        return sum(c.taken(place) for c, place in zip(rough, places, strict=True))

    stored = -taken()
    ways.append(tracer.load_vector().array @ increment)
    points, weights = np.polynomial.legendre.leggauss(POINTS)
    change = 0.0
    with system.additive_increments(frozen=False):
        for part, weight in zip((1 + points) / 2, weights / 2, strict=True):
            moved.array[:] = part * increment
            system.configure(moved, before.factor)
            system.residual_of(smooth, out)
            change += weight * float(out.array @ increment)
        moved.array[:] = increment
        system.configure(moved, before.factor)
        stored += taken()
        system.load(out)
        ways.append(out.array @ increment)
    tracer.back_to(after)
    change, way = (system.comm.allreduce(float(value)) for value in (change, sum(ways) / 2))
    return change + stored, way
