"""Supports as fixed components of nodal increments, along axes that nodes may have of their own."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from dolfinx import fem

from ..mesh.reader import COMPONENTS, NamedMesh
from ..model.supports import Support
from .fields import Fields
from .kinematics import Kinematics
from .nodal_field import AdditiveField, QuaternionField
from .partly_fixed import PartlyFixed, directions_of_edges
from .sharing import Sharing, share_marks


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


def fixed_dofs(fields: Fields, sharings: Sequence[Sharing]) -> list[np.ndarray]:
    """Local dofs of each block that supports fix, or that those who added the block have fixed.

    Rotations of which one component is fixed then turn as `PartlyFixed` says.
    """
    kinematics = {mesh: fields.kinematics(mesh) for mesh in fields.meshes}
    by_supports = {k.block: [fixed_by(k, s) for s in fields.scene.supports if s.mesh is mesh]
                   for mesh, k in kinematics.items()}
    dofs = [np.unique(np.concatenate([np.empty(0, dtype=np.int64), *fields.fixed.get(block, []),
                                      *by_supports.get(block, [])])) for block in fields.blocks]
    dofs = share_marks(sharings, fields.blocks, dofs)
    fixed = dict(zip(fields.blocks, dofs, strict=True))
    turning = {f: mesh for mesh, k in kinematics.items() for f in k.block.fields if f.curved}
    _hold(turning, {f: np.isin(f.dofs, fixed[kinematics[mesh].block]).reshape(-1, 3) for f, mesh in turning.items()},
          fields.scene.supports, sharings)
    return dofs


def _hold(turning: dict[QuaternionField, NamedMesh], fixed: dict[QuaternionField, np.ndarray],
          supports: Sequence[Support], sharings: Sequence[Sharing]) -> None:
    """Let the nodes of fields of which one component is fixed turn as `PartlyFixed` says."""
    directions = {}
    for field, mesh in turning.items():
        if mesh.domain.comm.allreduce(int((fixed[field].sum(axis=1) == 1).sum())):
            edges = {s.at for s in supports if s.mesh is mesh and s.at in mesh.edges and _turns(s)}
            directions[field] = directions_of_edges(mesh, sorted(edges), field.value.function_space)
    for sharing in sharings:
        if sharing.field in directions and sharing.of in directions:
            directions[sharing.field][sharing.nodes] = directions[sharing.of][sharing.of_nodes]
    for field, along in directions.items():
        nodes = np.flatnonzero(fixed[field].sum(axis=1) == 1)
        axes = np.broadcast_to(np.eye(3), (len(nodes), 3, 3)) if field.axes is None else field.axes[nodes]
        field.hold(PartlyFixed(nodes, fixed[field][nodes].argmax(axis=1), axes, along[nodes]))


def fixed_by(kinematics: Kinematics, support: Support) -> np.ndarray:
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
        fixed, axes = _directions(field, support, nodes)[:, :, components], field.axes.copy()
        if field.curved and field.partly_fixed is not None:
            axes[field.partly_fixed.nodes] = field.partly_fixed.start
        along = np.einsum("nki,nkj->nij", axes[nodes], fixed)
        chosen = np.isclose((along**2).sum(axis=2), 1.0, atol=1e-8)
        if not np.all(chosen.sum(axis=1) == len(components)):
            raise ValueError(f"Support at {support.at!r}: its axes differ from those of another support there, and "
                             "those do not fix the same; give both the same axes")
        dofs.append(table[nodes][chosen])
    return np.unique(np.concatenate(dofs))


def _turns(support: Support) -> bool:
    """Whether a support fixes a component of the rotation."""
    return any(name.startswith("r") for name in support.fixed.split())


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
