"""Motions of a structure's nodes in words: which parts move as rigid bodies, which nodes, which rotations."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components

from ..model.scene import part_named
from ..notices import listed

CLOSE = 1e-4  # of a motion's size, deviation from what its words say: null vectors are exact to about 1e-6
FEW = 3  # parts that words name one by one
AXES = "xyz"


@dataclass(frozen=True, eq=False)
class Moving:
    """Motions of a part, one in each column.

    Attributes
    ----------
    places, displacements : of its nodes, shapes (nodes, 3) and (nodes, 3, motions), in sizes of the structure
    spin_places, spins : of its nodes with rotations; in the plane about the third axis
    """

    part: object
    name: str
    places: np.ndarray
    displacements: np.ndarray
    spin_places: np.ndarray
    spins: np.ndarray

    def combined(self, coefficients: np.ndarray) -> Moving:
        """Linear combinations of its motions, one for each column."""
        return Moving(self.part, self.name, self.places, self.displacements @ coefficients, self.spin_places,
                      self.spins @ coefficients)


def motions_in_words(discretisation, vectors: np.ndarray) -> str:
    """One motion of those that vectors of the system span on one process, by parts, directions and places.

    It is the one that the node that moves most takes part in most; rotations alone are told where nothing else moves.

    Parameters
    ----------
    vectors : shape (rows, motions)
    """
    size = max(mesh.size for mesh in discretisation.scene.meshes)
    return _mechanism(list(_of_parts(discretisation, vectors, size)), vectors.shape[1], size)


def rigid_motions_in_words(discretisation, vectors: np.ndarray) -> str:
    """Rigid motions of connected parts among those that vectors of the system span on one process; "": none.

    Parameters
    ----------
    vectors : shape (rows, motions)
    """
    size = max(mesh.size for mesh in discretisation.scene.meshes)
    told = _free_bodies(discretisation, list(_of_parts(discretisation, vectors, size)), vectors.shape[1], size)
    more = len(told) - FEW
    return "; ".join(told[:FEW]) + (f"; and {more} more" if more > 0 else "")


def _of_parts(discretisation, vectors: np.ndarray, size: float) -> Iterator[Moving]:
    system, fields = discretisation.system, discretisation.unknowns.fields
    names = _names(discretisation.scene.parts)
    steps = [system.motions(system.create_vector(np.ascontiguousarray(column))) for column in vectors.T]
    for part in discretisation.scene.parts:
        k, found = discretisation.kinematics(part.mesh), []
        for field in k.block.fields:
            space, number = field.value.function_space, fields.index(field)
            nodes = np.unique(space.dofmap.list[part.mesh.group(part.group)])
            table = np.stack([step[number][nodes] for step in steps], axis=-1)
            whole = np.zeros((len(nodes), 3, len(steps)))
            if table.shape[1] == 1:
                whole[:, 2:] = table
            else:
                whole[:, :table.shape[1]] = table
            found += [space.tabulate_dof_coordinates()[nodes], whole]
        if len(found) == 2:
            found += [np.empty((0, 3)), np.empty((0, 3, len(steps)))]
        found[1] = found[1] / size
        yield Moving(part, names[part], *found)


def _bodies(discretisation) -> list[list]:
    """Parts that the tangent's entries connect, directly or by others."""
    system = discretisation.system
    start, columns, values = system.matrix.getValuesCSR()
    graph = csr_array((np.abs(values), columns, start))
    graph.eliminate_zeros()
    pieces = connected_components(graph, directed=False)[1]
    free, parts = discretisation.layout.free_numbers, discretisation.scene.parts
    on = []
    for part in parts:
        k, rows = discretisation.kinematics(part.mesh), []
        for field in k.block.fields:
            nodes = np.unique(field.value.function_space.dofmap.list[part.mesh.group(part.group)])
            rows.append(free[discretisation.unknowns.fields.index(field)][nodes].ravel())
        numbers = np.concatenate(rows)
        on.append(set(pieces[numbers[numbers >= 0]].tolist()))
    left, found = list(range(len(parts))), []
    while left:
        body = [left.pop(0)]
        while more := [i for i in left if any(on[i] & on[j] for j in body)]:
            body += more
            left = [i for i in left if i not in more]
        found.append([parts[i] for i in sorted(body)])
    return found


