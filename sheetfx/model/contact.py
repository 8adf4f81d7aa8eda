"""Contact of beams with rigid obstacles."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

from ..checks import Choice, NotNegative, Positive, check
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
    points: Annotated[str, Choice(("nodes", "quadrature"))] = "quadrature"
    friction: NotNegative = 0.0
    side: Annotated[int, Choice((-1, 0, 1))] = 0
    enforcement: Annotated[str | None, Choice(("penalty", "uzawa", "semismooth"))] = None
    scale: Positive | None = None
    layer: NotNegative | None = None
    approach: tuple[Positive, ...] = (8.0, 4.0, 2.0, 1.0)

    def __post_init__(self):
        check(self)
        if self.side:
            self.beam.mesh.require_alike("Contact: side", self.beam.group)
