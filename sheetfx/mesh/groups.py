"""Names and cells of the physical groups of a gmsh model."""

from __future__ import annotations

import numpy as np

from .cells import KINDS, Cells

ORDERS = 1, 2, 3
DIMENSIONS = {0: "points", 1: "curves", 2: "surfaces", 3: "volumes"}
ONE_KIND = {1: "", 2: ": quadrilaterals by Mesh.RecombineAll = 1 and Mesh.RecombinationAlgorithm = 3 (or "
            "Mesh.SubdivisionAlgorithm = 1), triangles by Mesh.RecombineAll = 0; or read both with read_kinds"}
TOGETHER = (2, 3), (9, 10), (21, 36)  # gmsh's numbers of triangles and quadrilaterals of one order


def name_of(model, dimension: int, tag: int) -> str:
    """Of a physical group; its number where it has none, with its dimension where another one's has that number.

    gmsh counts the groups of each dimension from 1.
    """
    if name := model.getPhysicalName(dimension, tag):
        return name
    groups = model.getPhysicalGroups()
    numbers = [number for d, number in groups if not model.getPhysicalName(d, number)]
    clash = len(set(numbers)) < len(numbers) and any(d == 2 for d, _ in groups)
    return f"{DIMENSIONS[dimension][:-1]} {tag}" if clash else str(tag)


def cells_of(model, dimension: int, what: str, several: bool) -> list[Cells]:
    """Cells in the groups of a dimension, of each kind that there is; nodes count from 0."""
    found: dict[int, Cells] = {}
    labels: dict[int, tuple[str, str]] = {}
    groups = {}
    for _, tag in model.getPhysicalGroups(dimension):
        name = name_of(model, dimension, tag)
        entities = groups.setdefault(name, [])
        entities += [int(e) for e in model.getEntitiesForPhysicalGroup(dimension, tag) if e not in entities]
        for entity in entities:
            kinds, _, tables = model.mesh.getElements(dimension, entity)
            if not len(kinds):
                raise ValueError(f"{what}: a part of the group {name!r} has no cells; mesh it, or remove it; save the "
                                 "pieces of a partition as one file")
            for kind, table in zip(map(int, kinds), tables, strict=True):
                label, _, _, size, _, _ = model.mesh.getElementProperties(kind)
                if kind not in KINDS:
                    raise ValueError(f"{what}: the group {name!r} has cells {label!r}; only complete intervals, "
                                     f"triangles and quadrilaterals of order {ORDERS[0]} to {ORDERS[-1]} can be read")
                labels.setdefault(kind, (name, label))
                _check_kinds(what, dimension, labels, several)
                cells = found.setdefault(kind, Cells({}, {}, kind))
                cells.nodes[entity] = table.reshape(-1, size).astype(np.int64) - 1
    for cells in found.values():
        cells.groups = {name: own for name, on in groups.items() if (own := [e for e in on if e in cells.nodes])}
    return [found[kind] for kind in sorted(found)] or [Cells({}, {})]


def _check_kinds(what: str, dimension: int, labels: dict[int, tuple[str, str]], several: bool) -> None:
    """Refuse cells of several kinds, but for triangles and quadrilaterals of one order where both are read."""
    if len(labels) == 1 or (several and tuple(sorted(labels)) in TOGETHER):
        return
    (first, one), *_, (name, label) = labels.values()
    remedy = (", or triangles and quadrilaterals of one order (setOrder)" if several and dimension == 2 else
              ONE_KIND[dimension])
    raise ValueError(f"{what}: mixed kinds of cells, {one!r} in the group {first!r} and {label!r} in {name!r}; mesh "
                     f"all {DIMENSIONS[dimension]} with one kind{remedy}")
