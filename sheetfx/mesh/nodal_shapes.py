"""Shapes of which each moves one node of a structure."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..checks import checked
from .pieces import SAME_PLACE
from .reader import NamedMesh


@dataclass(frozen=True, eq=False)
class NodalShape:
    """One node moved by 1 and all others by 0, a function of place for `imperfect`.

    Attributes
    ----------
    place : of the node, shape (3,)
    direction : in which it moves, shape (3,); None: along the normal
    """

    place: np.ndarray
    direction: np.ndarray | None
    _reach: float

    def __call__(self, x: np.ndarray) -> np.ndarray:
        here = (np.linalg.norm(x - self.place, axis=1) <= self._reach).astype(float)
        return here if self.direction is None else here[:, None] * self.direction


@checked
def nodal_shapes(meshes: Sequence[NamedMesh]) -> list[NodalShape]:
    """A shape for each node of the cells: along the normal of surfaces and plane curves, else three.

    Parameters
    ----------
    meshes : of one scene; nodes at one place are one
    """
    found = [meshes[0].comm.allgather(mesh.domain.geometry.x) for mesh in meshes]
    places = np.concatenate([x for parts in found for x in parts])
    reach = SAME_PLACE * max(mesh.size for mesh in meshes)
    _, first = np.unique(np.round(places / (2 * reach)), axis=0, return_index=True)
    normal = all(mesh.domain.topology.dim == 2 or mesh.dimension == 2 for mesh in meshes)
    directions = [None] if normal else list(np.eye(3))
    return [NodalShape(places[n], direction, reach) for n in first for direction in directions]
