"""Interface laws: gaps to obstacles, and the augmented tractions that enforce them.

A law is written in the gap (positive when open), the slip and their multipliers. The
enforcement decides what the multipliers are: zero (penalty), constants that are updated
(Uzawa), or unknowns (semismooth Newton). The law itself is the same in all three.
"""

from __future__ import annotations

import ufl

from . import rotation


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


def sphere_gap(x, centre, radius):
    """Distance of point `x` from a sphere (a circle in the plane) about `centre`; negative inside."""
    r = x - ufl.as_vector(centre)
    return ufl.sqrt(ufl.dot(r, r)) - radius


def plane_gap(x, point, normal):
    """Distance of `x` from the plane through `point` with unit `normal`."""
    return ufl.dot(x - point, normal)


def plane_slip(x, point, x_before, point_before, tangent):
    """Displacement along a plane's `tangent` relative to the plane during a step."""
    return ufl.dot((x - point) - (x_before - point_before), tangent)


def contact_pressure(multiplier, gap, scale):
    """Unilateral contact: pressure <multiplier - scale gap> (Alart and Curnier 1991, eq. 3.4).

    Parts without a gap touch.

    Parameters
    ----------
    multiplier : UFL scalar
        Pressure (force per length of a beam), zero for pure penalty.
    gap : UFL scalar, length
    scale : float or UFL constant
        Augmentation (pressure per length); the penalty stiffness where there is no multiplier.
    """
    trial = multiplier - scale * gap
    return ufl.conditional(ufl.ge(trial, 0), trial, 0)


def coulomb_traction(multiplier, slip, scale, pressure, friction):
    """Coulomb friction: projection of the trial traction on the cone (Alart and Curnier 1991).

    The traction is conjugate to the slip and opposes it; sticking inside the cone. On its surface
    the law slides, so that a point without pressure has no tangential stiffness.
    """
    bound, trial = friction * pressure, multiplier + scale * slip
    return ufl.conditional(ufl.ge(trial, bound), bound, ufl.conditional(ufl.le(trial, -bound), -bound, trial))


def linear_spring(extension, stiffness):
    """Force of a linear spring."""
    return stiffness * extension


def extension(displacements):
    """Displacement of the last of one or two points against the first, or against the ground.

    Parameters
    ----------
    displacements : list of one or two UFL vectors
    """
    return displacements[-1] - displacements[0] if len(displacements) > 1 else displacements[0]


def relative_quaternion(first, second):
    """Scalar and vector part of conjugate(first) * second: the turn of the second on the axes of the first."""
    p0, p = first[0], ufl.as_vector([first[1], first[2], first[3]])
    q0, q = second[0], ufl.as_vector([second[1], second[2], second[3]])
    return p0 * q0 + ufl.dot(p, q), p0 * q - q0 * p - ufl.cross(p, q)


def rotation_between(rotations):
    """Rotation of the last of one or two points from the first, or from the ground.

    Parameters
    ----------
    rotations : list of one or two UFL vectors, angles of shape (1,) in the plane or quaternions of shape (4,)

    Returns
    -------
    UFL vector, shape (1,) or the rotation vector of shape (3,), below half a turn, on the axes of the first point.
    """
    if rotations[0].ufl_shape == (1,):
        return extension(rotations)
    q = rotations[0]
    scalar, vector = q[0], ufl.as_vector([q[1], q[2], q[3]])
    if len(rotations) > 1:
        scalar, vector = relative_quaternion(*rotations)
    sine = ufl.sqrt(ufl.dot(vector, vector) + 1e-16)
    return 2 * ufl.atan2(sine, scalar) / sine * vector


def gap_of_arm(first, second, arm):
    """How far the second of two points is off the end of a rigid arm on the first, and turned against it.

    The gap R^T (u_2 - u_1 + arm) - arm of the places, and twice the vector part of the relative quaternion made of
    unit length, which interpolated quaternions are not; both on the axes of the first point (Crisfield 1997, section
    24.3, with the arm as an offset).

    Parameters
    ----------
    first, second : lists of UFL vectors: displacement and, where there is one, rotation (angle or quaternion)
    arm : UFL vector from the first to the second point in the reference configuration

    Returns
    -------
    list of UFL scalars: components of the gap, then of the turn where both points have a rotation.
    """
    apart = second[0] - first[0]
    if len(first) > 1:
        turn = rotation_of(first[1])
        apart = turn.pull_back(apart) + turn.pulled_change(arm)
    return [*(apart[i] for i in range(apart.ufl_shape[0])), *_turn_between(first, second)]


