"""Element vectors and matrices of internal virtual work.

Strains are differentiated with respect to the jet of the fields at each integration point; shape functions
enter by one product of dense matrices for many cells at once, and rotations by the derivatives of the nodal
quaternions, so that residual and tangent are gradient and Hessian of the energy as a function of the nodal
increments.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from itertools import combinations_with_replacement, pairwise

import numba
import numpy as np
from dolfinx import fem
from mpi4py import MPI

from ..communicators import lasting
from ..model.history import has_history
from ..model.work import Internal
from . import origins
from .assumed import AssumedWork
from .cases import has_cases
from .contribution import Contribution, Forces
from .densities import PointwiseWork, component_pairs
from .layout import Layout
from .nodal_field import AdditiveField

FEWEST, MOST = 64, 512  # cells that are evaluated together, about
CACHED = 2**18  # entries of their matrices that a processor's cache holds


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
    name : of its history in snapshots, where a law has one

    Attributes
    ----------
    numbers : in `fields`, of those that occur
    couplings : list of Coupling, filled by `tangent`
    """

    def __init__(self, internal: Internal, fields: list[AdditiveField], increments: list[fem.Function | None] | None,
                 name: str = "history"):
        self.internal, domain, cells = internal, internal.domain, internal.cells
        self._terms = [(AssumedWork if t.tying or has_history(t.law) else PointwiseWork)(
            t, domain, cells, fields, increments) for t in internal.terms]
        self._memories = [(t, t.memory) for t in self._terms if isinstance(t, AssumedWork) and t.memory]
        self._name = name
        self._accepted: dict[str, np.ndarray] = {}
        self.kinks = bool(self._memories) or any(has_cases(t) for t in internal.terms)
        self.smooth = not self.kinks
        if self._memories:
            self.without_fall = ("laws with history would have to remember the long steps of a fall; trace paths by "
                                 "arc length, through the limit point")
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

    @cached_property
    def _chunks(self) -> list[slice]:
        count = len(self.internal.cells)
        values = sum(nodes.shape[1] * raw for nodes, raw in zip(self._nodes, self._raw, strict=True))
        size = np.clip(CACHED / values**2, FEWEST, MOST)
        ends = np.linspace(0, count, max(round(count / size), min(count, 1)) + 1).astype(int).tolist()
        return [slice(start, end) for start, end in pairwise(ends)]

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
        for chunk in self._chunks:
            for term in self._terms:
                self._add(forces, chunk, term.vectors(chunk))

    def _add(self, forces: Forces, chunk: slice, numbered: Iterable[tuple[int, np.ndarray]]) -> None:
        """Add forces of a chunk on fields of some numbers."""
        for number, vectors in numbered:
            _add_rows(forces.on(number), self._nodes[self.numbers.index(number)][chunk], vectors)

    def forces_by(self, change) -> Callable[[Forces], None]:
        """Function that adds the first-order change of the internal forces by a change of all strains, a UFL vector."""
        change = change + fem.Constant(self.internal.domain, np.zeros(change.ufl_shape))  # zeros alone are on no mesh
        changes = [term.forces_by(change) for term in self._terms]

        def add(forces: Forces) -> None:
            for chunk in self._chunks:
                for vectors in changes:
                    self._add(forces, chunk, vectors(chunk))

        return add

    def energy(self) -> float:
        """Energy that the cells of this process store now: the work of resultants on the way to the present strains.

        It is the integral of s(t e) . e over 0 < t < 1 for strains e and resultants s, which holds for any law that is
        the gradient of an energy density.

        Raises
        ------
        ValueError
            For a law with history that does not tell it.
        """
        if not self.tells_energy:
            raise ValueError("strain energy: a law with history does not say how much of the work it has taken is "
                             "stored; give it a method `energies`, or ask for forces instead")
        for term in self._terms:
            term.compile_energy()
        return sum(term.energy(chunk) for chunk in self._chunks for term in self._terms)

    def dissipated(self) -> float:
        """Energy that laws with history of the cells of this process have dissipated since the start."""
        return sum(term.energies(chunk)[1] for chunk in self._chunks for term, _ in self._memories)

    @property
    def tells_energy(self) -> bool:
        """Whether its laws say what they store."""
        return all(memory.tells_energy for _, memory in self._memories)

    @property
    def remembers(self) -> bool:
        """Whether a law has history."""
        return bool(self._memories)

    @property
    def resultants_inside(self) -> bool:
        """Whether resultants come from assumed strains, or from history, known at the points of integration."""
        return self.remembers or any(t.tying and not t.tying.exact for t in self.internal.terms)

    def resultants(self) -> np.ndarray:
        """Present resultants of its only term at the points of integration, (cells, points, resultants)."""
        (term,) = self._terms
        return np.concatenate([term.resultants(chunk) for chunk in self._chunks])

    @property
    def points(self) -> np.ndarray:
        """Points of integration of its first term."""
        return self.internal.terms[0].rule.points

    def history(self) -> tuple[np.ndarray, np.ndarray]:
        """What the points of a law with history remember, (cells, points, remembered), and their weights."""
        ((term, memory),) = self._memories
        return memory.history, term.measure

    def strains_and_history(self) -> tuple[np.ndarray, np.ndarray]:
        """Strains and history of a law with history at the last accepted state, (cells, points, ...)."""
        ((_, memory),) = self._memories
        return memory.strains, memory.history

    def update_history(self) -> bool:
        accepted = self.snapshot()
        self.commit()
        self._accepted = accepted
        return self.history_moved

    def rewind(self) -> None:
        if self._accepted:
            self.restore(self._accepted)

    def commit(self) -> None:
        self._accepted = {}
        for term, _ in self._memories:
            for chunk in self._chunks:
                term.commit(chunk)

    def pass_by(self, begins: bool) -> None:
        for term, _ in self._memories:
            for chunk in self._chunks:
                term.pass_by(chunk, begins)

    def forgotten(self, forces: Forces) -> np.ndarray:
        powers = []
        for term, _ in self._memories:
            for chunk in self._chunks:
                vectors, power = term.forgotten(chunk)
                self._add(forces, chunk, vectors)
                powers.append(power)
        return np.sum(powers, axis=0)

    def apart(self) -> bool:
        """Whether no point has flowed in the step that leads here, nor is on the point of it; cases may be."""
        still = bool(self._memories) and all(memory.stands_still(self._accepted[f"{self._name} {n}"])
                                             for n, (_, memory) in enumerate(self._memories))
        return self.smooth or lasting(self.internal.domain.comm).allreduce(still, op=MPI.LAND)

    @property
    def history_moved(self) -> bool:
        return lasting(self.internal.domain.comm).allreduce(any(m.moved for _, m in self._memories), op=MPI.LOR)

    def history_moved_since(self, snapshot: dict[str, np.ndarray]) -> bool:
        moved = any(memory.moved_since(snapshot[f"{self._name} {n}"]) for n, (_, memory) in enumerate(self._memories))
        return lasting(self.internal.domain.comm).allreduce(moved, op=MPI.LOR)

    def freeze(self, frozen: bool) -> None:
        for _, memory in self._memories:
            memory.frozen = frozen

    def snapshot(self) -> dict[str, np.ndarray]:
        return {f"{self._name} {n}": memory.snapshot() for n, (_, memory) in enumerate(self._memories)}

    def origins(self) -> dict[str, np.ndarray]:
        return dict.fromkeys(self.snapshot(), origins.of_cells(self.internal.domain, self.internal.cells))

    def restore(self, snapshot: dict[str, np.ndarray]) -> None:
        self._accepted = {}
        for n, (_, memory) in enumerate(self._memories):
            memory.restore(snapshot[f"{self._name} {n}"])

    def extrapolate_stress(self) -> None:
        for chunk in self._chunks:
            for term in self._terms:
                term.extrapolate_stress(chunk)

    def forget_stress(self) -> None:
        for term in self._terms:
            term.forget_stress()

    def tangent(self, held: Forces) -> Sequence[np.ndarray]:
        for coupling in self.couplings:
            coupling.values[:] = 0
        bases = {n: f.variations() for n, f in zip(self.numbers, self._fields, strict=True)}
        nodes = dict(zip(self.numbers, self._nodes, strict=True))
        for chunk in self._chunks:
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


@lru_cache
def _layout(rows: int, columns: int, same: bool) -> tuple[np.ndarray, np.ndarray]:
    """For each pair of components the number of its element matrix, and whether that must be transposed."""
    block, flipped = np.zeros((rows, columns), dtype=np.int64), np.zeros((rows, columns), dtype=np.bool_)
    for number, (c, d) in enumerate(component_pairs(rows, columns, same)):
        block[c, d] = number
        if same and c != d:
            block[d, c], flipped[d, c] = number, True
    return block, flipped


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
