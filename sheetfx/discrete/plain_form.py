"""A problem that is a residual form in DOLFINx, without a scene: its unknowns, its load factor and its monitored value.

Where the load factor leaves the solution as it is (a trivial branch, such as a straight column), steps must be measured
in it: the factor over its scale then stands beside the unknowns as one more of them, so that lengths are those of
Keller (1977, eq. 2.8). Its own equation is linear and touches no other.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import isfinite, sqrt
from typing import TYPE_CHECKING, Any

import numpy as np
import ufl
from dolfinx import fem
from mpi4py import MPI
from petsc4py import PETSc

from ..jit import compiled_form
from ..rounding import SAME, UNIT
from .contribution import Contribution, Forces
from .form_work import FormWork, slope
from .functional import Functional
from .layout import Layout
from .load_factors import LoadFactors
from .nodal import FixedIncrements
from .nodal_field import AdditiveField
from .number import NumberField, shared_by_all
from .potential import MOVED, SYMMETRIC, asymmetry, moved
from .system import System
from .timing import Stopwatch
from .unknowns import Block, Unknowns
from .visiting import Visiting

BESIDE = sqrt(UNIT)  # unit of the load's coordinate: with the largest stiffness its force is still the least


class GivenFactor(LoadFactors):
    """The user's load factor: a Constant, or a Function that is uniform."""

    def __init__(self, given: fem.Constant | fem.Function):
        self._given, self.stage = given, 0
        constant = isinstance(given, fem.Constant)
        domain = given.ufl_domain() if constant else given.function_space.mesh
        self._constants = [given if constant else fem.Constant(domain, float(given.x.array[0]))]
        self.symbols = [ufl.variable(self._constants[0])]

    def set(self, factor: float) -> None:
        super().set(factor)
        if isinstance(self._given, fem.Function):
            self._given.x.array[:] = factor


class LoadCoordinate(Contribution):
    """The load factor as an unknown s of its own, by k (s - factor / unit) = 0.

    Parameters
    ----------
    field : of the number s, and its number among the fields
    factors : of the problem
    unit : load factor for which s is 1
    """

    def __init__(self, field: NumberField, number: int, factors: LoadFactors, unit: float):
        self._field, self._number, self._factors = field, number, factors
        self.unit, self.stiffness, self.stage = unit, 1.0, 0

    @property
    def _owned(self) -> int:
        return self._field.index_map.size_local

    def start(self, stiffness: float) -> None:
        """Put the coordinate to the present load factor, and k to a value."""
        self.stiffness = stiffness
        self._field.start(self._factors.now / self.unit)

    def residual(self, forces: Forces) -> None:
        table = forces.on(self._number)
        table[: self._owned] += self.stiffness * (self._field.table[: self._owned] - self._factors.now / self.unit)

    def load(self, forces: Forces) -> None:
        forces.on(self._number)[: self._owned] += self.stiffness / self.unit

    def pattern(self, layout: Layout) -> tuple[np.ndarray, np.ndarray]:
        own = layout.free_numbers[self._number].ravel()[: self._owned]
        return own, own

    def tangent(self, held: Forces) -> Sequence[np.ndarray]:
        return [np.full(self._owned, self.stiffness)]


