"""Virtual work of the values that fields have at points: springs, joints, constraints.

The values z = P x at the points are linear in nodal values x (rotations enter by their quaternions), so that forces
f(z) and stiffness df/dz at the points become P^T f and P^T df/dz P on nodal values, and by the nodal variations an
exact Hessian.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from dolfinx import fem
from scipy.sparse import csr_matrix

from ..communicators import lasting
from .contribution import Contribution, Forces
from .layout import Layout
from .nodal_field import AdditiveField
from .point_law import EVERY, PointLaw
from .unknowns import Unknowns
from .whole import WholeField

NOTHING = 1e-14  # values of shape functions that are rounding


@dataclass(frozen=True)
class Trace:
    """Values of a field at points, by interpolation between nodes: rows of P.

    Attributes
    ----------
    field : number in `Unknowns.fields`
    nodes : shape (points, k), local numbers of nodes, or numbers in the whole field
    weights : shape (points, k)
    of : the field; a whole one: each process has all points; None: the one in `Unknowns.fields`
    """

    field: int
    nodes: np.ndarray
    weights: np.ndarray
    of: AdditiveField | WholeField | None = None

    @classmethod
    def at_nodes(cls, field: int, nodes: np.ndarray, of: AdditiveField | WholeField | None = None) -> Trace:
        """The nodal values themselves."""
        nodes = np.asarray(nodes, dtype=np.int64).reshape(-1, 1)
        return cls(field, nodes, np.ones(nodes.shape), of)

    @classmethod
    def in_cells(cls, field: int, space: fem.FunctionSpace, cells: np.ndarray, reference: np.ndarray,
                 of: AdditiveField | WholeField | None = None) -> Trace:
        """Values at reference points of cells, one in each."""
        if not len(cells):
            return cls.at_nodes(field, cells, of)
        element = space.ufl_element().basix_element
        weights = element.tabulate(0, np.ascontiguousarray(reference))[0, :, :, 0]
        weights = np.where(np.abs(weights) > NOTHING, weights, 0.0)
        nodes = space.dofmap.list[cells].astype(np.int64)
        most = (weights != 0).sum(axis=1).max(initial=0)
        order = np.sort(np.argsort(-np.abs(weights), axis=1, kind="stable")[:, :most], axis=1)
        nodes, weights = (np.take_along_axis(array, order, axis=1) for array in (nodes, weights))
        return cls(field, nodes, weights, of)


class PointWork(Contribution):
    """Virtual work of the values of fields at points.

    Parameters
    ----------
    unknowns : Unknowns
    traces : of the fields whose values count; their components one behind the other are z, shape (points, m)
    law : function from z to the forces conjugate to it, shape (points, m), and their derivative, shape (points, m, m)
    load : function from z to the derivative of the external forces by the load factor, shape (points, m); None: none
    smooth, conservative : as of a Contribution
    stage : number of the load stage
    """

    def __init__(self, unknowns: Unknowns, traces: Sequence[Trace], law: Callable, *, load: Callable | None = None,
                 smooth: bool = True, conservative: bool = True, stage: int | None = None):
        self._traces, self._law, self._load = list(traces), law, load
        self._fields: list[AdditiveField | WholeField] = [t.of or unknowns.fields[t.field] for t in traces]
        self._is_whole = any(isinstance(f, WholeField) for f in self._fields)
        self._unknowns, self._held = unknowns, None
        self._stiff: np.ndarray | slice = EVERY
        self.smooth, self.conservative, self.stage = smooth, conservative, stage
        ends = np.cumsum([f.components for f in self._fields])
        self._parts = [slice(end - f.components, end) for end, f in zip(ends, self._fields, strict=True)]

    def values(self) -> np.ndarray:
        """z at all points of this process."""
        tables = {f: f.table for f in dict.fromkeys(self._fields)}  # those of whole fields are gathered once
        return self._interpolated([tables[f] for f in self._fields])

    def _interpolated(self, tables: Sequence[np.ndarray]) -> np.ndarray:
        return np.concatenate([np.einsum("nk,nkc->nc", t.weights, table[t.nodes])
                               for t, table in zip(self._traces, tables, strict=True)], axis=1)

    def residual(self, forces: Forces) -> None:
        self._add(forces, self._forces(self.values()))

    def _forces(self, z: np.ndarray) -> np.ndarray:
        return self._law.forces(z) if isinstance(self._law, PointLaw) else self._law(z)[0]

    def load(self, forces: Forces) -> None:
        if self._load is not None:
            self._add(forces, self._load(self.values()))

    def energy(self) -> float | None:
        if not (self.smooth and isinstance(self._law, PointLaw)):
            return None
        energy = self._law.energy(self.values())
        return energy if self._is_whole else lasting(self._unknowns.blocks[0].index_map.comm).allreduce(energy)

    def _add(self, forces: Forces, values: np.ndarray, curved_only: bool = False) -> None:
        for trace, field, part in zip(self._traces, self._fields, self._parts, strict=True):
            if field.curved or not curved_only:
                field.add(forces.on(trace.field), trace.nodes, trace.weights[:, :, None] * values[:, None, part])

    def _groups(self) -> list[tuple[int, np.ndarray, list[int]]]:
        """Traces that have the same nodes of one field: its number, the nodes, and the numbers of the traces."""
        groups: list[tuple[int, np.ndarray, list[int]]] = []
        for number, trace in enumerate(self._traces):
            for field, nodes, members in groups:
                if field == trace.field and (nodes is trace.nodes or np.array_equal(nodes, trace.nodes)):
                    members.append(number)
                    break
            else:
                groups.append((trace.field, trace.nodes, [number]))
        return groups

    def pattern(self, layout: Layout) -> tuple[np.ndarray, np.ndarray]:
        own, self._same = np.unique(self._numbers(layout)[self._stiff], axis=0, return_inverse=True)
        self._same = self._same.ravel()
        rows, shape = own, (*own.shape, own.shape[1])
        if self._is_whole:  # each process has all points, and its own rows
            rows = np.where((own >= layout.start) & (own < layout.start + layout.size), own, -1)
        return np.broadcast_to(rows[:, :, None], shape).ravel(), np.broadcast_to(own[:, None, :], shape).ravel()

    def _numbers(self, layout: Layout) -> np.ndarray:
        """Numbers of the increments that points depend on, in the order of `_derivatives`, (points, increments)."""
        chosen = [self._fields[members[0]].seen(layout.free_numbers[field])[nodes]
                  for field, nodes, members in self._groups()]
        return np.concatenate([n.reshape(len(n), n.shape[1] * n.shape[2]) for n in chosen], axis=1)

    def extrapolate_stress(self) -> None:
        held = self._unknowns.changes
        if held is not None and isinstance(self._law, PointLaw):
            changes = [f.seen(held[t.field].x.array.reshape(-1, f.components))
                       for t, f in zip(self._traces, self._fields, strict=True)]
            self._held = self._law.extrapolated(self.values(), self._interpolated(changes))

    def tangent(self, held: Forces) -> Sequence[np.ndarray]:
        forces, stiffness = self._linearised(self.values())
        self._add(held, forces, curved_only=True)
        resisting = np.flatnonzero(stiffness.any(axis=(1, 2)))
        matrix = self._derivatives(np.arange(len(forces))[self._stiff][resisting])
        blocks = matrix.transpose(0, 2, 1) @ (stiffness[resisting] @ matrix)
        count, wanted = len(blocks), self._same.max(initial=-1) + 1
        sums = csr_matrix((np.ones(count), (self._same[resisting], np.arange(count))), shape=(wanted, count))
        return [(sums @ blocks.reshape(count, matrix.shape[2] ** 2)).ravel()]

    def _linearised(self, z: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Forces at all points, and stiffness at those that the tangent counts."""
        return self._law(z) if self._held is None else self._law.holding(self._held, z)

    def _derivatives(self, points: np.ndarray | slice = EVERY) -> np.ndarray:
        """Derivative of z by increments of the nodes, in the order of `pattern`, shape (points, m, increments)."""
        columns = []
        for _, nodes, members in self._groups():
            f, nodes = self._fields[members[0]], nodes[points]
            variations = f.variations()
            variations = variations[nodes if len(variations) > 1 else np.zeros_like(nodes)]
            rows = np.zeros((len(nodes), self._parts[-1].stop, nodes.shape[1] * f.width))
            for number in members:
                varied = self._traces[number].weights[points, :, None, None] * variations
                rows[:, self._parts[number]] = varied.transpose(0, 2, 1, 3).reshape(rows[:, self._parts[number]].shape)
            columns.append(rows)
        return np.concatenate(columns, axis=2)
