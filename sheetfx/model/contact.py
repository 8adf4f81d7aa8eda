"""Contact of beams with rigid obstacles."""

from __future__ import annotations

from dataclasses import dataclass

from ..checks import require_finite
from .beam import Beam
from .obstacles import RigidCylinder, RigidPlane


@dataclass(frozen=True, eq=False)
class Contact:
    """Unilateral contact, with or without friction, between a beam and a rigid obstacle.

    Attributes
    ----------
    points : "nodes" or "quadrature", where contact is checked
    friction : Coulomb's coefficient
    side : contact at the surface (half the depth off the centre line) instead of at the
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
    side: int = 0
    enforcement: str | None = None
    scale: float | None = None
    layer: float | None = None
    approach: tuple[float, ...] = (8.0, 4.0, 2.0, 1.0)

    def __post_init__(self):
        for name, value, known in (("points", self.points, ("nodes", "quadrature")),
                                   ("enforcement", self.enforcement, (None, "semismooth", "uzawa", "penalty")),
                                   ("side", self.side, (-1, 0, 1))):
            if value not in known:
                raise ValueError(f"Contact: {name} is {value!r}; it must be one of {', '.join(map(str, known))}")
        require_finite(self, "friction", "layer", "scale", "approach")
        for name in ("friction", "layer"):
            value = getattr(self, name)
            if value is not None and value < 0:
                raise ValueError(f"Contact: {name} is {value}; it must not be negative")
