"""The load vector of strains at which a part is free of stress."""

from __future__ import annotations

from .contribution import Contribution, Forces
from .elements import ElementWork


class NaturalStrainLoad(Contribution):
    """Forces by a change of a part's strains without stress; the part's own work has what they do by now.

    Parameters
    ----------
    work : internal virtual work of the part
    natural : strains without stress for a load factor of 1, a UFL vector
    stage : number of the load stage
    """

    called, tells_work = "initial strain", False

    def __init__(self, work: ElementWork, natural, stage: int):
        self.stage, self._add = stage, work.forces_by(natural)

    def load(self, forces: Forces) -> None:
        self._add(forces)
