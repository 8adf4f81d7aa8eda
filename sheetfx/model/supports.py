"""Supports: components of displacement and rotation that are held."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Annotated

import numpy as np

from ..checks import NONZERO, Text, check, checked, require_known_component
from ..mesh.reader import COMPONENTS, NamedMesh


@dataclass(frozen=True)
class Support:
    """Fixed components at a named point or edge: any of x y z rx ry rz, separated by spaces.

    In space components of the rotation hold the rotation R since the reference configuration, however many steps have
    led to it. With a, b, c the axes that rx, ry, rz stand for, in cyclic order, it is at each node of the support

    - fixed about a, b and c: R = 1.
    - fixed about a and b: R c = c. The node turns about c alone, by any angle.
    - fixed about a, at a point: the axis of R is perpendicular to a; for the quaternion (q0, v) of R this is v . a = 0.
      What points along a is carried to where it points now the shortest way, and not twisted: a hinge that transmits
      the torsion about a, whatever the direction in which a member along a leaves its place.
    - fixed about a, on an edge of a surface: c . R t = 0, where t is the direction of the edge across a, and c = a x t.
      The line along the edge stays in the plane of a and t, and turns in it; the surface turns about that line. This
      is the simply supported edge of plates and shells, with a in the surface normal to the edge: "z rx" on an edge
      along y of a plate across z holds c . R t = e_z . R e_y = 0. Its director does not tilt along the edge, and an
      edge that stays in the plane anyway, as thin plates do, is not held any further. Without rx such an edge is a
      soft support, whose director is free to tilt.

    An edge counts as a point where it runs along a, within 30 degrees, and where edges of several directions meet.
    What several supports hold at a node is held together, whatever their axes: at an oblique corner of two edges with
    "z rx", each on its own axes, rx and ry.

    Attributes
    ----------
    axes : three orthonormal directions that x, y, z and rx, ry, rz stand for, or a function from places, shape
        (n, 3), to directions, shape (n, 3 directions, 3 components); None: the axes of space
    """

    mesh: NamedMesh
    at: str
    fixed: Text
    axes: Sequence[Sequence[float]] | Callable | None = None

    def __post_init__(self):
        check(self)
        known = COMPONENTS[self.mesh.dimension]
        self.mesh.require(f"Support at {self.at!r}", self.at, "point", "edge")
        for name in self.fixed.split():
            require_known_component(f"Support at {self.at!r}", name, known)
        if self.axes is not None and self.mesh.dimension != 3:
            raise ValueError(f"Support at {self.at!r}: axes are for structures in space")

    def directions(self, places: np.ndarray) -> np.ndarray:
        """Directions at places, shape (n, 3, 3), one direction in each row."""
        axes = self.axes(places) if callable(self.axes) else np.broadcast_to(self.axes, (len(places), 3, 3))
        axes = np.asarray(axes, dtype=float)
        if not np.allclose(axes @ axes.transpose(0, 2, 1), np.eye(3), atol=1e-9):
            raise ValueError(f"Support at {self.at!r}: axes must be three orthonormal directions")
        return axes


@dataclass(frozen=True)
class Symmetry(Support):
    """Support where a plane of symmetry cuts the structure, see `symmetry`."""


@checked
def clamp(mesh: NamedMesh, at: str) -> Support:
    """All displacements and rotations fixed."""
    return Support(mesh, at, " ".join(COMPONENTS[mesh.dimension]))


@checked
def pin(mesh: NamedMesh, at: str) -> Support:
    """All displacements fixed."""
    return Support(mesh, at, " ".join(c for c in COMPONENTS[mesh.dimension] if not c.startswith("r")))


@checked
def symmetry(mesh: NamedMesh, at: str,
             normal: str | Annotated[tuple[float, float, float], NONZERO] = "x") -> Symmetry:
    """Structure cut by a plane: no displacement along its normal, rotation about the normal only.

    Parameters
    ----------
    normal : x, y or z, or a vector of any direction
    """
    if not isinstance(normal, str):
        return Symmetry(mesh, at, "x ry rz", _axes_from(normal))
    if normal not in ("x", "y", "z"):
        raise ValueError(f"symmetry at {at!r}: normal is {normal!r}; it must be x, y or z")
    turns = [f"r{c}" for c in "xyz" if c != normal and f"r{c}" in COMPONENTS[mesh.dimension]]
    return Symmetry(mesh, at, " ".join([normal, *turns]))


def _axes_from(first: Sequence[float]) -> np.ndarray:
    """Three orthonormal directions of which the first is given."""
    columns = np.column_stack((first, np.eye(3)[np.argsort(np.abs(first))[:2]].T))
    axes = np.linalg.qr(columns)[0].T
    return axes * np.sign(axes[0] @ np.asarray(first, dtype=float))
