"""Where plastic parts have flowed."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..model.plasticity import PlasticLaw
from .discretisation import Discretisation


@dataclass
class PlasticState:
    """State of a plastic part at its points of quadrature, on this process; all arrays have the shape (cells, points).

    Attributes
    ----------
    share : of the thickness or of the cross-section that has flowed
    strain : largest equivalent plastic strain in the thickness or cross-section
    measure : area or length that the point stands for
    """

    share: np.ndarray
    strain: np.ndarray
    measure: np.ndarray


def is_plastic(part) -> bool:
    return isinstance(getattr(part, "section_law", None), PlasticLaw)


def plastic_state(discretisation: Discretisation, part) -> PlasticState:
    """State of a plastic part at the last accepted state.

    Raises
    ------
    ValueError
        For a part that is not plastic.
    """
    if not is_plastic(part):
        raise ValueError(f"{type(part).__name__}: has no plastic law; give it an fx.Plastic material")
    work = discretisation.works_of_parts[discretisation.scene.parts.index(part)]
    history, measure = work.history()
    share, strain = part.section_law.flowed(history.reshape(-1, history.shape[2]))
    return PlasticState(share.reshape(measure.shape), strain.reshape(measure.shape), measure)


def plastic_stresses(discretisation: Discretisation, part, at) -> np.ndarray:
    """Stresses of a plastic part in the layer or fibre nearest to a place of its section, (cells, points, 3 or 1).

    They belong to the last accepted state at the points of integration.
    """
    known = discretisation.work_of(part).strains_and_history()
    strains, history = (values.reshape(-1, values.shape[2]) for values in known)
    found = part.section_law.stresses(strains, history, np.ravel(np.asarray(at, dtype=float)))
    return found.reshape(*known[0].shape[:2], -1)


def plastic_share(discretisation: Discretisation) -> float:
    """Share of the volume of all plastic parts that has flowed, on all processes; 0 where there are none."""
    volumes = np.zeros(2)
    for part in filter(is_plastic, discretisation.scene.parts):
        state = plastic_state(discretisation, part)
        size = part.section.thickness if hasattr(part, "discrete") else part.section.area
        volumes += size * np.array([np.sum(state.share * state.measure), state.measure.sum()])
    flowed, whole = discretisation.system.comm.allreduce(volumes)
    return float(flowed / whole) if whole else 0.0
