"""Finite rotations of a director frame, written so that the increment is a free variable.

A rotation object answers three questions about a cross-section or director: where a reference
vector points now (`rotate`), which reference vector points along a current one (`pull_back`), and
how fast the rotation changes along the structure (`bending`). Strain measures use nothing else,
so the same strain measure serves planar and spatial structures.
"""

from __future__ import annotations

from dataclasses import dataclass

import ufl


def cross_matrix_product(quaternion_scalar, quaternion_vector, a):
    """Rotate `a` by a quaternion of any length with the rational (Cayley) formula.

    R a = a + (2 q0 v x a + 2 v x (v x a)) / |q|^2; no trigonometric function and no
    normalisation is needed (Geradin and Cardona 2001, eq. 4.45).
    """
    return a + turning(quaternion_scalar, quaternion_vector, a)


def turning(quaternion_scalar, quaternion_vector, a):
    """R a - a by the same formula."""
    q0, v = quaternion_scalar, quaternion_vector
    length2 = q0 * q0 + ufl.dot(v, v)
    va = ufl.cross(v, a)
    return 2 * (q0 * va + ufl.cross(v, va)) / length2


def compose(increment, quaternion):
    """Apply a Rodrigues increment (twice the tangent of half the angle) to a stored quaternion.

    (1, increment/2) * quaternion in Hamilton's product (Geradin and Cardona 2001, eq. 4.61).

    Parameters
    ----------
    increment : UFL vector, shape (3,)
    quaternion : UFL vector, shape (4,)
        Scalar part first; need not have unit length.

    Returns
    -------
    (scalar, vector) of the product, not normalised.
    """
    q0 = quaternion[0]
    v = ufl.as_vector([quaternion[1], quaternion[2], quaternion[3]])
    return (
        q0 - ufl.dot(increment, v) / 2,
        v + (q0 * increment + ufl.cross(increment, v)) / 2,
    )


@dataclass(frozen=True)
class PlanarRotation:
    """Rotation in the plane by one angle (radians, unlimited)."""

    angle: object

    def rotate(self, a):
        c, s = ufl.cos(self.angle), ufl.sin(self.angle)
        return ufl.as_vector([c * a[0] - s * a[1], s * a[0] + c * a[1]])

    def pull_back(self, a):
        c, s = ufl.cos(self.angle), ufl.sin(self.angle)
        return ufl.as_vector([c * a[0] + s * a[1], c * a[1] - s * a[0]])

    def change(self, a):
        """`rotate(a) - a` to all digits where the rotation is small."""
        c, s = -2 * ufl.sin(self.angle / 2) ** 2, ufl.sin(self.angle)
        return ufl.as_vector([c * a[0] - s * a[1], s * a[0] + c * a[1]])

    def pulled_change(self, a):
        """`pull_back(a) - a` to all digits where the rotation is small."""
        c, s = -2 * ufl.sin(self.angle / 2) ** 2, ufl.sin(self.angle)
        return ufl.as_vector([c * a[0] + s * a[1], c * a[1] - s * a[0]])

    def bending(self, frame):
        """Change of curvature, a list of one component."""
        return [frame.along(self.angle)]


@dataclass(frozen=True)
class SpatialRotation:
    """Stored quaternion followed by a Rodrigues increment; no limit on the total rotation.

    An increment is zero when forms are evaluated; it exists so that the virtual work of loads can be
    written with the spin, its variation at zero.
    """

    quaternion: object
    increment: object = None

    def _product(self):
        if self.increment is None:
            q = self.quaternion
            return q[0], ufl.as_vector([q[1], q[2], q[3]])
        return compose(self.increment, self.quaternion)

    def rotate(self, a):
        return cross_matrix_product(*self._product(), a)

    def pull_back(self, a):
        q0, v = self._product()
        return cross_matrix_product(q0, -v, a)

    def change(self, a):
        """`rotate(a) - a` to all digits where the rotation is small."""
        return turning(*self._product(), a)

    def pulled_change(self, a):
        """`pull_back(a) - a` to all digits where the rotation is small."""
        q0, v = self._product()
        return turning(q0, -v, a)

    def bending(self, frame):
        """Material change of curvature R^T k on the frame's axes (torsion first).

        k = 2 (q0 v' - q0' v + v x v') / |q|^2 (Geradin and Cardona 2001, eq. 4.62).
        """
        q0, v = self._product()
        rate0, rate = frame.along(q0), frame.along(v)
        length2 = q0 * q0 + ufl.dot(v, v)
        spatial = 2 * (q0 * rate - rate0 * v + ufl.cross(v, rate)) / length2
        material = cross_matrix_product(q0, -v, spatial)
        return [ufl.dot(material, axis) for axis in frame.axes]
