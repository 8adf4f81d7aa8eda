"""From a gmsh model with named physical groups to a mesh that knows its groups by name."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
import ufl
from dolfinx import fem
from dolfinx.mesh import Mesh
from mpi4py import MPI

from ..compat import model_to_mesh

RULES = 8


@dataclass(eq=False)
class Model:
    """A mesh and its named groups.

    Attributes
    ----------
    mesh : dolfinx mesh
    cells : name -> owned cells of this process
    points : name -> vertices of this process (may be empty on some)
    """

    mesh: Mesh
    cells: dict[str, np.ndarray]
    points: dict[str, np.ndarray]
    _rules: list = field(default_factory=list)
    _measures: dict = field(default_factory=dict)

    @property
    def dimension(self) -> int:
        return self.mesh.geometry.dim

    @property
    def size(self) -> float:
        """Diagonal of the box around the structure."""
        x = self.mesh.geometry.x
        comm = self.mesh.comm
        low, high = np.empty(3), np.empty(3)
        comm.Allreduce(x.min(axis=0, initial=np.inf), low, op=MPI.MIN)
        comm.Allreduce(x.max(axis=0, initial=-np.inf), high, op=MPI.MAX)
        return float(np.linalg.norm(high - low))

    @property
    def length(self) -> float:
        """Length of all curves."""
        one = fem.Constant(self.mesh, 1.0)
        return self.mesh.comm.allreduce(fem.assemble_scalar(fem.form(one * ufl.dx(self.mesh))))

    def integral(self, rule: dict, group: str | None = None):
        """Measure over the cells of a group (default all) with a quadrature rule.

        Each pair of group and rule has an own subdomain number: DOLFINx 0.9 may mix up several
        rules that are integrated over one subdomain.
        """
        key = (group, tuple(sorted(rule.items())))
        if key not in self._rules:
            if len(self._rules) == RULES:
                raise ValueError(f"more than {RULES} pairs of cell group and quadrature rule in one model")
            self._rules.append(key)
            cells = self.group(group)
            self._subdomains()[self._rules.index(key)] = (self._rules.index(key), cells)
        return ufl.Measure("dx", domain=self.mesh, subdomain_data=self._subdomains(),
                           subdomain_id=self._rules.index(key), metadata=dict(rule))

    def _subdomains(self) -> list:
        """The list that all measures of the model share."""
        return self._measures.setdefault("dx", [(i, np.empty(0, dtype=np.int32)) for i in range(RULES)])

    def group(self, name: str | None) -> np.ndarray:
        """Owned cells of a named group, or all owned cells."""
        if name is None:
            return np.arange(self.mesh.topology.index_map(self.mesh.topology.dim).size_local, dtype=np.int32)
        if name not in self.cells:
            raise ValueError(f"the mesh has no group of cells named {name!r}; it has {', '.join(self.cells)}")
        return self.cells[name]

    def at(self, name: str) -> np.ndarray:
        """Vertices of a named point (empty where another process has it)."""
        if name not in self.points:
            raise ValueError(f"the mesh has no point named {name!r}; it has {', '.join(self.points)}")
        return self.points[name]

    def point_measure(self, name: str):
        """Evaluation at a named point, as a measure: the sum over the group's vertices.

        Each vertex is integrated from one side, that of a single cell on a single process.
        """
        self.at(name)
        if "ds" not in self._measures:
            self._measures["ds"] = [(i, self._sides(v)) for i, v in enumerate(self.points.values())]
        return ufl.Measure("ds", domain=self.mesh, subdomain_data=self._measures["ds"],
                           subdomain_id=list(self.points).index(name))

    def _sides(self, vertices: np.ndarray) -> np.ndarray:
        """Pairs (cell, local vertex) for the vertices that this process answers for."""
        topology = self.mesh.topology
        topology.create_connectivity(0, 1)
        to_cells, to_vertices = topology.connectivity(0, 1), topology.connectivity(1, 0)
        owned = topology.index_map(1).size_local
        pairs = []
        claims = []
        for vertex in vertices:
            cells = [c for c in to_cells.links(vertex) if c < owned]
            if cells:
                pairs.append((min(cells), int(np.flatnonzero(to_vertices.links(min(cells)) == vertex)[0])))
                claims.append(topology.index_map(0).local_to_global(np.array([vertex], dtype=np.int32))[0])
        earlier = self.mesh.comm.allgather(claims)[: self.mesh.comm.rank]
        taken = {c for rank in earlier for c in rank}
        return np.array([p for p, c in zip(pairs, claims, strict=True) if c not in taken], dtype=np.int32).ravel()


def read(build: Callable[[], None], dimension: int, order: int = 1, comm: MPI.Comm = MPI.COMM_WORLD) -> Model:
    """Mesh the geometry that `build` adds to the current gmsh model.

    Parameters
    ----------
    build : function without arguments that fills the gmsh model and names physical groups
    dimension : 2 or 3, of the space that the structure lies in
    order : 1 or 2, of the geometry (2: curved elements)
    """
    import gmsh

    gmsh.initialize(interruptible=False)
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        groups: dict[int, dict[str, list[int]]] = {}
        if comm.rank == 0:
            gmsh.model.add("model")
            build()
            top = max(d for d, _ in gmsh.model.getPhysicalGroups())
            gmsh.model.mesh.generate(top)
            gmsh.model.mesh.setOrder(order)
            groups = _group_by_entity(gmsh.model)
        groups = comm.bcast(groups, root=0)
        mesh, cell_tags, point_tags = model_to_mesh(gmsh.model, comm, dimension)
    finally:
        gmsh.finalize()
    top = mesh.topology.dim
    owned = mesh.topology.index_map(top).size_local
    cells = {name: _find(cell_tags, tags) for name, tags in groups[top].items()}
    cells = {name: c[c < owned] for name, c in cells.items()}
    points = {name: _find(point_tags, tags) for name, tags in groups[0].items()}
    return Model(mesh, cells, points)


def _group_by_entity(model) -> dict[int, dict[str, list[int]]]:
    """Give each entity a physical group of its own number, since mesh tags hold one value each.

    Returns, for each dimension, the names of the groups and the entities in them.
    """
    groups: dict[int, dict[str, list[int]]] = {0: {}, 1: {}, 2: {}}
    for d, tag in model.getPhysicalGroups():
        groups[d][model.getPhysicalName(d, tag)] = [int(e) for e in model.getEntitiesForPhysicalGroup(d, tag)]
    model.removePhysicalGroups()
    for d, named in groups.items():
        for entity in sorted({e for entities in named.values() for e in entities}):
            model.addPhysicalGroup(d, [entity], tag=entity)
    return groups


def _find(tags, values) -> np.ndarray:
    found = [tags.find(v) for v in values]
    return np.unique(np.concatenate(found)).astype(np.int32)
