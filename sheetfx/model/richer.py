"""The same structure with polynomials of one degree more on the same cells, and cells that are curved by one more."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import basix.ufl
import numpy as np
from mpi4py import MPI

from ..compat import geometry_nodes
from ..mesh.reader import NamedMesh, Reading
from .beam import Bar, Beam
from .shell import Shell, richer_form

MOST, MOST_CURVED = 4, 3  # degree of a beam, and of the geometry of cells
STRAIGHT = 1e-9  # distance of nodes from where corners put them, over the size of the structure, that is rounding


class NothingRicher(ValueError):
    """A part has no discretisation of one degree more."""


def richer(parts: Sequence[Beam | Bar | Shell]) -> dict[Any, Any]:
    """Meshes and parts -> the same with one degree more; straight bars are exact, and so are cells of straight lines.

    Raises
    ------
    NothingRicher
    """
    meshes = _richer_meshes(parts)
    found: dict[Any, Any] = dict(meshes)
    for part in parts:
        mesh = meshes.get(part.mesh, part.mesh)
        if isinstance(part, Shell):
            form = richer_form(part.discrete)
            if form is None:
                raise NothingRicher(f"there is no form of shells of a higher degree than {part.form or 'its own'!r}")
            found[part] = replace(part, mesh=mesh, form=form)
        elif isinstance(part, Beam):
            if part.degree >= MOST:
                raise NothingRicher(f"there are no beams of a higher degree than {part.degree}")
            found[part] = replace(part, mesh=mesh, degree=part.degree + 1)
    return found


def _richer_meshes(parts: Sequence[Beam | Bar | Shell]) -> dict[NamedMesh, NamedMesh]:
    """Meshes whose geometry bends their cells -> the same read again with one order more."""
    with_bars = {id(part.mesh) for part in parts if isinstance(part, Bar)}
    found: dict[NamedMesh, NamedMesh] = {}
    for meshes in _read_together(parts):
        order = 1 + max(mesh.degree for mesh, _ in meshes)
        if order > MOST_CURVED or any(id(mesh) in with_bars for mesh, _ in meshes):
            continue
        pairs = _again(meshes, order, 0)
        if all(_count(one) == _count(other) for one, other in pairs.items()) and any(map(_bends, pairs.values())):
            found.update(pairs)
    return found


def _read_together(parts: Sequence[Beam | Bar | Shell]) -> list[list[tuple[NamedMesh, Reading]]]:
    """Meshes that can be read again, one gmsh model's together."""
    together: dict[int, list[tuple[NamedMesh, Reading]]] = {}
    for mesh in dict.fromkeys(part.mesh for part in parts):
        if mesh.reading is not None:
            together.setdefault(id(mesh.reading.again), []).append((mesh, mesh.reading))
    return list(together.values())


def _again(meshes: list[tuple[NamedMesh, Reading]], order: int, halvings: int) -> dict[NamedMesh, NamedMesh]:
    """Meshes of one gmsh model -> the same read again."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # what there is to say of the model has been said
        again = meshes[0][1].again(order, halvings)
    found = {mesh: again[reading.number] for mesh, reading in meshes}
    for one, other in found.items():
        other.name_as(one)
    return found


def finer(parts: Sequence[Beam | Bar | Shell], halvings: int = 1) -> dict[NamedMesh, NamedMesh]:
    """Meshes -> the same with all cells divided in two along each side, but for bars, which are exact.

    Raises
    ------
    NothingRicher
        Where only the cells of a mesh are known, or nothing but bars is there.
    """
    meshes = _read_together([part for part in parts if not isinstance(part, Bar)])
    known = {mesh for group in meshes for mesh, _ in group}
    others = [part for part in parts if not isinstance(part, Bar) and part.mesh not in known]
    if others or not meshes:
        raise NothingRicher("cells cannot be halved: " + (
            f"of the mesh of {', '.join(others[0].mesh.cells)} nothing is known but its cells" if others else
            "there are only bars"))
    return {one: other for group in meshes for one, other in
            _again(group, max(mesh.degree for mesh, _ in group), halvings).items()}


def _count(mesh: NamedMesh) -> int:
    return mesh.domain.topology.index_map(mesh.domain.topology.dim).size_global


def _bends(mesh: NamedMesh) -> bool:
    """Whether cells are curved: their nodes stand beside where their corners would put them."""
    nodes, cell = geometry_nodes(mesh.domain), mesh.domain.basix_cell()
    element = basix.ufl.element("P", cell.name, mesh.degree).basix_element
    shares = basix.ufl.element("P", cell.name, 1).basix_element.tabulate(0, element.points)[0, :, :, 0]
    x = mesh.domain.geometry.x[nodes]
    off = np.abs(x - shares @ x[:, :shares.shape[1]]).max(initial=0.0)
    return bool(mesh.comm.allreduce(off, op=MPI.MAX) > STRAIGHT * mesh.size)
