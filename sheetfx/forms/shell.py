"""Geometrically exact shells: reference frame and strain measures."""

from __future__ import annotations

from dataclasses import dataclass

import ufl


@dataclass(frozen=True)
class SurfaceFrame:
    """Reference frame of a surface, cell by cell, so that folds and junctions need no shared normal.

    Attributes
    ----------
    domain : ufl mesh
    axes : tuple of three UFL vectors: orthonormal tangents and normal
    director : UFL vector, the normal as a field whose gradient is the curvature of the surface
    to_mesh : UFL tensor, shape (3, 3), from tangent vectors of the surface to those of the meshed one below it; None:
        the surface is the meshed one
    """

    domain: object
    axes: tuple
    director: object
    to_mesh: object = None

    @property
    def tangents(self):
        return self.axes[:2]

    def along(self, f, direction):
        """Derivative of a field along a tangent vector per unit of reference length."""
        return ufl.dot(ufl.grad(f), direction if self.to_mesh is None else ufl.dot(self.to_mesh, direction))

    def at(self, offset):
        """Frame of the parallel surface at a distance along the director, and its area per area of this one.

        A place x on this surface is x + offset n on the other, so that tangents there are t_a + offset n,_a (the
        shifter, Naghdi 1972, section 7): derivatives are taken per length of the parallel surface.
        """
        moved = [t + offset * self.along(self.director, t) for t in self.tangents]
        shift = ufl.as_matrix([[ufl.dot(m, t) for t in self.tangents] for m in moved])
        area, back = ufl.det(shift), ufl.inv(shift)
        below, tangents = ([sum(back[c, a] * v[a] for a in range(2)) for c in range(2)] for v in (self.tangents, moved))
        to_mesh = sum(ufl.outer(b, t) for b, t in zip(below, self.tangents, strict=True))
        if self.to_mesh is not None:
            to_mesh = ufl.dot(self.to_mesh, to_mesh)
        return SurfaceFrame(self.domain, (*tangents, self.axes[2]), self.director, to_mesh), area


def surface_frame(domain, director=None, middle=None) -> SurfaceFrame:
    """Frame of a surface from the Jacobian of its mesh.

    Parameters
    ----------
    domain : ufl mesh of topological dimension 2 in space
    director : UFL vector, shape (3,)
        Unit normals interpolated in each cell; None: the normal of flat cells.
    middle : pair of UFL vectors, shape (3,)
        Tangent and normal of each cell's middle: the axes are turned from there by the smallest rotation, so that
        another tangent's are the same but for a constant angle. None: the tangent of flat cells.
    """
    normal = unit_normal(domain)
    first = unit_tangent(domain)
    if middle is not None:
        first, before = middle
        first = first - ufl.dot(normal, first) / (1 + ufl.dot(normal, before)) * (normal + before)
    return SurfaceFrame(domain, (first, ufl.cross(normal, first), normal), normal if director is None else director)


def unit_tangent(domain):
    """Tangent of a cell along its first reference coordinate."""
    jacobian = ufl.Jacobian(domain)
    column = ufl.as_vector([jacobian[i, 0] for i in range(3)])
    return column / ufl.sqrt(ufl.dot(column, column))


def along_surface(direction, normal):
    """Part of a direction that is tangent to a surface."""
    return direction - ufl.dot(direction, normal) * normal


def unit_normal(domain):
    """Normal of a surface in its reference configuration."""
    jacobian = ufl.Jacobian(domain)
    normal = ufl.cross(*(ufl.as_vector([jacobian[i, a] for i in range(3)]) for a in range(2)))
    return normal / ufl.sqrt(ufl.dot(normal, normal))


@dataclass(frozen=True)
class ShellStrains:
    """Generalised strains of a shell on the axes of its frame.

    Attributes
    ----------
    membrane : UFL vector (e11, e22, 2 e12)
    bending : UFL vector (k11, k22, 2 k12), 1 / length
    shear : UFL vector (g1, g2), transverse
    drilling : UFL scalar, in-plane rotation of the surface minus the rotation field's
    """

    membrane: object
    bending: object
    shear: object
    drilling: object

    @property
    def vector(self):
        """All strains in the order membrane, bending, shear, drilling, shape (9,)."""
        parts = (self.membrane, self.bending, self.shear)
        return ufl.as_vector([part[i] for part in parts for i in range(part.ufl_shape[0])] + [self.drilling])


