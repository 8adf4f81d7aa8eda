"""From virtual work to PETSc: residual, tangent and load vector of a problem."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from itertools import repeat

import numpy as np
import ufl
from dolfinx import fem
from mpi4py import MPI
from petsc4py import PETSc
from ufl.algorithms.map_integrands import map_integrands

from .. import compat
from ..compat import JIT
from ..model.work import Internal
from .elements import ElementWork
from .layout import Layout
from .timing import Stopwatch
from .unknowns import Unknowns


class System:
    """Discrete equilibrium R(x, factor) = 0 in increments x since the last converged state.

    Parameters
    ----------
    unknowns : Unknowns
    factor : ufl variable around a fem.Constant, the load factor as it appears in `work`
    internal : terms of internal virtual work
    work : UFL form of all other virtual work (contact positive, loads negative), or None
    nodal : for each block forces on its dofs for a load factor of 1
    fixed : for each block the local dofs whose increment is zero
    symmetric : whether the tangent is symmetric (no friction, conservative loads)
    mixed_points : use the mixed integration point tangent (Magisano, Leonetti and Garcea 2017)
        instead of the plain derivative of the residual

    Attributes
    ----------
    size : number of free unknowns
    fixed_places : places of fixed unknowns in this process's part of a vector
    multiplier_places : places of free Lagrange multipliers in this process's part of a vector
    multipliers : number of Lagrange multipliers; each gives the tangent one negative pivot
    """

    def __init__(self, unknowns: Unknowns, factor, internal: Sequence[Internal], work, *,
                 nodal: Sequence[np.ndarray], fixed: Sequence[np.ndarray], symmetric: bool = True,
                 mixed_points: bool = True, clock: Stopwatch | None = None):
        self.unknowns, self.symmetric = unknowns, symmetric
        self.clock = clock or Stopwatch()
        self._factor, self._nodal = factor, nodal
        self._layout = Layout(unknowns.blocks)
        self._changes = [fem.Function(f.value.function_space) for f in unknowns.fields] if mixed_points else None
        with self.clock("compile"):
            self.internal = [ElementWork(t, unknowns.fields, self._changes) for t in internal]
            self._compile(work)
        self.fixed_places = self._layout.rows(fixed)
        self.size = self.comm.allreduce(self._layout.size - len(self.fixed_places))
        self.multiplier_places = self._multipliers()
        self.multipliers = self.comm.allreduce(len(self.multiplier_places))
        self._create_matrix()
        self.weights = self._inner_product_weights()

    @property
    def comm(self):
        return self._layout.comm

    @property
    def factor(self) -> float:
        return float(self._factor.ufl_operands[0].value)

    @factor.setter
    def factor(self, value: float) -> None:
        self._factor.ufl_operands[0].value = value

    def _compile(self, work) -> None:
        self._residual = self._load = self._tangent = None
        loaded = self.comm.allreduce(any(f.any() for f in self._nodal), op=MPI.LOR)
        if work is not None:
            self._compile_work(work)
        if self._load is None and not loaded:
            raise ValueError("no load of the scene depends on the load factor; add one to `loads`")

    def _compile_work(self, work) -> None:
        load = -map_integrands(lambda e: ufl.diff(e, self._factor), ufl.algorithms.expand_derivatives(work))
        self._residual = self._compiled(work)
        tangent = self._compiled(self.unknowns.linearise(work))
        self._tangent = tangent and self._square(tangent)
        self._load = self._compiled(load)

    def _compiled(self, form) -> list:
        form = self.unknowns.at_rest(form)
        return None if form.empty() else fem.form(self.unknowns.blocks_of(form), jit_options=JIT)

    def _square(self, forms: list) -> list:
        """Put empty forms on the diagonal, which DOLFINx needs for the spaces and for fixed unknowns."""
        for n, block in enumerate(self.unknowns.blocks):
            if forms[n][n] is None:
                zero = fem.Constant(block.space.mesh, 0.0)
                u, v = ufl.TrialFunction(block.space), ufl.TestFunction(block.space)
                forms[n][n] = fem.form(zero * ufl.inner(u, v) * ufl.dx, jit_options=JIT)
        return forms

    def _multipliers(self) -> np.ndarray:
        """Places of free Lagrange multipliers in this process's part of a vector."""
        marks, vector = self._layout.zeros(), self.create_vector()
        for f, array in self._layout.fields(marks):
            array[f.dofs] = f.multiplier
        self._layout.put(marks, vector)
        vector.array[self.fixed_places] = 0
        return np.flatnonzero(vector.array > 0.5)

    def _create_matrix(self) -> None:
        """A matrix for the entries of internal work, of other work and of fixed unknowns, in this order."""
        places, rows, columns = self._layout.places, [], []
        for work in self.internal:
            for coupling in work.couplings:
                shape = coupling.values.shape
                left = np.broadcast_to(places[coupling.rows][coupling.nodes[:, 0], :, None], shape)
                right = np.broadcast_to(places[coupling.columns][coupling.nodes[:, 1], None, :], shape)
                rows += [left.ravel(), right[coupling.mirrored].ravel()]
                columns += [right.ravel(), left[coupling.mirrored].ravel()]
            for number in work.places:
                if self.unknowns.fields[number].curved:
                    shape = (*places[number].shape, self.unknowns.fields[number].width)
                    rows.append(np.broadcast_to(places[number][:, :, None], shape).ravel())
                    columns.append(np.broadcast_to(places[number][:, None, :], shape).ravel())
        self._other = self._turned = None
        self._turn = self._layout.turning_matrix()
        if self._tangent is not None:
            self._other = compat.create_matrix(self._tangent)
            pointer, column, _ = self._other_tangent()
            first = self._other.getOwnershipRange()[0]
            rows.append(first + np.repeat(np.arange(len(pointer) - 1), np.diff(pointer)))
            columns.append(column)
        rows, columns = np.concatenate(rows), np.concatenate(columns)
        fixed = self.fixed_places + self._layout.start
        all_fixed = np.concatenate(self.comm.allgather(fixed))
        lost = np.isin(rows, all_fixed) | np.isin(columns, all_fixed)
        rows[lost], columns[lost] = -1, -1
        rows, columns = np.concatenate((rows, fixed)), np.concatenate((columns, fixed))
        self.matrix = compat.create_coo_matrix(self.comm, self._layout.size, rows, columns)
        if self.symmetric:
            self.matrix.setOption(PETSc.Mat.Option.SYMMETRIC, True)
            self.matrix.setOption(PETSc.Mat.Option.SYMMETRY_ETERNAL, True)

    def _other_tangent(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Row pointers, columns and values of the tangent of work other than internal."""
        matrix = compat.assemble_matrix(self._other, self._tangent)
        if self._turn is not None:
            matrix = self._turned = matrix.ptap(self._turn, result=self._turned)
        return matrix.getValuesCSR()

    def _inner_product_weights(self) -> PETSc.Vec:
        """Weights that make increments of translations and rotations commensurate.

        Each field counts with the mean square of its nodal increments over its scale; fixed increments do not.
        """
        weights, arrays = self.create_vector(), self._layout.zeros()
        for f, array in self._layout.fields(arrays):
            array[f.dofs] = 1 / (f.scale**2 * f.value.function_space.dofmap.index_map.size_global)
        self._layout.put(arrays, weights)
        weights.array[self.fixed_places] = 0
        return weights

    def create_vector(self, values: np.ndarray | None = None) -> PETSc.Vec:
        """A vector of increments, zero or with this process's part given."""
        return self._layout.create_vector(values)

    def configure(self, x: PETSc.Vec) -> None:
        """Put all fields to the last converged state followed by the increments x."""
        for f, array in self._layout.fields(self._layout.arrays(x)):
            f.advance(array)

    def retract(self, x: PETSc.Vec, step: PETSc.Vec) -> None:
        """Follow the increments x (changed in place) by a further step."""
        totals = self._layout.arrays(x)
        for f, total, further in self._layout.fields(totals, self._layout.arrays(step)):
            f.combine(total, further)
        self._layout.put(totals, x)
        x.ghostUpdate(addv=PETSc.InsertMode.INSERT, mode=PETSc.ScatterMode.FORWARD)

    def residual(self, out: PETSc.Vec) -> None:
        """Out-of-balance forces of the current configuration."""
        self._assemble(self._residual, out, -self.factor, self._internal_forces)
        self.reaction = self.comm.allreduce(float(self._support @ self._support)) ** 0.5

    def bilinear(self, form) -> PETSc.Mat:
        """Matrix of a form in `unknowns.vary` and `unknowns.linearise` on the rows of the tangent; fixed ones empty."""
        forms = self._square(self._compiled(form))
        matrix = compat.assemble_matrix(compat.create_matrix(forms), forms)
        if self._turn is not None:
            matrix = matrix.ptap(self._turn)
        matrix.zeroRowsColumns(self.fixed_places + self._layout.start, 0.0)
        return matrix

    def load(self, out: PETSc.Vec) -> None:
        """Derivative of the external forces with respect to the load factor."""
        self._assemble(self._load, out, 1.0)

    def tangent(self) -> PETSc.Mat:
        """Derivative of the residual with respect to increments of the current configuration."""
        with self.clock("assembly"):
            values = []
            moments = self._moments()
            for work in self.internal:
                work.tangent()
                for coupling in work.couplings:
                    values += [coupling.values.ravel(), coupling.values[coupling.mirrored].ravel()]
                for number, held in zip(work.places, work.held, strict=True):
                    field = self.unknowns.fields[number]
                    if field.curved:
                        values.append((field.curvature(held, self.symmetric) + moments.pop(number, 0.0)).ravel())
            if self._other is not None:
                values.append(self._other_tangent()[2])
            values.append(np.ones(len(self.fixed_places)))
            compat.set_coo_values(self.matrix, np.concatenate(values))
            return self.matrix

    def _assemble(self, forms, out, nodal: float, further=lambda arrays: None) -> None:
        """Sum of forms, nodal loads times a factor, and what `further` adds; zero where increments are fixed."""
        with self.clock("assembly"):
            arrays = self._along_space(forms, nodal)
            self._turn_inward(arrays)
            further(arrays)
            self._layout.put(arrays, out)
            out.ghostUpdate(addv=PETSc.InsertMode.ADD, mode=PETSc.ScatterMode.REVERSE)
            self._support = out.array[self.fixed_places]
            out.array[self.fixed_places] = 0

    def _along_space(self, forms, nodal: float) -> list[np.ndarray]:
        """Forms and nodal loads times a factor on the blocks: forces along space, moments conjugate to the spin."""
        arrays = [nodal * load for load in self._nodal]
        for array, form in zip(arrays, forms or [], strict=False):
            if form is not None:
                fem.assemble_vector(array, form)
        return arrays

    def _moments(self) -> dict[int, np.ndarray]:
        """For each field of rotations the change of moments with its increments, in unsymmetric problems."""
        if self.symmetric:
            return {}
        arrays = self._along_space(self._residual, -self.factor)
        return {number: f.moment_slopes(array[f.dofs].reshape(-1, f.width))
                for number, (f, array) in enumerate(self._layout.fields(arrays)) if f.curved}

    def _turn_inward(self, arrays) -> None:
        """Take nodal vectors of the blocks to forces on increments along the axes of their nodes."""
        for f, array in self._layout.fields(arrays):
            if f.curved:
                array[f.dofs] = f.pull_moments(array[f.dofs].reshape(-1, f.width)).ravel()
            if f.axes is not None:
                array[f.dofs] = f.inward(array[f.dofs])

    def functional(self, block, dofs: np.ndarray, value: float) -> PETSc.Vec:
        """Vector whose product with increments is `value` times the sum of some owned dofs, along space."""
        arrays, vector = self._layout.zeros(), self.create_vector()
        arrays[self.unknowns.blocks.index(block)][dofs] = value
        self._turn_inward(arrays)
        self._layout.put(arrays, vector)
        return vector

    def _internal_forces(self, arrays) -> None:
        """Add internal forces to the local arrays of the blocks."""
        forces = [np.zeros((len(f.value.x.array) // f.value.function_space.dofmap.bs,
                            f.value.function_space.dofmap.bs)) for f in self.unknowns.fields]
        for work in self.internal:
            work.residual(forces)
        touched = {number for work in self.internal for number in work.places}
        for number, (f, array) in enumerate(self._layout.fields(arrays)):
            if number in touched:
                force = forces[number]
                basis = np.broadcast_to(f.variations(), (*force.shape, f.width))
                array[f.dofs] += np.einsum("na,nai->ni", force, basis).ravel()

    @contextmanager
    def additive_increments(self) -> Iterator[None]:
        """Let increments since the last converged state add at all nodes, those of rotations too.

        Residual and tangent are then gradient and Hessian of the energy as a function of them, wherever they are.
        """
        turning = [f for f in self.unknowns.fields if f.curved]
        kept = [f.charted for f in turning]
        for f in turning:
            f.charted = np.ones_like(f.charted)
        try:
            yield
        finally:
            for f, charted in zip(turning, kept, strict=True):
                f.charted = charted

    def extrapolate_stress(self, step: PETSc.Vec | None = None) -> None:
        """Stresses of the tangent: those of the current state plus their linear change by `step`."""
        if self._changes is None:
            return
        with self.clock("assembly"):
            for change, values in zip(self._changes, repeat(0.0) if step is None else self.changes(step), strict=False):
                change.x.array[:] = values
            for work in self.internal:
                work.extrapolate_stress()

    def changes(self, step: PETSc.Vec) -> list[np.ndarray]:
        """First-order change of the values of each field by a further step."""
        return [f.change(array) for f, array in self._layout.fields(self._layout.arrays(step))]

    def commit(self) -> None:
        """Accept the current configuration as converged; increments count from here."""
        for f in self.unknowns.fields:
            f.commit()

    def snapshot(self) -> dict[str, np.ndarray]:
        """Converged values of all fields on this process."""
        return {self._key(n, f): f.previous.x.array.copy() for n, f in enumerate(self.unknowns.fields)}

    def restore(self, snapshot: dict[str, np.ndarray]) -> None:
        """Return to a converged state that `snapshot` gave."""
        for n, f in enumerate(self.unknowns.fields):
            f.previous.x.array[:] = snapshot[self._key(n, f)]
            f.value.x.array[:] = f.previous.x.array

    @staticmethod
    def _key(number: int, field) -> str:
        """Name of a field in a snapshot; fields of several models have the same name but for the number."""
        return f"{field.name} {number}"
