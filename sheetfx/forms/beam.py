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
    direction : UFL vector, the tangent as a field whose gradient is the curvature of the curve; None: straight cells
    """

    axes: tuple
    direction: object = None

    @property
    def tangent(self):
        return self.axes[0]

    @property
    def normal(self):
        return self.axes[1]

    def along(self, f):
        """Derivative of a field with respect to the reference arc length."""
        return ufl.dot(ufl.grad(f), self.tangent)

    def length_at(self, offset):
        """Length of fibres that stand off the curve by components on the cross-section's axes, per length of the curve.

        Sections stand across the curve, so that fibres on the inside of a bend are shorter: 1 - curvature . offset.
        """
        if self.direction is None:
            return 1.0
        bend = self.along(self.direction)
        return 1 - sum(c * ufl.dot(bend, axis) for c, axis in zip(offset, self.axes[1:], strict=True))


def unit_tangent(domain):
    """Unit tangent of a curve from the Jacobian of its mesh."""
    jacobian = ufl.Jacobian(domain)
    column = ufl.as_vector([jacobian[i, 0] for i in range(jacobian.ufl_shape[0])])
    return column / ufl.sqrt(ufl.dot(column, column))


def curve_frame(domain, up=None, direction=None) -> CurveFrame:
    """Frame of a curve from the Jacobian of its mesh.

    Parameters
    ----------
    domain : ufl mesh of topological dimension 1
    up : sequence of 3 floats or UFL vector, shape (3,)
        In space: a vector that, made perpendicular to the tangent, is the normal (first
        principal axis of the section). Must not be parallel to the tangent.
    direction : UFL vector
        Unit tangents interpolated in each cell, where the curvature matters.
    """
    tangent = unit_tangent(domain)
    if tangent.ufl_shape == (2,):
        return CurveFrame((tangent, ufl.as_vector([-tangent[1], tangent[0]])), direction)
    if not isinstance(up, ufl.core.expr.Expr):
        up = ufl.as_vector([float(c) for c in up])
    normal = up - ufl.dot(up, tangent) * tangent
    normal = normal / ufl.sqrt(ufl.dot(normal, normal))
    return CurveFrame((tangent, normal, ufl.cross(tangent, normal)), direction)


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



def off_the_line(strains, offset, length):
    """Strains of a line that the sections carry beside the curve, from the curve's own.

    A point at e in the section stands at x + u + R e, whose derivative adds R' e to the curve's: Gamma + K x e
    on the axes of the reference frame (Simo 1985, eq. 3.7, of the line beside the curve). All strains are then
    taken per length of that line.

    Parameters
    ----------
    strains : UFL vector in the order of `simo_reissner`
    offset : e on the cross-section's axes: along the normal, in space also along the binormal (length)
    length : of the line beside the curve per length of the curve, see `CurveFrame.length_at`
    """
    if len(offset) == 1:
        carried = [-strains[2] * offset[0], 0.0]
    else:
        twist, about_normal, about_binormal = (strains[i] for i in range(3, 6))
        along_normal, along_binormal = offset
        carried = [about_normal * along_binormal - about_binormal * along_normal, -twist * along_binormal,
                   twist * along_normal]
    carried += [0.0] * (len(strains) - len(carried))
    return ufl.as_vector([(e + c) / length for e, c in zip(strains, carried, strict=True)])