def _free_bodies(discretisation, moving: list[Moving], motions: int, size: float) -> list[str]:
    """Rigid motions of connected parts among all motions, a sentence for each body that has some."""
    told, bodies = [], _bodies(discretisation)
    for body in bodies:
        mine = [m for m in moving if m.part in body]
        rigid, centre = _rigid_among(mine, [m for m in moving if m.part not in body], motions, size)
        if rigid.shape[1]:
            whole = len(bodies) == 1
            rest = [m.name for m in moving if m.part not in body]
            name = "the structure" if whole else "the " + listed([m.name for m in mine], FEW, " and the ")
            others = listed(rest, FEW, " and the ")
            apart = "" if whole else f", which nothing joins to the {others},"
            told.append(f"{name}{apart} {_rigid_words(rigid, centre, size, _dimension(body))}")
    return told


def _dimension(parts) -> int:
    return parts[0].mesh.dimension


def _rigid_among(mine: list[Moving], others: list[Moving], motions: int, size: float) -> tuple[np.ndarray, np.ndarray]:
    """Rigid motions (translation and rotation about a centre) that are combinations of the motions, others at rest.

    Returns
    -------
    array, shape (6, count), and the centre
    """
    places = np.concatenate([m.places for m in mine])
    centre = (places.max(axis=0) + places.min(axis=0)) / 2
    ours = np.concatenate([m.displacements.reshape(-1, motions) for m in mine])
    theirs = np.concatenate([np.empty((0, motions)), *(m.displacements.reshape(-1, motions) for m in others)])
    basis, values, _ = np.linalg.svd(np.concatenate((ours, theirs)), full_matrices=False)
    basis = basis[:, values > CLOSE * values.max(initial=0.0)]
    body = _rigid(places, centre, size)
    directions, values, right = np.linalg.svd(body, full_matrices=False)
    kept = values > CLOSE * values.max()
    common, cosines, _ = np.linalg.svd(directions[:, kept].T @ basis[:len(ours)], full_matrices=False)
    found = (right[kept].T / values[kept]) @ common[:, cosines > 1 - CLOSE**2 / 2]
    return np.linalg.qr(found)[0], centre


def _rigid(places: np.ndarray, centre: np.ndarray, size: float) -> np.ndarray:
    """Displacements of places in six rigid motions, in sizes; shape (3 places, 6)."""
    arms, columns = (places - centre) / size, []
    for axis in np.eye(3):
        columns.append(np.broadcast_to(axis, arms.shape).ravel())
    for axis in np.eye(3):
        columns.append(np.cross(axis, arms).ravel())
    return np.column_stack(columns)


def _rigid_words(rigid: np.ndarray, centre: np.ndarray, size: float, dimension: int) -> str:
    """A space of rigid motions: translations along axes, and rotations about axes."""
    count = rigid.shape[1]
    if count == (6 if dimension == 3 else 3):
        return "can move along and turn about every axis"
    slides = rigid @ _kernel(rigid[3:])
    words = [f"can move along {_along(slides[:3])}"] if slides.shape[1] else []
    turns = rigid @ _kernel(slides.T @ rigid) if slides.shape[1] else rigid
    if turns.shape[1] == 3:
        arms = np.concatenate([np.cross(omega, np.eye(3)).T for omega in turns[3:].T])
        fixed = np.linalg.lstsq(arms, -turns[:3].T.ravel(), rcond=None)[0]
        place = words_of_place(centre + size * fixed, size)
        return " and ".join([*words, f"can turn about every axis through {place}"])
    axes = [i for i, axis in enumerate(np.eye(3))
            if np.linalg.norm(axis - turns[3:] @ np.linalg.lstsq(turns[3:], axis, rcond=None)[0]) < CLOSE]
    if len(axes) == turns.shape[1]:
        turns = turns @ np.linalg.lstsq(turns[3:], np.eye(3)[:, axes], rcond=None)[0]
    seen = []
    for a in turns.T:
        omega, shift = a[3:], a[:3]
        through = centre + size * np.cross(omega, shift) / (omega @ omega)
        seen.append("about " + (f"{_direction(omega)} through " if dimension == 3 else "")
                    + words_of_place(through[:dimension], size))
    return " and ".join(words + ([f"can turn {' and '.join(seen)}"] if seen else []))


def _kernel(matrix: np.ndarray) -> np.ndarray:
    """Orthonormal combinations of the columns, which are of unit size, that vanish."""
    _, values, right = np.linalg.svd(matrix)
    return right[int((values > CLOSE).sum()):].T


def _along(directions: np.ndarray) -> str:
    """Directions that some vectors span, by axes where they are such."""
    basis, values, _ = np.linalg.svd(directions, full_matrices=False)
    basis = basis[:, values > CLOSE]
    axes = [name for name, axis in zip(AXES, np.eye(3), strict=True)
            if np.linalg.norm(axis - basis @ (basis.T @ axis)) < CLOSE]
    return " and ".join(axes if len(axes) == basis.shape[1] else map(_direction, basis.T))


