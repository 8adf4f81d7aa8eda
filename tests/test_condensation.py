"""Forces of rubbing pairs on a given flexibility, against the law that they have to follow."""

from __future__ import annotations

from functools import partial
from types import SimpleNamespace

import numpy as np
from scipy.sparse import block_diag, csr_matrix

from sheetfx.continuation.condensation import Condensation
from sheetfx.discrete.condensed_pairs import CondensedPairs
from sheetfx.discrete.pairs import Pairs

NORMAL, TANGENTIAL, FRICTION, PAIRS = 3e6, 3e4, 0.2, 12


RUBBING = SimpleNamespace(components=2, _slack=0.0, pairs=Pairs(*np.zeros((4, PAIRS)), np.ones(PAIRS),
                                                                (NORMAL, TANGENTIAL, FRICTION, 0.0, 0.0), False, 0.0))


class Given(Condensation):
    """Pairs in a plane, with gaps and tractions where a step starts, on a flexibility that is given."""

    begins = False

    def __init__(self, gaps, tractions, flexibility, moved):
        self._start, self._matrix, self._many = (gaps, tractions), flexibility, False
        self._rows, self._loads, self._responses = np.empty(0, dtype=np.int64), np.empty(0), []
        self._moved, self._flexibility = moved, np.empty((0, len(moved)))
        self._gaps, self._ends, self._size, self._exact = None, [], 1.0, 1e-4
        self._laws, self._alike = [(self.forces, self.moduli)], [partial(CondensedPairs.alike, RUBBING)]
        self._rows_of_pairs, self._multiples, self._regularise = np.full(PAIRS, 2), [1.0], lambda times: None
        self._before, self._stiff = self._after(np.zeros(2 * PAIRS))
        self._begin()

    def _trial(self, changes):
        gaps, tractions = self._start
        gap, slip = changes.reshape(-1, 2).T
        return np.maximum(-NORMAL * (gaps + gap), 0.0), tractions + TANGENTIAL * slip

    def forces(self, changes):
        pressures, tractions = self._trial(changes)
        return np.column_stack((-pressures, np.clip(tractions, -FRICTION * pressures, FRICTION * pressures))).ravel()

    def moduli(self, changes):
        pressures, tractions = self._trial(changes)
        closed, sticks = pressures > 0, np.abs(tractions) < FRICTION * pressures
        slope = np.where(sticks, 0.0, -FRICTION * NORMAL * np.sign(tractions)) * closed
        return block_diag([[[NORMAL * c, 0.0], [s, TANGENTIAL * t]] for c, s, t in
                           zip(closed, slope, sticks & closed, strict=True)], format="csr")

    def _units(self, rows):
        return rows

    def _respond(self, units):
        return self._matrix[units], np.zeros(len(units))

    def _places(self, responses):
        return responses


def problem(seed: int) -> Given:
    """A third of the pairs is open, others stick or slip; the structure is some thousand times softer than they are."""
    draw = np.random.default_rng(seed)
    gaps = np.where(draw.random(PAIRS) < 1 / 3, 1e-5, -1e-5) * draw.random(PAIRS)
    bounds = FRICTION * np.maximum(-NORMAL * gaps, 0.0)
    tractions = bounds * draw.choice([-1.0, 0.3, 1.0], PAIRS) * np.where(draw.random(PAIRS) < 0.5, 1.0, 1 + 1e-7)
    modes = draw.normal(size=(2 * PAIRS, 2 * PAIRS)) / (2 * PAIRS) ** 0.5
    structure = 1e-3 * modes @ modes.T + 1e-4 * np.eye(2 * PAIRS)
    tangent = Given(gaps, tractions, structure, np.zeros(2 * PAIRS))._stiff.toarray()
    flexibility = structure @ np.linalg.inv(np.eye(2 * PAIRS) + tangent @ structure)
    return Given(gaps, tractions, flexibility.T, 1e-3 * draw.normal(size=2 * PAIRS))


def found(given: Given) -> bool:
    """Whether forces are found; they must be those of the law then."""
    forces = given._solve()
    if forces is None:
        return False
    every = np.zeros(2 * PAIRS)
    every[given._rows] = forces
    changes = given._moved - every @ given._matrix
    right = given.forces(changes) - given._before - csr_matrix(given._stiff) @ changes
    np.testing.assert_allclose(every, right, atol=1e-3)
    return True


def test_nearly_all_problems_are_solved():
    """One of these, 99 of 100 in all; where each pair is linearised at the end of its way it is 55 of 100."""
    assert sum(found(problem(seed)) for seed in range(40)) >= 39


def test_without_a_step_there_are_no_forces():
    given = problem(0)
    given._moved = np.zeros(2 * PAIRS)
    assert not given._solve().any()
