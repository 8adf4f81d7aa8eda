"""Interface laws: gaps to obstacles, and the augmented tractions that enforce them.

A law is written in the gap (positive when open), the slip and their multipliers. The
enforcement decides what the multipliers are: zero (penalty), constants that are updated
(Uzawa), or unknowns (semismooth Newton). The law itself is the same in all three.
"""

from __future__ import annotations

import ufl


def cylinder_gap(x, centre, radius):
    """Distance of point `x` from a circle or cylinder about `centre`; negative inside.

    The cylinder's axis is normal to the plane of the two first coordinates.
    """
    r = ufl.as_vector([x[0] - centre[0], x[1] - centre[1]])
    return ufl.sqrt(ufl.dot(r, r)) - radius


def cylinder_slip(x, centre, x_before, centre_before, radius):
    """Arc length on the cylinder between the feet of a point before and after a step."""
    a = ufl.as_vector([x_before[i] - centre_before[i] for i in (0, 1)])
    b = ufl.as_vector([x[i] - centre[i] for i in (0, 1)])
    return radius * ufl.atan2(a[0] * b[1] - a[1] * b[0], ufl.dot(a, b))


def plane_gap(x, point, normal):
    """Distance of `x` from the plane through `point` with unit `normal`."""
    return ufl.dot(x - point, normal)


def plane_slip(x, point, x_before, point_before, tangent):
    """Displacement along a plane's `tangent` relative to the plane during a step."""
    return ufl.dot((x - point) - (x_before - point_before), tangent)


def contact_pressure(multiplier, gap, scale):
    """Unilateral contact: pressure <multiplier - scale gap> (Alart and Curnier 1991, eq. 3.4).

    Parameters
    ----------
    multiplier : UFL scalar
        Pressure (force per length of a beam), zero for pure penalty.
    gap : UFL scalar, length
    scale : float or UFL constant
        Augmentation (pressure per length); the penalty stiffness where there is no multiplier.
    """
    return ufl.max_value(multiplier - scale * gap, 0)


def coulomb_traction(multiplier, slip, scale, pressure, friction):
    """Coulomb friction: projection of the trial traction on the cone (Alart and Curnier 1991).

    The traction is conjugate to the slip and opposes it; sticking inside the cone. On its surface
    the law slides, so that a point without pressure has no tangential stiffness.
    """
    bound, trial = friction * pressure, multiplier + scale * slip
    return ufl.conditional(ufl.ge(trial, bound), bound, ufl.conditional(ufl.le(trial, -bound), -bound, trial))
