"""Frictionless contact of a beam with an obstacle through an elastic layer, on points that follow the contact zone."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import ufl
from dolfinx import fem
from dolfinx.mesh import create_interval
from mpi4py import MPI

from .. import forms
from ..jit import compiled_expression
from ..mesh.numbers import with_constants
from ..model.contact import Contact
from ..model.obstacles import way_of
from ..rounding import SAME
from .contact import OPEN, SLIP, ContactFields, ContactState
from .contact_work import touching
from .contribution import Forces
from .fields import Fields
from .layout import Layout
from .nodal_field import AdditiveField
from .points import PointWork, Trace
from .timing import Stopwatch
from .unknowns import Unknowns
from .zones import SAMPLES, Zones, samples

CHUNK = 32  # points whose gaps are evaluated together


class LayerFields(ContactFields):
    """Gap of a contact through a layer, at samples in each cell between which it is interpolated.

    Forces act in the zones where it is negative, at points that follow them.
    """

    def _choose_points(self, name: str, count: int) -> None:
        self._points = samples()[:, None]
        self.cells = self.contact.beam.mesh.group(self.contact.beam.group)

    def gap_of(self, values: Sequence, place, arm):
        """Gap in UFL at a point with a place, from displacement, rotation where there is a side, and travel."""
        values, obstacle = list(values), self.contact.obstacle
        x = place + values.pop(0)
        if self.contact.side:
            x = x + forms.interface.rotation_of(values.pop(0)).rotate(arm)
        return obstacle.gap(x, [values[0][0] * c for c in way_of(obstacle)] if values else [0.0, 0.0])

    def prepare(self, at_rest) -> None:
        beam = self.contact.beam
        domain, d = beam.mesh.domain, beam.mesh.dimension
        place, jacobian = ufl.SpatialCoordinate(domain), ufl.Jacobian(domain)
        length = ufl.sqrt(sum(jacobian[i, 0] ** 2 for i in range(d)))
        arm = self.contact.lever * beam.frame().normal
        fixed = self._at_samples([*(place[i] for i in range(d)), *(arm[i] for i in range(d)), length])
        self.places, self.arms, self._lengths = fixed[..., :d], fixed[..., d: 2 * d], fixed[..., 2 * d]
        self._expression = self._compiled(at_rest(ufl.as_vector([self.gap, *(self._position[i] for i in range(d))])))

    def _compiled(self, values) -> fem.Expression:
        return compiled_expression(values, self._points, with_constants)

    def _at_samples(self, values: Sequence) -> np.ndarray:
        return self._table(self._compiled(ufl.as_vector(values)))

    def _table(self, expression: fem.Expression) -> np.ndarray:
        """Values in all cells at samples, shape (cells, samples, values)."""
        table = expression.eval(self.contact.beam.mesh.domain, self.cells)
        return table.reshape(len(self.cells), len(self._points), -1)

    def gaps(self) -> np.ndarray:
        """Gaps at samples in the current configuration, shape (cells, samples)."""
        return self._table(self._expression)[..., 0]

    def smallest_gap(self) -> float:
        """Smallest gap of the samples of this process, which has the ends of cells, as zones do not."""
        return float(self.gaps().min(initial=np.inf))

    def weights(self, zones: Zones) -> np.ndarray:
        """Lengths that belong to the points of zones."""
        return zones.weights * zones.interpolate(self._lengths)

    def evaluate(self) -> ContactState:
        """States of open samples elsewhere, then of the points in zones that touch."""
        table, d = self._table(self._expression), self.contact.beam.mesh.dimension
        zones = Zones.where_negative(table[..., 0])
        touching, apart = zones.interpolate(table), table[table[..., 0] >= 0]
        rows, closed = np.concatenate([apart, touching]), np.arange(len(apart) + len(touching)) >= len(apart)
        return ContactState(
            position=rows[:, 1: 1 + d], gap=rows[:, 0],
            pressure=np.where(closed, -rows[:, 0], 0.0) / self._final_compliance,
            traction=np.zeros(len(rows)), weight=np.concatenate([np.zeros(len(apart)), self.weights(zones)]),
            status=np.where(closed, SLIP, OPEN))

    def touching(self, state: ContactState) -> int:
        return int((state.status != OPEN).sum())

    def numbers(self) -> None:
        return None


class LayerWork(PointWork):
    """Virtual work of the pressure of a contact layer, gap over compliance wherever the gap is negative.

    Its energy is the integral of gap^2 / (2 compliance) over the zones that touch, exact for the interpolated gap.
    Forces and tangent change continuously with the state, so that paths are smooth and have true tangents.

    Attributes
    ----------
    fields : LayerFields
    """

    def __init__(self, of_scene: Fields, fields: LayerFields, clock: Stopwatch):
        self.fields, self._clock, unknowns = fields, clock, of_scene.unknowns
        self._everywhere = [_in_cells(unknowns, n, fields.cells) for n in _fields_of_gap(of_scene, fields.contact)]
        super().__init__(unknowns, self._everywhere, self._law)
        self.smooth, self.steep, self.approaches = False, True, fields.contact.approach
        self._shapes = [_at_samples(field, trace) for field, trace in zip(self._fields, self._traces, strict=True)]
        self._gap = GapAtPoints(fields, [f.components for f in self._fields])
        self._followed = np.empty(0), 0.0

    def pattern(self, layout: Layout) -> tuple[np.ndarray, np.ndarray]:
        now, self._traces = self._traces, self._everywhere
        found = super().pattern(layout)
        self._traces = now
        return found

    def values(self) -> np.ndarray:
        self._follow()
        return super().values()

    def _follow(self) -> None:
        """Have the samples of the cells that touch in the current configuration, and what they share of its zones."""
        gaps, compliance = self.fields.gaps(), float(self.fields.compliance.value)
        if compliance == self._followed[1] and np.array_equal(gaps, self._followed[0]):
            return
        self._followed = gaps, compliance
        zones = Zones.where_negative(gaps - SAME * self.fields.contact.beam.section.depth)  # without a gap parts touch
        self._near, cell = np.unique(zones.cells, return_inverse=True)
        rows, weights, gap = zones.rows, self.fields.weights(zones) / compliance, zones.interpolate(gaps)
        self._energy = float(weights @ gap**2) / 2
        self._pressed = np.zeros((len(self._near), SAMPLES))
        self._stiffness = np.zeros((len(self._near), SAMPLES, SAMPLES))
        np.add.at(self._pressed, cell, (weights * gap)[:, None] * rows)
        np.add.at(self._stiffness, cell, weights[:, None, None] * rows[:, :, None] * rows[:, None, :])
        self._traces = [Trace(trace.field, np.repeat(trace.nodes[self._near], SAMPLES, axis=0),
                              np.tile(shapes, (len(self._near), 1)))
                        for trace, shapes in zip(self._everywhere, self._shapes, strict=True)]

    def _law(self, z: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        self._slopes, bends = self._gap(z, self.fields.places[self._near], self.fields.arms[self._near])
        return self._pressed.ravel()[:, None] * self._slopes, self._pressed.ravel()[:, None, None] * bends

    def tangent(self, held: Forces) -> Sequence[np.ndarray]:
        forces, bends = self._law(self.values())
        self._add(held, forces, curved_only=True)
        samples_of_cells = (len(self._near), SAMPLES)
        changes = self._derivatives()
        size = changes.shape[2]
        rows = np.einsum("nc,ncw->nw", self._slopes, changes).reshape(*samples_of_cells, size)
        blocks = (changes.transpose(0, 2, 1) @ (bends @ changes)).reshape(*samples_of_cells, size, size).sum(axis=1)
        blocks += rows.transpose(0, 2, 1) @ (self._stiffness @ rows)
        values = np.zeros((len(self.fields.cells), size, size))
        np.add.at(values, self._same[self._near], blocks)
        return [values.ravel()]

    def regularise(self, times: float) -> None:
        self.fields.thicken(times)

    def energy(self) -> float:
        self._follow()
        return self.fields.contact.beam.mesh.comm.allreduce(self._energy)

    def touching(self) -> tuple[int, float]:
        with self._clock("contact"):
            return touching(self.fields)


def _fields_of_gap(of_scene: Fields, contact: Contact) -> list[int]:
    """Numbers of the fields that the gap of a contact depends on."""
    found = list(of_scene.kinematics(contact.beam.mesh).block.fields[: 2 if contact.side else 1])
    if of_scene.has(contact.obstacle, "travel"):
        found.append(of_scene.own_field(contact.obstacle, "travel"))
    return [of_scene.unknowns.fields.index(field) for field in found]


def _in_cells(unknowns: Unknowns, number: int, cells: np.ndarray) -> Trace:
    """All nodes of cells, or the one number that they share."""
    space = getattr(unknowns.fields[number].value, "function_space", None)
    nodes = np.zeros((len(cells), 1), dtype=np.int64) if space is None else space.dofmap.list[cells].astype(np.int64)
    return Trace(number, nodes, np.zeros(nodes.shape))


def _at_samples(field: AdditiveField, trace: Trace) -> np.ndarray:
    """Shape functions of a field at the samples of a cell, shape (SAMPLES, k)."""
    if trace.nodes.shape[1] == 1:
        return np.ones((SAMPLES, 1))
    return field.value.function_space.ufl_element().basix_element.tabulate(0, samples()[:, None])[0, :, :, 0]


class GapAtPoints:
    """First and second derivatives of the gap at points by the values of fields there, compiled once."""

    def __init__(self, fields: LayerFields, sizes: Sequence[int]):
        mesh, d, m = create_interval(MPI.COMM_SELF, CHUNK, (0.0, 1.0)), fields.contact.beam.mesh.dimension, sum(sizes)
        self._mesh, self._cells, self._size = mesh, np.arange(CHUNK, dtype=np.int32), m
        self._z, self._place, self._arm = (fem.Function(fem.functionspace(mesh, ("DG", 0, (n,)))) for n in (m, d, d))
        z, ends = ufl.variable(self._z), np.cumsum(sizes)
        values = [ufl.as_vector([z[int(i)] for i in range(end - n, end)]) for end, n in zip(ends, sizes, strict=True)]
        gap = fields.gap_of(values, self._place, self._arm)
        slope = ufl.diff(gap, z)
        bend = ufl.diff(slope, z)
        table = ufl.as_vector([*(slope[i] for i in range(m)), *(bend[i, j] for i in range(m) for j in range(m)),
                               self._z[0]])  # without which derivatives that are constants, as of planes, have no mesh
        self._expression = compiled_expression(table, np.array([[0.5]]), with_constants)

    def __call__(self, z: np.ndarray, places: np.ndarray, arms: np.ndarray) -> tuple[np.ndarray, ...]:
        """Gradient, shape (n, m), and Hessian, shape (n, m, m), of the gap."""
        count, m = len(z), self._size
        places, arms = (table.reshape(count, table.shape[-1]) for table in (places, arms))
        table = np.zeros((count, m + m * m + 1))
        for start in range(0, count, CHUNK):
            part = slice(start, min(start + CHUNK, count))
            for function, values in ((self._z, z), (self._place, places), (self._arm, arms)):
                rows = function.function_space.dofmap.list[:, 0]
                given = values[np.minimum(np.arange(start, start + CHUNK), count - 1)]
                function.x.array.reshape(given.shape)[rows] = given
            table[part] = self._expression.eval(self._mesh, self._cells).reshape(CHUNK, -1)[: part.stop - start]
        return table[:, :m], table[:, m:-1].reshape(count, m, m)
