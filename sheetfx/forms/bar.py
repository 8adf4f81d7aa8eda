"""Pin-jointed bars: reference frame and strain measures."""

from __future__ import annotations

import ufl

from .beam import CurveFrame, unit_tangent


def bar_frame(domain) -> CurveFrame:
    """Frame of straight bars, of which only the tangent is needed."""
    return CurveFrame((unit_tangent(domain),))


def engineering(u, rotation, frame):
    """Change of length over the length, (l - L) / L.

    Parameters
    ----------
    u : UFL vector
        Displacement, linear along each bar (length unit of the mesh).
    rotation : None; stands here so that strain measures of bars and beams are called alike
    frame : CurveFrame

    Returns
    -------
    UFL vector, shape (1,), no unit.
    """
    twice = 2 * green(u, rotation, frame)[0]
    return ufl.as_vector([twice / (ufl.sqrt(1 + twice) + 1)])


def green(u, rotation, frame):
    """Green's strain (l^2 - L^2) / (2 L^2); parameters and result as for `engineering`."""
    slope = frame.along(u)
    return ufl.as_vector([ufl.dot(frame.tangent, slope) + ufl.dot(slope, slope) / 2])
