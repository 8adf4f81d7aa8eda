"""Values of UFL expressions as arrays, for many samples at once, without a form compiler."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import ufl
from ufl import classes
from ufl.algorithms import expand_derivatives

COMPARISONS = {classes.EQ: np.equal, classes.NE: np.not_equal, classes.LE: np.less_equal, classes.LT: np.less,
               classes.GE: np.greater_equal, classes.GT: np.greater, classes.AndCondition: np.logical_and,
               classes.OrCondition: np.logical_or, classes.NotCondition: np.logical_not}
ELEMENTWISE = COMPARISONS | {
    classes.Product: np.multiply, classes.Division: np.divide, classes.Power: np.power, classes.Abs: np.abs,
    classes.MinValue: np.minimum, classes.MaxValue: np.maximum, classes.Conditional: np.where,
    classes.Atan2: np.arctan2, classes.Sum: np.add, classes.Conj: np.conj, classes.Real: np.real,
    classes.Imag: np.imag, classes.Erf: np.vectorize(math.erf, otypes=[float])}
NAMES = {"asin": "arcsin", "acos": "arccos", "atan": "arctan", "ln": "log"}  # of functions, where NumPy has others


class Unknown(Exception):
    """An expression contains what has no value here."""


def prepared(expression):
    """An expression with its derivatives carried out, as `evaluate` takes it.

    Raises
    ------
    Unknown
        Where UFL cannot.
    """
    try:
        return expand_derivatives(expression)
    except NotImplementedError as error:
        raise Unknown(str(error)) from error


def evaluate(expression, terminal: Callable) -> np.ndarray:
    """Values of a prepared expression.

    Parameters
    ----------
    terminal : function from a UFL terminal, or the gradient of one, to its values, shape (samples or 1, *its shape)

    Returns
    -------
    array, shape (samples or 1, *shape of the expression)

    Raises
    ------
    Unknown
        For an operator that has no values at a point, such as a jump, and as `terminal` does.
    """
    known: dict = {}
    with np.errstate(all="ignore"):
        for node in ufl.corealg.traversal.unique_post_traversal(expression):
            if not isinstance(node, (classes.MultiIndex, classes.Label)):
                known[node] = _value(node, known, terminal)
    return known[expression]


def _value(node, known: dict, terminal: Callable) -> np.ndarray:
    """Values of a node, shape (samples or 1, *free indices, *shape), free indices in the order UFL has them."""
    operands = node.ufl_operands
    if isinstance(node, classes.Zero):
        return np.zeros((1, *node.ufl_index_dimensions, *node.ufl_shape))
    if isinstance(node, classes.ScalarValue):
        return np.array([node.value()])
    if isinstance(node, classes.Identity):
        return np.eye(node.ufl_shape[0])[None]
    if isinstance(node, (classes.Terminal, classes.Grad)):
        return _terminal(node, terminal)
    if isinstance(node, classes.Variable):
        return known[operands[0]]
    if isinstance(node, classes.ListTensor):
        return np.stack(np.broadcast_arrays(*(known[o] for o in operands)), axis=1 + len(node.ufl_free_indices))
    if isinstance(node, (classes.Indexed, classes.ComponentTensor, classes.IndexSum)):
        return _reindexed(node, known[operands[0]])
    function = ELEMENTWISE.get(type(node))
    if function is None and isinstance(node, classes.MathFunction):
        name = node._name
        function = getattr(np, NAMES.get(name, name), None)
    if function is None:
        raise Unknown(type(node).__name__)
    values = [_with_indices(known[o], getattr(o, "ufl_free_indices", ()), node) for o in operands]
    if isinstance(node, classes.Conditional):
        values[0] = values[0].reshape(*values[0].shape, *(1 for _ in node.ufl_shape))
    if isinstance(node, (classes.Power, classes.MathFunction)):
        values = [v if v.dtype.kind == "c" else v.astype(float) for v in values]
    return function(*values)


def _terminal(node, terminal: Callable) -> np.ndarray:
    if isinstance(node, classes.Grad) and not isinstance(node.ufl_operands[0], classes.Terminal):
        raise Unknown("Grad")
    return terminal(node)


def _with_indices(values: np.ndarray, indices, node) -> np.ndarray:
    """Axes of an operand for all free indices of the node, of length 1 where the operand has not that index."""
    if not isinstance(node, classes.Condition) and indices != node.ufl_free_indices:  # conditions have none
        rank = values.ndim - 1 - len(indices)
        lengths = [values.shape[1 + indices.index(i)] if i in indices else 1 for i in node.ufl_free_indices]
        return values.reshape(values.shape[0], *lengths, *values.shape[values.ndim - rank:])
    return values


def _reindexed(node, values: np.ndarray) -> np.ndarray:
    """Components, tensors and sums over an index, by the names of the axes."""
    tensor, indices = node.ufl_operands
    names = [str(i) for i in tensor.ufl_free_indices] + [f"axis {k}" for k in range(len(tensor.ufl_shape))]
    free = [str(i) for i in node.ufl_free_indices]
    if isinstance(node, classes.Indexed):
        place: list = [slice(None)] * values.ndim
        for k, index in enumerate(indices):
            if isinstance(index, classes.FixedIndex):
                place[values.ndim - len(indices) + k] = int(index)
            names[len(tensor.ufl_free_indices) + k] = "" if isinstance(index, classes.FixedIndex) \
                else str(index.count())
        values, out = values[tuple(place)], free
        names = [n for n in names if n]
    elif isinstance(node, classes.ComponentTensor):
        out = free + [str(i.count()) for i in indices]
    else:
        out = free + names[len(tensor.ufl_free_indices):]
    numbers = {name: 1 + k for k, name in enumerate(dict.fromkeys(names))}
    return np.einsum(values, [0, *(numbers[n] for n in names)], [0, *(numbers[n] for n in out)])
