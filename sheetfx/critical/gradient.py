"""How the load of a critical point changes with the structure, without a path of the changed one.

Formulas are in `critical.limit_gradient`, `critical.bifurcation_gradient` and `critical.followed_bifurcation`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence

import numpy as np

from ..continuation.state import CriticalPoint, State
from ..continuation.tracer import Tracer, tracer_of
from ..discrete.discretisation import Discretisation
from ..model.scene import Scene
from .bifurcation_gradient import BifurcationGradient
from .changed import Change, Failure
from .defining import without_third_variations
from .followed_bifurcation import FollowedBifurcation
from .limit_gradient import LimitGradient


class LoadGradient:
    """Derivatives of the load of a critical point.

    Parameters
    ----------
    path : Path or Tracer, which stays at its present state
    point, state : the critical point and its state
    modes : null vectors of a bifurcation
    states : of the path, from its first state on, where a state depends on those before

    Raises
    ------
    ValueError
        Where there is none: the tangent is not singular, the load is a reaction, or states before it are missing.
    NoDerivative
        At a bifurcation, where the stiffness along a mode jumps past zero.
    """

    def __init__(self, path, point: CriticalPoint, state: State, modes: Sequence[np.ndarray] = (),
                 states: Sequence[State] = ()):
        tracer: Tracer = tracer_of(path)
        title = f"{point.title} at load {point.load:.6g}"
        if point.kind not in ("limit", "bifurcation") or point.spread:
            raise ValueError(f"gradient: {title} is no single point where the tangent is singular; give a limit point "
                             "or a bifurcation")
        if not isinstance(tracer.discretisation, Discretisation):
            raise ValueError(f"gradient: {title}: a plain form has no scene to change; compare whole paths")
        self._found: LimitGradient | BifurcationGradient
        before = [one for one in states if one.step < point.step and not getattr(path, "falls", ())]
        if point.kind == "limit":
            if before and tracer.system.rough and _turns_at_corner(before[-1], state):
                raise ValueError(f"gradient: {title} is a corner of the path, as where something begins to touch, and "
                                 "its load changes with the corner's place; compare whole paths")
            self._found = LimitGradient(tracer, title, state, before)
        elif without_third_variations(tracer.system):
            self._found = FollowedBifurcation(tracer, title, state, modes, before)
        else:
            self._found = BifurcationGradient(tracer, title, state, modes)

    def derivative(self, scene: Callable[[float], Scene], at: float, step: float | None = None) -> float | np.ndarray:
        """Derivative of the total load by a number.

        Parameters
        ----------
        scene : function from the number to the scene, of which only values change and nodes move
        at : the number as it is
        step : of differences, which may be shorter where these are not exact; None: a share of the number

        Returns
        -------
        Of several modes in ascending order as many, one for each load that the point splits into as the number grows.

        Raises
        ------
        ValueError
            If the number changes the unknowns.
        NoDerivative
            If the number makes the structure imperfect.
        """
        (found,) = self.derivatives([Change(scene, at, step)])
        if isinstance(found, Exception):
            raise found
        return found

    def derivatives(self, changes: Iterable[Change]) -> Iterable[float | np.ndarray | Failure]:
        """Derivatives by several numbers, or why there is none, in their order."""
        return self._found.derivatives(changes)


def _turns_at_corner(before: State, limit: State) -> bool:
    """Whether the load does not come to rest up to a limit point: its rate does not fall to half."""
    return abs(limit.load_rate) > abs(before.load_rate) / 2
