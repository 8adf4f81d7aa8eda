"""Joints: what connects parts with each other or with the ground, written as work at points or along parts."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import ufl

from .. import forms
from ..checks import check, require_components, require_known_component
from ..mesh.reader import COMPONENTS, NamedMesh
from ..notices import warn
from .beam import Bar, Beam
from .shell import Shell
from .work import Acting


class Joint(Acting):
    """What connects parts; a joint of one's own derives from it and defines `work` or `contributions`.

    `work` is the virtual work that the joint does *against* a motion, as strains of parts do.

    Attributes
    ----------
    on_ground : whether it holds the structure, or may; a structure that neither this nor a support holds is free
    """

    on_ground = True

    @property
    def points(self) -> Sequence[tuple[NamedMesh, str | None]]:
        """Named points that it connects; meshes that no joint connects are told when the scene is made.

        None in the place of a name stands for the whole mesh.
        """
        return ()

    def shared(self, fields) -> Sequence:
        """Nodes that have no unknowns of their own, but share other nodes' (`discrete.sharing.Sharing`)."""
        return ()


@dataclass(frozen=True)
class End:
    """A named point of a mesh."""

    mesh: NamedMesh
    at: str

    def nodes(self, fields) -> np.ndarray:
        """Its nodes that this process owns."""
        return fields.nodes(self.mesh, self.at)

    def trace(self, fields, places: np.ndarray, quantity: str):
        """One quantity at its nodes, in the order of given places."""
        return fields.trace(self.mesh, fields.matching(self.mesh, self.at, places, quantity), quantity)


@dataclass(frozen=True, eq=False)
class Spring(Joint):
    """Spring from a named point to the ground, or to another point.

    Attributes
    ----------
    mesh, at : the point; at each node of an edge there is a spring, see `EdgeFoundation` for one per length
    component : x, y or z, or rx, ry or rz for a spring against rotation (in space against that component of the
        rotation vector of the second point from the first, on axes that turn with the first)
    stiffness : force per length, or moment per radian
    to : mesh and name of the other point; None: the ground
    law : function from extension and stiffness to the force, both UFL scalars; None: their product
    """

    mesh: NamedMesh
    at: str
    component: str
    stiffness: float
    to: tuple[NamedMesh, str] | None = None
    law: Callable = forms.interface.linear_spring

    def __post_init__(self):
        check(self)
        known = COMPONENTS[self.mesh.dimension]
        require_known_component(f"Spring at {self.at!r}", self.component, known)
        for end in self._ends:
            end.mesh.require(f"Spring at {end.at!r}", end.at, "point", "edge")
        if self.to == (self.mesh, self.at):
            raise ValueError(f"Spring at {self.at!r}: joins the point to itself; name another point in `to`")
        if self.at in self.mesh.edges:
            warn(f"Spring at {self.at!r}: is one at each node of the edge, so that its stiffness in all depends on the "
                 "mesh; give one per length by an EdgeFoundation")

    @property
    def _ends(self) -> list[End]:
        return [End(self.mesh, self.at), *([End(*self.to)] if self.to else [])]

    @property
    def on_ground(self) -> bool:  # type: ignore[override]
        return self.to is None

    @property
    def points(self) -> Sequence[tuple[NamedMesh, str]]:
        return [(end.mesh, end.at) for end in self._ends]

    def contributions(self, fields):
        index, dimension = COMPONENTS[self.mesh.dimension].index(self.component), self.mesh.dimension
        quantity = "displacement" if index < dimension else "rotation"
        places = fields.places(self.mesh, self._ends[0].nodes(fields))
        traces = [end.trace(fields, places, quantity) for end in self._ends]

        def extension(values, data, factor):
            if quantity == "displacement":
                return ufl.as_vector([forms.interface.extension(values)[index]])
            return ufl.as_vector([forms.interface.rotation_between(values)[index - dimension]])

        yield fields.point_work(traces, extension, lambda e: ufl.as_vector([self.law(e[0], self.stiffness)]))


@dataclass(frozen=True, eq=False)
class Foundation(Joint):
    """Elastic foundation along beams or bars, or under shells (Winkler 1867).

    Attributes
    ----------
    part : what rests on it
    stiffness : for each direction of space a force per length (per area of shells) and displacement
    law : function from displacement and stiffness along a direction to the pressure, UFL scalars; None: their product
    """

    part: Beam | Bar | Shell
    stiffness: tuple[float, ...]
    law: Callable = forms.interface.linear_spring

    def __post_init__(self):
        check(self)
        require_components("Foundation: stiffness", self.stiffness, self.part.mesh.dimension)

    def work(self, fields):
        u = fields.displacement(self.part.mesh)
        along = [(component, k) for component, k in enumerate(self.stiffness) if k]
        return sum(self.law(u[i], k) * fields.vary(u[i]) for i, k in along) * self.part.measure()


