"""The balance of work and energy along a step, which holds between states of one path however its rates waver.

What the loads do on the way from one state to the next is the change of the energy, and what friction takes. With these
known a path that leads there gives its loads in between: a step whose loads do not fit has jumped to another path.
"""

from __future__ import annotations

import numpy as np

from .segment import Segment
from .state import State

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
    follows = earlier is not None and before.stage == after.stage and before.length > 0
    change, way, way_before = _energy(segment, before.increment if follows else 0 * after.increment)
    rise = after.load_increment
    expected, steepest, farthest = rise * way / 2, abs(rise), abs(way)
    if follows:
        share = after.length / before.length
        bends = [share * (share * a - b) / (1 + share) for a, b in ((before.load_increment, rise), (way_before, way))]
        expected += (bends[0] * way - bends[1] * rise) / 6
        steepest = max(steepest, share * abs(before.load_increment))
        farthest = max(farthest, share * abs(way_before))
    allowed = tracer.control.unbalanced * steepest + WAVER * abs(after.factor)
    return abs(change - expected) <= allowed * max(abs(way), ASIDE * farthest)


def _energy(segment: Segment, increment_before: np.ndarray) -> tuple[float, float, float]:
    """Work taken up from the first to the last state less that of the load of the first, and motions along the load.

    That of the segment, and that of an increment before it along the load at its start.
    """
    before, after, tracer = segment.before, segment.after, segment.tracer
    system, increment = tracer.system, after.increment
    rough, smooth = system.rough, [c for c in system.contributions if c not in system.rough]
    out, moved, ways = system.create_vector(), system.create_vector(), []
    tracer.back_to(before)
    places = [c.place() for c in rough]

    def taken():
        return sum(c.stored_and_dissipated(place) for c, place in zip(rough, places, strict=True))

    stored = -taken()
    load = tracer.load_vector().array
    ways.append(load @ increment)
    way_before = load @ increment_before
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
    change, way, way_before = (system.comm.allreduce(float(v)) for v in (change, sum(ways) / 2, way_before))
    return change + stored, way, way_before
