"""One contact in discrete form: its points, multipliers, virtual work and state."""

from __future__ import annotations

from dataclasses import dataclass

import basix.ufl
import numpy as np
import ufl
from dolfinx import fem

from .. import forms
from ..jit import compiled_expression
from ..model.contact import Contact
from ..rounding import SAME
from .nodal_field import AdditiveField
from .unknowns import Block

# Contact points on the length of a layer, and the numbers of them in a cell that are used: few, so that
# forms are compiled once for many meshes.
POINTS_ON_LAYER = 16
COUNTS = (2, 3, 4, 6, 8, 12, 16, 24, 32, 48, 64)


OPEN, STICK, SLIP = "open", "stick", "slip"


@dataclass(frozen=True)
class ContactState:
    """State of all contact points of one process, one row for each.

    Attributes
    ----------
    position : (n, d), current place of the point of the beam
    gap : (n,), length, negative where it penetrates
    pressure, traction : (n,), force per length; the traction is conjugate to the slip
    weight : (n,), length that belongs to the point
    status : (n,) of "open", "stick", "slip" ("slip" without friction)
    """

    position: np.ndarray
    gap: np.ndarray
    pressure: np.ndarray
    traction: np.ndarray
    weight: np.ndarray
    status: np.ndarray


def status_of(pressure: np.ndarray, traction: np.ndarray, bound: np.ndarray) -> np.ndarray:
    """Status of points by their pressure, the size of their traction, and that at which they slip."""
    return np.where(pressure == 0, OPEN, np.where(traction >= bound * (1 - SAME), SLIP, STICK))


class ContactFields:
    """Multipliers and tractions of a contact.

    Multipliers that are unknowns are kept in units of length: pressure over `unit`, so that the
    residual of their equation is a force like all others.
    """

    def __init__(self, contact: Contact, name: str):
        beam = contact.beam
        domain = beam.mesh.domain
        self.contact = contact
        self.layer, count = resolution(contact)
        stiffness = beam.section.stiffness(beam.material, 2)[2]
        self.enforcement = contact.enforcement or ("penalty" if self.layer else "semismooth")
        self._final_compliance = self.layer**4 / stiffness
        self.compliance = fem.Constant(domain, self._final_compliance)
        self.scale = contact.scale or _default_scale(contact, stiffness)
        self.block, self.unit = None, 1.0
        self._choose_points(name, count)
        self.gap = self.slip = None

    def _choose_points(self, name: str, count: int) -> None:
        """Points of contact, `count` in a cell, with multipliers at them."""
        contact, beam = self.contact, self.contact.beam
        domain, degree = beam.mesh.domain, beam.degree
        cell, shape = domain.basix_cell(), (2,) if contact.friction else ()
        if contact.points == "nodes":
            rule = {"quadrature_rule": "GLL", "quadrature_degree": 2 * degree - 1}
            element = basix.ufl.element("P", cell, degree, shape=shape)
            weights = {1: (1 / 2, 1 / 2), 2: (1 / 6, 1 / 6, 2 / 3), 3: (1 / 12, 1 / 12, 5 / 12, 5 / 12)}[degree]
            points = basix.ufl.element("P", cell, degree).basix_element.points
        else:
            rule = {"quadrature_degree": 2 * count - 1}
            element = basix.ufl.quadrature_element(cell, value_shape=shape, degree=2 * count - 1)
            points, weights = element.custom_quadrature()
        self._points, self._weights = points, np.asarray(weights)
        self.integral = beam.mesh.integral(rule, beam.group)
        self.multiplier = fem.Function(fem.functionspace(domain, element), name=name)
        if self.enforcement == "semismooth":
            self.unit = 1e3 * self.scale
            field = AdditiveField(self.multiplier, np.arange(len(self.multiplier.x.array)), np.inf, True)
            self.block = Block.of_space(self.multiplier.function_space, field)

    def close(self, position, travel, previous) -> None:
        """Express gap and slip in the fields.

        Parameters
        ----------
        position : UFL vector, current place of the beam's points
        travel : UFL components of the obstacle's displacement
        previous : function from an expression to its value at the last converged state
        """
        obstacle = self.contact.obstacle
        self._position = position
        self.gap = obstacle.gap(position, travel) - self.contact.apart
        self.slip = obstacle.slip(position, travel, previous(position), [previous(t) for t in travel])

    @property
    def multipliers(self) -> list:
        """Normal and, with friction, tangential multiplier as pressures."""
        if self.contact.friction:
            return [self.unit * self.multiplier[0], self.unit * self.multiplier[1]]
        return [self.unit * self.multiplier]

    @property
    def tractions(self) -> list:
        """Pressure and, with friction, tangential traction."""
        law, m = forms.interface, self.multipliers
        pressure = law.contact_pressure(m[0], self.gap, self._stiffness)
        if not self.contact.friction:
            return [pressure]
        return [pressure, law.coulomb_traction(m[1], self.slip, self.scale, pressure, self.contact.friction)]

    @property
    def _stiffness(self):
        """Augmentation; where multipliers are not unknowns the stiffness of the contact layer."""
        if self.block is None and self.layer:
            return 1 / self.compliance
        return self.scale

    def work(self, vary):
        """Virtual work of the contact tractions, and the equations of the multipliers.

        The stationary point of (p^2 - m^2) / (2 scale) - compliance m^2 / 2 with p = <m - scale gap>
        (Alart and Curnier 1991, eq. 3.9, with an elastic layer). Sticking is elastic too, with a
        thousandth of the compliance at nodes: several points of a cell cannot all stick exactly, nor can
        a point that a support holds.
        """
        tractions = self.tractions
        density = -tractions[0] * vary(self.gap)
        if self.contact.friction:
            density += tractions[1] * vary(self.slip)
        if self.block is not None:
            for traction, multiplier in zip(tractions, self.multipliers, strict=True):
                density += (traction - multiplier) / self.scale * vary(multiplier)
            compliances = [self.compliance, (1.0 if self.layer else 1e-3) / self.scale]
            for compliance, multiplier in zip(compliances, self.multipliers, strict=False):
                density -= compliance * multiplier * vary(multiplier)
        return density * self.integral

    def thicken(self, times: float) -> None:
        """Make the elastic layer thicker by a factor, for approaching a solution."""
        self.compliance.value = self._final_compliance * times**4

    def prepare(self, at_rest) -> None:
        """Compile the evaluation at contact points; `at_rest` as in Unknowns."""
        domain = self.contact.beam.mesh.domain
        jacobian = ufl.Jacobian(domain)
        length = ufl.sqrt(sum(jacobian[i, 0] ** 2 for i in range(domain.geometry.dim)))
        tractions = (self.tractions + [ufl.as_ufl(0.0)])[:2]
        values = [*(self._position[i] for i in range(domain.geometry.dim)), self.gap, *tractions, length]
        self._expression = compiled_expression(at_rest(ufl.as_vector(values)), self._points)

    def evaluate(self) -> ContactState:
        """State of the contact points in the current configuration."""
        beam = self.contact.beam
        d = beam.mesh.dimension
        table = self._expression.eval(beam.mesh.domain, beam.mesh.group(beam.group))
        table = table.reshape(-1, len(self._weights), d + 4)
        weight = (table[..., d + 3] * self._weights).ravel()
        table = table.reshape(-1, d + 4)
        gap, pressure, traction = table[:, d], table[:, d + 1], table[:, d + 2]
        status = status_of(pressure, np.abs(traction), self.contact.friction * pressure)
        return ContactState(table[:, :d], gap, pressure, traction, weight, status)

    def smallest_gap(self) -> float:
        """Smallest gap of the points that may touch on this process; infinite where it has none."""
        return float(self.evaluate().gap.min(initial=np.inf))

    def _points_of_rows(self) -> np.ndarray:
        """Local number of the contact point of each row of a state; cells may share a node."""
        beam = self.contact.beam
        return self.multiplier.function_space.dofmap.list[beam.mesh.group(beam.group)].ravel()

    def numbers(self) -> np.ndarray | None:
        """Global number of the contact point of each row of a state; None: each row is a point of its own."""
        return self.multiplier.function_space.dofmap.index_map.local_to_global(self._points_of_rows())

    def touching(self, state: ContactState) -> int:
        """Number of contact points of this process that touch."""
        points = np.unique(self._points_of_rows()[state.status != OPEN])
        return int((points < self.multiplier.function_space.dofmap.index_map.size_local).sum())

    def store(self, state: ContactState, normal: bool) -> None:
        """Put evaluated tractions into multipliers that are not unknowns."""
        dofs = self._points_of_rows()
        table = self.multiplier.x.array.reshape(-1, 2 if self.contact.friction else 1)
        if normal:
            table[dofs, 0] = state.pressure
        if self.contact.friction:
            table[dofs, 1] = state.traction
        self.multiplier.x.scatter_forward()


