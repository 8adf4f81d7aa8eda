"""Where the increments of all fields stand in the solver's vector."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from itertools import chain

import numpy as np
from dolfinx import la
from dolfinx.cpp.la.petsc import get_local_vectors, scatter_local_vectors
from mpi4py import MPI
from petsc4py import PETSc

from .. import compat
from ..communicators import lasting
from .nodal_field import AdditiveField
from .origins import SEVERAL, components
from .sharing import Sharing
from .unknowns import Block


class Layout:
    """Rows of the solver's vector: blocks one behind the other on each process.

    Vectors are taken apart into arrays, one for each block with the entries of this process and its ghosts. Rows of
    unknowns that are shared with other nodes stay zero: arrays have the values of those, and forces go there.

    Parameters
    ----------
    blocks : in their order
    fixed : for each block the local dofs whose increment is zero; None: none
    sharings : nodes that have the unknowns of others

    Attributes
    ----------
    comm : of all processes
    size, start : number of rows of this process, and global number of the first
    fixed : rows of this process whose increment is zero or another row's, counted from its first
    """

    def __init__(self, comm: MPI.Comm, blocks: Sequence[Block], fixed: Sequence[np.ndarray] | None = None,
                 sharings: Sequence[Sharing] = ()):
        self._blocks, self.comm, self._sharings = blocks, lasting(comm), sharings
        self._maps = [(b.index_map, b.width) for b in blocks]
        self._owned = [index_map.size_local * width for index_map, width in self._maps]
        self._offsets = np.concatenate(([0], np.cumsum(self._owned)))
        self.size = int(self._offsets[-1])
        self.start = self.comm.scan(self.size) - self.size
        self._shared = [s.entries(blocks) for s in sharings]
        fixed = list(fixed) if fixed is not None else [np.empty(0, dtype=np.int64) for _ in blocks]
        self._fixed, self._zero = [np.asarray(dofs) for dofs in fixed], self.rows(fixed)
        for block, dofs, _, _ in self._shared:
            fixed[block] = np.union1d(fixed[block], dofs)
        self.fixed = self.rows(fixed)

    def fixing(self, dofs: Sequence[np.ndarray]) -> Layout:
        """The same layout in which further local dofs of each block are fixed."""
        fixed = [np.union1d(before, more) for before, more in zip(self._fixed, dofs, strict=True)]
        return Layout(self.comm, self._blocks, fixed, self._sharings)

    def create_vector(self, values: np.ndarray | None = None) -> PETSc.Vec:
        """A vector, zero or with this process's part given."""
        vector = self._nothing.copy()  # a new one takes ten times as long, and messages
        if values is not None:
            vector.array[:] = values
        return vector

    @cached_property
    def _nothing(self) -> PETSc.Vec:
        return compat.create_vector(self._maps)

    def zeros(self) -> list[np.ndarray]:
        """An array for each block."""
        return [np.zeros((index_map.size_local + index_map.num_ghosts) * width) for index_map, width in self._maps]

    def arrays(self, vector: PETSc.Vec) -> list[np.ndarray]:
        """Arrays with the entries of a vector, whose ghosts are updated."""
        vector.ghostUpdate(addv=PETSc.InsertMode.INSERT, mode=PETSc.ScatterMode.FORWARD)
        arrays = get_local_vectors(vector, self._maps)
        for block, dofs, of_block, of_dofs in self._shared:
            arrays[block][dofs] = arrays[of_block][of_dofs]
        return arrays

    def everywhere(self, vector: PETSc.Vec) -> np.ndarray:
        """Entries of a vector of all processes, by their global numbers."""
        own = vector.array_r
        return own.copy() if self.comm.size == 1 else np.concatenate(self.comm.allgather(own))

    @cached_property
    def global_size(self) -> int:
        """Number of rows of all processes."""
        return self.comm.allreduce(self.size)

    def put(self, arrays: Sequence[np.ndarray], vector: PETSc.Vec) -> None:
        """Write arrays of increments into a vector and its ghosts on this process."""
        for block, dofs, _, _ in self._shared:
            arrays[block][dofs] = 0.0
        scatter_local_vectors(vector, arrays, self._maps)

    def gather(self, arrays: Sequence[np.ndarray], vector: PETSc.Vec) -> None:
        """Add up the forces on increments that the processes have in arrays, in a vector."""
        for block, dofs, of_block, of_dofs in self._shared:
            np.add.at(arrays[of_block], of_dofs, arrays[block][dofs])
        self.put(arrays, vector)
        vector.ghostUpdate(addv=PETSc.InsertMode.ADD, mode=PETSc.ScatterMode.REVERSE)

    def fields(self, *arrays: Sequence[np.ndarray]) -> list[tuple[AdditiveField, ...]]:
        """Each field with the arrays of its block."""
        return [(f, *own) for block, *own in zip(self._blocks, *arrays, strict=True) for f in block.fields]

    def held(self, field: AdditiveField) -> np.ndarray:
        """Which components of a field's nodal increments are fixed, shape (nodes, width)."""
        fixed = next(dofs for block, dofs in zip(self._blocks, self._fixed, strict=True) if field in block.fields)
        return np.isin(field.dofs, fixed).reshape(-1, field.width)

    def rows(self, dofs: Sequence[np.ndarray]) -> np.ndarray:
        """Rows of this process that belong to local dofs of each block."""
        return np.concatenate([offset + d[d < owned] for d, owned, offset in zip(
            dofs, self._owned, self._offsets[:-1], strict=True)]).astype(np.int32)

    def origins(self) -> np.ndarray:
        """What tells the rows of this process on any number of processes, see `discrete.origins`."""
        arrays = [array.astype(np.int64) for array in self.zeros()]
        for number, (field, array) in enumerate(self.fields(arrays)):
            array[field.dofs] = number * SEVERAL + components(field.origins, field.width)
        return np.concatenate([a[:owned] for a, owned in zip(arrays, self._owned, strict=True)])

    @cached_property
    def numbers(self) -> list[np.ndarray]:
        """For each block the global numbers of its entries on this process and its ghosts."""
        numbers = []
        for (index_map, width), owned, offset in zip(self._maps, self._owned, self._offsets[:-1], strict=True):
            number = la.vector(index_map, width)
            number.array[:owned] = self.start + offset + np.arange(owned)
            number.scatter_forward()
            numbers.append(np.rint(number.array).astype(np.int64))
        return numbers

    @cached_property
    def field_numbers(self) -> list[np.ndarray]:
        """For each field the global numbers of its nodes' increments, shape (nodes, width)."""
        return [array[f.dofs].reshape(-1, f.width) for f, array in self.fields(self.numbers)]

    def free(self, numbers: np.ndarray) -> np.ndarray:
        """Global numbers of the unknowns themselves; -1, which matrices leave out, where the increment is zero."""
        own, others = self._all_shared
        if len(own):
            place = np.minimum(np.searchsorted(own, numbers), len(own) - 1)
            numbers = np.where(own[place] == numbers, others[place], numbers)
        return np.where(np.isin(numbers, self._all_zero), -1, numbers)

    @cached_property
    def _all_zero(self) -> np.ndarray:
        return np.concatenate(self.comm.allgather(self._zero + self.start))

    @cached_property
    def _all_shared(self) -> tuple[np.ndarray, np.ndarray]:
        """Global numbers of entries that share the unknowns of others, in ascending order, and of these."""
        pairs = [np.column_stack((self.numbers[block][dofs], self.numbers[of_block][of_dofs]))
                 for block, dofs, of_block, of_dofs in self._shared]
        pairs = np.concatenate([np.empty((0, 2), dtype=np.int64), *chain(*self.comm.allgather(pairs))])
        own, first = np.unique(pairs[:, 0], return_index=True)
        return own, pairs[first, 1]

    @cached_property
    def free_numbers(self) -> list[np.ndarray]:
        """`field_numbers` with -1 where the increment is zero."""
        return [self.free(numbers) for numbers in self.field_numbers]

    def starts(self) -> np.ndarray:
        """Global number of the first row of each block on each process, shape (processes, blocks)."""
        return np.array(self.comm.allgather((self.start + self._offsets[:-1]).tolist()), dtype=np.int64)

    def turning_matrix(self) -> PETSc.Mat | None:
        """Matrix from increments to motions along the directions of space, for `turn`; None: always the identity."""
        if not self.comm.allreduce(any(f.axes is not None for f in self._fields), op=MPI.LOR):
            return None
        rows, columns = [], []
        for field, own in zip(self._fields, self._own_numbers, strict=True):
            shape = (*own.shape, field.width)
            rows.append(np.broadcast_to(own[:, :, None], shape).ravel())
            columns.append(np.broadcast_to(own[:, None, :], shape).ravel())
        return compat.create_coo_matrix(self.comm, self.size, np.concatenate(rows), np.concatenate(columns))

    def turn(self, matrix: PETSc.Mat) -> None:
        """Give a turning matrix the values of the present configuration."""
        values = []
        for field, own in zip(self._fields, self._own_numbers, strict=True):
            motions = field.motions()
            motions = np.eye(field.width)[None] if motions is None else motions[: len(own)]
            values.append(np.broadcast_to(motions, (*own.shape, field.width)).ravel())
        compat.set_coo_values(matrix, np.concatenate(values))

    @property
    def _fields(self) -> list[AdditiveField]:
        return [f for block in self._blocks for f in block.fields]

    @cached_property
    def _own_numbers(self) -> list[np.ndarray]:
        """`field_numbers` of the nodes of this process, which come before its ghosts."""
        return [numbers[(numbers[:, 0] >= self.start) & (numbers[:, 0] < self.start + self.size)]
                for numbers in self.field_numbers]
