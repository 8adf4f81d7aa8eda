"""Places on deformed surfaces, for pictures of states, modes and whatever else moves them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
import ufl

from ..jit import compiled_expression
from ..mesh.reader import NamedMesh
from ..model.shell import TRIANGLE
from .evaluate import communicator
from .shown import Shown

PIECES = 4


@dataclass
class Surface:
    """Places on all surfaces, several to each cell so that curved cells look curved.

    Attributes
    ----------
    undeformed, current : (n, 3)
    faces : (m, 3), triangles by the numbers of their places
    borders : (c, p), places around each cell
    values : (n,), what the surface is coloured by; None: the size of the displacement
    """

    undeformed: np.ndarray
    current: np.ndarray
    faces: np.ndarray
    borders: np.ndarray
    values: np.ndarray | None = None

    @property
    def colours(self) -> np.ndarray:
        """Numbers at the places that are drawn as colours."""
        return np.linalg.norm(self.current - self.undeformed, axis=1) if self.values is None else self.values

    def mesh(self, places: np.ndarray):
        """A pyvista mesh of places of this surface, common places of cells merged, with displacement and colours."""
        import pyvista

        triangles = np.column_stack([np.full(len(self.faces), 3), self.faces]).ravel()
        mesh = pyvista.PolyData(places, triangles)
        mesh["displacement"], mesh["colours"] = self.current - self.undeformed, self.colours
        return mesh.clean(tolerance=1e-7)

    def edges(self, places: np.ndarray):
        """A pyvista mesh of the borders of cells."""
        import pyvista

        lines = np.column_stack([np.full(len(self.borders), self.borders.shape[1]), self.borders]).ravel()
        return pyvista.PolyData(places, lines=lines)


def surfaces(record: Shown, displacements: Mapping[NamedMesh, object] | None = None,
             values: Callable[[NamedMesh, np.ndarray], np.ndarray] | None = None) -> list[Surface] | None:
    """The surfaces of all meshes with the current fields, on process 0; None elsewhere.

    Parameters
    ----------
    displacements : for each mesh a displacement to use instead of the current one (Function or UFL vector)
    values : function of a mesh and points of the reference cell, with what its cells are coloured by, (cells, points)
    """
    comm, found = communicator(record), []
    for mesh in _surface_models(record):
        u = displacements[mesh] if displacements else record.path.discretisation.kinematics(mesh).u
        points, faces, border = _lattice(mesh.domain.basix_cell() == TRIANGLE)
        x = ufl.SpatialCoordinate(mesh.domain)
        expression = compiled_expression(ufl.as_vector([*x, *(x + u)]), points)
        gathered = comm.gather(expression.eval(mesh.domain, mesh.group(None)).reshape(-1, len(points), 2, 3))
        colours = None if values is None else comm.gather(values(mesh, points))
        if gathered is not None:
            table = np.concatenate(gathered)
            first = len(points) * np.arange(len(table))[:, None]
            undeformed, current = table.reshape(-1, 2, 3).transpose(1, 0, 2)
            found.append(Surface(undeformed, current, (first[:, :, None] + faces).reshape(-1, 3), first + border,
                                 None if colours is None else np.concatenate(colours).ravel()))
    return found if comm.rank == 0 else None


def has_surfaces(record: Shown) -> bool:
    return bool(_surface_models(record))


def _surface_models(record: Shown) -> list[NamedMesh]:
    return [m for m in record.case.scene.meshes if m.domain.topology.dim == 2]


def _lattice(triangle: bool) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Points on a reference cell, triangles between them, and the points around the cell."""
    grid = [(i, j) for j in range(PIECES + 1) for i in range(PIECES + 1 - j * triangle)]
    number = {place: n for n, place in enumerate(grid)}
    faces = []
    for i, j in grid:
        right, above, opposite = (i + 1, j), (i, j + 1), (i + 1, j + 1)
        if right in number and above in number:
            faces.append((number[i, j], number[right], number[above]))
            if opposite in number:
                faces.append((number[right], number[opposite], number[above]))
    line = range(PIECES)
    corners = [(0, 0), (PIECES, 0), (0, PIECES)] if triangle else [(0, 0), (PIECES, 0), (PIECES, PIECES), (0, PIECES)]
    around = []
    for (i, j), (k, m) in zip(corners, [*corners[1:], corners[0]], strict=True):
        around += [number[i + (k - i) * s // PIECES, j + (m - j) * s // PIECES] for s in line]
    return np.array(grid) / PIECES, np.array(faces), np.array([*around, around[0]])
