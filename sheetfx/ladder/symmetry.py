"""Whether a structure cut by planes of symmetry buckles across them before its first critical point.

The tangent of the part at a symmetric state, with the supports of the other symmetry on a plane, belongs to the modes
of the whole which the plane turns into their negatives (Healey 1988, A group-theoretic approach to computational
bifurcation problems with symmetry).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np
from petsc4py import PETSc

from ..continuation.linear import DirectSolver, SingularTangent
from ..continuation.spectrum import diagonal, nearest_to_zero
from ..continuation.state import State
from ..discrete.discretisation import Discretisation
from ..discrete.free_motions import usual_stiffness
from ..discrete.number import NumberField
from ..events.event import Event
from ..mesh.reader import COMPONENTS
from ..mesh.tagged import nodes_of_vertices
from ..model.scene import Scene
from ..model.supports import Support, Symmetry
from .unsupported import rows_that_hold


@dataclass(frozen=True)
class Across:
    """Modes that some planes of symmetry turn into their negatives.

    Attributes
    ----------
    name : what decisions call them
    scene : the part with supports of these modes on the planes
    """

    name: str
    scene: Scene


def planes(scene: Scene) -> list[list[Support]]:
    """Supports on each plane of symmetry that cuts the structure.

    Supports of `fx.symmetry`; where the symmetry factor needs more, also others that hold the displacement along the
    normal of a plane and both rotations in it, and nothing else.
    """
    declared = _by_plane(scene, [one for one in scene.supports if isinstance(one, Symmetry)])
    alike = _by_plane(scene, scene.supports)
    return alike if 2 ** len(declared) < scene.symmetry_factor == 2 ** len(alike) else declared


def _by_plane(scene: Scene, supports: Sequence[Support]) -> list[list[Support]]:
    found: dict[tuple, list[Support]] = {}
    for support in supports:
        if (normal := _plane(scene, support)) is not None:
            found.setdefault(normal, []).append(support)
    return list(found.values())


def _plane(scene: Scene, support: Support) -> tuple[float, ...] | None:
    """Normal and distance from the origin of the plane that a support stands for; None: it is of another kind."""
    held = set(support.fixed.split())
    if callable(support.axes):
        return None
    for number, axis in enumerate("xyz"[:support.mesh.dimension]):
        turns = {c for c in COMPONENTS[support.mesh.dimension] if c.startswith("r") and c != f"r{axis}"}
        if held - {axis} == (turns if _turns(scene, support) else set()) and axis in held:
            normal = np.eye(3)[number] if support.axes is None else np.asarray(support.axes)[number]
            normal = normal * np.sign(normal[np.abs(normal).argmax()])
            places = support.mesh.domain.geometry.x[nodes_of_vertices(support.mesh.domain)[
                support.mesh.vertices(support.at)]] @ normal
            return (*(np.round([*normal, _mean(support, places) / support.mesh.size], 6) + 0.0).tolist(),)
    return None


def _turns(scene: Scene, support: Support) -> bool:
    return any(part.mesh is support.mesh and part.spaces[1] is not None for part in scene.parts)


def _mean(support: Support, places: np.ndarray) -> float:
    total, count = support.mesh.comm.allreduce(np.array([places.sum(), len(places)]))
    return float(total / max(count, 1))


def across(scene: Scene) -> Iterator[Across]:
    """The modes across each choice of planes."""
    known = planes(scene)
    for count in range(1, len(known) + 1):
        for chosen in combinations(known, count):
            turned = {id(one): _other(scene, one) for plane in chosen for one in plane}
            supports = [turned.get(id(one), one) for one in scene.supports]
            names = " and ".join(", ".join(one.at for one in plane) for plane in chosen)
            yield Across(names, replace(scene, supports=supports))


def _other(scene: Scene, support: Support) -> Support:
    """The support of the other symmetry: what was free is held, and what was held is free."""
    known = [c for c in COMPONENTS[support.mesh.dimension] if _turns(scene, support) or not c.startswith("r")]
    free = " ".join(c for c in known if c not in support.fixed.split())
    return Support(support.mesh, support.at, free, support.axes)


class Asymmetric:
    """Eigenvalue of the tangent nearest to zero for modes across planes of symmetry: a negative one where there is one.

    Obstacles that travel are part of the symmetric structure, and stand still in these modes. What can move freely
    across the planes is held where that strains nothing.

    Raises
    ------
    ValueError
        If the part is a mechanism for these modes.
    """

    def __init__(self, modes: Across):
        self.name, self._home = f"mode across {modes.name}", Discretisation(modes.scene)
        system = self._home.system
        self._still, first = system.create_vector(), system.matrix.getOwnershipRange()[0]
        travels = system.free_rows(lambda field: isinstance(field, NumberField) and not field.multiplier)
        self._held = (first + travels).astype(PETSc.IntType)
        system.extrapolate_stress()
        self._held = np.concatenate((self._held, rows_that_hold(self._home, system.tangent())))
        pattern = system.create_vector(np.cos(np.arange(self._still.local_size)))
        pattern.array[system.multiplier_rows] = 0
        try:
            self._factored().check(pattern, usual_stiffness(self._home))
        except SingularTangent:
            raise ValueError(f"the part is a mechanism across {modes.name}") from None

    def __call__(self, state: State) -> float:
        system = self._home.system
        system.restore(dict(state.fields))
        system.configure(self._still, state.factor)
        solver = self._factored()
        unstable, asked = (solver.negative_pivots() or 0) > system.multipliers, 1
        while True:
            values = nearest_to_zero(solver, diagonal(system.weights), asked)[0]
            if found := [value for value in values if (value < 0) == unstable]:
                return min(found, key=abs)
            asked *= 2

    def _factored(self) -> DirectSolver:
        system = self._home.system
        system.extrapolate_stress()
        tangent = system.tangent().copy()
        tangent.setOption(PETSc.Mat.Option.KEEP_NONZERO_PATTERN, True)
        stiffest = tangent.getDiagonal()
        stiffest.abs()
        tangent.zeroRowsColumns(self._held, stiffest.max()[1])
        solver = DirectSolver(PETSc.KSP().create(system.comm), tangent, system.conservative)
        solver.factorise()
        return solver

    @property
    def event(self) -> Event:
        """Where the first of these modes becomes unstable."""
        return Event(self.name, self, way=-1)
