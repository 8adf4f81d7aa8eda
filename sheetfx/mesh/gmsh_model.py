"""The gmsh model that meshes are made of: meshed or read from a file, with its groups by name, and checked."""

from __future__ import annotations

import re
import subprocess
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from mpi4py import MPI
from scipy.sparse import coo_array, triu

from ..compat import gmsh_cells
from ..notices import warn
from .cells import KINDS, Cells
from .files import SUFFIXES, model_parts
from .groups import DIMENSIONS, ORDERS, cells_of, name_of
from .quality import bad_cells, refuse
from .raised import raise_order

Source = Callable[[], None] | str | Path

CURVED = 2  # order of cells that the geometry or a place bends, the degree of shells and beams by default
STRAIGHT = 1e-9  # distance of a middle from between its ends, over the size of the structure, that is rounding
NAMELESS = "Open CASCADE"  # what OpenCASCADE calls what has no name
GEOMETRIES = ".step", ".stp", ".brep", ".iges", ".igs", ".geo"
CONVERTED = ".unv", ".bdf", ".nas"  # meshes that gmsh reads, but for groups of nodes
CONVERT = """
import sys
import gmsh
gmsh.initialize(interruptible=False)
gmsh.option.setNumber("General.Terminal", 0)
gmsh.open(sys.argv[1])
for dimension, word in ((1, "curve"), (2, "surface")):
    if not gmsh.model.getPhysicalGroups(dimension):
        for _, tag in gmsh.model.getEntities(dimension):
            gmsh.model.addPhysicalGroup(dimension, [tag], name=f"{word} {tag}")
gmsh.write(sys.argv[2])
"""
FILE = re.compile(rb"^\$(MeshFormat|NOD|PTS)", re.MULTILINE)  # of versions 2 to 4, and 1


@dataclass
class Model:
    """What all processes know of a gmsh model.

    Attributes
    ----------
    what : name of the model, for messages
    x : places of its nodes in space; those without cells are not numbers
    curves : Cells
    kinds : of surfaces, of each kind; triangles first
    points : name -> nodes
    said : what was done to its cells, for a warning; empty where nothing was
    identity : tells meshes of this model from other models', on one process
    """

    what: str
    x: np.ndarray
    curves: Cells
    kinds: list[Cells]
    points: dict[str, np.ndarray]
    said: str = ""
    identity: object = field(default_factory=object)

    @property
    def surfaces(self) -> Cells:
        """Where they are of one kind."""
        return self.kinds[0]

    def points_on(self, cells: Cells) -> dict[str, np.ndarray]:
        """Named points that are corners of cells."""
        corners = np.unique(cells.corners())
        return {name: found for name, nodes in self.points.items() if len(found := np.intersect1d(nodes, corners))}

    def require_points_on(self, *cells: Cells) -> None:
        """Refuse named points that no cell has for a corner."""
        if lost := sorted(self.points.keys() - {name for c in cells for name in self.points_on(c)}):
            raise ValueError(f"{self.what}: the point {lost[0]!r} is on no cell of a named group; add its curve or "
                             "surface to a group, or remove the name")

    def require_edges(self) -> None:
        """Refuse named curves that are not on edges of surfaces."""
        for name in self.curves.groups:
            if not self.on_edges(name).all():
                raise ValueError(f"{self.what}: the curves {name!r} are not on edges of surfaces; read both with "
                                 f"read_mixed(..., bars=[{name!r}])")

    def on_edges(self, name: str) -> np.ndarray:
        """Whether each cell of a group of curves is an edge of a surface."""
        return np.isin(self.pairs(self.curves.corners(self.curves.groups[name])), self.edges())

    def edges(self) -> np.ndarray:
        """A number for each edge of the cells of surfaces, cell by cell."""
        return np.concatenate([self.pairs(cells.sides()) for cells in self.kinds])

    def pairs(self, nodes: np.ndarray) -> np.ndarray:
        """A number for each pair of nodes, whatever its order."""
        return np.sort(nodes, axis=1) @ np.array([len(self.x), 1])


