"""Displacement and rotation of the parts of a model as unknown fields."""

from __future__ import annotations

from dataclasses import dataclass

import basix.ufl
import numpy as np
from dolfinx import fem

from . import forms
from .mesh.reader import Model
from .scene import COMPONENTS
from .unknowns import AdditiveField, Block, QuaternionField


@dataclass(frozen=True)
class Kinematics:
    """Displacement and rotation of the parts of one model.

    Attributes
    ----------
    rotation, total_rotation : with and without the symbol of its increment, for virtual work and strains
    """

    u: fem.Function
    spin: fem.Function
    rotation: object
    total_rotation: object
    block: Block

    def sub_space(self, component: str):
        dimension = self.block.space.mesh.geometry.dim
        index = COMPONENTS[dimension].index(component)
        if index < dimension:
            return self.block.space.sub(0).sub(index)
        rotations = self.block.space.sub(1)
        return rotations if dimension == 2 else rotations.sub(index - dimension)

    def displacement(self, model: Model, at: str) -> np.ndarray:
        """Displacement of a named point, the same on all processes."""
        return self._value(self.u, model, at)

    def point_dofs(self, model: Model, at: str, component: str) -> np.ndarray:
        """Dofs of a component at the vertices of a named point that this process owns."""
        dofs = fem.locate_dofs_topological(self.sub_space(component), *model.at(at))
        space = self.block.space
        return dofs[dofs < space.dofmap.index_map.size_local * space.dofmap.index_map_bs]

    def angle(self, model: Model, at: str) -> float:
        """Rotation of a named point in the plane, in radians."""
        return float(self._value(self.spin, model, at)[0])

    @staticmethod
    def _value(function: fem.Function, model: Model, at: str) -> np.ndarray:
        space = function.function_space
        size = space.dofmap.index_map_bs
        nodes = fem.locate_dofs_topological(space, *model.at(at))
        owned = nodes[nodes < space.dofmap.index_map.size_local]
        found = model.mesh.comm.allgather(function.x.array.reshape(-1, size)[owned[:1]])
        return np.concatenate(found)[0]


def kinematics_of(model: Model, displacement: tuple[str, int], rotation: tuple[str, int]) -> Kinematics:
    """Spaces and fields of a model's parts: the angle in the plane, a quaternion in space.

    Parameters
    ----------
    displacement, rotation : family and degree of the spaces
    """
    mesh, dimension = model.mesh, model.dimension
    spins = () if dimension == 2 else (3,)
    cell = mesh.basix_cell()
    family, degree = rotation
    parts = [basix.ufl.element(displacement[0], cell, displacement[1], shape=(dimension,)),
             basix.ufl.element(family, cell, degree, shape=spins)]
    space = fem.functionspace(mesh, basix.ufl.mixed_element(parts))
    u = fem.Function(fem.functionspace(mesh, parts[0]), name="displacement")
    displacement = AdditiveField(u, _places(u.function_space, space.sub(0)), model.size)
    spin = fem.Function(fem.functionspace(mesh, parts[1]), name="rotation")
    spin_dofs = _places(spin.function_space, space.sub(1))
    if dimension == 2:
        turn = AdditiveField(spin, spin_dofs, 1.0)
        spatial = total = forms.rotation.PlanarRotation(spin)
    else:
        q = fem.Function(fem.functionspace(mesh, (family, degree, (4,))), name="rotation")
        order = _matching_nodes(q.function_space, spin.function_space)
        turn = QuaternionField(q, spin, spin_dofs.reshape(-1, 3)[order].ravel())
        spatial, total = forms.rotation.SpatialRotation(q, spin), forms.rotation.SpatialRotation(q)
    return Kinematics(u, spin, spatial, total, Block(space, (displacement, turn)))


def _places(space, part) -> np.ndarray:
    """For each dof of `space` the dof of the same element's `part` of a mixed space.

    DOLFINx 0.9 forgets the order of nodes along edges when it collapses the part (degree 3 and above).
    """
    size = space.dofmap.bs
    count = space.dofmap.index_map.size_local + space.dofmap.index_map.num_ghosts
    dofs = np.empty(count * size, dtype=np.int64)
    own = size * space.dofmap.list[:, :, None] + np.arange(size)
    dofs[own.reshape(part.dofmap.list.shape)] = part.dofmap.list
    return dofs


def _matching_nodes(space, other) -> np.ndarray:
    """For each node of `space` the node of `other` at the same place (same element, other shape)."""
    nodes = np.empty(space.dofmap.index_map.size_local + space.dofmap.index_map.num_ghosts, dtype=np.int64)
    nodes[space.dofmap.list.ravel()] = other.dofmap.list.ravel()
    return nodes

