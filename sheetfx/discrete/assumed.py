"""Work of a term whose law is called with assumed strains, once at each point of integration.

The strains e are sampled at the points of integration and at the fewer points of a lower rule. With their polynomial
through the latter, P e, the law is given

    e* = P e + r (e - P e),    0 <= r <= 1,

a fixed matrix between the points of a cell. Where e is of the full rule's degree, P is its projection on polynomials
of one degree less (their difference is Legendre's polynomial, whose zeros are Gauss's points), so that an elastic law
stores (1 - r^2) of the energy by the lower rule and r^2 of that by the full one: selective reduced integration (Malkus
and Hughes 1978; Arnold and Brezzi 1997), but one that coupled laws and laws with history can bear. The tangent,

    B*^T C B* + sum of s^ d2e,    s^ = T^T (weight s),

is the exact Hessian of the energy for the matrix T of e*.
"""

from __future__ import annotations

from itertools import combinations_with_replacement

import numpy as np
import ufl
from dolfinx.mesh import Mesh

from ..mesh.quadrature import Rule
from ..model.work import Term
from .densities import Densities, add_matrix, at_points, component_pairs, put
from .laws import FormulaLaw


class AssumedWork(Densities):
    """Work of a term with `tying`.

    Parameters
    ----------
    increments : see `elements.ElementWork`
    """

    def __init__(self, term: Term, domain: Mesh, cells: np.ndarray, fields, increments):
        sampling = np.vstack((term.rule.points, term.tying.low.points))
        super().__init__(term.strains, domain, cells, fields, Rule(sampling, np.ones(len(sampling))))
        self._count, self._size = len(term.rule.points), term.strains.ufl_shape[0]
        self._extrapolation = term.tying.extrapolation
        slopes = ufl.diff(self.strains, self.jet)
        width = self.jet.ufl_shape[0]
        self._strains = self.expression(self.strains)
        self._kinematics = self.expression(ufl.as_vector(
            [self.strains[i] for i in range(self._size)]
            + [slopes[i, j] for i in range(self._size) for j in range(width)]))
        self._sampled, self._rows = self.function()
        self._curvature = self.expression(ufl.as_vector(self.pairs(
            ufl.diff(ufl.diff(ufl.dot(self._sampled, self.strains), self.jet), self.jet))))
        self._measure, self._roots = _measure_and_roots(term, domain, cells)
        self._law = FormulaLaw(term.law, self._size, domain, cells, term.rule)
        self._increments = None if increments is None else [increments[n] for n in self.numbers]
        self._held = np.zeros((*self._measure.shape, self._size))

    def _assumed(self, chunk: slice, values: np.ndarray) -> np.ndarray:
        """Assumed values at the points of integration of values (cells, points, strains, ...)."""
        here, low = values[:, :self._count], values[:, self._count:]
        projected = (self._extrapolation @ low.reshape(*low.shape[:2], -1)).reshape(here.shape)
        roots = self._roots[chunk].reshape(*here.shape[:3], *(1,) * (here.ndim - 3))
        return projected + roots * (here - projected)

    def _sampled_forces(self, chunk: slice, forces: np.ndarray) -> np.ndarray:
        """Forces on the sampled strains from those on the assumed ones: the transpose of `_assumed`."""
        here = self._roots[chunk] * forces
        return np.concatenate((here, self._extrapolation.T @ (forces - here)), axis=1)

    def _sample(self, chunk: slice) -> tuple[np.ndarray, np.ndarray]:
        """Assumed strains, and derivatives of the sampled ones by the jet, (cells, points, strains, jet)."""
        values = self.evaluate(self._kinematics, chunk)
        strains, slopes = values[..., :self._size], values[..., self._size:]
        return self._assumed(chunk, strains), slopes.reshape(*strains.shape, -1)

    def vectors(self, chunk: slice):
        """Number of each field and its internal forces."""
        strains, slopes = self._sample(chunk)
        return self._forces(chunk, slopes, self._law(chunk, strains)[0])

    def _forces(self, chunk: slice, slopes: np.ndarray, resultants: np.ndarray):
        forces = self._sampled_forces(chunk, self._measure[chunk, :, None] * resultants)
        return self.integrated((forces[:, :, None] @ slopes)[:, :, 0])

    def extrapolate_stress(self, chunk: slice) -> None:
        strains, slopes = self._sample(chunk)
        resultants, moduli = self._law(chunk, strains)
        change = self._assumed(chunk, (slopes @ self._change_of_jet(chunk)[..., None])[..., 0])
        self._held[chunk] = resultants + (moduli @ change[..., None])[..., 0]

    def _change_of_jet(self, chunk: slice) -> np.ndarray:
        """Change of the jet at the sampling points in the last Newton step, (cells, points, jet)."""
        changes = []
        for part, table, increment in zip(self.parts, self.tables, self._increments, strict=True):
            nodes = increment.function_space.dofmap.list[self.cells[chunk]]
            values = increment.x.array.reshape(-1, part.components)[nodes]
            change = np.tensordot(values, table, (1, 2)).transpose(0, 3, 1, 2)
            changes.append(change.reshape(*change.shape[:2], -1))
        return np.concatenate(changes, axis=2)

    def add_matrices(self, chunk: slice, matrices: dict):
        """Add element matrices (cells, pairs of components, n, m) by numbers of fields; return held forces."""
        strains, slopes = self._sample(chunk)
        resultants, moduli = self._law(chunk, strains)
        held = resultants if self._increments is None else self._held[chunk]
        self._add_material(chunk, slopes, moduli, matrices)
        forces = self._sampled_forces(chunk, self._measure[chunk, :, None] * held)
        put(self._sampled, self._rows[chunk], forces)
        self.add_products(self.evaluate(self._curvature, chunk), matrices)
        return self.integrated((forces[:, :, None] @ slopes)[:, :, 0])

    def _add_material(self, chunk: slice, slopes: np.ndarray, moduli: np.ndarray, matrices: dict) -> None:
        """Add B*^T C B*."""
        weighted = self._measure[chunk, :, None, None] * moduli
        cells, rows = len(slopes), self._count * self._size
        assumed = {}
        for number, part, table in zip(self.numbers, self.parts, self.tables, strict=True):
            nodal = self.of_field(slopes, part) @ table.transpose(1, 0, 2)[None, :, None]
            assumed[number] = self._assumed(chunk, nodal.reshape(*slopes.shape[:3], -1))
        forces = {number: (weighted @ b).reshape(cells, rows, -1) for number, b in assumed.items()}
        components = {number: part.components for number, part in zip(self.numbers, self.parts, strict=True)}
        for one, other in combinations_with_replacement(self.numbers, 2):
            found = assumed[one].reshape(cells, rows, -1).transpose(0, 2, 1) @ forces[other]
            found = found.reshape(cells, components[one], -1, components[other], found.shape[2] // components[other])
            pairs = component_pairs(components[one], components[other], one == other)
            add_matrix(matrices, (one, other), np.stack([found[:, c, :, d] for c, d in pairs], axis=1))


def _measure_and_roots(term: Term, domain: Mesh, cells: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Weights of the points of each cell, (cells, points), and r for each strain there, (cells, points, strains)."""
    data = ufl.as_vector([ufl.JacobianDeterminant(domain), *(ufl.sqrt(s) for s in term.tying.shares)])
    values = at_points(data, domain, term.rule.points).eval(domain, cells)
    values = values.reshape(len(cells), len(term.rule.points), -1)
    return values[..., 0] * term.rule.weights, np.ascontiguousarray(values[..., 1:])
