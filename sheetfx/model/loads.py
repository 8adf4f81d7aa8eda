"""Loads on a structure: data that owns its weak form, checked when made."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import ufl
from dolfinx import fem

from .. import forms
from ..checks import check, require_components, require_known_component
from ..jit import compiled_form
from ..mesh.numbers import lift_numbers
from ..mesh.reader import COMPONENTS, NamedMesh
from .beam import Bar, Beam
from .obstacles import Obstacle
from .shell import Shell
from .work import Acting

FORCE, MOMENT, PRESSURE, LINE_PRESSURE = "force", "moment", "pressure", "line pressure"


class Load(Acting):
    """What grows with the load factor; a load of one's own derives from it and defines `work`.

    `work` is the virtual work of the load *on* the structure at the load factor `fields.factor`.

    Attributes
    ----------
    reports : what `total` gives, "force", "moment", "pressure" or "line pressure": forces and moments of several loads,
        and of all equal parts of a structure, are added up, pressures are not
    """

    reports = FORCE

    def at_points(self, forces) -> None:
        """Put forces and moments at points into `forces` (`discrete.fields.NodalForces`), for a load factor of 1."""

    def total(self, fields) -> float | Callable[[], float]:
        """The reported load: its size for a load factor of 1, or a function that gives it now (a reaction).

        A load that does not define it reports the load factor.
        """
        return 1.0


@dataclass(frozen=True)
class PointForce(Load):
    """Force of fixed direction at each vertex of a named point, for a load factor of 1."""

    mesh: NamedMesh
    at: str
    force: tuple[float, ...]

    def __post_init__(self):
        check(self)
        self.mesh.require(f"{type(self).__name__} at {self.at!r}", self.at, "point", "edge")
        require_components(f"PointForce at {self.at!r}: force", self.force, self.mesh.dimension)

    def at_points(self, forces) -> None:
        for component, value in zip(COMPONENTS[self.mesh.dimension], self.force, strict=False):
            forces.add(self.mesh, self.at, component, value)

    def total(self, fields) -> float:
        return float(np.linalg.norm(self.force)) * self.mesh.count(self.at)


@dataclass(frozen=True)
class Moment(Load):
    """Moment at a named point or per length of a named edge, conjugate to the spin.

    One number in the plane, three in space; along an edge also a function from the place (UFL vector) to these.
    """

    mesh: NamedMesh
    at: str
    moment: float | tuple[float, float, float] | Callable
    reports = MOMENT

    def __post_init__(self):
        check(self)
        self.mesh.require(f"Moment at {self.at!r}", self.at, "point", "edge")
        if callable(self.moment):
            _require_along("Moment", self.mesh, self.at)
        else:
            require_components(f"Moment at {self.at!r}: moment", np.ravel(self.moment), 2 * self.mesh.dimension - 3)

    @property
    def conservative(self) -> bool:  # type: ignore[override]
        """In space the work of a fixed moment depends on the way of turning (Ziegler 1968)."""
        return self.mesh.dimension == 2

    @property
    def _pointed(self) -> bool:
        return self.at in self.mesh.points

    def at_points(self, forces) -> None:
        if self._pointed:
            for component, value in zip(COMPONENTS[self.mesh.dimension][self.mesh.dimension:],
                                        np.atleast_1d(self.moment), strict=True):
                forces.add(self.mesh, self.at, component, value)

    def work(self, fields):
        if self._pointed:
            return None
        moment = fields.factor * forms.vector(_components(self.moment, self.mesh))
        return forms.load.spin_moment(moment, fields.vary(fields.spin(self.mesh))) * self.mesh.facet_measure(self.at)

    def total(self, fields) -> float:
        if self._pointed:
            return float(np.linalg.norm(self.moment)) * self.mesh.count(self.at)
        return _size(self.moment, self.mesh, self.mesh.facet_measure(self.at))


@dataclass(frozen=True, eq=False)
class LineForce(Load):
    """Force per reference length on a beam or on bars; `follower`: components on the turning frame.

    The force is given by numbers, or by a function from the place (UFL vector) to components.

    In space the tangent of a follower force takes rotations between nodes to the first order, which costs
    an iteration, not accuracy.
    """

    beam: Beam | Bar
    force: tuple[float, ...] | Callable
    follower: bool = False

    def __post_init__(self):
        check(self)
        if not callable(self.force):
            require_components("LineForce: force", self.force, self.beam.mesh.dimension)
        if self.follower and isinstance(self.beam, Bar):
            raise ValueError("LineForce: follower is True, but bars have no cross-section that turns; make it False")
        if self.follower and (callable(self.force) or np.any(self.force[::2]) or self.beam.mesh.dimension == 2):
            self.beam.mesh.require_alike("LineForce: follower is True", self.beam.group)

    @property
    def conservative(self) -> bool:  # type: ignore[override]
        return not self.follower

    def work(self, fields):
        mesh = self.beam.mesh
        force = [fields.factor * c for c in _components(self.force, mesh)]
        u = fields.displacement(mesh)
        if self.follower:
            density = forms.load.follower_force(force, self.beam.frame(), fields.rotation(mesh), u, fields.vary)
        else:
            density = forms.load.dead_force(forms.vector(force), u, fields.vary)
        return density * self.beam.measure()

    def total(self, fields) -> float:
        return _size(self.force, self.beam.mesh, self.beam.measure())


def _require_along(title: str, mesh: NamedMesh, at: str) -> None:
    """Refuse a function of the place for a load at a named point."""
    if at in mesh.points:
        raise ValueError(f"{title} at {at!r}: is a function of the place, but acts at a point; give numbers there")


def _components(force: float | Sequence[float] | Callable, mesh: NamedMesh) -> Any:
    """Numbers, or UFL expressions of the place."""
    return force(ufl.SpatialCoordinate(mesh.domain)) if callable(force) else force


def _size(force: float | Sequence[float] | Callable, mesh: NamedMesh, measure) -> float:
    """Integral of the size of a force or moment by length or area."""
    domain, components = mesh.domain, _components(force, mesh)
    if callable(force):
        vector = forms.vector(components)
        size = ufl.sqrt(ufl.dot(vector, vector)) if vector.ufl_shape else abs(vector)
    else:
        size = fem.Constant(domain, float(np.linalg.norm(components)))
    return mesh.comm.allreduce(fem.assemble_scalar(compiled_form(lift_numbers(size * measure, domain))))


@dataclass(frozen=True)
class EdgeForce(Load):
    """Force of fixed direction per reference length of a named edge of shells.

    The force is given by numbers, or by a function from the place (UFL vector) to components.
    """

    mesh: NamedMesh
    at: str
    force: tuple[float, float, float] | Callable

    def __post_init__(self):
        check(self)
        self.mesh.require(f"EdgeForce at {self.at!r}", self.at, "edge")
        if not callable(self.force):
            require_components(f"EdgeForce at {self.at!r}: force", self.force, self.mesh.dimension)

    def work(self, fields):
        force, u = fields.factor * forms.vector(_components(self.force, self.mesh)), fields.displacement(self.mesh)
        return forms.load.dead_force(force, u, fields.vary) * self.mesh.facet_measure(self.at)

    def total(self, fields) -> float:
        return _size(self.force, self.mesh, self.mesh.facet_measure(self.at))


@dataclass(frozen=True, eq=False)
class SurfaceForce(Load):
    """Force of fixed direction per reference area of a shell.

    The force is given by numbers, or by a function from the place (UFL vector) to components.
    """

    shell: Shell
    force: tuple[float, float, float] | Callable

    def __post_init__(self):
        check(self)
        if not callable(self.force):
            require_components("SurfaceForce: force", self.force, self.shell.mesh.dimension)

    def work(self, fields):
        mesh = self.shell.mesh
        force = fields.factor * forms.vector(_components(self.force, mesh))
        return forms.load.dead_force(force, fields.displacement(mesh), fields.vary) * self.shell.measure()

    def total(self, fields) -> float:
        return _size(self.force, self.shell.mesh, self.shell.measure())


@dataclass(frozen=True, eq=False)
class ObstacleForce(Load):
    """Force on an obstacle along its travel."""

    obstacle: Obstacle
    force: float

    def __post_init__(self):
        check(self)
        if self.obstacle.travel is None:
            raise ValueError("ObstacleForce: its obstacle has travel None and cannot move; give it a direction")

    def at_points(self, forces) -> None:
        forces.add_to_own(self.obstacle, "travel", self.force)

    def total(self, fields) -> float:
        return abs(self.force)


@dataclass(frozen=True)
class PrescribedDisplacement(Load):
    """Prescribed displacement component of a named point, or of all of a named edge; its reaction is an unknown.

    The reported load is the reaction along the motion: a structure that resists has a positive one either way.

    Nodes of the edge where a support fixes the component stay there. Edges that move alike may have corners in common.
    """

    mesh: NamedMesh
    at: str
    component: str
    distance: float

    def __post_init__(self):
        check(self)
        self.mesh.require(f"{type(self).__name__} at {self.at!r}", self.at, "point", "edge")
        require_known_component(f"PrescribedDisplacement of {self.at!r}", self.component,
                                COMPONENTS[self.mesh.dimension][:self.mesh.dimension])

    def unknowns(self, fields) -> None:
        held = [s.at for s in fields.scene.supports
                if s.mesh is self.mesh and s.axes is None and self.component in s.fixed.split()]
        for load in fields.scene.all_loads:
            if load is self:
                break
            if isinstance(load, PrescribedDisplacement) and load.mesh is self.mesh and load.component == self.component:
                held.append(load.at)
        fields.add_multiplier(self, self.mesh, "reaction", self.at, held)

    def work(self, fields):
        """The reaction r holds the displacement at its value: the variation of r (factor distance - u)."""
        index = COMPONENTS[self.mesh.dimension].index(self.component)
        error = fields.factor * self.distance - fields.displacement(self.mesh)[index]
        return fields.vary(fields.own(self, "reaction") * error) * self.mesh.facet_measure(self.at)

    def total(self, fields) -> Callable[[], float]:
        """The reaction along the motion, as PrescribedRotation has its moment."""
        way = float(np.copysign(1.0, self.distance))
        reaction = way * fields.own(self, "reaction") * self.mesh.facet_measure(self.at)
        form, comm = compiled_form(-reaction), self.mesh.comm
        return lambda: comm.allreduce(fem.assemble_scalar(form))


@dataclass(frozen=True)
class PrescribedRotation(Load):
    """Prescribed rotation of a named point; the moment that it takes is an unknown.

    In the plane an angle in radians, of any size. In space a vector, angle times axis: all of the rotation is
    prescribed, and the point turns about the axis as the load factor grows. A support may hold the other components.
    """

    mesh: NamedMesh
    at: str
    rotation: float | tuple[float, float, float]
    reports = MOMENT

    def __post_init__(self):
        check(self)
        self.mesh.require(f"{type(self).__name__} at {self.at!r}", self.at, "point", "edge")
        require_components(f"PrescribedRotation at {self.at!r}: rotation", np.ravel(self.rotation),
                           2 * self.mesh.dimension - 3)

    def unknowns(self, fields) -> None:
        nodes, width = fields.nodes(self.mesh, self.at, "rotation"), len(np.ravel(self.rotation))
        origins = fields.origins(self.mesh, nodes, "rotation")
        fields.add_numbers(self, self.mesh, "moment", origins, width, without=np.flatnonzero(self._held(fields, nodes)))

    def _held(self, fields, nodes: np.ndarray) -> np.ndarray:
        """Whether a support holds each component of the rotation of each node.

        Raises
        ------
        ValueError
            Where it is to turn.
        """
        held = np.zeros((len(nodes), len(np.ravel(self.rotation))), dtype=bool)
        names = COMPONENTS[self.mesh.dimension][self.mesh.dimension:]
        for support in (s for s in fields.scene.supports if s.mesh is self.mesh and s.axes is None):
            there = np.isin(nodes, fields.nodes(self.mesh, support.at, "rotation"))
            for index, (name, angle) in enumerate(zip(names, np.ravel(self.rotation), strict=True)):
                if name not in support.fixed.split():
                    continue
                if angle and self.mesh.comm.allreduce(int(there.sum())):
                    raise ValueError(f"PrescribedRotation at {self.at!r}: the support at {support.at!r} holds {name}, "
                                     f"and {angle} is prescribed; take it from the one or the other")
                held[there, index] = True
        return held

    def contributions(self, fields):
        nodes, width = fields.nodes(self.mesh, self.at, "rotation"), len(np.ravel(self.rotation))
        moments = [fields.own_trace(self, "moment", np.arange(len(nodes)) * width + i) for i in range(width)]

        def strains(values, data, factor):
            turn = forms.interface.turn_from_prescribed(values[0], factor, np.ravel(self.rotation))
            return forms.interface.with_multipliers(turn, values[1:])

        traces = [fields.trace(self.mesh, nodes, "rotation"), *moments]
        yield fields.point_work(traces, strains, forms.interface.tied, stage=fields.stage)

    def total(self, fields) -> Callable[[], float]:
        """The moment along the rotation."""
        field, comm = fields.own_field(self, "moment"), self.mesh.comm
        axis = np.ravel(self.rotation) / (np.linalg.norm(self.rotation) or 1.0)
        return lambda: -comm.allreduce(float((field.value.array.reshape(-1, len(axis)) @ axis).sum()))