class FormValue(Functional):
    """The value of a form without arguments, or its root.

    Parameters
    ----------
    home : the problem
    form : UFL form in its function
    root : whether the root is meant, as of a norm
    """

    def __init__(self, home: PlainForm, form: ufl.Form, root: bool = False):
        u = home.u
        self._home, self._root, self._at = home, root, fem.Function(u.function_space)
        gradient = ufl.derivative(form, u, ufl.TestFunction(u.function_space))
        self._value, self._gradient = (compiled_form(ufl.replace(f, {u: self._at})) for f in (form, gradient))
        super().__init__(home.system.create_vector())

    def at(self, values: np.ndarray) -> float:
        """The value for nodal values of the function on this process."""
        self._at.x.array[:] = values
        found = self._home.system.comm.allreduce(float(fem.assemble_scalar(self._value)))
        return sqrt(max(found, 0.0)) if self._root else found

    @property
    def initial(self) -> float:
        return self.at(self._home.u.x.array)

    def rate(self, increment: PETSc.Vec) -> float:
        """Change by a small increment from the present values; none of a root that is zero."""
        value = self.at(self._home.u.x.array)
        if self._root and not value:
            return 0.0
        arrays, layout = self._home.layout.zeros(), self._home.layout
        fem.assemble_vector(arrays[0], self._gradient)
        layout.gather(arrays, self.vector)
        self.vector.array[layout.fixed] = 0
        return self.vector.dot(increment) / (2 * value if self._root else 1.0)

    def of(self, increment: PETSc.Vec) -> float:
        before = self._home.field.previous.x.array
        return self.at(before + self._home.layout.arrays(increment)[0]) - self.at(before)


