"""Share of nodal rotations in the tangent: forces on them do work on their second variations."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from .contribution import Contribution, Forces
from .layout import Layout
from .unknowns import Unknowns


def curvature(unknowns: Unknowns, layout: Layout, contributions: Sequence[Contribution],
              held: Forces) -> list[np.ndarray]:
    """Values of the tangent for the nodes of each field of rotations, in arrays one behind the other.

    Parameters
    ----------
    held : forces of all contributions on nodal quaternions, which the tangent holds fixed
    """
    conservative = all(c.conservative for c in contributions)
    moments = {} if conservative else _moments(unknowns, layout, contributions)
    return [(field.curvature(held.on(number), conservative) + moments.get(number, 0.0)).ravel()
            for number, field in enumerate(unknowns.fields) if field.curved]


def _moments(unknowns: Unknowns, layout: Layout, contributions: Sequence[Contribution]) -> dict[int, np.ndarray]:
    """For each field of rotations the change of moments with its increments."""
    forces = Forces(unknowns, layout)
    for contribution in contributions:
        if contribution.gives_moments:
            contribution.residual(forces)
    return {number: f.moment_slopes(array[f.dofs].reshape(-1, f.width))
            for number, (f, array) in enumerate(layout.fields(forces.along_space)) if f.curved}
