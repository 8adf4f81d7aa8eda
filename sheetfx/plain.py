"""Paths of a residual form in DOLFINx: `fx.continuation`."""

from __future__ import annotations

from collections.abc import Sequence
from math import isfinite

import numpy as np
import ufl
from dolfinx import fem
from mpi4py import MPI
from petsc4py import PETSc

from .checks import Positive, require
from .communicators import lasting
from .continuation.control import StepRule
from .continuation.inertia import first_passing
from .continuation.linear import DirectSolver, SingularTangent
from .discrete.plain_form import PlainForm
from .events.event import Event
from .events.until import Until
from .notices import warn
from .path import Path
from .rounding import NONE, last_digits

MOST = 25  # Newton iterations to the first state
UNSYMMETRIC = (
    "continuation: the tangent dF/du is not symmetric, so that F is no gradient: unstable modes are counted from 0 in "
    "the first state, by the real eigenvalues that pass zero; bifurcations have no name nor coefficients, and Hopf "
    "points are not looked for")


def continuation(F: ufl.Form, u: fem.Function, load_factor: fem.Constant | fem.Function,
                 bcs: Sequence[fem.DirichletBC] = (), *, control: StepRule | None = None, until: Until | None = None,
                 monitor: ufl.Form | None = None, scale: float = 1.0, load_scale: float | None = None,
                 events: Sequence[Event] = (), prefix: str = "sheetfx_") -> Path:
    """The path of solutions of F(u, load_factor; v) = 0 from the present values of u and load_factor on.

    The path is an iterator over states, and has limit points and bifurcations, as a scene's. While it is iterated
    over, `u` and `load_factor` have the values of the present state. Of states `load` is the load factor, and
    `deflection` the monitored value. `fx.trace(path)` goes to its end and gives a `Record`.

    Parameters
    ----------
    F : residual, a UFL form with one test function of the space of `u`. Where the tangent dF/du is symmetric, as of the
        gradient of an energy, bifurcations have names and coefficients, and all unstable modes are counted
    u : unknown, of any element; it begins near a solution, which Newton's method finds at the first load factor
    load_factor : Constant, or uniform scalar Function, that occurs in F; it grows at first
    bcs : Dirichlet conditions with values that do not depend on the load factor
    control, until, events, prefix : see `Path`; lengths are root mean squares of nodal values over `scale`
    monitor : UFL form of rank 0 in `u`, such as u * ds(1), that is reported; None: the L2 norm of `u`
    scale : value of `u` that counts as 1 in lengths
    load_scale : change of the load factor that counts as 1 in lengths too; None: none does, but where u does not
        respond to the load factor at first, the one by which its linear change makes the tangent singular (linear
        buckling)

    Raises
    ------
    ValueError
        If it is no such problem, or no solution lies near the first state.
    """
    require("continuation", scale=(scale, Positive), load_scale=(load_scale, Positive | None))
    _check_form(F, u)
    _check_factor(F, load_factor)
    _check_conditions(bcs, u, load_factor)
    if monitor is not None and not (isinstance(monitor, ufl.Form) and not monitor.arguments()
                                    and u in monitor.coefficients()):
        raise ValueError("continuation: monitor is no UFL form of rank 0 in u; give an integral, such as u * ds(1)")
    for condition in bcs:
        condition.set(u.x.array)
    problem = PlainForm(F, u, load_factor, bcs, monitor, scale, load_scale)
    trivial = _settle(problem)
    if trivial and load_scale is None:
        load_scale = _critical_factor(problem)
        problem = PlainForm(F, u, load_factor, bcs, monitor, scale, load_scale)
    if not problem.symmetric:
        warn(UNSYMMETRIC)
    return Path(problem, control, until, events=events, prefix=prefix)


