"""Work of a term whose law is called with assumed strains, once at each point of integration.

The strains e are sampled at the points of integration and at the fewer points of a lower rule. With their polynomial
P e through the latter, and the polynomial Q e of the same kind that is nearest to them at the former, the law is given

    e* = (1 - r^2) P e + r^2 Q e + r (e - Q e),    0 <= r <= 1,

a fixed matrix between the points of a cell. Polynomial and rest are orthogonal: constant moduli do no work between
them, and constant forces the work that r^2 of the full rule and 1 - r^2 of the lower one give. Where e is of the full
rule's degree in an affine cell, P e = Q e (what is left is Legendre's polynomial, whose zeros are Gauss's points), so
that an elastic law stores its energy by these shares of both rules: selective reduced integration (Malkus and Hughes
1978; Arnold and Brezzi 1997), but one that coupled laws and laws with history can bear. The tangent,

    B*^T C B* + sum of s^ d2e,    s^ = T^T (weight s),

is the exact Hessian of the energy for the matrix T of e*.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations_with_replacement

import numpy as np
import ufl
from dolfinx.mesh import Mesh

from ..mesh.quadrature import Rule
from ..model.history import has_history
from ..model.work import Term
from .densities import WAY, Densities, at_points, put
from .laws import FormulaLaw, RememberingLaw
from .material import add_material


class AssumedWork:
    """Work of a term whose law is called once at each point, with strains that may be tied to a lower rule.

    Parameters
    ----------
    increments : see `elements.ElementWork`

    Attributes
    ----------
    numbers : of the fields that occur, in `fields`
    """

    def __init__(self, term: Term, domain: Mesh, cells: np.ndarray, fields, increments):
        self._full = _Sampling(term.strains, domain, cells, fields, term.rule.points)
        self._low, self._tying, self._size = None, term.tying, term.strains.ufl_shape[0]
        self._places = np.full(self._size, -1)  # of the strains among the tied ones
        if self._tying:
            self._places[list(self._tying.tied)] = np.arange(len(self._tying.tied))
            tied = ufl.as_vector([term.strains[i] for i in self._tying.tied])
            self._low = _Sampling(tied, domain, cells, fields, self._tying.low.points)
        self._samplings = [s for s in (self._full, self._low) if s is not None]
        self.numbers = self._full.numbers
        self._measure, self._roots = _measure_and_roots(term, domain, cells)
        self._projection = _projection(term, domain, cells)
        weighted = self._projection.transpose(0, 2, 1) * self._measure[:, None, :]
        self._nearest = np.linalg.solve(weighted @ self._projection, weighted)
        self._law = (RememberingLaw(term.law, (*self._measure.shape, self._size)) if has_history(term.law)
                     else FormulaLaw(term.law, self._size, domain, cells, term.rule))
        self._increments = increments
        self._held = np.zeros((*self._measure.shape, self._size))

    def _assumed(self, chunk: slice, values: list[np.ndarray]) -> np.ndarray:
        """Assumed values from those sampled at each rule, (cells, points, strains, ...); the first are written over."""
        here, *low = values
        if low:
            tied = here[:, :, self._tying.tied]
            roots = self._roots[chunk].reshape(len(tied), 1, -1, *(1,) * (tied.ndim - 3))
            low = (1 - roots**2) * low[0] - (roots - roots**2) * _along(self._nearest[chunk], tied)
            here[:, :, self._tying.tied] = _along(self._projection[chunk], low) + roots * tied
        return here

    def _sampled(self, chunk: slice, forces: np.ndarray) -> list[np.ndarray]:
        """Forces on the strains sampled at each rule from those on the assumed ones: the transpose of `_assumed`."""
        if self._low is None:
            return [forces]
        tied = forces[:, :, self._tying.tied]
        roots, low = self._roots[chunk, None], self._projection[chunk].transpose(0, 2, 1) @ tied
        forces[:, :, self._tying.tied] = roots * tied - self._nearest[chunk].transpose(0, 2, 1) @ (
            (roots - roots**2) * low)
        return [forces, (1 - roots**2) * low]

    def _sample(self, chunk: slice) -> tuple[np.ndarray, list[np.ndarray]]:
        """Assumed strains, and the derivatives of the sampled ones by the jets."""
        strains, slopes = zip(*(s.sample(chunk) for s in self._samplings), strict=True)
        return self._assumed(chunk, list(strains)), list(slopes)

    def _forces(self, chunk: slice, resultants: np.ndarray) -> list[np.ndarray]:
        return self._sampled(chunk, self._measure[chunk, :, None] * resultants)

    def _integrated(self, forces: list[np.ndarray], slopes: list[np.ndarray]):
        for sampling, force, slope in zip(self._samplings, forces, slopes, strict=True):
            yield from sampling.integrated((force[:, :, None] @ slope)[:, :, 0])

    def vectors(self, chunk: slice):
        """Number of each field and its internal forces."""
        strains, slopes = self._sample(chunk)
        return self._integrated(self._forces(chunk, self._law(chunk, strains)[0]), slopes)

    @property
    def measure(self) -> np.ndarray:
        """Weights of the points of integration, (cells, points)."""
        return self._measure

    @property
    def memory(self) -> RememberingLaw | None:
        """The law where it is one with history."""
        return self._law if isinstance(self._law, RememberingLaw) else None

    def commit(self, chunk: slice) -> None:
        """Let history move on to the present strains."""
        if self.memory:
            self.memory.commit(chunk, self._sample(chunk)[0])

    def pass_by(self, chunk: slice, begins: bool) -> None:
        """Add the present strains to those that a step comes by, see `laws.RememberingLaw.pass_by`."""
        self.memory.pass_by(chunk, self._sample(chunk)[0], begins)

    def forgotten(self, chunk: slice):
        """Number of each field and the internal forces that a step to the present strains forgets; powers on the way.

        See `laws.RememberingLaw.forgotten`.
        """
        strains, slopes = self._sample(chunk)
        resultants, powers = self.memory.forgotten(chunk, strains, self._measure[chunk])
        return self._integrated(self._forces(chunk, resultants), slopes), powers

    def resultants(self, chunk: slice) -> np.ndarray:
        """Present resultants at the points of integration, (cells, points, strains)."""
        return self._law(chunk, self._sample(chunk)[0])[0]

    def compile_energy(self) -> None:
        """Nothing has to be compiled for `energy`."""

    def energies(self, chunk: slice) -> tuple[float, float]:
        """What a law with history stores at the present strains, and has dissipated."""
        stored, dissipated = self.memory.energies(chunk, self._sample(chunk)[0])
        return float(np.sum(self._measure[chunk] * stored)), float(np.sum(self._measure[chunk] * dissipated))

    def energy(self, chunk: slice) -> float:
        """Work of the resultants on the way to the present strains; of a law with history what it stores."""
        if self.memory:
            return self.energies(chunk)[0]
        strains, _ = self._sample(chunk)
        density = sum(weight * np.sum(self._law(chunk, share * strains)[0] * strains, axis=2) for share, weight in WAY)
        return float(np.sum(self._measure[chunk] * density))

    def extrapolate_stress(self, chunk: slice) -> None:
        strains, slopes = self._sample(chunk)
        self._held[chunk], moduli = self._law(chunk, strains)
        if any(self._increments[number].x.array.any() for number in self.numbers):
            change = self._assumed(chunk, [s.change(chunk, slope, self._increments)
                                           for s, slope in zip(self._samplings, slopes, strict=True)])
            self._held[chunk] += (moduli @ change[..., None])[..., 0]

    def add_matrices(self, chunk: slice, matrices: dict):
        """Add element matrices (cells, pairs of components, n, m) by numbers of fields; return held forces."""
        held = self._law(chunk, self._sample(chunk)[0])[0] if self._increments is None else self._held[chunk]
        forces = self._forces(chunk, held)
        strains, slopes, curvature = zip(*(s.curved(chunk, force)
                                           for s, force in zip(self._samplings, forces, strict=True)), strict=True)
        moduli = self._measure[chunk, :, None, None] * self._law(chunk, self._assumed(chunk, list(strains)))[1]
        for sampling, values in zip(self._samplings, curvature, strict=True):
            sampling.add_products(values, matrices)
        self._add_material(chunk, slopes, moduli, matrices)
        return self._integrated(forces, slopes)

    def _add_material(self, chunk: slice, slopes: Sequence[np.ndarray], moduli: np.ndarray, matrices: dict) -> None:
        """Add B*^T C B*."""
        fields = tuple((part.components, *self._full.shapes(number), *self._samplings[-1].shapes(number))
                       for number, part in zip(self.numbers, self._full.parts, strict=True))
        pairs = combinations_with_replacement(self.numbers, 2)
        add_material(fields, slopes[0], slopes[-1], self._places, self._projection[chunk], self._nearest[chunk],
                     self._roots[chunk], moduli, tuple(matrices[pair] for pair in pairs))


class _Sampling(Densities):
    """Strains at points, and their first and second derivatives by the jet."""

    def __init__(self, strains, domain: Mesh, cells: np.ndarray, fields, points: np.ndarray):
        super().__init__(strains, domain, cells, fields, Rule(points, np.ones(len(points))))
        self._size, width = self.strains.ufl_shape[0], self.jet.ufl_shape[0]
        self._count = self._size * (1 + width)
        slopes = ufl.diff(self.strains, self.jet)
        kinematics = [self.strains[i] for i in range(self._size)]
        kinematics += [slopes[i, j] for i in range(self._size) for j in range(width)]
        self._kinematics = self.expression(ufl.as_vector(kinematics))
        self._given, self._rows = self.function()
        i, j = ufl.indices(2)
        force = ufl.as_vector(self._given[i] * slopes[i, j], j)
        self._all = self.expression(ufl.as_vector(kinematics + self.pairs(ufl.diff(force, self.jet))))

    def sample(self, chunk: slice) -> tuple[np.ndarray, np.ndarray]:
        """Strains (cells, points, strains), and their derivatives (cells, points, strains, jet)."""
        return self._split(self.evaluate(self._kinematics, chunk))

    def _split(self, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        strains, slopes = values[..., :self._size], values[..., self._size: self._count]
        return strains, np.ascontiguousarray(slopes).reshape(*strains.shape, -1)

    def curved(self, chunk: slice, forces: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """What `sample` gives, and the sum of forces times second derivatives of the strains, see `pairs`."""
        put(self._given, self._rows[chunk], forces)
        values = self.evaluate(self._all, chunk)
        return *self._split(values), values[..., self._count:]

    def shapes(self, number: int) -> tuple[int, np.ndarray]:
        """Place of a field in the jet, and its shape functions at the points; a place of -1 where it does not occur."""
        if number not in self.numbers:
            return -1, self.tables[0]
        place = self.numbers.index(number)
        return self.parts[place].start, self.tables[place]

    def change(self, chunk: slice, slopes: np.ndarray, increments) -> np.ndarray:
        """First-order change of the strains by increments of all fields, (cells, points, strains)."""
        changes = []
        for number, part, table in zip(self.numbers, self.parts, self.tables, strict=True):
            nodes = increments[number].function_space.dofmap.list[self.cells[chunk]]
            values = increments[number].x.array.reshape(-1, part.components)[nodes]
            change = np.tensordot(values, table, (1, 2)).transpose(0, 3, 1, 2)
            changes.append(change.reshape(*change.shape[:2], -1))
        return (slopes @ np.concatenate(changes, axis=2)[..., None])[..., 0]


def _measure_and_roots(term: Term, domain: Mesh, cells: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Weights of the points of each cell, (cells, points), and r of its tied strains, (cells, strains).

    It is the root of the mean share: were it not constant in a cell, constant forces would do work on e - P e.
    """
    shares = term.tying.shares if term.tying else ()
    data = ufl.as_vector([ufl.JacobianDeterminant(domain) * term.stretch, *shares])
    values = at_points(data, term.rule.points).eval(domain, cells)
    values = values.reshape(len(cells), len(term.rule.points), 1 + len(shares))
    measure = values[..., 0] * term.rule.weights
    return measure, np.sqrt(np.einsum("cq,cqi->ci", measure, values[..., 1:]) / measure.sum(axis=1)[:, None])


def _projection(term: Term, domain: Mesh, cells: np.ndarray) -> np.ndarray:
    """Matrices from values at the low rule's points to P e at those of integration, (cells, points, low points).

    The polynomial is that of strains times area: constant forces then do the work on it that the low rule gives.
    """
    tying = term.tying
    if not tying:
        return np.empty((len(cells), len(term.rule.points), 0))
    area = ufl.JacobianDeterminant(domain) * term.stretch
    areas = [at_points(area, points).eval(domain, cells).reshape(len(cells), -1)
             for points in (term.rule.points, tying.low.points)]
    return tying.extrapolation * areas[1][:, None, :] / areas[0][:, :, None]


def _along(matrices: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Products of a matrix of each cell with values at its points, (cells, points, ...)."""
    found = matrices @ values.reshape(*values.shape[:2], -1)
    return found.reshape(*found.shape[:2], *values.shape[2:])
