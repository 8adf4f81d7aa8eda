"""From a gmsh model of surfaces and bars to a mesh of each, with nodes at the same places where they meet."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Annotated

import numpy as np
from mpi4py import MPI

from ..checks import NOT_NEGATIVE, Choice, checked
from .cells import Cells
from .gmsh_model import Model, Source, read_model
from .groups import DIMENSIONS
from .partition import Hosted
from .reader import NamedMesh, named_mesh, with_reading


@dataclass(frozen=True, eq=False)
class MixedMesh:
    """Meshes of the surfaces and of the bars of one gmsh model.

    Attributes
    ----------
    surfaces : its edges are the named curves on edges of its cells, be they bars or not
    curves : the bars
    """

    surfaces: NamedMesh
    curves: NamedMesh

    def shared_nodes(self) -> np.ndarray:
        """Pairs of nodes of the geometry of curves and surfaces on this process that are one in gmsh, shape (n, 2).

        Each process that has a node of the curves on a surface has it on the surface, too.
        """
        numbers = [mesh.domain.geometry.input_global_indices for mesh in (self.curves, self.surfaces)]
        return np.stack(np.intersect1d(*numbers, return_indices=True)[1:], axis=1)


@checked
def read_mixed(source: Source, bars: str | Sequence[str], order: Annotated[int | None, Choice((1, 2, 3))] = None,
               place: Callable | None = None, comm: MPI.Comm = MPI.COMM_WORLD,
               halvings: Annotated[int, NOT_NEGATIVE] = 0) -> MixedMesh:
    """Meshes of the surfaces and of the bars of one gmsh model in space.

    Curves of `bars` are cells of the curves and, where they lie on edges of surfaces, edges of the surfaces under the
    same name; so are other groups that consist of such curves. All other named curves are edges of the surfaces.
    Named points are points of each mesh that has them.

    Parameters
    ----------
    source, order, place, halvings : as for `read`
    bars : names of groups of curves

    Raises
    ------
    ValueError
        If the file, a group or a cell cannot be read, there are no surfaces or bars, or a curve is neither a bar nor
        on the edges of surfaces.
    """
    model = read_model(source, "read_mixed", order, place, comm, halvings=halvings)
    cells, edges = _bars_and_edges(model, [bars] if isinstance(bars, str) else list(bars))
    model.require_points_on(model.surfaces, cells)
    partition = Hosted(cells.corners())
    surfaces = named_mesh(model, model.surfaces, edges, 3, comm, partition.hosts)
    curves = named_mesh(model, cells, Cells({}, {}), 3, comm, partition.guests)

    def again(order: int | None, more: int) -> tuple[NamedMesh, NamedMesh]:
        found = read_mixed(source, bars, order, place, comm, halvings + more)
        return found.surfaces, found.curves

    with_reading((surfaces, curves), source, place, again)
    return MixedMesh(surfaces, curves)


def _bars_and_edges(model: Model, bars: list[str]) -> tuple[Cells, Cells]:
    """Groups of curves that are bars, and those on edges of surfaces."""
    curves = model.curves.groups
    known = ", ".join(curves) or "none"
    if not model.surfaces.groups:
        raise ValueError(f"{model.what}: no group of surfaces; read bars alone with read")
    if not bars:
        raise ValueError(f"{model.what}: bars names no group; give groups of curves (there are {known}), or read "
                         "surfaces alone with read")
    for name in bars:
        if name not in curves:
            others = dict.fromkeys(model.points, 0) | dict.fromkeys(model.surfaces.groups, 2)
            kind = f"is a group of {DIMENSIONS[others[name]]}" if name in others else "is no group"
            raise ValueError(f"{model.what}: {name!r} in bars {kind}; give groups of curves (there are {known})")
    chosen = {entity for name in bars for entity in curves[name]}
    within = [name for name, entities in curves.items() if chosen.issuperset(entities)]
    edges = [name for name in curves if name not in within or model.on_edges(name).any()]
    for name in edges:
        if name not in within and not model.on_edges(name).all():
            raise ValueError(f"{model.what}: the curves {name!r} are no bars, and not all of them are on edges of "
                             "surfaces; add them to bars, or leave off what is on no surface")
    return model.curves.of(within), model.curves.of(edges)
