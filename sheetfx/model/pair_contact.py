"""Contact between deformable parts: panels seated on bars, or butting against them, at pairs of points."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import cached_property, lru_cache
from typing import Annotated

import numpy as np

from .. import forms
from ..checks import NONZERO, Choice, Count, NotNegative, Positive, check, require_components
from ..mesh.lines import Stretch
from ..mesh.meeting import Meeting, Side, along_lines, at_pairs
from ..mesh.projection import Cells, cells_at
from ..mesh.reader import NamedMesh
from ..mesh.track import Track
from ..mesh.whole import whole
from .interface import stiffness_over
from .joints import Joint
from .places import Place, each_of, meeting_of, require_places, title_of

FACES = "seat", "butt"
ENFORCEMENTS = "penalty", "uzawa", "condensed"
PARALLEL = 1e-9  # sine of an angle, or an arm over the size of the mesh, that gives no direction
POINTS = 3  # on each piece of a line
STIFF = 10.0  # pressure per penetration, over the membrane stiffness of the softer part and the size of its cells
ELASTIC_SLIP = 1e-2  # tangential over normal stiffness
PENETRATION = 1e-6  # over the size of the cells, that augmentation leaves


@dataclass(frozen=True, eq=False)
class PairContact(Joint):
    """Unilateral contact, with or without friction, of a line of one part with a curve of another.

    Pairs of points along the line can be pressed together, but not pulled apart. Directions turn with the first part.

    Attributes
    ----------
    mesh : of the first part, which has rotations where it can turn: a shell, or a beam
    at : where on it: a named edge of surfaces, group of curves or point, a Stretch, or several of these
    to : mesh of the second part, of curves, and the name of a group of cells of it; None: all
    face : "seat": the first part lies on the second; "butt": the edge of a panel pushes against the second part in
        the plane of the panel
    toward : direction from the first part to the second one, roughly; None: that of the arms between them, which
        then must not be zero (a butting edge always faces away from its panel)
    gap : initial gap, whatever is between the lines otherwise (half thicknesses, radii) being filled; a number, or a
        function from places on the first part, shape (n, dimension), to gaps
    friction : Coulomb's coefficient
    cohesion, strength : traction that holds without pressure, and tension that is held (force per length of line)
    moving : whether pairs find their partner along the curve as they slide; else they stay as they are first
    pairs : number of pairs on each line, evenly spaced; None: three Gauss points on each piece that is in one
        cell of both parts
    stiffness : pressure (force per length, a force at named points) over penetration; None: ten times that of the
        softer part in its plane over a cell
    tangential : stiffness against slip before the cone is reached; None: a hundredth of `stiffness`, with which
        Newton's steps do not jump from slip to slip the other way
    enforcement : "condensed": forces of the penalty, found within each Newton iteration on the flexibility of the
        structure at the pairs that open, close or slip; "penalty": the same without that, with two to three times
        as many factorisations, which pays on several processes; or "uzawa": found as "condensed" ones, but pressures
        are augmented until no pair penetrates by more than a millionth of a cell (and slips where it sticks by more
        than that times `stiffness` over `tangential`), with a stiffness that grows along the path from the given one
        as long as this is slow
    law : function like `forms.contact.mohr_coulomb`
    reach : distance between the lines of both parts that may be filled
    adjust : overlap at the start (a negative `gap`) up to which pairs touch where they are, as of imperfect
        parts; 0: none
    name : what messages call it
    """

    mesh: NamedMesh
    at: Place
    to: tuple[NamedMesh, str | None]
    face: Annotated[str, Choice(FACES)] = "seat"
    toward: Annotated[Sequence[float], NONZERO] | None = None
    gap: NotNegative | Callable = 0.0
    friction: NotNegative = 0.0
    cohesion: NotNegative = 0.0
    strength: NotNegative = 0.0
    moving: bool = True
    pairs: Count | None = None
    stiffness: Positive | None = None
    tangential: Positive | None = None
    enforcement: Annotated[str, Choice(ENFORCEMENTS)] = "condensed"
    law: Callable = forms.contact.mohr_coulomb
    reach: NotNegative = 0.0
    adjust: NotNegative = 0.0
    name: str = field(default="PairContact", kw_only=True)

    smooth = False
    on_ground = False

    def __post_init__(self):
        check(self)
        require_places(self.name, self.mesh, each_of(self.at))
        if self.toward is not None:
            require_components(f"{self._title}: toward", self.toward, self.mesh.dimension)
        if self.to[0].domain.topology.dim != 1:
            raise ValueError(f"{self._title}: the second part is a surface; give beams or bars, and the surface first")
        if self.to[0].dimension != self.mesh.dimension:
            raise ValueError(f"{self._title}: the first part is in {self.mesh.dimension} dimensions, the second in "
                             f"{self.to[0].dimension}; read both with the same")
        if self.face == "butt" and self.mesh.domain.topology.dim != 2:
            raise ValueError(f"{self._title}: face is 'butt', but the first part is no surface; use 'seat'")
        _ = self.axes

    @property
    def _title(self) -> str:
        return title_of(self.name, each_of(self.at)[0])

    @property
    def points(self) -> Sequence[tuple[NamedMesh, str | None]]:
        return [(self.mesh, None), (self.to[0], None)]

    @property
    def conservative(self) -> bool:  # type: ignore[override]
        return self.friction == 0 and self.cohesion == 0

    @cached_property
    def meeting(self) -> Meeting:
        """Pairs of points."""
        return _meeting(self.mesh, tuple(each_of(self.at)), self.to, self.pairs, self.reach, self.name)

    @cached_property
    def axes(self) -> np.ndarray:
        """Directions at the pairs, shape (n, d, d): out of the face, along the line, across."""
        meeting = self.meeting
        one, two = meeting.sides
        along = self._directions()
        arms = two.places - one.places
        if self.mesh.dimension == 2:
            out = np.column_stack((along[:, 1], -along[:, 0]))
            return np.stack([out * self._sign(out, arms), along], axis=1)
        normals = self._normals(one, arms)
        normals = normals - (normals * along).sum(axis=1, keepdims=True) * along
        sizes = np.linalg.norm(normals, axis=1, keepdims=True)
        if sizes.min(initial=1.0) <= PARALLEL:
            raise ValueError(f"{self._title}: no direction leads from one part to the other across their lines; give "
                             "one in `toward`")
        normals = normals / sizes
        if self.face == "seat":
            out = normals * self._sign(normals, arms)
        else:
            out = np.cross(along, normals)
            inside = Cells(whole(self.mesh), one.cells).middles - one.places
            out *= -np.sign((out * inside).sum(axis=1, keepdims=True))
        return np.stack([out, along, np.cross(out, along)], axis=1)

    def _normals(self, first: Side, arms: np.ndarray) -> np.ndarray:
        """Directions of the order of 1 off the lines: normals of a surface, else those toward the second part."""
        if first.normals is not None:
            return first.normals
        if self.toward is None:
            return arms / self.mesh.size
        return np.tile(self.toward / np.linalg.norm(self.toward), (len(arms), 1))

    def _directions(self) -> np.ndarray:
        """Unit vectors along the lines, at points along the second part."""
        two, mesh, group = self.meeting.sides[1], whole(self.to[0]), self.to[1]
        cells = np.sort(cells_at(mesh, group))
        return Track(Cells(mesh, cells)).tangents(np.searchsorted(cells, two.cells), two.reference)

    def _sign(self, out: np.ndarray, arms: np.ndarray) -> np.ndarray:
        toward = arms / self.mesh.size if self.toward is None else self.toward / np.linalg.norm(self.toward)
        along = (out * toward).sum(axis=1, keepdims=True)
        if np.abs(along).min(initial=1.0) <= PARALLEL:
            raise ValueError(f"{self._title}: no direction leads from one part to the other, which lie at the same "
                             "place; say in `toward` on which side the second part is")
        return np.sign(along)

    def contributions(self, fields):
        meeting = self.meeting
        one, two = meeting.sides
        gap = self.gap(one.places) if callable(self.gap) else np.full(len(meeting.weights), float(self.gap))
        if gap.min(initial=0.0) < -self.adjust:
            worst = ", ".join(f"{x:.6g}" for x in one.places[gap.argmin()])
            raise ValueError(f"{self._title}: the parts overlap by {-gap.min():.6g} at ({worst}); move one of them, "
                             "make the gap larger, or adjust= where it is an imperfection")
        gap = np.maximum(gap, 0.0)
        stiffness = self.stiffness or self._default_stiffness(fields)
        tangential = self.tangential or ELASTIC_SLIP * stiffness
        yield fields.pair_work(self, one, two, {
            "arms": two.places - one.places, "axes": self.axes, "gap": gap, "weights": meeting.weights,
            "parameters": (stiffness, tangential, self.friction, self.cohesion, self.strength),
            "augmented": self.enforcement == "uzawa", "tolerance": PENETRATION * meeting.size})

    def _default_stiffness(self, fields) -> float:
        size = self.meeting.size
        both = [max(stiffness_over(part, size)[0] for part in fields.scene.parts if part.mesh is mesh)
                for mesh in (self.mesh, self.to[0])]
        at_points = all(isinstance(at, str) and at in self.mesh.points for at in each_of(self.at))
        return STIFF * min(both) * (size if at_points else 1.0)


@lru_cache(maxsize=4)
def _meeting(mesh: NamedMesh, places: Sequence[str | Stretch], to: tuple[NamedMesh, str | None], pairs: int | None,
             reach: float, name: str) -> Meeting:
    """Pairs of points at some places; kept, because both faces of a panel have the same."""
    def along(first, second, lines, title):
        if pairs is None:
            return along_lines(first, second, lines, reach, POINTS, title)
        return at_pairs(first, second, lines, pairs, reach, title)

    return meeting_of(mesh, places, to, reach, name, along)
