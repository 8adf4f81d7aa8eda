"""Structures on which classical methods of path following fail, with every critical point of their paths.

A method is right on a trap if it finds all points of the list, in this order, and no others.
"""

from __future__ import annotations

from .classical import CLASSICAL
from .contact import CONTACT
from .following import FOLLOWING
from .modes import MODES
from .plates import PLATES
from .pressure import PRESSURE
from .trap import Expected, Trap

__all__ = ["FAMILIES", "TRAPS", "Expected", "Trap"]

FAMILIES = CLASSICAL, MODES, FOLLOWING, PLATES, PRESSURE, CONTACT
TRAPS = {trap.name: trap for family in FAMILIES for trap in family}
