"""Imperfect shapes: a model with moved nodes."""

from __future__ import annotations

from collections.abc import Callable

import dolfinx
import numpy as np
import ufl
from dolfinx import fem

from ..compat import JIT
from .reader import Model


def imperfect(model: Model, displacement: fem.Function | Callable, amplitude: float) -> Model:
    """A model like another with all nodes moved by `amplitude` times a displacement.

    The given model keeps its shape; edges, points and groups have the same names. The sum of several
    imperfections is made by one call after the other.

    Parameters
    ----------
    displacement : Function on the model's mesh (such as `mode_displacement` gives), or a function from
        coordinates, shape (n, 3), to displacements, shape (n, 3) or (n, 2) in the plane
    amplitude : factor, a length where the largest displacement is 1
    """
    mesh, old = model.mesh, model.mesh.geometry
    x = old.x[:, :old.dim].copy()
    moved = _at_nodes(mesh, displacement) if isinstance(displacement, fem.Function) else displacement(old.x)
    x += amplitude * np.asarray(moved)[:, :old.dim]
    geometry = type(old._cpp_object)(old.index_map(), old.dofmap, old.cmap._cpp_object, x, old.input_global_indices)
    copy = type(mesh._cpp_object)(mesh.comm, mesh.topology._cpp_object, geometry)
    domain = ufl.Mesh(mesh.ufl_domain().ufl_coordinate_element())
    return Model(dolfinx.mesh.Mesh(copy, domain), model.cells, model.edges, model.points)


def _at_nodes(mesh, displacement: fem.Function) -> np.ndarray:
    """Displacement at the nodes of the geometry of this process, shape (n, dimension)."""
    points = mesh.ufl_domain().ufl_coordinate_element().basix_element.points
    cells = np.arange(len(mesh.geometry.dofmap), dtype=np.int32)
    table = fem.Expression(displacement, points, jit_options=JIT).eval(mesh, cells)
    values = np.zeros((len(mesh.geometry.x), mesh.geometry.dim))
    values[mesh.geometry.dofmap.ravel()] = table.reshape(-1, mesh.geometry.dim)
    return values
