"""Element vectors and matrices of internal virtual work.

Strains are differentiated with respect to the jet of the fields at each integration point; shape functions
enter by one product of dense matrices for many cells at once, and rotations by the derivatives of the nodal
quaternions, so that residual and tangent are gradient and Hessian of the energy as a function of the nodal
increments.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import combinations_with_replacement, product

import basix.ufl
import numba
import numpy as np
import ufl
from dolfinx import fem
from dolfinx.mesh import Mesh

from ..compat import JIT
from ..mesh.numbers import lift_numbers
from ..mesh.quadrature import Rule
from ..model.work import Internal, Term
from .contribution import Contribution, Forces
from .jets import FieldJet, as_function_of_jet
from .layout import Layout
from .nodal_field import AdditiveField

CHUNK = 64


@dataclass
class Coupling:
    """Blocks of the symmetric tangent that couple nodes of two fields.

    Attributes
    ----------
    rows, columns : numbers of the fields in the list of fields, rows <= columns
    nodes : shape (n, 2), pairs of nodes on this process that share a cell; of one field with itself those with the
        first not above the second
    pairs : for each cell the number of each of its pairs of nodes, -1 for those that are left out
    mirrored : pairs whose transpose is another block of the tangent
    values : shape (n, components of a node's row increment, of its column increment)
    """

    rows: int
    columns: int
    nodes: np.ndarray
    pairs: np.ndarray
    mirrored: np.ndarray
    values: np.ndarray


class ElementWork(Contribution):
    """Internal virtual work of one group of cells.

    Parameters
    ----------
    internal : Internal
    fields : fields that the strains may depend on
    increments : for each field a Function with its change in the last Newton step, for the mixed integration
        point tangent (Magisano, Leonetti and Garcea 2017); None: the plain tangent

    Attributes
    ----------
    numbers : in `fields`, of those that occur
    couplings : list of Coupling, filled by `tangent`
    """

    def __init__(self, internal: Internal, fields: list[AdditiveField], increments: list[fem.Function | None] | None):
        self.internal, domain, cells = internal, internal.domain, internal.cells
        self._terms = [_TermWork(t, domain, cells, fields, increments) for t in internal.terms]
        self.numbers = sorted({n for t in self._terms for n in t.numbers})
        self._fields = [fields[n] for n in self.numbers]
        self._nodes = [f.value.function_space.dofmap.list[cells].astype(np.int64) for f in self._fields]
        self._raw = [f.components for f in self._fields]
        self.couplings = []
        for a, b in combinations_with_replacement(range(len(self.numbers)), 2):
            nodes, pairs = _node_pairs(self._nodes[a], self._nodes[b], a == b)
            mirrored = np.flatnonzero(nodes[:, 0] != nodes[:, 1]) if a == b else np.arange(len(nodes))
            values = np.zeros((len(nodes), self._fields[a].width, self._fields[b].width))
            self.couplings.append(Coupling(self.numbers[a], self.numbers[b], nodes, pairs, mirrored, values))

    def _chunks(self):
        count = len(self.internal.cells)
        return [slice(start, min(start + CHUNK, count)) for start in range(0, count, CHUNK)]

    def pattern(self, layout: Layout) -> tuple[np.ndarray, np.ndarray]:
        rows, columns = [], []
        for coupling in self.couplings:
            shape = coupling.values.shape
            left = np.broadcast_to(layout.free_numbers[coupling.rows][coupling.nodes[:, 0], :, None], shape)
            right = np.broadcast_to(layout.free_numbers[coupling.columns][coupling.nodes[:, 1], None, :], shape)
            rows += [left.ravel(), right[coupling.mirrored].ravel()]
            columns += [right.ravel(), left[coupling.mirrored].ravel()]
        return np.concatenate(rows), np.concatenate(columns)

    def residual(self, forces: Forces) -> None:
        for chunk in self._chunks():
            for term in self._terms:
                for number, vectors in term.vectors(chunk):
                    _add_rows(forces.on(number), self._nodes[self.numbers.index(number)][chunk], vectors)

    def extrapolate_stress(self) -> None:
        for chunk in self._chunks():
            for term in self._terms:
                term.extrapolate_stress(chunk)

    def tangent(self, held: Forces) -> Sequence[np.ndarray]:
        for coupling in self.couplings:
            coupling.values[:] = 0
        bases = {n: f.variations() for n, f in zip(self.numbers, self._fields, strict=True)}
        nodes = dict(zip(self.numbers, self._nodes, strict=True))
        for chunk in self._chunks():
            matrices: dict[tuple[int, int], np.ndarray] = {}
            for term in self._terms:
                for number, vectors in term.add_matrices(chunk, matrices):
                    own = self.numbers.index(number)
                    if self._fields[own].curved:
                        _add_rows(held.on(number), self._nodes[own][chunk], vectors)
            for coupling in self.couplings:
                a, b = coupling.rows, coupling.columns
                if (a, b) in matrices:
                    raw = [self._raw[self.numbers.index(n)] for n in (a, b)]
                    sizes = tuple((0,) * n for n in (*raw, *coupling.values.shape[1:]))
                    _add_blocks(matrices[a, b], *_layout(*raw, a == b), bases[a], bases[b], nodes[a][chunk],
                                nodes[b][chunk], coupling.pairs[chunk], coupling.values, sizes)
        return [values.ravel() for coupling in self.couplings
                for values in (coupling.values, coupling.values[coupling.mirrored])]


class _TermWork:
    """Evaluation of one term: densities at the points, and their products with shape functions."""

    def __init__(self, term: Term, domain: Mesh, cells: np.ndarray, fields, increments):
        self._domain, self._cells, self._rule = domain, cells, term.rule
        strains, jet, self._parts = as_function_of_jet(term.strains, [f.value for f in fields])
        values = [f.value for f in fields]
        self.numbers = [values.index(p.field) for p in self._parts]
        self._tables = [_tabulate(p, term.rule) for p in self._parts]
        resultants = term.law(strains)
        slopes = ufl.diff(strains, jet)
        i, j, k = ufl.indices(3)
        force = ufl.as_vector(resultants[i] * slopes[i, j], j)
        if increments is None:
            held, stiffness = force, ufl.diff(force, jet)
            self._stress = None
        else:
            self._prepare_stress(term, [p.field for p in self._parts], [increments[n] for n in self.numbers])
            held = ufl.as_vector(self._stress[i] * slopes[i, j], j)
            stiffness = ufl.as_matrix(ufl.diff(resultants, jet)[i, j] * slopes[i, k], (j, k)) + ufl.diff(held, jet)
        size = ufl.JacobianDeterminant(domain)
        self._force = self._expression(size * force)
        self._entries = [_entries(one, other) for one, other in combinations_with_replacement(self._parts, 2)]
        self._products = [_products(one, other, term.rule.weights)
                          for one, other in combinations_with_replacement(self._tables, 2)]
        entries = [stiffness[e] for pairs in self._entries for e in pairs]
        self._stiffness = self._expression(size * ufl.as_vector(entries + [held[e] for e in range(jet.ufl_shape[0])]))

    def _prepare_stress(self, term, values, increments) -> None:
        shape = term.strains.ufl_shape
        element = basix.ufl.quadrature_element(self._domain.basix_cell(), value_shape=shape,
                                               points=term.rule.points, weights=term.rule.weights)
        self._stress = fem.Function(fem.functionspace(self._domain, element))
        self._stress_rows = self._stress.function_space.dofmap.list[self._cells]
        resultants = term.law(term.strains)
        self._extrapolated = self._expression(resultants + ufl.derivative(resultants, values, increments))

    def _expression(self, expression) -> fem.Expression:
        """Values at the points of the rule."""
        return fem.Expression(lift_numbers(ufl.algorithms.expand_derivatives(expression), self._domain),
                              self._rule.points, jit_options=JIT)

    def _evaluate(self, expression, chunk) -> np.ndarray:
        table = expression.eval(self._domain, self._cells[chunk])
        return table.reshape(len(table), len(self._rule.weights), -1)

    def _integrated(self, values):
        """Number of each field and its element vectors (cells, components, nodes) from densities of the jet."""
        for part, number, table in zip(self._parts, self.numbers, self._tables, strict=True):
            count = part.components * len(part.orders)
            density = values[:, :, part.start: part.start + count].reshape(
                *values.shape[:2], part.components, len(part.orders))
            yield number, np.tensordot(density, table * self._rule.weights[None, :, None], ((3, 1), (0, 1)))

    def vectors(self, chunk):
        """Number of each field and its internal forces."""
        return self._integrated(self._evaluate(self._force, chunk))

    def extrapolate_stress(self, chunk) -> None:
        values = self._evaluate(self._extrapolated, chunk)
        width = values.shape[2]
        self._stress.x.array.reshape(-1, width)[self._stress_rows[chunk].ravel()] = values.reshape(-1, width)

    def add_matrices(self, chunk, matrices: dict):
        """Add element matrices (cells, pairs of components, n, m) by numbers of fields; return held forces."""
        values, start = self._evaluate(self._stiffness, chunk), 0
        couplings = zip(combinations_with_replacement(self.numbers, 2), self._entries, self._products, strict=True)
        for pair, entries, products in couplings:
            density = values[:, :, start: start + len(entries)]
            orders = products.shape[0] // values.shape[1]
            density = density.reshape(*values.shape[:2], -1, orders).transpose(0, 2, 1, 3)
            shape = (*density.shape[:2], *products.shape[1:])
            flat = np.ascontiguousarray(density).reshape(-1, products.shape[0])
            found = (flat @ products.reshape(products.shape[0], -1)).reshape(shape)
            if pair in matrices:
                matrices[pair] += found
            else:
                matrices[pair] = found
            start += len(entries)
        return self._integrated(values[:, :, start:])


def _component_pairs(rows: int, columns: int, same: bool) -> list[tuple[int, int]]:
    """Pairs of components that are kept: for one field with itself those with the first not above the second."""
    return [(c, d) for c, d in product(range(rows), range(columns)) if not same or c <= d]


def _entries(one: FieldJet, other: FieldJet) -> list[tuple[int, int]]:
    """Entries of the jet's stiffness that couple two fields."""
    pairs = _component_pairs(one.components, other.components, one is other)
    orders = list(product(range(len(one.orders)), range(len(other.orders))))
    return [(one.entry(c, k), other.entry(d, m)) for c, d in pairs for k, m in orders]


@lru_cache
def _layout(rows: int, columns: int, same: bool) -> tuple[np.ndarray, np.ndarray]:
    """For each pair of components the number of its element matrix, and whether that must be transposed."""
    block, flipped = np.zeros((rows, columns), dtype=np.int64), np.zeros((rows, columns), dtype=np.bool_)
    for number, (c, d) in enumerate(_component_pairs(rows, columns, same)):
        block[c, d] = number
        if same and c != d:
            block[d, c], flipped[d, c] = number, True
    return block, flipped


def _tabulate(part: FieldJet, rule: Rule) -> np.ndarray:
    """Shape functions and derivatives that a jet uses, shape (orders, points, nodes)."""
    element = part.field.function_space.element.basix_element
    table = element.tabulate(1, rule.points)[..., 0]
    return np.ascontiguousarray(table[list(part.orders)])


def _products(one: np.ndarray, other: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """Weighted products of shape functions, shape (points * orders * orders, n, m)."""
    table = np.einsum("q,kqi,mqj->qkmij", weights, one, other)
    return np.ascontiguousarray(table.reshape(-1, one.shape[2], other.shape[2]))


def _node_pairs(rows: np.ndarray, columns: np.ndarray, same: bool) -> tuple[np.ndarray, np.ndarray]:
    """Pairs of nodes that share a cell, and for each cell the number of each of its pairs (see Coupling)."""
    width = int(columns.max(initial=0)) + 1
    keys = rows[:, :, None] * width + columns[:, None, :]
    kept = rows[:, :, None] <= columns[:, None, :] if same else np.ones(keys.shape, dtype=bool)
    unique, inverse = np.unique(keys[kept], return_inverse=True)
    pairs = np.full(keys.shape, -1)
    pairs[kept] = inverse
    return np.column_stack((unique // width, unique % width)), pairs


def _add_rows(target: np.ndarray, nodes: np.ndarray, values: np.ndarray) -> None:
    """Add element vectors (cells, components, nodes) to nodal rows."""
    for component in range(target.shape[1]):
        target[:, component] += np.bincount(nodes.ravel(), values[:, component, :].ravel(), len(target))


@numba.njit(cache=True, fastmath=True)
def _add_blocks(matrices, block, flipped, row_basis, column_basis, rows, columns, pairs, values, sizes):
    """Add element matrices, taken to nodal increments, to the blocks of pairs of nodes.

    `sizes` holds tuples whose lengths are the numbers of components of the raw row and column and of their
    increments: constants at compilation, so that the innermost loops are unrolled.
    """
    raw_rows, raw_columns, row_width, width = (len(sizes[0]), len(sizes[1]), len(sizes[2]), len(sizes[3]))
    plain_rows, plain_columns = row_basis.shape[0] == 1, column_basis.shape[0] == 1
    whole, half = np.empty((raw_rows, raw_columns)), np.empty((raw_rows, width))
    for c in range(matrices.shape[0]):
        for i in range(rows.shape[1]):
            row = row_basis[0 if plain_rows else rows[c, i]]
            for j in range(columns.shape[1]):
                pair = pairs[c, i, j]
                if pair < 0:
                    continue
                for a in range(raw_rows):
                    for b in range(raw_columns):
                        k = block[a, b]
                        whole[a, b] = matrices[c, k, j, i] if flipped[a, b] else matrices[c, k, i, j]
                if plain_rows and plain_columns:
                    for m in range(row_width):
                        for n in range(width):
                            values[pair, m, n] += whole[m, n]
                    continue
                column = column_basis[0 if plain_columns else columns[c, j]]
                for a in range(raw_rows):
                    for n in range(width):
                        total = 0.0
                        for b in range(raw_columns):
                            total += whole[a, b] * column[b, n]
                        half[a, n] = total
                for m in range(row_width):
                    for n in range(width):
                        total = 0.0
                        for a in range(raw_rows):
                            total += row[a, m] * half[a, n]
                        values[pair, m, n] += total
