"""From contributions to PETSc: residual, tangent and load vector of a problem."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, nullcontext
from itertools import zip_longest

import numpy as np
from mpi4py import MPI
from petsc4py import PETSc
from scipy.sparse import csr_matrix

from .. import compat
from .contribution import Contribution, Forces
from .curvature import curvature
from .form_work import FormMatrix
from .history import History
from .layout import Layout
from .load_factors import LoadFactors
from .nodal_field import AdditiveField
from .timing import Stopwatch
from .unknowns import Unknowns


class System:
    """Discrete equilibrium R(x, factor) = 0 in increments x since the last converged state: a sum of contributions.

    Parameters
    ----------
    unknowns : Unknowns
    contributions : of the sum
    layout : rows of the unknowns, and which of them are fixed
    factors : load factors of the stages

    Attributes
    ----------
    smooth, conservative : whether all contributions are
    steep : contributions that are
    rough : contributions that are not smooth, laws of parts aside
    history : History of fields and contributions
    size : number of free unknowns
    fixed_rows : of fixed unknowns in this process's part of a vector
    multiplier_rows : of free Lagrange multipliers in this process's part of a vector
    multipliers : number of Lagrange multipliers; each gives the tangent one negative pivot
    matrix : the tangent
    """

    def __init__(self, unknowns: Unknowns, contributions: Sequence[Contribution], layout: Layout,
                 factors: LoadFactors, clock: Stopwatch):
        self.unknowns, self.contributions, self.factors, self.clock = unknowns, list(contributions), factors, clock
        self.smooth = all(c.smooth for c in contributions)
        self.conservative = all(c.conservative for c in contributions)
        self.steep = [c for c in contributions if c.steep]
        self.rough = [c for c in contributions if not (c.smooth or c.kinks)]
        self.history = History(unknowns.fields, contributions)
        self._layout = layout
        self.fixed_rows = layout.fixed
        self.size = self.comm.allreduce(layout.size - len(self.fixed_rows))
        self.multiplier_rows = self.free_rows(lambda field: field.multiplier)
        self.multipliers = self.comm.allreduce(len(self.multiplier_rows))
        self.matrix = self._steep_pattern = None
        self._create_matrix()
        self.weights = self._inner_product_weights()
        self.reaction = 0.0

    @property
    def comm(self):
        return self._layout.comm

    @property
    def factor(self) -> float:
        """The load factor of the present configuration."""
        return self.factors.now

    @property
    def work_known(self) -> bool:
        """Whether there are contributions that are not smooth, laws of parts aside, and all tell their work."""
        return bool(self.rough) and all(c.conservative or c in self.rough for c in self.contributions) and all(
            c.touch() is not None for c in self.rough)

    def free_rows(self, wanted: Callable[[AdditiveField], bool]) -> np.ndarray:
        """Rows of the free increments of some fields in this process's part of a vector."""
        marks, vector = self._layout.zeros(), self.create_vector()
        for f, array in self._layout.fields(marks):
            array[f.dofs] = wanted(f)
        self._layout.put(marks, vector)
        vector.array[self.fixed_rows] = 0
        return np.flatnonzero(vector.array > 0.5)

    def _create_matrix(self) -> None:
        """A matrix for the entries of all contributions, one behind the other, and of the nodes' rotations."""
        patterns = [c.pattern(self._layout) for c in self.contributions]
        for numbers, field in zip(self._layout.free_numbers, self.unknowns.fields, strict=True):
            if field.curved:
                shape = (*numbers.shape, field.width)
                patterns.append((np.broadcast_to(numbers[:, :, None], shape).ravel(),
                                 np.broadcast_to(numbers[:, None, :], shape).ravel()))
        rows, columns = (np.concatenate(parts) for parts in zip(*patterns, strict=True))
        self.matrix = compat.create_coo_matrix(self.comm, self._layout.size, rows, columns, self.matrix)
        if self.conservative:
            self.matrix.setOption(PETSc.Mat.Option.SYMMETRIC, True)
            self.matrix.setOption(PETSc.Mat.Option.SYMMETRY_ETERNAL, True)

    def _inner_product_weights(self) -> PETSc.Vec:
        """Weights that make increments of translations and rotations commensurate.

        Each field counts with the mean square of its nodal increments over its scale; fixed increments do not.
        """
        weights, arrays = self.create_vector(), self._layout.zeros()
        for f, array in self._layout.fields(arrays):
            array[f.dofs] = 1 / (f.scale**2 * f.count)
        self._layout.put(arrays, weights)
        weights.array[self.fixed_rows] = 0
        return weights

    def create_vector(self, values: np.ndarray | None = None) -> PETSc.Vec:
        """A vector of increments, zero or with this process's part given."""
        return self._layout.create_vector(values)

    def everywhere(self, vector: PETSc.Vec) -> np.ndarray:
        """Entries of a vector of all processes, by their global numbers."""
        return self._layout.everywhere(vector)

    def own(self, entries: np.ndarray) -> np.ndarray:
        """Of entries of all processes this process's part."""
        return entries[self._layout.start:self._layout.start + self._layout.size]

    def configure(self, x: PETSc.Vec, factor: float) -> None:
        """Put all fields to the last converged state followed by the increments x, and the load factor to a value."""
        self.factors.set(factor)
        for f, array in self._layout.fields(self._layout.arrays(x)):
            f.advance(array)

    def retract(self, x: PETSc.Vec, step: PETSc.Vec) -> None:
        """Follow the increments x (changed in place) by a further step."""
        totals = self._layout.arrays(x)
        for f, total, further in self._layout.fields(totals, self._layout.arrays(step)):
            f.combine(total, further)
        self._layout.put(totals, x)
        x.ghostUpdate(addv=PETSc.InsertMode.INSERT, mode=PETSc.ScatterMode.FORWARD)

    def foresee(self, x: PETSc.Vec, step: PETSc.Vec, factor: float) -> None:
        """Let friction look ahead along a step, from increments x, to a load factor; the system ends where it was."""
        rubbing = [c for c in self.contributions if c.rubs]
        if not rubbing:
            return
        here, ahead = self.factor, x.copy()
        for c in rubbing:
            c.foresee(ahead=False)
        self.retract(ahead, step)
        self.configure(ahead, factor)
        for c in rubbing:
            c.foresee(ahead=True)
        self.configure(x, here)

    @contextmanager
    def held(self, found: bool) -> Iterator[bool]:
        """Let contributions hold what an iteration would overshoot, or open if forces are found; whether any does."""
        holding = [c for c in self.contributions if c.freeze_open_contacts()] if found else []
        try:
            yield not self.smooth and self.comm.allreduce(len(holding)) > 0
        finally:
            for contribution in holding:
                contribution.release()

    def residual(self, out: PETSc.Vec) -> None:
        """Out-of-balance forces of the current configuration."""
        support = self.residual_of(self.contributions, out)
        self.reaction = self.comm.allreduce(float(support @ support)) ** 0.5

    def residual_of(self, contributions: Sequence[Contribution], out: PETSc.Vec,
                    act=lambda contribution, forces: contribution.residual(forces)) -> np.ndarray:
        """Forces of some contributions on free increments, in `out`; return those on fixed ones of this process."""
        with self.clock("assembly"):
            forces = self._forces()
            for contribution in contributions:
                act(contribution, forces)
            return self._gather(forces, out)

    def at_nodes(self, act: Callable[[Forces], None]) -> PETSc.Vec:
        """Forces and moments at nodes along the directions of space that a function adds up, fixed nodes included."""
        forces, out = self._forces(), self.create_vector()
        act(forces)
        self._layout.gather(forces.spatial(self._layout), out)
        return out

    def arrays(self, vector: PETSc.Vec) -> list[np.ndarray]:
        """An array for each block with the entries of a vector; nodes that share unknowns have the others' values."""
        return self._layout.arrays(vector)

    def load(self, out: PETSc.Vec, stage: int | None = None) -> np.ndarray:
        """Derivative of the external forces with respect to the load factor of a stage (None: the present one).

        Those on fixed increments of this process are returned.
        """
        with self.clock("assembly"):
            forces = self._forces()
            for contribution in self.contributions:
                if contribution.stage == (self.factors.stage if stage is None else stage):
                    contribution.load(forces)
            return self._gather(forces, out)

    def tangent(self, only: Sequence[Contribution] | None = None) -> PETSc.Mat:
        """Derivative of the residual with respect to increments of the current configuration.

        Parameters
        ----------
        only : contributions that alone have another tangent, though the same forces, since this was last made; None:
            all may have
        """
        with self.clock("assembly"):
            held = self._forces()
            if only is None:
                if any(c.moved for c in self.contributions):
                    self._create_matrix()
                self._shares = [c.tangent(held) for c in self.contributions] + [
                    curvature(self.unknowns, self._layout, self.contributions, held)]
            else:
                self._shares = [c.tangent(held) if c in only else share for c, share in zip_longest(
                    self.contributions, self._shares)]
            compat.set_coo_values(self.matrix, np.concatenate([array for share in self._shares for array in share]))
            return self.matrix

    def tangent_of_steep(self) -> csr_matrix:
        """Share of the steep contributions in the tangent, with the rows and columns of all processes."""
        with self.clock("assembly"):
            held, size = self._forces(), self._layout.global_size
            if self._steep_pattern is None or self.comm.allreduce(any(c.moved for c in self.steep), op=MPI.LOR):
                parts = [c.pattern(self._layout) for c in self.steep]
                self._steep_pattern = [np.concatenate(numbers) for numbers in zip(*parts, strict=True)]
            rows, columns = self._steep_pattern
            values = np.concatenate([array for c in self.steep for array in c.tangent(held)])
            inside = (values != 0) & (np.minimum(rows, columns) >= 0)
            values, rows, columns = (np.concatenate(parts) for parts in zip(*self.comm.allgather(
                (values[inside], rows[inside], columns[inside])), strict=True))
            return csr_matrix((values, (rows, columns)), shape=(size, size))

    def _forces(self) -> Forces:
        return Forces(self.unknowns, self._layout)

    def _gather(self, forces: Forces, out: PETSc.Vec) -> np.ndarray:
        """Put forces on increments into a vector, zero where these are fixed; return those there."""
        arrays = forces.along_space
        self._turn_inward(arrays)
        for number, (f, array) in enumerate(self._layout.fields(arrays)):
            force = forces.given(number)
            if force is not None:
                array[f.dofs] += f.pull(force)
        self._layout.gather(arrays, out)
        support = out.array[self.fixed_rows]
        out.array[self.fixed_rows] = 0
        return support

    def _turn_inward(self, arrays) -> None:
        """Take nodal vectors of the blocks to forces on increments along the axes of their nodes."""
        for f, array in self._layout.fields(arrays):
            array[f.dofs] = f.inward(array[f.dofs])

    def functional(self, block, dofs: np.ndarray, value: float) -> PETSc.Vec:
        """Vector whose product with increments is `value` times the sum of some owned dofs, along space."""
        arrays, vector = self._layout.zeros(), self.create_vector()
        arrays[self.unknowns.blocks.index(block)][dofs] = value
        self._turn_inward(arrays)
        self._layout.gather(arrays, vector)
        return vector

    def diagonal(self, given: Sequence[np.ndarray | None]) -> PETSc.Vec:
        """Numbers on increments, the same along all axes of a node, as the diagonal of a matrix; fixed ones are zero.

        Parameters
        ----------
        given : for each block the values of its local dofs; None: zero
        """
        arrays, vector = self._layout.zeros(), self.create_vector()
        for array, own in zip(arrays, given, strict=True):
            if own is not None:
                array += own
        self._layout.gather(arrays, vector)
        vector.array[self.fixed_rows] = 0
        return vector

    def bilinear(self, form) -> Callable[[], PETSc.Mat]:
        """Function that gives the present matrix of a form in `unknowns.vary` and `unknowns.linearise`.

        It has the rows of the tangent, fixed ones empty; each call writes over what the last one gave.
        """
        part = FormMatrix(self.unknowns, form)
        matrix = compat.create_coo_matrix(self.comm, self._layout.size, *part.pattern(self._layout))

        def now() -> PETSc.Mat:
            compat.set_coo_values(matrix, part.values())
            return matrix

        return now

    @contextmanager
    def additive_increments(self, frozen: bool = True) -> Iterator[None]:
        """Let increments since the last converged state add at all nodes, rotations too.

        Residual and tangent are then gradient and Hessian of the energy as a function of them, wherever they are, where
        history is frozen.
        """
        turning = [f for f in self.unknowns.fields if f.curved]
        kept = [f.charted for f in turning]
        for f in turning:
            f.charted = np.ones_like(f.charted)
        try:
            with self.history.frozen() if frozen else nullcontext():
                yield
        finally:
            for f, charted in zip(turning, kept, strict=True):
                f.charted = charted

    def extrapolate_stress(self, step: PETSc.Vec | None = None) -> None:
        """Stresses of the tangent: the current state's plus their linear change by `step`."""
        held = self.unknowns.changes
        if held is None:
            return
        with self.clock("assembly"):
            for change, values in zip(held, [0.0] * len(held) if step is None else self.changes(step), strict=True):
                change.x.array[:] = values
            for contribution in self.contributions:
                contribution.extrapolate_stress()

    def forget_stress(self) -> None:
        """Let the next tangent have no stresses."""
        for contribution in self.contributions:
            contribution.forget_stress()

    def changes(self, step: PETSc.Vec) -> list[np.ndarray]:
        """First-order change of the values of each field by a further step."""
        return [f.change(array) for f, array in self._layout.fields(self._layout.arrays(step))]

    def motions(self, step: PETSc.Vec) -> list[np.ndarray]:
        """Displacements and spins of the nodes of each field by a further step, along the directions of space."""
        found = []
        for f, array in self._layout.fields(self._layout.arrays(step)):
            own, along = array[f.dofs].reshape(-1, f.width), f.motions()
            found.append(own if along is None else np.einsum("nij,nj->ni", along, own))
        return found

    def rate_by(self, motions: Sequence[np.ndarray]) -> PETSc.Vec:
        """Rate of the increments since the last converged state with which nodes move as `motions` says now."""
        arrays, rate = self._layout.zeros(), self.create_vector()
        for (f, array), motion in zip(self._layout.fields(arrays), motions, strict=True):
            array[f.dofs] = f.rate(motion)
        self._layout.put(arrays, rate)
        return rate

    def step_by(self, motions: Sequence[np.ndarray]) -> PETSc.Vec:
        """The further step from the last converged state that gives `motions`; its axes may differ from theirs."""
        arrays, step = self._layout.zeros(), self.create_vector()
        for (f, array), motion in zip(self._layout.fields(arrays), motions, strict=True):
            array[f.dofs] = f.inward(motion.ravel())
        self._layout.put(arrays, step)
        return step

    def snapshot(self) -> dict[str, np.ndarray]:
        """All that a state consists of on this process: fields, history, stage and load factor."""
        return self.history.snapshot() | {"load": np.array([self.factors.stage, self.factors.now])}

    def origins(self) -> dict[str, np.ndarray]:
        """What tells rows of a snapshot's arrays, and of a vector (`increment`), on any number of processes."""
        return self.history.origins() | {"load": np.arange(2), "increment": self._layout.origins()}

    def restore(self, snapshot: dict[str, np.ndarray]) -> None:
        """Return to a state that `snapshot` gave."""
        stage, factor = snapshot["load"]
        self.factors.enter(int(stage), float(factor))
        self.history.restore(snapshot)
