"""Where the increments of all fields stand in the solver's vector."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property

import numpy as np
from dolfinx import fem
from dolfinx.cpp.la.petsc import get_local_vectors, scatter_local_vectors
from mpi4py import MPI
from petsc4py import PETSc

from .. import compat
from .unknowns import AdditiveField, Block


class Layout:
    """Rows of the solver's vector: blocks one behind the other on each process.

    Vectors are taken apart into arrays, one for each block with the entries of this process and its ghosts.

    Attributes
    ----------
    comm : of all processes
    size, start : number of rows of this process, and global number of the first
    """

    def __init__(self, blocks: Sequence[Block]):
        self._blocks, self.comm = blocks, blocks[0].space.mesh.comm
        self._maps = [(b.space.dofmap.index_map, b.space.dofmap.index_map_bs) for b in blocks]
        self._owned = [index_map.size_local * width for index_map, width in self._maps]
        self._offsets = np.concatenate(([0], np.cumsum(self._owned)))
        self.size = int(self._offsets[-1])
        self.start = self.comm.scan(self.size) - self.size

    def create_vector(self, values: np.ndarray | None = None) -> PETSc.Vec:
        """A vector, zero or with this process's part given."""
        vector = compat.create_vector(self._maps)
        if values is not None:
            vector.array[:] = values
        return vector

    def zeros(self) -> list[np.ndarray]:
        """An array for each block."""
        return [np.zeros((index_map.size_local + index_map.num_ghosts) * width) for index_map, width in self._maps]

    def arrays(self, vector: PETSc.Vec) -> list[np.ndarray]:
        """Arrays with the entries of a vector, whose ghosts are updated."""
        vector.ghostUpdate(addv=PETSc.InsertMode.INSERT, mode=PETSc.ScatterMode.FORWARD)
        return get_local_vectors(vector, self._maps)

    def put(self, arrays: Sequence[np.ndarray], vector: PETSc.Vec) -> None:
        """Write arrays into a vector and its ghosts on this process."""
        scatter_local_vectors(vector, arrays, self._maps)

    def fields(self, *arrays: Sequence[np.ndarray]) -> list[tuple[AdditiveField, ...]]:
        """Each field with the arrays of its block."""
        return [(f, *own) for block, *own in zip(self._blocks, *arrays, strict=True) for f in block.fields]

    def rows(self, dofs: Sequence[np.ndarray]) -> np.ndarray:
        """Rows of this process that belong to local dofs of each block."""
        return np.concatenate([offset + d[d < owned] for d, owned, offset in zip(
            dofs, self._owned, self._offsets[:-1], strict=True)]).astype(np.int32)

    @cached_property
    def places(self) -> list[np.ndarray]:
        """For each field the global numbers of its nodes' increments, shape (nodes, width)."""
        numbers = []
        for block, owned, offset in zip(self._blocks, self._owned, self._offsets[:-1], strict=True):
            number = fem.Function(block.space)
            number.x.array[:owned] = self.start + offset + np.arange(owned)
            number.x.scatter_forward()
            numbers.append(number.x.array)
        return [np.rint(array[f.dofs]).astype(np.int64).reshape(-1, f.width) for f, array in self.fields(numbers)]

    def turning_matrix(self) -> PETSc.Mat | None:
        """Matrix from components along the axes of the nodes to those along the directions of space; None: identity."""
        fields = [f for block in self._blocks for f in block.fields]
        if not self.comm.allreduce(any(f.axes is not None for f in fields), op=MPI.LOR):
            return None
        rows, columns, values = [], [], []
        for field, place in zip(fields, self.places, strict=True):
            own = place[(place[:, 0] >= self.start) & (place[:, 0] < self.start + self.size)]
            axes = np.broadcast_to(np.eye(field.width) if field.axes is None else field.axes,
                                   (*place.shape, field.width))
            shape = (*own.shape, field.width)
            rows.append(np.broadcast_to(own[:, :, None], shape).ravel())
            columns.append(np.broadcast_to(own[:, None, :], shape).ravel())
            values.append(axes[: len(own)].ravel())
        matrix = compat.create_coo_matrix(self.comm, self.size, np.concatenate(rows), np.concatenate(columns))
        compat.set_coo_values(matrix, np.concatenate(values))
        return matrix
