"""Interpolation of vectors and symmetric tensors on the reference triangle by their tangential parts along edges."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .quadrature import Rule

EDGES = ((0.0, 0.0), (1.0, 0.0)), ((0.0, 0.0), (0.0, 1.0)), ((1.0, 0.0), (-1.0, 1.0))  # begin and tangent of each


@dataclass(frozen=True)
class Tangential:
    """An interpolation in covariant components, from tangential parts at points of edges and from moments inside.

    Components are (e11, e22, 2 e12) of a tensor, (g1, g2) of a vector.

    Attributes
    ----------
    points, tangents : of the edges, shape (edge points, 2)
    from_edges : values at a rule's points from tangential parts, shape (points, components, edge points)
    from_moments : values at a rule's points from moments, shape (points, components, moments)
    moments : moments from values at the rule's points, shape (moments, points, components)
    """

    points: np.ndarray
    tangents: np.ndarray
    from_edges: np.ndarray
    from_moments: np.ndarray
    moments: np.ndarray


def regge(degree: int, rule: Rule) -> Tangential:
    """Symmetric tensors of polynomials of a degree: Regge's element (Christiansen 2011; Neunteufel and Schoeberl 2021).

    Their parts t . e t at Gauss's points of the edges, and moments with polynomials of a degree less; the moments make
    membranes of bent cells soft enough, which values inside do not.
    """
    basis = [_times(column, unit) for unit in np.eye(3) for column in _monomials(degree)]
    return _interpolation(degree, 3, basis, rule)


def nedelec(degree: int, rule: Rule) -> Tangential:
    """Vectors of Nedelec's first kind (1980): polynomials of a degree less one and rotated homogeneous ones."""
    basis = [_times(column, unit) for unit in np.eye(2) for column in _monomials(degree - 1)]
    basis += [lambda x, i=i: (x[:, 0]**i * x[:, 1]**(degree - 1 - i))[:, None] * np.column_stack((x[:, 1], -x[:, 0]))
              for i in range(degree)]
    return _interpolation(degree - 1, 2, basis, rule)


def polynomials(degree: int, points: np.ndarray) -> np.ndarray:
    """Monomials up to a degree at points, shape (points, monomials)."""
    return np.column_stack([monomial(points) for monomial in _monomials(degree)])


def _monomials(degree: int) -> list:
    return [lambda x, i=i, j=j: x[:, 0]**i * x[:, 1]**j for j in range(degree + 1) for i in range(degree + 1 - j)]


def _times(scalar, unit: np.ndarray):
    return lambda x: scalar(x)[:, None] * unit


def _interpolation(degree: int, components: int, basis: list, rule: Rule) -> Tangential:
    along = (np.polynomial.legendre.leggauss(degree + 1)[0] + 1) / 2
    points = np.array([np.add(begin, s * np.array(tangent)) for begin, tangent in EDGES for s in along])
    tangents = np.repeat([tangent for _, tangent in EDGES], len(along), axis=0)
    parts = np.column_stack((tangents**2, tangents.prod(axis=1))) if components == 3 else tangents
    inside = polynomials(degree - 1, rule.points) * rule.weights[:, None]
    moments = np.einsum("qm,cd->mcqd", inside, np.eye(components)).reshape(-1, len(rule.points), components)
    at_edges, at_rule = (np.stack([function(x) for function in basis], axis=-1) for x in (points, rule.points))
    tested = np.concatenate((np.einsum("pc,pcb->pb", parts, at_edges), np.einsum("mqc,qcb->mb", moments, at_rule)))
    values = at_rule @ np.linalg.inv(tested)
    return Tangential(points, tangents, values[..., :len(points)], values[..., len(points):], moments)
