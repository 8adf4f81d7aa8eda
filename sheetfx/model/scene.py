"""The scene: a structure with its supports, joints, contacts and loads, as plain data checked when made."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from itertools import combinations
from typing import Annotated, Any

from ..checks import NONZERO, Count, Like, check, require_known_component
from ..mesh.pieces import separate_pieces
from ..mesh.reader import COMPONENTS, NamedMesh
from ..notices import alike, warn
from .beam import Bar, Beam
from .contact import Contact
from .free_body import held_freely
from .held import supports_that_hold
from .initial_strain import StressFree
from .interface import Interface
from .joints import Compatible, Joint
from .loads import Load, Moment, PrescribedDisplacement, PrescribedRotation
from .overlap import refuse_overlap
from .shell import Shell
from .supports import Support

TO_A_TARGET = Like("a LoadControl with the target 1, which ends at the full loads",
                   lambda control: control is None or hasattr(control, "target"))


@dataclass(frozen=True)
class Monitor:
    """The displacement that paths are drawn against: a point's component or an obstacle's travel."""

    on: object
    at: str | None = None
    component: str | None = None
    sign: Annotated[float, NONZERO] = 1.0

    def __post_init__(self):
        check(self)
        if isinstance(self.on, NamedMesh):
            at = self.at or ""
            self.on.require(f"Monitor at {self.at!r}", at, "point", "edge")
            if (count := self.on.count(at)) != 1:
                raise ValueError(f"Monitor at {self.at!r}: has {count} vertices, of which one displacement would be "
                                 "the sum; name a point")
            require_known_component(f"Monitor at {self.at!r}", self.component or "", COMPONENTS[self.on.dimension])
        elif getattr(self.on, "travel", None) is None:
            raise ValueError(f"Monitor: {self.on!r} does not travel; name a point and a component of a mesh, or an "
                             "obstacle with a travel")


@dataclass(frozen=True, eq=False)
class Stage:
    """Loads that are applied before the varying ones, and stay: self-weight, prestress, a held displacement.

    Attributes
    ----------
    loads : grow together from zero to their full size
    name : what states say they are in
    control : how their path is followed, a `LoadControl` up to 1, such as `LoadControl(1.0, fixed=True)` to apply them
        at once; None: traced in steps that adapt, as any path
    at_once : whether the stage begins in balance with its whole loads, found by Newton's method from where the
        structure is; for what can move freely without them, as a net of cables without prestress
    """

    loads: Sequence[Load]
    name: str = "preload"
    control: Annotated[Any, TO_A_TARGET] = None
    at_once: bool = False

    def __post_init__(self):
        check(self)
        if self.at_once and self.control is not None:
            raise ValueError(f"Stage {self.name!r}: at_once is True, so that no path is followed; leave control out")
        if not self.loads:
            raise ValueError(f"Stage {self.name!r}: loads is empty; give at least one")


@dataclass(frozen=True, eq=False)
class Scene:
    """A structure with its joints, contacts, supports and loads.

    Attributes
    ----------
    parts : beams, bars and shells
    supports : where the structure is held; without any, and without a joint to the ground, it is a free body, whose
        loads have to be in equilibrium
    loads : those that vary along the path
    monitor : what paths are drawn against
    contacts : with rigid obstacles
    symmetry_factor : how many times the modelled part stands in the whole structure (2 for a half);
        forces are reported for the whole
    joints : springs, ties, foundations, and joints of one's own
    stages : of loads that are applied first, one stage after the other
    """

    parts: Sequence[Beam | Bar | Shell]
    supports: Sequence[Support]
    loads: Sequence[Load]
    monitor: Monitor
    contacts: Sequence[Contact] = field(default_factory=tuple)
    symmetry_factor: Count = 1
    joints: Sequence[Joint] = field(default_factory=tuple)
    stages: Sequence[Stage] = field(default_factory=tuple)

    def __post_init__(self):
        check(self)
        if not self.parts:
            raise ValueError("Scene: parts is empty; give at least one beam, bar or shell")
        for name in ("parts", "contacts", "joints"):
            given = list(map(id, getattr(self, name)))
            if twice := [one for one in getattr(self, name) if given.count(id(one)) > 1]:
                raise ValueError(f"Scene: {name} has the same {type(twice[0]).__name__} twice; leave one out")
        if not self.loads:
            raise ValueError("Scene: loads is empty; give at least one")
        self._check_meshes()
        self._check_initial_strains()
        self._check_prescribed()
        for mesh in self.meshes:
            self._check_spaces([part for part in self.parts if part.mesh is mesh])
        refuse_overlap(self.parts)
        self._tell_unjoined()
        self._tell_points()
        self._tell_short()

    @property
    def stress_free(self) -> list[tuple[int, StressFree]]:
        """Loads that change the strains without stress, with the numbers of their stages."""
        return [(number, load) for number, stage in enumerate(self.all_stages) for load in stage.loads
                if isinstance(load, StressFree)]

    @property
    def free(self) -> bool:
        """Whether nothing holds the structure: no support, no obstacle, no joint to the ground."""
        return not (self.supports or self.contacts or any(joint.on_ground for joint in self.joints))

    @cached_property
    def all_joints(self) -> list[Joint]:
        """Its joints, and what holds the mean motion of a free body."""
        return [*self.joints, *(held_freely(self.parts) if self.free else ())]

    @property
    def all_stages(self) -> list[Stage]:
        """The stages of loads applied first, and the varying loads' stage."""
        return [*self.stages, Stage(self.loads, "load")]

    @property
    def all_loads(self) -> list[Load]:
        return [load for stage in self.all_stages for load in stage.loads]

    @property
    def meshes(self) -> list[NamedMesh]:
        """The meshes of the parts, each once, in order."""
        return list(dict.fromkeys(part.mesh for part in self.parts))

    def _check_meshes(self) -> None:
        """Refuse objects on a mesh that no part has: they would act on nothing."""
        known = self.meshes
        placed: list[Any] = [*self.supports, *self.all_loads, *self.joints, *self.contacts, self.monitor]
        for one in placed:
            for mesh in _meshes_of(one):
                if mesh not in known:
                    at = f" at {one.at!r}" if isinstance(getattr(one, "at", None), str) else ""
                    raise ValueError(f"{type(one).__name__}{at}: is on a mesh of {', '.join(mesh.cells)} that no part "
                                     "of the scene has; give one of the meshes of its parts (what is read twice is two "
                                     "meshes), or a part on this one")

    def _check_initial_strains(self) -> None:
        """Refuse initial strains of anything but a part: they would act on nothing."""
        for _, load in self.stress_free:
            if not any(load.part is part for part in self.parts):
                raise ValueError(f"{type(load).__name__}: its {part_named(load.part)} is no part of the scene; give "
                                 "one of the parts themselves, not one like it")

    def _check_prescribed(self) -> None:
        """Refuse loads that prescribe one displacement or rotation twice, but at corners of edges that move alike."""
        moved = [(load, stage.name) for stage in self.all_stages for load in stage.loads
                 if isinstance(load, PrescribedDisplacement)]
        for (load, stage), (other, earlier) in combinations(moved, 2):
            if load.mesh is not other.mesh or load.component != other.component:
                continue
            what = f"PrescribedDisplacement of {other.at!r}: component {load.component}"
            if load.at == other.at:
                raise ValueError(f"{what} is prescribed twice; keep one of the two")
            if (load.distance, stage) != (other.distance, earlier) and load.mesh.meet(load.at, other.at):
                raise ValueError(f"{what} is {other.distance:g} where that of {load.at!r}, with which it has points in "
                                 f"common, is {load.distance:g}; give both the same distance in one stage")
        turned = [load for load in self.all_loads if isinstance(load, PrescribedRotation)]
        for one, two in combinations(turned, 2):
            if one.mesh is two.mesh and (one.at == two.at or one.mesh.meet(one.at, two.at)):
                there = "" if one.at == two.at else f", which has points in common with {two.at!r}"
                raise ValueError(f"PrescribedRotation at {one.at!r}{there}: the rotation is prescribed twice; keep one "
                                 "of the two")

    def require_free(self, monitor: Monitor) -> None:
        """Refuse to monitor what supports hold."""
        on, at, component = monitor.on, monitor.at, monitor.component
        if not isinstance(on, NamedMesh) or at is None or component is None:
            return
        if held := supports_that_hold(self.supports, on, at, component):
            raise ValueError(f"Monitor at {at!r}: its component {component} is held by the support at "
                             f"{' and '.join(map(repr, held))}, so that it stays zero; monitor a component that moves")

    def _tell_unjoined(self) -> None:
        """Warn of parts and of pieces of meshes that neither joints nor an obstacle connect."""
        compatible = [joint for joint in self.joints if isinstance(joint, Compatible)]
        others = [joint.points for joint in self.joints if joint not in compatible]
        touching: dict = {}
        for contact in self.contacts:
            touching.setdefault(contact.obstacle, []).append((contact.beam.mesh, None))
        pieces = separate_pieces(self.meshes, [*filter(None, others), *touching.values()],
                                 [(joint.mesh, joint.to) for joint in compatible])
        if pieces and all(others):
            warn(f"Scene: nothing joins the piece with {pieces[0]} and the piece with {pieces[1]}; they are solved "
                 "side by side. Join them (weld, hinge, Spring), mesh them together, or trace each in a scene of its "
                 "own")

    def _tell_points(self) -> None:
        """Warn, once for each kind of joint, of those at single points of shells."""
        found: dict[str, list[str]] = {}
        for joint in self.joints:
            if isinstance(joint, Interface):
                found.setdefault(joint.name, []).extend(joint.points_of_shells)
        for name, points in found.items():
            if points:
                one = "joins a single point" if len(points) == 1 else "each join a single point"
                warn(f"{alike(name, points)}: {one} of a shell. The displacement and rotation of a plate under a force "
                     "or moment at a point have no limit as its mesh is refined, so that results depend on the mesh; "
                     "join it over a length, see Stretch")

    def _tell_short(self) -> None:
        """Warn, once for each kind of joint, of those along lines that are shorter than half of a cell there."""
        found: dict[str, list] = {}
        for joint in self.joints:
            if isinstance(joint, Interface):
                found.setdefault(joint.name, []).extend(line for line in joint.meeting.lines if line.short)
        for lines in found.values():
            if lines:
                worst = min(lines, key=lambda line: line.length / line.cell)
                more = f" (the shortest of {len(lines)})" if len(lines) > 1 else ""
                warn(f"{worst.name}{more}: its length {worst.length:.4g} is less than half of the cell of "
                     f"{worst.cell:.4g} that it is on, where it holds as a longer one would: stiffness, and where "
                     f"parts part, are those of the mesh. Give cells of at most {2 * worst.length:.4g} there, or a "
                     "longer joint")

    def _check_spaces(self, parts) -> None:
        """Refuse parts of one mesh that cannot share its unknowns, and rotations where there are none."""
        mesh, spaces = parts[0].mesh, parts[0].spaces
        for part in parts[1:]:
            if part.spaces != spaces:
                raise ValueError(f"Scene: {type(parts[0]).__name__} and {type(part).__name__} of one mesh have "
                                 f"unknowns {spaces} and {part.spaces}; give them the same, or each its own mesh")
        if spaces[1] is not None:
            return
        for support in self.supports:
            turns = [c for c in support.fixed.split() if c.startswith("r")]
            if support.mesh is mesh and turns:
                raise ValueError(f"Support at {support.at!r}: fixes {' '.join(turns)}, but bars have no rotations; "
                                 "fix displacements only, for example with pin")
        for load in self.all_loads:
            if isinstance(load, Moment) and load.mesh is mesh:
                raise ValueError(f"Moment at {load.at!r}: bars have no rotations; give them forces")
        component = self.monitor.component or ""
        if self.monitor.on is mesh and component.startswith("r"):
            raise ValueError(f"Monitor at {self.monitor.at!r}: component is {component}, but bars have no rotations; "
                             "choose a displacement")


def _meshes_of(one: Any) -> list[NamedMesh]:
    """Meshes that a support, load, joint, contact or monitor is on."""
    parts = [getattr(one, name, None) for name in ("part", "beam", "shell")]
    found = [getattr(one, "mesh", None), getattr(one, "on", None), *(getattr(part, "mesh", None) for part in parts)]
    joined = [mesh for mesh, _ in one.points] if isinstance(one, Joint) else []
    return [mesh for mesh in (*found, *joined) if isinstance(mesh, NamedMesh)]


def part_named(part: Beam | Bar | Shell) -> str:
    """A part by its kind and what its mesh is made of."""
    return f"{type(part).__name__} on {part.group or ', '.join(part.mesh.cells)}"
