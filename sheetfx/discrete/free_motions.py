"""Why the tangent of an unloaded structure cannot be solved: no numbers, or motions without stiffness, by name.

Free motions are null vectors of the tangent in which each unknown counts in units of its own stiffness, S K S with
S = 1 / sqrt(diag K), so that units of lengths and forces do not matter.
"""

from __future__ import annotations

import numpy as np
from dolfinx.mesh import compute_midpoints
from petsc4py import PETSc
from scipy.sparse import csr_array, diags_array, eye_array
from scipy.sparse.linalg import LinearOperator, eigs, eigsh, splu

from ..model.advice import advice_on_supports
from ..model.scene import part_named
from .contribution import Forces
from .motion_words import motions_in_words, rigid_motions_in_words, words_of_place

ROUNDED = 1e3 * np.finfo(float).eps  # stiffness over the diagonal that sums of hundreds of entries round to
MOST = 12  # motions that are looked for: the rigid ones of two pieces in space


def why_singular(discretisation) -> str:
    """Why the tangent of the present state is singular, and what to do about it; called on all processes."""
    if unfinished := without_numbers(discretisation, "in the first state"):
        return (f"{unfinished}; look at its strains and law there (a division by zero, or the root of zero, at rest) "
                "and at its numbers")
    begin, advice = "the unloaded structure can move freely (its tangent is singular)", advice_on_supports(
        discretisation.scene)
    if discretisation.system.comm.size > 1:
        return f"{begin}: {advice}; run it on one process to have the free motion named"
    if (stages := discretisation.stages) and not stages[0].at_once:
        advice += f", or let stage {stages[0].name!r} begin with at_once=True if its loads do"
    found = null_vectors(discretisation)
    if free := rigid_motions_in_words(discretisation, found):
        return f"{begin}: {free}; {advice}"
    if thin := _too_thin(discretisation):
        return thin
    words = motions_in_words(discretisation, found)
    return f"{begin}: {words}" + ("" if words.startswith("rotations") else f"; {advice}")


def usual_stiffness(discretisation) -> PETSc.Vec:
    """For each unknown the median of the assembled tangent's diagonal over the unknowns of its field.

    A penalty at a few nodes, as of contact, does not change a median. It is 0 for fixed unknowns, and for fields with
    negative entries, such as multipliers, of which a diagonal says nothing.
    """
    system, layout = discretisation.system, discretisation.layout
    found = system.create_vector()
    system.matrix.getDiagonal().copy(found)
    found.array[system.fixed_rows] = 0
    arrays = layout.arrays(found)
    for field, array in layout.fields(arrays):
        entries = np.concatenate(system.comm.allgather(array[field.dofs]))
        stiff = entries[entries > 0]
        array[field.dofs] = np.median(stiff) if len(stiff) and not (entries < 0).any() else 0.0
    layout.put(arrays, found)
    found.array[system.fixed_rows] = 0
    return found


def null_vectors(discretisation) -> np.ndarray:
    """Orthonormal null vectors of the assembled tangent, in roots of its diagonal; shape (rows, vectors).

    At least the one nearest to one is returned. On one process only.
    """
    system = discretisation.system
    start, columns, values = system.matrix.getValuesCSR()
    full = csr_array((values, columns, start))
    free = np.setdiff1d(np.arange(full.shape[0]), system.fixed_rows)
    matrix = full[free][:, free]
    roots, usual = np.sqrt(np.abs(matrix.diagonal())), np.sqrt(usual_stiffness(discretisation).array[free])
    roots = np.where(roots < np.finfo(float).eps ** 0.5 * usual, usual, roots)
    stiff = roots > 0
    scale = np.where(stiff, 1 / np.where(stiff, roots, 1.0), 0.0)
    coupled = abs(matrix @ diags_array(scale)).max(axis=1).toarray()
    scale[~stiff] = 1 / np.where(coupled[~stiff] > 0, coupled[~stiff], 1.0)
    scaled = (diags_array(scale) @ matrix @ diags_array(scale)).tocsc()
    size = len(free)
    if size <= 3 * MOST:
        _, values, right = np.linalg.svd(scaled.toarray())
        vectors = right.T[:, ::-1]
        values = values[::-1]
    else:
        factor = splu((scaled + ROUNDED * eye_array(size)).tocsc())
        inverse = LinearOperator((size, size), matvec=factor.solve)
        solve = eigsh if system.conservative else eigs
        begin = np.cos(np.arange(size, dtype=float) ** 2)
        values, vectors = solve(scaled, MOST, sigma=-ROUNDED, OPinv=inverse, v0=begin)
        order = np.argsort(abs(values))
        values, vectors = values[order].real, vectors[:, order].real
    count = max(1, int((abs(values[:MOST]) <= ROUNDED).sum()))
    found = np.zeros((full.shape[0], count))
    found[free] = scale[:, None] * vectors[:, :count]
    return found


