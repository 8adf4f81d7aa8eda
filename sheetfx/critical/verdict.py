"""What a path is searched for, so that silence about the rest means absence."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..continuation.control import StepRule
from ..continuation.inertia import can_stick
from ..continuation.problem import Problem
from ..continuation.state import State
from ..discrete.pair_work import PairWork, pairs_of
from .flutter import COUNT

GRAZING = 1e-3  # of the penetration that augmentation leaves, which is none


def searched(discretisation: Problem, control: StepRule, flutter: bool) -> list[str]:
    """What a path under a control is searched for and what not, and which loads have a potential, in sentences.

    Parameters
    ----------
    flutter : whether frequencies are followed
    """
    system = discretisation.system
    found = [*_of_loads(discretisation), *_of_points(system)]
    if not system.conservative and system.smooth:
        found.append(f"flutter: where frequencies meet, of the {COUNT} nearest to zero beside those that have met"
                     if flutter else f"flutter: not looked for ({discretisation.massless})")
    if grazing := sum(_grazing(pairs) for pairs in pairs_of(system.contributions)):
        found.append(f"bifurcations: pairs of points ({grazing}) touch without pressure now, and count as closed: "
                     "modes that take them apart are not seen (give a gap or an imperfection)")
    if not control.guarded:
        found.append("other paths: not looked for, steps are taken as they are")
    elif not system.smooth:
        work = (", or whose work is not the energy stored and dissipated" if system.work_known else
                "; other jumps within steps are not looked for")
        apart = "; where all is apart, one that leaves the smooth path" if pairs_of(system.contributions) else ""
        found.append(f"other paths: a step is cut that turns too far, or leaps beside a critical point{work}{apart}")
    else:
        found.append("other paths: steps that leave the smooth path are cut")
    return found


def _of_loads(discretisation: Problem) -> list[str]:
    """Loads that follow the structure, and whether they have a potential."""
    found = []
    for potential, words in ((True, "have a potential as the structure is supported: the tangent is symmetric"),
                             (False, "have no potential: the tangent is not symmetric")):
        names = sorted({type(load).__name__ for load, has in discretisation.follower.items() if has == potential})
        if names:
            found.append(f"loads: {', '.join(names)} {words}")
    return found


def _of_points(system) -> list[str]:
    if system.rough:
        return ["limit points: where the load turns from one step to the next (contact makes its rate waver)",
                *_of_bifurcations_with_contact(system)]
    if not system.smooth:
        return ["limit points: where the load turns from one step to the next (yielding makes its rate jump)",
                "bifurcations: unstable modes compared at the ends of steps, and between where the load turns; where "
                "something yields or is unloaded eigenvalues jump, and may jump past zero" if system.conservative else
                "bifurcations: not looked for (yielding beside loads without a potential)"]
    counted = ("by the inertia of the tangent" if system.conservative else
               "by the real eigenvalues that pass zero between the tangents of neighbouring states")
    return ["limit points: by the rate of the load",
            f"bifurcations: {counted}, also within steps that the curve through their ends misses"]


def _of_bifurcations_with_contact(system) -> list[str]:
    if not (system.conservative or can_stick(system)):
        return ["bifurcations: not looked for (friction of a Contact, or by a law of one's own, or contact beside "
                "loads without a potential)"]
    found = ["bifurcations: unstable modes compared at the ends of steps, and between where the load turns; where "
             "something begins or ceases to touch or to slip eigenvalues jump, and may jump past zero; what is lost "
             "and regained within one step is not seen (shorter steps: `largest` of the control)",
             "bifurcations with contact: that a path bends away from one, as a slightly imperfect structure's does, is "
             "not seen; a long step may go straight past it, and name that of the perfect structure"]
    if not system.conservative:
        found += ["bifurcations with friction: of the loading tangent, with which what slips slips on, and what sticks "
                  "or is open stays so; not those at which some of it would turn",
                  "flutter: not looked for (friction)"]
    return found


def _grazing(work: PairWork) -> int:
    """Number of pairs that touch and are not pressed."""
    state = work.evaluate()
    near = GRAZING * work.pairs.tolerance
    return int(((np.abs(state.gap) <= near) & (state.pressure <= near * work.pairs.parameters[0])).sum())


def doubts(discretisation: Problem, states: Sequence[State]) -> list[str]:
    """What a traced path has found that may be otherwise, in sentences: bifurcations where pressures are augmented.

    Modes are counted with the stiffness of augmentation, which is softer than the rigid bodies that it stands for: a
    structure on it may have unstable modes that it has not on these.
    """
    works = pairs_of(discretisation.system.contributions)
    names = sorted({work.contact.name for work in works if work.pairs.augmented})
    loads = [p.load for s in states for p in s.critical if p.kind == "bifurcation" and s.contact_points]
    if not names or not loads:
        return []
    which = f"at load {loads[0]:.6g}" + (f" and {len(loads) - 1} more" if len(loads) > 1 else "")
    return [f"bifurcation {which}: where something touches by {', '.join(names)} unstable modes are counted with the "
            "stiffness that pressures are augmented with, and may be its own; what stays with ten times the "
            "`stiffness` is the structure's"]
