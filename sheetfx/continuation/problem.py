"""What the path follower asks of a problem: the one list of it, which mypy holds scenes and plain forms to.

A structure (`discrete.discretisation.Discretisation`) and a plain form (`discrete.plain_form.PlainForm`) are problems.
Their equations are a `discrete.system.System`, a sum of contributions: what acts, touches or remembers is asked of
these, see `discrete.contribution`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import AbstractContextManager
from typing import Any, Protocol

import numpy as np
from petsc4py import PETSc

from ..discrete.functional import Functional
from ..discrete.layout import Layout
from ..discrete.system import System
from ..discrete.timing import Stopwatch


class Problem(Protocol):
    """Equations with what a path reports of them, and says where they cannot be solved.

    Attributes
    ----------
    system : the equations
    clock : of the time that parts of the work take
    layout : rows of the unknowns
    stages : of loads that are applied before the path's; none: the load factor is the path's throughout
    size : what default steps of the monitored value are a part of
    massless : why frequencies are not followed; "": they can be
    follower : loads that follow the structure, and for each whether its forces have a potential nevertheless
    unresponsive : what to say where the unknowns do not respond to the load factor
    """

    clock: Stopwatch
    layout: Layout
    unresponsive: str

    @property
    def system(self) -> System: ...

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
        """The load at a load factor of 1; None: it is not proportional to the factor."""

    def visiting(self, snapshot: dict[str, np.ndarray]) -> AbstractContextManager[None]:
        """Be at a state, and afterwards where the problem was before."""

    def unbalanced(self, load: PETSc.Vec) -> str:
        """Fault of a load vector that nothing takes, as of a body without supports; "": none."""

    def why_singular(self) -> str:
        """Why the tangent of the first state is singular; called on all processes."""

    def without_numbers(self, when: str) -> str:
        """What has no finite numbers now, and where; "": nothing."""

    def unstable_at_rest(self, count: int, modes: Sequence[np.ndarray]) -> str:
        """What to say of a first state with negative eigenvalues, of which some modes are given."""
