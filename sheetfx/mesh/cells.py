"""Cells of a gmsh model by their entities."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

INTERVALS, TRIANGLES, QUADRILATERALS = ("intervals", 2), ("triangles", 3), ("quadrilaterals", 4)
KINDS = {1: INTERVALS, 8: INTERVALS, 26: INTERVALS, 2: TRIANGLES, 9: TRIANGLES, 21: TRIANGLES, 3: QUADRILATERALS,
         10: QUADRILATERALS, 36: QUADRILATERALS}  # gmsh's numbers of complete cells; names and corners


@dataclass
class Cells:
    """Cells of one dimension in a gmsh model.

    Attributes
    ----------
    groups : name -> entities
    nodes : entity -> nodes of its cells in gmsh's order, shape (cells, nodes)
    kind : gmsh's number of the kind of cell, where there are any
    """

    groups: dict[str, list[int]]
    nodes: dict[int, np.ndarray]
    kind: int | None = None

    def table(self, entities: Iterable[int] | None = None) -> np.ndarray:
        """Nodes of the cells of some entities, or of all, one behind the other."""
        return np.concatenate([self.nodes[e] for e in sorted(set(self.nodes if entities is None else entities))])

    @property
    def straight(self) -> bool:
        """Whether they have no nodes but those at their corners."""
        return all(nodes.shape[1] == KINDS[self.kind][1] for nodes in self.nodes.values())

    def source(self) -> np.ndarray:
        """Entity of each cell."""
        return np.repeat(sorted(self.nodes), [len(self.nodes[e]) for e in sorted(self.nodes)])

    def corners(self, entities: Iterable[int] | None = None) -> np.ndarray:
        """Nodes at the corners of the cells of some entities, or of all."""
        return self.table(entities)[:, :KINDS[self.kind][1]]

    def sides(self) -> np.ndarray:
        """Nodes at the ends of each edge of each cell, in order around it."""
        corners = self.corners()
        return np.stack([corners, np.roll(corners, -1, axis=1)], axis=2).reshape(-1, 2)

    def of(self, names: Iterable[str]) -> Cells:
        """The cells of some groups alone."""
        groups = {name: self.groups[name] for name in names}
        return Cells(groups, {e: self.nodes[e] for entities in groups.values() for e in entities}, self.kind)