def _direction(vector: np.ndarray) -> str:
    vector = vector / np.linalg.norm(vector)
    axis = np.argmax(np.abs(vector))
    if np.abs(np.delete(vector, axis)).max() < CLOSE:
        return AXES[axis]
    return words_of_place(vector * np.sign(vector[axis]))


def _mechanism(moving: list[Moving], motions: int, size: float) -> str:
    """One motion that is rigid for no body: the one that one node takes most of."""
    moves, turns = ([getattr(m, name).reshape(-1, motions) for m in moving] for name in ("displacements", "spins"))
    largest, spins = (max(np.abs(rows).max(initial=0.0) for rows in kind) for kind in (moves, turns))
    kind = "moves" if largest > CLOSE * spins else "turns"
    rows = np.concatenate(moves if kind == "moves" else turns)
    chosen = rows[np.argmax(np.linalg.norm(rows, axis=1))]
    found = [m.combined(chosen[:, None] / (chosen @ chosen)) for m in moving]
    if kind == "turns":
        return _turning_words(found, size)
    unit = max(np.abs(m.displacements).max(initial=0.0) for m in found)
    acting = [m for m in found if np.abs(m.displacements).max(initial=0.0) > CLOSE * unit]
    told = []
    for m in acting:
        rigid, centre = _rigid_among([m], [], 1, size) if len(moving) > 1 else (np.empty((6, 0)), None)
        how = (_rigid_words(rigid, centre, size, _dimension([m.part])).replace("can move", "moves").replace(
            "can turn", "turns") if rigid.shape[1] else _nodes_words(m, size))
        told.append(f"the {m.name} {how}")
    return ", ".join(told[:FEW]) + (f", and {len(told) - FEW} more parts move" * (len(told) > FEW))


def _nodes_words(moving: Moving, size: float) -> str:
    """The node that moves most."""
    lengths = np.linalg.norm(moving.displacements[..., 0], axis=1)
    most = int(np.argmax(lengths))
    count = int((lengths > lengths[most] / 2).sum())
    dimension = _dimension([moving.part])
    return (f"moves most at {words_of_place(moving.places[most, :dimension], size)} along "
            f"{_direction(moving.displacements[most, :, 0])}" + (f", {count} nodes at least half as far" * (count > 1)))


def _turning_words(found: list[Moving], size: float) -> str:
    """Rotations without displacements: of which part, about its normal or its axis."""
    most = max(found, key=lambda m: np.linalg.norm(m.spins, axis=1).max(initial=0.0))
    lengths = np.linalg.norm(most.spins[..., 0], axis=1)
    node = int(np.argmax(lengths))
    spin, dimension = most.spins[node, :, 0], _dimension([most.part])
    about = "" if dimension == 2 else f" about {_axis_name(most, node, spin)}"
    return (f"rotations of the {most.name}{about} have no stiffness, for instance at "
            f"{words_of_place(most.spin_places[node, :dimension], size)}: its strains leave them out; give it strains "
            "that change with them, or hold them by supports")


def _axis_name(moving: Moving, node: int, spin: np.ndarray) -> str:
    """The normal, or the axis, of a part's nodes about a node where the spin is along it; else the direction."""
    arms = moving.places - moving.spin_places[node]
    nearest = np.argsort(np.linalg.norm(arms, axis=1))[:9]
    values, axes = np.linalg.eigh(arms[nearest].T @ arms[nearest])
    surface = moving.part.mesh.domain.topology.dim == 2
    axis = axes[:, 0] if surface else axes[:, -1]
    name = "its normal" if surface else "its axis"
    return name if abs(axis @ spin) > 0.99 * np.linalg.norm(spin) else _direction(spin)


def _names(parts) -> dict:
    """Parts by their kind and group, and by their number where several have the same."""
    plain = [part_named(part) for part in parts]
    return {part: name + (f" (parts[{i}])" if plain.count(name) > 1 else "")
            for i, (part, name) in enumerate(zip(parts, plain, strict=True))}


def words_of_place(place: np.ndarray, size: float = 1.0) -> str:
    """Coordinates in brackets, rounding beside a size left out."""
    place = np.where(np.abs(place) < CLOSE**2 * size, 0.0, place) + 0.0
    return "(" + ", ".join(f"{value:.4g}" for value in place) + ")"