@dataclass(frozen=True, eq=False)
class EdgeFoundation(Joint):
    """Springs per length along a named edge of shells, whatever its cells; an `fx.Spring` there is one at each node.

    Attributes
    ----------
    mesh, at : the edge
    stiffness : for each direction of space a force per length and displacement
    law : function from displacement and stiffness along a direction to the force per length, UFL scalars
    """

    mesh: NamedMesh
    at: str
    stiffness: tuple[float, ...]
    law: Callable = forms.interface.linear_spring

    def __post_init__(self):
        check(self)
        self.mesh.require(f"EdgeFoundation at {self.at!r}", self.at, "edge")
        require_components(f"EdgeFoundation at {self.at!r}: stiffness", self.stiffness, self.mesh.dimension)
        if not any(self.stiffness):
            raise ValueError(f"EdgeFoundation at {self.at!r}: stiffness is zero along all directions; leave it out")

    def work(self, fields):
        u = fields.displacement(self.mesh)
        along = [(component, k) for component, k in enumerate(self.stiffness) if k]
        return sum(self.law(u[i], k) * fields.vary(u[i]) for i, k in along) * self.mesh.facet_measure(self.at)


@dataclass(frozen=True, eq=False)
class Uniform(Joint):
    """All nodes of an edge or point move alike along one direction, by a free amount.

    Attributes
    ----------
    mesh, at : the edge
    component : x, y or z
    """

    mesh: NamedMesh
    at: str
    component: str
    on_ground = False

    def __post_init__(self):
        check(self)
        self.mesh.require(f"Uniform at {self.at!r}", self.at, "point", "edge")
        require_known_component(f"Uniform at {self.at!r}", self.component,
                                COMPONENTS[self.mesh.dimension][:self.mesh.dimension])

    def unknowns(self, fields) -> None:
        fields.add_number(self, self.mesh, "motion", self.mesh.size)
        fields.add_numbers(self, self.mesh, "tie", fields.origins(self.mesh, fields.nodes(self.mesh, self.at)), 1)

    def contributions(self, fields):
        nodes, index = fields.nodes(self.mesh, self.at), COMPONENTS[self.mesh.dimension].index(self.component)
        for support in fields.scene.supports:
            if support.mesh is self.mesh and support.axes is None and self.component in support.fixed.split() and (
                    set(fields.nodes(self.mesh, support.at, ghosts=True)) & set(nodes)):
                raise ValueError(f"Uniform at {self.at!r}: the support at {support.at!r} holds component "
                                 f"{self.component} of a node of it; free one of the two")
        first = np.zeros(len(nodes), dtype=np.int64)
        traces = [fields.trace(self.mesh, nodes), fields.own_trace(self, "motion", first),
                  fields.own_trace(self, "tie", np.arange(len(nodes)))]

        def strains(values, data, factor):
            u, motion, multiplier = values
            return forms.interface.with_multipliers([u[index] - motion[0]], [multiplier])

        yield fields.point_work(traces, strains, forms.interface.tied)


@dataclass(frozen=True, eq=False)
class Compatible(Joint):
    """Full compatibility: nodes of a mesh that stand at nodes of another one have the same unknowns as these.

    The shared unknowns are eliminated, no equation is added. Nodes without a partner keep their own: triangles of
    which rotations live at the middles of edges share them with the middle nodes of beams of degree 2.

    Attributes
    ----------
    mesh, to : the two meshes, such as bars and the panels whose edges they run along
    at : group of cells, edge or point of `mesh` where nodes are shared; None: wherever they stand at one place
    rotations : whether rotations are shared too; otherwise displacements are, as at a hinge
    """

    mesh: NamedMesh
    to: NamedMesh
    at: str | None = None
    rotations: bool = True
    on_ground = False

    def __post_init__(self):
        check(self)
        if self.mesh is self.to:
            raise ValueError("Compatible: joins a mesh to itself; name another one in `to`")
        if self.at is not None:
            self.mesh.require(f"Compatible at {self.at!r}", self.at, "point", "edge", "group of cells")
        if self.to.dimension != self.mesh.dimension:
            raise ValueError(f"Compatible: joins a mesh in {self.mesh.dimension} with one in {self.to.dimension} "
                             "dimensions; read both with the same")

    @property
    def points(self) -> Sequence[tuple[NamedMesh, str | None]]:
        return [(self.mesh, None), (self.to, None)]

    def shared(self, fields) -> Sequence:
        quantities = ("displacement", "rotation") if self.rotations else ("displacement",)
        return fields.sharings(self.mesh, self.to, self.at, quantities)