def _too_thin(discretisation) -> str:
    """Which shell is so thin that its bending stiffness rounds beside its membrane stiffness; "": none."""
    for part, work in zip(discretisation.scene.parts, discretisation.works_of_parts, strict=True):
        thickness = getattr(getattr(part, "section", None), "thickness", None)
        if part.mesh.domain.topology.dim != 2 or not isinstance(thickness, float):
            continue
        ratio, least = thickness / part.mesh.size, (ROUNDED * max(len(work.internal.cells), 1)) ** 0.5
        if ratio <= least:
            return (f"{part_named(part)}: thickness is {thickness:g}, {ratio:.2g} of its size {part.mesh.size:g}: its "
                    f"bending stiffness is {ratio**2:.1g} of its membrane stiffness, which double precision cannot "
                    f"hold; give it at least {least:.1g} of its size on this mesh")
    return ""


def without_numbers(discretisation, when: str) -> str:
    """Which contribution has infinite or no numbers in its forces or tangent now, and where; "": none.

    Called on all processes; `when` says of which state it tells.
    """
    system, scene = discretisation.system, discretisation.scene
    found, layout = "", discretisation.layout
    sizes = [part.mesh.size for part in scene.parts]  # which all processes find together
    for number, work in enumerate(system.contributions):
        held, forces = (Forces(discretisation.unknowns, layout) for _ in range(2))
        work.residual(forces)
        values = np.concatenate([np.empty(0), *(np.ravel(v) for v in work.tangent(held))])
        rows = work.pattern(layout)[0] if len(values) else np.empty(0, dtype=np.int64)
        wrong = np.unique(rows[~np.isfinite(values)])
        bent = any((v := forces.given(i)) is not None and not np.isfinite(v).all()
                   for i in range(len(system.unknowns.fields)))
        bent = bent or not all(np.isfinite(a).all() for a in forces.along_space)
        if (len(wrong) or bent) and not found:
            part = scene.parts[number] if number < len(scene.parts) else None
            name = part_named(part) if part else work.called or type(work).__name__
            what = f"tangent {when} is not a finite number" if len(wrong) else f"forces {when} are not finite numbers"
            found = f"{name}: its {what}" + (
                _where(discretisation, part, sizes[number], wrong, forces) if part else "")
    return next(filter(None, system.comm.allgather(found)), "")


def _where(discretisation, part, size: float, wrong: np.ndarray, forces: Forces) -> str:
    """A cell of a part all of whose nodes have no numbers, in rows of the tangent or else in forces, and its place."""
    mesh, field = part.mesh, discretisation.kinematics(part.mesh).block.fields[0]
    layout, number = discretisation.layout, discretisation.unknowns.fields.index(field)
    numbers = layout.free_numbers[number]
    if len(wrong):
        without = (np.isin(numbers, wrong) | (numbers < 0)).all(axis=1)
    else:
        without = ~np.isfinite(layout.fields(forces.spatial(layout))[number][1][field.dofs]).reshape(
            numbers.shape).all(axis=1)
    cells = mesh.group(part.group)
    inside = without[field.value.function_space.dofmap.list[cells]].all(axis=1)
    if not inside.any():
        return ""
    cell = cells[np.flatnonzero(inside)[:1]]
    place = compute_midpoints(mesh.domain, mesh.domain.topology.dim, cell.astype(np.int32))[0]
    return f" in {int(inside.sum())} of {len(cells)} cells, first in cell {cell[0]} at " + words_of_place(
        place[:mesh.dimension], size)
