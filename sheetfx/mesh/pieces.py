"""Connected pieces of meshes, by the names of the things on them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import chain

import numpy as np
from dolfinx.mesh import compute_midpoints
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from ..compat import geometry_nodes
from ..notices import listed
from .reader import NamedMesh

Place = tuple[NamedMesh, str | None]

SAME_PLACE = 1e-6  # distance of vertices that stand at one place, over the size of their mesh
SHOWN = 6


def loose_pieces(meshes: Sequence[NamedMesh], held: Sequence[Place], joined: Sequence[Sequence[Place]] = (),
                 compatible: Sequence[tuple[NamedMesh, NamedMesh]] = ()) -> list[str]:
    """Names of groups and points on each connected piece of some meshes that nothing holds, its own ones first.

    Parameters
    ----------
    held : points and edges with supports
    joined : points and edges that joints connect with each other; None in the place of a name is the whole mesh
    compatible : meshes that move together where they have vertices at the same places
    """
    pieces = _Pieces(meshes, joined, compatible)
    tied = set().union(*(pieces.at(mesh, mesh.vertices(at)) for mesh, at in held))
    return pieces.named(pieces.all.difference(*pieces.comm.allgather(tied)))


def separate_pieces(meshes: Sequence[NamedMesh], joined: Sequence[Sequence[Place]] = (),
                    compatible: Sequence[tuple[NamedMesh, NamedMesh]] = ()) -> list[str]:
    """Names on each piece of some meshes, see `loose_pieces`, whether held or not; none where all hangs together."""
    pieces = _Pieces(meshes, joined, compatible)
    return pieces.named(pieces.all) if len(pieces.all) > 1 else []


class _Pieces:
    """Connected pieces of meshes by numbers of their vertices on all processes.

    Attributes
    ----------
    all : numbers of pieces with cells
    """

    def __init__(self, meshes: Sequence[NamedMesh], joined: Sequence[Sequence[Place]],
                 compatible: Sequence[tuple[NamedMesh, NamedMesh]]):
        self.comm, self._meshes = meshes[0].comm, meshes
        self._vertices = [mesh.domain.topology.index_map(0) for mesh in meshes]
        self._starts = np.cumsum([0, *(v.size_global for v in self._vertices)])
        pairs = [np.empty((0, 2), dtype=np.int64)]
        for mesh in meshes:
            corners = self._numbers(mesh, _corners(mesh).ravel()).reshape(_corners(mesh).shape)
            pairs += [corners[:, [0, i]] for i in range(1, corners.shape[1])]
        for extra, places in enumerate(joined, self._starts[-1]):
            pairs += [np.insert(self._numbers(mesh, _vertices_of(mesh, name))[:, None], 0, extra, axis=1)
                      for mesh, name in places]
        found = [*self.comm.allgather(np.concatenate(pairs)),
                 *(_at_same_places(*both, self._numbers) for both in compatible)]
        edges, size = np.concatenate(found).T, self._starts[-1] + len(joined)
        graph = coo_array((np.ones(edges.shape[1]), tuple(edges)), shape=(size, size))
        self._pieces = connected_components(graph, directed=False)[1]
        self.all = set(self._pieces[:self._starts[-1]].tolist())

    def _numbers(self, mesh: NamedMesh, local: np.ndarray) -> np.ndarray:
        index = self._meshes.index(mesh)
        return self._starts[index] + self._vertices[index].local_to_global(np.asarray(local, dtype=np.int32))

    def at(self, mesh: NamedMesh, local: np.ndarray) -> set[int]:
        """Pieces with vertices of this process."""
        return set(self._pieces[self._numbers(mesh, local)].tolist())

    def named(self, wanted: set[int]) -> list[str]:
        """Names on each of some pieces, those on few pieces first."""
        here = [(name, self.at(mesh, _corners(mesh)[cells].ravel())) for mesh in self._meshes
                for name, cells in mesh.cells.items()]
        here += [(name, self.at(mesh, mesh.vertices(name)))
                 for mesh in self._meshes for name in (*mesh.edges, *mesh.points)]
        on: dict[str, set[int]] = {}
        for name, where in chain.from_iterable(self.comm.allgather(here)):
            on.setdefault(name, set()).update(where)
        names = sorted(on, key=lambda name: len(on[name]))
        return [listed([repr(name) for name in names if piece in on[name]], SHOWN) for piece in sorted(wanted)]


def _vertices_of(mesh: NamedMesh, name: str | None) -> np.ndarray:
    return np.unique(_corners(mesh)) if name is None else mesh.vertices(name)


def _corners(mesh: NamedMesh) -> np.ndarray:
    """Vertices of each cell of this process."""
    corners = mesh.domain.topology.connectivity(mesh.domain.topology.dim, 0)
    return corners.array.reshape(corners.num_nodes, -1) if corners.num_nodes else np.empty((0, 2), dtype=np.int32)


def _at_same_places(one: NamedMesh, other: NamedMesh, numbers: Callable) -> np.ndarray:
    """Pairs of numbers of vertices of two meshes that stand at one place, of all processes."""
    comm, known = one.comm, []
    for mesh in (one, other):
        owned = np.arange(mesh.domain.topology.index_map(0).size_local, dtype=np.int32)
        x = compute_midpoints(mesh.domain, 0, owned)
        known.append([np.concatenate(parts) for parts in zip(*comm.allgather((numbers(mesh, owned), x)), strict=True)])
    (here, x), (there, y) = known
    near = cKDTree(x).query_ball_tree(cKDTree(y), SAME_PLACE * max(one.size, other.size))
    pairs = [(here[i], there[j]) for i, found in enumerate(near) for j in found]
    return np.array(pairs, dtype=np.int64).reshape(-1, 2)


def straight_joints(mesh: NamedMesh) -> int:
    """Number of nodes at which two straight cells and no others meet in one line, on all processes."""
    met: dict[int, list[np.ndarray]] = {}
    for nodes, along in zip(geometry_nodes(mesh.domain)[mesh.group(None), :2], mesh.chords(None), strict=True):
        for node in nodes:
            met.setdefault(int(node), []).append(along)
    straight = [len(chords) == 2 and abs(chords[0] @ chords[1]) > 1 - 1e-9 for chords in met.values()]
    return mesh.comm.allreduce(sum(straight))
