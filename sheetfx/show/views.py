"""Views of deformed surfaces side by side, to one scale and from one side."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product
from pathlib import Path as Folder

import numpy as np

from ..record import Record
from .evaluate import Curves, unit_of
from .layout import EXAGGERATIONS
from .surfaces import Surface, surfaces

SIZE, DPI, OVERSAMPLING = np.array([1600, 900]), 100, 2
BAR, BOTTOM, TITLE = 170, 40, 56
COLOUR_MAP, LINE, OUTLINE, BEAM = "viridis", "#1a1a1a", "#8c8c8c", "#c4432b"
MOST_CELLS_WITH_EDGES, FOLD = 2000, 30.0
SIDES = [np.array([x, y, 1.0]) for x, y in product((1.0, -1.0), (-1.6, 1.6))]
PREFERENCE, SHALLOW, RISE = 1.1, 0.12, 0.3


@dataclass
class View:
    """A state to draw: its title, surfaces, and beams (cells, points, 3) with what colours them, if anything."""

    title: str
    surfaces: list[Surface]
    beams: np.ndarray | None
    beam_values: np.ndarray | None = None

    @property
    def places(self) -> np.ndarray:
        """All places to be seen, (n, 3)."""
        lines = [] if self.beams is None else [self.beams.reshape(-1, 3)]
        return np.concatenate([p for s in self.surfaces for p in (s.undeformed, s.current)] + lines)


def view(record: Record, title: str) -> View | None:
    """What is shown of the current fields, on process 0; None elsewhere."""
    beams = any(part.mesh.domain.topology.dim == 1 for part in record.case.scene.parts)
    found, curves = surfaces(record), Curves(record).evaluate() if beams else None
    return None if found is None else View(title, found, None if curves is None else curves[1])


def draw_views(record: Record, views: list[View], file: Folder, meaning: str = "") -> None:
    """Draw states, surfaces coloured by the size of displacement or what `meaning` says; needs an X server."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import Normalize
    from matplotlib.figure import Figure

    camera = Camera(views)
    columns, rows = camera.fit(len(views))
    norm = Normalize(0, max(s.colours.max() for v in views for s in v.surfaces) or 1.0)
    figure = Figure(figsize=SIZE / DPI, dpi=DPI)
    FigureCanvasAgg(figure)
    cell = np.array([SIZE[0] - BAR, SIZE[1] - BOTTOM]) // (columns, rows)
    for i, shown in enumerate(views):
        corner = i % columns * cell[0], SIZE[1] - (i // columns + 1) * cell[1]
        axes = figure.add_axes((*(corner / SIZE), *(camera.pixels / SIZE)))
        axes.imshow(_render(shown, camera, norm), interpolation="antialiased", aspect="auto")
        axes.set_axis_off()
        axes.set_title(shown.title, fontsize=14 if columns < 3 else 11)
    fit_titles(figure, cell[0])
    bar_axes = figure.add_axes((1 - 0.7 * BAR / SIZE[0], 0.2, 0.015, 0.6))
    bar = figure.colorbar(ScalarMappable(norm, COLOUR_MAP), cax=bar_axes)
    unit = unit_of(record.case.axes[0])
    bar.set_label(meaning or (f"displacement ({unit})" if unit else "displacement"), fontsize=13)
    bar.ax.tick_params(labelsize=11)
    symmetry_factor = record.case.scene.symmetry_factor
    notes = [f"one of {symmetry_factor} equal parts" if symmetry_factor > 1 else "", "grey: edges before deformation",
             f"heights (z) x {camera.exaggeration}" if camera.exaggeration > 1 else ""]
    figure.text(0.99, 0.015, "; ".join(n for n in notes if n), ha="right", fontsize=11, color="#555555")
    figure.savefig(file, dpi=DPI)


def fit_titles(figure, width: float) -> None:
    """Make the letters of all titles so small that none is wider than a view (pixels)."""
    titles = [axes.title for axes in figure.axes]
    widest = max(title.get_window_extent(figure.canvas.get_renderer()).width for title in titles)
    for title in titles:
        title.set_fontsize(title.get_fontsize() * min(1.0, 0.96 * width / widest))


class Camera:
    """A parallel projection, from the side that shows most of the surfaces, that all views share.

    Attributes
    ----------
    exaggeration : of heights along z where the structure is shallow
    frame : rows to the right, up and towards the eye
    pixels : size of each view, after `fit`
    """

    def __init__(self, views: list[View]):
        self.exaggeration = 1
        places = np.concatenate([v.places for v in views])
        extent = np.ptp(places, axis=0)
        if 0 < extent[2] < SHALLOW * max(extent[:2]):
            self.exaggeration = max([1, *(e for e in EXAGGERATIONS if e * extent[2] <= RISE * max(extent[:2]))])
        area = np.concatenate([self._areas(s) for v in views for s in v.surfaces])
        seen = [np.abs(area @ side).sum() for side in SIDES]
        best = int(np.argmax(seen))
        back = SIDES[0 if seen[best] < PREFERENCE * seen[0] else best]
        back = back / np.linalg.norm(back)
        right = np.cross([0.0, 0.0, 1.0], back)
        right /= np.linalg.norm(right)
        self.frame = np.array([right, np.cross(back, right), back])
        across = self.place(places) @ self.frame.T
        self._low, self._high = across.min(axis=0), across.max(axis=0)

    def _areas(self, surface: Surface) -> np.ndarray:
        a, b, c = (self.place(surface.current)[surface.faces[:, i]] for i in range(3))
        return np.cross(b - a, c - a)

    def place(self, places: np.ndarray) -> np.ndarray:
        """Places in the drawing, heights exaggerated."""
        return places * (1, 1, self.exaggeration)

    def fit(self, count: int) -> tuple[int, int]:
        """Columns and rows in which `count` views are largest."""
        size, best = (self._high - self._low)[:2], 0.0
        for columns in range(1, count + 1):
            rows = -(-count // columns)
            pixels = np.array([SIZE[0] - BAR, SIZE[1] - BOTTOM]) // (columns, rows) - (0, TITLE)
            if min(pixels / size) > best:
                best, self.pixels, grid = min(pixels / size), pixels, (columns, rows)
        self.scale = 1.06 * self.pixels[1] / best / 2
        return grid

    def aim(self, plotter) -> None:
        length = float(np.linalg.norm(self._high - self._low))
        middle = (self._low + self._high) / 2 @ self.frame
        plotter.enable_parallel_projection()
        plotter.camera.up = self.frame[1]
        plotter.camera.focal_point = middle
        plotter.camera.position = middle + 10 * length * self.frame[2]
        plotter.camera.parallel_scale = self.scale
        plotter.camera.clipping_range = (length, 20 * length)

    def forward(self, places: np.ndarray) -> np.ndarray:
        """Places in the drawing, a little nearer so that lines lie in front of surfaces."""
        return self.place(places) + np.linalg.norm(self._high - self._low) / 500 * self.frame[2]


def _render(shown: View, camera: Camera, norm) -> np.ndarray:
    """A view without its title, pixels (rows, columns, 3)."""
    import pyvista

    plotter = pyvista.Plotter(off_screen=True, window_size=[int(OVERSAMPLING * p) for p in camera.pixels],
                              lighting="light kit")
    plotter.set_background("white")
    for surface in shown.surfaces:
        outline = surface.mesh(camera.place(surface.undeformed)).extract_feature_edges(feature_angle=FOLD)
        plotter.add_mesh(outline, color=OUTLINE, line_width=1.2 * OVERSAMPLING, lighting=False)
        plotter.add_mesh(surface.mesh(camera.place(surface.current)), scalars="colours", cmap=COLOUR_MAP,
                         clim=(norm.vmin, norm.vmax), show_scalar_bar=False, smooth_shading=True,
                         split_sharp_edges=True, feature_angle=FOLD, ambient=0.35, specular=0.1)
        if len(surface.borders) <= MOST_CELLS_WITH_EDGES:
            plotter.add_mesh(surface.edges(camera.forward(surface.current)), color=LINE, opacity=0.5,
                             line_width=0.6 * OVERSAMPLING, lighting=False)
    if shown.beams is not None:
        mesh, colours = lines(camera.forward(shown.beams)), {"color": BEAM}
        if shown.beam_values is not None:
            mesh["colours"] = shown.beam_values.ravel()
            colours = {"scalars": "colours", "cmap": COLOUR_MAP, "clim": (norm.vmin, norm.vmax),
                       "show_scalar_bar": False}
        plotter.add_mesh(mesh, line_width=4 * OVERSAMPLING, lighting=False, **colours)
    camera.aim(plotter)
    image = plotter.screenshot(return_img=True)
    plotter.close()
    return image


def lines(cells: np.ndarray):
    """A pyvista mesh of curves, shape (cells, points, 3)."""
    import pyvista

    count, points = cells.shape[:2]
    numbers = np.column_stack([np.full(count, points), np.arange(count * points).reshape(count, points)])
    return pyvista.PolyData(cells.reshape(-1, 3), lines=numbers.ravel())
