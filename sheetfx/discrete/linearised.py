"""The linear solution of the unloaded structure, with what can be asked of it: derivatives along its response."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

AHEAD = 2e-5  # of the structure's size, by which its nodes move either way, and twice that


class LinearSolution:
    """Displacements, forces, stresses and reactions that are linear in the load.

    Each is the derivative of what a record tells, by the load factor at the first state, times a factor.

    Parameters
    ----------
    record : Record, whose shown state stays as it is
    state : that whose response is taken
    factor : load factor
    """

    def __init__(self, record, state, factor: float):
        self._record, self._state, self.factor = record, state, factor
        size = record.path.tracer.distance(0.0, state.response)
        self._ahead = AHEAD / size if size else 1.0

    def __str__(self) -> str:
        return f"linear solution at load factor {self.factor:g}"

    @property
    def load(self) -> float:
        """Total load on the whole structure."""
        return float(self.of(self._record.path.discretisation.total_load))

    @property
    def deflection(self) -> float:
        """Monitored displacement."""
        tracer, structure = self._record.path.tracer, self._record.path.discretisation
        return self.factor * tracer.monitored_rate(structure.system.create_vector(self._state.response))

    def of(self, ask: Callable[[], Any]) -> Any:
        """Linear part of a number or array that is asked of the structure in its present configuration.

        By differences of fourth order (Richardson), since thin parts are nonlinear after a small way.
        """
        structure = self._record.path.discretisation
        system, found = structure.system, []
        with structure.visiting(self._state.fields), system.history.frozen():
            for ahead in (self._ahead, -self._ahead, 2 * self._ahead, -2 * self._ahead):
                system.configure(system.create_vector(ahead * self._state.response), self._state.factor + ahead)
                found.append(np.asarray(ask()))
        near, far = found[0] - found[1], found[2] - found[3]
        return self.factor * (8 * near - far) / (12 * self._ahead)

    def displacement(self, at: str, mesh=None) -> np.ndarray:
        """Of a named point, see `Record.displacement`."""
        return self.of(lambda: self._record.displacement(at, mesh))

    def rotation(self, at: str, mesh=None) -> np.ndarray:
        """Rotation vector of a named point, in the plane an angle."""
        turn = self.of(lambda: self._record.rotation(at, mesh))
        return 2 * turn[1:] if turn.shape == (4,) else turn

    def forces(self, part) -> np.ndarray:
        """Stress resultants of a part, see `Record.forces`."""
        return self.of(lambda: self._record.forces(part))

    def stresses(self, part, at: float | Sequence[float] = 0.0) -> np.ndarray:
        """Stresses of a part, see `Record.stresses`."""
        return self.of(lambda: self._record.stresses(part, at))

    def reaction(self, of: Any) -> np.ndarray:
        """Force, along space, that a support or a prescribed motion exerts on the modelled structure."""
        def force():
            found = [reaction.force for thing, reaction in self._record.shown_reactions() if thing is of]
            if not found:
                raise ValueError(f"reaction: {of!r} is no support or prescribed motion of the scene")
            return found[0]
        return self.of(force)
