"""Lengths and angles of increments in the measure of a control, and the displacement that is monitored."""

from __future__ import annotations

from math import acos

import numpy as np
from mpi4py import MPI
from petsc4py import PETSc

from .. import rounding
from ..discrete.functional import Functional
from ..discrete.system import System
from .control import StepRule
from .problem import Problem
from .state import State


class Measuring:
    """What can measure increments of the load factor and of the unknowns (this process's part).

    Attributes
    ----------
    discretisation, system : the system's weights make the unknowns commensurate
    control : of the path
    """

    discretisation: Problem
    system: System
    control: StepRule
    _monitor: Functional

    def _load_weight(self) -> float:
        """Weight of the load's square in the square of a length."""
        return 0.0

    def _controlled(self, control: StepRule) -> Functional:
        """The displacement that a control goes by."""
        return self.discretisation.functional(getattr(control, "monitor", None))

    def monitored(self, increment: PETSc.Vec) -> float:
        """Change of the monitored displacement by an increment of the unknowns since the last converged state."""
        return self._monitor.of(increment)

    def monitored_rate(self, increment: PETSc.Vec) -> float:
        """Change of the monitored displacement by a small increment of the unknowns."""
        return self._monitor.rate(increment)

    def turn(self, before: State, after: State) -> float:
        """Largest angle in radians between the increment of a step and what it should go on from and lead to.

        These are the tangents at its start and its end. With contact, where tangents waver and paths have corners, it
        has to go on from either the increment before or the tangent at its start. At the start of a path, where what
        touches without a force opens at once, or where the load turns because it is made to, and nothing has flowed, so
        that points unload, the tangent at its end is the whole step's.
        """
        if self.system.smooth:
            return max(self.angle(after.direction, d) for d in (before.tangent, after.tangent))
        goes_on = self.system.comm.allreduce(bool(before.increment.any()), op=MPI.LOR)
        ways = [before.tangent, before.direction] if goes_on else [before.tangent]
        if not goes_on or (after.apart and not self.control.passes_limits):
            ways.append(after.tangent)
        least = min(self.angle(after.direction, way) for way in ways)
        return 0.0 if least > self.control.turn and self.stands_still(after) else least

    def stands_still(self, after: State) -> bool:
        """Whether a prescribed load moves nothing by more than states are exact, as of parts pressed onto obstacles.

        They are so to rounding, and to the penetration and slip that augmented contact leaves.
        """
        if self.control.passes_limits:
            return False
        left = max(contribution.tolerance for contribution in self.system.contributions) / self.discretisation.size
        moved = self.distance(0.0, after.increment)
        return moved <= max(rounding.SAFETY * rounding.UNIT, left) or moved <= rounding.off_path(self, after)

    def angle(self, one: tuple[float, np.ndarray], other: tuple[float, np.ndarray]) -> float:
        """Angle between two increments of load factor and unknowns; zero where one of them is rounding."""
        lengths = self.distance(*one), self.distance(*other)
        if min(lengths) <= rounding.SAFETY * rounding.UNIT:
            return 0.0
        return acos(np.clip(self.inner(one, other) / (lengths[0] * lengths[1]), -1.0, 1.0))

    def distance(self, load: float, increment: np.ndarray) -> float:
        """Length of an increment of load factor and unknowns (this process's part) in the control's measure."""
        return self.inner((load, increment), (load, increment)) ** 0.5

    def inner(self, one: tuple[float, np.ndarray], other: tuple[float, np.ndarray]) -> float:
        """Inner product of increments of load factor and unknowns in the control's measure."""
        (a, left), (b, right) = one, other
        return self.system.comm.allreduce(float(left * self.system.weights.array @ right)) + self._load_weight() * a * b
