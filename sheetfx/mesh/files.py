"""Meshes of other programs' files, as meshio reads them: cells, their sets, and sets of nodes as edges and points."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ..notices import listed
from .cells import KINDS, Cells
from .groups import DIMENSIONS

SUFFIXES = ".inp", ".med", ".fem", ".vtk", ".vtu", ".xdmf", ".mesh", ".ply", ".off", ".stl", ".obj"
# meshio's names of cells: dimension, gmsh's number of the kind, and of such with eight nodes that of nine
READ = {"line": (1, 1), "line3": (1, 8), "line4": (1, 26), "triangle": (2, 2), "triangle6": (2, 9),
        "triangle10": (2, 21), "quad": (2, 3), "quad9": (2, 10), "quad16": (2, 36), "quad8": (2, 10)}
SERENDIPITY = np.array([-0.25] * 4 + [0.5] * 4)  # of eight nodes, the place of the middle
TAGS = "cell_tags", "nastran:ref", "medit:ref", "CellEntityIds"  # data of cells whose numbers are groups
SHOWN = 5


def model_parts(file: Path, what: str) -> tuple[np.ndarray, Cells, list[Cells], dict[str, np.ndarray], str]:
    """Places of nodes, curves, surfaces of each kind, points, and what was left out, in words.

    Sets of nodes become edges, where they hold both ends of sides of surfaces, else points; those with the name of a
    set of cells are left to it. Cells without any set make a group of their own.

    Raises
    ------
    ValueError
        If meshio is missing or cannot read the file, or it has no curves or surfaces.
    """
    try:
        import meshio
    except ImportError as error:
        raise ValueError(f"{what}: files of this kind are read by meshio, which is not installed; install it, or save "
                         "the mesh from gmsh as .msh") from error
    try:
        mesh = meshio.read(file)
    except (Exception, SystemExit) as error:
        said = " ".join(str(error).split()) or type(error).__name__
        raise ValueError(f"{what}: meshio cannot read the file ({said}); save it as .msh, .inp or .med") from error
    x = np.zeros((len(mesh.points), 3))
    if len(x):
        x[:, :mesh.points.shape[1]] = mesh.points
    blocks, left = [], {}
    for number, block in enumerate(mesh.cells):
        if block.type in READ and len(block.data):
            nodes = np.asarray(block.data, dtype=np.int64)
            if block.type == "quad8":
                middles = np.einsum("k,nkd->nd", SERENDIPITY, x[nodes])
                nodes = np.column_stack((nodes, len(x) + np.arange(len(nodes))))
                x = np.concatenate([x, middles])
            blocks.append((number, *READ[block.type], nodes))
        elif block.type != "vertex":
            left[block.type] = left.get(block.type, 0) + len(block.data)
    if not blocks:
        raise ValueError(f"{what}: has no lines, triangles or quadrilaterals"
                         f"{', only ' + _counted(left) if left else ''}; export the curves and surfaces of the model")
    cells = _cells(mesh, blocks)
    curves, surfaces = cells.get(1) or [Cells({}, {})], cells.get(2) or [Cells({}, {})]
    if len(curves) > 1:
        raise ValueError(f"{what}: lines of several orders; save all with one order")
    points, edges, lost = _node_sets(mesh, surfaces, {name for c in (*curves, *surfaces) for name in c.groups})
    if edges and curves[0].kind not in (None, 1):
        lost, edges = [*lost, *edges], {}
    for name, pairs in edges.items():
        entity = max([0, *curves[0].nodes]) + 1
        curves[0].nodes[entity], curves[0].groups[name], curves[0].kind = pairs, [entity], 1
    said = [f"{_counted(left)} left out"] if left else []
    if lost:
        said.append(f"sets of nodes without a side or point of their own left out: {listed(sorted(lost), SHOWN)}")
    return x, curves[0], surfaces, points, "; ".join(said)


def _counted(left: Mapping[str, int]) -> str:
    return listed([f"{count} cells {kind!r}" for kind, count in left.items()], SHOWN)


def _sets_of(mesh: Any, number: int) -> dict[str, np.ndarray]:
    """Cells of a block in each set of cells."""
    found = {name: np.asarray(own[number], dtype=np.int64) for name, own in mesh.cell_sets.items()
             if own[number] is not None and len(own[number])}
    if found:
        return found
    names = getattr(mesh, "cell_tags", None) or {}
    for data in (mesh.cell_data[tag][number] for tag in TAGS if tag in mesh.cell_data):
        tags = np.asarray(data).ravel().astype(np.int64)
        for tag in np.unique(tags):
            for name in names.get(int(tag), [] if names else [str(tag)]):
                found[name] = np.union1d(found.get(name, np.empty(0, dtype=np.int64)), np.flatnonzero(tags == tag))
    return found


def _cells(mesh: Any, blocks: Sequence[tuple[int, int, int, np.ndarray]]) -> dict[int, list[Cells]]:
    """Cells of each dimension and kind; those that are in the same sets are one entity."""
    made: dict[int, Cells] = {}
    for number, dimension, kind, nodes in blocks:
        cells, own = made.setdefault(kind, Cells({}, {}, kind)), _sets_of(mesh, number)
        member = np.zeros((len(nodes), len(own)), dtype=bool)
        for column, chosen in enumerate(own.values()):
            member[chosen, column] = True
        for pattern in np.unique(member, axis=0) if own else member[:1]:
            entity = sum(len(c.nodes) for c in made.values()) + 1
            cells.nodes[entity] = nodes[(member == pattern).all(axis=1)]
            inside = [name for name, chosen in zip(own, pattern, strict=True) if chosen]
            for name in inside or [f"{DIMENSIONS[dimension]} without a set" if own else DIMENSIONS[dimension]]:
                cells.groups.setdefault(name, []).append(entity)
    found: dict[int, list[Cells]] = {}
    for kind in sorted(made):
        found.setdefault(1 if KINDS[kind][1] == 2 else 2, []).append(made[kind])
    return found


def _node_sets(mesh: Any, surfaces: Sequence[Cells],
               known: set[str]) -> tuple[dict[str, np.ndarray], dict[str, np.ndarray], list[str]]:
    """Points, and edges as pairs of nodes, that sets of nodes stand for, and sets that are neither."""
    points, edges, lost = {}, {}, []
    sides = [np.sort(cells.sides(), axis=1) for cells in surfaces if cells.nodes]
    every, counts = np.unique(np.concatenate([np.empty((0, 2), dtype=np.int64), *sides]), axis=0, return_counts=True)
    corners = np.unique(every)
    for name, given in _named_nodes(mesh).items():
        if name in known:
            continue
        inside = np.isin(every, given).all(axis=1)
        border = inside & (counts == 1)
        if inside.any():
            edges[name] = every[border if border.any() else inside]
        elif len(own := np.intersect1d(given, corners) if len(corners) else given):
            points[name] = own
        else:
            lost.append(name)
    return points, edges, lost


def _named_nodes(mesh: Any) -> dict[str, np.ndarray]:
    found = {name: np.asarray(nodes, dtype=np.int64).ravel() for name, nodes in mesh.point_sets.items()}
    tags = getattr(mesh, "point_tags", None) or {}
    if "point_tags" in mesh.point_data:
        numbers = np.asarray(mesh.point_data["point_tags"]).ravel()
        for tag, names in tags.items():
            for name in names:
                own = np.flatnonzero(numbers == tag)
                found[name] = np.union1d(found.get(name, np.empty(0, dtype=np.int64)), own)
    return found
