"""Critical loads of imperfect structures and their gradients, each by the path of the imperfect structure."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import Any, cast

import numpy as np

from ..continuation.state import CriticalPoint, State
from ..events.search import state_at
from ..model.scene import Scene
from .augmented import KINDS
from .changed import Change
from .gradient import LoadGradient
from .imperfect import imperfect, shapes_on
from .shares import critical_modes
from .worst import NONE, ImperfectLoad, LoadsByShape

STEP = 1e-4  # of the size, of differences by a coefficient


class Imperfections(LoadsByShape):
    """Critical loads of a structure with imperfections, each by the path of the imperfect structure.

    Parameters
    ----------
    scene : without imperfections
    shapes : displacements, each as one of `imperfect`; the largest displacement of a shape should be 1
    follow : function from a scene to its Path, such as `Path`
    known : loads that were found before, which are not looked for again
    told : called with each new one

    Attributes
    ----------
    known : loads that have been found, by coefficients
    """

    def __init__(self, scene: Scene, shapes: Sequence[Any], follow: Callable[[Scene], Any], *,
                 known: Iterable[ImperfectLoad] = (), told: Callable[[ImperfectLoad], None] | None = None):
        if not len(shapes):
            raise ValueError("Imperfections: no shapes; give one or more")
        self._scene, self._follow, self._told = scene, follow, told
        self._shapes, self.count = shapes_on(scene, shapes), len(shapes)
        self._last: tuple[tuple[float, ...], Any, list[State], CriticalPoint | None] | None = None
        self.known = {one.coefficients: one for one in known}

    def at(self, coefficients: Sequence[float]) -> ImperfectLoad:
        """The first critical load with an imperfection.

        Raises
        ------
        ValueError
            If there is not one coefficient for each shape.
        """
        key = self._key(coefficients)
        if key not in self.known:
            self._last = self._followed(key)
            point = self._last[-1]
            self.known[key] = ImperfectLoad(key, *((point.load, point.kind) if point else (np.inf, NONE)))
            if self._told:
                self._told(self.known[key])
        return self.known[key]

    def gradient(self, coefficients: Sequence[float]) -> np.ndarray:
        """Derivatives of the first critical load by the coefficients, shape (number of shapes,).

        Raises
        ------
        ValueError
            As `LoadGradient`, where laws remember the way; or if the path has no critical point.
        NoDerivative
            At a bifurcation that a shape makes a limit point.
        """
        key = self._key(coefficients)
        if self._last is None or self._last[0] != key:
            self._last = self._followed(key)
        _, path, states, point = self._last
        if point is None:
            raise ValueError(f"Imperfections: the path with {', '.join(f'{c:.4g}' for c in key)} has no critical point "
                             f"up to load {states[-1].load:.6g}; let it go further, or take another imperfection")
        state = path.critical_states.get(point) or state_at(path.tracer, states[-2], states[-1], point)
        modes = critical_modes(path, states, point, state) if point.kind == "bifurcation" else ()
        gradient = LoadGradient(path, point, state, modes, states)
        size = float(np.linalg.norm(key) or 1.0)

        def of(number: int) -> Change:
            return Change(lambda value: self.scene([*key[:number], value, *key[number + 1:]]), key[number], STEP * size,
                          size)

        rates = np.empty(len(key))
        for n, rate in enumerate(gradient.derivatives(map(of, range(len(key))))):
            if isinstance(rate, Exception):
                raise rate
            rates[n] = np.min(rate)
        return rates

    def _key(self, coefficients: Sequence[float]) -> tuple[float, ...]:
        key = tuple(float(c) for c in coefficients)
        if len(key) != self.count:
            raise ValueError(f"Imperfections: {len(key)} coefficients for {self.count} shapes; give one each")
        return key

    def scene(self, coefficients: Sequence[float]) -> Scene:
        """The imperfect structure."""
        given = [(one, c) for shapes, c in zip(self._shapes, coefficients, strict=True) for one in shapes]
        return cast(Scene, imperfect(self._scene, [one for one, _ in given], [c for _, c in given]))

    def _followed(self, key: tuple[float, ...]) -> tuple[tuple[float, ...], Any, list[State], CriticalPoint | None]:
        """The path of an imperfect structure up to its first critical point; None: it has none."""
        path = self._follow(self.scene(key))
        return key, path, *up_to_critical(path)


def up_to_critical(path) -> tuple[list[State], CriticalPoint | None]:
    """States of a path up to its first limit point or bifurcation, and that; None: it has none."""
    states = []
    for state in path:
        states.append(state)
        for point in state.critical:
            if point.kind in KINDS:
                return states, point
    return states, None
