"""Parts as the bodies that their sections make: shells with both faces, beams and bars by their outlines."""

from __future__ import annotations

from typing import Any

import basix
import numpy as np

from ..discrete.section_forces import section_points
from ..model.beam import Bar
from ..model.outline import Outlined
from ..model.section import Rectangle, Tube
from ..model.shell import Shell
from .display import display
from .evaluate import communicator
from .saving import File, on_process_0, require_ending
from .shown import Shown

ROUND, ALONG = 24, 4  # corners of circles, and pieces of a curved cell


def solids(record: Shown, file: File | None = None) -> Any:
    """Bodies of all parts in the shown state, with thickness and normals (process 0).

    Each has the number of its `part` and, of shells, the `thickness` as data of cells, and the `normal`, by which
    offsets, plies and sides of pressure go, as data of points. Sections whose outline is not known are drawn as
    rectangles of their depth and area.

    Parameters
    ----------
    file : .vtp that they are written to, for ParaView; or .png of a picture

    Returns
    -------
    pyvista.PolyData; None on other processes
    """
    if file is not None:
        require_ending("solids", file, [".vtp", ".png"])
    comm, found = communicator(record), []
    for number, part in enumerate(record.case.scene.parts):
        pieces = comm.gather((_of_shell if isinstance(part, Shell) else _of_curve)(record, part))
        found += [(number, *piece) for piece in pieces or () if len(piece[1])]
    return on_process_0(record, lambda: _made(found, file))


def _made(found: list, file: File | None) -> Any:
    import pyvista

    count, points, faces, parts, thickness, normals = 0, [], [], [], [], []
    for number, places, quads, thick, normal in found:
        points.append(places)
        faces.append(np.column_stack((np.full(len(quads), quads.shape[1]), quads + count)).ravel())
        parts.append(np.full(len(quads), number))
        thickness.append(thick)
        normals.append(normal)
        count += len(places)
    made = pyvista.PolyData(np.concatenate(points), np.concatenate(faces))
    made.cell_data["part"], made.cell_data["thickness"] = np.concatenate(parts), np.concatenate(thickness)
    made.point_data["normal"] = np.concatenate(normals)
    if file is not None and str(file).endswith(".vtp"):
        made.save(str(file))
    elif file is not None:
        with display():
            plotter = pyvista.Plotter(off_screen=True, window_size=[1280, 800], lighting="light kit")
            plotter.set_background("white")
            plotter.add_mesh(made, scalars="thickness" if made.cell_data["thickness"].any() else "part",
                             cmap="viridis", scalar_bar_args={"color": "black"}, split_sharp_edges=True)
            plotter.screenshot(str(file))
            plotter.close()
    return made


def _of_shell(record: Shown, shell: Shell) -> tuple[np.ndarray, ...]:
    """Corners of all cells on the lower and the upper face, their cells, thickness and normals."""
    cell = shell.mesh.domain.basix_cell()
    corners = basix.geometry(cell)
    around = np.array([0, 1, 2] if len(corners) == 3 else [0, 1, 3, 2])
    at = section_points(record.path.discretisation, shell, corners)
    cells = len(at.places)
    half = np.broadcast_to(shell.sections.in_cells(lambda section: section.thickness), cells)[:, None, None] / 2
    director = at.axes[:, :, 2]
    faces = np.stack([at.places - half * director, at.places + half * director], axis=1)
    numbers = np.arange(cells * 2 * len(corners)).reshape(cells, 2, len(corners))[:, :, around]
    normals = np.repeat(director[:, None], 2, axis=1)
    return (faces.reshape(-1, 3), numbers.reshape(-1, len(corners)), np.repeat(2 * half[:, 0, 0], 2),
            normals.reshape(-1, 3))


def _of_curve(record: Shown, part) -> tuple[np.ndarray, ...]:
    """Outlines along all cells of beams or bars, their sides, no thickness, and normals of the sides' rings."""
    pieces = 1 if isinstance(part, Bar) else ALONG
    at = section_points(record.path.discretisation, part, np.linspace(0, 1, pieces + 1)[:, None])
    places, axes = (np.pad(v, [(0, 0)] * (v.ndim - 1) + [(0, 3 - v.shape[-1])]) for v in (at.places, at.axes))
    depth, width = _across(axes)
    points, quads, normals, count = [], [], [], 0
    for ring in outlines(part.sections.typical):
        line = places[:, :, None] + ring[:, 0, None] * depth[:, :, None] + ring[:, 1, None] * width[:, :, None]
        numbers = count + np.arange(line[..., 0].size).reshape(line.shape[:3])
        sides = np.roll(numbers, -1, axis=2)
        quads.append(np.stack([numbers[:, :-1], sides[:, :-1], sides[:, 1:], numbers[:, 1:]], axis=-1).reshape(-1, 4))
        points.append(line.reshape(-1, 3))
        normals.append(np.broadcast_to(depth[:, :, None], line.shape).reshape(-1, 3))
        count += line[..., 0].size
    sides = np.concatenate(quads)
    return np.concatenate(points), sides, np.zeros(len(sides)), np.concatenate(normals)


def _across(axes: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Directions of depth and width; of bars, which have none, any."""
    along = axes[:, :, 0]
    if axes.shape[2] > 1:
        depth = axes[:, :, 1]
    else:
        helper = np.eye(3)[np.abs(along).argmin(axis=-1)]
        depth = np.cross(helper, along)
        depth /= np.linalg.norm(depth, axis=-1, keepdims=True)
    return depth, axes[:, :, 2] if axes.shape[2] > 2 else np.cross(along, depth)


def outlines(section) -> list[np.ndarray]:
    """Rings of a section about its centroid, along depth and width, each of shape (n, 2)."""
    if isinstance(section, Outlined):
        return section._about_centroid[0]
    if isinstance(section, Tube):
        angles = 2 * np.pi * np.arange(ROUND) / ROUND
        circle = np.column_stack((np.cos(angles), np.sin(angles)))
        inner = section.diameter / 2 - section.thickness
        return [section.diameter / 2 * circle] + ([inner * circle[::-1]] if inner > 0 else [])
    low, high = section.faces
    width = section.width if isinstance(section, Rectangle) else section.area / (high - low)
    return [np.array([(low, -width / 2), (high, -width / 2), (high, width / 2), (low, width / 2)])]
