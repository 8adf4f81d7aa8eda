"""Supports as fixed components of nodal increments, along axes that nodes may have of their own."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from dolfinx import fem

from ..communicators import lasting
from ..mesh.reader import COMPONENTS, NamedMesh
from ..model.loads import PrescribedDisplacement
from ..model.supports import Support
from .fields import Fields
from .kinematics import Kinematics
from .nodal_field import AdditiveField, QuaternionField
from .partly_fixed import PartlyFixed, directions_of_edges
from .sharing import Sharing, share_marks

SAME = 1e-8  # squared sine of the angle between directions that count as one
SURELY_NEW = 0.3  # squared sine of an axis of space to those before: of the three at least one has a third


def turn_nodes(kinematics: Kinematics, supports: Sequence[Support]) -> None:
    """Give the nodes of supports with axes of their own axes that hold what all supports there hold.

    These are the axes of the first such support. Where they leave a direction oblique that another support holds, the
    first axes are an orthonormal basis of all directions that are held there, as at an oblique corner of two edges.
    """
    for number, field in enumerate(kinematics.block.fields):
        holding = [s for s in supports if _components(kinematics, s)[number]]
        if all(s.axes is None for s in holding):
            continue
        axes = np.tile(np.eye(3), (len(field.dofs) // field.width, 1, 1))
        turned = np.zeros(len(axes), dtype=bool)
        for support in holding:
            if support.axes is not None:
                nodes = _nodes(field, support)
                nodes = nodes[~turned[nodes]]
                axes[nodes], turned[nodes] = _directions(field, support, nodes), True
        inside = _inside(kinematics, supports, number, axes)
        oblique = np.flatnonzero((inside * (1 - inside) > SAME).any(axis=1))
        held: dict[int, list[np.ndarray]] = {node: [] for node in oblique}
        for nodes, directions in _held_along(kinematics, holding, number):
            for node, columns in zip(nodes, directions, strict=True):
                if node in held:
                    held[node] += [*columns.T]
        for node, directions in held.items():
            axes[node] = _basis(directions)
        field.axes = axes


def _held_along(kinematics: Kinematics, supports: Sequence[Support],
                number: int) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """Nodes of each support and the directions, as columns, along which it holds a field of the kinematics."""
    field = kinematics.block.fields[number]
    for support in supports:
        if components := _components(kinematics, support)[number]:
            nodes = _nodes(field, support)
            yield nodes, _directions(field, support, nodes)[:, :, components]


def _inside(kinematics: Kinematics, supports: Sequence[Support], number: int, axes: np.ndarray) -> np.ndarray:
    """Squared cosines between axes of the nodes and the span of all that supports hold there, shape (nodes, 3)."""
    sums = np.zeros_like(axes)
    for nodes, directions in _held_along(kinematics, supports, number):
        sums[nodes] += np.einsum("nik,njk->nij", directions, directions)
    sizes, bases = np.linalg.eigh(sums)
    within = np.where(sizes[:, None, :] > SAME / 2, bases, 0.0)  # two directions at an angle a: the lesser is a^2 / 2
    return (np.einsum("nik,nij->nkj", within, axes)**2).sum(axis=1)


def _basis(directions: Sequence[np.ndarray]) -> np.ndarray:
    """Right-handed orthonormal basis, as columns: first of some directions, then across them.

    By Gram and Schmidt, so that all processes that know a node choose the same.
    """
    basis: list[np.ndarray] = []
    for candidate, least in [*((d, SAME) for d in directions), *((e, SURELY_NEW) for e in np.eye(3))]:
        rest = candidate - sum((b * (b @ candidate) for b in basis), np.zeros(3))
        if rest @ rest > least and len(basis) < 3:
            basis.append(rest / np.linalg.norm(rest))
    basis[2] *= np.sign(np.linalg.det(basis))
    return np.column_stack(basis)


def fixed_dofs(fields: Fields, sharings: Sequence[Sharing]) -> list[np.ndarray]:
    """Local dofs of each block that supports fix, or that those who added the block have fixed.

    Rotations of which one component is fixed then turn as `PartlyFixed` says.
    """
    kinematics = {mesh: fields.kinematics(mesh) for mesh in fields.meshes}
    _leave_held_nodes(fields)
    by_supports = {k.block: [fixed_by(k, s) for s in fields.scene.supports if s.mesh is mesh]
                   for mesh, k in kinematics.items()}
    for mesh, k in kinematics.items():
        if by_supports[k.block]:
            supports = [s for s in fields.scene.supports if s.mesh is mesh]
            _refuse_oblique(k, supports, np.concatenate(by_supports[k.block]))
    dofs = [np.unique(np.concatenate([np.empty(0, dtype=np.int64), *fields.fixed.get(block, []),
                                      *by_supports.get(block, [])])) for block in fields.blocks]
    dofs = share_marks(sharings, fields.blocks, dofs)
    fixed = dict(zip(fields.blocks, dofs, strict=True))
    turning = {f: mesh for mesh, k in kinematics.items() for f in k.block.fields if f.curved}
    _hold(turning, {f: np.isin(f.dofs, fixed[kinematics[mesh].block]).reshape(-1, 3) for f, mesh in turning.items()},
          fields.scene.supports, sharings)
    return dofs


def _leave_held_nodes(fields: Fields) -> None:
    """Let no motion be prescribed at nodes where supports on axes of their own hold its component: nodes stay there."""
    for load in fields.scene.all_loads:
        if not isinstance(load, PrescribedDisplacement):
            continue
        mesh, supports = load.mesh, [s for s in fields.scene.supports if s.mesh is load.mesh]
        if all(s.axes is None for s in supports):
            continue
        kinematics, own = fields.kinematics(mesh), fields.own_field(load, "reaction")
        table = kinematics.u.function_space.dofmap.list
        axes = np.tile(np.eye(3), (len(kinematics.u.x.array) // 3, 1, 1))
        held = _inside(kinematics, supports, 0, axes)[:, COMPONENTS[3].index(load.component)] > 1 - SAME
        block = next(b for b in fields.blocks if b.fields[0] is own)
        fields.fixed[block].append(own.dofs[np.unique(own.value.function_space.dofmap.list[held[table]])])


def _hold(turning: dict[QuaternionField, NamedMesh], fixed: dict[QuaternionField, np.ndarray],
          supports: Sequence[Support], sharings: Sequence[Sharing]) -> None:
    """Let the nodes of fields of which one component is fixed turn as `PartlyFixed` says."""
    directions = {}
    for field, mesh in turning.items():
        if mesh.comm.allreduce(int((fixed[field].sum(axis=1) == 1).sum())):
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
    """Local dofs of the nodal increments that a support holds, with others where its node has axes across its own."""
    dofs = [np.empty(0, dtype=np.int64)]
    for field, components in zip(kinematics.block.fields, _components(kinematics, support), strict=True):
        if not components:
            continue
        nodes, table = _nodes(field, support), field.dofs.reshape(-1, field.width)
        if field.axes is None:
            dofs.append(table[nodes][:, components].ravel())
            continue
        along = np.einsum("nki,nkj->nij", _axes(field)[nodes], _directions(field, support, nodes)[:, :, components])
        dofs.append(table[nodes][(along**2).sum(axis=2) > SAME])
    return np.unique(np.concatenate(dofs))


def _axes(field: AdditiveField) -> np.ndarray:
    """Axes of nodes in the reference configuration."""
    axes = field.axes.copy()
    if field.curved and field.partly_fixed is not None:
        axes[field.partly_fixed.nodes] = field.partly_fixed.start
    return axes


def _refuse_oblique(kinematics: Kinematics, supports: Sequence[Support], fixed: np.ndarray) -> None:
    """Refuse supports across the axes that their nodes share with another mesh: more would be fixed than they hold.

    Parameters
    ----------
    fixed : local dofs of the kinematics that the supports fix

    Raises
    ------
    ValueError
        On all processes, where one has such a node.
    """
    comm, found = lasting(kinematics.block.space.mesh.comm), []
    for number, field in enumerate(kinematics.block.fields):
        if field.axes is not None:
            inside = _inside(kinematics, supports, number, _axes(field))
            wrong = (np.isin(field.dofs, fixed).reshape(-1, 3) & (inside < 1 - SAME)).any(axis=1)
            found += [s.at for s in supports if _components(kinematics, s)[number] and wrong[_nodes(field, s)].any()]
    if names := [name for rank in comm.allgather(found) for name in rank]:
        raise ValueError(f"Support at {names[0]!r}: its axes differ from those of the mesh whose unknowns its nodes "
                         "share; give both the same axes")


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
