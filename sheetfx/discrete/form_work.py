"""Virtual work written as a UFL form: its residual, load and tangent."""

from __future__ import annotations

import reprlib
from collections.abc import Sequence

import numpy as np
import ufl
from dolfinx import fem
from petsc4py import PETSc
from ufl.algorithms.map_integrands import map_integrands

from .. import compat
from ..communicators import lasting
from ..jit import compiled_form
from ..model.work import Acting
from .contribution import Contribution, Forces
from .densities import WAY
from .layout import Layout
from .number import NumberField
from .unknowns import Unknowns


class FormWork(Contribution):
    """Virtual work as a UFL form in the fields, the numbers among the unknowns, and the load factor.

    Parameters
    ----------
    unknowns : Unknowns
    work : UFL form, linear in the variations that `unknowns.vary` makes; internal work positive, loads negative
    factor : UFL variable of the load factor; None: the work has none
    """

    gives_moments = True

    def __init__(self, unknowns: Unknowns, work, *, factor=None, smooth: bool = True, conservative: bool = True,
                 stage: int | None = None):
        self.smooth, self.conservative, self.stage, self._unknowns = smooth, conservative, stage, unknowns
        shares = {number: unknowns.part(work, number) for number in [None, *_numbers_in(unknowns, work)]}
        self._forces = _Vectors(unknowns, shares)
        self._load = None
        if factor is not None:
            self._load = _Vectors(unknowns, {n: -slope(share, factor) for n, share in shares.items()})
        self._matrix = FormMatrix(unknowns, unknowns.linearise(shares[None]))
        self._borders = [_Border(unknowns, shares, number) for number in shares if number is not None]

    def residual(self, forces: Forces) -> None:
        self._forces.add(forces.along_space)

    def load(self, forces: Forces) -> None:
        if self._load is not None:
            self._load.add(forces.along_space)

    def pattern(self, layout: Layout) -> tuple[np.ndarray, np.ndarray]:
        parts = [self._matrix.pattern(layout), *(border.pattern(layout) for border in self._borders)]
        rows, columns = (np.concatenate(numbers) for numbers in zip(*parts, strict=True))
        return rows, columns

    def tangent(self, held: Forces) -> Sequence[np.ndarray]:
        return [self._matrix.values(), *(border.values() for border in self._borders)]

    def energy(self) -> float | None:
        """Work on the straight way to the present values, where its forces are none but on fields that add."""
        if self.stage is not None or not (self.smooth and self.conservative):
            return None
        fields = [(field, field.value.x.array.copy()) for field in self._unknowns.fields if not field.curved]
        total, comm = 0.0, lasting(self._unknowns.blocks[0].index_map.comm)
        for share, weight in WAY:
            for field, values in fields:
                field.show(share * values)
            arrays = [np.zeros((b.index_map.size_local + b.index_map.num_ghosts) * b.width)
                      for b in self._unknowns.blocks]
            self._forces.add(arrays)
            for block, array in zip(self._unknowns.blocks, arrays, strict=True):
                for field in block.fields:
                    total += np.nan if field.curved and array[field.dofs].any() else 0.0
                total += weight * sum(array[f.dofs] @ v for f, v in fields if f in block.fields)
        for field, values in fields:
            field.show(values)
        found = comm.allreduce(float(total))
        return None if np.isnan(found) else found


def work_of(acting: Acting, fields) -> ufl.Form | None:
    """The virtual work of a joint or load.

    Raises
    ------
    ValueError
        Where it is no form.
    """
    found = acting.work(fields)
    if not (found is None or isinstance(found, ufl.Form)):
        raise ValueError(f"{type(acting).__name__}: work returns {reprlib.repr(found)}; return a UFL form, which is an "
                         "expression times a measure, or None")
    return found


def by_mesh(works: Sequence) -> list:
    """Sums of the forms on each mesh; None stands for no form."""
    sums: dict = {}
    for work in works:
        if work is not None and work.integrals():
            domain = work.ufl_domain()
            sums[domain] = sums[domain] + work if domain in sums else work
    return list(sums.values())


def _numbers_in(unknowns: Unknowns, work) -> list[NumberField]:
    """Numbers whose variation does work."""
    constants = set(ufl.algorithms.expand_derivatives(work).constants())
    return [number for number in unknowns.numbers if number.variation in constants]


def slope(form, variable):
    """Derivative of a form with respect to a UFL variable."""
    return map_integrands(lambda e: ufl.diff(e, variable), ufl.algorithms.expand_derivatives(form))


def _compiled(unknowns: Unknowns, form) -> list:
    """Compiled forms by blocks with a space; None where there is nothing."""
    form = unknowns.at_rest(form)
    return None if form.empty() else compiled_form(unknowns.blocks_of(form))


