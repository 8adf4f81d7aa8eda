"""Modes of critical points, and in which parts they store their energy."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..continuation.state import CriticalPoint, State
from ..continuation.tracer import tracer_of
from ..events.search import state_at, step_of
from .modes import scaled

ALIKE = 1e-3  # relative difference of eigenvalues of one cluster
SMALL = 1e-6  # largest displacement of a mode that is imposed, over the size of the structure


def critical_modes(path, states: Sequence[State], point: CriticalPoint,
                   state: State | None = None) -> list[np.ndarray]:
    """Null vectors of the tangent at a bifurcation or limit point, each with a largest displacement of 1.

    Parameters
    ----------
    path : Path or Tracer that the states belong to; it stays at its present state
    states : of the path, among them those before and after the point
    point : one of `critical` of these states
    state : of the point itself; None: it is found again, or where it does not converge with contact or history the one
        at the end of its step serves

    Returns
    -------
    list of arrays of increments on this process, as many as the point's multiplicity; several span the space
    of null vectors, in no particular order.

    Raises
    ------
    ValueError
        If a state beside the point is missing, or nothing is singular there (an event, flutter).
    ArithmeticError
        If the point does not converge again.
    """
    if point.kind not in ("bifurcation", "limit"):
        raise ValueError(f"critical_modes: the tangent is not singular at {point.title} (load {point.load:.6g}); give "
                         "a bifurcation or a limit point")
    tracer = tracer_of(path)
    before, after = step_of("critical_modes", states, point, len(tracer.x.array))
    present = tracer.state
    try:
        tracer.factorise_at(state or _state_near(tracer, before, after, point))
        pairs = sorted(zip(*tracer.spectrum(point.multiplicity + 1), strict=True), key=lambda pair: abs(pair[0]))
        return [scaled(path.discretisation, mode) for _, mode in pairs[:point.multiplicity]]
    finally:
        tracer.back_to(present)


def softest_modes(path, state: State, count: int) -> list[np.ndarray]:
    """Modes of the tangent at a state whose eigenvalues are nearest to zero, each with a largest displacement of 1.

    More than `count` where the last one would part modes of one eigenvalue, as symmetry makes them.

    Returns
    -------
    list of arrays of increments on this process, the softest one first.
    """
    tracer = tracer_of(path)
    present, asked = tracer.state, min(count + 1, tracer.system.size)
    try:
        tracer.factorise_at(state)
        while True:
            pairs = sorted(zip(*tracer.spectrum(asked), strict=True), key=lambda pair: abs(pair[0]))
            sizes = [abs(value) for value, _ in pairs]
            apart = [n for n in range(count, len(sizes)) if sizes[n] - sizes[n - 1] > ALIKE * sizes[n]]
            if apart or asked == tracer.system.size:
                break
            asked = min(2 * asked, tracer.system.size)
        return [scaled(path.discretisation, mode) for _, mode in pairs[:apart[0] if apart else None]]
    finally:
        tracer.back_to(present)


def _state_near(tracer, before: State, after: State, point: CriticalPoint) -> State:
    try:
        return state_at(tracer, before, after, point)
    except ArithmeticError:
        if tracer.system.smooth:
            raise
        return after


def energy_shares(path, unloaded: State, modes: Sequence[np.ndarray]) -> list[float]:
    """Shares of the parts of a scene, in their order, in the strain energy of modes.

    The energy is that which the unloaded structure would store if the mode were imposed on it. Shares of several modes
    are those of the sum of their energies, which does not depend on how modes of one load are chosen.

    Parameters
    ----------
    path : Path or Tracer that the modes belong to; it stays at its present state
    unloaded : first state of the path
    modes : arrays of increments on this process
    """
    discretisation = path.discretisation
    system, size = discretisation.system, max(mesh.size for mesh in discretisation.scene.meshes)
    energies = np.zeros(len(discretisation.scene.parts))
    with discretisation.visiting(unloaded.fields):
        forces = system.create_vector()
        for mode in modes:
            step = system.create_vector(SMALL * size * mode)
            system.configure(step, system.factor)
            for i, part in enumerate(discretisation.works_of_parts):
                system.residual_of([part], forces)
                energies[i] += forces.dot(step)
    return (energies / energies.sum()).tolist()
