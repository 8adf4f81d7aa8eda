"""What pictures show of a state, gathered on process 0."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager

import numpy as np
import ufl
from dolfinx import fem
from mpi4py import MPI

from ..continuation.state import CriticalPoint, State
from ..discrete.contact import ContactFields, ContactState
from ..jit import compiled_expression
from ..mesh.reader import NamedMesh
from ..model.obstacles import way_of
from .shown import Shown

POINTS_PER_CELL = 5
ROUNDING = 1e-6  # of a displacement that is zero, over the largest increment of the unknowns


def communicator(record: Shown) -> MPI.Comm:
    return record.path.discretisation.system.comm


def unit_of(axis: str) -> str:
    """The unit in a name such as "load (N)", "" where it has none."""
    return axis[axis.rindex("(") + 1:-1] if axis.endswith(")") else ""


def told(axis: str, plain: str) -> str:
    """What a value on an axis is called in sentences: plainly, or where it is a ratio by the axis' own name."""
    return axis if any(sign in axis for sign in (" over ", " / ")) else plain


def with_unit(value: float, unit: str) -> str:
    """A number with four digits or more, and its unit."""
    if 1e-3 <= abs(value) < 1e4:
        digits = f"{value:#.4g}".rstrip(".")
    else:
        digits = f"{value:.0f}" if 1e4 <= abs(value) < 1e7 else f"{value:.4g}"
    return f"{digits} {unit}".rstrip()


def stays(states: Sequence[State]) -> bool:
    """Whether the monitored displacement is zero but for rounding."""
    largest = max(np.abs(state.increment).max(initial=0.0) for state in states)
    return max(abs(state.deflection) for state in states) <= ROUNDING * largest


@contextmanager
def last_state_kept(record: Shown) -> Iterator[None]:
    """Other states may be shown inside; afterwards the fields are the last one's again."""
    try:
        yield
    finally:
        record.show(record.states[-1])


def most_telling(points: list[CriticalPoint], most: int) -> list[CriticalPoint]:
    """At most `most` critical points: the first, the highest, the lowest and others spread over the path."""
    if len(points) <= most:
        return points
    loads = [p.load for p in points]
    chosen = {0, int(np.argmax(loads)), int(np.argmin(loads))}
    chosen.update(np.linspace(0, len(points) - 1, most - len(chosen) + 1)[1:].astype(int).tolist())
    return [points[i] for i in sorted(chosen)]


class Curves:
    """The curves of all meshes, several points to each cell so that curved cells look curved.

    Parameters
    ----------
    displacements : for each mesh a displacement to use instead of the current one
    """

    def __init__(self, record: Shown, displacements: Mapping[NamedMesh, fem.Function] | None = None):
        points = np.linspace(0, 1, POINTS_PER_CELL)[:, None]
        discretisation = record.path.discretisation
        self._comm = communicator(record)
        self._parts = []
        for mesh in (m for m in record.case.scene.meshes if m.domain.topology.dim == 1):
            x = ufl.SpatialCoordinate(mesh.domain)
            u = displacements[mesh] if displacements else discretisation.kinematics(mesh).u
            both = [*x, *(x + u)]
            self._parts.append((mesh, compiled_expression(ufl.as_vector(both), points)))

    def evaluate(self) -> tuple[np.ndarray, np.ndarray] | None:
        """Undeformed and current places, each (cells, points, 3), on process 0; None elsewhere."""
        rows = [np.zeros((0, POINTS_PER_CELL, 2, 3))]
        for mesh, expression in self._parts:
            d = mesh.dimension
            table = expression.eval(mesh.domain, mesh.group(None)).reshape(-1, POINTS_PER_CELL, 2, d)
            rows.append(np.pad(table, [(0, 0), (0, 0), (0, 0), (0, 3 - d)]))
        gathered = self._comm.gather(np.concatenate(rows))
        if gathered is None:
            return None
        table = np.concatenate(gathered)
        return table[:, :, 0], table[:, :, 1]


class ContactPoints:
    """All contact points of a record; points of several cells at one node are one point."""

    def __init__(self, record: Shown):
        self.fields: list[ContactFields] = record.path.discretisation.contacts
        self._comm = communicator(record)
        self._numbers = [self._comm.gather(c.numbers()) for c in self.fields]

    def evaluate(self) -> list[ContactState] | None:
        """State of each contact in order of x, on process 0; None elsewhere."""
        states = []
        for contact, numbers in zip(self.fields, self._numbers, strict=True):
            parts = self._comm.gather(vars(contact.evaluate()))
            if parts is not None:
                states.append(_merge(parts, numbers))
        return states if self._comm.rank == 0 else None


def _merge(parts: list[dict], numbers: list[np.ndarray | None]) -> ContactState:
    values = {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}
    rows = np.arange(len(values["gap"])) if numbers[0] is None else np.concatenate(numbers)
    _, first, place = np.unique(rows, return_index=True, return_inverse=True)
    weight = np.bincount(place, weights=values["weight"])
    values = {name: value[first] for name, value in values.items()} | {"weight": weight}
    order = np.argsort(values["position"][:, 0], kind="stable")
    return ContactState(**{name: value[order] for name, value in values.items()})


def travel(record: Shown, obstacle) -> np.ndarray:
    """Displacement of an obstacle in the shown state, shape (2,)."""
    if (way := way_of(obstacle)) is None:
        return np.zeros(2)
    return record.path.discretisation.travelled(obstacle) * way
