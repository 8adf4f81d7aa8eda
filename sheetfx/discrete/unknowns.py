"""All unknowns of a problem, and derivatives of forms with respect to them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import ufl
from dolfinx.common import IndexMap
from dolfinx.fem import FunctionSpace
from mpi4py import MPI
from ufl.algorithms.formsplitter import FormSplitter

from ..communicators import lasting
from ..mesh.numbers import constants_on, lift_numbers
from .nodal_field import AdditiveField, QuaternionField
from .number import NumberField


@dataclass(frozen=True, eq=False)
class Block:
    """A part of the solver's vector and the fields that live in it.

    Attributes
    ----------
    fields : one, or displacement and rotation of a mixed space
    index_map, width : distribution of its entries over the processes, and entries to each index
    space : function space; None for numbers
    """

    fields: tuple[AdditiveField, ...]
    index_map: IndexMap
    width: int
    space: FunctionSpace | None = None

    @classmethod
    def of_space(cls, space: FunctionSpace, *fields: AdditiveField) -> Block:
        return cls(fields, space.dofmap.index_map, space.dofmap.index_map_bs, space)

    @classmethod
    def of_numbers(cls, field: NumberField) -> Block:
        return cls((field,), field.index_map, 1)


class Unknowns:
    """All blocks of a problem, and derivatives with respect to them.

    Attributes
    ----------
    changes : for each field a holder of its change in the last Newton step, for the mixed integration point tangent
        (Magisano, Leonetti and Garcea 2017); None: the tangent is the plain derivative
    """

    changes: Sequence | None = None

    def __init__(self, blocks: Sequence[Block]):
        self.blocks = tuple(blocks)
        self.fields = [f for b in self.blocks for f in b.fields]
        self.spatial = tuple(b for b in self.blocks if b.space is not None)
        self.numbers = [f for f in self.fields if isinstance(f, NumberField) and f.symbol is not None]
        mixed = ufl.MixedFunctionSpace(*[b.space for b in self.spatial])
        self._tests = self._pieces(ufl.TestFunctions(mixed))
        self._trials = self._pieces(ufl.TrialFunctions(mixed))
        self._arguments = ufl.TestFunctions(mixed)
        self._symbols = [f.symbol for b in self.spatial for f in b.fields]

    @cached_property
    def charted(self) -> bool:
        """Whether any nodes turn their axes from one converged state to the next, as supports hold one rotation."""
        charted = any(f.charted.any() for f in self.fields if isinstance(f, QuaternionField))
        return bool(lasting(self.blocks[0].index_map.comm).allreduce(charted, op=MPI.LOR))

    def _pieces(self, arguments) -> list:
        return [
            piece
            for block, argument in zip(self.spatial, arguments, strict=True)
            for piece in (ufl.split(argument) if len(block.fields) > 1 else [argument])
        ]

    def vary(self, expression):
        """Variation of an expression in the direction of the test functions, and of the numbers in it."""
        varied = ufl.derivative(expression, self._symbols, self._tests)
        for number in self.numbers:
            varied += number.variation * ufl.diff(expression, number.symbol)
        return varied

    def linearise(self, expression):
        """Derivative of an expression or form in the direction of the trial functions."""
        return ufl.derivative(expression, self._symbols, self._trials)

    def linearise_scalar(self, form):
        """Derivative of a form without arguments in the direction of the test functions."""
        return ufl.derivative(form, self._symbols, self._tests)

    def previous(self, expression):
        """The expression as it was at the last converged state."""
        mapping = {f.value: f.previous for b in self.spatial for f in b.fields}
        for number in self.numbers:
            mapping |= number.earlier()
        return ufl.replace(expression, mapping)

    def part(self, work, number: NumberField | None = None):
        """Of virtual work the share of one number's variation, or of all fields (None)."""
        mapping = {n.variation: ufl.as_ufl(1.0 if n is number else 0.0) for n in self.numbers}
        if number is not None:
            mapping |= {argument: ufl.classes.Zero(argument.ufl_shape) for argument in self._arguments}
        return ufl.replace(ufl.algorithms.expand_derivatives(work), mapping) if mapping else work

    def at_rest(self, form):
        """Carry out derivatives, then put the symbols of rotation increments to zero."""
        form = ufl.algorithms.expand_derivatives(form)
        mapping = {k: v for f in self.fields for k, v in f.at_rest().items()}
        form = ufl.replace(form, mapping) if mapping else form
        if isinstance(form, ufl.core.expr.Expr):
            domain = ufl.domain.extract_unique_domain(form)
            return form if domain is None else _on_domain(form, domain)
        domains = dict.fromkeys(integral.ufl_domain() for integral in form.integrals())
        parts = [_on_domain(ufl.Form([i for i in form.integrals() if i.ufl_domain() == d]), d) for d in domains]
        return ufl.Form([integral for part in parts for integral in part.integrals()])

    def blocks_of(self, form) -> list:
        """Split a linear form into a list and a bilinear form into a square list of forms, by blocks with a space.

        Unlike `ufl.extract_blocks` this keeps the places of blocks that the form does not touch.
        """
        split, numbers = FormSplitter().split, range(len(self.spatial))

        def block(*place):
            part = split(form, *place)
            return None if part.empty() else part

        if len(form.arguments()) and max(a.number() for a in form.arguments()) == 1:
            return [[block(i, j) for j in numbers] for i in numbers]
        return [block(i) for i in numbers]


def _on_domain(form, domain):
    """A form or expression on one mesh with its numbers as constants there."""
    return lift_numbers(constants_on(domain, form), domain)
