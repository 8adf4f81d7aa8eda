"""Unknown fields: what an increment means at the nodes of a field, and how it changes the field.

The solver works with increments since the last converged state. A displacement adds its
increment; a rotation composes it with the quaternion of that state, node by node, so that the state
depends on the nodal rotations only and the total rotation is unlimited.
"""

from __future__ import annotations

from functools import cached_property

import numpy as np
import ufl
from dolfinx.common import IndexMap
from dolfinx.fem import Function, FunctionSpace

from . import origins
from .partly_fixed import PartlyFixed


class AdditiveField:
    """A field that adds its increment (displacement, planar angle, multiplier).

    Parameters
    ----------
    value : Function
        Current value; appears in the forms.
    dofs : int array
        Place of each entry of `value` in the local vector of the block.
    scale : float
        Size against which increments are measured; infinite: not measured at all.
    multiplier : bool
        Whether the field is a Lagrange multiplier (counts one negative pivot each).

    Attributes
    ----------
    axes : array, shape (nodes, width, width), or None
        Columns are the directions that the components of nodal increments belong to; None: the axes of space.
    """

    axes: np.ndarray | None = None
    curved = False

    def __init__(self, value: Function, dofs: np.ndarray, scale: float, multiplier: bool = False):
        self.value, self.dofs, self.scale, self.multiplier = value, dofs, scale, multiplier
        self.symbol = value
        self.previous = Function(value.function_space)

    def create_change(self) -> Function:
        """A holder of changes of the value, in `x.array`."""
        return Function(self.value.function_space)

    @property
    def name(self) -> str:
        return self.value.name

    @property
    def components(self) -> int:
        """Number of components of the value at a node."""
        return self.value.function_space.dofmap.bs

    @property
    def width(self) -> int:
        """Number of components of a nodal increment."""
        return self.components

    @property
    def table(self) -> np.ndarray:
        """Values of the nodes of this process and its ghosts, shape (nodes, components)."""
        return self.value.x.array.reshape(-1, self.components)

    @property
    def space(self) -> FunctionSpace:
        """Function space of the value."""
        return self.value.function_space

    @property
    def index_map(self) -> IndexMap:
        """Distribution of the nodes over the processes."""
        return self.space.dofmap.index_map

    def seen(self, rows: np.ndarray) -> np.ndarray:
        """Rows for the nodes that traces may have: of this process and its ghosts."""
        return rows

    def add(self, total: np.ndarray, nodes: np.ndarray, values: np.ndarray) -> None:
        """Add values at nodes to an array of the nodes of this process and its ghosts."""
        np.add.at(total, nodes, values)

    @cached_property
    def count(self) -> int:
        """Number of nodes on all processes."""
        return self.value.function_space.dofmap.index_map.size_global

    @cached_property
    def origins(self) -> np.ndarray:
        """What tells nodes of this process and its ghosts on any number of processes, see `origins`."""
        return origins.of_nodes(self.value.function_space)

    def variations(self) -> np.ndarray:
        """Nodal variations by a unit increment, shape (nodes or 1 if all alike, components, width)."""
        return np.eye(self.width)[None] if self.axes is None else self.axes

    def motions(self) -> np.ndarray | None:
        """Displacements or spins of the nodes by a unit increment, shape (nodes, width, width); None: the increment."""
        return self.axes

    def outward(self, components: np.ndarray) -> np.ndarray:
        """Nodal vectors along the directions of space from components along the axes."""
        if self.axes is None:
            return components
        return np.einsum("nij,nj->ni", self.axes, components.reshape(-1, self.width)).ravel()

    def rate(self, motions: np.ndarray) -> np.ndarray:
        """Rates of the present increment at nodes with given rates of displacement, or spins, along space; flat."""
        return self.inward(motions.ravel())

    def inward(self, components: np.ndarray) -> np.ndarray:
        """Forces on increments from nodal forces or moments along the directions of space."""
        motions = self.motions()
        if motions is None:
            return components
        return np.einsum("nji,nj->ni", motions, components.reshape(-1, self.width)).ravel()

    def pull(self, force: np.ndarray) -> np.ndarray:
        """Forces on nodal increments by forces conjugate to the values, shape (nodes, components), as a flat array."""
        return self.inward(force.ravel())

    def spatial(self, force: np.ndarray) -> np.ndarray:
        """Nodal forces or moments along the directions of space, flat, from forces conjugate to the values."""
        return force.ravel()

    def advance(self, block_increment: np.ndarray) -> None:
        self.value.x.array[:] = self.previous.x.array + self.outward(block_increment[self.dofs])

    def show(self, values: np.ndarray) -> None:
        """Put the present value alone to an array of this process."""
        self.value.x.array[:] = values

    def change(self, block_increment: np.ndarray) -> np.ndarray:
        """First-order change of the value's array by a further increment."""
        return self.outward(block_increment[self.dofs])

    def combine(self, total: np.ndarray, further: np.ndarray) -> None:
        """Follow the increment `total` (changed in place) by `further`."""
        total[self.dofs] += further[self.dofs]

    def rebase(self) -> None:
        """Let increments count from the present value."""
        self.previous.x.array[:] = self.value.x.array

    def restore(self, values: np.ndarray) -> None:
        """Put the value that increments count from, and the present one, to an array of this process."""
        self.previous.x.array[:] = values
        self.value.x.array[:] = values

    def at_rest(self) -> dict:
        """Replacements that put the increment's symbol to zero in a form."""
        return {}

    def holding(self, values: np.ndarray, held: np.ndarray) -> np.ndarray:
        """The nearest nodal values that supports allow.

        Parameters
        ----------
        values : shape (nodes, components)
        held : which components of nodal increments are fixed, shape (nodes, width)
        """
        return self._put_back(values, held)

    def _put_back(self, vectors: np.ndarray, held: np.ndarray) -> np.ndarray:
        """Vectors along the directions of space without their components that are fixed."""
        if self.axes is None:
            return np.where(held, 0.0, vectors)
        own = np.where(held, np.einsum("nji,nj->ni", self.axes, vectors), 0.0)
        return vectors - np.einsum("nij,nj->ni", self.axes, own)