def read_model(source: Source, who: str, order: int | None, place: Callable | None, comm: MPI.Comm,
               several: bool = False, size: float | None = None, halvings: int = 0) -> Model:
    """What there is to know of the gmsh model of a source; what goes wrong on process 0 is raised on all.

    Parameters
    ----------
    source : function without arguments that fills the gmsh model and names physical groups, or path of a .msh file
    who : reads it, for messages
    order : of the geometry; None: see `read`
    place : function from coordinates of nodes to those in space; None: the same
    several : whether surfaces may have triangles and quadrilaterals
    size : largest of the cells that gmsh makes
    halvings : number of times that these are then divided in two along each side
    """
    what = who if callable(source) else f"{who} {str(source)!r}"
    if order not in (None, *ORDERS):
        raise ValueError(f"{what}: order is {order}; it must be one of {', '.join(map(str, ORDERS))}")
    model = error = None
    if comm.rank == 0:
        try:
            model = _model(source, what, order, place, several, size, halvings)
        except Exception as raised:  # other processes wait to be told
            error = raised
    model, error = comm.bcast((model, error), root=0)
    if error is not None:
        raise error
    if model.said and not comm.rank:
        warn(model.said)
    return model


def _model(source: Source, what: str, order: int | None, place: Callable | None, several: bool,
           size: float | None, halvings: int) -> Model:
    other = not callable(source) and Path(source).suffix.lower() in SUFFIXES
    if halvings and (other or not (callable(source) or is_geometry(source) or place)):
        raise ValueError(f"{what}: halvings is {halvings}, but a file of cells does not tell the lines and surfaces "
                         "that they are on; make its cells smaller where they come from")
    if other:
        return _raised(_of_file(Path(source), what, place, several), order, place is not None, known=False)
    import gmsh

    gmsh.initialize(interruptible=False)
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        _fill(gmsh, source, what, size)
        for _ in range(halvings):
            gmsh.model.mesh.refine()
        if gmsh.model.getNumberOfPartitions():
            gmsh.model.mesh.unpartition()
        known = _curve(gmsh.model, what, order, place, several)
        (curves,), surfaces = (cells_of(gmsh.model, dimension, what, several) for dimension in (1, 2))
        points = {name_of(gmsh.model, 0, tag): gmsh.model.mesh.getNodesForPhysicalGroup(0, tag)[0].astype(np.int64) - 1
                  for _, tag in gmsh.model.getPhysicalGroups(0)}
        used = np.concatenate([nodes.ravel() for cells in (curves, *surfaces) for nodes in cells.nodes.values()])
        x = _places(gmsh.model, np.unique(used), what, place)
    finally:
        gmsh.finalize()
    return _raised(Model(what, x, curves, surfaces, points), order, place is not None, known)


def _raised(model: Model, order: int | None, placed: bool, known: bool) -> Model:
    """A model that is checked, and raised to a higher order where its geometry is not known."""
    check_model(model, placed)
    if known or order == 1 or not (found := raise_order(model.x, model.kinds, model.curves, order)):
        return model
    said = "; ".join(filter(None, (model.said, found.said and f"{model.what}: {found.said}")))
    return Model(model.what, found.x, found.curves, found.surfaces, model.points, said)


def _of_file(file: Path, what: str, place: Callable | None, several: bool) -> Model:
    """The model of a file of another program."""
    _require_file(file, what)
    x, curves, surfaces, points, said = model_parts(file, what)
    if len(surfaces) > 1 and not several:
        raise ValueError(f"{what}: mixed kinds of cells, triangles and quadrilaterals; read both with read_kinds")
    return Model(what, x if place is None else np.asarray(place(x), dtype=float), curves, surfaces, points,
                 said and f"{what}: {said}")


def _require_file(file: Path, what: str) -> None:
    if not file.is_file():
        raise ValueError(f"{what}: there is no such file in {file.parent.resolve()}; give the path of a .msh file")


def _curve(model, what: str, order: int | None, place: Callable | None, several: bool) -> bool:
    """Give cells the order that is asked for where gmsh or the place know how they are curved; whether they do."""
    curves, surfaces = (cells_of(model, dimension, what, several) for dimension in (1, 2))
    used = [cells for cells in (*surfaces, *curves) if cells.nodes]
    if not used:
        raise ValueError(f"{what}: no named curve or surface has cells; mesh the model, and save it in version 4.1")
    straight = all(cells.straight for cells in used)
    placed = straight and place is not None and _bends(model, used, place)
    known = placed or not (straight and surfaces[0].nodes and _is_discrete(model))
    if order and known:
        model.mesh.setOrder(order)
    elif placed:
        model.mesh.setOrder(CURVED)
        model.mesh.renumberNodes()
    elif straight and known and surfaces[0].nodes:
        model.mesh.setOrder(CURVED)
        if not any(_is_curved(model, cells) for cells in cells_of(model, 2, what, several)):
            model.mesh.setOrder(1)
    return known


def _is_discrete(model) -> bool:
    """Whether some surface of a group is known by its mesh alone, as in files."""
    entities = {int(e) for _, tag in model.getPhysicalGroups(2) for e in model.getEntitiesForPhysicalGroup(2, tag)}
    return any(model.getType(2, entity).startswith("Discrete") for entity in entities)


