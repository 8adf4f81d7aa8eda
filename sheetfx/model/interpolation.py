"""Assumed strains of triangles: tangential parts along edges, moments inside, and rotations that bulge in each cell."""

from __future__ import annotations

import numpy as np
import ufl
from dolfinx.mesh import Mesh

from ..mesh.at_points import at_points, put, values_at_points
from ..mesh.quadrature import Rule
from ..mesh.tangential import Tangential, nedelec, polynomials, regge
from .tying import Map


class Interpolation:
    """Strains of triangles with displacements and rotations of one degree, 2 or 3.

    Covariant membrane strains are interpolated in Regge's space of a degree less (Neunteufel and Schoeberl 2021, eq.
    10), transverse shear strains in Nedelec's of the same degree (Durán and Liberman 1992). Rotations get a bubble of a
    degree more in each cell, which linear moduli of bending and shear eliminate: with it shear strains have the freedom
    that thin plates need (Arnold and Brezzi 1997). Of drilling strains d the law is given the polynomial Q d of two
    degrees less that is nearest, (1 - r) Q d + r d with r^2 = thickness^2 / area.

    Parameters
    ----------
    frame : SurfaceFrame of the mid-surface
    thickness : of each cell, or of all, shape (cells,) or (1,)
    moduli : of bending and shear, shape (cells, 5, 5) or (1, 5, 5)
    domain, cells, rule : where strains are assumed
    degree : of displacements and rotations
    """

    exact = False

    def __init__(self, frame, thickness: np.ndarray, moduli: np.ndarray, domain: Mesh, cells: np.ndarray, rule: Rule,
                 degree: int):
        self._degree, self._thickness = degree, thickness
        self._moduli = np.broadcast_to(moduli, (len(cells), 5, 5))
        self._membrane, self._shear = regge(degree - 1, rule), nedelec(degree, rule)
        points = self._membrane.points
        self.low = Rule(points, np.ones(len(points)))
        back = ufl.JacobianInverse(domain)
        below = [t if frame.to_mesh is None else ufl.dot(frame.to_mesh, t) for t in frame.tangents]
        self._axes = ufl.as_matrix([[ufl.dot(back[i, :], t) for t in below] for i in range(2)])
        tangents = np.linalg.solve(self._components(domain, cells, points), self._membrane.tangents[..., None])[..., 0]
        self._tangents, rows = values_at_points(domain, cells, self.low, (2,))
        put(self._tangents, rows, tangents)

    def _components(self, domain: Mesh, cells: np.ndarray, points: np.ndarray) -> np.ndarray:
        """Reference components (rows) of the axes of strains (columns), (cells, points, 2, 2)."""
        return at_points(self._axes, points).eval(domain, cells).reshape(len(cells), len(points), 2, 2)

    def sampled(self, strains):
        """Stretch, and transverse shear, along the edges."""
        c = self._tangents
        return ufl.as_vector([c[0] ** 2 * strains[0] + c[1] ** 2 * strains[1] + c[0] * c[1] * strains[2],
                              c[0] * strains[6] + c[1] * strains[7]])

    def maps(self, domain: Mesh, cells: np.ndarray, rule: Rule, area, measure: np.ndarray) -> list[Map]:
        axes = self._components(domain, cells, rule.points)
        back = np.linalg.inv(axes)
        membrane = _interpolated(self._membrane, _of_tensors(axes), _of_tensors(back), (0, 3), 0)
        shear = _interpolated(self._shear, np.swapaxes(axes, 2, 3), np.swapaxes(back, 2, 3), (6, 8), 1)
        return [membrane, shear, self._bulging(axes, shear, rule, measure), self._drilling(rule, measure)]

    def _bulging(self, axes: np.ndarray, shear: Map, rule: Rule, measure: np.ndarray) -> Map:
        """Strains less the bubbles' own, whose forces then vanish: e - B K^-1 B^T D e with K = B^T D B."""
        values, slopes = _bubbles(self._degree, rule.points)
        slopes = np.einsum("cqij,qin->cqjn", axes, slopes)
        strains = np.zeros((*measure.shape, 5, 2, values.shape[1]))
        strains[:, :, 0, 0] = strains[:, :, 2, 1] = slopes[:, :, 0]
        strains[:, :, 1, 1] = strains[:, :, 2, 0] = slopes[:, :, 1]
        strains[:, :, 3, 0] = strains[:, :, 4, 1] = values
        rows = np.swapaxes(strains, 1, 2).reshape(len(measure), 5 * measure.shape[1], -1)
        first = 3 * measure.shape[1]
        rows[:, first:] = shear.spread @ (shear.gather @ rows[:, first:])
        forces = np.einsum("cij,cq,cjqn->ciqn", self._moduli, measure, rows.reshape(len(rows), 5, measure.shape[1], -1))
        forces = forces.reshape(rows.shape).transpose(0, 2, 1)
        gather = np.linalg.pinv(forces @ rows, hermitian=True) @ forces
        return _map((3, 8), (0, 0), np.ones(len(rows)), np.zeros((*rows.shape[:2], 0)), gather, -rows)

    def _drilling(self, rule: Rule, measure: np.ndarray) -> Map:
        share = np.minimum(1.0, self._thickness**2 / measure.sum(axis=1))
        root = np.sqrt(share)[:, None, None]
        spread = np.tile(polynomials(self._degree - 2, rule.points), (len(measure), 1, 1))
        weighted = spread.transpose(0, 2, 1) * measure[:, None, :]
        nearest = np.linalg.solve(weighted @ spread, weighted)
        return _map((8, 9), (0, 0), root[:, 0, 0], np.zeros((*measure.shape, 0)), (1 - root) * nearest, spread)


