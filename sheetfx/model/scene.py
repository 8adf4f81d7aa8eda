"""What is modelled: plain data, checked when made."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np

from ..mesh.reader import COMPONENTS, Model
from .beam import Bar, Beam
from .loads import Moment, Motion
from .obstacles import RigidCylinder, RigidPlane
from .shell import Shell


@dataclass(frozen=True)
class Support:
    """Fixed components at a named point or edge: any of x y z rx ry rz, separated by spaces.

    Attributes
    ----------
    axes : three orthonormal directions that x, y, z and rx, ry, rz stand for, or a function from places, shape
        (n, 3), to directions, shape (n, 3 directions, 3 components); None: those of space
    """

    model: Model
    at: str
    fixed: str
    axes: Sequence[Sequence[float]] | Callable | None = None

    def __post_init__(self):
        known = COMPONENTS[self.model.dimension]
        self.model.at(self.at)
        for name in self.fixed.split():
            if name not in known:
                raise ValueError(f"Support at {self.at!r}: no component {name!r}; choose from {' '.join(known)}")
        if self.axes is not None and self.model.dimension != 3:
            raise ValueError(f"Support at {self.at!r}: axes are for structures in space")

    def directions(self, places: np.ndarray) -> np.ndarray:
        """Directions at places, shape (n, 3, 3), one direction in each row."""
        axes = self.axes(places) if callable(self.axes) else np.broadcast_to(self.axes, (len(places), 3, 3))
        axes = np.asarray(axes, dtype=float)
        if not np.allclose(axes @ axes.transpose(0, 2, 1), np.eye(3), atol=1e-9):
            raise ValueError(f"Support at {self.at!r}: axes must be three orthonormal directions")
        return axes


def clamp(model: Model, at: str) -> Support:
    """All displacements and rotations fixed."""
    return Support(model, at, " ".join(COMPONENTS[model.dimension]))


def pin(model: Model, at: str) -> Support:
    """All displacements fixed."""
    return Support(model, at, " ".join(c for c in COMPONENTS[model.dimension] if not c.startswith("r")))


def symmetry(model: Model, at: str, normal: str | Sequence[float] = "x") -> Support:
    """Structure cut by a plane: no displacement along its normal, rotation about the normal only.

    Parameters
    ----------
    normal : x, y or z, or a vector of any direction
    """
    if not isinstance(normal, str):
        return Support(model, at, "x ry rz", _axes_from(normal))
    if normal not in ("x", "y", "z"):
        raise ValueError(f"symmetry at {at!r}: normal is {normal!r}; it must be x, y or z")
    turns = [f"r{c}" for c in "xyz" if c != normal and f"r{c}" in COMPONENTS[model.dimension]]
    return Support(model, at, " ".join([normal, *turns]))


def _axes_from(first: Sequence[float]) -> np.ndarray:
    """Three orthonormal directions of which the first is given."""
    columns = np.column_stack((first, np.eye(3)[np.argsort(np.abs(first))[:2]].T))
    axes = np.linalg.qr(columns)[0].T
    return axes * np.sign(axes[0] @ np.asarray(first, dtype=float))


@dataclass(frozen=True, eq=False)
class Contact:
    """Unilateral contact, with or without friction, between a beam and a rigid obstacle.

    Attributes
    ----------
    points : "nodes" or "quadrature", where contact is checked
    friction : Coulomb's coefficient
    half_depth : contact at the surface (half the depth off the centre line) instead of at the
        centre line; the sign says on which side of the frame's normal
    enforcement : "penalty" (the stiffness of the contact layer), "uzawa" (multipliers are updated
        between solutions) or "semismooth" (multipliers are unknowns); None: semismooth where contact is
        exact, penalty where there is a layer, see demos/enforcement.py for the comparison
    scale : augmentation, pressure per length of penetration; None: from the bending stiffness
    layer : thickness-like length of an elastic contact layer, see `contact.fields.resolution`;
        0: exact; None: 0 at nodes, as thin as it can be for a smooth path otherwise
    approach : multiples of the layer through which each step's solution is approached
    """

    beam: Beam
    obstacle: RigidCylinder | RigidPlane
    points: str = "quadrature"
    friction: float = 0.0
    half_depth: int = 0
    enforcement: str | None = None
    scale: float | None = None
    layer: float | None = None
    approach: tuple[float, ...] = (8.0, 4.0, 2.0, 1.0)

    def __post_init__(self):
        for name, value, known in (("points", self.points, ("nodes", "quadrature")),
                                   ("enforcement", self.enforcement, (None, "semismooth", "uzawa", "penalty")),
                                   ("half_depth", self.half_depth, (-1, 0, 1))):
            if value not in known:
                raise ValueError(f"Contact: {name} is {value!r}; it must be one of {', '.join(map(str, known))}")
        for name in ("friction", "layer"):
            value = getattr(self, name)
            if value is not None and value < 0:
                raise ValueError(f"Contact: {name} is {value}; it must not be negative")


@dataclass(frozen=True)
class Monitor:
    """The displacement that paths are drawn against: a point's component or an obstacle's travel."""

    on: object
    at: str | None = None
    component: str | None = None
    sign: float = 1.0


@dataclass(frozen=True, eq=False)
class Scene:
    """A structure with its contacts, supports and loads.

    Attributes
    ----------
    parts : beams, bars and shells
    copies : how many times the modelled part stands in the whole structure (2 for a half);
        loads are reported for the whole
    """

    parts: Sequence[Beam | Bar | Shell]
    supports: Sequence[Support]
    loads: Sequence[object]
    monitor: Monitor
    contacts: Sequence[Contact] = field(default_factory=tuple)
    copies: int = 1

    def __post_init__(self):
        if not self.parts:
            raise ValueError("Scene: no structure; give at least one beam, bar or shell")
        if not self.loads:
            raise ValueError("Scene: no load; give at least one")
        if not self.supports:
            raise ValueError("Scene: the structure has no support and can move freely; add a support")
        self._check_motions()
        for model in self.models:
            self._check_spaces([part for part in self.parts if part.model is model])

    @property
    def models(self) -> list[Model]:
        """The models of the parts, each once, in order."""
        return list(dict.fromkeys(part.model for part in self.parts))

    def _check_motions(self) -> None:
        """Refuse motions that prescribe one displacement twice."""
        moved = [(load.model, load.at, load.component) for load in self.loads if isinstance(load, Motion)]
        for i, (_, at, component) in enumerate(moved):
            if moved[i] in moved[:i]:
                raise ValueError(f"Motion of {at!r}: component {component} is prescribed twice; keep one of the two")

    def _check_spaces(self, parts) -> None:
        """Refuse parts of one model that cannot share its unknowns, and rotations where there are none."""
        model, spaces = parts[0].model, parts[0].spaces
        for part in parts[1:]:
            if part.spaces != spaces:
                raise ValueError(f"Scene: {type(parts[0]).__name__} and {type(part).__name__} of one model have "
                                 f"unknowns {spaces} and {part.spaces}; give them the same, or each its own model")
        if spaces[1] is not None:
            return
        for support in self.supports:
            turns = [c for c in support.fixed.split() if c.startswith("r")]
            if support.model is model and turns:
                raise ValueError(f"Support at {support.at!r}: fixes {' '.join(turns)}, but bars have no rotations; "
                                 "fix displacements only, for example with pin")
        for load in self.loads:
            if isinstance(load, Moment) and load.model is model:
                raise ValueError(f"Moment at {load.at!r}: bars have no rotations; give them forces")
        component = self.monitor.component or ""
        if self.monitor.on is model and component.startswith("r"):
            raise ValueError(f"Monitor at {self.monitor.at!r}: component is {component}, but bars have no rotations; "
                             "choose a displacement")
