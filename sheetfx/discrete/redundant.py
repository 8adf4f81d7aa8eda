"""Lagrange multipliers that constrain what others, or supports, constrain already."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.linalg.lapack import dpstrf
from scipy.sparse import coo_array, diags_array
from scipy.sparse.csgraph import connected_components

from .contribution import Contribution, Forces
from .layout import Layout
from .points import PointWork
from .unknowns import Unknowns

INDEPENDENT = 1e-9  # square of the sine of the angle between a constraint and the others, of one that is independent


def without_redundant(layout: Layout, works: Sequence[Contribution], unknowns: Unknowns) -> Layout:
    """The layout with multipliers fixed at zero that point works among some contributions make redundant."""
    redundant = redundant_multipliers([w for w in works if isinstance(w, PointWork)], unknowns, layout)
    return layout.fixing(redundant) if layout.comm.allreduce(sum(map(len, redundant))) else layout


def redundant_multipliers(works: Sequence[Contribution], unknowns: Unknowns, layout: Layout) -> list[np.ndarray]:
    """For each block the local dofs of multipliers that can be zero, because others do what they do.

    The constraints are compared as they are now, each by its derivative with respect to the free increments; of those
    that depend on each other as many are kept as are independent, the most independent first (Cholesky's
    decomposition with pivots of their products; Higham 2002, section 10.3). Without this, supports that hold what a
    weld holds too, or welds that close a loop, would make the tangent singular.
    """
    kept: list[np.ndarray] = [np.empty(0, dtype=np.int64) for _ in unknowns.blocks]
    own = [(n, layout.free_numbers[n].ravel()) for n, f in enumerate(unknowns.fields) if f.multiplier]
    rows = np.unique(np.concatenate([np.empty(0, dtype=np.int64), *(numbers for _, numbers in own)]))
    parts = [(*work.pattern(layout), np.concatenate(work.tangent(Forces(unknowns, layout)))) for work in works]
    if not parts:
        return kept
    row, column, value = (np.concatenate(p) for p in zip(*parts, strict=True))
    rows = rows[(rows >= 0) & np.isin(rows, row)]
    chosen = rows[_dependent(_constraints(unknowns, layout, rows, row, column, value))]
    blocks = [number for number, block in enumerate(unknowns.blocks) for _ in block.fields]
    for number, numbers in own:
        kept[blocks[number]] = unknowns.fields[number].dofs[np.isin(numbers, chosen)]
    return kept


def _constraints(unknowns: Unknowns, layout: Layout, rows, row, column, value):
    """Of the entries of a tangent those in rows of multipliers and columns of others, each row of unit length."""
    here = np.isin(row, rows) & ~np.isin(column, rows) & (column >= 0) & (value != 0)
    columns, column = np.unique(column[here], return_inverse=True)
    scales = np.ones(len(columns))
    for numbers, field in zip(layout.free_numbers, unknowns.fields, strict=True):
        if np.isfinite(field.scale):
            scales[np.isin(columns, numbers)] = field.scale
    matrix = coo_array((value[here] * scales[column], (np.searchsorted(rows, row[here]), column)),
                       shape=(len(rows), len(columns))).tocsr()
    lengths = np.sqrt(np.asarray((matrix * matrix).sum(axis=1)).ravel())
    return diags_array(1 / np.where(lengths > 0, lengths, 1.0)) @ matrix


def _dependent(constraints) -> np.ndarray:
    """Numbers of rows that depend on others."""
    products = (constraints @ constraints.T).tocsr()
    pieces, piece = connected_components(products, directed=False)
    found = [np.empty(0, dtype=np.int64)]
    for number in range(pieces):
        members = np.flatnonzero(piece == number)
        _, pivots, rank, _ = dpstrf(products[members][:, members].toarray(), tol=INDEPENDENT)
        found.append(members[pivots[rank:] - 1])
    return np.sort(np.concatenate(found))
