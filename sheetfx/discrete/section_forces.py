"""Stress resultants of parts, where they are evaluated, and along which directions they act."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import ufl

from ..communicators import lasting
from ..compat import geometry_nodes
from ..jit import compiled_expression
from ..mesh.lines import SAME, place_of
from ..mesh.numbers import with_constants
from ..mesh.projection import Cells
from ..mesh.quadrature import Rule, extrapolation
from ..model.beam import Bar, Beam
from .discretisation import Discretisation

NEAR = 1e-3  # of the size of a mesh, that a place may be off it


@dataclass(frozen=True)
class SectionPoints:
    """Points of a part's resultants on this process.

    Attributes
    ----------
    reference : places in the reference configuration on the meshed line or surface, shape (cells, points, dimension)
    places : where these points are now, of beams and shells with an offset on the centroid or mid-surface
    axes : directions in which the axes of the resultants point now, shape (cells, points, axes, dimension): of beams
        the normal of the cross-section, its depth and in space its width; of shells the two in the surface and the
        director; of bars their direction
    """

    reference: np.ndarray
    places: np.ndarray
    axes: np.ndarray


def section_forces(discretisation: Discretisation, part) -> np.ndarray:
    """Stress resultants of a part now, shape (cells, points, resultants).

    They are evaluated where they are most exact, at the points of a reduced rule (Barlow 1976): elsewhere in a cell,
    and at nodes above all, the shear force of a slender part is many times too large. Laws with history, and strains
    that are interpolated, are known at the points of integration alone.
    """
    work = discretisation.work_of(part)
    if work.resultants_inside:
        return work.resultants()
    resultants, points = _resultants(discretisation, part)
    return _evaluated(part, resultants, points)


def section_points(discretisation: Discretisation, part, points: np.ndarray | None = None) -> SectionPoints:
    """Points of a part in the present configuration, in the order of its resultants.

    Parameters
    ----------
    points : reference points of a cell; None: as of `section_forces`
    """
    mesh, kinematics = part.mesh, discretisation.kinematics(part.mesh)
    d, rotation, frame = mesh.dimension, kinematics.total_rotation, part.frame()
    x = ufl.SpatialCoordinate(mesh.domain)
    if isinstance(part, Bar):
        along = frame.tangent + frame.along(kinematics.u)
        axes, arms = [along / ufl.sqrt(ufl.dot(along, along))], []
    else:
        axes = [rotation.rotate(axis) for axis in frame.axes]
        arms = list(zip(np.ravel(part.offset).tolist(), axes[1:] if isinstance(part, Beam) else axes[2:], strict=False))
    place = x + kinematics.u + sum((c * axis for c, axis in arms if c), 0 * x)
    values = ufl.as_vector([v[i] for v in (x, place, *axes) for i in range(d)])
    table = _evaluated(part, values, section_points_of(discretisation, part) if points is None else points)
    table = table.reshape(*table.shape[:2], 2 + len(axes), d)
    return SectionPoints(table[:, :, 0], table[:, :, 1], table[:, :, 2:])


def _resultants(discretisation: Discretisation, part):
    """UFL vector, and the points of a cell at which it is most exact."""
    kinematics, natural = discretisation.kinematics(part.mesh), discretisation.fields.natural_strains(part)
    strains, law, points = part.pointwise(kinematics.u, kinematics.total_rotation)
    return law(strains if natural is None else strains - natural), points


def _evaluated(part, values, points: np.ndarray) -> np.ndarray:
    """A UFL vector at points of the part's cells on this process, shape (cells, points, components)."""
    domain, cells = part.mesh.domain, part.mesh.group(part.group)
    return compiled_expression(values, points, with_constants).eval(domain, cells).reshape(
        len(cells), len(points), values.ufl_shape[0])


def value_at(discretisation: Discretisation, part, values: np.ndarray, at: str | Sequence[float]) -> np.ndarray:
    """Values of a part at a named point or a place of the reference configuration, the same on all processes.

    They belong to the polynomial through the points of the cell there, at its corners the mean of all cells of the
    part that have it.

    Parameters
    ----------
    values : at the points of `section_forces`, on this process, shape (cells, points, ...)

    Raises
    ------
    ValueError
        If the place is off the part.
    """
    mesh, cells = part.mesh, part.mesh.group(part.group)
    place = place_of(mesh, at)
    found, near = [], np.inf
    if len(cells):
        corners = mesh.domain.geometry.x[geometry_nodes(mesh.domain)[cells], :mesh.dimension]
        touching = np.flatnonzero((np.linalg.norm(corners - place, axis=2) <= SAME * mesh.size).any(axis=1))
        among = Cells(mesh, cells)
        which, _, apart = among.closest(place[None])
        near = float(apart[0])
        chosen = touching if len(touching) else which
        points = np.asarray(section_points_of(discretisation, part))
        for number in chosen:
            reference = Cells(mesh, cells[[number]]).closest(place[None])[1]
            found.append(np.tensordot(through_points(mesh, points, reference), values[number], 1)[0])
    everywhere = [(n, v) for n, own in lasting(mesh.comm).allgather((near, found)) for v in own]
    nearest = min((n for n, _ in everywhere), default=np.inf)
    if not nearest <= NEAR * mesh.size:
        words = ", ".join(f"{c:.6g}" for c in place)
        raise ValueError(f"value_at: the place ({words}) is {nearest:.4g} off the {type(part).__name__}; "
                         "give one on it")
    return np.mean([v for n, v in everywhere if n <= nearest + SAME * mesh.size], axis=0)


def section_points_of(discretisation: Discretisation, part) -> np.ndarray:
    """Reference points of a cell at which resultants of a part are evaluated."""
    work = discretisation.work_of(part)
    return work.points if work.resultants_inside else _resultants(discretisation, part)[1]


def through_points(mesh, points: np.ndarray, reference: np.ndarray) -> np.ndarray:
    """Values at reference points by those at the points of a cell; their mean where no polynomial passes through."""
    try:
        return extrapolation(mesh.domain.basix_cell(), *(Rule(p, np.ones(len(p))) for p in (points, reference)))
    except ValueError:
        return np.full((len(reference), len(points)), 1 / len(points))
