"""What a path is searched for, so that silence about the rest means absence."""

from __future__ import annotations

from ..continuation.control import StepRule
from ..discrete.discretisation import Discretisation
from .flutter import COUNT


def searched(discretisation: Discretisation, control: StepRule, flutter: bool) -> list[str]:
    """What a path under a control is searched for and what not, and which loads have a potential, in sentences.

    Parameters
    ----------
    flutter : whether frequencies are followed
    """
    system = discretisation.system
    found = [*_of_loads(discretisation), *_of_points(system)]
    if not system.conservative and system.smooth:
        found.append(f"flutter: where frequencies meet, of the {COUNT} nearest to zero beside those that have met"
                     if flutter else "flutter: not looked for (a part has no density)")
    if not control.guarded:
        found.append("other paths: not looked for, steps are taken as they are")
    elif not system.smooth:
        found.append("other paths: a step that turns too far is cut, " + (
            "or whose work is not what is stored and dissipated" if system.work_known else
            "jumps within steps are not looked for"))
    else:
        found.append("other paths: steps that leave the smooth path are cut")
    return found


def _of_loads(discretisation: Discretisation) -> list[str]:
    """Loads that follow the structure, and whether they have a potential."""
    found = []
    for potential, words in ((True, "have a potential as the structure is supported: the tangent is symmetric"),
                             (False, "have no potential: the tangent is not symmetric")):
        names = sorted({type(load).__name__ for load, has in discretisation.follower.items() if has == potential})
        if names:
            found.append(f"loads: {', '.join(names)} {words}")
    return found


def _of_points(system) -> list[str]:
    if not system.smooth:
        return ["limit points: where the load turns from one step to the next (contact makes its rate waver)",
                "bifurcations: unstable modes compared at the ends of steps only" if system.conservative else
                "bifurcations: not looked for (contact with friction)"]
    counted = ("by the inertia of the tangent" if system.conservative else
               "by the real eigenvalues that pass zero between the tangents of neighbouring states")
    return ["limit points: by the rate of the load",
            f"bifurcations: {counted}, also within steps that the tangents at their ends do not explain"]
