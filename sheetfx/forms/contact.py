"""Contact of two parts: where they are against each other, and the tractions that this makes.

Kinematics and law are separate. `on_fixed_partner` and `on_moving_partner` give the gap (positive when open) and the
slips from traces of both parts; `mohr_coulomb` gives pressure and tractions from them, and any function with its
arguments can stand in its place.
"""

from __future__ import annotations

import ufl

from .interface import rotation_of


def on_fixed_partner(first, second, arm, axes, gap):
    """Gap and slips against the point of the second part that was opposite in the beginning.

    The place of the second point is seen from the first one, on axes that turn with it (Wriggers 2006, section 4.1,
    for pairs of nodes).

    Parameters
    ----------
    first, second : lists of UFL vectors: displacement, and of the first part rotation where it has one
    arm : UFL vector from the first to the second point in the reference configuration
    axes : UFL vector, directions one behind the other: out of the first part's face, then along it
    gap : UFL scalar, the initial one

    Returns
    -------
    list of UFL scalars: the gap, and slips of the second part along the face (one in the plane, two in space).
    """
    place = _seen_from(first, second[0] - first[0], arm)
    change = [_along(axes, row, place) - _along(axes, row, arm) for row in range(arm.ufl_shape[0])]
    return [gap + change[0], *change[1:]]


def on_moving_partner(first, second, arm, slopes, curvatures, axes, start):
    """Gap and slips against the point of a curve that is opposite now.

    The partner is where the plane through the first point that is normal to the second axis (which lies along the
    curve) cuts it. Near the point of the curve at which the traces are taken the curve is y + y' s + y'' s^2 / 2, so
    that s is the root of a quadratic equation; at s = 0 values and both derivatives are the true partner's, and
    the tangent is the exact Hessian though the point moves.

    Parameters
    ----------
    first : as of `on_fixed_partner`
    second : list of UFL vectors: displacement of the curve, and its first and second derivative by arc length
    arm, slopes, curvatures : UFL vectors, from the first point to the curve's in the reference configuration, and
        derivatives of the curve's place by arc length
    axes : as of `on_fixed_partner`
    start : UFL vector: initial gap, initial place along each axis, then how far the partner has moved along the curve

    Returns
    -------
    list of UFL scalars as of `on_fixed_partner`; the first slip is how far the second part has moved past the first.
    """
    dimension = arm.ufl_shape[0]
    place = _seen_from(first, second[0] - first[0], arm)
    slope, curvature = (_pulled_back(first, v) for v in (slopes + second[1], curvatures + second[2]))
    a, b, c = (_along(axes, 1, v) for v in (place, slope, curvature))
    root = ufl.sqrt(ufl.max_value(b * b - 2 * a * c, b * b / 4))
    ahead = -2 * a / (b + ufl.conditional(ufl.ge(b, 0), root, -root))
    here = place + ahead * slope + ahead * ahead / 2 * curvature
    across = [_along(axes, row, here) - start[1 + row] for row in range(dimension)]
    passed = -ufl.sign(b) * (start[1 + dimension] + ahead)
    return [start[0] + across[0], passed, *across[2:]]


def on_obstacle(gap, place, shift, before, slipped):
    """Gap of a point to a rigid obstacle, and its slips past that, in the plane that touches it, along each direction.

    Parameters
    ----------
    gap : function from a place and a shift of the obstacle to the distance of the place from it
    place : UFL vector, where the point is
    shift : list of UFL scalars, how far the obstacle has moved along each direction
    before : UFL vector, where the point was at the last accepted state, seen from the obstacle
    slipped : UFL vector, slips until then

    Returns
    -------
    list of UFL scalars: the gap, and a slip for each direction of space.
    """
    here = ufl.variable(place)
    distance = gap(here, shift)
    normal = ufl.diff(distance, here)
    passed = place - ufl.as_vector(shift) - before
    along = slipped + passed - ufl.dot(passed, normal) * normal
    return [distance, *(along[i] for i in range(place.ufl_shape[0]))]


def mohr_coulomb(gap, slips, pressure, tractions, parameters):
    """Unilateral contact with Coulomb friction, cohesion and a tensile strength (thesis, eq. 3.12).

    Pressure <p - K gap> of an augmented Lagrangian (Simo and Laursen 1992, eq. 2.10), which is a penalty where p is
    zero; parts without a gap touch. Tension goes up to the strength and stays there while the gap opens. Tractions are
    the trial ones, returned radially to the cone mu p + c; slip does not open the gap.

    Parameters
    ----------
    gap, slips : UFL scalar, and list of slips since the last accepted state (length)
    pressure, tractions : multipliers, UFL scalar and list: zero, or as they were at the last accepted state
    parameters : UFL vector: normal stiffness, tangential stiffness, friction coefficient, cohesion, tensile strength

    Returns
    -------
    (pressure, tractions) : force per length of the line of contact; tractions against the slip of the second part
    """
    normal, tangential, friction, cohesion, strength = (parameters[i] for i in range(5))
    trial = pressure - normal * gap
    closed = ufl.ge(trial, -strength)
    pressed = ufl.conditional(closed, trial, -strength)
    if not slips:
        return pressed, []
    bound = ufl.conditional(closed, ufl.max_value(friction * pressed + cohesion, 0), 0)
    sticking = [t + tangential * s for t, s in zip(tractions, slips, strict=True)]
    size = ufl.sqrt(sum(t * t for t in sticking) + 1e-30)
    share = ufl.conditional(ufl.lt(size, bound), 1.0, bound / size)
    return pressed, [share * t for t in sticking]


def strains_of(kinematics, history, slips: bool):
    """Generalised strains of a contact: gap, slips since the last accepted state, and what the law remembers.

    Parameters
    ----------
    kinematics : list of UFL scalars, as `on_fixed_partner` gives it
    history : UFL vector: multipliers of the pressure and of the tractions, then the slips that they belong to
    slips : whether the law knows of slips
    """
    count = len(kinematics) - 1
    if not slips:
        return ufl.as_vector([kinematics[0], history[0]])
    since = [kinematics[1 + i] - history[1 + count + i] for i in range(count)]
    return ufl.as_vector([kinematics[0], *since, *(history[i] for i in range(1 + count))])


def resultants_of(law, strains, parameters, slips: int):
    """Forces conjugate to `strains_of`: a pressure works against the gap; remembered values do no work."""
    pressure, tractions = law(strains[0], [strains[1 + i] for i in range(slips)], strains[1 + slips],
                              [strains[2 + slips + i] for i in range(slips)], parameters)
    return ufl.as_vector([-pressure, *tractions, *[0.0] * (1 + slips)])


def _seen_from(first, apart, arm):
    """Place of the second point on axes that turn with the first."""
    if len(first) == 1:
        return apart + arm
    turn = rotation_of(first[1])
    return turn.pull_back(apart) + turn.pulled_change(arm) + arm


def _pulled_back(first, vector):
    return vector if len(first) == 1 else rotation_of(first[1]).pull_back(vector)


def _along(axes, row, vector):
    count = vector.ufl_shape[0]
    return sum(axes[count * row + i] * vector[i] for i in range(count))
