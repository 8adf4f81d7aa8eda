"""Imperfect shapes: a mesh with moved nodes.

Shapes are modes, functions of place, measured deviations or random fields, and sums of these.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Annotated, Any

import dolfinx
import numpy as np
from dolfinx import fem
from scipy.interpolate import RBFInterpolator

from .. import forms
from ..checks import NOT_NEGATIVE, Count, Positive, checked
from ..compat import geometry_nodes, moved_mesh
from ..jit import compiled_expression
from .mixed import MixedMesh
from .quality import bad_cells, refuse
from .reader import NamedMesh

Shape = fem.Function | Callable[[np.ndarray], np.ndarray]

FLAT = 1e-8


@checked
def imperfect(mesh: NamedMesh | MixedMesh, displacement: Shape | Sequence[Shape],
              amplitude: float | Sequence[float] = 1.0) -> NamedMesh | MixedMesh:
    """A mesh like another with all nodes moved by `amplitude` times a displacement.

    The given mesh keeps its shape; edges, points and groups have the same names.

    Parameters
    ----------
    mesh : a MixedMesh is moved whole: nodes of bars on surfaces move with these, others as is given for them, a
        function of place or a Function on the curves
    displacement : Function on the mesh (such as `mode_displacement` gives), or a function from
        coordinates, shape (n, 3), to displacements, shape (n, 3) or (n, 2) in the plane, or to deviations along the
        unit normal of a surface or plane curve, shape (n,); or a sequence of these
    amplitude : factor, a length where the largest displacement is 1; a sequence has a factor for each displacement

    Raises
    ------
    ValueError
        If there is not one amplitude for each displacement, a displacement has another shape or is on another mesh,
        there is no normal for deviations along it, or a cell is folded over or has no extent.
    """
    given = given_shapes(displacement, amplitude)
    if isinstance(mesh, NamedMesh):
        return at_places(mesh, _places(mesh, given))
    shared = mesh.shared_nodes()
    y, x = moved_together([mesh.surfaces, mesh.curves], given, [(1, 0, shared)])
    return MixedMesh(at_places(mesh.surfaces, y), at_places(mesh.curves, x))


def given_shapes(displacement: Any, amplitude: float | Sequence[float]) -> list[tuple[Any, float]]:
    """Displacements with their amplitudes.

    Raises
    ------
    ValueError
        If there is no displacement, or not one amplitude for each.
    """
    shapes = displacement if isinstance(displacement, Sequence) else [displacement]
    if not len(shapes):
        raise ValueError("imperfect: displacement is empty; give at least one")
    amplitudes = np.atleast_1d(amplitude)
    if len(amplitudes) not in (1, len(shapes)):
        raise ValueError(f"imperfect: {len(amplitudes)} amplitudes for {len(shapes)} displacements; give one for each")
    return list(zip(shapes, np.broadcast_to(amplitudes, len(shapes)), strict=True))


def _places(mesh: NamedMesh, given: Sequence[tuple[Shape, float]]) -> np.ndarray:
    """Places of the moved nodes of the geometry of this process, shape (n, dimension)."""
    x = mesh.domain.geometry.x[:, :mesh.dimension].copy()
    for shape, factor in given:
        x += factor * _moved(mesh, shape)
    return x


def at_places(mesh: NamedMesh, x: np.ndarray) -> NamedMesh:
    """A mesh like another with its nodes at other places."""
    moved = NamedMesh(moved_mesh(mesh.domain, x), mesh.cells, mesh.edges, mesh.points, mesh.opposed, mesh.model)
    _refuse_bad_cells(moved)
    return moved


def moved_together(meshes: Sequence[NamedMesh], given: Sequence[tuple[Shape, float]],
                   common: Sequence[tuple[int, int, np.ndarray]]) -> list[np.ndarray]:
    """Places of the moved nodes of several meshes, of which some are one.

    Parameters
    ----------
    given : functions of place move all meshes, a Function the one that it is on
    common : numbers of two meshes, and pairs of nodes of which the first mesh's goes where the second's does

    Returns
    -------
    for each mesh an array of shape (nodes, dimension)

    Raises
    ------
    ValueError
        If a node has no displacement.
    """
    domains, places = [mesh.domain for mesh in meshes], []
    for number, mesh in enumerate(meshes):
        elsewhere = [s for s, _ in given if isinstance(s, fem.Function) and s.function_space.mesh is not mesh.domain
                     and s.function_space.mesh in domains]
        here = [one for one in given if one[0] not in elsewhere]
        along = [one for one in here if isinstance(one[0], fem.Function) or _moves(mesh, one[0])]
        alone = np.ones(len(mesh.domain.geometry.x), dtype=bool)
        for own, _, pairs in common:
            if own == number:
                alone[pairs[:, 0]] = False
        fields = any(isinstance(one[0], fem.Function) for one in here)
        if (count := mesh.comm.allreduce(int(alone.sum()))) and not fields and len(along) < len(given):
            raise ValueError(f"imperfect: {count} nodes of {', '.join(mesh.cells)} that move with no surface have no "
                             "displacement; give one on them too, or a function of place of shape (n, 3)")
        places.append(_places(mesh, along))
    for own, of, pairs in common:
        places[own][pairs[:, 0]] = places[of][pairs[:, 1]]
    return places


def _moves(mesh: NamedMesh, shape: Callable[[np.ndarray], np.ndarray]) -> bool:
    """Whether a function of place gives displacements, or deviations along normals that the mesh has."""
    normals = mesh.domain.topology.dim == 2 or mesh.dimension == 2
    return normals or np.ndim(shape(mesh.domain.geometry.x)) == 2


def geometry_nodes_at(mesh: NamedMesh, at: str | None) -> np.ndarray:
    """Nodes of the geometry of this process at a named point or edge or on a group of cells; None: all."""
    domain, nodes = mesh.domain, geometry_nodes(mesh.domain)
    if at is None or at in mesh.cells:
        return np.unique(nodes[mesh.group(at)])
    space = fem.functionspace(domain, domain.ufl_domain().ufl_coordinate_element())
    of_dofs = np.empty(nodes.max(initial=-1) + 1, dtype=np.int64)
    of_dofs[space.dofmap.list.ravel()] = nodes.ravel()
    return np.unique(of_dofs[fem.locate_dofs_topological(space, *mesh.at(at))])


@checked
def measured(points: np.ndarray, offsets: np.ndarray) -> Callable[[np.ndarray], np.ndarray]:
    """Deviations measured at points, as a function of place for `imperfect`.

    Between the points they are interpolated by cubic radial basis functions with a linear polynomial (natural cubic
    splines where the points lie on a line), in as many directions as the points extend.

    Parameters
    ----------
    points : nominal places, shape (n, 3) or (n, 2)
    offsets : displacements from there, shape (n, 3) or (n, 2), or deviations along the normal, shape (n,); of
        measured places give the difference to the nominal ones

    Raises
    ------
    ValueError
        If the table has not one offset for each point, points twice, or too few points.
    """
    points, offsets = np.asarray(points, dtype=float), np.asarray(offsets, dtype=float)
    if points.ndim != 2 or len(points) != len(offsets):
        raise ValueError(f"measured: points of shape {points.shape} and offsets of shape {offsets.shape}; "
                         "give a row of coordinates and an offset for each point")
    different, counts = np.unique(points, axis=0, return_counts=True)
    if len(different) < len(points):
        raise ValueError(f"measured: the point {different[np.argmax(counts)]} stands twice in the table; keep one of "
                         "its rows")
    centre = points.mean(axis=0)
    _, extents, axes = np.linalg.svd(points - centre, full_matrices=False)
    axes = axes[extents > FLAT * extents.max(initial=0.0)]
    if len(points) <= len(axes) or not len(axes):
        raise ValueError(f"measured: {len(points)} points are too few; give {max(len(axes), 1) + 1} or more")
    interpolate = RBFInterpolator((points - centre) @ axes.T, offsets, kernel="cubic")
    return lambda x: interpolate((x[:, :points.shape[1]] - centre) @ axes.T)


@checked
def random_field(correlation_length: Positive, deviation: Positive = 1.0, seed: Annotated[int, NOT_NEGATIVE] = 0,
                 waves: Count = 1000) -> Callable[[np.ndarray], np.ndarray]:
    """Random Gaussian deviations along the normal, as a function of place for `imperfect`.

    Their mean is zero and their covariance deviation^2 exp(-(distance / correlation_length)^2), with distances in
    space. The field is a sum of waves with random phases and wave vectors from the spectrum of the covariance
    (Shinozuka and Deodatis 1991; Rahimi and Recht 2007, section 3): a function of place alone, the same on any mesh and
    any number of processes. It is Gaussian in the limit of many waves; with 1000 its kurtosis is 2.9985.

    Parameters
    ----------
    correlation_length : distance at which the correlation is 1 / e
    deviation : standard deviation, a length
    seed : of the random numbers; another seed is another sample
    waves : number of waves

    Raises
    ------
    ValueError
        If a length, the deviation or the number of waves is not positive.
    """
    generator = np.random.default_rng(seed)
    vectors = generator.normal(scale=np.sqrt(2) / correlation_length, size=(3, waves))
    phases = generator.uniform(0, 2 * np.pi, waves)
    return lambda x: deviation * np.sqrt(2 / waves) * np.cos(x @ vectors + phases).sum(axis=1)


def _refuse_bad_cells(mesh: NamedMesh) -> None:
    """Refuse cells that have been moved out of shape, on all processes where one has them."""
    element, x = mesh.domain.ufl_domain().ufl_coordinate_element().basix_element, mesh.domain.geometry.x
    found = bad_cells(element, x[geometry_nodes(mesh.domain)], mesh.cells, mesh.size)
    refuse("imperfect", [bad for rank in mesh.comm.allgather(found) for bad in rank],
           "make the amplitude smaller, or the cells smaller than the waves of the shape")


def _moved(mesh: NamedMesh, shape: Shape) -> np.ndarray:
    """Displacement of a shape at the nodes of the geometry of this process, shape (n, dimension)."""
    if isinstance(shape, fem.Function):
        if shape.function_space.mesh is not mesh.domain:
            raise ValueError(f"imperfect: {shape.name!r} is a field on another mesh; give one on the mesh that is to "
                             "be imperfect, or a function of place")
        return _at_nodes(mesh, shape)
    values, count = np.asarray(shape(mesh.domain.geometry.x), dtype=float), len(mesh.domain.geometry.x)
    if values.shape not in ((count,), (count, mesh.dimension), (count, 3)):
        raise ValueError(f"imperfect: a displacement has shape {values.shape} at {count} nodes; give ({count}, "
                         f"{mesh.dimension}), or ({count},) for deviations along the normal")
    return values[:, :mesh.dimension] if values.ndim == 2 else values[:, None] * _normals(mesh)


def _at_nodes(mesh: NamedMesh, field) -> np.ndarray:
    """Mean over the cells at each node of the geometry of a vector expression, shape (n, dimension)."""
    domain = mesh.domain
    element = domain.ufl_domain().ufl_coordinate_element()
    space = fem.functionspace(domain, element)
    expression = compiled_expression(field, element.basix_element.points)
    total, count = fem.Function(space), fem.Function(space)
    cells = mesh.group(None)
    nodes, width = space.dofmap.list[cells], mesh.dimension
    table = expression.eval(domain, cells).reshape(*nodes.shape, width)
    np.add.at(total.x.array.reshape(-1, width), nodes, table)
    np.add.at(count.x.array.reshape(-1, width), nodes, 1.0)
    for function in (total, count):
        function.x.scatter_reverse(dolfinx.la.InsertMode.add)
        function.x.scatter_forward()
    values = np.zeros((len(domain.geometry.x), width))
    values[geometry_nodes(domain)] = (total.x.array / count.x.array).reshape(-1, width)[space.dofmap.list]
    return values


def _normals(mesh: NamedMesh) -> np.ndarray:
    """Unit normals at the nodes of the geometry of this process, shape (n, dimension)."""
    domain = mesh.domain
    if domain.topology.dim == 2:
        normal = forms.shell.unit_normal(domain)
    elif mesh.dimension == 2:
        normal = forms.beam.curve_frame(domain).normal
    else:
        raise ValueError("imperfect: curves in space have no normal for deviations along it; "
                         "give displacements of shape (n, 3)")
    normals = _at_nodes(mesh, normal)
    lengths = np.linalg.norm(normals, axis=1, keepdims=True)
    places = np.concatenate(mesh.comm.allgather(domain.geometry.x[lengths[:, 0] < 0.1]))
    if len(places):
        raise ValueError(f"imperfect: normals of the parts that meet at {places[0]} cancel; give displacements of "
                         "shape (n, 3) instead of deviations along the normal")
    return normals / lengths
