"""States of one scene as starts or guesses for another one of the same structure."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from ..discrete.discretisation import Discretisation
from ..discrete.transfer import Transfer

if TYPE_CHECKING:
    from .state import State


def transferred(state: State, scene: Any, modes: Sequence[np.ndarray] = ()) -> tuple[State, list[np.ndarray]]:
    """A state on another mesh, degree or model, and modes with it.

    The state is not in equilibrium there: interpolation strains what was not strained. It has the same load, deflection
    and number of unstable modes, and the response that it had.

    Parameters
    ----------
    state : of a path or from `fx.critical`; of states from files those that a path has taken, in `path.start`
    scene : Scene of the same structure, its parts in groups of the same names
    modes : increments at the state, this process's part

    Returns
    -------
    The state of the other scene, and its increments that move and turn nodes as the modes do.

    Raises
    ------
    ValueError
        If the state does not know its scene, or the other one has not its meshes, or axes of what laws remember.
    """
    if state.scene is None:
        raise ValueError("state.on: a state from a file does not know its scene; take it from `path.start` of "
                         "Path(scene, start=[state])")
    return between(state, Discretisation(state.scene), Discretisation(scene), modes)


def between(state: State, source: Discretisation, target: Discretisation,
            modes: Sequence[np.ndarray] = ()) -> tuple[State, list[np.ndarray]]:
    """As `transferred`, for discretisations that are there; both end at the state."""
    transfer = Transfer(source, target)
    target.system.factors.enter(state.stage, 0.0)
    unit = target.load_of_unit()
    factor = state.load / unit if unit else state.factor
    fields = transfer.snapshot(state.fields, factor)
    increment, response, *vectors = (transfer.increments(v).array.copy()
                                     for v in (state.increment, state.response, *modes))
    share = state.factor / factor if factor else 1.0  # of the load of a unit of the factor, which cells may change
    norm2, work = state.reference
    return replace(state, factor=factor, load_rate=state.load_rate / share, load_increment=state.load_increment / share,
                   reference=(norm2 * share**2, work * share**2), critical=(), next_length=0.0, increment=increment,
                   response=response * share, fields=fields, scene=target.scene), vectors
