"""What small imperfections do to a bifurcation: Koiter's half and two-thirds power laws."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from .. import rounding
from ..continuation.state import CriticalPoint, State
from ..continuation.tracer import tracer_of
from ..discrete.discretisation import Discretisation
from ..events.search import state_at
from ..model.scene import Scene
from .koiter import expansion


def limit_of_imperfect(point: CriticalPoint, amplitude: float, sensitivity: float = 1.0) -> float:
    """Ratio of the loads at which a slightly imperfect and the perfect structure lose stability (Koiter 1945).

    The maximum of (1 - r) xi + a xi^2 + b xi^3 = sensitivity r amplitude over xi: asymptotically
    1 - r = 2 (-a amplitude)^(1/2) or 3 / 2^(2/3) (-b)^(1/3) amplitude^(2/3).

    Parameters
    ----------
    point : simple bifurcation with a slope or a negative curvature
    amplitude : largest deviation in the shape of the mode, in length units; its sign counts where there is a slope
    sensitivity : 1 for a structure that does not bend before it buckles

    Raises
    ------
    ValueError
        If the structure is not sensitive to this imperfection.
    """
    a, b = point.slope or 0.0, point.curvature or 0.0
    size = abs(sensitivity * amplitude)
    sign = 1.0 if sensitivity * amplitude > 0 else -1.0
    if a * sign >= 0 and not (a == 0 and b < 0):
        raise ValueError(f"limit_of_imperfect: a bifurcation with a = {a:g}, b = {b:g} keeps its load with an "
                         f"imperfection of {amplitude:g}; give one of the other sign or another point")
    size = max(size, rounding.TINIEST)

    def ratio(xi):
        return (xi + sign * a * xi**2 + b * xi**3) / (xi + size)

    highest = np.roots(np.polysub(np.polymul([3 * b, 2 * sign * a, 1], [1, size]), [b, sign * a, 1, 0]))
    return float(ratio(min(xi.real for xi in highest if rounding.is_real(xi) and xi.real > 0)))


def imperfection_sensitivity(path, before: State, after: State, point: CriticalPoint,
                             scene: Callable[[float], Scene], amplitude: float) -> float:
    """Factor rho on imperfections of a shape, for `limit_of_imperfect`.

    The imperfection pushes along the mode as rho times one in the shape of the mode would push a structure that does
    not bend before it buckles (Koiter 1945; Budiansky 1974).

    Parameters
    ----------
    path : Path or Tracer that the states belong to
    before, after : states of the step that the bifurcation lies in
    scene : function from an amplitude to the imperfect structure, on a mesh from `imperfect`
    amplitude : small enough for differences, such as a thousandth of a thickness

    Raises
    ------
    ValueError
        If the point is no simple bifurcation, or the amplitude is not positive.
    """
    if point.kind != "bifurcation" or point.multiplicity > 1:
        raise ValueError(f"imperfection_sensitivity: the {point.title} at load {point.load:.6g} is no simple "
                         "bifurcation; give one that is")
    if not amplitude > 0:
        raise ValueError(f"imperfection_sensitivity: amplitude is {amplitude}; it must be positive")
    tracer = tracer_of(path)
    present = tracer.state
    try:
        state = state_at(tracer, before, after, point)
        e = expansion(tracer, tracer.spectrum(1)[1][0], [before, after])
    finally:
        tracer.back_to(present)
    pushes = []
    for sign in (1.0, -1.0):
        imperfect = Discretisation(scene(sign * amplitude))
        imperfect.system.restore(state.fields)
        residual = imperfect.system.create_vector()
        imperfect.system.residual(residual)
        pushes.append(residual.dot(e.mode))
    push = (pushes[0] - pushes[1]) / (2 * amplitude)
    return push * e.size / (e.stiffness * state.factor)
