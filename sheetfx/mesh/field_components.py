"""Shapes that a random field of deviations is made of, by its covariance (Karhunen 1947; Loeve 1948)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import dolfinx
import numpy as np
import ufl
from dolfinx import fem
from scipy.sparse.linalg import eigsh
from scipy.spatial.distance import cdist

from ..checks import Count, Positive, checked
from ..jit import compiled_form
from .reader import NamedMesh

LEAST = 1e-12  # variance of a component over that of the first one


@dataclass(frozen=True, eq=False)
class FieldComponent:
    """One shape of a random field, a function of place to deviations along the normal for `imperfect`.

    Attributes
    ----------
    variance : its mean square over the structure; all components of the field have a mean square of 1 together
    """

    variance: float
    _sites: np.ndarray
    _weights: np.ndarray
    _length: float

    def __call__(self, x: np.ndarray) -> np.ndarray:
        return _covariance(x, self._sites, self._length) @ self._weights


@checked
def field_components(meshes: Sequence[NamedMesh], correlation_length: Positive, count: Count) -> list[FieldComponent]:
    """The components with the largest variance of the field that `random_field` gives samples of.

    The field is their sum with independent normal coefficients of standard deviation 1. Its covariance is taken
    between the middles of cells of the highest dimension, and between all places by it (Nystroem 1930).

    Parameters
    ----------
    correlation_length : distance at which the correlation is 1 / e
    count : number of components

    Raises
    ------
    ValueError
        If the cells tell fewer components apart.
    """
    highest = max(mesh.domain.topology.dim for mesh in meshes)
    parts = [_middles(mesh) for mesh in meshes if mesh.domain.topology.dim == highest]
    sites, sizes = (np.concatenate(arrays) for arrays in zip(*parts, strict=True))
    roots = np.sqrt(sizes / sizes.sum())
    covariance = roots[:, None] * _covariance(sites, sites, correlation_length) * roots
    most = len(sites) - 1
    values, vectors = eigsh(covariance, min(count, most), v0=np.ones(len(sites))) if most else (np.ones(1), np.eye(1))
    told = np.flatnonzero(values > LEAST * values[-1])[::-1]
    if len(told) < count:
        raise ValueError(f"field_components: count is {count}, and {len(sites)} cells with a correlation length of "
                         f"{correlation_length:g} tell {len(told)} apart; give a smaller count")
    return [FieldComponent(float(values[n]), sites, _signed(roots * vectors[:, n]) / values[n]**0.5, correlation_length)
            for n in told]


def _covariance(x: np.ndarray, y: np.ndarray, length: float) -> np.ndarray:
    return np.exp(-cdist(x, y, "sqeuclidean") / length**2)


def _signed(values: np.ndarray) -> np.ndarray:
    """The same on any number of processes: the largest one positive."""
    return values if values.max() >= -values.min() else -values


def _middles(mesh: NamedMesh) -> tuple[np.ndarray, np.ndarray]:
    """Middles and sizes of the cells of all processes."""
    domain, dim = mesh.domain, mesh.domain.topology.dim
    count = domain.topology.index_map(dim).size_local
    places = dolfinx.mesh.compute_midpoints(domain, dim, np.arange(count, dtype=np.int32))
    space = fem.functionspace(domain, ("DG", 0))
    sizes = fem.assemble_vector(compiled_form(ufl.TestFunction(space) * ufl.dx)).array[:count]
    found = mesh.comm.allgather((places, sizes))
    return tuple(np.concatenate(arrays) for arrays in zip(*found, strict=True))
