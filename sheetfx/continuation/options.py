"""Every number of the path follower that is a user's: keywords of each control, such as `ArcLength(turn=pi)`."""

from __future__ import annotations

from dataclasses import KW_ONLY, dataclass
from typing import Annotated

from ..checks import Choice, Count, Positive, Range, check

Share = Annotated[float, Range(above=0, most=1)]


@dataclass(frozen=True)
class Options:
    """Lengths of steps, accuracies of critical points, and what a step may miss.

    A smaller `defect` makes a path take more states and miss less.

    Attributes
    ----------
    step : first step, in the control's own measure; None: the control's default
    smallest, largest : bounds on steps, as multiples of the first step
    iterations : number of iterations that a step should take; steps grow and shrink with the square root of this over
        the number taken (Ramm 1981)
    turn : largest angle in radians between the increment of a step and the tangents at its start and its end (with
        contact, the tangent at its start or the increment before); pi: any
    newton : "full", a new tangent for each iteration, or "modified", the tangent at the start of the step for all
    most_iterations : after which a step is cut; None: 20 with new tangents, 100 with one
    before_critical : first step where none is given, over the way to the first critical point as the tangent tells it
    with_contact : first step where none is given, over the control's default, where something may touch
    defect : correction of the interpolated path inside of a piece, off the path over its length and in the load over
        its change, from which the middle of the piece is looked at (Kierzenka and Shampine 2001)
    unbalanced : work of a step with contact that is neither stored nor dissipated, over that of its change of load,
        from which the step is refused
    same_load : relative difference of the loads of a multiple bifurcation
    exact : relative error of the load at a bifurcation, and at flutter
    exact_event : relative error of the load at an event
    forgotten, astray : share of the resultants that laws with history may forget of the way within a step, and how far
        that may lead off the path, over the length of the step, from which it is divided, see `continuation.lapse`
    augmentations : of contact forces in one step, at most
    """

    step: Positive | None = None
    smallest: Positive = 1e-4
    largest: Positive = 8.0
    iterations: Count = 7
    turn: Positive = 0.8
    newton: Annotated[str, Choice(("full", "modified"))] = "full"
    _: KW_ONLY
    most_iterations: Count | None = None
    before_critical: Share = 0.38
    with_contact: Share = 1 / 8
    defect: Positive = 0.008
    unbalanced: Positive = 0.1
    same_load: Positive = 2e-6
    exact: Positive = 1e-8
    exact_event: Positive = 1e-10
    forgotten: Positive = 1e-3
    astray: Positive = 0.02
    augmentations: Count = 30

    def __post_init__(self):
        check(self)
