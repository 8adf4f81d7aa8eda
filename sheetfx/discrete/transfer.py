"""From one discretisation of a structure to another: fields at the nodes, history at the points of integration.

Displacements and planar angles of a mesh whose cells lie within straight ones of the other, with polynomials of at
least the same degree, come over exactly. Quaternions are interpolated and put back to unit length: rotations come over
exactly to nodes, but between these they change a little.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from petsc4py import PETSc

from ..mesh.places import Places
from ..mesh.reader import NamedMesh
from .discretisation import Discretisation
from .nodal_field import AdditiveField, QuaternionField
from .number import NumberField
from .section_forces import section_points

ALIGNED = 0.99  # cosine of the angle between axes of points, of which one remembers what the other did


class Transfer:
    """States and increments of one scene's discretisation on another's.

    Parameters
    ----------
    source, target : of scenes with the same structure; on other meshes, of other degrees, with other joints or contacts

    Raises
    ------
    ValueError
        If a mesh of the target has no counterpart.
    """

    def __init__(self, source: Discretisation, target: Discretisation):
        self._source, self._target = source, target
        self._meshes = _counterparts(source.scene.meshes, target.scene.meshes)
        self._on_same = list(self._meshes) == list(self._meshes.values())
        self._pairs: list[tuple[AdditiveField, AdditiveField, Places | None]] = []
        for other, mesh in self._meshes.items():
            mine = {field.name: field for field in source.kinematics(mesh).block.fields}
            for field in target.kinematics(other).block.fields:
                if (own := mine.get(field.name)) is not None:
                    self._pairs.append((own, field, self._places(own, field, mesh, other)))

    def _places(self, own: AdditiveField, field: AdditiveField, mesh: NamedMesh, other: NamedMesh) -> Places | None:
        """Of the nodes of a field that this process owns; None: they are the other field's."""
        space = field.value.function_space
        if mesh is other and own.value.function_space.ufl_element() == space.ufl_element():
            return None
        owned, table = space.dofmap.index_map.size_local, space.dofmap.list
        for _, known, places in self._pairs:
            before = known.value.function_space
            if places and before.mesh is space.mesh and np.array_equal(before.dofmap.list, table):
                return places
        cells = np.zeros(owned + space.dofmap.index_map.num_ghosts, dtype=np.int64)
        cells[table[::-1].ravel()] = np.repeat(np.arange(len(table))[::-1], table.shape[1])  # the first one of a node
        return Places(mesh, other, cells[:owned], space.tabulate_dof_coordinates()[:owned, :other.dimension])

    def snapshot(self, fields: dict[str, np.ndarray], factor: float) -> dict[str, np.ndarray]:
        """Snapshot of the target's system at a state of the source.

        Rotations that the source has not, and multipliers of other meshes, are none.

        Parameters
        ----------
        fields : snapshot of the source's system
        factor : load factor of the target

        Raises
        ------
        ValueError
            If what laws remember belongs to axes that the target has not.
        """
        source, target = self._source.system, self._target.system
        source.restore(fields)
        found = target.snapshot()
        found |= {name: fields[name].copy() for name, values in found.items()
                  if name in fields and fields[name].shape == values.shape and (self._on_same or values.size == 1)}
        for own, field, places in self._pairs:
            values = field.create_change()
            values.x.array[:] = _interpolated(own, own.table, field, places).ravel()
            values.x.scatter_forward()
            table = values.x.array.reshape(-1, field.components)
            found[target.history.key(field)] = field.holding(table, self._target.layout.held(field)).ravel()
        found["load"] = np.array([fields["load"][0], factor])
        target.restore(found)
        return found | (self._remembered(fields) if source.history.moved else {})

    def increments(self, vector: np.ndarray) -> PETSc.Vec:
        """The target's increments that move and turn its nodes as the source's do; both at the same state."""
        source, target = self._source, self._target
        motions = dict(zip(source.unknowns.fields, source.system.motions(source.system.create_vector(vector)),
                           strict=True))
        found = {field: _interpolated(own, motions[own], field, places) for own, field, places in self._pairs}
        numbers = {source.system.history.key(f): moved for f, moved in motions.items() if isinstance(f, NumberField)}
        for field in target.unknowns.fields:
            moved = numbers.get(target.system.history.key(field))
            if moved is not None and moved.size == len(field.dofs) and (self._on_same or moved.size == 1):
                found[field] = moved
        step = target.system.step_by([found.get(f, np.zeros((len(f.dofs) // f.width, f.width)))
                                      for f in target.unknowns.fields])
        step.array[target.system.fixed_rows] = 0
        return step

    def _remembered(self, fields: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
        """What laws of the target remember: as the nearest points of integration of the source."""
        found = {}
        for number, part in enumerate(self._target.scene.parts):
            work = self._target.work_of(part)
            if not work.remembers:
                continue
            mesh = self._meshes[part.mesh]
            like = next((n for n, p in enumerate(self._source.scene.parts)
                         if p.mesh is mesh and p.group == part.group and self._source.work_of(p).remembers), None)
            if like is None:
                continue
            kept = fields[f"history of part {like} 0"]
            found[f"history of part {number} 0"] = self._nearest(self._source.scene.parts[like], part, kept)
        return found

    def _nearest(self, mine, part, kept: np.ndarray) -> np.ndarray:
        """History at points of a part of the target, from a part of the source, (cells, points, values)."""
        source, target = section_points(self._source, mine), section_points(self._target, part)
        cells = part.mesh.group(part.group)
        count, width = target.reference.shape[1], target.axes.shape[2:]
        places = Places(mine.mesh, part.mesh, np.repeat(cells, count),
                        target.reference.reshape(-1, part.mesh.dimension))
        rows = np.full(len(mine.mesh.group(None)), -1)
        rows[mine.mesh.group(mine.group)] = np.arange(len(kept))
        points = self._source.work_of(mine).points

        def of(which: np.ndarray, reference: np.ndarray) -> np.ndarray:
            point = np.argmin(np.linalg.norm(reference[:, None] - points, axis=2), axis=1)
            place = rows[which], point
            return np.concatenate((kept[place], source.axes[place].reshape(len(which), -1)), axis=1)

        values = places.values(of)
        axes = values[:, kept.shape[2]:].reshape(-1, *width)
        if (np.einsum("nad,nad->na", axes, target.axes.reshape(axes.shape)) < ALIGNED).any():
            raise ValueError(f"{type(part).__name__}: what points of {part.group or 'all cells'} remember belongs to "
                             "other axes on the other mesh; give the part axes of its own in both scenes, as by `axis`")
        return values[:, :kept.shape[2]].reshape(len(cells), count, -1)


def _counterparts(source: Sequence[NamedMesh], target: Sequence[NamedMesh]) -> dict[NamedMesh, NamedMesh]:
    """For each mesh of the target the same mesh of the source, or the one in its place."""
    if all(mesh in source for mesh in target):
        return {mesh: mesh for mesh in target}
    if len(source) != len(target) or [m.dimension for m in source] != [m.dimension for m in target]:
        raise ValueError(f"state.on: its scene has {len(source)} meshes and the other one {len(target)}; give a scene "
                         "with as many, in the same order and with as many dimensions")
    return dict(zip(target, source, strict=True))


def _interpolated(own: AdditiveField, nodal: np.ndarray, field: AdditiveField, places: Places | None) -> np.ndarray:
    """Nodal values of a field at the nodes of another one on this process and its ghosts, zero at the latter."""
    if places is None:
        return nodal.copy()
    space = own.value.function_space
    element, table = space.ufl_element().basix_element, space.dofmap.list
    turns = isinstance(own, QuaternionField) and nodal.shape[1] == 4

    def of(cells: np.ndarray, reference: np.ndarray) -> np.ndarray:
        values = nodal[table[cells]]
        if turns:  # q and -q are one rotation
            values = values * np.where(np.einsum("nka,na->nk", values, values[:, 0]) < 0, -1.0, 1.0)[..., None]
        shapes = element.tabulate(0, reference)[0, :, :, 0] if len(cells) else np.zeros((0, table.shape[1]))
        return np.einsum("nk,nka->na", shapes, values)

    found = places.values(of)
    out = np.zeros((len(field.dofs) // field.width, nodal.shape[1]))
    out[:len(found)] = found / np.linalg.norm(found, axis=1, keepdims=True) if turns else found
    return out