def gap_in_space(first, second, arm):
    """The gap u_2 - u_1 + arm - R arm on the axes of space, and the turn as of `gap_of_arm`.

    Where all of its components are held this is the same constraint. Along lines they are held in the mean only, and
    on axes that turn a force times a turn would work on the rest of the gap: parts would seem to buckle, in
    tension too, at a strain of about thickness over size of a cell.
    """
    apart = second[0] - first[0]
    if len(first) > 1:
        apart = apart - rotation_of(first[1]).change(arm)
    return [*(apart[i] for i in range(apart.ufl_shape[0])), *_turn_between(first, second)]


def mean_gaps(first, u, arm, lever):
    """Share of one of many points in the mean displacement, and turn, against a rigid body that a reference carries.

    With d = u - u_1 + arm - R arm, the means of d and of (R lever) x d vanish where the body is that of least squares
    (Kabsch 1976, for small d).

    Parameters
    ----------
    first : list of displacement and rotation of the reference, UFL vectors
    u : UFL vector, displacement of the point
    arm, lever : UFL vectors from the reference, and from the middle of all points, to the point at rest

    Returns
    -------
    list of UFL scalars: 2 + 1 in the plane, 3 + 3 in space.
    """
    turn = rotation_of(first[1])
    apart, lever = u - first[0] - turn.change(arm), turn.rotate(lever)
    if len(u) == 2:
        return [apart[0], apart[1], lever[0] * apart[1] - lever[1] * apart[0]]
    about = ufl.cross(lever, apart)
    return [*(apart[i] for i in range(3)), *(about[i] for i in range(3))]


def _turn_between(first, second):
    """Components of the turn of the second of two points against the first, where both have a rotation."""
    if len(first) == 1 or len(second) == 1:
        return []
    if first[1].ufl_shape == (1,):
        return [second[1][0] - first[1][0]]
    vector = relative_quaternion(first[1], second[1])[1]
    twice = 2 / ufl.sqrt(ufl.dot(first[1], first[1]) * ufl.dot(second[1], second[1]))
    return [twice * vector[i] for i in range(3)]


def on_axes(components, axes):
    """Components of a gap in space, and of the turn where there is one, along axes of the first part.

    Parameters
    ----------
    components : list of 3 or 6 UFL scalars
    axes : UFL vector, shape (9,), three directions one behind the other
    """
    return [sum(axes[3 * row + i] * components[start + i] for i in range(3))
            for start in range(0, len(components), 3) for row in range(3)]


def stiff(matrix):
    """Law of an elastic joint: the stiffness matrix (of numbers) times the vector of gap and turn."""
    def forces(gap):
        return ufl.as_vector([sum((float(k) * gap[j] for j, k in enumerate(row) if k), ufl.as_ufl(0.0))
                              for row in matrix])
    return forces


def rotation_of(value):
    """Rotation from an angle of shape (1,) or a quaternion."""
    return rotation.PlanarRotation(value[0]) if value.ufl_shape == (1,) else rotation.SpatialRotation(value)


def with_multipliers(gaps, multipliers):
    """Generalised strains of a constraint: its gaps, then their Lagrange multipliers.

    Parameters
    ----------
    gaps : list of UFL scalars
    multipliers : list of UFL vectors of shape (1,)
    """
    return ufl.as_vector([*gaps, *(m[0] for m in multipliers)])


def tied(strains):
    """Law of a constraint: the gradient of multiplier times gap."""
    half = strains.ufl_shape[0] // 2
    return ufl.as_vector([strains[half + i] for i in range(half)] + [strains[i] for i in range(half)])


def turn_from_prescribed(value, factor, rotation):
    """Turn of a point from a prescribed rotation, factor times angle times axis.

    Parameters
    ----------
    value : UFL vector, angle of shape (1,) or quaternion of shape (4,)
    factor : UFL scalar
    rotation : numbers, angle or angle times axis

    Returns
    -------
    list of UFL scalars: the angle, or twice the vector part of the relative quaternion, on the axes of space.
    """
    if value.ufl_shape == (1,):
        return [value[0] - factor * rotation[0]]
    angle = sum(r * r for r in rotation) ** 0.5
    axis = [r / angle if angle else 0.0 for r in rotation]
    sine = ufl.sin(factor * angle / 2)
    prescribed = ufl.as_vector([ufl.cos(factor * angle / 2), *(sine * a for a in axis)])
    vector = relative_quaternion(prescribed, value)[1]
    return [2 * vector[i] for i in range(3)]
