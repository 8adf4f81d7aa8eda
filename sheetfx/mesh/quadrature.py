"""Quadrature rules on reference cells."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import basix
import numpy as np


@dataclass(frozen=True)
class Rule:
    """Points and weights on a reference cell.

    Attributes
    ----------
    points : shape (n, topological dimension)
    weights : shape (n,)
    """

    points: np.ndarray
    weights: np.ndarray

    @cached_property
    def metadata(self) -> dict:
        """For a UFL measure."""
        return {"quadrature_rule": "custom", "quadrature_points": self.points, "quadrature_weights": self.weights}


def gauss(cell: basix.CellType, *counts: int) -> Rule:
    """Gauss points: one count for an interval, one for each direction of a quadrilateral."""
    lines = [basix.make_quadrature(basix.CellType.interval, 2 * n - 1) for n in counts]
    if cell == basix.CellType.interval:
        return Rule(*lines[0])
    (x, wx), (y, wy) = lines
    points = np.stack(np.meshgrid(x[:, 0], y[:, 0], indexing="ij"), axis=-1).reshape(-1, 2)
    return Rule(points, np.outer(wx, wy).ravel())


def simplex(degree: int) -> Rule:
    """Rule on a triangle that is exact for polynomials of a degree."""
    return Rule(*basix.make_quadrature(basix.CellType.triangle, degree))


def extrapolation(cell: basix.CellType, low: Rule, full: Rule) -> np.ndarray:
    """Matrix from values at the points of one rule to those, at another's, of the polynomial through them.

    Polynomials have a degree on simplices, and a degree along each direction on quadrilaterals.

    Raises
    ------
    ValueError
        If no such polynomial has as many coefficients as there are points.
    """
    for degree in range(len(low.points)):
        family = basix.create_element(basix.ElementFamily.P, cell, degree, basix.LagrangeVariant.gll_warped,
                                      basix.DPCVariant.unset, degree == 0)
        if family.dim == len(low.points):
            at_low, at_full = (family.tabulate(0, rule.points)[0, :, :, 0] for rule in (low, full))
            return at_full @ np.linalg.inv(at_low)
    raise ValueError(f"ShellForm: no polynomial on a {cell.name} passes through {len(low.points)} points; take a low "
                     "rule with as many as a polynomial has coefficients")
