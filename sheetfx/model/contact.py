"""Contact of beams with rigid obstacles."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

from ..checks import Choice, NotNegative, Positive, check
from .beam import Beam
from .obstacles import RigidCylinder, RigidPlane
from .varying import require_uniform


@dataclass(frozen=True, eq=False)
class Contact:
    """Unilateral contact, with or without friction, between a beam and a rigid obstacle.

    Attributes
    ----------
    points : "nodes" or "quadrature", where contact is checked
    friction : Coulomb's coefficient
    side : 0: whichever looks to the obstacle; 1 or -1: only that to which the frame's normal points, or the other, on
        which friction turns about the axis too
    enforcement : "penalty" (the stiffness of the contact layer), "uzawa" (multipliers are updated
        between solutions) or "semismooth" (multipliers are unknowns); None: semismooth where contact is
        exact, penalty where there is a layer, see demos/enforcement.py for the comparison
    scale : augmentation, pressure per length of penetration; None: from the bending stiffness
    layer : length of an elastic contact layer of the stiffness EI / layer^4; 0: exact; None: 0 at nodes, otherwise that
        of a penalty's `scale`, or as thin as it can be for a smooth path
    approach : multiples of the layer through which forces are approached that a step does not find at once
    distance : from the axis to where it touches; None: half the depth, as the faces are; 0: at the axis
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
    distance: NotNegative | None = None

    def __post_init__(self):
        check(self)
        require_uniform(self.beam, "Contact")
        if self.layer and self.scale and self.enforcement == "penalty":
            raise ValueError(f"Contact: scale is {self.scale:g} and layer {self.layer:g}, each of which is the "
                             "stiffness of a penalty; give one of them")
        if self.side:
            self.beam.mesh.require_alike("Contact: side", self.beam.group)

    @property
    def reach(self) -> float:
        """Distance from the axis to where it touches."""
        return self.beam.section.depth / 2 if self.distance is None else self.distance

    @property
    def apart(self) -> float:
        """Distance of the axis from the obstacle at which it touches, on whichever side."""
        return 0.0 if self.side else self.reach

    @property
    def lever(self) -> float:
        """Place along the normal of the frame of the points that touch; zero without a side."""
        return self.side * self.reach
