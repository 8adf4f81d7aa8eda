"""From a gmsh model of triangles and quadrilaterals to a mesh of each, with common nodes where they meet."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import Annotated

import numpy as np
from mpi4py import MPI

from ..checks import NOT_NEGATIVE, Choice, checked
from .cells import Cells
from .gmsh_model import Model, Source, read_model
from .orientation import run_alike
from .partition import Hosted
from .reader import NamedMesh, named_mesh, with_reading


@dataclass(frozen=True, eq=False)
class MeshesByKind:
    """Meshes of the triangles and of the quadrilaterals of one gmsh model; they can be iterated over.

    `fx.Compatible(meshes.triangles, meshes.quadrilaterals)` makes both one structure.

    Attributes
    ----------
    triangles : has named edges and points but for those that are on quadrilaterals too
    quadrilaterals : has named edges and points
    """

    triangles: NamedMesh
    quadrilaterals: NamedMesh

    def __iter__(self) -> Iterator[NamedMesh]:
        return iter((self.triangles, self.quadrilaterals))

    def having(self, name: str) -> list[NamedMesh]:
        """Meshes with something of a name: one, or both where the group, edge or point lies on cells of both kinds.

        Raises
        ------
        ValueError
            If neither has it.
        """
        known = [{*mesh.cells, *mesh.edges, *mesh.points} for mesh in self]
        if not any(name in names for names in known):
            raise ValueError(f"having: no group of cells, edge or point named {name!r}; there are "
                             f"{', '.join(sorted(set.union(*known)))}")
        return [mesh for mesh, names in zip(self, known, strict=True) if name in names]


@checked
def read_kinds(source: Source, order: Annotated[int | None, Choice((1, 2, 3))] = None, place: Callable | None = None,
               comm: MPI.Comm = MPI.COMM_WORLD, halvings: Annotated[int, NOT_NEGATIVE] = 0) -> MeshesByKind:
    """Meshes of the triangles and of the quadrilaterals of one gmsh model in space.

    Recombination in gmsh leaves both. Cells run alike and are raised to one order across both kinds. Each piece of a
    named edge, and each named point, is in one of the meshes, so that a load on both meshes counts once.

    Parameters
    ----------
    source, order, place, halvings : as for `read`

    Raises
    ------
    ValueError
        If the file, a group or a cell cannot be read, a curve is on no edge of a surface, or all cells are of one kind.
    """
    model = read_model(source, "read_kinds", order, place, comm, several=True, halvings=halvings)
    if len(model.kinds) == 1:
        raise ValueError(f"{model.what}: all cells are of one kind; read them with read")
    model.require_edges()
    model.require_points_on(*model.kinds)
    triangles, quadrilaterals = model.kinds
    partition, alike = Hosted(triangles.corners()), run_alike(model, *model.kinds)
    inner, outer = _edges(model, quadrilaterals)
    second = named_mesh(model, quadrilaterals, inner, 3, comm, partition.hosts, alike, 1)
    corners = quadrilaterals.corners()
    rest = replace(model, points={name: np.setdiff1d(nodes, corners) for name, nodes in model.points.items()})
    first = named_mesh(rest, triangles, outer, 3, comm, partition.guests, alike)
    with_reading((first, second), source, place,
                 lambda order, more: tuple(read_kinds(source, order, place, comm, halvings + more)))
    return MeshesByKind(first, second)


def _edges(model: Model, cells: Cells) -> tuple[Cells, Cells]:
    """Named curves on edges of some cells, and the others."""
    here, curves = model.pairs(cells.sides()), model.curves
    found = []
    for on in (True, False):
        nodes = {e: table[np.isin(model.pairs(curves.corners([e])), here) == on] for e, table in curves.nodes.items()}
        nodes = {e: table for e, table in nodes.items() if len(table)}
        groups = {name: own for name, entities in curves.groups.items() if (own := [e for e in entities if e in nodes])}
        found.append(Cells(groups, nodes, curves.kind))
    return found[0], found[1]
