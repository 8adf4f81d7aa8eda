"""Nodes of which one component of the rotation is fixed: a surface of rotations is left to them.

With the rotation R since the reference configuration, its quaternion (q0, v) and the fixed axis a, that surface is

- at points: v . a = 0, the axis of R is perpendicular to a;
- on edges: c . R t = 0 with c = a x t, where t is the edge's direction across a: R t stays in the plane of a and t.

Increments keep to it exactly if their component along one direction n is zero. At points (1, w / 2) (q0, v) keeps
v . a = 0 for all Rodrigues vectors w perpendicular to n = q0 a + v x a, which is a turned by half of R. On edges
increments turn about R t by one angle, then about c by another, and n = R t x c. So supports fix a component along
axes that turn with the node, whatever the steps, and no equation is added.
"""

from __future__ import annotations

from collections.abc import Sequence

import basix
import numpy as np
from dolfinx import la

from ..compat import geometry_nodes
from ..mesh.reader import NamedMesh

ACROSS, CORNER = 0.25, 0.1  # squared sine of an edge to the axis, and of edges to one another, that make a direction
BROKEN = 1e-6  # by which a state breaks the condition that is not one of these supports


class PartlyFixed:
    """Nodes of a field of rotations with one fixed component, and the axes of their increments.

    Parameters
    ----------
    nodes : numbers of the nodes
    fixed : of each the number of its fixed component
    axes : of each the directions of the components in the reference configuration as columns, shape (nodes, 3, 3)
    edges : of each the sum of t t over the edges there, t being their unit direction; zero at points, shape
        (nodes, 3, 3)

    Attributes
    ----------
    nodes : numbers of the nodes
    start : directions of the components in the reference configuration, as given
    on_edge : numbers of those among them that are on an edge
    fixed_on_edge : of each of these the number of its fixed component
    twist : of each of these the second derivative of the Rodrigues vector by the components of an increment, which is
        along the fixed direction, shape (nodes on edges, 3, 3)
    """

    def __init__(self, nodes: np.ndarray, fixed: np.ndarray, axes: np.ndarray, edges: np.ndarray):
        self.nodes, self.start = nodes, axes.copy()
        self._held = held = np.take_along_axis(axes, fixed[:, None, None], axis=2)[..., 0]
        across = np.eye(3) - np.einsum("ni,nj->nij", held, held)
        sizes, directions = np.linalg.eigh(across @ edges @ across)
        self._edge = (sizes[:, 2] > ACROSS) & (sizes[:, 1] < CORNER * sizes[:, 2])
        self.on_edge, held = nodes[self._edge], held[self._edge]
        self.fixed_on_edge, along = fixed[self._edge], directions[self._edge, :, 2]
        self._along, self._across = along, np.cross(held, along)
        self._order = (self.fixed_on_edge[:, None] + np.arange(3)) % 3
        self.twist, numbers = np.zeros((len(along), 3, 3)), np.arange(len(along))
        _, about, across = self._order.T
        self.twist[numbers, about, across] = self.twist[numbers, across, about] = -0.5

    def axes(self, quaternions: np.ndarray) -> np.ndarray:
        """Directions of the components of increments from given rotations of the nodes, as columns."""
        axes = _turned(quaternions + np.eye(4)[0], self.start)
        along = _turned(quaternions[self._edge], self._along[:, :, None])[..., 0]
        own = np.stack((np.cross(along, self._across), along, self._across), axis=2)
        on_edge = np.empty_like(own)
        np.put_along_axis(on_edge, np.broadcast_to(self._order[:, None], own.shape), own, axis=2)
        kept = np.abs(np.einsum("ni,ni->n", along, self._across)) < BROKEN
        axes[self._edge] = np.where(kept[:, None, None], on_edge, axes[self._edge])
        return axes

    def nearest(self, quaternions: np.ndarray) -> np.ndarray:
        """The rotations of the nodes that are closest to given ones and that the supports allow."""
        found = quaternions.copy()
        found[:, 1:] -= np.einsum("ni,ni->n", found[:, 1:], self._held)[:, None] * self._held
        off = quaternions[self._edge]
        along = _turned(off, self._along[:, :, None])[..., 0]
        sine = np.einsum("ni,ni->n", along, self._across)[:, None]
        about = np.cross(along, self._across)
        size = np.linalg.norm(about, axis=1, keepdims=True)
        back = -np.tan(np.arctan2(sine, size) / 2) * about / np.where(size > 0, size, 1.0)
        scalar, vector = off[:, :1], off[:, 1:]
        found[self._edge] = np.column_stack((scalar[:, 0] - np.einsum("ni,ni->n", back, vector),
                                             vector + scalar * back + np.cross(back, vector)))
        return found


def _turned(quaternions: np.ndarray, columns: np.ndarray) -> np.ndarray:
    """Columns turned by quaternions of any length, shapes (n, 4) and (n, 3, k)."""
    length = (quaternions**2).sum(axis=1)
    twice = 2 / np.where(length > 0, length, 1.0)
    rows, scalar, vector = columns.transpose(0, 2, 1), quaternions[:, None, :1], quaternions[:, None, 1:]
    across = np.cross(vector, rows)
    return (rows + twice[:, None, None] * (scalar * across + np.cross(vector, across))).transpose(0, 2, 1)


def directions_of_edges(mesh: NamedMesh, names: Sequence[str], space) -> np.ndarray:
    """Sum of t t over the facets of named edges with unit direction t, at each node of a space, shape (nodes, 3, 3)."""
    table = la.vector(space.dofmap.index_map, 9)
    sums = table.array.reshape(-1, 3, 3)
    shape, nodes = mesh.domain.ufl_domain().ufl_coordinate_element().basix_element, geometry_nodes(mesh.domain)
    points = space.element.basix_element.points
    slopes = shape.tabulate(1, points)[1:, :, :, 0]
    corners, sides = basix.geometry(shape.cell_type), basix.topology(shape.cell_type)[1]
    for name in names:
        for cell, side in mesh.sides(mesh.at(name)[1]).reshape(-1, 2):
            first, second = corners[sides[side]]
            chosen = space.dofmap.dof_layout.entity_closure_dofs(1, int(side))
            along = np.einsum("dki,ij,d->kj", slopes[:, chosen], mesh.domain.geometry.x[nodes[cell]], second - first)
            along /= np.linalg.norm(along, axis=1, keepdims=True)
            sums[space.dofmap.cell_dofs(cell)[chosen]] += np.einsum("ki,kj->kij", along, along)
    table.scatter_reverse(la.InsertMode.add)
    table.scatter_forward()
    return sums
