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