def _fill(gmsh, source: Source, what: str, size: float | None) -> None:
    """Mesh what a function builds or a file of geometry holds, or open a file with a mesh."""
    if size is not None:
        gmsh.option.setNumber("Mesh.MeshSizeMax", size)
    if callable(source):
        gmsh.model.add("model")
        source()
        _check_groups(gmsh.model, what)
        gmsh.model.mesh.generate(max(d for d, _ in gmsh.model.getPhysicalGroups()))
        return
    file = Path(source)
    _require_file(file, what)
    if is_geometry(file):
        _mesh_geometry(gmsh, file, what)
        return
    if file.suffix.lower() in CONVERTED:
        with TemporaryDirectory() as folder:
            _fill(gmsh, _converted(file, Path(folder), what), what, None)
        return
    if not FILE.search(file.read_bytes()[:10000]):
        raise ValueError(f"{what}: the file is none of gmsh's; save the mesh from gmsh as .msh")
    try:
        gmsh.open(str(file))
    except Exception as error:
        raise ValueError(f"{what}: gmsh cannot read the file ({error}); save the mesh from gmsh again") from error
    _check_groups(gmsh.model, what)
    for entity in gmsh.model.getEntities():  # versions 1 and 2 save a cell once for each group that it is in
        gmsh.model.mesh.removeDuplicateElements([entity])
    gmsh.model.mesh.renumberNodes()


def _converted(file: Path, folder: Path, what: str) -> Path:
    """A file that gmsh reads as .msh, made by a process of its own, since some such files end it.

    What has no group is one by its dimension and number.
    """
    made = folder / "converted.msh"
    done = subprocess.run([sys.executable, "-c", CONVERT, str(file), str(made)], capture_output=True, text=True)
    if done.returncode or not made.is_file():
        said = (done.stderr.strip().splitlines() or ["it ends without a word"])[-1]
        raise ValueError(f"{what}: gmsh cannot read the file ({said}); save the mesh as .msh, .inp or .med")
    return made


def is_geometry(source: Source) -> bool:
    """Whether a source is a file of geometry, which gmsh meshes."""
    return not callable(source) and Path(source).suffix.lower() in GEOMETRIES


def _mesh_geometry(gmsh, file: Path, what: str) -> None:
    """Mesh the surfaces, or the curves, of a file of geometry; what has no group is one by its name or number."""
    try:
        gmsh.open(str(file))
    except Exception as error:
        raise ValueError(f"{what}: gmsh cannot read the file ({error}); export it again, as STEP or BREP") from error
    model = gmsh.model
    if model.getEntities(3):
        raise ValueError(f"{what}: has {len(model.getEntities(3))} volumes; export the surfaces of a shell model, not "
                         "its solid")
    top = 2 if model.getEntities(2) else 1
    for dimension in range(top + 1):
        if model.getPhysicalGroups(dimension):
            continue
        entities = [tag for _, tag in model.getEntities(dimension)]
        names = [model.getEntityName(dimension, tag).rsplit("/", 1)[-1] for tag in entities]
        for tag, name in zip(entities, names, strict=True):
            named = name and names.count(name) == 1 and not name.startswith(NAMELESS)
            model.addPhysicalGroup(dimension, [tag], name=name if named else f"{DIMENSIONS[dimension][:-1]} {tag}")
    _check_groups(model, what)
    model.mesh.generate(top)


def _check_groups(model, what: str) -> None:
    """Refuse groups that are not of curves, surfaces and points, and beside surfaces those with one name.

    A bar may have the name of a point: where there are no surfaces, curves are not looked up with points.
    """
    groups = model.getPhysicalGroups()
    dimensions = {d for d, _ in groups}
    if not dimensions & {1, 2}:
        raise ValueError(f"{what}: no physical group of curves or surfaces; name those that belong to the structure "
                         "(gmsh.model.addPhysicalGroup, or Physical Curve and Physical Surface in a .geo file), and "
                         "save without Mesh.SaveAll")
    if 3 in dimensions:
        volumes = next(name_of(model, *group) for group in groups if group[0] == 3)
        raise ValueError(f"{what}: the group {volumes!r} is one of volumes; only curves and surfaces can be read")
    known: dict[str, int] = {}
    for d, tag in groups:
        name = name_of(model, d, tag)
        if known.setdefault(name, d) != d and 2 in dimensions:
            raise ValueError(f"{what}: the group {name!r} is one of {DIMENSIONS[known[name]]} and of {DIMENSIONS[d]}; "
                             "give each its own name")