def off_the_surface(u, rotation, frame, offset):
    """Displacement and frame of the parallel surface at a distance along the director, and its area per area.

    Any form whose strains are written in these has the strains of that surface, per its own length.
    """
    return u + offset * (rotation.rotate(frame.director) - frame.director), *frame.at(offset)


def naghdi(u, rotation, frame, offset=0.0) -> ShellStrains:
    """Green-Lagrange strains of the one-director shell with finite rotations.

    e_ab = (f_a . f_b - t_a . t_b) / 2, k_ab = sym(f_a . d,_b - t_a . n,_b), g_a = f_a . d - t_a . n
    (Naghdi 1972, section 11; Simo and Fox 1989, eqs. 4.23-4.25) with f_a = t_a + u,_a and d = R n;
    drilling (f_1 . R t_2 - f_2 . R t_1) / 2 (Fox and Simo 1992, eq. 3.3).

    Parameters
    ----------
    u : UFL vector, shape (3,)
        Displacement of the reference surface (length unit of the mesh).
    rotation : SpatialRotation
        Rotation of the director frame from the reference configuration.
    frame : SurfaceFrame
        Of the reference surface.
    offset : float
        Distance from it along the director at which strains are taken (length), see `off_the_surface`. `Shell(offset=)`
        needs none: it gives displacement and frame of the mid-surface.
    """
    if not isinstance(offset, (int, float)) or offset:
        u, frame, _ = off_the_surface(u, rotation, frame, offset)
    t, n = frame.tangents, frame.director
    d = rotation.rotate(n)
    slope = [frame.along(d, a) for a in t]
    start = [frame.along(n, a) for a in t]
    f = [a + frame.along(u, a) for a in t]

    def membrane(a, b):
        return (ufl.dot(f[a], f[b]) - ufl.dot(t[a], t[b])) / 2

    def bending(a, b):
        return ufl.dot(f[a], slope[b]) - ufl.dot(t[a], start[b])

    turned = [rotation.rotate(a) for a in frame.tangents]
    return ShellStrains(
        membrane=ufl.as_vector([membrane(0, 0), membrane(1, 1), 2 * membrane(0, 1)]),
        bending=ufl.as_vector([bending(0, 0), bending(1, 1), bending(0, 1) + bending(1, 0)]),
        shear=ufl.as_vector([ufl.dot(f[a], d) - ufl.dot(t[a], n) for a in range(2)]),
        drilling=(ufl.dot(f[0], turned[1]) - ufl.dot(f[1], turned[0])) / 2,
    )


def biot(u, rotation, frame, offset=0.0) -> ShellStrains:
    """Strains of the one-director shell on axes that turn with its rotation, for bending that stretches its faces much.

    e_ab = sym(f_a . R t_b - t_a . t_b), k_ab = sym(d,_a . R t_b - n,_a . t_b), g_a = f_a . d - t_a . n: the symmetric
    parts of the strains of Reissner 1974, and drilling as `naghdi` has it. Small strains are the same by both. Naghdi's
    bending strain has the stretch as a factor, so that a moment M at a curvature k brings a membrane force -M k: by
    that a plastic hinge as short as the shell is thick shortens and softens.

    Parameters as of `naghdi`.
    """
    if not isinstance(offset, (int, float)) or offset:
        u, frame, _ = off_the_surface(u, rotation, frame, offset)
    t, n = frame.tangents, frame.director
    d, turned = rotation.rotate(n), [rotation.rotate(a) for a in t]
    slope, start = [frame.along(d, a) for a in t], [frame.along(n, a) for a in t]
    f = [a + frame.along(u, a) for a in t]

    def symmetric(now, before):
        both = [[ufl.dot(now[a], turned[b]) - ufl.dot(before[a], t[b]) for b in range(2)] for a in range(2)]
        return ufl.as_vector([both[0][0], both[1][1], both[0][1] + both[1][0]])

    return ShellStrains(
        membrane=symmetric(f, t),
        bending=symmetric(slope, start),
        shear=ufl.as_vector([ufl.dot(f[a], d) - ufl.dot(t[a], n) for a in range(2)]),
        drilling=(ufl.dot(f[0], turned[1]) - ufl.dot(f[1], turned[0])) / 2,
    )