class PlainForm(Visiting):
    """F(u, load factor; v) = 0 as a problem, see `continuation.problem.Problem`.

    Parameters
    ----------
    form : UFL form of rank 1, linear in the test function of the space of `u`
    u : Function with a solution for the present load factor
    load_factor : Constant, or uniform Function, that occurs in the form
    bcs : Dirichlet conditions, which `u` satisfies
    monitor : UFL form of rank 0 in `u`; None: the L2 norm of `u`
    scale : value of `u` that counts as 1 in lengths of steps
    load_scale : load factor that counts as 1 in them; None: none does

    Attributes
    ----------
    field : `u` as an unknown field
    symmetric : whether the tangent is, so that F is the gradient of an energy
    """

    stages: Sequence[Any] = ()
    size = 1.0
    massless = "a plain form has no mass"
    follower: Mapping[Any, bool] = {}
    unresponsive = "continuation: u does not respond to load_factor; give load_scale, a change of it that matters"

    def __init__(self, form: ufl.Form, u: fem.Function, load_factor: fem.Constant | fem.Function,
                 bcs: Sequence[fem.DirichletBC], monitor: ufl.Form | None, scale: float, load_scale: float | None):
        self.u, self.load_factor, self.clock = u, load_factor, Stopwatch()
        self.factors = GivenFactor(load_factor)
        present = self.factors.now
        space = u.function_space
        self.field = AdditiveField(u, np.arange(len(u.x.array)), scale)
        self.field.rebase()
        blocks = [Block.of_space(space, self.field)]
        coordinate = NumberField("load coordinate", shared_by_all(space.mesh.comm), 1 / BESIDE)
        if load_scale is not None:
            blocks.append(Block.of_numbers(coordinate))
        unknowns = self.unknowns = Unknowns(blocks)
        (test,) = ufl.TestFunctions(ufl.MixedFunctionSpace(space))
        form = ufl.algorithms.expand_derivatives(form)
        form = ufl.replace(form, {form.arguments()[0]: test, load_factor: self.factors.symbols[0]})
        fixed = np.unique(np.concatenate([np.empty(0, dtype=np.int32), *(bc.dof_indices()[0] for bc in bcs)]))
        self.layout = Layout(space.mesh.comm, blocks, [fixed, *(fixed[:0] for _ in blocks[1:])])
        self._form = form
        with self.clock("compile"):
            work = FormWork(unknowns, form, factor=self.factors.symbols[0], stage=0)
        self.symmetric = work.conservative = self._is_symmetric(work)
        held = FixedIncrements()
        own = LoadCoordinate(coordinate, 1, self.factors, BESIDE * load_scale) if load_scale is not None else None
        self.system = System(unknowns, [work, held, *([own] if own else [])], self.layout, self.factors, self.clock)
        self.factors.set(present)
        held.stiffness, largest = self._stiffest()
        if own:
            own.start(largest * BESIDE**2)
        l2 = ufl.inner(u, u) * ufl.dx
        self._monitor = FormValue(self, l2, root=True) if monitor is None else FormValue(self, monitor)

    def _is_symmetric(self, work: FormWork) -> bool:
        """Whether the tangent is, and its change by the load factor, however small beside it.

        Random nodal values are steep on fine meshes: where the form has no numbers there, nearer ones are looked at.
        """
        system, share = System(self.unknowns, [work], self.layout, self.factors, self.clock), MOVED
        rest = moved(system, self.layout, share, 0.0).copy()
        while not isfinite(asymmetry(rest)) and share > UNIT:
            share *= MOVED
            rest = moved(system, self.layout, share, 0.0).copy()
        size, factor, change = rest.norm(), 1.0, rest
        for _ in range(2):  # where the change is as large as the rest, if the form has numbers there
            further = moved(system, self.layout, share, factor).copy()
            further.axpy(-1.0, rest, PETSc.Mat.Structure.SAME_NONZERO_PATTERN)
            if not isfinite(further.norm()):
                break
            change, factor = further, size / (further.norm() or size or 1.0)
        system.configure(system.create_vector(), 0.0)
        return (asymmetry(rest) <= SYMMETRIC * size
                and asymmetry(change) <= SYMMETRIC * change.norm() + SAME * size)

    def _stiffest(self) -> tuple[float, float]:
        """Largest entry of the tangent's diagonal in free rows of the form, and largest over its weight."""
        rows = self.u.function_space.dofmap.index_map.size_local * self.field.components
        free = np.setdiff1d(np.arange(rows), self.system.fixed_rows)
        diagonal, weights = (np.abs(v.array[free]) for v in (self.system.tangent().getDiagonal(), self.system.weights))
        entry, over = (self.system.comm.allreduce(float(v.max(initial=0.0)), op=MPI.MAX)
                       for v in (diagonal, diagonal / weights))
        return entry or 1.0, over or 1.0

    if not TYPE_CHECKING:
        def __getattr__(self, name: str):
            raise AttributeError(f"a plain form has no {name}: only a scene has parts, supports and meshes with names, "
                                 "which forces, stresses, frequencies, balance and pictures of shapes are asked of")

    def functional(self, monitor: Any = None) -> Functional:
        if monitor is not None:
            raise ValueError(f"DisplacementControl: monitor is {monitor!r}; a plain form is controlled by the value "
                             "that it monitors: leave `monitor` of the control out and give it to fx.continuation")
        return self._monitor

    def tangent_rate(self) -> PETSc.Mat:
        """Derivative of the tangent by the load factor, at the present u."""
        return self.system.bilinear(slope(self.unknowns.linearise(self._form), self.factors.symbols[0]))()

    def nodal_changes(self, step: PETSc.Vec) -> list[np.ndarray]:
        return [self.system.changes(step)[0].reshape(-1, self.field.components)]

    def total_load(self) -> float:
        return self.factors.now

    def load_of_unit(self) -> float:
        return 1.0

    def unbalanced(self, load: PETSc.Vec) -> str:
        return ""

    def why_singular(self) -> str:
        return self.without_numbers("in the first state") or (
            f"continuation: the tangent dF/du is singular at the first load factor, {self.factors.now:g}: F and bcs "
            "leave u open there; begin at another load factor, or give Dirichlet conditions")

    def without_numbers(self, when: str) -> str:
        residual = self.system.create_vector()
        self.system.residual(residual)
        sizes = (("F", residual.norm()), ("the tangent dF/du", self.system.tangent().norm()))
        wrong = [name for name, size in sizes if not np.isfinite(size)]
        return f"continuation: {wrong[0]} is not a finite number {when}" if wrong else ""

    def unstable_at_rest(self, count: int, modes: Sequence[np.ndarray]) -> str:
        return (f"continuation: the tangent dF/du has {count} negative eigenvalue{'s' * (count > 1)} in the first "
                "state, which unstable_modes count too; where F is minus the gradient of an energy, give -F")
