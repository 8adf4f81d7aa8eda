"""Geometrically exact beams: reference frame and strain measures."""

from __future__ import annotations

from dataclasses import dataclass

import ufl


@dataclass(frozen=True)
class CurveFrame:
    """Reference frame of a curve: unit tangent and cross-section axes, cell by cell.

    Attributes
    ----------
    axes : tuple of UFL vectors
        (tangent, normal) in the plane, (tangent, normal, binormal) in space.
    """

    axes: tuple

    @property
    def tangent(self):
        return self.axes[0]

    @property
    def normal(self):
        return self.axes[1]

    def along(self, f):
        """Derivative of a field with respect to the reference arc length."""
        return ufl.dot(ufl.grad(f), self.tangent)


def unit_tangent(domain):
    """Unit tangent of a curve from the Jacobian of its mesh."""
    jacobian = ufl.Jacobian(domain)
    column = ufl.as_vector([jacobian[i, 0] for i in range(jacobian.ufl_shape[0])])
    return column / ufl.sqrt(ufl.dot(column, column))


def curve_frame(domain, up=None) -> CurveFrame:
    """Frame of a curve from the Jacobian of its mesh.

    Parameters
    ----------
    domain : ufl mesh of topological dimension 1
    up : sequence of 3 floats or UFL vector, shape (3,)
        In space: a vector that, made perpendicular to the tangent, is the normal (first
        principal axis of the section). Must not be parallel to the tangent.
    """
    tangent = unit_tangent(domain)
    if tangent.ufl_shape == (2,):
        return CurveFrame((tangent, ufl.as_vector([-tangent[1], tangent[0]])))
    if not isinstance(up, ufl.core.expr.Expr):
        up = ufl.as_vector([float(c) for c in up])
    normal = up - ufl.dot(up, tangent) * tangent
    normal = normal / ufl.sqrt(ufl.dot(normal, normal))
    return CurveFrame((tangent, normal, ufl.cross(tangent, normal)))


def simo_reissner(u, rotation, frame):
    """Strains of the geometrically exact, shear-flexible beam.

    Gamma = R^T phi' - t and K = R^T k on the axes of the reference frame (Reissner 1972,
    eqs. 12-14, in the plane; Simo 1985, eqs. 3.7-3.8, in space), with Gamma = R^T u' + (R^T t - t) so that the
    small strains of slender beams are not differences of numbers near 1.

    Parameters
    ----------
    u : UFL vector
        Displacement of the centre line (length unit of the mesh).
    rotation : PlanarRotation or SpatialRotation
        Rotation of the cross-section from the reference configuration.
    frame : CurveFrame

    Returns
    -------
    UFL vector, shape (3,) in the plane: axial strain, shear strain, change of curvature;
    shape (6,) in space: axial strain, two shear strains, twist, two changes of curvature.
    Strains have no unit, curvatures 1 / length.
    """
    stretch = rotation.pull_back(frame.along(u)) + rotation.pulled_change(frame.tangent)
    return ufl.as_vector([ufl.dot(stretch, axis) for axis in frame.axes] + rotation.bending(frame))

