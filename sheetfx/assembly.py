"""From virtual work to PETSc: residual, tangent and load vector of a problem."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import basix.ufl
import numpy as np
import ufl
from dolfinx import fem
from dolfinx.cpp.la.petsc import get_local_vectors, scatter_local_vectors
from dolfinx.fem.petsc import create_vector_block
from dolfinx.mesh import Mesh
from petsc4py import PETSc
from ufl.algorithms.map_integrands import map_integrands

from . import compat
from .compat import JIT
from .timing import Stopwatch
from .unknowns import Unknowns


@dataclass(frozen=True)
class Internal:
    """Internal virtual work of one group of cells with one quadrature rule.

    Attributes
    ----------
    strains : UFL vector of generalised strains
    law : function from strains to stress resultants
    integral : measure
    degree : quadrature degree of the measure
    mesh, cells : what the measure covers
    """

    strains: object
    law: Callable
    integral: ufl.Measure
    degree: int
    mesh: Mesh
    cells: np.ndarray


class System:
    """Discrete equilibrium R(x, factor) = 0 in increments x since the last converged state.

    Parameters
    ----------
    unknowns : Unknowns
    factor : ufl variable around a fem.Constant, the load factor as it appears in `work`
    internal : terms of internal virtual work
    work : UFL form of all other virtual work (contact positive, loads negative), or None
    fixed : for each block the local dofs whose increment is zero
    symmetric : whether the tangent is symmetric (no friction, conservative loads)
    mixed_points : use the mixed integration point tangent (Magisano, Leonetti and Garcea 2017)
        instead of the plain derivative of the residual
    """

    def __init__(self, unknowns: Unknowns, factor, internal: Sequence[Internal], work=None, *,
                 fixed: Sequence[np.ndarray], symmetric: bool = True, mixed_points: bool = True,
                 clock: Stopwatch | None = None):
        self.unknowns, self.internal, self.symmetric = unknowns, list(internal), symmetric
        self.clock = clock or Stopwatch()
        self._factor = factor
        self._increments = [fem.Function(b.space) for b in unknowns.blocks]
        self._stresses = [_StressStore(t, unknowns, self._increments) for t in internal] if mixed_points else []
        with self.clock("compile"):
            self._compile(work)
        self._maps = [(b.space.dofmap.index_map, b.space.dofmap.index_map_bs) for b in unknowns.blocks]
        self._fix(fixed)
        self.matrix = compat.create_matrix(self._tangent)
        if symmetric:
            self.matrix.setOption(PETSc.Mat.Option.SYMMETRIC, True)
            self.matrix.setOption(PETSc.Mat.Option.SYMMETRY_ETERNAL, True)
        self.weights = self._inner_product_weights()

    @property
    def comm(self):
        return self.unknowns.blocks[0].space.mesh.comm

    @property
    def factor(self) -> float:
        return float(self._factor.ufl_operands[0].value)

    @factor.setter
    def factor(self, value: float) -> None:
        self._factor.ufl_operands[0].value = value

    @property
    def multipliers(self) -> int:
        """Number of Lagrange multipliers; each gives the tangent one negative pivot."""
        return sum(
            b.space.dofmap.index_map.size_global * b.space.dofmap.index_map_bs
            for b in self.unknowns.blocks if b.fields[0].multiplier
        )

    def _compile(self, work) -> None:
        vary, linearise = self.unknowns.vary, self.unknowns.linearise
        forces = sum(ufl.inner(t.law(t.strains), vary(t.strains)) * t.integral for t in self.internal)
        residual = forces + work if work is not None else forces
        if self._stresses:
            tangent = sum(
                ufl.inner(linearise(t.law(t.strains)), vary(t.strains)) * t.integral
                + ufl.inner(s.stress, linearise(vary(t.strains))) * t.integral
                for t, s in zip(self.internal, self._stresses, strict=True)
            )
            if work is not None:
                tangent += linearise(work)
        else:
            tangent = linearise(residual)
        load = -map_integrands(lambda e: ufl.diff(e, self._factor), ufl.algorithms.expand_derivatives(residual))
        self._residual = self._compiled(residual)
        self._tangent = self._compiled(tangent)
        self._load = self._compiled(load)
        if all(form is None for form in self._load):
            raise ValueError("no load of the scene depends on the load factor; add one to `loads`")

    def _compiled(self, form) -> list:
        return fem.form(self.unknowns.blocks_of(self.unknowns.at_rest(form)), jit_options=JIT)

    def _fix(self, fixed) -> None:
        self._conditions, rows = [], []
        offset = 0
        for block, (index_map, size), dofs in zip(self.unknowns.blocks, self._maps, fixed, strict=True):
            owned = index_map.size_local * size
            if block.space.mesh.comm.allreduce(len(dofs)):
                self._conditions.append(fem.dirichletbc(fem.Function(block.space), np.asarray(dofs, dtype=np.int32)))
            rows.append(offset + dofs[dofs < owned])
            offset += owned
        self._fixed = np.concatenate(rows).astype(np.int32)
        self.size = self.comm.allreduce(offset - len(self._fixed))

    def _inner_product_weights(self) -> PETSc.Vec:
        """Weights that make increments of translations and rotations commensurate.

        Each field counts with the mean square of its nodal increments over its scale.
        """
        weights = self.create_vector()
        local = []
        for block in self.unknowns.blocks:
            array = np.zeros(self._local_size(block))
            for f in block.fields:
                space = f.value.function_space
                array[f.dofs] = 1 / (f.scale**2 * space.dofmap.index_map.size_global)
            local.append(array)
        scatter_local_vectors(weights, local, self._maps)
        return weights

    @staticmethod
    def _local_size(block) -> int:
        index_map = block.space.dofmap.index_map
        return (index_map.size_local + index_map.num_ghosts) * block.space.dofmap.index_map_bs

    def create_vector(self) -> PETSc.Vec:
        return create_vector_block(self._residual)

    def configure(self, x: PETSc.Vec) -> None:
        """Put all fields to the last converged state followed by the increments x."""
        x.ghostUpdate(addv=PETSc.InsertMode.INSERT, mode=PETSc.ScatterMode.FORWARD)
        for block, array in zip(self.unknowns.blocks, get_local_vectors(x, self._maps), strict=True):
            for f in block.fields:
                f.advance(array)

    def retract(self, x: PETSc.Vec, step: PETSc.Vec) -> None:
        """Follow the increments x (changed in place) by a further step."""
        for v in (x, step):
            v.ghostUpdate(addv=PETSc.InsertMode.INSERT, mode=PETSc.ScatterMode.FORWARD)
        totals, further = get_local_vectors(x, self._maps), get_local_vectors(step, self._maps)
        for block, total, more in zip(self.unknowns.blocks, totals, further, strict=True):
            for f in block.fields:
                f.combine(total, more)
        scatter_local_vectors(x, totals, self._maps)
        x.ghostUpdate(addv=PETSc.InsertMode.INSERT, mode=PETSc.ScatterMode.FORWARD)

    def residual(self, out: PETSc.Vec) -> None:
        """Out-of-balance forces of the current configuration."""
        self._assemble(self._residual, out)
        self.reaction = self.comm.allreduce(float(self._support @ self._support)) ** 0.5

    def load(self, out: PETSc.Vec) -> None:
        """Derivative of the external forces with respect to the load factor."""
        self._assemble(self._load, out)

    def tangent(self) -> PETSc.Mat:
        with self.clock("assembly"):
            return compat.assemble_matrix(self.matrix, self._tangent, self._conditions)

    def _assemble(self, forms, out) -> None:
        with self.clock("assembly"):
            arrays = []
            for block, form in zip(self.unknowns.blocks, forms, strict=True):
                array = np.zeros(self._local_size(block))
                if form is not None:
                    fem.assemble_vector(array, form)
                arrays.append(array)
            scatter_local_vectors(out, arrays, self._maps)
            out.ghostUpdate(addv=PETSc.InsertMode.ADD, mode=PETSc.ScatterMode.REVERSE)
            self._support = out.array[self._fixed]
            out.array[self._fixed] = 0

    def extrapolate_stress(self, step: PETSc.Vec | None = None) -> None:
        """Stresses of the tangent: those of the current state plus their linear change by `step`."""
        if not self._stresses:
            return
        with self.clock("assembly"):
            if step is None:
                for function in self._increments:
                    function.x.array[:] = 0
            else:
                step.ghostUpdate(addv=PETSc.InsertMode.INSERT, mode=PETSc.ScatterMode.FORWARD)
                for function, array in zip(self._increments, get_local_vectors(step, self._maps), strict=True):
                    function.x.array[:] = array
            for store in self._stresses:
                store.update()

    def commit(self) -> None:
        """Accept the current configuration as converged; increments count from here."""
        for f in self.unknowns.fields:
            f.commit()

    def snapshot(self) -> dict[str, np.ndarray]:
        """Converged values of all fields on this process."""
        return {f.name: f.previous.x.array.copy() for f in self.unknowns.fields}

    def restore(self, snapshot: dict[str, np.ndarray]) -> None:
        """Return to a converged state that `snapshot` gave."""
        for f in self.unknowns.fields:
            f.previous.x.array[:] = snapshot[f.name]
            f.value.x.array[:] = f.previous.x.array


class _StressStore:
    """Stress at the integration points of one internal term, extrapolated along an increment."""

    def __init__(self, term: Internal, unknowns: Unknowns, increments):
        mesh = term.mesh
        shape = term.strains.ufl_shape
        element = basix.ufl.quadrature_element(mesh.basix_cell(), value_shape=shape, degree=term.degree)
        self.stress = fem.Function(fem.functionspace(mesh, element))
        self._cells = term.cells
        resultants = term.law(term.strains)
        change = unknowns.linearise_along(resultants, increments)
        points = element.custom_quadrature()[0]
        expression = unknowns.at_rest(resultants + change)
        self._expression = fem.Expression(expression, points, jit_options=JIT)
        self._dofs = self.stress.function_space.dofmap.list[self._cells]
        self._width = shape[0]

    def update(self) -> None:
        values = self._expression.eval(self.stress.function_space.mesh, self._cells)
        self.stress.x.array.reshape(-1, self._width)[self._dofs.ravel()] = values.reshape(-1, self._width)
