"""Loads as virtual work; `vary` turns a quantity into its variation."""

from __future__ import annotations

import ufl


def dead_force(force, u, vary):
    """Force of fixed direction: density times the variation of the displacement."""
    return ufl.dot(force, vary(u))


def follower_force(components, frame, rotation, u, vary):
    """Force that turns with the cross-section, given by components on the reference frame."""
    force = sum(c * axis for c, axis in zip(components, frame.axes, strict=True))
    return ufl.dot(rotation.rotate(force), vary(u))


def spin_moment(moment, spin_variation):
    """Moment of fixed direction, conjugate to the spin (Simo and Vu-Quoc 1986, section 3)."""
    return ufl.inner(moment, spin_variation)


def pressure(value, u, frame, vary):
    """Pressure on a deformed surface per reference area, along f_1 x f_2 (Simo, Taylor and Wriggers 1991, eq. 2.9).

    Its consistent tangent is the derivative; it is symmetric only where the edges are held.
    """
    first, second = (t + frame.along(u, t) for t in frame.tangents)
    return value * ufl.dot(ufl.cross(first, second), vary(u))


def line_pressure(value, u, frame, vary):
    """Pressure on a deformed curve in the plane per reference length, along its normal, on the left of its direction.

    The plane case of Simo, Taylor and Wriggers 1991, eq. 2.9: the tangent of the curve turned by a right angle.
    """
    tangent = frame.tangent + frame.along(u)
    return value * ufl.dot(ufl.as_vector([-tangent[1], tangent[0]]), vary(u))


def rigid_measures(x, u, rotation, length):
    """Densities of displacement, and of rotation about the origin, that are linear in small motions.

    Of the small rigid motions of a body none but rest has integrals that are all zero.

    Parameters
    ----------
    x, u : UFL vectors, shape (d,)
    rotation : see `forms.rotation`; None: there is none
    length : that rotations of cross-sections are multiplied by, squared; any that is positive

    Returns
    -------
    list of UFL scalars: d displacements, then one rotation in the plane, three in space
    """
    if len(u) == 2:
        turn = x[0] * u[1] - x[1] * u[0]
        return [u[0], u[1], turn if rotation is None else turn + length**2 * rotation.angle]
    turn = ufl.cross(x, u)
    if rotation is not None:
        axes = [ufl.as_vector(row) for row in ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))]
        turn = turn + length**2 / 2 * sum((ufl.cross(a, rotation.change(a)) for a in axes[1:]),
                                          ufl.cross(axes[0], rotation.change(axes[0])))
    return [*(u[i] for i in range(3)), *(turn[i] for i in range(3))]
