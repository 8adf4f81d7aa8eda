"""Imperfect structures: meshes with moved nodes, and scenes on them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any, cast

import numpy as np
from mpi4py import MPI
from scipy.spatial import cKDTree

from ..checks import checked
from ..discrete.discretisation import Discretisation
from ..discrete.fields import SAME_PLACE
from ..mesh import imperfection
from ..mesh.imperfection import Shape, at_places, geometry_nodes_at, given_shapes, moved_together
from ..mesh.lines import Stretch, Vector, lines_of
from ..mesh.mixed import MixedMesh
from ..mesh.projection import Cells
from ..mesh.reader import NamedMesh
from ..model.joints import Compatible
from ..model.obstacles import way_of
from ..model.places import each_of
from ..model.scene import Scene
from .modes import mode_on
from .remade import Remade

PLACES = "centre", "point"  # attributes of obstacles that tell where they start


@checked
def imperfect(mesh: NamedMesh | MixedMesh | Scene, displacement: Any,
              amplitude: float | Sequence[float] = 1.0) -> NamedMesh | MixedMesh | Scene:
    """A structure like another with all nodes moved by `amplitude` times a displacement; the given one keeps its shape.

    Parameters
    ----------
    mesh : a mesh, see `mesh.imperfection.imperfect`; a MixedMesh or a Scene is moved whole: nodes that are one in gmsh,
        or by `Compatible`, stay one, and bars on surfaces move with these. A new scene is made of new parts, supports,
        loads, joints, contacts and monitor on the moved meshes; obstacles stay where they are
    displacement : Function on a mesh (such as `mode_displacement` gives), or a function from coordinates, shape (n, 3),
        to displacements, shape (n, 3) or (n, 2) in the plane, or to deviations along the unit normal of a surface or
        plane curve, shape (n,); of a scene also a mode of a path of it: a BucklingLoad, Vibration, Branch, or array of
        increments; or a sequence of these
    amplitude : factor, a length where the largest displacement is 1; a sequence has a factor for each displacement

    Raises
    ------
    ValueError
        If there is not one amplitude for each displacement, a displacement has another shape or is on another mesh, a
        mode is one of another scene, there is no normal for deviations along it, or a cell is folded over or has no
        extent.
    """
    if not isinstance(mesh, Scene):
        return imperfection.imperfect(mesh, displacement, amplitude)
    given = given_shapes(displacement, amplitude)
    shapes = shapes_on(mesh, [one for one, _ in given])
    return _Moved(mesh, [(shape, factor) for found, (_, factor) in zip(shapes, given, strict=True)
                         for shape in found]).of(mesh)


def shapes_on(scene: Scene, displacements: Sequence[Any]) -> list[list[Shape]]:
    """Displacements as they are; of a mode one on each mesh.

    Raises
    ------
    ValueError
        If a mode is one of another scene.
    """
    modes = [getattr(one, "mode", one) for one in displacements]
    if not any(isinstance(mode, np.ndarray) for mode in modes):
        return [[one] for one in displacements]
    discretisation = Discretisation(scene)
    size = discretisation.layout.size
    if other := [len(mode) for mode in modes if isinstance(mode, np.ndarray) and len(mode) != size]:
        raise ValueError(f"imperfect: the mode has {other[0]} increments and the scene {size}; give a mode of a path "
                         "of this scene")
    return [[mode_on(discretisation, mesh, mode) for mesh in scene.meshes] if isinstance(mode, np.ndarray) else [mode]
            for mode in modes]


class _Moved(Remade):
    """A scene on moved meshes: all that is on one of them is made again, once."""

    def __init__(self, scene: Scene, given: Sequence[tuple[Shape, float]]):
        places = moved_together(scene.meshes, given, list(_common(scene)))
        self._way = scene.meshes[0].comm.allreduce(max(
            float(np.linalg.norm(x - m.domain.geometry.x[:, :m.dimension], axis=1).max(initial=0.0))
            for m, x in zip(scene.meshes, places, strict=True)), op=MPI.MAX)
        new: dict[int, Any] = {id(m): at_places(m, x) for m, x in zip(scene.meshes, places, strict=True)}
        super().__init__(new | {id(one): self._back(one) for one in self._free(scene)})

    def _free(self, scene: Scene) -> list[Any]:
        """Obstacles that travel freely, which start where they first touch."""
        found = [getattr(contact, "obstacle", None) for contact in scene.contacts]
        return [one for one in found if one is not None and one.travel is not None]

    def _back(self, obstacle: Any) -> Any:
        """An obstacle so far back along its travel that it does not start inside of what has moved."""
        if not (at := next((name for name in PLACES if hasattr(obstacle, name)), None)):
            return obstacle
        return replace(obstacle, **{at: tuple((getattr(obstacle, at) - 2 * self._way * way_of(obstacle)).tolist())})

    def changes(self, one: Any) -> dict[str, Any]:
        """Of a joint the stretches on its moved mesh, and a reach over what has moved."""
        if not isinstance(getattr(one, "mesh", None), NamedMesh):
            return {}
        at, changed = getattr(one, "at", None), {}
        if not (at is None or isinstance(at, str)):
            moved = [self._stretch(one.mesh, a) if isinstance(a, Stretch) else a for a in each_of(at)]
            changed["at"] = moved[0] if isinstance(at, Stretch) else moved
        if hasattr(one, "reach"):
            changed["reach"] = one.reach + 2 * self._way
        return changed

    def _stretch(self, mesh: NamedMesh, stretch: Stretch) -> Stretch:
        """A stretch that goes along with the mesh it is on."""
        def moved(at: str | Vector) -> str | Vector:
            return at if isinstance(at, str) else self._place(mesh, at)

        start, end = moved(stretch.start), None if stretch.end is None else moved(stretch.end)
        length = stretch.length
        if length and isinstance(stretch.along, str):
            before, after = (sum(p.length() for line in lines_of(m, stretch.along) for p in line)
                             for m in (mesh, self._new[id(mesh)]))
            length *= after / before
        return replace(stretch, start=start, end=end, length=length)

    def _place(self, mesh: NamedMesh, at: Sequence[float]) -> Vector:
        """Where a place on or beside a mesh is once that has moved."""
        cells, x = Cells(mesh, mesh.group(None)), np.array([at], dtype=float)
        which, reference, _ = cells.closest(x)
        way = Cells(self._new[id(mesh)], cells.cells).places(which, reference) - cells.places(which, reference)
        return cast(Vector, tuple((x + way)[0].tolist()))


def _common(scene: Scene) -> Iterator[tuple[int, int, np.ndarray]]:
    """Numbers of meshes of which nodes of the first are nodes of the second, and pairs of these; surfaces first.

    These are nodes that are one in the gmsh model of both, and those that `Compatible` makes one.
    """
    meshes = sorted(range(len(scene.meshes)), key=lambda n: -scene.meshes[n].domain.topology.dim)
    for place, own in enumerate(meshes):
        for of in meshes[:place]:
            one, other = scene.meshes[own], scene.meshes[of]
            pairs = [np.empty((0, 2), dtype=np.int64)]
            if one.model is not None and one.model is other.model:
                pairs.append(MixedMesh(other, one).shared_nodes())
            for joint in scene.joints:
                if isinstance(joint, Compatible) and {joint.mesh, joint.to} == {one, other}:
                    pairs.append(_at_one_place(joint, one, other))
            yield own, of, np.concatenate(pairs)


def _at_one_place(joint: Compatible, one: NamedMesh, other: NamedMesh) -> np.ndarray:
    """Pairs of geometry nodes on this process that stand at one place where a joint shares nodes."""
    nodes = [geometry_nodes_at(m, joint.at if m is joint.mesh else None) for m in (one, other)]
    x, y = (m.domain.geometry.x[n] for m, n in zip((one, other), nodes, strict=True))
    if not len(x) or not len(y):
        return np.empty((0, 2), dtype=np.int64)
    distance, nearest = cKDTree(y).query(x)
    found = distance <= SAME_PLACE * max(one.size, other.size)
    return np.column_stack((nodes[0][found], nodes[1][nearest[found]]))
