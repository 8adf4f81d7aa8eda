"""Numbers of a form as constants, so that other values of a parameter need no new compilation."""

from __future__ import annotations

from dataclasses import fields, is_dataclass

import numpy as np
from dolfinx.fem import Constant
from ufl import replace
from ufl.algorithms import expand_derivatives
from ufl.algorithms.analysis import extract_constants
from ufl.algorithms.map_integrands import map_integrand_dags
from ufl.corealg.multifunction import MultiFunction
from ufl.domain import extract_unique_domain


def as_constants(domain, numbers):
    """The same nest of sequences and dataclasses with entries of one vector constant for its numbers.

    Zeros stay numbers, so that forms do not contain what vanishes. Numbers become constants where they
    enter a form, rather than by `lift_numbers`, because UFL orders sums by the values of their numbers.
    """
    found: list[float] = []
    mapped(numbers, lambda n: found.append(n) if n else None)
    constant = Constant(domain, np.array(found or [0.0], dtype=float))
    places = iter(range(len(found)))
    return mapped(numbers, lambda n: constant[next(places)] if n else 0.0)


def mapped(nest, function):
    """The same nest of sequences and dataclasses with what a function makes of its numbers."""
    if is_dataclass(nest):
        return type(nest)(**{f.name: mapped(getattr(nest, f.name), function) for f in fields(nest)})
    if isinstance(nest, (tuple, list)):
        return type(nest)(mapped(n, function) for n in nest)
    return function(nest)


class _Lift(MultiFunction):
    """Replaces numbers that look like data; factors of formulas (multiples of 1/12) stay."""

    expr = MultiFunction.reuse_if_untouched

    def __init__(self, replace):
        super().__init__()
        self._replace = replace

    def float_value(self, o):
        value = float(o)
        return o if abs(value) <= 16 and (12 * value).is_integer() else self._replace(o, value)

    def power(self, o, base, exponent):
        return o._ufl_expr_reconstruct_(base, o.ufl_operands[1])

    def variable(self, o, expression, label):
        """Labels of variables count on, which would make each expression a new one."""
        return expression


def lift_numbers(expression, domain):
    """Replace the numbers in a form or expression by the entries of one vector constant on `mesh`."""
    values: dict[float, int] = {}

    def collect(o, value):
        values.setdefault(value, len(values))
        return o

    expression = map_integrand_dags(_Lift(collect), expression)
    if not values:
        return expression
    constant = Constant(domain, np.array(list(values)))
    return map_integrand_dags(_Lift(lambda o, value: constant[values[value]]), expression)


def with_constants(expression):
    """An expression with its derivatives carried out, and then its numbers lifted."""
    expression = expand_derivatives(expression)
    return lift_numbers(expression, extract_unique_domain(expression))


def constants_on(domain, expression):
    """A form or expression on a UFL mesh, in which constants of other meshes are replaced by ones on its own.

    They have the same values, also when these change.

    The form compiler takes forms with constants on meshes of another dimension for integrals over facets.
    """
    others = [c for c in extract_constants(expression) if c.ufl_domain() != domain]
    return replace(expression, {c: constant_of(domain, c) for c in others}) if others else expression


def constant_of(domain, constant: Constant) -> Constant:
    """A constant on a mesh that has the value of another one, also when that changes."""
    twin = Constant(domain, constant.value)
    twin._cpp_object = constant._cpp_object
    return twin
