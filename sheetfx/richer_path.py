"""Critical points on a richer discretisation by a piece of its own path, where no Newton's method finds them directly.

A state before the point is taken over. It comes to rest while its amplitude is held, and the path goes on from there up
to a point of the same kind. Where states depend on those before, by friction or laws with history, the piece begins at
the last one that remembers nothing.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from functools import cached_property, partial
from itertools import count, islice

import numpy as np

from .continuation.state import CriticalPoint, State
from .continuation.transferred import between
from .critical.error_bar import ErrorBar, error_bars
from .critical.remade import Remade
from .critical.shares import critical_modes
from .discrete.discretisation import Discretisation
from .events.determinant import orthonormal
from .model.scene import Scene
from .path import Path, PathFailure

LONGER = 2  # times the steps of the path, that a piece of the richer one takes at most, and so many more


def error_bars_of(path: Path, states: Sequence[State], points: Sequence[CriticalPoint],
                  state_at: Callable[[CriticalPoint], State],
                  modes_at: Callable[[CriticalPoint], Sequence[np.ndarray]],
                  scene: Scene | None = None) -> list[ErrorBar]:
    """Error bars of critical points of a path, directly or by pieces of the richer one; none by these after falls.

    Parameters
    ----------
    states : of the path, from its first state on
    points, state_at, modes_at, scene : see `critical.error_bar.error_bars`
    """
    by_path = None if path.falls else partial(RicherPath, path, states)
    return error_bars(path, points, state_at, modes_at, by_path, scene)


class RicherPath:
    """Finds points of a path on a richer discretisation.

    Parameters
    ----------
    path, states : of the structure, from its first state on
    scene : richer one
    """

    def __init__(self, path: Path, states: Sequence[State], scene: Scene):
        self._path, self._states, self._target = path, states, Discretisation(scene)
        self._pieces: dict[int, Piece] = {}

    def __call__(self, point: CriticalPoint, alike: float) -> tuple[float, float, int]:
        """The same point of the richer structure.

        Parameters
        ----------
        alike : cosine between modes, from which on a point is surely the same

        Returns
        -------
        Its load, the smallest cosine, and the factorisations that it took.

        Raises
        ------
        ArithmeticError
            If no piece leads to such a point, or its mode is another one for the greater part.
        """
        spent, modes = 0, modes_of(self._path, self._states, point)
        for start in self._starts(point):
            if start.step not in self._pieces:
                self._pieces[start.step] = Piece(start, self._path, self._target)
            piece, found = self._pieces[start.step], []
            for there in piece.points(start.step + LONGER * (point.step - start.step + 1)):
                if there.kind == point.kind and (there.name == point.name or there.kind != "limit"):
                    found.append((piece.cosine(there, modes), there.load))
                    if found[-1][0] >= alike:
                        break
            spent += piece.spent()
            if found:
                cosine, load = max(found)
                if 2 * cosine**2 < 1:
                    raise ArithmeticError(f"with one degree more the next {point.kind} point is at load {load:.6g} in "
                                          f"another mode, alike to {cosine:.2f}")
                return load, cosine, spent
        raise ArithmeticError("the path with one degree more has no such point near")

    def _starts(self, point: CriticalPoint) -> Iterator[State]:
        """States before a point, the last one first, each twice as far behind as the one before."""
        before, back = [s for s in self._without_past if s.step < point.step], 1
        if not before:
            raise ArithmeticError("no state before the point is known that remembers nothing")
        while back < len(before):
            yield before[-back]
            back *= 2
        yield before[0]

    @cached_property
    def _without_past(self) -> list[State]:
        """States up to the first one that depends on those before; a path's beginning never does."""
        tracer, kept = self._path.tracer, []
        contributions = tracer.system.contributions
        remembers = any(c.remembers for c in contributions)
        rubs = any(not (c.smooth or c.conservative) for c in contributions)
        for state in self._states:
            if remembers:
                tracer.back_to(state)
            if state.step and ((rubs and not state.apart) or (remembers and tracer.system.history.moved)):
                break
            kept.append(state)
        return kept


class Piece:
    """Piece of a path of the richer structure, followed only as far as it is asked.

    Parameters
    ----------
    start : state of the poorer path that it begins at
    path : poorer one
    target : richer discretisation
    """

    _told = 0

    def __init__(self, start: State, path: Path, target: Discretisation):
        self._start, self._poorer, self._target, scene = start, path.discretisation, target, target.scene
        first = between(start, self._poorer, self._target)[0]
        there = {id(one): other for one, other in zip(path.scene.meshes, scene.meshes, strict=False)}
        control = Remade(there).of(path.controls[-1])  # it may have a monitor of its own
        self._path = Path(scene, control, start=[first] if start.step else [])
        known = not start.step or self._is_behind_as_many(start)
        self._states = [self._path.tracer.state]
        self._further = iter(self._path if known else ())

    def _is_behind_as_many(self, start: State) -> bool:
        """Whether it settles, with as many unstable modes where they are counted: no point lies between."""
        settled = self._path.tracer.settle()
        return settled is not None and start.unstable_modes in (None, settled.unstable_modes)

    def points(self, last: int) -> Iterator[CriticalPoint]:
        """Critical points up to a step."""
        for number in count():
            if number == len(self._states) and not (self._states[-1].step < last and self._go_on()):
                return
            yield from self._states[number].critical

    def _go_on(self) -> bool:
        """Whether there is a further state."""
        try:
            further = list(islice(self._further, 1))
        except PathFailure:
            further = []
        self._states += further
        return bool(further)

    def spent(self) -> int:
        """Factorisations since this was last asked."""
        before, self._told = self._told, self._path.tracer.total_factorisations
        return self._told - before

    def cosine(self, point: CriticalPoint, modes: Sequence[np.ndarray]) -> float:
        """Smallest cosine between the spaces of a point's modes and of modes of the poorer path."""
        modes = between(self._start, self._poorer, self._target, modes)[1]
        found = modes_of(self._path, self._states, point)
        weights, system = self._path.tracer.system.weights, self._path.tracer.system
        one, other = (orthonormal(weights, [system.create_vector(m) for m in those]) for those in (modes, found))
        return float(np.linalg.svd([[(weights * a).dot(b) for b in other] for a in one], compute_uv=False).min())


def modes_of(path: Path, states: Sequence[State], point: CriticalPoint) -> list[np.ndarray]:
    """Null vectors at a bifurcation; at a limit point the path's own direction, as yielding leaves no null vector."""
    state = path.critical_states.get(point)
    if point.kind != "limit":
        return critical_modes(path, states, point, state)
    return [(state or next(s for s in states if s.step == point.step)).response]
