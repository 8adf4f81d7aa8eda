"""Couplings of many nodes with one reference point: as a rigid body, or by their mean motion."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from .. import forms
from ..checks import check, require_known
from ..mesh.lines import SAME, places_of
from ..mesh.projection import Cells, cells_at
from ..mesh.reader import COMPONENTS, NamedMesh
from ..mesh.whole import whole
from .joints import Joint


@dataclass(frozen=True, eq=False)
class _Coupling(Joint):
    """Nodes and their reference point.

    Attributes
    ----------
    mesh, at : the reference: a named point of a beam or shell, which has a rotation
    to : mesh, and the name of the edge or points whose nodes are coupled with it, however far they are
    name : what messages call it
    """

    mesh: NamedMesh
    at: str
    to: tuple[NamedMesh, str]
    name: str = field(default="coupling", kw_only=True)
    on_ground = False

    def __post_init__(self):
        check(self)
        title = f"{type(self).__name__} at {self.at!r}"
        self.mesh.require(title, self.at, "point")
        if self.mesh.count(self.at) != 1:
            raise ValueError(f"{title}: has {self.mesh.count(self.at)} vertices; name a single point as the reference")
        self.to[0].require(title, self.to[1], "edge", "point")
        if self.to[0].dimension != self.mesh.dimension:
            raise ValueError(f"{title}: joins a mesh in {self.mesh.dimension} with one in {self.to[0].dimension} "
                             "dimensions; read both with the same")

    @property
    def points(self) -> Sequence[tuple[NamedMesh, str | None]]:
        return [(self.mesh, self.at), self.to]

    def _reference(self, fields, count: int) -> list:
        """Displacement and rotation of the reference, once for each node, and its place."""
        if fields.spin(self.mesh) is None:
            raise ValueError(f"{type(self).__name__} at {self.at!r}: the reference is on bars, which do not turn; take "
                             "a point of a beam or shell")
        return self._traces(fields, self.mesh, np.repeat(self._place, count, axis=0))

    @cached_property
    def _place(self) -> np.ndarray:
        return places_of(self.mesh, self.at)[:1]

    def _traces(self, fields, mesh: NamedMesh, places: np.ndarray) -> list:
        cells = Cells(whole(mesh), cells_at(whole(mesh), None))
        which, reference, _ = cells.closest(places)
        quantities = ["displacement"] if fields.spin(mesh) is None else ["displacement", "rotation"]
        return [fields.trace_in(mesh, cells.cells[which], reference, quantity) for quantity in quantities]

    def _nodes(self, fields) -> tuple[np.ndarray, np.ndarray]:
        """Places and origins of the coupled nodes of all processes, without the reference itself."""
        mesh, at = self.to
        own = fields.nodes(mesh, at)
        gathered = mesh.comm.allgather((fields.places(mesh, own), fields.origins(mesh, own)))
        places, origins = (np.concatenate(parts) for parts in zip(*gathered, strict=True))
        order = np.argsort(origins)
        places, origins = places[order], origins[order]
        apart = np.ones(len(places), dtype=bool) if mesh is not self.mesh else (
            np.linalg.norm(places - self._place, axis=1) > 0)
        if not apart.any():
            raise ValueError(f"{type(self).__name__} at {self.at!r}: {at!r} has no node beside the reference; name an "
                             "edge, or points elsewhere")
        return places[apart], origins[apart]


@dataclass(frozen=True, eq=False)
class KinematicCoupling(_Coupling):
    """Nodes move and turn with a reference point as one rigid body (known as RBE2, or a spider).

    Attributes
    ----------
    held : components of the nodes that follow it, x y z rx ry rz, separated by spaces, on axes that turn with the
        reference; None: all that they have
    """

    held: str | None = None

    def __post_init__(self):
        super().__post_init__()
        require_known(f"KinematicCoupling at {self.at!r}", (self.held or "").split(), COMPONENTS[self.mesh.dimension])

    def _names(self, fields) -> list[str]:
        dimension = self.mesh.dimension
        every = COMPONENTS[dimension][:dimension if fields.spin(self.to[0]) is None else None]
        wanted = every if self.held is None else self.held.split()
        if missing := [name for name in wanted if name not in every]:
            raise ValueError(f"KinematicCoupling at {self.at!r}: holds {' '.join(missing)}, but bars have no "
                             "rotations; hold displacements only")
        return [name for name in every if name in wanted]

    def unknowns(self, fields) -> None:
        fields.add_numbers(self, self.mesh, "tie", self._nodes(fields)[1], len(self._names(fields)), whole=True)

    def contributions(self, fields):
        places, names = self._nodes(fields)[0], self._names(fields)
        first, second = self._reference(fields, len(places)), self._traces(fields, self.to[0], places)
        chosen = [COMPONENTS[self.mesh.dimension].index(name) for name in names]
        numbers = np.arange(len(places)) * len(names)
        ties = [fields.own_trace(self, "tie", numbers + i) for i in range(len(names))]
        split, last = len(first), len(first) + len(second)

        def strains(values, data, factor):
            gap = forms.interface.gap_of_arm(values[:split], values[split:last], data[0])
            return forms.interface.with_multipliers([gap[i] for i in chosen], values[last:])

        yield fields.point_work([*first, *second, *ties], strains, forms.interface.tied, [places - self._place])


@dataclass(frozen=True, eq=False)
class DistributingCoupling(_Coupling):
    """A reference point follows the mean motion of nodes, which it does not stiffen (known as RBE3).

    Its force and moment are distributed over them: the reference is where the nodes' own rigid body, by least
    squares, has it.
    """

    def unknowns(self, fields) -> None:
        motions = len(COMPONENTS[self.mesh.dimension])
        fields.add_numbers(self, self.mesh, "tie", np.zeros(1, dtype=np.int64), motions, whole=True)

    def contributions(self, fields):
        places, dimension = self._nodes(fields)[0], self.mesh.dimension
        if np.linalg.matrix_rank(places - places.mean(axis=0), SAME * self.to[0].size) < dimension - 1:
            raise ValueError(f"DistributingCoupling at {self.at!r}: the nodes of {self.to[1]!r} are on a line (or one "
                             "point), about which they do not tell how it turns; name an edge that bends, or more "
                             "points")
        first = self._reference(fields, len(places))
        second = self._traces(fields, self.to[0], places)[:1]
        numbers = np.zeros(len(places), dtype=np.int64)
        ties = [fields.own_trace(self, "tie", numbers + i) for i in range(len(COMPONENTS[dimension]))]
        middle = places.mean(axis=0)

        def strains(values, data, factor):
            gaps = forms.interface.mean_gaps(values[:2], values[2], data[0], data[1])
            return forms.interface.with_multipliers(gaps, values[3:])

        data = [places - self._place, places - middle]
        yield fields.point_work([*first, *second, *ties], strains, forms.interface.tied, data,
                                weights=np.full(len(places), 1 / len(places)))
