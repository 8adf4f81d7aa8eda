"""A path of sheetfx against the dense one of the same structure: every state on it, and the same critical points."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from dense_path import DensePath, Place, Point, Undecided
from random_structures import Structure, dense, scene
from scipy.optimize import brentq

import sheetfx as fx

LONGEST, TURN = 0.03, 0.1  # of the dense steps, in diagonals of the structure and in radians; the check halves both
ON_PATH = 1e-4  # distance of a state from the dense path, in diagonals of the structure
LOAD = 1e-5  # difference of loads of one point, relative
NEAR_ZERO = 1e-3  # of the largest load, from which on differences are relative
FARTHEST = 3.0  # length of the dense path over that of the states' polygon, in which their end must be passed


@dataclass(frozen=True)
class Comparison:
    """What became of a structure.

    Attributes
    ----------
    name : of the structure
    points : number of critical points of the dense path
    undecided : why the dense path is not known; "" where it is
    differences : points that are missed, invented or different, and where the path is left
    factorisations : of sheetfx
    """

    name: str
    points: int
    undecided: str
    differences: tuple[str, ...]
    factorisations: int

    def __str__(self) -> str:
        return f"{self.name}: {self.undecided or '; '.join(self.differences) or 'agrees'}"


def compare(structure: Structure, control: fx.ArcLength | None = None, steps: int = 40) -> Comparison:
    """Trace a structure both ways."""
    record, failure = _traced(structure, control or fx.ArcLength(), steps)
    states = [_displacements(record, structure, state) for state in record.states]
    spent = record.path.tracer.total_factorisations
    try:
        one, other = (DenseRun(structure, states, part) for part in (1.0, 0.5))
    except Undecided as reason:
        return Comparison(structure.name, 0, f"undecided: {reason}", (), spent)
    points = other.points
    if one.passed != other.passed or _differences(one.points, points):
        return Comparison(structure.name, len(points), "undecided: half the step gives other points", (), spent)
    reached = record.states[other.passed - 1].step
    found = [Point(p.kind, p.load / structure.total, p.multiplicity, 0.0) for p in record.critical_points
             if p.step <= reached]
    differences = [*failure, *_differences(points, found)]
    if other.passed < len(states):
        differences.append(f"state {other.passed} of {len(states)} is not on the path")
    return Comparison(structure.name, len(points), "", tuple(differences), spent)


def _traced(structure: Structure, control: fx.ArcLength, steps: int):
    case = fx.Case(scene(structure), control, fx.Until(deflection=structure.deflection, steps=steps))
    try:
        return fx.trace(case), []
    except fx.PathFailure as failure:
        return failure.record, [f"stops: {failure}"]


def _displacements(record, structure: Structure, state) -> np.ndarray:
    """Displacements of the named nodes in a row, and the load factor."""
    record.show(state)
    mesh = record.case.scene.parts[0].mesh
    kinematics = record.path.discretisation.kinematics(mesh)
    return np.append(np.ravel([kinematics.displacement(mesh, name) for name in structure.nodes]), state.factor)


class DenseRun:
    """The dense path as far as it passes given states one after the other.

    Attributes
    ----------
    passed : number of states that it passes
    points : critical points up to the last of them
    """

    def __init__(self, structure: Structure, states: Sequence[np.ndarray], part: float):
        self._problem, self._dimension = dense(structure), structure.dimension
        size = np.linalg.norm(np.ptp(list(structure.nodes.values()), axis=0))
        longest = part * LONGEST * size * len(structure.nodes) ** 0.5
        self._path = path = DensePath(self._problem, longest, part * TURN)
        scales = np.append(np.ones(len(states[0]) - 1), path.scale)
        targets = [state * scales for state in states]
        self._tolerance = ON_PATH * size
        whole = sum(np.linalg.norm(b - a) for a, b in zip(targets[:-1], targets[1:], strict=True))
        along, self.passed = 0.0, 1
        while self.passed < len(targets) and path.lengths[-1] - along <= FARTHEST * whole:
            path.step()
            while self.passed < len(targets) and (there := self._meets(targets[self.passed])) is not None:
                along, self.passed = there, self.passed + 1
        self.points = [point for point in path.points if point.along <= along]

    def _meets(self, target: np.ndarray) -> float | None:
        """Length of the path where its last step passes a state; None: it does not."""
        path, (here, there) = self._path, self._path.places[-2:]
        length = path.lengths[-1] - path.lengths[-2]

        def ahead(place: Place) -> float:
            return float((target - self._shown(place.z)) @ self._shown(place.tangent))

        far = min(np.linalg.norm(target - self._shown(place.z)) for place in (here, there))
        if far > length or not ahead(here) >= 0 > ahead(there):
            return None
        along = brentq(lambda s: ahead(path.ahead(here, s) if s < length else there), 0.0, length, xtol=1e-9 * length)
        nearest = path.ahead(here, along)
        near = np.linalg.norm(target - self._shown(nearest.z)) <= self._tolerance
        return path.lengths[-2] + along if near else None

    def _shown(self, z: np.ndarray) -> np.ndarray:
        """Displacements of the named nodes, and the load factor, of a vector."""
        return np.append(self._problem.displacement(z[:-1], self._dimension), z[-1])


def _differences(wanted: Sequence[Point], found: Sequence[Point]) -> list[str]:
    """Points of one list that the other does not have, in order."""
    largest = max((abs(point.factor) for point in wanted), default=0.0)

    def same(one: Point, other: Point) -> bool:
        return (one.kind, one.multiplicity) == (other.kind, other.multiplicity) and (
            abs(one.factor - other.factor) <= LOAD * max(abs(one.factor), NEAR_ZERO * largest))

    def named(point: Point) -> str:
        return f"{point.multiplicity}-fold {point.kind} at {point.factor:.8g}"

    matched = _longest_common(wanted, found, same)
    missed = [f"missed: {named(p)}" for i, p in enumerate(wanted) if i not in {i for i, _ in matched}]
    return missed + [f"invented: {named(p)}" for j, p in enumerate(found) if j not in {j for _, j in matched}]


def _longest_common(one: Sequence, other: Sequence, same) -> list[tuple[int, int]]:
    """Pairs of numbers of the longest common subsequence."""
    best = [[[] for _ in range(len(other) + 1)] for _ in range(len(one) + 1)]
    for i, a in enumerate(one):
        for j, b in enumerate(other):
            best[i + 1][j + 1] = ([*best[i][j], (i, j)] if same(a, b) else
                                  max(best[i][j + 1], best[i + 1][j], key=len))
    return best[-1][-1]
