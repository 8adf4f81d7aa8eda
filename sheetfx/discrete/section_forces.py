"""Stress resultants of parts, where they are evaluated, and along which directions they act."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import ufl

from ..jit import compiled_expression
from ..mesh.numbers import with_constants
from ..model.beam import Bar, Beam
from .discretisation import Discretisation


@dataclass(frozen=True)
class SectionPoints:
    """Points of a part's resultants on this process.

    Attributes
    ----------
    reference : places in the reference configuration on the meshed line or surface, shape (cells, points, dimension)
    places : where these points are now, of beams and shells with an offset those of the centroid or mid-surface
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


def section_points(discretisation: Discretisation, part) -> SectionPoints:
    """Points of a part in the present configuration, in the order of its resultants."""
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
    work = discretisation.work_of(part)
    points = work.points if work.resultants_inside else _resultants(discretisation, part)[1]
    table = _evaluated(part, values, points)
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
