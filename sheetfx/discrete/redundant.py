"""Lagrange multipliers that constrain what others, or supports, constrain already.

A constraint is redundant where others, supports or shared unknowns hold all of it but what rounding of its place makes.
A rest would be held exactly, however small it is: ties on one line but for rounding would hold slopes of a shell
besides, and be stiffer than one mesh with all its nodes in common. Places count as one within `SAME` of the mesh's
size, and shape functions change by up to `STEEPEST` over a cell: that is the sine of the angle between a constraint and
all that is held, up to which it is redundant.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.linalg.lapack import dpstrf
from scipy.sparse import coo_array, csr_array, diags_array
from scipy.sparse.csgraph import connected_components

from ..mesh.lines import SAME
from ..mesh.reader import NamedMesh
from .contribution import Contribution, Forces
from .layout import Layout
from .points import PointWork
from .unknowns import Unknowns

STEEPEST = 5.1  # largest slope of quadratic shape functions, (-3, 4, -1) over the length of a cell at its end


def without_redundant(layout: Layout, works: Sequence[Contribution], unknowns: Unknowns,
                      meshes: Sequence[NamedMesh]) -> Layout:
    """The layout with multipliers fixed at zero that point works among some contributions make redundant."""
    redundant = redundant_multipliers([w for w in works if isinstance(w, PointWork)], unknowns, layout, meshes)
    return layout.fixing(redundant) if layout.comm.allreduce(sum(map(len, redundant))) else layout


def redundant_multipliers(works: Sequence[Contribution], unknowns: Unknowns, layout: Layout,
                          meshes: Sequence[NamedMesh]) -> list[np.ndarray]:
    """For each block the local dofs of multipliers that can be zero, because others do what they do.

    The constraints are compared as they are now, each by its derivative with respect to the free increments, over what
    it would be were nothing fixed or shared. Of those that depend on each other as many are kept as are independent,
    the most independent first (Cholesky's decomposition with pivots of their products; Higham 2002, section 10.3).
    Without this, supports that hold what a weld holds too, or welds that close a loop, would make the tangent singular.

    A rotation counts as the displacement that it makes over a cell of the finest mesh.
    """
    kept: list[np.ndarray] = [np.empty(0, dtype=np.int64) for _ in unknowns.blocks]
    own = [(n, layout.free_numbers[n].ravel()) for n, f in enumerate(unknowns.fields) if f.multiplier]
    if not own:
        return kept
    cell = min(mesh.mean_cell for mesh in meshes)
    rounding = (STEEPEST * SAME * max(mesh.size for mesh in meshes) / cell)**2
    rows = np.unique(np.concatenate([np.empty(0, dtype=np.int64), *(numbers for _, numbers in own)]))
    free, whole = (_constraints(works, unknowns, at, rows[rows >= 0], cell)
                   for at in (layout, Layout(layout.comm, unknowns.blocks)))
    lengths = np.sqrt(np.asarray((whole * whole).sum(axis=1)).ravel())
    here = np.flatnonzero(lengths)
    chosen = rows[rows >= 0][here[_dependent(diags_array(1 / lengths[here]) @ free[here], rounding)]]
    blocks = [number for number, block in enumerate(unknowns.blocks) for _ in block.fields]
    for number, numbers in own:
        kept[blocks[number]] = unknowns.fields[number].dofs[np.isin(numbers, chosen)]
    return kept


def _constraints(works: Sequence[Contribution], unknowns: Unknowns, layout: Layout, rows: np.ndarray,
                 cell: float) -> csr_array:
    """Of the tangents of works the entries in rows of multipliers and columns of others, which may be fixed."""
    parts = [(*work.pattern(layout), np.concatenate(work.tangent(Forces(unknowns, layout)))) for work in works]
    none: tuple = (np.empty(0, dtype=np.int64), np.empty(0, dtype=np.int64), np.empty(0))
    row, column, value = (np.concatenate(p) for p in zip(none, *parts, strict=True))
    here = np.isin(row, rows) & ~np.isin(column, rows) & (column >= 0) & (value != 0)
    columns, column = np.unique(column[here], return_inverse=True)
    turns = [layout.free_numbers[unknowns.fields.index(f)].ravel() for b in unknowns.blocks for f in b.fields[1:]]
    turns = layout.comm.allgather(np.concatenate([none[0], *turns]))
    scales = np.where(np.isin(columns, np.concatenate(turns)), 1 / cell, 1.0)
    return coo_array((value[here] * scales[column], (np.searchsorted(rows, row[here]), column)),
                     shape=(len(rows), len(columns))).tocsr()


def _dependent(constraints: csr_array, rounding: float) -> np.ndarray:
    """Numbers of rows of which others leave, or is free, no more than rounding, a squared length.

    Of rows that are alike the first ones stay, so that any number of processes keeps the same.
    """
    order = diags_array(1 - SAME * np.arange(constraints.shape[0]) / max(constraints.shape[0], 1))
    products = (order @ constraints @ constraints.T @ order).tocsr()
    free = products.diagonal() > rounding  # LAPACK takes the first pivot, however small
    rows, found = np.flatnonzero(free), [np.flatnonzero(~free)]
    products = products[rows][:, rows]
    pieces, piece = connected_components(products, directed=False)
    for number in range(pieces):
        members = np.flatnonzero(piece == number)
        _, pivots, rank, _ = dpstrf(products[members][:, members].toarray(), tol=rounding)
        found.append(rows[members[pivots[rank:] - 1]])
    return np.sort(np.concatenate(found))
