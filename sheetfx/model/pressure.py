"""Pressure, which follows what it acts on as it turns and stretches."""

from __future__ import annotations

from dataclasses import dataclass

from .. import forms
from .beam import Beam
from .loads import Load
from .shell import Shell


@dataclass(frozen=True, eq=False)
class Pressure(Load):
    """Pressure along the current normal of a shell, which follows it as it turns.

    Where the shell is closed or its edges are held, such a pressure has a potential; whether it has is seen by its
    tangent.
    """

    shell: Shell
    pressure: float
    conservative = False

    def work(self, fields):
        frame, u = self.shell.frame(), fields.displacement(self.shell.mesh)
        return forms.load.pressure(fields.factor * self.pressure, u, frame, fields.vary) * self.shell.measure()

    def total(self, fields) -> float:
        return abs(self.pressure)


@dataclass(frozen=True, eq=False)
class LinePressure(Load):
    """Pressure on a beam in the plane: force per current length along its current normal.

    The normal is on the left of the direction in which the mesh runs along the beam. As that of a `Pressure`, its
    tangent shows whether it has a potential: it has on closed rings and between ends that are held. A
    `LineForce(follower=True)` differs: its size is per reference length, it turns with the cross-section, and no
    supports give it a potential.
    """

    beam: Beam
    pressure: float
    conservative = False

    def __post_init__(self):
        if self.beam.mesh.dimension != 2:
            raise ValueError("LinePressure: the mesh is in space, where a curve has no one normal; use a LineForce")

    def work(self, fields):
        frame, u = self.beam.frame(), fields.displacement(self.beam.mesh)
        return forms.load.line_pressure(fields.factor * self.pressure, u, frame, fields.vary) * self.beam.measure()

    def total(self, fields) -> float:
        return abs(self.pressure)
