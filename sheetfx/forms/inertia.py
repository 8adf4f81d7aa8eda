"""Virtual work of inertia about a state at rest; `rate` and `variation` are linear in trial and test functions."""

from __future__ import annotations

import ufl


def translation(mass, rate, variation):
    """Work of accelerated mass: mass per length or area times the product of the two."""
    return mass * ufl.inner(rate, variation)


def carried(change, spin, arm):
    """Rate or variation of a point at the end of an arm that turns with the cross-section or the director.

    Parameters
    ----------
    change, spin : of the start of the arm; the spin a UFL scalar in the plane
    arm : UFL vector, as it points now (length)
    """
    if spin.ufl_shape == ():
        return change + spin * ufl.as_vector([-arm[1], arm[0]])
    return change + ufl.cross(spin, arm)


def section(inertia, spin_rate, spin_variation, rotation, frame):
    """Work of the rotary inertia of a beam's section on its turned axes (Simo and Vu-Quoc 1988).

    Parameters
    ----------
    inertia : sequence of floats or UFL constants
        In the plane one, about the binormal; in space those about all axes of the frame, and the off-diagonal one
        of normal and binormal (mass length).
    spin_rate, spin_variation : UFL scalars in the plane, vectors of shape (3,) in space
    rotation : rotation of the section
    frame : CurveFrame
    """
    if spin_rate.ufl_shape == ():
        return inertia[0] * spin_rate * spin_variation
    *about, product = inertia
    rate, variation = ([ufl.dot(spin, rotation.rotate(axis)) for axis in frame.axes]
                       for spin in (spin_rate, spin_variation))
    return (sum(i * r * v for i, r, v in zip(about, rate, variation, strict=True))
            + product * (rate[1] * variation[2] + rate[2] * variation[1]))


def director(inertia, spin_rate, spin_variation, normal):
    """Work of the rotary inertia of a shell's director (Simo, Rifai and Fox 1992): none about the director itself.

    Parameters
    ----------
    inertia : per area, about any axis across the director (mass)
    normal : UFL vector, shape (3,), the director now
    """
    return inertia * ufl.inner(ufl.cross(spin_rate, normal), ufl.cross(spin_variation, normal))
