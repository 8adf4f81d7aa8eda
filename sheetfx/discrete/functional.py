"""Displacements and rotations as functions of the increments since the last converged state."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from petsc4py import PETSc

from .layout import Layout
from .nodal_field import QuaternionField


@dataclass
class Functional:
    """A displacement, or what else is linear in increments.

    Attributes
    ----------
    vector : its product with a small increment is the change
    """

    vector: PETSc.Vec

    @property
    def initial(self) -> float:
        """Value at the start of a path, which changes are added to."""
        return 0.0

    def rate(self, increment: PETSc.Vec) -> float:
        """Change by a small increment, such as the response to a unit of load."""
        return self.vector.dot(increment)

    def of(self, increment: PETSc.Vec) -> float:
        """Change by an increment of any size."""
        return self.rate(increment)


@dataclass
class Turn(Functional):
    """Component of the rotation of a node in space: the angle times the axis of its rotation since the last state.

    Increments are Rodrigues vectors, 2 tan(angle / 2) times the axis. The sum of the angles of all steps is the angle
    that the node has turned where the axis stays.

    Attributes
    ----------
    layout : of the increments
    field : of the rotations
    dofs : the component's in the field's block, on the process that owns the node
    sign : of the component
    """

    layout: Layout
    field: QuaternionField
    dofs: np.ndarray
    sign: float

    def of(self, increment):
        block = next(own for field, own in self.layout.fields(self.layout.arrays(increment)) if field is self.field)
        vectors = self.field.rodrigues(block[self.field.dofs].reshape(-1, 3))
        tangents = np.linalg.norm(vectors, axis=1, keepdims=True) / 2
        turns = vectors * np.divide(np.arctan(tangents), tangents, out=np.ones_like(tangents), where=tangents > 0)
        return self.sign * self.layout.comm.allreduce(float(turns.ravel()[np.isin(self.field.dofs, self.dofs)].sum()))