class QuaternionField(AdditiveField):
    """Rotations as nodal quaternions of unit length, scalar first.

    The increment of a node is the Rodrigues vector of its rotation since the last converged state (twice the
    tangent of half the angle). Further increments are small rotations that follow it: forces on them are moments.

    Attributes
    ----------
    charted : bool array, nodes whose further increments add instead, because one component of them is fixed: the
        Hessian of the energy is then symmetric whatever the reaction there
    partly_fixed : those nodes, whose axes turn with them; None: none
    """

    partly_fixed: PartlyFixed | None = None

    curved = True
    width = 3

    def __init__(self, value: Function, symbol: Function, dofs: np.ndarray):
        super().__init__(value, dofs, 1.0)
        self.symbol = symbol
        value.x.array.reshape(-1, 4)[:] = (1, 0, 0, 0)
        count = len(value.x.array) // 4
        self.charted, self._components = np.zeros(count, dtype=bool), np.zeros((count, 3))
        self.rebase()

    def hold(self, partly_fixed: PartlyFixed) -> None:
        """Let the increments of some nodes add along axes that turn with them."""
        self.partly_fixed = partly_fixed
        self.charted[partly_fixed.nodes] = True
        if self.axes is None:
            self.axes = np.tile(np.eye(3), (len(self.charted), 1, 1))
        self._start_increments()

    def advance(self, block_increment):
        self._components = block_increment[self.dofs].reshape(-1, 3)
        self.value.x.array.reshape(-1, 4)[:] = _compose(self._increment(), self.previous.x.array.reshape(-1, 4))

    def rebase(self):
        super().rebase()
        self._start_increments()

    def restore(self, values):
        super().restore(values)
        self._start_increments()

    def _start_increments(self) -> None:
        self._components = np.zeros_like(self._components)
        if self.partly_fixed is not None:
            nodes = self.partly_fixed.nodes
            self.axes[nodes] = self.partly_fixed.axes(self.previous.x.array.reshape(-1, 4)[nodes])

    def _increment(self) -> np.ndarray:
        return self.rodrigues(self._components)

    def rodrigues(self, components: np.ndarray) -> np.ndarray:
        """Rodrigues vectors, on an edge of a turn about it before one across both; shape (nodes, 3)."""
        increment = self.outward(components.ravel()).reshape(-1, 3)
        if self.partly_fixed is not None:
            nodes, twist, normals = self._edge()
            x = components[nodes]
            increment = increment.copy()
            increment[nodes] += normals * (np.einsum("ni,nij,nj->n", x, twist, x) / 2)[:, None]
        return increment

    def _directions(self) -> np.ndarray | None:
        """Derivatives of the Rodrigues vectors by their components as columns; None: the directions of space."""
        if self.partly_fixed is None:
            return self.axes
        nodes, twist, normals = self._edge()
        directions = self.axes.copy()
        directions[nodes] += np.einsum("ni,njk,nk->nij", normals, twist, self._components[nodes])
        return directions

    def _edge(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Nodes on edges, second derivatives of their Rodrigues vectors, and the directions of these."""
        partly = self.partly_fixed
        return partly.on_edge, partly.twist, np.take_along_axis(
            self.axes[partly.on_edge], partly.fixed_on_edge[:, None, None], axis=2)[..., 0]

    def combine(self, total, further):
        before, more = (self.outward(a[self.dofs]).reshape(-1, 3) for a in (total, further))
        product = _compose(more, np.column_stack((np.ones(len(before)), before / 2)))
        composed = 2 * product[:, 1:] / product[:, :1]
        if self.axes is not None:
            composed = np.einsum("nji,nj->ni", self.axes, composed)
        added = (total + further)[self.dofs].reshape(-1, 3)
        total[self.dofs] = np.where(self.charted[:, None], added, composed).ravel()

    def variations(self):
        slopes = _slopes(self.value.x.array.reshape(-1, 4))
        slopes[self.charted] = self._chart()[2]
        return np.ascontiguousarray(slopes if self.axes is None else slopes @ self._directions())

    def motions(self):
        directions = self._directions()
        if not self.charted.any():
            return directions
        motions = np.tile(np.eye(3), (len(self.charted), 1, 1)) if directions is None else directions.copy()
        motions[self.charted] = _spins(self._increment()[self.charted]) @ motions[self.charted]
        return motions

    def rate(self, motions):
        directions, spins = self._directions(), _spins(self._increment())
        return np.linalg.solve(spins if directions is None else spins @ directions, motions[..., None]).ravel()

    def pull(self, force):
        return np.einsum("na,nai->ni", force, self.variations()).ravel()

    def spatial(self, force):
        return np.einsum("na,nai->ni", force, _slopes(self.value.x.array.reshape(-1, 4))).ravel()

    def _chart(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Of charted nodes the quaternion, and its derivative by the Rodrigues vector along and across it."""
        product = np.column_stack((np.ones(self.charted.sum()), self._increment()[self.charted] / 2))
        length = np.linalg.norm(product, axis=1)
        slopes = _slopes(self.previous.x.array.reshape(-1, 4)[self.charted]) / length[:, None, None]
        unit = self.value.x.array.reshape(-1, 4)[self.charted]
        along = np.einsum("na,nai->ni", unit, slopes)
        return unit, along, slopes - unit[:, :, None] * along[:, None, :]

    def change(self, block_increment):
        return np.einsum("nai,ni->na", self.variations(), block_increment[self.dofs].reshape(-1, 3)).ravel()

    def curvature(self, force: np.ndarray, symmetric: bool) -> np.ndarray:
        """Part of the tangent from forces on the quaternions, shape (nodes, 3, 3).

        The second derivative of the quaternions; in unsymmetric problems also the change of moments as the spin
        that they are conjugate to turns, which makes the tangent the derivative of the residual.
        """
        q = self.value.x.array.reshape(-1, 4)
        blocks = -np.einsum("na,na->n", force, q)[:, None, None] / 4 * np.eye(3)
        if not symmetric:
            moments = np.einsum("na,nai->ni", force, _slopes(q))
            blocks = blocks - np.cross(np.eye(3)[None], moments[:, None, :]) / 2
        unit, along, across = self._chart()
        force = force[self.charted]
        mixed = np.einsum("ni,nj->nij", along, np.einsum("na,nai->ni", force, across))
        radial = np.einsum("na,na->n", force, unit)[:, None, None] * np.einsum("nai,naj->nij", across, across)
        blocks[self.charted] = -mixed - mixed.transpose(0, 2, 1) - radial
        conjugate = np.zeros((len(q), 3))
        conjugate[self.charted] = np.einsum("na,nai->ni", force, across)
        return self._turned(blocks, conjugate)

    def _turned(self, blocks: np.ndarray, conjugate: np.ndarray) -> np.ndarray:
        """Nodal matrices for components of increments, from those for Rodrigues vectors and the forces on these."""
        directions = self._directions()
        if directions is not None:
            blocks = np.einsum("nki,nkl,nlj->nij", directions, blocks, directions)
        if self.partly_fixed is not None:
            nodes, twist, normals = self._edge()
            blocks[nodes] += np.einsum("ni,ni->n", conjugate[nodes], normals)[:, None, None] * twist
        return blocks

    def holding(self, values, held):
        """The nearest rotations; where one component is fixed, on the surface in `PartlyFixed`."""
        found = values.copy()
        found[:, 1:] = self._put_back(values[:, 1:], held)
        if self.partly_fixed is not None:
            found[self.partly_fixed.nodes] = self.partly_fixed.nearest(values[self.partly_fixed.nodes])
        return found / np.linalg.norm(found, axis=1, keepdims=True)

    def moment_slopes(self, moments: np.ndarray) -> np.ndarray:
        """Derivative of `inward` with respect to further increments, shape (nodes, 3, 3); not symmetric."""
        a = self._increment()
        twice = 2 + (a * a).sum(axis=1)[:, None, None] / 2
        pulled = np.einsum("nji,nj->ni", _spins(a), moments)
        skew = np.cross(np.eye(3)[None], moments[:, None, :]).transpose(0, 2, 1)
        slopes = -(skew + np.einsum("ni,nj->nij", pulled, a)) / twice
        charted = self.charted[:, None]
        return self._turned(np.where(charted[:, :, None], slopes, 0.0), np.where(charted, pulled, 0.0))

    def at_rest(self):
        return {self.symbol: ufl.classes.Zero(self.symbol.ufl_shape)}


def _slopes(quaternion: np.ndarray) -> np.ndarray:
    """Derivative of (1, increment / 2) * quaternion with respect to the increment, shape (n, 4, 3)."""
    q0, q1, q2, q3 = quaternion.T / 2
    return np.array([[-q1, -q2, -q3], [q0, q3, -q2], [-q3, q0, q1], [q2, -q1, q0]]).transpose(2, 0, 1)


def _spins(increment: np.ndarray) -> np.ndarray:
    """Derivative of the spin by Rodrigues vectors a, shape (n, 3, 3).

    The spin by a variation b is (b + a x b / 2) / (1 + |a|^2 / 4) (Geradin and Cardona 2001, section 4.9).
    """
    turned = np.eye(3) + np.cross(increment[:, None, :] / 2, np.eye(3)[None]).transpose(0, 2, 1)
    return turned / (1 + (increment * increment).sum(axis=1) / 4)[:, None, None]


def _compose(increment: np.ndarray, quaternion: np.ndarray) -> np.ndarray:
    """Unit quaternions (1, increment / 2) * quaternion, row by row (see forms.rotation.compose)."""
    product = quaternion + np.einsum("nai,ni->na", _slopes(quaternion), increment)
    return product / np.linalg.norm(product, axis=1, keepdims=True)
