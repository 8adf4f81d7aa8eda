"""Virtual work of the values that fields have at points: springs, joints, constraints.

The values z = P x at the points are linear in nodal values x (rotations enter by their quaternions), so that forces
f(z) and stiffness df/dz at the points become P^T f and P^T df/dz P on nodal values, and by the nodal variations an
exact Hessian.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import ufl
from dolfinx import fem
from dolfinx.mesh import create_interval
from mpi4py import MPI
from scipy.sparse import csr_matrix

from ..jit import compiled_expression
from ..mesh.numbers import with_constants
from .contribution import Contribution, Forces
from .densities import WAY
from .layout import Layout
from .nodal_field import AdditiveField
from .unknowns import Unknowns

NOTHING = 1e-14  # values of shape functions that are rounding
EVERY = slice(None)


@dataclass(frozen=True)
class Trace:
    """Values of a field at points, by interpolation between nodes: rows of P.

    Attributes
    ----------
    field : number in `Unknowns.fields`
    nodes : shape (points, k), local numbers of nodes
    weights : shape (points, k)
    """

    field: int
    nodes: np.ndarray
    weights: np.ndarray

    @classmethod
    def at_nodes(cls, field: int, nodes: np.ndarray) -> Trace:
        """The nodal values themselves."""
        nodes = np.asarray(nodes, dtype=np.int64).reshape(-1, 1)
        return cls(field, nodes, np.ones(nodes.shape))

    @classmethod
    def in_cells(cls, field: int, space: fem.FunctionSpace, cells: np.ndarray, reference: np.ndarray) -> Trace:
        """Values at reference points of cells, one in each."""
        if not len(cells):
            return cls.at_nodes(field, cells)
        element = space.ufl_element().basix_element
        weights = element.tabulate(0, np.ascontiguousarray(reference))[0, :, :, 0]
        weights = np.where(np.abs(weights) > NOTHING, weights, 0.0)
        nodes = space.dofmap.list[cells].astype(np.int64)
        order = np.argsort(-np.abs(weights), axis=1, kind="stable")[:, : (weights != 0).sum(axis=1).max(initial=0)]
        return cls(field, np.take_along_axis(nodes, order, axis=1), np.take_along_axis(weights, order, axis=1))


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
        self._fields: list[AdditiveField] = [unknowns.fields[t.field] for t in traces]
        self._unknowns, self._held = unknowns, None
        self._stiff: np.ndarray | slice = EVERY
        self.smooth, self.conservative, self.stage = smooth, conservative, stage
        ends = np.cumsum([f.components for f in self._fields])
        self._parts = [slice(end - f.components, end) for end, f in zip(ends, self._fields, strict=True)]

    def values(self) -> np.ndarray:
        """z at all points of this process."""
        return self._interpolated([f.table for f in self._fields])

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
        return self._unknowns.blocks[0].index_map.comm.allreduce(self._law.energy(self.values()))

    def _add(self, forces: Forces, values: np.ndarray, curved_only: bool = False) -> None:
        for trace, field, part in zip(self._traces, self._fields, self._parts, strict=True):
            if field.curved or not curved_only:
                np.add.at(forces.on(trace.field), trace.nodes,
                          trace.weights[:, :, None] * values[:, None, part])

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
        shape = (*own.shape, own.shape[1])
        return np.broadcast_to(own[:, :, None], shape).ravel(), np.broadcast_to(own[:, None, :], shape).ravel()

    def _numbers(self, layout: Layout) -> np.ndarray:
        """Numbers of the increments that points depend on, in the order of `_derivatives`, (points, increments)."""
        chosen = [layout.free_numbers[field][nodes] for field, nodes, _ in self._groups()]
        return np.concatenate([n.reshape(len(n), n.shape[1] * n.shape[2]) for n in chosen], axis=1)

    def extrapolate_stress(self) -> None:
        held = self._unknowns.changes
        if held is not None and isinstance(self._law, PointLaw):
            changes = [held[t.field].x.array.reshape(-1, f.components)
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
        for field, nodes, members in self._groups():
            f, nodes = self._unknowns.fields[field], nodes[points]
            variations = np.broadcast_to(f.variations(), (len(f.table), f.components, f.width))[nodes]
            rows = np.zeros((len(nodes), self._parts[-1].stop, nodes.shape[1] * f.width))
            for number in members:
                varied = self._traces[number].weights[points, :, None, None] * variations
                rows[:, self._parts[number]] = varied.transpose(0, 2, 1, 3).reshape(rows[:, self._parts[number]].shape)
            columns.append(rows)
        return np.concatenate(columns, axis=2)


class PointLaw:
    """Forces at points from a strain measure and a law that are written in UFL.

    With strains e(z) and resultants s(e) the forces are f = s . de/dz. The points are the cells of a mesh of their own,
    on which z is constant in each cell, so that all are evaluated by one compiled kernel.

    Parameters
    ----------
    strains : function (values, data, factor) -> UFL vector; `values` and `data` are lists of UFL vectors
    law : function from strains to resultants, both UFL vectors
    sizes : numbers of components of the values
    data : arrays of shape (points, components) that strains may depend on
    factor : function that gives the load factor
    weights : of the points, by which forces are multiplied; None: 1
    """

    def __init__(self, strains: Callable, law: Callable, sizes: Sequence[int], data: Sequence[np.ndarray],
                 count: int, factor: Callable[[], float], weights: np.ndarray | None = None):
        self._factor, self._count, self._size = factor, count, sum(sizes)
        self._weights = np.ones(count) if weights is None else weights
        if not count:
            return
        mesh = self._mesh = create_interval(MPI.COMM_SELF, count, (0.0, 1.0))
        self._cells = np.arange(count, dtype=np.int32)
        self._constant = fem.Constant(mesh, 0.0)
        self._z = self._on_cells(self._size)
        constants = self._data = [self._on_cells(d.shape[1], d) for d in data]
        z = self._variable = ufl.variable(self._z)
        now = ufl.variable(self._constant)
        ends = np.cumsum(sizes)
        values = [ufl.as_vector([z[int(i)] for i in range(end - size, end)]) for end, size in zip(ends, sizes,
                                                                                                  strict=True)]
        e, (i, j, k) = strains(values, constants, now), ufl.indices(3)
        self._density = sum(weight * ufl.dot(law(share * e), e) for share, weight in WAY)
        resultants, slopes = law(e), ufl.diff(e, z)
        self._change, self._held = self._on_cells(self._size), self._on_cells(e.ufl_shape[0])
        force, held = (ufl.as_vector(s[i] * slopes[i, j], j) for s in (resultants, self._held))
        material = ufl.as_matrix(ufl.diff(resultants, z)[i, j] * slopes[i, k], (k, j))
        self._strains, self._measure, self._law = self._expression(e), e, law
        self._force, self._holding = self._expression(force), self._expression(held)
        self._stiffness = self._expression(material + ufl.diff(held, z))
        self._resultants = self._expression(resultants + ufl.dot(ufl.diff(resultants, z), self._change))
        self._pull = self._expression(-ufl.diff(force, now))

    def give(self, number: int, values: np.ndarray) -> None:
        """Change one of the arrays of data that strains depend on."""
        if self._count:
            self._put(self._data[number], values)

    def weigh(self, weights: np.ndarray) -> None:
        """Change the weights of the points."""
        self._weights = weights

    def strains(self, z: np.ndarray) -> np.ndarray:
        """Strains at z, shape (points, strains)."""
        return self._evaluate(self._strains, z, self._held.function_space.dofmap.bs) if self._count else z

    def resultants(self, z: np.ndarray) -> np.ndarray:
        """Resultants at z, shape (points, strains)."""
        return self.extrapolated(z, np.zeros_like(z))

    def _on_cells(self, size: int, values: np.ndarray | None = None) -> fem.Function:
        function = fem.Function(fem.functionspace(self._mesh, ("DG", 0, (size,))))
        if values is not None:
            self._put(function, values)
        return function

    def _put(self, function: fem.Function, values: np.ndarray) -> None:
        function.x.array.reshape(values.shape)[function.function_space.dofmap.list[:, 0]] = values

    def _expression(self, expression) -> fem.Expression | None:
        expression = ufl.algorithms.expand_derivatives(expression)
        if isinstance(expression, ufl.classes.Zero):
            return None
        if ufl.domain.extract_unique_domain(expression) is None:  # numbers alone, which DOLFINx does not compile
            expression = fem.Constant(self._mesh, 1.0) * expression
        return compiled_expression(expression, np.array([[0.5]]), with_constants)

    def _evaluate(self, expression: fem.Expression | None, z: np.ndarray, *shape: int,
                  points: np.ndarray | slice = EVERY) -> np.ndarray:
        if not self._count or expression is None:
            return np.zeros((len(np.arange(self._count)[points]), *shape))
        self._put(self._z, z)
        self._constant.value = self._factor()
        return expression.eval(self._mesh, self._cells[points]).reshape(-1, *shape)

    def _weighted(self, expression: fem.Expression | None, z: np.ndarray, *shape: int,
                  points: np.ndarray | slice = EVERY) -> np.ndarray:
        return self._evaluate(expression, z, *shape, points=points) * self._weights[points].reshape(
            -1, *(1,) * len(shape))

    def forces(self, z: np.ndarray) -> np.ndarray:
        """Forces alone."""
        return self._weighted(self._force if self._count else None, z, self._size)

    def __call__(self, z: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Forces and stiffness."""
        return self.forces(z), self.stiffness(z)

    def stiffness(self, z: np.ndarray, points: np.ndarray | slice = EVERY) -> np.ndarray:
        """Stiffness at some of the points."""
        if not self._count:
            return np.zeros((0, self._size, self._size))
        self._put(self._held, self.extrapolated(z, np.zeros_like(z)))
        return self._weighted(self._stiffness, z, self._size, self._size, points=points)

    def extrapolated(self, z: np.ndarray, change: np.ndarray) -> np.ndarray:
        """Resultants at z, and their linear change by a change of z."""
        if not self._count:
            return np.zeros((0, 0))
        self._put(self._change, change)
        return self._evaluate(self._resultants, z, self._held.function_space.dofmap.bs)

    def holding(self, resultants: np.ndarray, z: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Forces of given resultants, and stiffness in which these stand for those at z.

        The mixed integration point tangent (Magisano, Leonetti and Garcea 2017).
        """
        if not self._count:
            return np.zeros((0, self._size)), np.zeros((0, self._size, self._size))
        self._put(self._held, resultants)
        return self._weighted(self._holding, z, self._size), self._weighted(self._stiffness, z, self._size, self._size)

    @cached_property
    def _of_strains(self) -> list[fem.Expression | None]:
        """Derivatives of strains by z, then resultants and moduli as functions of strains that are given."""
        given = ufl.variable(self._held)
        resultants = self._law(given)
        return [self._expression(e) for e in (
            ufl.diff(self._measure, self._variable), resultants, ufl.diff(resultants, given))]

    def slopes(self, z: np.ndarray) -> np.ndarray:
        """Derivatives of the strains at z, shape (points, strains, m)."""
        return self._evaluate(self._of_strains[0], z, self._held.function_space.dofmap.bs, self._size)

    def at_strains(self, strains: np.ndarray, z: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Resultants and moduli of given strains, times the weights."""
        self._put(self._held, strains)
        size = strains.shape[1]
        return self._weighted(self._of_strains[1], z, size), self._weighted(self._of_strains[2], z, size, size)

    @cached_property
    def _energy(self) -> fem.Expression | None:
        return self._expression(ufl.as_vector([self._density]))

    def energy(self, z: np.ndarray) -> float:
        """Work of the resultants on the way to the strains at z, of all points of this process."""
        return float(self._weighted(self._energy, z, 1).sum()) if self._count else 0.0

    def load(self, z: np.ndarray) -> np.ndarray:
        """Derivative of the external forces by the load factor."""
        return self._weighted(self._pull if self._count else None, z, self._size)
