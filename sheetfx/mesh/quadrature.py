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
