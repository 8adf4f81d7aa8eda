"""Strains that a section law is given in the place of the fields' strains, see `discrete.assumed`."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
import ufl
from dolfinx.mesh import Mesh

from ..mesh.at_points import at_points
from ..mesh.quadrature import Rule


@dataclass(frozen=True)
class Map:
    """A linear map of some strains in each cell, e* = root e + low l + spread gather e.

    Strains at the points of integration, e, and those that are sampled elsewhere, l, are columns, strain by strain.

    Attributes
    ----------
    strains, sampled : first one, and the one behind the last, of the strains that are mapped, and of l
    alike : whether each strain is mapped alone, all by the same matrices
    root : shape (cells,)
    low, gather, spread : shapes (cells, n, samples), (cells, m, n), (cells, n, m)
    """

    strains: tuple[int, int]
    sampled: tuple[int, int]
    alike: bool
    root: np.ndarray
    low: np.ndarray
    gather: np.ndarray
    spread: np.ndarray

    @property
    def parts(self) -> int:
        """Number of blocks of strains that the matrices are for."""
        return self.strains[1] - self.strains[0] if self.alike else 1


class Tying(Protocol):
    """Which strains are assumed.

    Attributes
    ----------
    low : rule at whose points strains are sampled
    exact : whether strains at the low rule's points are as the fields give them
    """

    low: Rule
    exact: bool

    def sampled(self, strains):
        """UFL vector of the values sampled at the low rule's points."""

    def maps(self, domain: Mesh, cells: np.ndarray, rule: Rule, area, measure: np.ndarray) -> Sequence[Map]:
        """Maps that act one after the other.

        Parameters
        ----------
        rule : of integration
        area : UFL scalar, of the surface over the reference cell's
        measure : weights of the points of integration, (cells, points)
        """


class LowerRule:
    """Membrane, shear and drilling strains that are tied to the points of a lower rule.

    With their polynomial P e through those points, and the polynomial Q e of the same kind that is nearest to them at
    the points of integration, the law is given

        e* = (1 - r^2) P e + r^2 Q e + r (e - Q e),    0 <= r <= 1.

    Polynomial and rest are orthogonal: constant moduli do no work between them, and constant forces the work that r^2
    of the full rule and 1 - r^2 of the lower one give. Where e is of the full rule's degree in an affine cell, P e is
    Q e (the rest is Legendre's polynomial, whose zeros are Gauss's points), so that an elastic law stores its
    energy by these shares of both rules: selective reduced integration (Malkus and Hughes 1978; Arnold and Brezzi
    1997), but one that coupled laws and laws with history can bear.

    Parameters
    ----------
    low : rule
    extrapolation : matrix from values at its points to those at the points of integration
    share : UFL scalar r^2, whose mean each cell takes: were it not constant, constant forces would do work on e - P e
    """

    exact = True

    def __init__(self, low: Rule, extrapolation: np.ndarray, share):
        self.low, self._extrapolation, self._share = low, extrapolation, share

    def sampled(self, strains):
        return ufl.as_vector([strains[i] for i in (0, 1, 2, 6, 7, 8)])

    def maps(self, domain: Mesh, cells: np.ndarray, rule: Rule, area, measure: np.ndarray) -> list[Map]:
        """The polynomial is of strains times area: constant forces then do the work that the low rule gives."""
        at_low = at_points(area, self.low.points).eval(domain, cells).reshape(len(cells), -1)
        spread = self._extrapolation * at_low[:, None, :] / (measure / rule.weights)[:, :, None]
        weighted = spread.transpose(0, 2, 1) * measure[:, None, :]
        nearest = np.linalg.solve(weighted @ spread, weighted)
        shares = at_points(self._share, rule.points).eval(domain, cells).reshape(len(cells), -1)
        squared = ((measure * shares).sum(axis=1) / measure.sum(axis=1))[:, None, None]
        root = np.sqrt(squared[:, 0, 0])
        low, gather = (1 - squared) * spread, (squared - np.sqrt(squared)) * nearest
        return [Map(strains, sampled, True, root, low, gather, spread)
                for strains, sampled in (((0, 3), (0, 3)), ((6, 9), (3, 6)))]