def _map(strains: tuple[int, int], sampled: tuple[int, int], root, low, gather, spread) -> Map:
    return Map(strains, sampled, False, *(np.ascontiguousarray(a) for a in (root, low, gather, spread)))


def _interpolated(given: Tangential, forth: np.ndarray, back: np.ndarray, strains: tuple[int, int], number: int) -> Map:
    """An interpolation as a map of strains on axes, with matrices from covariant components to these and back."""
    cells, points, size = forth.shape[:3]
    low, spread = (np.einsum("cqij,qjn->ciqn", forth, values).reshape(cells, size * points, -1)
                   for values in (given.from_edges, given.from_moments))
    gather = np.einsum("mqj,cqji->cmiq", given.moments, back).reshape(cells, -1, size * points)
    return _map(strains, (number, number + 1), np.zeros(cells), low, gather, spread)


def _of_tensors(axes: np.ndarray) -> np.ndarray:
    """Matrices of (e11, e22, 2 e12) on axes from covariant ones, from the axes' reference components (..., 2, 2)."""
    c, found = axes, np.empty((*axes.shape[:2], 3, 3))
    for row, (p, q) in enumerate(((0, 0), (1, 1), (0, 1))):
        both = 1 if p == q else 2
        found[..., row, 0] = both * c[..., 0, p] * c[..., 0, q]
        found[..., row, 1] = both * c[..., 1, p] * c[..., 1, q]
        found[..., row, 2] = both * (c[..., 0, p] * c[..., 1, q] + c[..., 1, p] * c[..., 0, q]) / 2
    return found


def _bubbles(degree: int, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Bubbles of a degree more at points, (points, bubbles), and their slopes, (points, 2, bubbles)."""
    r, s = points.T
    bubble = 27 * r * s * (1 - r - s)
    slopes = 27 * np.column_stack((s * (1 - 2 * r - s), r * (1 - r - 2 * s)))
    if degree == 2:
        return bubble[:, None], slopes[:, :, None]
    factors = np.column_stack((r, s)) - 1 / 3
    return bubble[:, None] * factors, slopes[:, :, None] * factors[:, None, :] + bubble[:, None, None] * np.eye(2)
