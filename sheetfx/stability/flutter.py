"""Flutter: where two frequencies of a structure under loads that follow it meet and become complex.

Under loads without a potential a structure can lose its stability while its tangent stays regular: two squares of
frequencies of small vibrations, K mode = omega^2 M mode, meet on the real axis and leave it as a conjugate pair
(Bolotin 1963; Ziegler 1968). Beyond, motions oscillate and grow.
"""

from __future__ import annotations

from math import inf

import numpy as np
from scipy.optimize import brentq

from ..continuation.segment import Missed, Segment
from ..continuation.spectrum import nearest_pairs
from ..continuation.state import CriticalPoint, State
from .vibration import is_complex, mass_matrix

COUNT = 6  # squares of frequencies, those nearest to zero, among which pairs are looked for
SAME = 1e-3  # relative difference of pairs that meet at one point
EXACT = 1e-9  # of a step, length within which frequencies meet


class Flutter:
    """Looks for flutter in the steps of a path whose tangent is not symmetric and whose parts have densities."""

    def __init__(self, tracer):
        self._tracer, self._mass = tracer, mass_matrix(tracer.discretisation)
        self._last: tuple[State | None, list[complex]] = None, []

    @staticmethod
    def concerns(tracer) -> bool:
        """Whether flutter is possible, and can be looked for."""
        parts = tracer.discretisation.scene.parts
        heavy = all(part.material is not None and part.material.density is not None for part in parts)
        return heavy and tracer.system.smooth and not tracer.system.conservative

    def __call__(self, segment: Segment) -> list[CriticalPoint]:
        """Points at which two frequencies meet, or part again, in a step."""
        before, after = (self._squares(segment, length) for length in (0.0, segment.after.length))
        self._last = segment.after, after
        reach = min(abs(values[-1]) if values else inf for values in (before, after))
        pairs = [[v for v in values if v.imag > 0 and is_complex(v) and abs(v) <= reach] for values in (before, after)]
        if len(pairs[0]) == len(pairs[1]):
            return []
        more, sign = (pairs[1], 1) if len(pairs[1]) > len(pairs[0]) else (pairs[0], -1)
        meeting = min(more, key=lambda pair: abs(pair.imag) / abs(pair))
        number = sum(abs(pair - meeting) <= SAME * abs(meeting) for pair in more)
        length = self._meet(segment, meeting.real, number)
        if length is None:
            return []
        state = segment[length]
        return [CriticalPoint("flutter", state.load, state.deflection, segment.after.step, length, number,
                              name="begins" if sign > 0 else "ends")]

    def _squares(self, segment: Segment, length: float) -> list[complex]:
        """Squares of frequencies at a state of the step, those nearest to zero."""
        state, tracer = segment[length], self._tracer
        if state is self._last[0]:
            return self._last[1]
        tracer.factorise_at(state)
        return [value for value, *_ in nearest_pairs(tracer.stepper.linear, self._mass(), COUNT)]

    def _meet(self, segment: Segment, near: float, number: int) -> float | None:
        """Length at which frequencies meet: the square of half the difference of both passes zero.

        Where several pairs meet at once, as in columns that are the same in two planes, the means of both count.
        """
        def discriminant(length):
            values = self._squares(segment, length)
            pairs = [v for v in values if v.imag > 0 and is_complex(v)]
            if pairs:
                return -min(pairs, key=lambda v: abs(v.real - near)).imag ** 2
            real = np.sort([v.real for v in values])
            groups = [real[n: n + 2 * number] for n in range(len(real) - 2 * number + 1)]
            group = min(groups, key=lambda g: abs(g.mean() - near))
            return ((group[number:].mean() - group[:number].mean()) / 2) ** 2

        try:
            return float(brentq(discriminant, 0.0, segment.after.length, xtol=EXACT * segment.after.length))
        except (Missed, ValueError):
            return None
