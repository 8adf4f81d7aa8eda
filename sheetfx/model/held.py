"""What supports hold at a point, together and along whatever axes."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from dolfinx.mesh import compute_midpoints

from ..mesh.reader import COMPONENTS, NamedMesh
from .supports import Support

ALONG = 1e-8  # squared sine of a direction to the span of those held, below which it is in it


def supports_that_hold(supports: Sequence[Support], mesh: NamedMesh, at: str, component: str) -> list[str]:
    """Places of the supports that hold a component at a named point, on all processes; empty where it can move."""
    group = [name for name in COMPONENTS[mesh.dimension] if name.startswith("r") == component.startswith("r")]
    wanted, rows = np.eye(len(group))[group.index(component)], [np.zeros((0, len(group)))]
    found: list[str] = []
    vertices = mesh.vertices(at)
    for support in supports:
        if support.mesh is not mesh or not len(there := np.intersect1d(vertices, mesh.vertices(support.at))):
            continue
        axes = np.eye(len(group))
        if support.axes is not None:
            axes = support.directions(compute_midpoints(mesh.domain, 0, there[:1].astype(np.int32)))[0]
        held = axes[[name in support.fixed.split() for name in group]]
        rows.append(held)
        if ((held @ wanted)**2 > ALONG).any():
            found.append(support.at)
    _, sizes, span = np.linalg.svd(np.concatenate(rows), full_matrices=False)
    within = span[sizes**2 > ALONG] @ wanted
    names = mesh.comm.allgather(found if within @ within > 1 - ALONG else [])
    return list(dict.fromkeys(name for rank in names for name in rank))