class _Vectors:
    """Forces on all blocks from the shares of virtual work of the fields (None) and of numbers."""

    def __init__(self, unknowns: Unknowns, shares: dict):
        forms = _compiled(unknowns, shares[None]) or [None] * len(unknowns.spatial)
        self._parts = [(unknowns.blocks.index(block), form, fem.assemble_vector)
                       for block, form in zip(unknowns.spatial, forms, strict=True) if form is not None]
        for number, share in shares.items():
            share = unknowns.at_rest(share)
            if number is not None and not share.empty():
                there = next(n for n, block in enumerate(unknowns.blocks) if block.fields[0] is number)
                self._parts.append((there, compiled_form(share), _add_scalar))

    def add(self, arrays: Sequence[np.ndarray]) -> None:
        for number, form, assemble in self._parts:
            assemble(arrays[number], form)


def _add_scalar(array: np.ndarray, form) -> None:
    array[0] += fem.assemble_scalar(form)


class FormMatrix:
    """Matrix of a bilinear form on the blocks with a space, as entries of the solver's matrix."""

    def __init__(self, unknowns: Unknowns, form):
        self._unknowns, self._forms, self._turned = unknowns, _compiled(unknowns, form), None
        if self._forms is None:
            return
        for n, block in enumerate(unknowns.spatial):
            if self._forms[n][n] is None:
                self._forms[n][n] = _nothing(block.space)
        self._matrix = compat.create_matrix(self._forms)
        self._own = Layout(unknowns.spatial[0].space.mesh.comm, unknowns.spatial)
        self._turn = self._own.turning_matrix()

    def pattern(self, layout: Layout) -> tuple[np.ndarray, np.ndarray]:
        """Global rows and columns, -1 where an increment is zero."""
        if self._forms is None:
            return np.empty(0, dtype=np.int64), np.empty(0, dtype=np.int64)
        pointer, columns, _ = self._assembled().getValuesCSR()
        rows = self._own.start + np.repeat(np.arange(len(pointer) - 1), np.diff(pointer))
        spatial = [n for n, block in enumerate(self._unknowns.blocks) if block.space is not None]
        own, all_of = self._own.starts().ravel(), layout.starts()[:, spatial].ravel()

        def moved(numbers: np.ndarray) -> np.ndarray:
            block = np.searchsorted(own, numbers, side="right") - 1
            return layout.free(numbers - own[block] + all_of[block])
        return moved(rows.astype(np.int64)), moved(columns.astype(np.int64))

    def values(self) -> np.ndarray:
        """Values of the entries of `pattern`."""
        return np.empty(0) if self._forms is None else self._assembled().getValuesCSR()[2]

    def _assembled(self) -> PETSc.Mat:
        matrix = compat.assemble_matrix(self._matrix, self._forms)
        if self._turn is not None:
            self._own.turn(self._turn)
            matrix = self._turned = matrix.ptap(self._turn, result=self._turned)
        return matrix


def _nothing(space):
    """An empty form for the diagonal, which DOLFINx needs for the space of each block."""
    zero = fem.Constant(space.mesh, 0.0)
    u, v = ufl.TrialFunction(space), ufl.TestFunction(space)
    return compiled_form(zero * ufl.inner(u, v) * ufl.dx)


class _Border:
    """Row and column of one number in the tangent of a form."""

    def __init__(self, unknowns: Unknowns, shares: dict, number: NumberField):
        self._unknowns, self._number = unknowns, unknowns.fields.index(number)
        share, numbers = shares[number], [n for n in shares if n is not None]
        self._column = _compiled(unknowns, slope(shares[None], number.symbol))
        self._row = _compiled(unknowns, unknowns.linearise_scalar(share))
        corner = [(unknowns.fields.index(n), unknowns.at_rest(slope(share, n.symbol))) for n in numbers]
        self._corner = [(n, compiled_form(form)) for n, form in corner if not form.empty()]

    def _sides(self) -> list[tuple[list, bool]]:
        return [(forms, down) for forms, down in ((self._column, True), (self._row, False)) if forms is not None]

    def pattern(self, layout: Layout) -> tuple[np.ndarray, np.ndarray]:
        own = layout.free_numbers[self._number].ravel()[:1]
        rows, columns = [], []
        for forms, down in self._sides():
            for block, form in zip(self._unknowns.spatial, forms, strict=True):
                if form is not None:
                    along = layout.free(layout.numbers[self._unknowns.blocks.index(block)])
                    across = np.broadcast_to(own, along.shape)
                    rows.append(along if down else across)
                    columns.append(across if down else along)
        for other, _ in self._corner:
            rows.append(own)
            columns.append(layout.free_numbers[other].ravel()[:1])
        return np.concatenate(rows), np.concatenate(columns)

    def values(self) -> np.ndarray:
        values = []
        for forms, _ in self._sides():
            for block, form in zip(self._unknowns.spatial, forms, strict=True):
                if form is not None:
                    array = np.zeros((block.index_map.size_local + block.index_map.num_ghosts) * block.width)
                    fem.assemble_vector(array, form)
                    for field in block.fields:
                        array[field.dofs] = field.inward(array[field.dofs])
                    values.append(array)
        values += [np.array([fem.assemble_scalar(form)]) for _, form in self._corner]
        return np.concatenate(values)
