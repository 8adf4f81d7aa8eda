"""Pictures of plastic zones, and plastic fields for files."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path as Folder

import numpy as np

from ..discrete.plastic import PlasticState, is_plastic
from ..mesh.quadrature import gauss
from ..mesh.reader import NamedMesh
from .evaluate import POINTS_PER_CELL, Curves, communicator, last_state_kept, unit_of
from .measure import SIZES
from .pictures import MOST_VIEWS, states_to_draw
from .saving import save_picture
from .shown import Shown
from .surfaces import has_surfaces, surfaces
from .views import OUTLINE, View, draw_views, manner_of_states

MEANING = "share of the thickness or section that has flowed"


def plastic_zones(record: Shown, folder: Folder, name: str = "plastic.png") -> None:
    """Draw where critical points and the last state have flowed, by the share of the thickness (process 0 writes).

    Structures with surfaces are drawn in space, structures of curves alone in the plane of x and y, or in space.
    """
    beams = any(part.mesh.domain.topology.dim == 1 for part in record.case.scene.parts)
    shells, found = has_surfaces(record), []
    with last_state_kept(record):
        for state, label, _, _ in states_to_draw(record, MOST_VIEWS - 1):
            record.show(state)
            title = "\n".join(label.split("; ") if "; " in label else label.split(": ", 1))
            drawn = surfaces(record, values=lambda mesh, points: on_cells(record, mesh, points)) if shells else []
            curves = Curves(record).evaluate() if beams else None
            values = _along_curves(record) if beams else None
            if communicator(record).rank == 0:
                found.append((View(title, drawn, None if curves is None else curves[1], values), curves))
    if communicator(record).rank > 0:
        return
    if shells:
        save_picture(record, lambda: draw_views([v for v, _ in found], manner_of_states(record, MEANING)),
                     Folder(folder) / name)
    else:
        draw_plastic_curves(record, found).savefig(Folder(folder) / name, dpi=100)


def draw_plastic_curves(record: Shown, found: list) -> object:
    """The matplotlib figure of `plastic_zones` for structures of curves.

    Parameters
    ----------
    found : for each state its `View` and the undeformed and current places of all curves
    """
    from matplotlib.collections import LineCollection

    from .figure import Picture

    spatial = record.case.scene.parts[0].mesh.dimension == 3
    columns = min(len(found), 2)
    rows = -(-len(found) // columns)
    figure = Picture(figsize=(8.0 * columns, (5.0 if spatial else 3.4) * rows), layout="constrained")
    options = {"projection": "3d"} if spatial else {}
    grid = figure.subplots(rows, columns, squeeze=False, subplot_kw=options)
    for axes, (shown, (undeformed, current)) in zip(grid.flat, found, strict=False):
        between = (shown.beam_values[:, 1:] + shown.beam_values[:, :-1]) / 2
        if spatial:
            from mpl_toolkits.mplot3d.art3d import Line3DCollection
            drawn = Line3DCollection(_segments(current), cmap=SIZES, linewidths=3)
            axes.add_collection(drawn)
            axes.auto_scale_xyz(*current.reshape(-1, 3).T)
        else:
            axes.add_collection(LineCollection(_segments(undeformed[..., :2]), colors=OUTLINE, linewidths=1))
            drawn = LineCollection(_segments(current[..., :2]), cmap=SIZES, linewidths=5)
            axes.add_collection(drawn)
            axes.autoscale()
            axes.spines[["top", "right"]].set_visible(False)
        drawn.set_array(between.ravel())
        drawn.set_clim(0, max(float(v.beam_values.max()) for v, _ in found) or 1.0)
        axes.set_title(shown.title, fontsize=10)
    for axes in grid.flat[len(found):]:
        axes.set_axis_off()
    unit = unit_of(record.case.axes[0])
    grid[-1, 0].set_xlabel(f"x ({unit})" if unit else "x")
    figure.colorbar(drawn, ax=grid, label=MEANING, shrink=0.8)
    return figure


def _segments(cells: np.ndarray) -> np.ndarray:
    """Pieces between neighbouring points of cells, (pieces, 2, components)."""
    return np.stack((cells[:, :-1], cells[:, 1:]), axis=2).reshape(-1, 2, cells.shape[2])


def plastic_parts(record: Shown, mesh: NamedMesh) -> list:
    return [part for part in record.case.scene.parts if part.mesh is mesh and is_plastic(part)]


def of_cells(record: Shown, mesh: NamedMesh, take: Callable[[PlasticState], np.ndarray]) -> np.ndarray:
    """One value for each cell of a mesh on this process, where parts are plastic; 0 elsewhere."""
    values = np.zeros(len(mesh.group(None)))
    for part in plastic_parts(record, mesh):
        values[mesh.group(part.group)] = take(record.plastic(part))
    return values


def mean_share(state: PlasticState) -> np.ndarray:
    """Share of the volume of each cell that has flowed."""
    return (state.share * state.measure).sum(axis=1) / state.measure.sum(axis=1)


def largest_strain(state: PlasticState) -> np.ndarray:
    """Largest equivalent plastic strain in each cell."""
    return state.strain.max(axis=1)


def on_cells(record: Shown, mesh: NamedMesh, points: np.ndarray) -> np.ndarray:
    """Share that has flowed at reference points of all cells of a mesh, (cells, points).

    It is the bilinear function closest to that at the points of quadrature, between 0 and 1.
    """
    found = np.zeros((len(mesh.group(None)), len(points)))
    for part in plastic_parts(record, mesh):
        taken = np.linalg.pinv(_linear(part.discrete.full.points))
        shares = record.plastic(part).share @ (_linear(points) @ taken).T
        found[mesh.group(part.group)] = np.clip(shares, 0.0, 1.0)
    return found


def _linear(points: np.ndarray) -> np.ndarray:
    s, t = points.T
    return np.column_stack((np.ones_like(s), s, t, s * t))


def _along_curves(record: Shown) -> np.ndarray | None:
    """Share that has flowed at the points of `Curves`, (cells, points), on process 0."""
    places, tables = np.linspace(0, 1, POINTS_PER_CELL), [np.zeros((0, POINTS_PER_CELL))]
    for mesh in (m for m in record.case.scene.meshes if m.domain.topology.dim == 1):
        table = np.zeros((len(mesh.group(None)), POINTS_PER_CELL))
        for part in plastic_parts(record, mesh):
            share = record.plastic(part).share
            at = gauss(mesh.domain.basix_cell(), share.shape[1]).points[:, 0]
            order = np.argsort(at)
            table[mesh.group(part.group)] = [np.interp(places, at[order], values) for values in share[:, order]]
        tables.append(table)
    gathered = communicator(record).gather(np.concatenate(tables))
    return None if gathered is None else np.concatenate(gathered)
