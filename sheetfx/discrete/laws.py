"""Section laws evaluated outside the kernels of the strains, at given strains."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np
import ufl
from dolfinx.mesh import Mesh

from ..mesh.at_points import at_points, put, values_at_points
from ..mesh.quadrature import Rule
from ..model.history import LawWithHistory

SAME = 1e-6  # relative difference of moduli that is rounding
PIECES = 4  # of the way between two states, along which a law is followed


class FormulaLaw:
    """A law written in UFL.

    Parameters
    ----------
    law : function from a UFL vector of strains to one of resultants
    size : number of strains
    domain, cells, rule : where it is evaluated
    """

    def __init__(self, law: Callable, size: int, domain: Mesh, cells: np.ndarray, rule: Rule):
        self._domain, self._cells, self._size = domain, cells, size
        self._given, self._rows = values_at_points(domain, cells, rule, (size,))
        strains = ufl.variable(self._given)
        resultants = law(strains)
        moduli = ufl.diff(resultants, strains)
        self._values = at_points(ufl.as_vector(
            [resultants[i] for i in range(size)] + [moduli[i, j] for i in range(size) for j in range(size)]),
            rule.points)

    def __call__(self, chunk: slice, strains: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Resultants (cells, points, n) and moduli (cells, points, n, n) of strains (cells, points, n)."""
        put(self._given, self._rows[chunk], strains)
        values = self._values.eval(self._domain, self._cells[chunk]).reshape(*strains.shape[:2], -1)
        return values[..., :self._size], values[..., self._size:].reshape(*strains.shape, self._size)