def _bends(model, used: Sequence[Cells], place: Callable) -> bool:
    """Whether a function bends straight cells: middles of their edges do not come to lie between the ends of these."""
    x = _table(model)
    ends = np.concatenate([cells.sides() for cells in used])
    ends = x[np.unique(np.sort(ends, axis=1), axis=0)]
    placed, middles = [np.asarray(place(ends[:, i]), dtype=float) for i in (0, 1)], place(ends.mean(axis=1))
    return _off(middles, *placed)


def _is_curved(model, cells: Cells) -> bool:
    """Whether middles of edges of cells of second order lie beside the chords'."""
    x, corners = _table(model), KINDS[cells.kind][1]
    return _off(x[cells.table()[:, corners:2 * corners].ravel()], *np.moveaxis(x[cells.sides()], 1, 0))


def _off(middles: np.ndarray, begin: np.ndarray, end: np.ndarray) -> bool:
    return bool((np.abs(middles - (begin + end) / 2) > STRAIGHT * np.linalg.norm(np.ptp(begin, axis=0))).any())


def _table(model) -> np.ndarray:
    """Places of the nodes of a gmsh model by their numbers, which count from 0."""
    numbers, x, _ = model.mesh.getNodes()
    table = np.full((int(numbers.max()), 3), np.nan)
    table[numbers.astype(np.int64) - 1] = x.reshape(-1, 3)
    return table


def _places(model, used: np.ndarray, what: str, place: Callable | None) -> np.ndarray:
    """Places of nodes in space, computed once for all meshes that are made of the model."""
    table = _table(model)
    placed = np.full_like(table, np.nan)
    placed[used] = table[used] if place is None else place(table[used])
    finite = np.isfinite(placed[used]).all(axis=1)
    if not finite.all():
        raise ValueError(f"{what}: place gives no finite coordinates for {table[used][~finite][0]}; correct the "
                         "function")
    return placed


def check_model(model: Model, placed: bool) -> None:
    """Refuse cells that no structure can have; `placed` by a function, which the remedy names."""
    _check_cells(model, placed)
    _check_doubles(model)


def _check_cells(model: Model, placed: bool) -> None:
    """Refuse cells without extent, concave ones and those that are folded over."""
    extent = float(np.linalg.norm(np.nanmax(model.x, axis=0) - np.nanmin(model.x, axis=0)))
    remedy = ("correct place, or mesh the group in other cells" if placed else
              "mesh the group with another size of cells or algorithm (Mesh.Algorithm, Mesh.RecombinationAlgorithm)")
    found = []
    for cells in (model.curves, *model.kinds):
        if cells.nodes:
            element, nodes = gmsh_cells(cells.kind, cells.table())
            source = cells.source()
            groups = {name: np.flatnonzero(np.isin(source, on)) for name, on in cells.groups.items()}
            found += bad_cells(element, model.x[nodes], groups, extent)
    refuse(model.what, found, remedy)


def _check_doubles(model: Model) -> None:
    """Refuse cells that share two facets: they lie on each other or nearly so, and DOLFINx 0.9 breaks down on them."""
    for kinds, facets in (([model.curves], "both ends"), (model.kinds, "two edges")):
        if not kinds[0].nodes:
            continue
        of_kinds = [cells.corners() for cells in kinds]
        source, owner = np.concatenate([cells.source() for cells in kinds]), np.concatenate(
            [np.full(len(corners), corners.shape[1]) for corners in of_kinds])
        owner = np.repeat(np.arange(len(owner)), owner)
        sides = of_kinds[0].ravel() if kinds[0] is model.curves else model.edges()
        number = np.unique(sides, return_inverse=True)[1].ravel()
        holds = coo_array((np.ones(len(number)), (owner, number))).tocsr()
        meets = triu(holds @ holds.T, 1).tocoo()
        for one, other in zip(meets.row[meets.data > 1], meets.col[meets.data > 1], strict=True):
            names = (next(n for cells in kinds for n, on in cells.groups.items() if source[c] in on)
                     for c in (one, other))
            raise ValueError(f"{model.what}: cells of the groups {' and '.join(map(repr, names))} share {facets} at "
                             f"{_middle(model.x, of_kinds, one)}; remove what stands twice, or mesh it with "
                             "more cells")


def _middle(x: np.ndarray, corners: list[np.ndarray], cell: int) -> np.ndarray:
    """Mean place of the corners of a cell, which counts through all kinds."""
    nodes = [row for table in corners for row in table]
    return x[nodes[cell]].mean(axis=0)
