"""Points of parts that stand for a length of line, an area, or themselves."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import basix
import numpy as np

from .lines import Stretch, lines_of, places_of
from .projection import Cells, cells_at
from .quadrature import gauss, simplex
from .reader import NamedMesh


@dataclass(frozen=True)
class Samples:
    """Points of a part.

    Attributes
    ----------
    cells, reference : numbers of the mesh's cells, and reference points in these
    places : shape (n, dimension)
    weights : length or area that each stands for; 1 for single points
    extent : what that is the power of a length: 0, 1 or 2
    """

    cells: np.ndarray
    reference: np.ndarray
    places: np.ndarray
    weights: np.ndarray
    extent: int

    @property
    def size(self) -> float:
        """Of all that they stand for: a length; 0: of points."""
        return float(self.weights.sum()) ** (1 / self.extent) if self.extent else 0.0


def samples_at(mesh: NamedMesh, places: Sequence[str | Stretch | None], points: int, title: str) -> Samples:
    """Samples at several places, which are all points, all lines or all surfaces; see `samples_of`.

    Raises
    ------
    ValueError
        If places are of several kinds, naming `title`.
    """
    found = [samples_of(mesh, place, points) for place in places]
    if len({s.extent for s in found}) > 1:
        raise ValueError(f"{title}: its places are of several kinds; make a contact for points, one for lines and one "
                         "for surfaces")
    return merged(found)


def samples_of(mesh: NamedMesh, at: str | Stretch | None, points: int) -> Samples:
    """Gauss points of a named edge or point, a group of cells or a stretch of a line; None: of all cells.

    Parameters
    ----------
    points : number along each piece of a line, and along each side of a cell
    """
    if isinstance(at, str) and at in mesh.points:
        places = places_of(mesh, at)
        return _in_cells(mesh, at, places, np.ones(len(places)), 0)
    if isinstance(at, Stretch) or mesh.domain.topology.dim == 1 or at in mesh.edges:
        lines = at.lines(mesh) if isinstance(at, Stretch) else lines_of(mesh, at)
        rule = gauss(basix.CellType.interval, points)
        t, pieces = rule.points[:, 0], [piece for line in lines for piece in line]
        weights = [rule.weights * np.linalg.norm(piece.slopes(t), axis=1) for piece in pieces]
        return _in_cells(mesh, at, np.concatenate([p.places(t) for p in pieces]), np.concatenate(weights), 1)
    cells = Cells(mesh, mesh.group(at))
    triangles = cells.kind == basix.CellType.triangle
    rule = simplex(2 * points - 1) if triangles else gauss(cells.kind, points, points)
    which = np.repeat(np.arange(len(cells.cells)), len(rule.weights))
    reference = np.tile(rule.points, (len(cells.cells), 1))
    slopes = cells.derivatives(which, reference)
    areas = np.sqrt(np.linalg.det(np.einsum("nda,ndb->nab", slopes, slopes)))
    return Samples(cells.cells[which], reference, cells.places(which, reference),
                   np.tile(rule.weights, len(cells.cells)) * areas, 2)


def _in_cells(mesh: NamedMesh, at: str | Stretch | None, places: np.ndarray, weights: np.ndarray,
              extent: int) -> Samples:
    along = at.along if isinstance(at, Stretch) else at
    cells = Cells(mesh, cells_at(mesh, along if isinstance(along, str) else None))
    which, reference, _ = cells.closest(places)
    return Samples(cells.cells[which], reference, places, weights, extent)


def merged(samples: Sequence[Samples]) -> Samples:
    """Points at several places of one part."""
    arrays = (np.concatenate([getattr(s, name) for s in samples])
              for name in ("cells", "reference", "places", "weights"))
    return Samples(*arrays, samples[0].extent)