def eliminates(contact: Contact) -> bool:
    """Whether a layer carries the pressure alone, without friction or multipliers."""
    return bool(resolution(contact)[0]) and not contact.friction and contact.enforcement in (None, "penalty")


def resolution(contact: Contact) -> tuple[float, int]:
    """Length of the contact layer and number of contact points in a cell.

    Rigid contact of a beam acts at points that slide; on fixed contact points the load hops from one to
    the next. An elastic layer of foundation stiffness EI / layer^4 spreads it over its characteristic
    length (Hetenyi 1946, section 3). The default of 0.1 depths (no less than a third of a cell) is
    indented by less than 1e-6 depths in the arch, and 16 points on a layer keep the tangent smooth as the
    contact slides (with 5 the slope of the arch's path changes its sign at random near the limit point).
    The scale of a penalty gives the layer of that stiffness.
    """
    if contact.points == "nodes":
        return contact.layer or 0.0, contact.beam.degree
    domain = contact.beam.mesh.domain
    cell = contact.beam.mesh.measure / domain.topology.index_map(1).size_global
    layer = contact.layer
    if layer is None and contact.scale and contact.enforcement == "penalty":
        layer = (contact.beam.section.stiffness(contact.beam.material, 2)[2] / contact.scale) ** (1 / 4)
    if layer is None:
        layer = max(0.1 * contact.beam.section.depth, cell / 3)
    if not layer:
        return 0.0, contact.beam.degree
    needed = POINTS_ON_LAYER * cell / layer * (1 - SAME)
    if needed > COUNTS[-1]:
        raise ValueError(f"Contact: a layer of {layer:.3g} would need {needed:.0f} contact points in each cell of "
                         f"length {cell:.3g}; refine the mesh or give a layer of at least "
                         f"{cell * POINTS_ON_LAYER / COUNTS[-1]:.3g}")
    return layer, next(count for count in COUNTS if count >= needed)


def _default_scale(contact: Contact, stiffness: float) -> float:
    """Augmentation of the order of the beam's own stiffness over a tenth of its size.

    48 EI / (l^3 h) with l a tenth of the mesh's size and h the mean cell length: pressure per
    length that a point force on a simply supported piece would need.
    """
    mesh = contact.beam.mesh
    cell = mesh.measure / mesh.domain.topology.index_map(1).size_global
    return 48 * stiffness / ((mesh.size / 10) ** 3 * cell)
