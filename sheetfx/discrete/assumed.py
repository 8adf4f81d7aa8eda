"""Work of a term whose law is called with assumed strains, once at each point of integration.

The law is given linear maps of the strains of the fields, fixed in each cell, see `model.tying`: e* = T e, of strains e
at the points of integration and at a lower rule's. The tangent,

    B*^T C B* + sum of s^ d2e,    s^ = T^T (weight s),

is the exact Hessian of the energy for the matrix T of e*.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from itertools import combinations_with_replacement

import numpy as np
import ufl
from dolfinx.mesh import Mesh

from ..mesh.at_points import at_points, put
from ..mesh.quadrature import Rule
from ..model.history import has_history
from ..model.tying import Map
from ..model.work import Term
from .densities import WAY, Densities
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
        self._samplings, self._size = [self._full], term.strains.ufl_shape[0]
        tying = self._tying = term.tying
        self.numbers = self._full.numbers
        area = ufl.JacobianDeterminant(domain) * term.stretch
        sizes = at_points(area, term.rule.points).eval(domain, cells)
        self._measure = term.rule.weights * sizes.reshape(len(cells), -1)
        self._maps: Sequence[Map] = []
        if tying:
            self._samplings.append(_Sampling(tying.sampled(term.strains), domain, cells, fields, tying.low.points))
            self._maps = tying.maps(domain, cells, term.rule, area, self._measure)
        self._law = (RememberingLaw(term.law, (*self._measure.shape, self._size)) if has_history(term.law)
                     else FormulaLaw(term.law, self._size, domain, cells, term.rule))
        self._increments = increments
        self._held = np.zeros((*self._measure.shape, self._size))

    def _assumed(self, chunk: slice, values: list[np.ndarray]) -> np.ndarray:
        """Assumed values from those sampled at each rule, (cells, points, strains); the first are written over."""
        here, *low = values
        for m in self._maps:
            own = _rows(here, m.strains, m.parts)
            found = m.root[chunk, None, None] * own + m.spread[chunk] @ (m.gather[chunk] @ own)
            if m.low.shape[2]:
                found += m.low[chunk] @ _rows(low[0], m.sampled, m.parts)
            here[:, :, slice(*m.strains)] = _points(found, here.shape[1])
        return here

    def _sampled(self, chunk: slice, forces: np.ndarray) -> list[np.ndarray]:
        """Forces on the strains sampled at each rule from those on the assumed ones: the transpose of `_assumed`."""
        if not self._maps:
            return [forces]
        low = self._samplings[1].zeros(chunk)
        for m in reversed(self._maps):
            own = _rows(forces, m.strains, m.parts)
            if m.low.shape[2]:
                low[:, :, slice(*m.sampled)] += _points(_against(m.low[chunk], own), low.shape[1])
            found = m.root[chunk, None, None] * own + _against(m.gather[chunk], _against(m.spread[chunk], own))
            forces[:, :, slice(*m.strains)] = _points(found, forces.shape[1])
        return [forces, low]

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

    def forces_by(self, change) -> Callable[[slice], Iterable]:
        """Function that gives the change of what `vectors` gives by a change of all strains, a UFL vector."""
        sampled = [s.expression(change if s is self._full else self._tying.sampled(change)) for s in self._samplings]

        def vectors(chunk: slice):
            strains, slopes = self._sample(chunk)
            by = self._assumed(chunk, [s.evaluate(e, chunk) for s, e in zip(self._samplings, sampled, strict=True)])
            resultants = (self._law(chunk, strains)[1] @ by[..., None])[..., 0]
            return self._integrated(self._forces(chunk, resultants), slopes)

        return vectors

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

    def forget_stress(self) -> None:
        if self._increments is not None:
            self._held[:] = 0.0

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
        maps = tuple((*m.strains, *m.sampled, m.parts, m.root[chunk], m.low[chunk], m.gather[chunk], m.spread[chunk])
                     for m in self._maps or [_without_map(len(self._measure))])
        add_material(fields, slopes[0], slopes[-1], maps, moduli, tuple(matrices[pair] for pair in pairs))


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

    def zeros(self, chunk: slice) -> np.ndarray:
        """Of the sampled strains' shape, (cells, points, strains)."""
        return np.zeros((len(self.cells[chunk]), len(self.rule.points), self._size))

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


def _without_map(cells: int) -> Map:
    """A map of no strains."""
    return Map((0, 0), (0, 0), False, np.ones(cells), *3 * [np.zeros((cells, 0, 0))])


def _rows(values: np.ndarray, strains: tuple[int, int], parts: int) -> np.ndarray:
    """Some strains at points, (cells, points, strains), as columns of each part, (cells, rows, parts)."""
    block = values[:, :, slice(*strains)]
    return np.swapaxes(np.swapaxes(block, 1, 2).reshape(len(block), parts, -1), 1, 2)


def _points(rows: np.ndarray, points: int) -> np.ndarray:
    """What `_rows` takes from what it gives."""
    return np.swapaxes(np.swapaxes(rows, 1, 2).reshape(len(rows), -1, points), 1, 2)


def _against(matrices: np.ndarray, rows: np.ndarray) -> np.ndarray:
    """Products of the transposed matrix of each cell."""
    return np.swapaxes(matrices, 1, 2) @ rows
