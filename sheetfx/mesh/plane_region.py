"""Triangles of second order on a plane region between polygons, by gmsh."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

SECOND_ORDER = 9  # gmsh's number of triangles with six nodes


def triangulate(rings: Sequence[np.ndarray], size: float) -> tuple[np.ndarray, np.ndarray]:
    """Mesh of straight triangles with nodes in the middles of their edges.

    Parameters
    ----------
    rings : corners of the outer polygon and of holes, each of shape (corners, 2)
    size : of the triangles' edges

    Returns
    -------
    places of the nodes, shape (nodes, 2), and nodes of the triangles, shape (cells, 6), in the order of gmsh: corners,
    then the middles of the edges 0-1, 1-2 and 2-0.
    """
    import gmsh

    mine = not gmsh.isInitialized()
    before = None if mine else gmsh.model.getCurrent()
    if mine:
        gmsh.initialize(interruptible=False)
        gmsh.option.setNumber("General.Terminal", 0)
    gmsh.model.add("plane region")
    try:
        gmsh.model.geo.addPlaneSurface([_loop(gmsh.model.geo, ring, size) for ring in rings])
        gmsh.model.geo.synchronize()
        gmsh.model.mesh.generate(2)
        gmsh.model.mesh.setOrder(2)
        numbers, x, _ = gmsh.model.mesh.getNodes()
        _, nodes = gmsh.model.mesh.getElementsByType(SECOND_ORDER)
    finally:
        if mine:
            gmsh.finalize()
        else:
            gmsh.model.remove()
            gmsh.model.setCurrent(before)
    used, cells = np.unique(nodes.reshape(-1, 6), return_inverse=True)
    order = np.argsort(numbers)
    return x.reshape(-1, 3)[order[np.searchsorted(numbers[order], used)], :2], cells.reshape(-1, 6)


def _loop(geometry, ring: np.ndarray, size: float) -> int:
    points = [geometry.addPoint(*corner, 0.0, size) for corner in ring]
    after = points[1:] + points[:1]
    return geometry.addCurveLoop([geometry.addLine(*pair) for pair in zip(points, after, strict=True)])


def refined(x: np.ndarray, cells: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The mesh whose triangles are the four in each of a mesh of straight triangles of second order."""
    small = cells[:, [[0, 3, 5], [3, 1, 4], [5, 4, 2], [3, 4, 5]]].reshape(-1, 3)
    edges = np.sort(small[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    edges, middles = np.unique(edges, axis=0, return_inverse=True)
    return np.vstack((x, x[edges].mean(axis=1))), np.hstack((small, len(x) + middles.reshape(-1, 3)))
