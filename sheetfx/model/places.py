"""Where joints are on parts: named points, edges, curves and stretches of lines; and where both parts meet there."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from ..mesh.discs import Disc
from ..mesh.lines import Piece, Stretch, lines_of, places_of
from ..mesh.meeting import Meeting, at_points, merged, over_area
from ..mesh.projection import Cells, cells_at
from ..mesh.reader import NamedMesh
from ..mesh.whole import whole

Place = str | Stretch | Disc | Sequence[str | Stretch | Disc]  # on a part: a point, edge, group of curves, line, disc
Ends = tuple[NamedMesh, str | None]  # a mesh and a name on it; None: all
AlongLines = Callable[[Cells, Cells, Sequence[Sequence[Piece]], str], Meeting]  # parts, lines and title


def require_group(part, dimension: int = 1) -> None:
    """Refuse a part on a mesh of cells of another dimension than its own, or on a group that its mesh does not have."""
    mesh, title = part.mesh, type(part).__name__
    names = ", ".join(map(repr, mesh.cells))
    if mesh.domain.topology.dim > dimension:
        raise ValueError(f"{title}: its mesh is one of surfaces ({names}); give a mesh of curves: "
                         "read_mixed(..., bars=[...]).curves, where surfaces and curves are in one model")
    if mesh.domain.topology.dim < dimension:
        raise ValueError(f"{title}: its mesh is one of curves ({names}); give a mesh of surfaces, whose gmsh model has "
                         "groups of surfaces")
    if mesh.dimension < dimension + (dimension == 2):
        raise ValueError(f"{title}: its mesh ({names}) is one in the plane; read it in 3 dimensions")
    if part.group is not None:
        part.mesh.require(f"{type(part).__name__}: group is {part.group!r}", part.group, "group of cells")


def require_places(title: str, mesh: NamedMesh, places: Sequence[str | Stretch | None]) -> None:
    """Refuse names that nothing of a mesh has, and no place at all."""
    if not places:
        raise ValueError(f"{title}: at is empty; name a place")
    for at in places:
        if isinstance(at, str):
            mesh.require(title_of(title, at), at, "point", "edge", "group of cells")


def each_of(at: Place | None) -> list:
    """The single places of one or several; one None is everywhere."""
    return [at] if at is None or isinstance(at, (str, Stretch, Disc)) else list(at)


def title_of(name: str, at: str | Stretch | Disc | None) -> str:
    """What messages call a joint by its name and place; None: everywhere."""
    if at is None:
        return name
    if isinstance(at, Disc):
        return f"{name} over the disc at {at.at!r}"
    return f"{name} from {at.start!r}" if isinstance(at, Stretch) else f"{name} at {at!r}"


def meeting_of(mesh: NamedMesh, places: Sequence[str | Stretch | Disc], to: Ends, reach: float, name: str,
               along_lines: AlongLines) -> Meeting:
    """Points where two parts meet at some places.

    Parameters
    ----------
    mesh, places : of the first part; each process has all points, in cells of the whole meshes
    to : mesh of the second part, and the name of a point, an edge or a group of cells of it
    reach : distance of the parts that may be bridged
    name : of the joint, for messages
    along_lines : what chooses points where a place is a line

    Raises
    ------
    ValueError
        If a place is a surface, a line is joined to a point, or points are off a part.
    """
    mesh, to = whole(mesh), (whole(to[0]), to[1])
    second = Cells(to[0], cells_at(*to))
    return merged([_meeting_at(mesh, at, second, to, reach, title_of(name, at), along_lines) for at in places])


def _meeting_at(mesh: NamedMesh, at: str | Stretch | Disc, second: Cells, to: Ends, reach: float, title: str,
                along_lines: AlongLines) -> Meeting:
    other, there = to
    others = places_of(other, there) if there is not None and there in other.points else None
    if isinstance(at, Disc):
        part = Cells(mesh, cells_at(mesh, None))
        return over_area(part, second, *at.samples(part, title), others, reach, title)
    first = _cells_along(mesh, at)
    if isinstance(at, str) and at in mesh.points:
        return at_points(first, second, places_of(mesh, at), others, reach, title)
    if others is not None:
        raise ValueError(f"{title}: a line cannot be joined to the point {there!r}; name an edge or a group of cells")
    if isinstance(at, str) and mesh.domain.topology.dim == 2 and at not in mesh.edges:
        raise ValueError(f"{title}: is a surface; give an edge, or a Stretch of a line on it")
    lines = at.lines(mesh) if isinstance(at, Stretch) else lines_of(mesh, at)
    return along_lines(first, second, lines, title)


def _cells_along(mesh: NamedMesh, at: str | Stretch) -> Cells:
    """Cells of a mesh that a place is looked for on: those along an edge where it is one, or a stretch of one."""
    along = at.along if isinstance(at, Stretch) else at
    return Cells(mesh, cells_at(mesh, along if isinstance(along, str) else None))
