"""Element matrices of the moduli of assumed strains, B*^T C B*, cell by cell so that all stays in a processor's cache.

Strains and forces at the points of a cell are rows, strain by strain; nodal values of a field are columns, component by
component. See `assumed` for the strains.
"""

from __future__ import annotations

import numba
import numpy as np

_within = numba.njit(inline="always")  # calls with views of arrays take longer than the work on small cells


@_within
def _depending(slopes, start, count):
    """First strain, and the one behind the last, with derivatives that are not zero by so many entries of the jet."""
    cells, points, strains, _ = slopes.shape
    first, last = strains, 0
    for c in range(cells):
        for q in range(points):
            for i in range(strains):
                if i < first or i >= last:
                    for slope in slopes[c, q, i, start: start + count]:
                        if slope != 0.0:
                            first, last = min(i, first), max(i + 1, last)
    return min(first, last), last


@_within
def _by_nodes(slopes, start, components, table, rows):
    """Derivatives of a strain at points by the nodal values of a field, from those by its values and gradient there."""
    orders, points, nodes = table.shape
    for q in range(points):
        for a in range(components):
            slope, row = slopes[q, start + a * orders: start + (a + 1) * orders], rows[q, a * nodes: (a + 1) * nodes]
            if orders == 3:
                zeroth, first, second = slope[0], slope[1], slope[2]
                for n in range(nodes):
                    row[n] = zeroth * table[0, q, n] + first * table[1, q, n] + second * table[2, q, n]
            elif orders == 2:
                first, second = slope[0], slope[1]
                for n in range(nodes):
                    row[n] = first * table[0, q, n] + second * table[1, q, n]
            else:
                only = slope[0]
                for n in range(nodes):
                    row[n] = only * table[0, q, n]


@_within
def _add_product(target, matrix, rows):
    """Add the product of a small matrix with rows."""
    for i in range(matrix.shape[0]):
        row = target[i]
        for j in range(matrix.shape[1]):
            entry, other = matrix[i, j], rows[j]
            for m in range(len(row)):
                row[m] += entry * other[m]


@_within
def _map(rows, low, values, root, from_low, gather, spread):
    """Replace strains by root times these, the low ones' share, and their gathered and spread part."""
    gathered = values[: len(gather)]
    gathered[:] = 0
    _add_product(gathered, gather, rows)
    rows *= root
    _add_product(rows, from_low, low)
    _add_product(rows, spread, gathered)


@_within
def _whole(strains, maps):
    """A range of strains, and all that maps mix with them."""
    first, last = strains
    for _ in range(len(maps)):
        for m in range(len(maps)):
            start, end, parts = maps[m][0], maps[m][1], maps[m][4]
            if parts == 1 and start < last and first < end:
                first, last = min(start, first), max(end, last)
    return first, last


@_within
def _multiply(moduli, nodal, first, last, forces):
    """Derivatives of the forces from the strains'; many moduli are zero."""
    points, strains, _ = moduli.shape
    forces[:] = 0
    for i in range(strains):
        for j in range(first, last):
            for q in range(points):
                modulus = moduli[q, i, j]
                if modulus != 0.0:
                    force, row = forces[i * points + q], nodal[j * points + q]
                    for m in range(len(row)):
                        force[m] += modulus * row[m]


@_within
def _add_component_pairs(matrices, found, rows, columns, same):
    """Add a matrix to the matrices of pairs of components, in the order of `densities.component_pairs`."""
    n, m = matrices.shape[1:]
    pair = 0
    for a in range(rows):
        for b in range(a if same else 0, columns):
            for i in range(n):
                target, values = matrices[pair, i], found[a * n + i, b * m: (b + 1) * m]
                for j in range(m):
                    target[j] += values[j]
            pair += 1


@numba.njit(cache=True, fastmath=True)
def add_material(fields, slopes, low_slopes, maps, moduli, matrices):
    """Add B*^T C B* to element matrices.

    Parameters
    ----------
    fields : for each its number of components, its place in the jet and its shape functions, (orders, points, nodes),
        at the points of integration, and the same two at the low points; a place of -1: the strains there do without it
    slopes, low_slopes : derivatives of the strains by the jet, (cells, points, strains, jet)
    maps : for each the range of its strains, and of the samples at the low points, the number of parts, and its
        matrices, see `model.tying.Map`
    moduli : times the weights of the points, (cells, points, strains, strains)
    matrices : for each pair of fields (cells, pairs of components, n, m)
    """
    cells, points, strains, _ = slopes.shape
    lows, sampled = low_slopes.shape[1], low_slopes.shape[2]
    widths = [components * table.shape[2] for components, _, table, _, _ in fields]
    nodal = [np.empty((strains * points, width)) for width in widths]
    forces = [np.empty((strains * points, width)) for width in widths]
    low = [np.zeros((sampled * lows, width)) for width in widths]
    most = 0
    for m in range(len(maps)):
        most = max(most, maps[m][7].shape[1])
    values = [np.empty((most, width)) for width in widths]
    ranges = [_whole(_depending(slopes, start, components * len(table)), maps)
              for components, start, table, _, _ in fields]
    for c in range(cells):
        for n, (components, start, table, low_start, low_table) in enumerate(fields):
            first, last = ranges[n]
            for i in range(first, last):
                _by_nodes(slopes[c, :, i], start, components, table, nodal[n][i * points: (i + 1) * points])
            for k in range(len(maps)):
                begin, end, low_begin, low_end, parts, root, from_low, gather, spread = maps[k]
                if low_start >= 0 and begin < last and first < end:
                    for i in range(low_begin, low_end):
                        _by_nodes(low_slopes[c, :, i], low_start, components, low_table,
                                  low[n][i * lows: (i + 1) * lows])
                size, low_size = (end - begin) // parts, (low_end - low_begin) // parts
                for part in range(parts):
                    at, below = begin + part * size, low_begin + part * low_size
                    if size > 0 and first <= at < last:
                        rows = nodal[n][at * points: (at + size) * points]
                        _map(rows, low[n][below * lows: (below + low_size) * lows], values[n], root[c], from_low[c],
                             gather[c], spread[c])
            _multiply(moduli[c], nodal[n], first, last, forces[n])
        pair = 0
        for n in range(len(fields)):
            for m in range(n, len(fields)):
                first, last = ranges[m]
                found = np.dot(forces[n][first * points: last * points].T, nodal[m][first * points: last * points])
                _add_component_pairs(matrices[pair][c], found, fields[n][0], fields[m][0], n == m)
                pair += 1
