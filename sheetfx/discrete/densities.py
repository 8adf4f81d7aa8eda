"""Functions of the jet of the fields at points of cells, and their products with shape functions."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from functools import cached_property
from itertools import combinations_with_replacement, product

import numpy as np
import ufl
from dolfinx import fem
from dolfinx.mesh import Mesh

from ..mesh.at_points import at_points, put, values_at_points
from ..mesh.quadrature import Rule
from ..model.work import Term
from .jets import FieldJet, as_function_of_jet

# Gauss's rule for the way from no strain to the present one: exact for energies up to the sixth power of strains.
WAY = (0.5 - 0.15**0.5, 5 / 18), (0.5, 8 / 18), (0.5 + 0.15**0.5, 5 / 18)


class Densities:
    """Strains as a function of the jet of the fields at the points of a rule.

    Parameters
    ----------
    strains : UFL vector
    domain, cells : where they are evaluated
    fields : list of fields that they may depend on
    rule : points, and the weights that densities are summed with

    Attributes
    ----------
    numbers : of the fields that occur, in `fields`
    strains, jet : the strains as a function of a UFL variable
    """

    def __init__(self, strains, domain: Mesh, cells: np.ndarray, fields, rule: Rule):
        self.domain, self.cells, self.rule = domain, cells, rule
        values = [f.value for f in fields]
        self.strains, self.jet, self.parts = as_function_of_jet(strains, values)
        self.numbers = [values.index(p.field) for p in self.parts]
        self.tables = [_tabulate(p, rule) for p in self.parts]
        self._entries = [_entries(one, other) for one, other in combinations_with_replacement(self.parts, 2)]
        self._products = [_products(one, other, rule.weights)
                          for one, other in combinations_with_replacement(self.tables, 2)]

    def expression(self, expression) -> fem.Expression:
        """Values at the points of the rule."""
        return at_points(expression, self.rule.points)

    def function(self) -> tuple[fem.Function, np.ndarray]:
        """A vector of the strains' shape at each point, and for each cell its rows in `x.array`."""
        return values_at_points(self.domain, self.cells, self.rule, self.strains.ufl_shape)

    def evaluate(self, expression: fem.Expression, chunk: slice) -> np.ndarray:
        """Shape (cells, points, components)."""
        table = expression.eval(self.domain, self.cells[chunk])
        return table.reshape(len(table), len(self.rule.points), -1)

    def pairs(self, matrix) -> list:
        """Entries of a symmetric UFL matrix over the jet, in the order that `add_products` takes."""
        return [matrix[e] for pairs in self._entries for e in pairs]

    def add_products(self, values: np.ndarray, matrices: dict) -> int:
        """Add element matrices (cells, pairs of components, n, m) by numbers of fields; return the entries taken."""
        start = 0
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
        return start

    def integrated(self, values: np.ndarray):
        """Number of each field and its element vectors (cells, components, nodes) from densities of the jet."""
        for part, number, table in zip(self.parts, self.numbers, self.tables, strict=True):
            density = self.of_field(values, part)
            yield number, np.tensordot(density, table * self.rule.weights[None, :, None], ((3, 1), (0, 1)))

    @staticmethod
    def of_field(values: np.ndarray, part: FieldJet) -> np.ndarray:
        """What belongs to one field of values whose last axis is the jet: shape (..., components, orders)."""
        count = part.components * len(part.orders)
        return values[..., part.start: part.start + count].reshape(
            *values.shape[:-1], part.components, len(part.orders))


