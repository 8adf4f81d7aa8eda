"""A DOLFINx mesh with its tags, as the model that meshes with names are made of."""

from __future__ import annotations

from collections.abc import Mapping

import basix
import numpy as np
from dolfinx.mesh import Mesh, MeshTags

from ..communicators import lasting
from ..compat import geometry_degree, geometry_nodes, gmsh_cells
from .cells import KINDS, Cells
from .gmsh_model import Model, check_model
from .groups import DIMENSIONS

Names = Mapping[int | tuple[int, int], str]
KIND = {(KINDS[kind][1], degree): kind for kinds in ((1, 8, 26), (2, 9, 21), (3, 10, 36))
        for degree, kind in enumerate(kinds, 1)}  # gmsh's number by corners and degree


def model_of(mesh: Mesh, cells: MeshTags | None, facets: MeshTags | None, vertices: MeshTags | None,
             names: Names) -> Model:
    """The model of a mesh of curves or surfaces, the same on all processes.

    Parameters
    ----------
    cells, facets, vertices : tags; None: one group of all cells, no edges, no points. Cells without a tag are left out
    names : of tags, or of pairs of dimension and tag where two dimensions have one tag; others are called by their
        dimension and number

    Raises
    ------
    ValueError
        If the mesh has other cells, tags are of another dimension, or a name has no tag.
    """
    topology, comm, top = mesh.topology, lasting(mesh.comm), mesh.topology.dim
    kind = _kind(mesh)
    _check_dimensions(top, cells, facets, vertices)
    tags = {tags.dim: tags for tags in (cells, facets, vertices) if tags is not None}
    known = {(d, int(tag)) for d, own in tags.items() for part in comm.allgather(np.unique(own.values)) for tag in part}
    by_dimension = _by_dimension(names, known)
    x, own = _places(mesh), _global_nodes(mesh)
    of_vertices = mesh.geometry.index_map().local_to_global(nodes_of_vertices(mesh).astype(np.int32))
    tables = {top: _by_tag(comm, own, cells, len(own))}
    topology.create_connectivity(1, 0)
    nodes = {0: of_vertices[:, None], 1: of_vertices[topology.connectivity(1, 0).array.reshape(-1, 2)]}
    tables |= {d: _by_tag(comm, nodes[d], given, topology.index_map(d).size_local)
               for d, given in tags.items() if d < top}
    order = np.argsort(gmsh_cells(kind, np.arange(own.shape[1])[None])[1][0])
    in_gmsh = {tag: table[:, order] for tag, table in tables[top].items()}

    def named(dimension: int) -> dict[str, list[int]]:
        found: dict[str, list[int]] = {}
        for tag in tables.get(dimension, {}):
            name = by_dimension.get((dimension, tag), "cells" if dimension == top and cells is None
                                    else f"{DIMENSIONS[dimension][:-1]} {tag}")
            found.setdefault(name, []).append(tag)
        return found

    own_cells, edges = Cells(named(top), in_gmsh, kind), Cells({}, {})
    if top == 2 and 1 in tables:
        edges = Cells(named(1), tables[1], KIND[2, 1])
    points = {name: np.unique(np.concatenate([tables[0][tag] for tag in on])) for name, on in named(0).items()}
    model = Model("from_dolfinx", x, *((edges, [own_cells]) if top == 2 else (own_cells, [Cells({}, {})])), points)
    check_model(model, False)
    return model


def _kind(mesh: Mesh) -> int:
    """gmsh's number of the cells of a mesh."""
    cell, degree = mesh.basix_cell(), geometry_degree(mesh)
    kind = KIND.get((len(basix.topology(cell)[0]), degree)) if mesh.topology.dim in (1, 2) else None
    if kind is None:
        raise ValueError(f"from_dolfinx: the mesh has {cell.name} cells of degree {degree}; give intervals, triangles "
                         "or quadrilaterals of degree 1 to 3")
    return kind


def _check_dimensions(top: int, cells: MeshTags | None, facets: MeshTags | None, vertices: MeshTags | None) -> None:
    """Refuse tags that are not of cells, facets or vertices, and both of the last two on curves."""
    for given, dimension, what in ((cells, top, "cell_tags"), (facets, top - 1, "facet_tags"),
                                   (vertices, 0, "vertex_tags")):
        if given is not None and given.dim != dimension:
            raise ValueError(f"from_dolfinx: {what} are of dimension {given.dim}; give tags of dimension {dimension}")
    if top == 1 and facets is not None and vertices is not None:
        raise ValueError("from_dolfinx: facet_tags and vertex_tags are both of points of curves; give one of them")


def _by_dimension(names: Names, known: set[tuple[int, int]]) -> dict[tuple[int, int], str]:
    """Names of pairs of dimension and tag."""
    found: dict[tuple[int, int], str] = {}
    for key, name in names.items():
        meant = {key} & known if isinstance(key, tuple) else {(d, tag) for d, tag in known if tag == key}
        if not meant:
            raise ValueError(f"from_dolfinx: {name!r} is to be the name of tag {key}, which no tags have; there are "
                             f"{', '.join(f'{DIMENSIONS[d][:-1]} {tag}' for d, tag in sorted(known))}")
        found |= dict.fromkeys(meant, name)
    return found


def _places(mesh: Mesh) -> np.ndarray:
    """Places of all nodes of all processes by their global numbers."""
    geometry, comm = mesh.geometry, lasting(mesh.comm)
    owned = geometry.index_map().size_local
    return np.concatenate(comm.allgather(geometry.x[:owned]))


def _global_nodes(mesh: Mesh) -> np.ndarray:
    """Global numbers of the nodes of the cells of this process."""
    owned = mesh.topology.index_map(mesh.topology.dim).size_local
    nodes = geometry_nodes(mesh)[:owned]
    return mesh.geometry.index_map().local_to_global(nodes.ravel().astype(np.int32)).reshape(nodes.shape)


def nodes_of_vertices(mesh: Mesh) -> np.ndarray:
    """Local number of the node of the geometry at each vertex of this process."""
    topology = mesh.topology
    topology.create_connectivity(topology.dim, 0)
    corners = topology.connectivity(topology.dim, 0)
    vertices = corners.array.reshape(corners.num_nodes, len(basix.topology(mesh.basix_cell())[0]))
    numbers = np.empty(vertices.max(initial=-1) + 1, dtype=np.int64)
    numbers[vertices] = geometry_nodes(mesh)[:len(vertices), :vertices.shape[1]]
    return numbers


def _by_tag(comm, nodes: np.ndarray, tags: MeshTags | None, owned: int) -> dict[int, np.ndarray]:
    """Nodes of the entities of each tag, of all processes."""
    entities, values = (np.arange(owned), np.zeros(owned, dtype=int)) if tags is None else (tags.indices, tags.values)
    mine = entities < owned
    parts = comm.allgather((nodes[entities[mine]], np.asarray(values)[mine]))
    tables, values = (np.concatenate(found) for found in zip(*parts, strict=True))
    return {int(tag): tables[values == tag].astype(np.int64) for tag in np.unique(values)}
