"""Loads on a structure: plain data, checked when made."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import ufl

from ..mesh.reader import COMPONENTS, Model
from .beam import Bar, Beam
from .obstacles import RigidCylinder, RigidPlane
from .shell import Shell


def _require_components(what: str, given: Sequence[float], count: int) -> None:
    """Refuse a vector of another length than the structure's space demands."""
    if len(given) != count:
        raise ValueError(f"{what} {tuple(map(float, given))} has {len(given)} components; give {count}")


@dataclass(frozen=True)
class PointForce:
    """Force of fixed direction at each vertex of a named point, for a load factor of 1."""

    model: Model
    at: str
    force: tuple[float, ...]

    def __post_init__(self):
        self.model.at(self.at)
        _require_components(f"PointForce at {self.at!r}: force", self.force, self.model.dimension)


@dataclass(frozen=True)
class Moment:
    """Moment at a named point or per length of a named edge, conjugate to the spin.

    One number in the plane, three in space.
    """

    model: Model
    at: str
    moment: float | tuple[float, float, float]

    def __post_init__(self):
        _require_components(f"Moment at {self.at!r}: moment", np.ravel(self.moment), 2 * self.model.dimension - 3)


@dataclass(frozen=True, eq=False)
class LineForce:
    """Force per reference length on a beam or on bars; `follower`: components on the turning frame.

    The force is given by numbers, or by a function from the place (UFL vector) to components.

    In space the tangent of a follower force takes rotations between nodes to the first order, which costs
    an iteration, not accuracy.
    """

    beam: Beam | Bar
    force: tuple[float, ...] | Callable
    follower: bool = False

    def __post_init__(self):
        if not callable(self.force):
            _require_components("LineForce: force", self.force, self.beam.model.dimension)
        if self.follower and isinstance(self.beam, Bar):
            raise ValueError("LineForce: follower is True, but bars have no cross-section that turns; make it False")

    def components(self) -> Sequence:
        """Numbers, or UFL expressions of the place."""
        return self.force(ufl.SpatialCoordinate(self.beam.model.mesh)) if callable(self.force) else self.force


@dataclass(frozen=True)
class EdgeForce:
    """Force of fixed direction per reference length of a named edge of shells."""

    model: Model
    at: str
    force: tuple[float, float, float]


@dataclass(frozen=True, eq=False)
class SurfaceForce:
    """Force of fixed direction per reference area of a shell."""

    shell: Shell
    force: tuple[float, float, float]


@dataclass(frozen=True, eq=False)
class Pressure:
    """Pressure along the current normal of a shell, which follows it as it turns."""

    shell: Shell
    pressure: float


@dataclass(frozen=True, eq=False)
class Push:
    """Force on an obstacle along its travel."""

    obstacle: RigidCylinder | RigidPlane
    force: float


@dataclass(frozen=True)
class Motion:
    """Prescribed displacement component of a named point, or of all of a named edge; its reaction is an unknown.

    Nodes of the edge where a support fixes the component stay there.
    """

    model: Model
    at: str
    component: str
    distance: float

    def __post_init__(self):
        known = COMPONENTS[self.model.dimension][:self.model.dimension]
        self.model.at(self.at)
        if self.component not in known:
            raise ValueError(f"Motion of {self.at!r}: no component {self.component!r}; choose from {' '.join(known)}")
