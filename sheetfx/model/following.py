"""Loads that follow what they act on: forces that turn with it, pressure that also grows with its area."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Annotated

import basix.ufl
import numpy as np
import ufl
from dolfinx import fem
from mpi4py import MPI

from .. import forms
from ..checks import Choice, check, require_components
from ..jit import compiled_expression
from ..mesh.reader import NamedMesh
from .beam import Beam
from .loads import LINE_PRESSURE, PRESSURE, Load
from .shell import Shell

SIDES = "negative", "positive"  # of a surface or plane curve, behind and before its normal


@dataclass(frozen=True, eq=False)
class FollowerForce(Load):
    """Force at a named point of beams, or per length of a named edge of shells, that turns with the rotation there.

    Attributes
    ----------
    force : components along the directions of space before anything has turned, for a load factor of 1
    """

    mesh: NamedMesh
    at: str
    force: tuple[float, ...]
    conservative = False

    def __post_init__(self):
        check(self)
        facets = "point" if self.mesh.domain.topology.dim == 1 else "edge"
        self.mesh.require(f"FollowerForce at {self.at!r}", self.at, facets)
        require_components(f"FollowerForce at {self.at!r}: force", self.force, self.mesh.dimension)

    def work(self, fields):
        rotation, u = fields.rotation(self.mesh), fields.displacement(self.mesh)
        if rotation is None:
            raise ValueError(f"FollowerForce at {self.at!r}: bars have no rotation to be followed; use a PointForce")
        force = rotation.rotate(fields.factor * forms.vector(self.force))
        return forms.load.dead_force(force, u, fields.vary) * self.mesh.facet_measure(self.at)

    def total(self, fields) -> float:
        on_point = self.at in self.mesh.points
        return float(np.linalg.norm(self.force)) * (self.mesh.count(self.at) if on_point
                                                    else self.mesh.edge_length(self.at))


@dataclass(frozen=True, eq=False)
class Pressure(Load):
    """Pressure on one side of a shell, which follows its current normal as it turns.

    Where the shell is closed or its edges are held, such a pressure has a potential; whether it has is seen by its
    tangent.

    Attributes
    ----------
    pressure : pushes where it is positive, pulls where it is negative; also a function from the place before anything
        moves (UFL vector), such as lambda x: 9.81e-6 * (height - x[2]), whose largest value is reported as the load
    side : that it acts on: "negative", from which it pushes along the normal, or "positive", to which the normal
        points, against it. The normal is that of the part's cells as they run (`mesh.orientation`), "normal" in files
        for ParaView
    """

    shell: Shell
    pressure: float | Callable
    side: Annotated[str, Choice(SIDES)] = SIDES[0]
    conservative = False
    reports = PRESSURE

    def __post_init__(self):
        check(self)
        self.shell.mesh.require_alike("Pressure", self.shell.group)

    def work(self, fields):
        frame, u = self.shell.frame(), fields.displacement(self.shell.mesh)
        return forms.load.pressure(fields.factor * _along(self), u, frame, fields.vary) * self._measure()

    def _measure(self):
        """Exact for a product of two tangents of the surface and a variation: otherwise it has a potential nowhere."""
        shell, own = self.shell, self.shell.discrete.displacement[1]
        return shell.mesh.integral({"quadrature_degree": 2 * max(own, shell.mesh.degree) - 1 + own}, shell.group)

    def total(self, fields) -> float:
        return _largest(self.pressure, self.shell)


@dataclass(frozen=True, eq=False)
class LinePressure(Load):
    """Pressure on one side of a beam in the plane: force per current length along its current normal.

    As a `Pressure`'s, its tangent shows whether it has a potential: it has on closed rings and between ends that
    are held. A `LineForce(follower=True)` differs: its size is per reference length, it turns with the cross-section,
    and no supports give it a potential.

    Attributes
    ----------
    pressure : pushes where it is positive, pulls where it is negative; also a function of the place, as of a `Pressure`
    side : that it acts on: "negative", from which it pushes along the normal, or "positive", to which the normal
        points, against it. The normal is on the left of the direction in which the mesh runs along the beam
    """

    beam: Beam
    pressure: float | Callable
    side: Annotated[str, Choice(SIDES)] = SIDES[0]
    conservative = False
    reports = LINE_PRESSURE

    def __post_init__(self):
        check(self)
        if self.beam.mesh.dimension != 2:
            raise ValueError("LinePressure: the mesh is in space, where a curve has no one normal; use a LineForce")
        self.beam.mesh.require_alike("LinePressure", self.beam.group)

    def work(self, fields):
        frame, u = self.beam.frame(), fields.displacement(self.beam.mesh)
        return forms.load.line_pressure(fields.factor * _along(self), u, frame, fields.vary) * self.beam.measure()

    def total(self, fields) -> float:
        return _largest(self.pressure, self.beam)


def _along(load: Pressure | LinePressure):
    """Pressure along the normal, a number or in UFL."""
    mesh = load.shell.mesh if isinstance(load, Pressure) else load.beam.mesh
    size = load.pressure(ufl.SpatialCoordinate(mesh.domain)) if callable(load.pressure) else load.pressure
    return size if load.side == SIDES[0] else -size


def _largest(pressure: float | Callable, part: Shell | Beam) -> float:
    """Size of a pressure; of a function the largest at the nodes of the geometry of its cells."""
    if not callable(pressure):
        return abs(pressure)
    domain = part.mesh.domain
    points = basix.ufl.element("P", domain.basix_cell().name, part.mesh.degree).basix_element.points
    value = pressure(ufl.SpatialCoordinate(domain)) + fem.Constant(domain, 0.0)  # numbers alone are on no mesh
    found = compiled_expression(value, points).eval(domain, part.mesh.group(part.group))
    return part.mesh.comm.allreduce(float(np.abs(found).max(initial=0.0)), op=MPI.MAX)
