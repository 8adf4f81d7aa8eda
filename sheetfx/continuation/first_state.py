"""The first state of a path or stage: its balance, its response where laws have a kink, and what only stresses it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from math import sqrt
from typing import Any

import numpy as np
from petsc4py import PETSc

from ..notices import warn
from ..rounding import NONE, SAFETY, noise
from .control import LoadControl, LoadResponse
from .measuring import Measuring
from .state import State

PROBE = 1e-6  # distance along the response at which the change of the tangent is looked at


class FirstState(Measuring):
    """The share of a `Tracer` in its first state.

    Attributes
    ----------
    stepper, snes : of the tracer
    x : increments since the last converged state
    state, tangent : where it is, and its response to load
    """

    stepper: Any
    snes: Any
    x: PETSc.Vec
    state: State
    tangent: LoadResponse
    reason: Callable[[], str]
    _load: PETSc.Vec
    _response: PETSc.Vec
    _reference: tuple[float, float] | None
    _attempted: Callable[..., State | None]
    _undo: Callable[[State], None]

    def _at_first(self, stage: int) -> float:
        """Load factor with which a stage begins."""
        return float(any(s.at_once for s in self.discretisation.stages[stage:stage + 1]))

    def _balance(self) -> None:
        """Find the balance that a stage begins with, where its first state is out of balance by more than rounding.

        Contact without load finds its own in the first step.

        Raises
        ------
        ValueError
            Where none is found.
        """
        start, system = self.state, self.system
        residual, off = system.create_vector(), []
        system.residual(residual)
        if not ((system.smooth or system.factor) and residual.norm() > 0):
            return
        for force in (residual, noise(system, self.x)):
            self.stepper.linear.solve(force, self._load)
            off.append(self.distance(0.0, self._load.array))
        if off[0] <= SAFETY * off[1]:
            return
        if not system.factor:
            warn(f"Scene: the unloaded structure is out of balance by forces of {residual.norm():.4g} in all, of "
                 "stress at rest in a law or joint; the path begins where it is in balance. Put them on by a Stage of "
                 "InitialStrain to have the way there")
        found = self._attempted(LoadControl(), self.tangent, 0.0)
        if found is None:
            raise ValueError(f"Scene: the structure that the path begins with is out of balance by forces of "
                             f"{residual.norm():.4g} in all, and no balance is found ({self.reason()}); let loads or "
                             "InitialStrain put them on in a Stage")
        self.state = replace(found, step=start.step, increment=start.increment, length=0.0)

    def _look_ahead(self) -> None:
        """Give the first state the response that leads on from it where laws of parts have cases there.

        The moduli of a kink depend on the way that leads away: each response gives the next moduli, until it
        stays. Stresses are the first state's.
        """
        system, tangent = self.system, self.tangent
        if tangent.least_weight or not any(c.kinks and not c.remembers for c in system.contributions):
            return
        sign, last = self.control.direction(self.state), system.create_vector()
        system.load(self._load)
        for _ in range(self.control.iterations_allowed):
            self._response.copy(last)
            ahead = sign * PROBE / sqrt(tangent.norm2)
            last.copy(self.x)
            self.x.scale(ahead)
            system.configure(self.x, self.state.factor + ahead)
            self.stepper.factorise(self.snes, self.x)
            self.stepper.linear.solve(self._load, self._response)
            last.axpy(-1.0, self._response)
            if tangent.inner(last, last) <= PROBE * tangent.norm2:
                break
        self._reference = tangent.norm2, self._load.dot(self._response)
        tangent.initial_norm2 = tangent.norm2
        self.state = replace(self.state, response=self._response.array.copy(), reference=self._reference,
                             load_rate=sign / sqrt(tangent.norm2 + self._load_weight()))
        self._undo(self.state)

    def _load_stiffens(self) -> bool:
        """Whether the load stresses held parts, though it moves nothing: by natural strains, or the tangent tells."""
        system = self.system
        if any(c.stage == system.factors.stage and not c.tells_work for c in system.contributions):
            return True
        matrix: Any = system.matrix
        here = matrix.copy()
        system.configure(self.x, system.factor + 1.0)
        system.extrapolate_stress()
        change = system.tangent().copy()
        change.axpy(-1.0, here, PETSc.Mat.Structure.SAME_NONZERO_PATTERN)
        system.configure(self.x, system.factor - 1.0)
        system.extrapolate_stress()
        self.stepper.factorise(self.snes, self.x)
        return change.norm() > NONE * here.norm()

    def _is_held(self, held: np.ndarray) -> bool:
        """Whether supports alone take the load; `held` are its forces on fixed increments of this process."""
        return self._load.norm() <= NONE * self.system.comm.allreduce(float(held @ held)) ** 0.5
