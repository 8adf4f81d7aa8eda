"""Supports as fixed components of nodal increments, along axes that nodes may have of their own."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from dolfinx import fem

from ..mesh.reader import COMPONENTS
from ..model.supports import Support
from .fields import Fields
from .kinematics import Kinematics
from .nodal_field import AdditiveField
from .unknowns import Block


def turn_nodes(kinematics: Kinematics, supports: Sequence[Support]) -> None:
    """Give the nodes of supports with axes of their own these axes; where several meet, those of the first."""
    for field in kinematics.block.fields:
        turned = np.zeros(len(field.dofs) // field.width, dtype=bool)
        for support in supports:
            if support.axes is None:
                continue
            if field.axes is None:
                field.axes = np.tile(np.eye(3), (len(turned), 1, 1))
            nodes = _nodes(field, support)
            nodes = nodes[~turned[nodes]]
            field.axes[nodes] = _directions(field, support, nodes)
            turned[nodes] = True


def fixed_dofs(fields: Fields, block: Block) -> np.ndarray:
    """Local dofs of a block that supports fix, or that those who added the block have fixed.

    Rotations of which one component is fixed are then followed by their Rodrigues vector.
    """
    dofs = [np.empty(0, dtype=np.int64), *fields.fixed.get(block, [])]
    for mesh in fields.meshes:
        kinematics = fields.kinematics(mesh)
        if kinematics.block is block:
            dofs += [_fixed_by(kinematics, s) for s in fields.scene.supports if s.mesh is mesh]
    found = np.unique(np.concatenate(dofs))
    for field in block.fields:
        if field.curved:
            field.charted = np.isin(field.dofs, found).reshape(-1, field.width).sum(axis=1) == 1
    return found


def _fixed_by(kinematics: Kinematics, support: Support) -> np.ndarray:
    """Local dofs of the nodal increments that a support fixes.

    Raises
    ------
    ValueError
        Where a node has the axes of another support, which do not fix the same.
    """
    dofs = [np.empty(0, dtype=np.int64)]
    for field, components in zip(kinematics.block.fields, _components(kinematics, support), strict=True):
        if not components:
            continue
        nodes, table = _nodes(field, support), field.dofs.reshape(-1, field.width)
        if field.axes is None:
            dofs.append(table[nodes][:, components].ravel())
            continue
        fixed = _directions(field, support, nodes)[:, :, components]
        along = np.einsum("nki,nkj->nij", field.axes[nodes], fixed)
        chosen = np.isclose((along**2).sum(axis=2), 1.0, atol=1e-8)
        if not np.all(chosen.sum(axis=1) == len(components)):
            raise ValueError(f"Support at {support.at!r}: its axes differ from those of another support there, and "
                             "those do not fix the same; give both the same axes")
        dofs.append(table[nodes][chosen])
    return np.unique(np.concatenate(dofs))


def _components(kinematics: Kinematics, support: Support) -> list[list[int]]:
    """For displacement and rotation the numbers of the components that a support names."""
    names, dimension = COMPONENTS[support.mesh.dimension], support.mesh.dimension
    groups = [names[:dimension], names[dimension:]][:len(kinematics.block.fields)]
    wanted = support.fixed.split()
    return [[i for i, name in enumerate(group) if name in wanted] for group in groups]


def _nodes(field: AdditiveField, support: Support) -> np.ndarray:
    return fem.locate_dofs_topological(field.value.function_space, *support.mesh.at(support.at))


def _directions(field: AdditiveField, support: Support, nodes: np.ndarray) -> np.ndarray:
    """Directions that a support's components stand for, as columns, shape (nodes, 3, 3)."""
    if support.axes is None:
        return np.broadcast_to(np.eye(3), (len(nodes), 3, 3))
    places = field.value.function_space.tabulate_dof_coordinates()[nodes]
    return support.directions(places).transpose(0, 2, 1)