class PointwiseWork(Densities):
    """Work of a term whose law is written in UFL, and called with the strains at each point.

    Parameters
    ----------
    increments : see `elements.ElementWork`
    """

    def __init__(self, term: Term, domain: Mesh, cells: np.ndarray, fields, increments):
        super().__init__(term.strains, domain, cells, fields, term.rule)
        self._term = term
        strains, jet = self.strains, self.jet
        resultants = term.law(strains)
        slopes = ufl.diff(strains, jet)
        i, j, k = ufl.indices(3)
        force = ufl.as_vector(resultants[i] * slopes[i, j], j)
        self._stress = None
        if increments is None:
            held, stiffness = force, ufl.diff(force, jet)
        else:
            self._stress, self._stress_rows = self.function()
            given = term.law(term.strains)
            self._extrapolated = self.expression(given + ufl.derivative(
                given, [p.field for p in self.parts], [increments[n] for n in self.numbers]))
            held = ufl.as_vector(self._stress[i] * slopes[i, j], j)
            stiffness = ufl.as_matrix(ufl.diff(resultants, jet)[i, j] * slopes[i, k], (j, k)) + ufl.diff(held, jet)
        size = ufl.JacobianDeterminant(domain) * term.stretch
        self._force = self.expression(size * force)
        entries = self.pairs(stiffness) + [held[e] for e in range(jet.ufl_shape[0])]
        self._stiffness = self.expression(size * ufl.as_vector(entries))

    @cached_property
    def _energy(self) -> fem.Expression:
        density = sum(weight * ufl.dot(self._term.law(share * self._term.strains), self._term.strains)
                      for share, weight in WAY)
        return self.expression(ufl.JacobianDeterminant(self.domain) * self._term.stretch * density)

    def compile_energy(self) -> None:
        """Compile what `energy` needs, on all processes together: some may have no cells."""
        _ = self._energy

    def energy(self, chunk: slice) -> float:
        """Work of the resultants on the way to the present strains."""
        return float(np.sum(self.evaluate(self._energy, chunk)[..., 0] @ self.rule.weights))

    def vectors(self, chunk: slice):
        """Number of each field and its internal forces."""
        return self.integrated(self.evaluate(self._force, chunk))

    def forces_by(self, change) -> Callable[[slice], Iterable]:
        """Function that gives the change of what `vectors` gives by a change of all strains, a UFL vector."""
        given = ufl.variable(self.strains)
        moduli, slopes = ufl.diff(self._term.law(given), given), ufl.diff(self.strains, self.jet)
        i, j, k = ufl.indices(3)
        force = ufl.as_vector(moduli[i, k] * change[k] * slopes[i, j], j)
        changed = self.expression(ufl.JacobianDeterminant(self.domain) * self._term.stretch * force)
        return lambda chunk: self.integrated(self.evaluate(changed, chunk))

    def extrapolate_stress(self, chunk: slice) -> None:
        put(self._stress, self._stress_rows[chunk], self.evaluate(self._extrapolated, chunk))

    def forget_stress(self) -> None:
        self._stress.x.array[:] = 0.0

    def add_matrices(self, chunk: slice, matrices: dict):
        """Add element matrices (cells, pairs of components, n, m) by numbers of fields; return held forces."""
        values = self.evaluate(self._stiffness, chunk)
        return self.integrated(values[:, :, self.add_products(values, matrices):])


def component_pairs(rows: int, columns: int, same: bool) -> list[tuple[int, int]]:
    """Pairs of components that are kept: for one field with itself those with the first not above the second."""
    return [(c, d) for c, d in product(range(rows), range(columns)) if not same or c <= d]


def _entries(one: FieldJet, other: FieldJet) -> list[tuple[int, int]]:
    """Entries of the jet's stiffness that couple two fields."""
    pairs = component_pairs(one.components, other.components, one is other)
    orders = list(product(range(len(one.orders)), range(len(other.orders))))
    return [(one.entry(c, k), other.entry(d, m)) for c, d in pairs for k, m in orders]


def _tabulate(part: FieldJet, rule: Rule) -> np.ndarray:
    """Shape functions and derivatives that a jet uses, shape (orders, points, nodes)."""
    element = part.field.function_space.element.basix_element
    table = element.tabulate(1, rule.points)[..., 0]
    return np.ascontiguousarray(table[list(part.orders)])


def _products(one: np.ndarray, other: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """Weighted products of shape functions, shape (points * orders * orders, n, m)."""
    table = np.einsum("q,kqi,mqj->qkmij", weights, one, other)
    return np.ascontiguousarray(table.reshape(-1, one.shape[2], other.shape[2]))
