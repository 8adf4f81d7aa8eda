"""From a gmsh model with named physical groups to a mesh that knows its groups by name."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Annotated

import numpy as np
import ufl
from dolfinx import fem
from dolfinx.mesh import Mesh, MeshTags, exterior_facet_indices
from mpi4py import MPI

from ..checks import NOT_NEGATIVE, Choice, Positive, checked, require_components
from ..communicators import lasting
from ..compat import geometry_degree, geometry_nodes, gmsh_mesh
from ..notices import warn
from .cells import Cells
from .gmsh_model import Model, Source, is_geometry, read_model
from .orientation import Alike, run_alike
from .partition import keep_junctions_whole
from .tagged import Names, model_of, nodes_of_vertices

ROUNDING = 1e-6  # place out of a plane, over the size of the structure, by which drawings are off
COMPONENTS = {2: ("x", "y", "rz"), 3: ("x", "y", "z", "rx", "ry", "rz")}  # of displacement and rotation, by dimension


@dataclass(frozen=True)
class Reading:
    """How the meshes of a gmsh model are read again with cells of another order.

    Attributes
    ----------
    again : function from an order, and how often all cells are halved, to all of them
    number : of one of them
    """

    again: Callable[[int | None, int], tuple[NamedMesh, ...]]
    number: int = 0


@dataclass(eq=False)
class NamedMesh:
    """A mesh and its named groups.

    Attributes
    ----------
    domain : DOLFINx mesh
    cells : name -> owned cells of this process
    edges : name -> facets of this process, for surfaces
    points : name -> vertices of this process (may be empty on some)
    opposed : group (None: all cells) -> a place where two of its cells run against each other; empty: nowhere
    model : the same object in meshes that are made of one gmsh model, and in imperfect ones of these
    reading : how it is read again; None: a file tells no more than its cells, or nodes have been moved
    size : diagonal of the box around the structure; known to each process, so that any may ask alone
    named_later : kind, name and place of points and edges that have been given names
    gathered : what `mesh.whole.whole` has made of it; None: nothing yet
    """

    domain: Mesh
    cells: dict[str, np.ndarray]
    edges: dict[str, np.ndarray]
    points: dict[str, np.ndarray]
    opposed: dict[str | None, np.ndarray] = field(default_factory=dict)
    model: object = None
    reading: Reading | None = None
    named_later: list = field(default_factory=list)
    _rules: list = field(default_factory=list)
    _measures: dict = field(default_factory=dict)
    size: float = field(init=False)
    gathered: NamedMesh | None = field(init=False, default=None)

    def __post_init__(self):
        x, comm = self.domain.geometry.x, self.comm
        low, high = np.empty(3), np.empty(3)
        comm.Allreduce(x.min(axis=0, initial=np.inf), low, op=MPI.MIN)
        comm.Allreduce(x.max(axis=0, initial=-np.inf), high, op=MPI.MAX)
        self.size = float(np.linalg.norm(high - low))

    @classmethod
    def from_dolfinx(cls, mesh: Mesh, cell_tags: MeshTags | None = None, facet_tags: MeshTags | None = None,
                     names: Names | None = None, vertex_tags: MeshTags | None = None) -> NamedMesh:
        """A mesh of curves or surfaces with the tags of a DOLFINx mesh as named groups.

        It is made anew, with cells that run alike and junctions on one process: `domain` is another mesh than the given
        one. `domain.geometry.input_global_indices` has the global numbers of its nodes there.

        Parameters
        ----------
        mesh : of intervals, triangles or quadrilaterals, in two or three dimensions; surfaces come to lie in space
        cell_tags : groups of cells; cells without a tag are left out. None: one group "cells"
        facet_tags : named edges of surfaces, named points of curves
        names : tag, or pair of dimension and tag, -> name; others are called "surface 3", "curve 3", "point 3"
        vertex_tags : named points

        Raises
        ------
        ValueError
            If the mesh has other cells, tags are of another dimension, a name has no tag, or a cell is not sound.
        """
        model = model_of(mesh, cell_tags, facet_tags, vertex_tags, names or {})
        cells, edges = (model.surfaces, model.curves) if mesh.topology.dim == 2 else (model.curves, Cells({}, {}))
        dimension = 3 if mesh.topology.dim == 2 else mesh.geometry.dim
        return named_mesh(model, cells, edges, dimension, lasting(mesh.comm), keep_junctions_whole)

    @property
    def comm(self) -> MPI.Intracomm:
        """Its processes."""
        return lasting(self.domain.comm)

    @property
    def dimension(self) -> int:
        return self.domain.geometry.dim

    @property
    def measure(self) -> float:
        """Length of all curves, or area of all surfaces."""
        return self.measure_of(None)

    @property
    def mean_cell(self) -> float:
        """Mean length of cells of curves; root of the mean area of cells of surfaces."""
        dimension = self.domain.topology.dim
        return (self.measure / self.domain.topology.index_map(dimension).size_global) ** (1 / dimension)

    def measure_of(self, group: str | None) -> float:
        """Length of the curves, or area of the surfaces, of a group (default all)."""
        one = fem.Constant(self.domain, 1.0)
        dx = ufl.dx(self.domain) if group is None else self.integral({"quadrature_degree": 2 * self.degree}, group)
        return self.comm.allreduce(fem.assemble_scalar(fem.form(one * dx)))

    @property
    def degree(self) -> int:
        """Of the geometry of its cells."""
        return geometry_degree(self.domain)

    def chords(self, group: str | None) -> np.ndarray:
        """Unit vectors from the first to the second corner of the cells of a group of curves, shape (cells, 3)."""
        ends = self.domain.geometry.x[geometry_nodes(self.domain)[self.group(group), :2]]
        along = ends[:, 1] - ends[:, 0]
        return along / np.linalg.norm(along, axis=1, keepdims=True)

    def name_points(self, name: str, where: Sequence[float] | Callable) -> str:
        """Give points of a mesh a name, as of a file that has none.

        Parameters
        ----------
        where : the place of a vertex; or a function from coordinates, shape (3, n), to whether points are meant

        Returns
        -------
        the name

        Raises
        ------
        ValueError
            If the name is taken, or there is no vertex.
        """
        x = self._coordinates(name)
        if callable(where):
            chosen = np.asarray(where(x.T), dtype=bool)
        else:
            require_components(f"name_points {name!r}: where", where, self.dimension)
            apart = np.linalg.norm(x[:, :self.dimension] - np.asarray(where, dtype=float), axis=1)
            chosen = apart <= ROUNDING * self.size
            nearest = self.comm.allgather(min(zip(apart.tolist(), x.tolist(), strict=True), default=(np.inf, [])))
            if not self.comm.allreduce(int(chosen.sum())):
                at = ", ".join(f"{c:.6g}" for c in min(nearest)[1][:self.dimension])
                raise ValueError(f"name_points: no vertex is at {tuple(where)} for {name!r}; the nearest one is at "
                                 f"({at})")
        return self._named(self.points, name, np.flatnonzero(chosen), "vertex", where)

    def name_edges(self, name: str, where: Callable) -> str:
        """Give edges of surfaces a name, those on the border if there are any, see `name_points`.

        Parameters
        ----------
        where : function from coordinates, shape (3, n), to whether points are on it: both ends of a side have to be
        """
        if self.domain.topology.dim != 2:
            raise ValueError(f"name_edges: {name!r} is to be on curves, which have no edges; name points")
        inside = np.asarray(where(self._coordinates(name).T), dtype=bool)
        topology = self.domain.topology
        for pair in ((1, 0), (1, 2)):
            topology.create_connectivity(*pair)
        chosen = inside[topology.connectivity(1, 0).array.reshape(-1, 2)].all(axis=1)
        border = np.zeros(len(chosen), dtype=bool)
        border[exterior_facet_indices(topology)] = True
        if self.comm.allreduce(int((chosen & border).sum())):
            chosen &= border
        self._measures.pop("ds", None)
        return self._named(self.edges, name, np.flatnonzero(chosen), "side", where)

    def name_as(self, other: NamedMesh) -> None:
        """Give the names that another mesh of the same structure has been given."""
        for kind, name, where in other.named_later:
            (self.name_points if kind == "vertex" else self.name_edges)(name, where)

    def _coordinates(self, name: str) -> np.ndarray:
        """Of all vertices of this process, for things that are to have a name."""
        if name in {*self.points, *self.edges, *self.cells}:
            raise ValueError(f"{name!r} is a name in the mesh already; give another one")
        self.domain.topology.create_connectivity(0, self.domain.topology.dim)
        return self.domain.geometry.x[nodes_of_vertices(self.domain)]

    def _named(self, group: dict, name: str, found: np.ndarray, kind: str, where) -> str:
        if not self.comm.allreduce(len(found)):
            raise ValueError(f"no {kind} of the mesh is where {name!r} is to be; look at the places that its function "
                             "is true for")
        group[name], self.gathered = found.astype(np.int32), None
        self.named_later.append((kind, name, where))
        return name

    def vertices(self, name: str) -> np.ndarray:
        """Vertices of a named point or edge on this process and its ghosts."""
        dimension, entities = self.at(name)
        self.domain.topology.create_connectivity(dimension, 0)
        links = self.domain.topology.connectivity(dimension, 0)
        return np.unique(np.concatenate([np.empty(0, dtype=np.int32), *(links.links(e) for e in entities)]))

    def meet(self, name: str, other: str) -> bool:
        """Whether two named points or edges have vertices in common, on any process."""
        common = np.intersect1d(self.vertices(name), self.vertices(other)).size
        return self.comm.allreduce(common) > 0

    def count(self, name: str) -> int:
        """Number of vertices of a named point or edge, on all processes."""
        owned = self.vertices(name) < self.domain.topology.index_map(0).size_local
        return self.comm.allreduce(int(owned.sum()))

    def integral(self, rule: dict, group: str | None = None):
        """Measure over the cells of a group (default all) with a quadrature rule.

        Each pair of group and rule has an own subdomain number: DOLFINx 0.9 may mix up several
        rules that are integrated over one subdomain. All measures of the mesh share the list of these.
        """
        key = (group, tuple(sorted(rule.items())))
        if key not in self._rules:
            self._rules.append(key)
            self._measures.setdefault("dx", []).append((len(self._rules) - 1, self.group(group)))
        return ufl.Measure("dx", domain=self.domain, subdomain_data=self._measures["dx"],
                           subdomain_id=self._rules.index(key), metadata=dict(rule))

    def edge_length(self, name: str) -> float:
        """Length of a named edge."""
        one = fem.Constant(self.domain, 1.0)
        return self.comm.allreduce(fem.assemble_scalar(fem.form(one * self.facet_measure(name))))

    def group(self, name: str | None) -> np.ndarray:
        """Owned cells of a named group, or all owned cells."""
        if name is None:
            return np.arange(self.domain.topology.index_map(self.domain.topology.dim).size_local, dtype=np.int32)
        if name not in self.cells:
            raise ValueError(f"the mesh has no group of cells named {name!r}; it has {', '.join(self.cells)}")
        return self.cells[name]

    def require(self, owner: str, name: str, *kinds: str) -> None:
        """Refuse a name that nothing of some kinds has: "point", "edge" or "group of cells"; say what it is instead."""
        named = {"point": self.points, "edge": self.edges, "group of cells": self.cells}
        known = [n for kind in kinds for n in named[kind]]
        if name not in known:
            what = " or ".join(filter(None, (", ".join(kinds[:-1]), kinds[-1])))
            other = next((f" (it is a {kind})" for kind, names in named.items() if name in names), "")
            raise ValueError(f"{owner}: the mesh has no {what} named {name!r}{other}; it has "
                             f"{', '.join(known) or 'none'}")

    def require_alike(self, owner: str, group: str | None) -> None:
        """Refuse a group (None: all cells) whose cells run against each other, for what goes by their direction."""
        if group in self.opposed:
            place = ", ".join(f"{x:.6g}" for x in self.opposed[group][:self.dimension])
            one, remedy = "", "join those that run alike in a group, or turn one"
            if self.domain.topology.dim == 2:
                one, remedy = " (it has no two sides, as a Möbius strip)", "divide it in two groups"
            raise ValueError(f"{owner}: cells of group {group or 'all'!r} run against each other at ({place}){one}; "
                             f"{remedy}, and give each a part of its own")

    def at(self, name: str) -> tuple[int, np.ndarray]:
        """Dimension and entities of a named point or edge (empty where another process has it)."""
        if name in self.points:
            return 0, self.points[name]
        if name in self.edges:
            return 1, self.edges[name]
        raise ValueError(f"the mesh has no point or edge named {name!r}; it has "
                         f"{', '.join([*self.points, *self.edges])}")

    def facet_measure(self, name: str):
        """Integral over a named edge of surfaces; on curves the value at a named point.

        Each facet is integrated from one side, a single cell's on a single process.
        """
        facets = self.points if self.domain.topology.dim == 1 else self.edges
        if name not in facets:
            raise ValueError(f"the mesh has no {'point' if facets is self.points else 'edge'} named {name!r}; it has "
                             f"{', '.join(facets)}")
        if "ds" not in self._measures:
            self._measures["ds"] = [(i, self.sides(v)) for i, v in enumerate(facets.values())]
        return ufl.Measure("ds", domain=self.domain, subdomain_data=self._measures["ds"],
                           subdomain_id=list(facets).index(name))

    def sides(self, facets: np.ndarray) -> np.ndarray:
        """Pairs (cell, local facet) one behind the other, for the facets that this process answers for."""
        topology = self.domain.topology
        top = topology.dim
        topology.create_connectivity(top - 1, top)
        topology.create_connectivity(top, top - 1)
        to_cells, to_facets = topology.connectivity(top - 1, top), topology.connectivity(top, top - 1)
        owned = topology.index_map(top).size_local
        pairs = []
        claims = []
        for facet in facets:
            cells = [c for c in to_cells.links(facet) if c < owned]
            if cells:
                pairs.append((min(cells), int(np.flatnonzero(to_facets.links(min(cells)) == facet)[0])))
                claims.append(topology.index_map(top - 1).local_to_global(np.array([facet], dtype=np.int32))[0])
        earlier = self.comm.allgather(claims)[: self.comm.rank]
        taken = {c for rank in earlier for c in rank}
        return np.array([p for p, c in zip(pairs, claims, strict=True) if c not in taken], dtype=np.int32).ravel()


@checked
def read(source: Source, dimension: Annotated[int, Choice((2, 3))],
         order: Annotated[int | None, Choice((1, 2, 3))] = None, place: Callable | None = None,
         comm: MPI.Comm = MPI.COMM_WORLD, size: Positive | None = None,
         halvings: Annotated[int, NOT_NEGATIVE] = 0) -> NamedMesh:
    """Mesh of curves, or of surfaces with edges, of a gmsh model or a file.

    Parameters
    ----------
    source : function without arguments that fills the gmsh model and names physical groups; or path of a file: .msh of
        any version; geometry that gmsh meshes (STEP, BREP, IGES, .geo), where what has no group is called by its name
        or number; or a mesh that meshio (.inp, .med, .vtk, ...) or gmsh (.unv, .bdf) reads. Sets of nodes become edges
        or points
    dimension : 2 or 3, of the space that the structure lies in
    order : of the geometry: 1 (flat cells), 2 or 3 (curved ones), best the degree of the form; None: 2 where the model
        or `place` bends surfaces, or where flat cells of a file seem to be a curved surface, which are raised with
        normals fitted to their neighbours; elsewhere 1, or the file's
    place : function from coordinates in the gmsh model, shape (n, 3), to those in space, shape (n, 3), for
        structures that are meshed in the plane of their parameters
    size : largest of the cells that gmsh makes
    halvings : number of times that all cells are divided in two along each side, on the geometry where gmsh knows it

    Raises
    ------
    ValueError
        If the file, a group or a cell cannot be read.
    """
    model = read_model(source, "read", order, place, comm, size=size, halvings=halvings)
    cells, edges = model.curves, Cells({}, {})
    if model.surfaces.groups:
        cells, edges = model.surfaces, model.curves
        model.require_edges()
    model.require_points_on(cells)
    mesh = named_mesh(model, cells, edges, dimension, comm, keep_junctions_whole)
    return with_reading((mesh,), source, place, lambda order, more: (
        read(source, dimension, order, place, comm, size, halvings + more),))[0]


def with_reading(meshes: tuple[NamedMesh, ...], source: Source, place: Callable | None,
                 again: Callable[[int | None, int], tuple[NamedMesh, ...]]) -> tuple[NamedMesh, ...]:
    """Meshes of one gmsh model, told how they are read again where the geometry is known."""
    if callable(source) or place is not None or is_geometry(source):
        for number, mesh in enumerate(meshes):
            mesh.reading = Reading(again, number)
    return meshes


def named_mesh(model: Model, cells: Cells, edges: Cells, dimension: int, comm: MPI.Comm, partitioner,
               alike: Alike | None = None, number: int = 0) -> NamedMesh:
    """Mesh of some cells of a gmsh model.

    Parameters
    ----------
    edges : curves on the edges of surfaces; absent ones are left out
    partitioner : where there are several processes
    alike : of cells of several kinds, which have been turned together; these have the given number there
    """
    alike, x = alike or run_alike(model, cells), model.x
    nodes = alike.nodes[number]
    if alike.said and not number and not comm.rank:
        warn(alike.said)
    used = x[np.unique(nodes)]
    if dimension == 2 and (off := np.abs(used[:, 2]).max()) > ROUNDING * np.linalg.norm(np.ptp(used, axis=0)):
        raise ValueError(f"{model.what}: the structure has places out of the x-y plane, by up to {off:.3g}; read it "
                         "in 3 dimensions, or in its plane with place=lambda x: x * (1, 1, 0)")
    if comm.rank:
        nodes, x = nodes[:0], x[:0]
    domain = gmsh_mesh(comm, cells.kind, nodes, x[:, :dimension], partitioner if comm.size > 1 else None)
    topology = domain.topology
    for d in range(topology.dim):
        topology.create_connectivity(d, topology.dim)
    owned = cells.source()[topology.original_cell_index[: topology.index_map(topology.dim).size_local]]
    inside = {name: _where(np.isin(owned, on)) for name, on in cells.groups.items()}
    numbers = domain.geometry.input_global_indices[nodes_of_vertices(domain)]
    points = {name: _where(np.isin(numbers, found)) for name, found in model.points_on(cells).items()}
    along = {}
    if edges.groups:
        sides = model.pairs(numbers[topology.connectivity(1, 0).array.reshape(-1, 2)])
        along = {name: _where(np.isin(sides, model.pairs(edges.corners(on)))) for name, on in edges.groups.items()}
    return NamedMesh(domain, inside, along, points, alike.opposed, model.identity)


def _where(chosen: np.ndarray) -> np.ndarray:
    return np.flatnonzero(chosen).astype(np.int32)
