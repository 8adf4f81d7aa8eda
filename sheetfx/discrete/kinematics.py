"""Displacement and rotation of the parts of a mesh as unknown fields."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import basix.ufl
import numpy as np
from dolfinx import fem

from .. import forms
from ..mesh.reader import COMPONENTS, NamedMesh
from .nodal_field import AdditiveField, QuaternionField
from .unknowns import Block


@dataclass(frozen=True)
class Kinematics:
    """Displacement and rotation of the parts of one mesh.

    Attributes
    ----------
    spin, rotation, total_rotation : rotation with and without the symbol of its increment, for virtual work and
        strains; None where there is none
    """

    u: fem.Function
    spin: fem.Function | None
    rotation: Any
    total_rotation: Any
    block: Block

    def sub_space(self, component: str):
        dimension = self.block.space.mesh.geometry.dim
        index = COMPONENTS[dimension].index(component)
        if self.spin is None:
            return self.block.space.sub(index)
        if index < dimension:
            return self.block.space.sub(0).sub(index)
        rotations = self.block.space.sub(1)
        return rotations if dimension == 2 else rotations.sub(index - dimension)

    def displacement(self, mesh: NamedMesh, at: str) -> np.ndarray:
        """Displacement of a named point, the same on all processes."""
        return self._value(self.u, mesh, at)

    def point_dofs(self, mesh: NamedMesh, at: str, component: str) -> np.ndarray:
        """Dofs of a component at the vertices of a named point or edge that this process owns."""
        dofs = fem.locate_dofs_topological(self.sub_space(component), 0, mesh.vertices(at))
        space = self.block.space
        return dofs[dofs < space.dofmap.index_map.size_local * space.dofmap.index_map_bs]

    def turned(self, mesh: NamedMesh, at: str) -> float | np.ndarray:
        """Rotation of a named point: in the plane an angle in radians, in space a unit quaternion.

        Raises
        ------
        ValueError
            If there is no field of rotations.
        """
        if self.spin is None:
            raise ValueError(f"rotation of {at!r}: bars have no rotations; ask for the displacement")
        value = self._value(self.block.fields[1].value, mesh, at)
        return float(value[0]) if len(value) == 1 else value

    @staticmethod
    def _value(function: fem.Function, mesh: NamedMesh, at: str) -> np.ndarray:
        space = function.function_space
        size = space.dofmap.index_map_bs
        nodes = fem.locate_dofs_topological(space, *mesh.at(at))
        owned = nodes[nodes < space.dofmap.index_map.size_local]
        found = mesh.comm.allgather(function.x.array.reshape(-1, size)[owned[:1]])
        return np.concatenate(found)[0]


def kinematics_of(mesh: NamedMesh, displacement: tuple[str, int], rotation: tuple[str, int] | None) -> Kinematics:
    """Spaces and fields of a mesh's parts: the angle in the plane, a quaternion in space.

    Parameters
    ----------
    displacement, rotation : family and degree of the spaces; rotation None: displacement alone
    """
    domain, dimension = mesh.domain, mesh.dimension
    cell = domain.basix_cell()
    vector = basix.ufl.element(displacement[0], cell, displacement[1], shape=(dimension,))
    u = fem.Function(fem.functionspace(domain, vector), name="displacement")
    if rotation is None:
        field = AdditiveField(u, np.arange(len(u.x.array)), mesh.size)
        return Kinematics(u, None, None, None, Block.of_space(u.function_space, field))
    turns = basix.ufl.element(rotation[0], cell, rotation[1], shape=() if dimension == 2 else (3,))
    space = fem.functionspace(domain, basix.ufl.mixed_element([vector, turns]))
    move = AdditiveField(u, _matching(u.function_space, space.sub(0), dimension), mesh.size)
    spin = fem.Function(fem.functionspace(domain, turns), name="rotation")
    spin_dofs = _matching(spin.function_space, space.sub(1), spin.function_space.dofmap.bs)
    if dimension == 2:
        turn = AdditiveField(spin, spin_dofs, 1.0)
        spatial = total = forms.rotation.PlanarRotation(spin)
    else:
        q = fem.Function(fem.functionspace(domain, (*rotation, (4,))), name="rotation")
        order = _matching(q.function_space, spin.function_space)
        turn = QuaternionField(q, spin, spin_dofs.reshape(-1, 3)[order].ravel())
        spatial, total = forms.rotation.SpatialRotation(q, spin), forms.rotation.SpatialRotation(q)
    return Kinematics(u, spin, spatial, total, Block.of_space(space, move, turn))


def _matching(space, other, width: int = 1) -> np.ndarray:
    """For each node of `space`, or each of `width` dofs at it, the entry of the other dofmap at the same place.

    The other space has the same element, or is that part of a mixed space: DOLFINx 0.9 forgets the order of nodes
    along edges when it collapses the part (degree 3 and above).
    """
    count = space.dofmap.index_map.size_local + space.dofmap.index_map.num_ghosts
    entries = np.empty(width * count, dtype=np.int64)
    own = width * space.dofmap.list[:, :, None] + np.arange(width)
    entries[own.ravel()] = other.dofmap.list.ravel()
    return entries
