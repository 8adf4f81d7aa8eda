"""Element vectors and matrices of internal virtual work.

Strains are differentiated with respect to the jet of the fields at each integration point; shape
functions enter by one product of dense matrices for many cells at once, and rotations by their nodal
variations: a nodal quaternion varies by half the product of the nodal spin and itself, so that residual
and tangent are exact derivatives of the energy as a function of the nodal rotations.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import combinations_with_replacement, product

import basix.ufl
import numba
import numpy as np
import ufl
from dolfinx import fem
from dolfinx.mesh import Mesh

from .compat import JIT
from .jets import FieldJet, as_function_of_jet
from .numbers import lift_numbers
from .quadrature import Rule
from .unknowns import AdditiveField

CHUNK = 256


@dataclass(frozen=True)
class Internal:
    """Internal virtual work of one group of cells with one quadrature rule.

    Attributes
    ----------
    strains : UFL vector of generalised strains
    law : function from strains to stress resultants, the gradient of an energy density
    rule : quadrature
    mesh, cells : what is integrated over (cells of this process)
    """

    strains: object
    law: Callable
    rule: Rule
    mesh: Mesh
    cells: np.ndarray


@dataclass(frozen=True)
class FieldPair:
    """Blocks of the tangent that couple nodes of two fields.

    Attributes
    ----------
    rows, columns : places of the fields in the list of fields
    nodes : shape (n, 2), pairs of nodes on this process that share a cell
    values : shape (n, components of a node's row increment, of its column increment)
    """

    rows: int
    columns: int
    nodes: np.ndarray
    values: np.ndarray


class ElementWork:
    """Residual and tangent of one internal term.

    Parameters
    ----------
    term : Internal
    fields : fields that the strains may depend on
    increments : for each field a Function with its change in the last Newton step, for the mixed integration
        point tangent (Magisano, Leonetti and Garcea 2017); None: the plain tangent
    """

    def __init__(self, term: Internal, fields: list[AdditiveField], increments: list[fem.Function] | None):
        self.term, self.mixed = term, increments is not None
        mesh = term.mesh
        strains, jet, self._parts = as_function_of_jet(term.strains, [f.value for f in fields])
        self._fields = [next(f for f in fields if f.value is p.field) for p in self._parts]
        self.places = [fields.index(f) for f in self._fields]
        self._tables = [_tabulate(p, mesh, term.rule.points) for p in self._parts]
        self._nodes = [p.field.function_space.dofmap.list[term.cells].astype(np.int64) for p in self._parts]
        resultants = term.law(strains)
        slopes = ufl.diff(strains, jet)
        if self.mixed:
            element = basix.ufl.quadrature_element(mesh.basix_cell(), value_shape=strains.ufl_shape,
                                                   points=term.rule.points, weights=term.rule.weights)
            self._stress = fem.Function(fem.functionspace(mesh, element))
            self._stress_dofs = self._stress.function_space.dofmap.list[term.cells]
            change = {f.value: d for f, d in zip(fields, increments, strict=True)}
            self._extrapolate = self._expression(
                term.law(term.strains) + ufl.derivative(term.law(term.strains), list(change), list(change.values())))
        i, j, k = ufl.indices(3)
        volume = ufl.JacobianDeterminant(mesh)
        force = ufl.as_vector(resultants[i] * slopes[i, j], j)
        self._force = self._expression(volume * force)
        if self.mixed:
            held = ufl.as_vector(self._stress[i] * slopes[i, j], j)
            stiffness = ufl.as_matrix(ufl.diff(resultants, jet)[i, j] * slopes[i, k], (j, k)) + ufl.diff(held, jet)
        else:
            held, stiffness = force, ufl.diff(force, jet)
        self._couplings = [_Coupling(self._parts, a, b) for a, b in combinations_with_replacement(
            range(len(self._parts)), 2)]
        entries = [stiffness[e] for c in self._couplings for e in c.entries]
        entries += [held[e] for e in range(jet.ufl_shape[0])]
        self._stiffness = self._expression(volume * ufl.as_vector(entries))
        self.pairs = []
        for coupling in self._couplings:
            coupling.table = _products(self._tables[coupling.a], self._tables[coupling.b], term.rule.weights)
            nodes, coupling.pairs = _node_pairs(self._nodes[coupling.a], self._nodes[coupling.b])
            widths = [self._fields[n].width for n in (coupling.a, coupling.b)]
            self.pairs.append(FieldPair(self.places[coupling.a], self.places[coupling.b], nodes,
                                        np.zeros((len(nodes), *widths))))
        self.curvatures = [np.zeros(len(f.previous.x.array) // p.components)
                           for f, p in zip(self._fields, self._parts, strict=True)]

    def _expression(self, expression) -> fem.Expression:
        return fem.Expression(lift_numbers(ufl.algorithms.expand_derivatives(expression), self.term.mesh),
                              self.term.rule.points, jit_options=JIT)

    def _chunks(self):
        count = len(self.term.cells)
        return [slice(start, min(start + CHUNK, count)) for start in range(0, count, CHUNK)]

    def _values(self, expression, chunk) -> np.ndarray:
        table = expression.eval(self.term.mesh, self.term.cells[chunk])
        return table.reshape(len(table), len(self.term.rule.weights), -1)

    def residual(self, forces: list[np.ndarray]) -> None:
        """Add internal forces, conjugate to the raw components of each field, shape (nodes, components)."""
        for chunk in self._chunks():
            values = self._values(self._force, chunk)
            for part, table, nodes, place in zip(self._parts, self._tables, self._nodes, self.places, strict=True):
                _add_rows(forces[place], nodes[chunk], self._integrate(values, part, table))

    def _integrate(self, values, part: FieldJet, table) -> np.ndarray:
        """Element vectors of one field from densities at the points: (cells, components, nodes)."""
        count = part.components * len(part.orders)
        density = values[:, :, part.start: part.start + count].reshape(
            *values.shape[:2], part.components, len(part.orders))
        return np.tensordot(density, table * self.term.rule.weights[None, :, None], ((3, 1), (0, 1)))

    def extrapolate_stress(self) -> None:
        """Stresses of the tangent: those of the current state plus their linear change by the increments."""
        for chunk in self._chunks():
            values = self._values(self._extrapolate, chunk)
            self._stress.x.array.reshape(-1, values.shape[2])[self._stress_dofs[chunk].ravel()] = values.reshape(
                -1, values.shape[2])

    def tangent(self) -> None:
        """Put the tangent into `pairs`, and the second variation of rotations into `curvatures`."""
        for pair in self.pairs:
            pair.values[:] = 0
        for curvature in self.curvatures:
            curvature[:] = 0
        bases = [f.variations() for f in self._fields]
        for chunk in self._chunks():
            values = self._values(self._stiffness, chunk)
            start = 0
            for coupling, pair in zip(self._couplings, self.pairs, strict=True):
                stop = start + len(coupling.entries)
                matrices = coupling.matrices(values[:, :, start:stop])
                _add_blocks(matrices, coupling.block, coupling.flipped, bases[coupling.a], bases[coupling.b],
                            self._nodes[coupling.a][chunk], self._nodes[coupling.b][chunk],
                            coupling.pairs[chunk], pair.values)
                start = stop
            for number, field in enumerate(self._fields):
                if field.curved:
                    part = self._parts[number]
                    held = self._integrate(values[:, :, start:], part, self._tables[number])
                    along = field.value.x.array.reshape(-1, part.components)[self._nodes[number][chunk]]
                    work = np.einsum("cki,cik->ci", held, along)
                    self.curvatures[number] -= np.bincount(
                        self._nodes[number][chunk].ravel(), work.ravel() / 4, len(self.curvatures[number]))


class _Coupling:
    """Layout of the entries of the jet's stiffness that couple two fields.

    For one field with itself only pairs of components (c, d) with c <= d are kept.
    """

    def __init__(self, parts: list[FieldJet], a: int, b: int):
        self.a, self.b = a, b
        one, other = parts[a], parts[b]
        pairs = [(c, d) for c, d in product(range(one.components), range(other.components)) if a != b or c <= d]
        self.entries = [(one.entry(c, k), other.entry(d, m)) for c, d in pairs
                        for k, m in product(range(len(one.orders)), range(len(other.orders)))]
        self.block = np.zeros((one.components, other.components), dtype=np.int64)
        self.flipped = np.zeros((one.components, other.components), dtype=np.bool_)
        for number, (c, d) in enumerate(pairs):
            self.block[c, d] = number
            if a == b and c != d:
                self.block[d, c], self.flipped[d, c] = number, True
        self._count = len(pairs)
        self.table = self.pairs = None

    def matrices(self, values: np.ndarray) -> np.ndarray:
        """Element matrices of each pair of components, shape (cells, pairs of components, n, m)."""
        cells, points, _ = values.shape
        values = values.reshape(cells, points, self._count, -1).transpose(0, 2, 1, 3)
        flat = np.ascontiguousarray(values).reshape(cells * self._count, -1)
        return (flat @ self.table.reshape(flat.shape[1], -1)).reshape(cells, self._count, *self.table.shape[1:])


def _tabulate(part: FieldJet, mesh: Mesh, points: np.ndarray) -> np.ndarray:
    """Shape functions and derivatives that a jet uses, shape (orders, points, nodes)."""
    element = part.field.function_space.element.basix_element
    table = element.tabulate(1, points)[..., 0]
    return np.ascontiguousarray(table[list(part.orders)])


def _products(one: np.ndarray, other: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """Weighted products of shape functions, shape (points * orders * orders, n, m)."""
    table = np.einsum("q,kqi,mqj->qkmij", weights, one, other)
    return np.ascontiguousarray(table.reshape(-1, one.shape[2], other.shape[2]))


def _node_pairs(rows: np.ndarray, columns: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Pairs of nodes that share a cell, and for each cell the number of each of its pairs."""
    width = int(columns.max(initial=0)) + 1
    keys = rows[:, :, None] * width + columns[:, None, :]
    unique, inverse = np.unique(keys, return_inverse=True)
    return np.column_stack((unique // width, unique % width)), inverse.reshape(keys.shape)


def _add_rows(target: np.ndarray, nodes: np.ndarray, values: np.ndarray) -> None:
    """Add element vectors (cells, components, nodes) to nodal rows."""
    for component in range(target.shape[1]):
        target[:, component] += np.bincount(nodes.ravel(), values[:, component, :].ravel(), len(target))


@numba.njit(cache=True)
def _add_blocks(matrices, block, flipped, row_basis, column_basis, rows, columns, pairs, values):
    """Add element matrices, taken to nodal increments, to the blocks of pairs of nodes."""
    raw_rows, raw_columns = block.shape
    half = np.empty((raw_rows, column_basis.shape[2]))
    for c in range(matrices.shape[0]):
        for i in range(rows.shape[1]):
            row = row_basis[rows[c, i] % row_basis.shape[0]]
            for j in range(columns.shape[1]):
                column = column_basis[columns[c, j] % column_basis.shape[0]]
                half[:] = 0.0
                for a in range(raw_rows):
                    for b in range(raw_columns):
                        entry = matrices[c, block[a, b], j, i] if flipped[a, b] else matrices[c, block[a, b], i, j]
                        for n in range(half.shape[1]):
                            half[a, n] += entry * column[b, n]
                target = values[pairs[c, i, j]]
                for a in range(raw_rows):
                    for m in range(row.shape[1]):
                        for n in range(half.shape[1]):
                            target[m, n] += row[a, m] * half[a, n]
