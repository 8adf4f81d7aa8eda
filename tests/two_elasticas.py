"""Two inextensible strips that slide on each other, by shooting: an independent solution for the double plate.

Strip 1 is clamped at x = 0 at a height above strip 2, which is clamped at the far end and reaches back; both touch with
their centre lines, without friction. theta' = m / EI and m' = n x t along each (Antman 2005, chapter 4), with the
contact force normal to strip 2 at the tip of strip 1.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import brentq, fsolve


@dataclass
class TwoElasticas:
    """Strips of one length and bending stiffness.

    Attributes
    ----------
    length, bending : of both
    gap, overlap : in height, and along the strips
    """

    length: float
    bending: float
    gap: float
    overlap: float

    def first_touch(self) -> float:
        """Load at which strip 1, alone until then, has come down to strip 2."""
        start = 3 * self.bending * self.gap / self.length**3
        return brentq(lambda load: self._alone(load) - self.gap, 0.5 * start, 2 * start, xtol=1e-12)

    def _alone(self, load: float) -> float:
        force = np.array([0.0, -load])
        moment = fsolve(lambda m: self._end(m[0], force, self.length)[3], [-load * self.length], xtol=1e-12)[0]
        return -self._end(moment, force, self.length)[1]

    def _end(self, moment: float, force: np.ndarray, length: float) -> np.ndarray:
        """Place, angle and moment at the end of a strip along x with a moment at its clamp and a force at its end."""
        def rates(s, y):
            along = np.cos(y[2]), np.sin(y[2])
            return [*along, y[3] / self.bending, along[1] * force[0] - along[0] * force[1]]

        return solve_ivp(rates, (0, length), [0.0, 0.0, 0.0, moment], rtol=1e-9, atol=1e-9, method="DOP853").y[:, -1]

    def _off(self, unknowns: np.ndarray, load: float) -> np.ndarray:
        """Moments at both ends, and what the touched point of strip 2 is off its angle and off the tip of strip 1.

        Unknown are the moments at the clamps, the arm and angle of the touched point of strip 2, and the contact force.
        """
        one, two, arm, angle, force = unknowns
        tip = self._end(one, force * np.array([np.sin(angle), np.cos(angle)]) - [0.0, load], self.length)
        other = self._end(two, force * np.array([np.sin(angle), -np.cos(angle)]), arm)
        apart = [2 * self.length - self.overlap - other[0] - tip[0], other[1] - self.gap - tip[1]]
        return np.array([tip[3], other[3], other[2] - angle, *apart])

    def path(self, loads) -> np.ndarray:
        """Deflection, contact force and arm on strip 2 at loads that rise from first touch on, shape (loads, 3)."""
        unknowns = np.array([-self.first_touch() * self.length, 0.0, self.length - self.gap, 0.0, 0.0])
        unknowns[2] = fsolve(lambda arm: self._off(np.array([unknowns[0], 0.0, arm[0], 0.0, 0.0]), loads[0])[3],
                             [self.overlap])[0]
        found = []
        for load in loads:
            unknowns, _, success, message = fsolve(self._off, unknowns, (load,), xtol=1e-11, full_output=True)
            assert success == 1, message
            tip = self._end(unknowns[0], unknowns[4] * np.array([np.sin(unknowns[3]), np.cos(unknowns[3])])
                            - [0.0, load], self.length)
            found.append((-tip[1], unknowns[4], unknowns[2]))
        return np.array(found)

    def slides_off(self, start: float) -> np.ndarray:
        """Load, deflection and contact force where the tip of strip 1 is at the end of strip 2, below a load."""
        loads = np.linspace(self.first_touch() * 1.001, start, 60)
        path = self.path(loads)
        last = int(np.flatnonzero(path[:, 2] < self.length)[-1])
        near = np.polynomial.Polynomial.fit(path[last - 3:last + 1, 2] - self.length, loads[last - 3:last + 1], 3)(0.0)
        return np.array([near, *self.path([*loads[:last + 1], near])[-1, :2]])
