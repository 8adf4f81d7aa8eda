"""Torsion, transverse shear and warping of a plane section, by finite elements (Saint-Venant's problem)."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import basix
import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.linalg import splu

from ..mesh.plane_region import refined, triangulate
from ..mesh.quadrature import simplex

ACCURACY = 2e-3  # change of torsion constant and shear areas by the last refinement: about half of it is left
MOST = 200_000  # triangles
GMSH = [0, 1, 2, 5, 3, 4]  # basix's middles of edges are opposite to corners 0, 1 and 2


@dataclass(frozen=True)
class SaintVenant:
    """Constants of a section about its centroid; axes are normal and binormal.

    Attributes
    ----------
    torsion : Saint-Venant's torsion constant
    shear : matrix of shear areas, shape (2, 2): forces per shear modulus and mean shear strain of equal energy, of a
        material that does not contract across (Poisson's ratio 0), by which it depends on the shape alone
    shear_centre : shape (2,), Trefftz's, which belongs to the same material
    warping : integral of the squared warping function about the shear centre
    places, areas : of fibres that integrate second moments exactly
    """

    torsion: float
    shear: np.ndarray
    shear_centre: np.ndarray
    warping: float
    places: np.ndarray
    areas: np.ndarray


@lru_cache(maxsize=512)
def saint_venant(rings: tuple[tuple[tuple[float, float], ...], ...], size: float) -> SaintVenant:
    """Constants to half a percent or better, from meshes that are refined until that holds.

    Parameters
    ----------
    rings : corners of the outer polygon and of holes, about the centroid
    size : of the first triangles
    """
    x, cells = triangulate([np.array(ring) for ring in rings], size)
    places, areas = _fibres(x, cells)
    before = solved = _solved(x, cells)
    while 4 * len(cells) <= MOST:
        x, cells = refined(x, cells)
        before, solved = solved, _solved(x, cells)
        if max(abs(solved[0] / before[0] - 1), np.abs(solved[1] - before[1]).max() / np.trace(solved[1])) < ACCURACY:
            break
    return SaintVenant(*solved, places, areas)


def _at_quadrature(x: np.ndarray, cells: np.ndarray, degree: int):
    """Shape functions at points, (points, 6), their slopes, (cells, points, 2, 6), and weights, (cells, points)."""
    rule = simplex(degree)
    table = basix.create_element(basix.ElementFamily.P, basix.CellType.triangle, 2,
                                 basix.LagrangeVariant.equispaced).tabulate(1, rule.points)[..., GMSH, 0]
    jacobian = np.stack([x[cells[:, i]] - x[cells[:, 0]] for i in (1, 2)], axis=-1)
    slopes = np.einsum("cji,jqn->cqin", np.linalg.inv(jacobian), table[1:])
    return table[0], slopes, np.abs(np.linalg.det(jacobian))[:, None] * rule.weights


def _fibres(x: np.ndarray, cells: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    values, _, weights = _at_quadrature(x, cells, 2)
    return np.einsum("qn,cnd->cqd", values, x[cells]).reshape(-1, 2), weights.ravel()


def _solved(x: np.ndarray, cells: np.ndarray) -> tuple[float, np.ndarray, np.ndarray, float]:
    """Torsion constant, shear areas, shear centre and warping constant.

    The warping function w of a twist has grad w + (-z, y) free of sources and of flow through the edge (Timoshenko and
    Goodier 1970, section 108). Shear stresses of a force F are grad p with -div grad p = I^-1 F . x, free of flow
    through the edge (Pilkey 2002, section 6.1, with a Poisson's ratio of 0). A gradient does no work with stresses of
    torsion, so that both are apart about the shear centre, the place that the moment of grad p tells.
    """
    values, slopes, weights = _at_quadrature(x, cells, 4)
    rows, columns = np.repeat(cells, 6, axis=1).ravel(), np.tile(cells, 6).ravel()

    def matrix(of_cells):
        return coo_array((of_cells.ravel(), (rows, columns)), shape=2 * (len(x),)).tocsc()

    stiffness = matrix(np.einsum("cqin,cqim,cq->cnm", slopes, slopes, weights))
    mass = matrix(np.einsum("qn,qm,cq->cnm", values, values, weights))
    place = np.einsum("qn,cnd->cqd", values, x[cells])
    turned = np.stack((-place[..., 1], place[..., 0]), axis=-1)
    twist = -np.bincount(cells.ravel(), np.einsum("cqin,cqi,cq->cn", slopes, turned, weights).ravel(), len(x))
    moments = x.T @ (mass @ x)
    loads = np.column_stack((twist, mass @ x @ np.linalg.inv(moments)))
    free = np.arange(1, len(x))  # a constant has no slope
    solved = np.zeros_like(loads)
    solved[1:] = splu(stiffness[free][:, free].tocsc()).solve(loads[1:])
    warp, potentials = solved[:, 0], solved[:, 1:]
    flexibility = potentials.T @ stiffness @ potentials
    about_centroid = -twist @ potentials  # moments of unit forces along normal and binormal
    constant_and_linear = np.column_stack((np.ones(len(x)), x))
    inner = constant_and_linear.T @ (mass @ constant_and_linear)
    warp = warp - constant_and_linear @ np.linalg.solve(inner, constant_and_linear.T @ (mass @ warp))
    torsion = float(np.trace(moments) - twist @ solved[:, 0])
    centre = np.array([about_centroid[1], -about_centroid[0]])
    return torsion, np.linalg.inv(flexibility), centre, float(warp @ (mass @ warp))