def _check_form(form: ufl.Form, u: fem.Function) -> None:
    if not isinstance(u, fem.Function) or u.x.array.dtype != np.float64:
        raise ValueError(f"continuation: u is {u!r}; give a real Function of DOLFINx, the unknown")
    if not isinstance(form, ufl.Form):
        raise ValueError(f"continuation: F is {form!r}; give a UFL form, the residual")
    if (rank := len(form.arguments())) != 1:
        remedy = "give its derivative, ufl.derivative(F, u)" if rank == 0 else "give the residual, not its derivative"
        raise ValueError(f"continuation: F has {rank} arguments and must have one, the test function; {remedy}")
    if form.arguments()[0].ufl_function_space() != u.function_space:
        raise ValueError("continuation: the test function of F is of another space than u; make it by "
                         "ufl.TestFunction(u.function_space)")
    if u not in form.coefficients():
        raise ValueError(f"continuation: F has no u ({u.name}) in it; write it in the Function that is given as u")


def _check_factor(form: ufl.Form, factor: fem.Constant | fem.Function) -> None:
    if not isinstance(factor, (fem.Constant, fem.Function)) or factor.ufl_shape:
        raise ValueError(f"continuation: load_factor is {factor!r}; give a scalar Constant of DOLFINx")
    if factor not in [*form.constants(), *form.coefficients()]:
        raise ValueError("continuation: load_factor does not occur in F; write F with it, or give the one that does")
    if isinstance(factor, fem.Constant):
        lowest = highest = float(factor.value)
    else:
        comm, values = lasting(factor.function_space.mesh.comm), factor.x.array
        lowest = comm.allreduce(float(values.min(initial=np.inf)), op=MPI.MIN)
        highest = comm.allreduce(float(values.max(initial=-np.inf)), op=MPI.MAX)
    if lowest != highest or not isfinite(lowest):
        raise ValueError(f"continuation: load_factor has values from {lowest:g} to {highest:g}; give a Constant, or a "
                         "Function that is uniform and finite at first")


def _check_conditions(bcs: Sequence[fem.DirichletBC], u: fem.Function, factor: fem.Constant | fem.Function) -> None:
    for number, condition in enumerate(bcs):
        if not isinstance(condition, fem.DirichletBC):
            raise ValueError(f"continuation: bcs[{number}] is {condition!r}; give what fem.dirichletbc returns")
        space = getattr(condition.function_space, "_cpp_object", condition.function_space)
        if not u.function_space._cpp_object.contains(space):
            raise ValueError(f"continuation: bcs[{number}] is of another space than u; make it with the space of u, "
                             "or a sub-space of it")
        if condition.g is factor._cpp_object:
            raise ValueError(f"continuation: the value of bcs[{number}] is the load factor, and must be fixed: write "
                             "u + load_factor * g for u in F, with a g of that value, or impose it weakly")


def _settle(problem: PlainForm) -> bool:
    """Solve F = 0 at the first load factor by Newton's method; return whether u does not respond to the factor there.

    Once a correction is small Newton's method makes the next one its square.
    """
    system = problem.system
    x, step, residual = (system.create_vector() for _ in range(3))
    solver = DirectSolver(PETSc.KSP().create(system.comm), system.matrix, problem.symmetric)
    for _ in range(MOST):
        system.configure(x, system.factor)
        system.residual(residual)
        system.tangent()
        try:
            solver.factorise()
        except SingularTangent:
            raise ValueError(problem.why_singular()) from None
        solver.solve(residual, step)
        step.scale(-1.0)
        system.retract(x, step)
        corrected = (system.weights * step).dot(step) ** 0.5
        if corrected <= NONE ** 0.5:
            break
    else:
        raise ValueError(problem.without_numbers("in the first state") or (
            f"continuation: Newton's method finds no solution of F = 0 near the u given, at the load factor "
            f"{system.factor:g}: after {MOST} iterations it corrects u by {corrected:.2g} of scale, and the "
            f"residual is {residual.norm():.2g}; give a u nearer to a solution, or begin at another load factor"))
    system.configure(x, system.factor)
    system.history.rebase()
    system.load(residual)
    return residual.norm(PETSc.NormType.INFINITY) <= last_digits(system, problem.field.scale)


def _critical_factor(problem: PlainForm) -> float:
    """Change of the load factor, at the u of the first state, that makes the tangent singular by its linear change."""
    system = problem.system
    system.tangent()
    solver = DirectSolver(PETSc.KSP().create(system.comm), system.matrix, problem.symmetric)
    solver.factorise()
    found = first_passing(solver, problem.tangent_rate())
    if not isfinite(found):
        raise ValueError(problem.unresponsive)
    return found
