"""Numbers of a form as constants, so that other values of a parameter need no new compilation."""

from __future__ import annotations

from dolfinx.fem import Constant
from ufl.algorithms.map_integrands import map_integrand_dags
from ufl.corealg.multifunction import MultiFunction


class _Lift(MultiFunction):
    """Replaces numbers that look like data; factors of formulas (multiples of 1/12) stay."""

    expr = MultiFunction.reuse_if_untouched

    def __init__(self, mesh):
        super().__init__()
        self._mesh, self._constants = mesh, {}

    def float_value(self, o):
        value = float(o)
        if abs(value) <= 16 and (12 * value).is_integer():
            return o
        if value not in self._constants:
            self._constants[value] = Constant(self._mesh, value)
        return self._constants[value]

    def power(self, o, base, exponent):
        return o._ufl_expr_reconstruct_(base, o.ufl_operands[1])


def lift_numbers(expression, mesh):
    """Replace the numbers in a form or expression by constants on `mesh`."""
    return map_integrand_dags(_Lift(mesh), expression)