class RememberingLaw:
    """A law with history, and the history of its points.

    Parameters
    ----------
    law : LawWithHistory
    shape : cells, points of each, strains

    Attributes
    ----------
    frozen : whether points answer as the linear comparison solid of the last accepted state (Hill 1958): with the
        moduli of loading where they were on the point of yielding, the others with elastic ones
    """

    def __init__(self, law: LawWithHistory, shape: tuple[int, int, int]):
        self._law, self.frozen = law, False
        self._strains, self._history = np.zeros(shape), np.zeros((*shape[:2], law.remembered))
        self._way: dict[int, list[np.ndarray]] = {}
        self._found: dict[int, tuple[np.ndarray, tuple[np.ndarray, ...]]] = {}  # strains and what follows

    def __call__(self, chunk: slice, strains: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Resultants (cells, points, n) and moduli (cells, points, n, n) of strains (cells, points, n)."""
        if not self.frozen:
            return self._update(chunk, strains)[:2]
        resultants, moduli, _ = self._update(chunk, self._strains[chunk])
        return resultants + (moduli @ (strains - self._strains[chunk])[..., None])[..., 0], moduli

    def _update(self, chunk: slice, strains: np.ndarray) -> tuple[np.ndarray, ...]:
        if chunk.start in self._found and np.array_equal(self._found[chunk.start][0], strains):
            return self._found[chunk.start][1]
        history = self._history[chunk]
        points = strains.shape[0] * strains.shape[1]
        updated = self._law.update(strains.reshape(points, -1), history.reshape(points, history.shape[2]))
        found = tuple(values.reshape(*strains.shape[:2], *values.shape[1:]) for values in updated)
        self._found[chunk.start] = strains.copy(), found
        return found

    def commit(self, chunk: slice, strains: np.ndarray) -> None:
        """Let history move on to what the present strains make of it."""
        self._history[chunk] = history = self._update(chunk, strains)[2]
        self._strains[chunk] = strains
        self._found.pop(chunk.start)
        if hasattr(self._law, "accepted"):
            self._law.accepted(strains.reshape(-1, strains.shape[2]), history.reshape(-1, history.shape[2]))

    def pass_by(self, chunk: slice, strains: np.ndarray, begins: bool) -> None:
        """Add strains to those that a step from the last accepted state comes by: a halfway place, a state, in turn."""
        if begins:
            self._way[chunk.start] = []
        self._way[chunk.start].append(strains.reshape(-1, strains.shape[2]).copy())

    def forgotten(self, chunk: slice, strains: np.ndarray, measure: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """What a law forgets that goes from the start of a step to strains at once, or to those on the way to them.

        Parameters
        ----------
        measure : of the points, (cells, points)

        Returns
        -------
        resultants that are forgotten at the end, shape of the strains; at the ends of all pieces of the way, sums of
        the sizes of their power and of all resultants' power, (pieces, 2)
        """
        end, powers = strains.reshape(-1, strains.shape[2]), []
        start = self._strains[chunk].reshape(end.shape)
        history = self._history[chunk].reshape(len(end), self._history.shape[2])
        known, lost = (self._law.update(start, history)[0], history), np.zeros_like(end)
        way = [*self._way.pop(chunk.start), end]
        for middle, after in zip(way[::2], way[1::2], strict=True):
            for now, rate, *found in self._followed(start, middle, after, *known):
                known = resultants, along = found
                moved, lost = np.flatnonzero((along != history).any(axis=1)), np.zeros_like(end)
                if len(moved):
                    lost[moved] = resultants[moved] - self._law.update(now[moved], history[moved])[0]
                powers.append([measure.ravel() @ np.abs((values * rate).sum(axis=1)) for values in (lost, resultants)])
            start = after
        return lost.reshape(strains.shape), np.array(powers)

    def _followed(self, start, middle, end, resultants, along) -> Iterator[tuple[np.ndarray, ...]]:
        """Strains, their rate, resultants and history at the ends of PIECES of a parabola through strains.

        Each point also stops where the power of its resultants, those at the start of a piece, changes sign.
        """
        slope, bend = 4 * middle - 3 * start - end, 2 * (start - 2 * middle + end)
        for piece in range(PIECES):
            with np.errstate(divide="ignore", invalid="ignore"):
                turn = -(resultants * slope).sum(axis=1) / (2 * resultants * bend).sum(axis=1)
            for part in (turn, np.full(len(start), (piece + 1.0) / PIECES)):
                there = np.flatnonzero((part > piece / PIECES) & (part <= (piece + 1) / PIECES))
                if not len(there):
                    continue
                way, along = part[there, None], along.copy()
                now = start[there] + way * (slope[there] + way * bend[there])
                resultants, _, along[there] = self._law.update(now, along[there])
            yield now, slope + 2 * (piece + 1) / PIECES * bend, resultants, along

    @property
    def tells_energy(self) -> bool:
        """Whether the law says what it stores and dissipates."""
        return hasattr(self._law, "energies")

    def energies(self, chunk: slice, strains: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """What points store, and have dissipated since the start, at strains; both (cells, points)."""
        history = self._update(chunk, strains)[2]
        points = strains.shape[0] * strains.shape[1]
        found = self._law.energies(strains.reshape(points, -1), history.reshape(points, history.shape[2]))
        stored, dissipated = (values.reshape(strains.shape[:2]) for values in found)
        return stored, dissipated

    @property
    def history(self) -> np.ndarray:
        """History of the last accepted state, (cells, points, remembered)."""
        return self._history

    @property
    def strains(self) -> np.ndarray:
        """Strains of the last accepted state, (cells, points, strains)."""
        return self._strains

    @property
    def moved(self) -> bool:
        """Whether a point of this process remembers something."""
        return bool(self._history.any())

    def moved_since(self, kept: np.ndarray) -> bool:
        """Whether a point of this process remembers something else than in a snapshot."""
        return not np.array_equal(self._history, kept[..., self._strains.shape[2]:])

    def stands_still(self, kept: np.ndarray) -> bool:
        """Whether points of this process remember what they did in a snapshot, with the moduli halfway from there."""
        if self.moved_since(kept):
            return False
        count = self._strains.shape[2]
        halfway, now, history = (values.reshape(values.shape[0] * values.shape[1], values.shape[2]) for values in (
            (kept[..., :count] + self._strains) / 2, self._strains, self._history))
        moduli = [self._law.update(strains, history)[1] for strains in (halfway, now)]
        return bool(np.allclose(*moduli, rtol=0.0, atol=SAME * np.abs(moduli[0]).max(initial=0.0)))

    def snapshot(self) -> np.ndarray:
        """Strains and history of the last accepted state."""
        return np.concatenate((self._strains, self._history), axis=2)

    def restore(self, kept: np.ndarray) -> None:
        count = self._strains.shape[2]
        self._strains[:], self._history[:] = kept[..., :count], kept[..., count:]
        self._found.clear()
