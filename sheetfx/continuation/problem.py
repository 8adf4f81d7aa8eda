"""What the path follower asks of a problem: the one list of it, which mypy holds scenes and plain forms to.

A structure (`discrete.discretisation.Discretisation`) and a plain form (`discrete.plain_form.PlainForm`) are problems.
Contact, friction and laws with history are asked of the contributions of a system, see `discrete.contribution`; a
smooth problem is asked for no more than what stands here.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import AbstractContextManager
from typing import Any, Protocol

import numpy as np
from petsc4py import PETSc

from ..discrete.functional import Functional
from ..discrete.layout import Layout
from ..discrete.timing import Stopwatch


class Equations(Protocol):
    """Equilibrium R(x, factor) = 0 in increments x since the last converged state.

    Attributes
    ----------
    comm : of all processes
    size : number of free unknowns
    matrix : the tangent
    weights : diagonal of the inner product of increments
    conservative : whether R is a gradient, so that the tangent is symmetric and its inertia counts unstable modes
    smooth : whether the tangent changes continuously
    multipliers : number of unknowns each of which gives the tangent one negative eigenvalue
    factor : the load factor of the present configuration
    reaction : norm of the forces on fixed unknowns, as of the last `residual`
    """

    size: int
    matrix: Any
    weights: PETSc.Vec
    conservative: bool
    smooth: bool
    multipliers: int
    reaction: float

    @property
    def comm(self) -> Any: ...

    @property
    def factor(self) -> float: ...

    def create_vector(self, values: np.ndarray | None = None) -> PETSc.Vec:
        """A vector of increments, zero or with this process's part given."""

    def configure(self, x: PETSc.Vec, factor: float) -> None:
        """Put the problem to the last converged state followed by the increments x, and to a load factor."""

    def retract(self, x: PETSc.Vec, step: PETSc.Vec) -> None:
        """Follow the increments x (changed in place) by a further step."""

    def residual(self, out: PETSc.Vec) -> None:
        """R of the present configuration, zero in fixed rows."""

    def load(self, out: PETSc.Vec) -> None:
        """Minus the derivative of R with respect to the load factor."""

    def tangent(self) -> PETSc.Mat:
        """Derivative of R with respect to increments of the present configuration."""

    def extrapolate_stress(self, step: PETSc.Vec | None = None) -> None:
        """Let the next tangent be that of a long step, where the problem has one; nothing otherwise."""

    def additive_increments(self) -> AbstractContextManager[None]:
        """Let increments add, where they turn something otherwise, so that the tangent is the Hessian of the energy."""

    def snapshot(self) -> dict[str, np.ndarray]:
        """All that the last converged state consists of on this process."""

    def restore(self, snapshot: dict[str, np.ndarray]) -> None:
        """Return to a state that `snapshot` gave."""

    def origins(self) -> dict[str, np.ndarray]:
        """What tells the rows of a snapshot's arrays on any number of processes."""


class Problem(Protocol):
    """Equations with what a path reports of them, and says where they cannot be solved.

    Attributes
    ----------
    system : the equations
    clock : of the time that parts of the work take
    layout : rows of the unknowns
    stages : of loads that are applied before those of the path; none: the load factor is that of the path throughout
    size : what default steps of the monitored value are a part of
    massless : why frequencies are not followed; "": they can be
    follower : loads that follow the structure, and for each whether its forces have a potential nevertheless
    unresponsive : what to say where the unknowns do not respond to the load factor
    """

    clock: Stopwatch
    layout: Layout
    unresponsive: str

    @property
    def system(self) -> Equations: ...

    @property
    def stages(self) -> Sequence[Any]: ...

    @property
    def size(self) -> float: ...

    @property
    def massless(self) -> str: ...

    @property
    def follower(self) -> Mapping[Any, bool]: ...

    def functional(self, monitor: Any = None) -> Functional:
        """What a control goes by; None: what the path is drawn against."""

    def nodal_changes(self, step: PETSc.Vec) -> list[np.ndarray]:
        """Changes of the nodal values by a step, one node in each row, for amplitudes of modes."""

    def total_load(self) -> float:
        """The load that states report."""

    def load_of_unit(self) -> float | None:
        """That of a load factor of 1; None: it is not proportional to the factor."""

    def visiting(self, snapshot: dict[str, np.ndarray]) -> AbstractContextManager[None]:
        """Be at a state, and afterwards where the problem was before."""

    def why_singular(self) -> str:
        """Why the tangent of the first state is singular; called on all processes."""

    def without_numbers(self, when: str) -> str:
        """What has no finite numbers now, and where; "": nothing."""

    def unstable_at_rest(self, count: int, modes: Sequence[np.ndarray]) -> str:
        """What to say of a first state with negative eigenvalues, of which some modes are given."""
