"""Cells that no strain can be computed on: without length or area, concave, or folded over.

A cell of a surface in space has no sign of its own. Its normal t1 x t2, where t1 and t2 are the derivatives of the
place by the coordinates of the reference cell, is compared with the unit normal n halfway to the cell's middle, and
that with the middle's:

    (t1 x t2) . n / (|t1| |t2|)

is the scaled Jacobian of Knupp (2001, Algebraic mesh quality metrics) where the cell is flat: the sine of the angle at
a corner, zero where two edges make a straight line, negative at a corner that points inwards. Of a curve the tangents
are compared.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import basix
import numpy as np

FLAT = 1e-12  # length or area of a cell, over the size of the mesh or its square, that is rounding
STRAIGHT = 1e-9  # scaled Jacobian that is rounding of the coordinates, in cells far from the origin as well
CHUNK = 20000  # cells at a time: places at which high orders are looked at take memory


@dataclass(frozen=True)
class Bad:
    """Cells of a group that are bad.

    Attributes
    ----------
    group : name
    count : number of its bad cells
    value : least scaled Jacobian among them; None: the worst has no extent
    place : where that is
    dimension : of the cells
    """

    group: str
    count: int
    value: float | None
    place: np.ndarray
    dimension: int

    @property
    def rank(self) -> float:
        """The smaller the worse."""
        return -np.inf if self.value is None else self.value


def bad_cells(element, x: np.ndarray, groups: Mapping[str, np.ndarray], extent: float) -> list[Bad]:
    """Bad cells of each group.

    Parameters
    ----------
    element : basix element of the geometry
    x : places of the nodes of each cell, shape (cells, nodes, 3)
    groups : name -> numbers of cells
    extent : size of the mesh
    """
    ranks, places = scaled_jacobians(element, x, extent)
    dimension = len(basix.topology(element.cell_type)) - 1
    found = []
    for name, cells in groups.items():
        bad = np.asarray(cells, dtype=np.int64)
        bad = bad[ranks[bad] <= STRAIGHT]
        if len(bad):
            worst = bad[np.argmin(ranks[bad])]
            value = float(ranks[worst]) if np.isfinite(ranks[worst]) else None
            found.append(Bad(name, len(bad), value, places[worst], dimension))
    return found


def scaled_jacobians(element, x: np.ndarray, extent: float) -> tuple[np.ndarray, np.ndarray]:
    """Least scaled Jacobian of each cell, minus infinity where it has no extent, and its place.

    Parameters
    ----------
    element, x, extent : as of `bad_cells`
    """
    values, sizes, places = (np.concatenate(parts) for parts in zip(
        *(_looked_at(element, x[i:i + CHUNK], extent) for i in range(0, max(len(x), 1), CHUNK)), strict=True))
    dimension = len(basix.topology(element.cell_type)) - 1
    return np.where(sizes <= FLAT * extent**dimension, -np.inf, values), places


def refuse(what: str, found: Sequence[Bad], remedy: str) -> None:
    """Refuse bad cells, by the worst of them.

    Parameters
    ----------
    what : has them, for messages

    Raises
    ------
    ValueError
        If there are any.
    """
    if not found:
        return
    worst = min(found, key=lambda bad: bad.rank)
    count, one = (total := sum(bad.count for bad in found if bad.group == worst.group)), total == 1
    cells = f"{count} {'cell' if one else 'cells'} of the group {worst.group!r}"
    place = tuple(float(f"{c:.6g}") for c in worst.place + 0.0)
    if worst.value is None:
        extent = "length" if worst.dimension == 1 else "area"
        raise ValueError(f"{what}: {cells} {'has' if one else 'have'} no {extent}, {'' if one else 'the first '}at "
                         f"{place}; {remedy}")
    kind = "folded back" if worst.dimension == 1 else "concave or folded over"
    raise ValueError(f"{what}: {cells} {'is' if one else 'are'} {kind}, {'' if one else 'the worst '}at {place}, where "
                     f"the scaled Jacobian is {worst.value:.2g} and that of a square is 1; {remedy}")


def _looked_at(element, x: np.ndarray, extent: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Least scaled Jacobian of each cell, its length or area, and the place of that Jacobian."""
    degree, corners = element.degree, basix.geometry(element.cell_type)
    lattice = basix.create_lattice(element.cell_type, 1 if degree == 1 else 2 * degree, basix.LatticeType.equispaced,
                                   True)
    centre, count = corners.mean(axis=0, keepdims=True), len(lattice)
    table = element.tabulate(1, np.concatenate([lattice, (lattice + centre) / 2, centre]))[..., 0]
    tangents = np.einsum("dpn,cni->dcpi", table[1:], x)
    lengths = np.linalg.norm(tangents, axis=3)
    lengths[lengths <= FLAT * extent] = 0.0  # two corners in one place, but for rounding
    normals, scale = (tangents[0], lengths[0]) if len(tangents) == 1 else (np.cross(*tangents), lengths.prod(axis=0))
    sizes = np.linalg.norm(normals, axis=2)
    units = normals / np.where(sizes > 0, sizes, 1.0)[..., None]
    halfway, middle = units[:, count:-1], np.broadcast_to(units[:, -1:], units[:, count:-1].shape)
    alike = (halfway * middle).sum(axis=2, keepdims=True) > 0
    inwards = np.concatenate([np.where(alike, halfway, middle), middle], axis=1)
    found = scale[:, :-1] > 0
    shares = np.where(found, (normals[:, :-1] * inwards).sum(axis=2) / np.where(found, scale[:, :-1], 1.0), 0.0)
    worst = shares.argmin(axis=1)
    places = np.einsum("cn,cni->ci", table[0][worst], x)
    return np.take_along_axis(shares, worst[:, None], axis=1)[:, 0], sizes.mean(axis=1), places
