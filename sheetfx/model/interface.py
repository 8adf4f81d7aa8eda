"""Interfaces: where parts are welded, bolted, hinged or linked, at points or along lines; meshes need not match.

One law stands for all: a gap between two parts as a function of their traces, and what holds it shut.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Annotated

import numpy as np

from .. import forms
from ..checks import NONZERO, Choice, NotNegative, check, checked, require_known_component
from ..mesh.discs import Disc
from ..mesh.lines import Stretch
from ..mesh.meeting import Meeting, along_lines
from ..mesh.reader import COMPONENTS, NamedMesh
from .beam import Bar, Beam
from .joints import Joint
from .places import Place, each_of, meeting_of, require_places, title_of
from .shell import Shell

STIFF = 1e3  # of a penalty, times the stiffness of the softer part (Herrema et al. 2019, section 4)


@dataclass(frozen=True, eq=False)
class Interface(Joint):
    """Joint of two parts at a point or along a line, where their cells need not match.

    A rigid arm goes from each point of the first part to the closest one of the second, and turns with the first. The
    gap is how far the second part is off the end of the arm, and how it is turned against the first, on axes that turn
    with the first part. A law says which of its components are held, or what forces they make.

    Along lines components are held in the mean, by multipliers that are linear and continuous on the cells of the part
    that has the larger ones (a mortar method; Hueeber, Mair and Wohlmuth 2005).

    Attributes
    ----------
    mesh : of the first part
    at : where on it: a named point, edge of surfaces or group of curves, a Stretch, a Disc over which components are
        held in the mean, or several of one of these
    to : mesh of the second part, and the name of a point, an edge or a group of cells of it; None: anywhere on it
    law : components that are held, any of x y z rx ry rz separated by spaces; or a function from the vector of all
        components of the gap to forces and moments (per length of a line), both in UFL, see
        `forms.interface.stiff`
    gap : function from traces of both parts, lists of displacement and rotation, and the arm to a list of components;
        None: `forms.interface.gap_of_arm`, or `gap_in_space` where all displacements are held
    reach : distance of the parts that arms may bridge; any for a named point joined to another one
    enforcement : of components that are held: "multiplier", exact, or "penalty", of a thousand times the stiffness of
        the softer part
    axes : directions, one in each row, that x y z and rx ry rz stand for, or "normal": z is the normal of the surface
        there; None: the axes of space
    name : what messages call it
    """

    mesh: NamedMesh
    at: Place
    to: tuple[NamedMesh, str | None]
    law: str | Callable
    gap: Callable | None = None
    reach: NotNegative = 0.0
    enforcement: Annotated[str, Choice(("multiplier", "penalty"))] = "multiplier"
    axes: Sequence[Sequence[float]] | str | None = None
    name: str = field(default="Interface", kw_only=True)
    on_ground = False

    def __post_init__(self):
        check(self)
        require_places(self.name, self.mesh, each_of(self.at))
        if self.to == (self.mesh, self.at):
            raise ValueError(f"{self._title}: ties the point to itself; name another point in `to`")
        if self.to[0].dimension != self.mesh.dimension:
            raise ValueError(f"{self._title}: joins a mesh in {self.mesh.dimension} with one in "
                             f"{self.to[0].dimension} dimensions; read both with the same")
        for name in self.held:
            require_known_component(self._title, name, COMPONENTS[self.mesh.dimension])
        if not self.held and isinstance(self.law, str):
            raise ValueError(f"{self._title}: holds no component; give some of "
                             f"{' '.join(COMPONENTS[self.mesh.dimension])}")
        self._check_axes()
        _ = self.meeting

    @property
    def _title(self) -> str:
        return title_of(self.name, self._places[0])

    @property
    def held(self) -> list[str]:
        """Names of the components that are held."""
        return self.law.split() if isinstance(self.law, str) else []

    @property
    def _places(self) -> list[str | Stretch | Disc]:
        return each_of(self.at)

    @property
    def _at_point(self) -> bool:
        return any(isinstance(at, Disc) or (isinstance(at, str) and at in self.mesh.points) for at in self._places)

    @property
    def points_of_shells(self) -> list[str]:
        """Named points at which it joins a shell, whose response to a force at a point has no limit."""
        shells = any(m.domain.topology.dim == 2 for m in (self.mesh, self.to[0]))
        return [at for at in self._places if shells and isinstance(at, str) and at in self.mesh.points]

    @property
    def points(self) -> Sequence[tuple[NamedMesh, str | None]]:
        return [(mesh, at if isinstance(at, str) and (at in mesh.points or at in mesh.edges) else None)
                for mesh, at in (*((self.mesh, at) for at in self._places), self.to)]

    def _check_axes(self) -> None:
        if self.axes is None:
            return
        if self.mesh.dimension != 3:
            raise ValueError(f"{self._title}: axes are for structures in space")
        if isinstance(self.axes, str):
            if self.axes != "normal" or max(m.domain.topology.dim for m in (self.mesh, self.to[0])) < 2:
                raise ValueError(f"{self._title}: axes are {self.axes!r}; give three directions, or 'normal' where a "
                                 "part is a surface")
        elif np.shape(self.axes) != (3, 3) or not np.allclose(np.dot(self.axes, np.transpose(self.axes)), np.eye(3)):
            raise ValueError(f"{self._title}: axes must be three orthonormal directions")

    @cached_property
    def meeting(self) -> Meeting:
        """Points where the parts meet."""
        return meeting_of(self.mesh, self._places, self.to, self.reach, self.name,
                          lambda first, second, lines, title: along_lines(first, second, lines, self.reach, 4, title,
                                                                          tied=True))

    def unknowns(self, fields) -> None:
        if self.held and self.enforcement == "multiplier":
            fields.add_numbers(self, self.mesh, "tie", self.meeting.origins, len(self.held), whole=True)

    def contributions(self, fields):
        meeting, names = self.meeting, self.held
        meshes = self.mesh, self.to[0]
        sides = [[fields.trace_in(mesh, side.cells, side.reference, quantity) for quantity in (
            ["displacement"] if fields.spin(mesh) is None else ["displacement", "rotation"])]
            for mesh, side in zip(meshes, meeting.sides, strict=True)]
        arms = meeting.sides[1].places - meeting.sides[0].places
        self._check(sides, arms)
        split, last = len(sides[0]), len(sides[0]) + len(sides[1])
        chosen = [COMPONENTS[self.mesh.dimension].index(name) for name in names]
        whole = set(range(self.mesh.dimension)) <= set(chosen)
        gap = self.gap or (forms.interface.gap_in_space if whole else forms.interface.gap_of_arm)
        data, held = [arms], self.held and self.enforcement == "multiplier"
        if self.axes is not None:
            data.append(self._directions())
        multipliers = [fields.own_trace(self, "tie", meeting.nodes * len(names) + i, meeting.hats)
                       for i in range(len(names))] if held else []

        def gaps(values, data):
            components = gap(values[:split], values[split:last], data[0])
            return components if self.axes is None else forms.interface.on_axes(components, data[1])

        def strains(values, data, factor):
            components = gaps(values, data)
            if names:
                components = [components[i] for i in chosen]
            return forms.interface.with_multipliers(components, values[last:])

        law = self.law if not names else forms.interface.tied
        if names and not held:
            law = forms.interface.stiff(np.diag(self._penalties(fields, chosen)))
        yield fields.point_work([*sides[0], *sides[1], *multipliers], strains, law, data, weights=meeting.weights)

    def _directions(self) -> np.ndarray:
        """Axes at the points, one direction behind the other, shape (n, 9), which change continuously along lines."""
        count = len(self.meeting.weights)
        if not isinstance(self.axes, str):
            return np.tile(np.ravel(self.axes), (count, 1))
        normals = next(s.normals for s in reversed(self.meeting.sides) if s.normals is not None)
        along = np.sign((normals[1:] * normals[:-1]).sum(axis=1))
        normals = normals * np.concatenate(([1.0], np.cumprod(along)))[:count, None]
        across = np.eye(3)[np.abs(normals).max(axis=0, initial=0.0).argmin()]
        first = np.cross(across, normals)
        first /= np.linalg.norm(first, axis=1, keepdims=True)
        return np.concatenate([first, np.cross(normals, first), normals], axis=1)

    def _check(self, sides, arms) -> None:
        turning = any(name.startswith("r") for name in self.held)
        if turning and min(map(len, sides)) < 2:
            raise ValueError(f"{self._title}: ties rotations, but bars have none; tie displacements only")
        if len(sides[0]) < 2 and np.abs(arms).max(initial=0.0) > 1e-9 * self.mesh.size:
            raise ValueError(f"{self._title}: the points are {np.abs(arms).max():.4g} apart, but the first one is "
                             "on bars, which cannot turn an arm; give the part with rotations first")

    def _penalties(self, fields, chosen: Sequence[int]) -> list[float]:
        """Stiffness against each component of the gap, per length of a line."""
        size = self.meeting.size
        both = [[stiffness_over(part, size) for part in fields.scene.parts if part.mesh is mesh]
                for mesh in (self.mesh, self.to[0])]
        soft = np.min([np.max(parts, axis=0) for parts in both], axis=0)
        length = size if self._at_point else 1.0
        return [STIFF * length * soft[int(i >= self.mesh.dimension)] for i in chosen]


def stiffness_over(part: Shell | Beam | Bar, size: float) -> tuple[float, float]:
    """Force per length and displacement of a part over the size of a cell, and moment per length and rotation."""
    if isinstance(part, Shell):
        plate = part.sections.typical.stiffness(part.material)  # type: ignore[arg-type]
        return plate.membrane[0][0] / size, plate.bending[0][0] / size
    section, modulus = part.sections.typical, part.material.modulus
    return modulus * section.area / size**2, modulus * min(section.second_moments) / size**2


@checked
def weld(mesh: NamedMesh, at: Place, to: tuple[NamedMesh, str | None], **how) -> Interface:
    """Two parts that move and turn together; where they stand apart, rigid links turn with the first (see `link`).

    `how` are further attributes of an Interface: reach, enforcement.
    """
    return Interface(mesh, at, to, " ".join(COMPONENTS[mesh.dimension]), **{"name": "weld"} | how)


@checked
def link(mesh: NamedMesh, at: Place, to: tuple[NamedMesh, str | None], reach: NotNegative, **how) -> Interface:
    """Rigid links to a part that stands up to `reach` off the first, and turn with the first: an eccentric weld.

    Along a line on a surface the turn about its normal is free. A plate has no stiffness against it on a line: what a
    mesh has depends on its size, and held the bar by it, at an arm, with up to four times the stiffness of the limit.
    """
    on_surface = any(m.domain.topology.dim == 2 for m in (mesh, to[0])) and not (
        isinstance(at, str) and at in mesh.points)
    maker = bolt if on_surface else weld
    return maker(mesh, at, to, reach=reach, **{"name": "link"} | how)


@checked
def hinge(mesh: NamedMesh, at: Place, to: tuple[NamedMesh, str | None], **how) -> Interface:
    """Two parts that move together and turn freely."""
    held = COMPONENTS[mesh.dimension][:mesh.dimension]
    return Interface(mesh, at, to, " ".join(held), **{"name": "hinge"} | how)


@checked
def bolt(mesh: NamedMesh, at: Place, to: tuple[NamedMesh, str | None],
         axis: Annotated[tuple[float, float, float], NONZERO] | None = None, **how) -> Interface:
    """Two parts that move together and turn freely about one axis, which turns with the first.

    Parameters
    ----------
    axis : direction of the bolt; None: the normal of the surface that is joined, or joins
    """
    if axis is None:
        return Interface(mesh, at, to, "x y z rx ry", axes="normal", **{"name": "bolt"} | how)
    columns = np.linalg.qr(np.column_stack((axis, np.eye(3)[np.argsort(np.abs(axis))[:2]].T)))[0]
    axes = np.array([columns[:, 1], columns[:, 2], np.cross(columns[:, 1], columns[:, 2])])
    return Interface(mesh, at, to, "x y z rx ry", axes=axes, **{"name": "bolt"} | how)
