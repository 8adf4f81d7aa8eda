"""Dependence of an expression on the values and gradients of fields at a point.

The jet of the fields at a point is the vector of their values and of their derivatives along the
reference coordinates of the cell. A strain measure is a function of the jet; derivatives with respect to
it are small matrices at each point, and the shape functions come in afterwards, as one product of
dense matrices for many cells (see `elements`).
"""

from __future__ import annotations

from dataclasses import dataclass

import ufl
from dolfinx.fem import Function
from ufl.algorithms import expand_derivatives
from ufl.corealg.map_dag import map_expr_dag
from ufl.corealg.multifunction import MultiFunction

from ..compat import topological_dimension


@dataclass(frozen=True)
class FieldJet:
    """What an expression uses of one field.

    Attributes
    ----------
    field : Function
    components : number of components of the field
    orders : 0 for the value, k + 1 for the derivative along the reference coordinate k
    start : place of the field in the jet; the entry of component c is start + c len(orders) + place
    """

    field: Function
    components: int
    orders: tuple[int, ...]
    start: int

    def entry(self, component: int, order_index: int) -> int:
        return self.start + component * len(self.orders) + order_index


def as_function_of_jet(expression, fields) -> tuple[object, object, list[FieldJet]]:
    """Rewrite an expression as a function of one UFL variable, the jet.

    Parameters
    ----------
    expression : UFL expression in values and first gradients of the fields
    fields : sequence of Functions

    Returns
    -------
    the expression, the variable, and the used part of each field (fields that do not occur are left out)
    """
    expression = expand_derivatives(expression)
    values, gradients = _occurrences(expression)
    domain = ufl.domain.extract_unique_domain(expression)
    jacobian, inverse = ufl.Jacobian(domain), ufl.JacobianInverse(domain)
    dimension = topological_dimension(domain)
    parts, entries = [], []
    for field in (f for f in fields if f in values or f in gradients):
        orders = (0,) * (field in values) + tuple(range(1, dimension + 1)) * (field in gradients)
        count = field.ufl_shape[0] if field.ufl_shape else 1
        parts.append(FieldJet(field, count, orders, len(entries)))
        slopes = ufl.dot(ufl.grad(field), jacobian)
        for c in range(count):
            place = (c,) if field.ufl_shape else ()
            entries += [_at(field, place) if k == 0 else slopes[place + (k - 1,)] for k in orders]
    jet = ufl.variable(ufl.as_vector(entries))
    mapping = {}
    for part in parts:
        scalar = not part.field.ufl_shape
        if 0 in part.orders:
            components = [jet[part.entry(c, 0)] for c in range(part.components)]
            mapping[part.field] = components[0] if scalar else ufl.as_vector(components)
        if dimension in part.orders:
            first = part.orders.index(1)
            rows = [[jet[part.entry(c, first + k)] for k in range(dimension)] for c in range(part.components)]
            gradient = ufl.dot(ufl.as_vector(rows[0]) if scalar else ufl.as_matrix(rows), inverse)
            mapping[ufl.grad(part.field)] = gradient
    return map_expr_dag(_Replace(mapping), expression), jet, parts


def _at(field, place):
    return field[place] if place else field


def _occurrences(expression) -> tuple[set, set]:
    """Fields whose value, and fields whose gradient occurs."""
    values, gradients = set(), set()

    def visit(node):
        if isinstance(node, ufl.classes.Grad):
            operand = node.ufl_operands[0]
            if not isinstance(operand, ufl.classes.Terminal):
                raise ValueError("a strain measure may use first gradients of the fields only")
            gradients.add(operand)
        elif isinstance(node, ufl.classes.Coefficient):
            values.add(node)
        else:
            pending.extend(node.ufl_operands)

    pending, seen = [expression], set()
    while pending:
        node = pending.pop()
        if node not in seen:
            seen.add(node)
            visit(node)
    return values, gradients


class _Replace(MultiFunction):
    """Put functions of the jet in the place of fields and their gradients."""

    expr = MultiFunction.reuse_if_untouched

    def __init__(self, mapping):
        super().__init__()
        self._mapping = mapping

    def grad(self, o):
        return self._mapping.get(o, o)

    def coefficient(self, o):
        return self._mapping.get(o, o)
