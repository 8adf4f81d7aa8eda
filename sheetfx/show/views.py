"""Views of deformed structures side by side, to one scale and from one side."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import product

import numpy as np

from .display import display
from .evaluate import Curves, unit_of
from .layout import EXAGGERATIONS
from .measure import SIZES, Measure
from .shown import Shown
from .surfaces import Surface, surfaces

SIZE, DPI, OVERSAMPLING = (1600, 900), 100, 2
BAR, BOTTOM, TITLE = 170, 40, 56
LINE, OUTLINE, BEAM = "#1a1a1a", "#8c8c8c", "#c4432b"
MOST_CELLS_WITH_EDGES, FOLD = 2000, 30.0
SIDES = [np.array([x, y, 1.0]) for x, y in product((1.0, -1.0), (-1.6, 1.6))]
PREFERENCE, SHALLOW, RISE = 1.1, 0.12, 0.3


@dataclass
class View:
    """A state or a mode to draw.

    Attributes
    ----------
    beams : current places of curves, (cells, points, 3); None: there are none
    beam_values : what colours them, (cells, points); None: they have one colour
    beams_before : their undeformed places, to be drawn; None: they are not
    """

    title: str
    surfaces: list[Surface]
    beams: np.ndarray | None
    beam_values: np.ndarray | None = None
    beams_before: np.ndarray | None = None

    @property
    def places(self) -> np.ndarray:
        """All places to be seen, (n, 3)."""
        lines = [b.reshape(-1, 3) for b in (self.beams, self.beams_before) if b is not None]
        return np.concatenate([p for s in self.surfaces for p in (s.undeformed, s.current)] + lines)

    @property
    def undeformed(self) -> np.ndarray:
        """All undeformed places that are known, (n, 3)."""
        lines = [] if self.beams_before is None else [self.beams_before.reshape(-1, 3)]
        return np.concatenate([*(s.undeformed for s in self.surfaces), *lines])

    @property
    def colours(self) -> list[np.ndarray]:
        """All that is drawn as colours."""
        return [*(s.colours for s in self.surfaces), *([] if self.beam_values is None else [self.beam_values])]

    def moved(self, scale: float) -> View:
        """The same with displacements drawn to another scale."""
        beams = self.beams if self.beams is None or self.beams_before is None else (
            self.beams_before + scale * (self.beams - self.beams_before))
        return replace(self, beams=beams, surfaces=[
            replace(s, current=s.undeformed + scale * (s.current - s.undeformed)) for s in self.surfaces])


@dataclass(frozen=True)
class Manner:
    """How views are drawn.

    Attributes
    ----------
    meaning : of colours
    remarks : at the foot
    colour_map, limits : of colours; limits None: from zero to the largest
    exaggerated : whether heights of shallow structures are
    size : of the picture in pixels
    """

    meaning: str
    remarks: Sequence[str] = ()
    colour_map: str = SIZES
    limits: tuple[float, float] | None = None
    exaggerated: bool = True
    size: tuple[int, int] = SIZE


def view(record: Shown, title: str, measure: Measure) -> View | None:
    """The view of the current fields, all parts coloured by one measure, on process 0; None elsewhere."""
    beams = any(part.mesh.domain.topology.dim == 1 for part in record.case.scene.parts)
    found, curves = surfaces(record), Curves(record).evaluate() if beams else None
    if found is None:
        return None
    return coloured(View(title, found, None if curves is None else curves[1], None,
                         None if curves is None or found else curves[0]), measure,
                    None if curves is None else curves[1] - curves[0])


def coloured(shown: View, measure: Measure, of_beams: np.ndarray | None) -> View:
    """A view whose surfaces and curves are coloured by one measure of their displacements.

    Parameters
    ----------
    of_beams : displacements of curves, (cells, points, 3); None: there are none
    """
    return replace(shown, surfaces=[replace(s, values=measure(s.current - s.undeformed)) for s in shown.surfaces],
                   beam_values=None if of_beams is None else measure(of_beams))


def draw_states(record: Shown, views: list[View], measure: Measure):
    """The figure of states, coloured by a measure of their displacements."""
    limits = measure.limits([c for v in views for c in v.colours])
    return draw_views(views, manner_of_states(record, measure.said(unit_of(record.case.axes[0])), measure.colour_map,
                                              limits))


def manner_of_states(record: Shown, meaning: str, *colours) -> Manner:
    """How states are drawn, with colours (`colour_map` and `limits` of Manner) that mean something."""
    factor = record.case.scene.symmetry_factor
    parts = [f"one of {factor} equal parts"] if factor > 1 else []
    return Manner(meaning, [*parts, "grey: before deformation"], *colours)


def draw_views(views: list[View], manner: Manner):
    """The figure of views side by side.

    Raises
    ------
    NoDisplay
        Where there is no X server and none can be started.
    """
    from matplotlib.colors import Normalize

    from .figure import Picture

    camera, size = Camera(views, manner.exaggerated), np.array(manner.size)
    columns, rows = camera.fit(len(views), manner.size)
    norm = Normalize(*(manner.limits or (0, max(c.max() for v in views for c in v.colours) or 1.0)))
    figure = Picture(figsize=size / DPI, dpi=DPI)
    cell = np.array([size[0] - BAR, size[1] - BOTTOM]) // (columns, rows)
    with display():
        images = [render(shown, camera, norm, manner.colour_map) for shown in views]
    for i, (shown, image) in enumerate(zip(views, images, strict=True)):
        corner = i % columns * cell[0], size[1] - (i // columns + 1) * cell[1]
        axes = figure.add_axes((*(corner / size), *(camera.pixels / size)))
        axes.imshow(image, interpolation="antialiased", aspect="auto")
        axes.set_axis_off()
        axes.set_title(shown.title, fontsize=14 if columns < 3 else 11)
    fit_titles(figure, cell[0])
    if any(v.colours for v in views):
        colour_bar(figure, (1 - 0.7 * BAR / size[0], 0.2, 0.015, 0.6), norm, manner.colour_map, manner.meaning)
    notes = [*manner.remarks, *([f"heights (z) x {camera.exaggeration}"] if camera.exaggeration > 1 else [])]
    figure.text(0.99, 0.015, "; ".join(notes), ha="right", fontsize=11, color="#555555")
    return figure


def colour_bar(figure, place: Sequence[float], norm, colour_map: str, meaning: str) -> None:
    """Add a bar of colours at a place of a figure (left, bottom, width, height), with what they mean."""
    from matplotlib.cm import ScalarMappable

    bar = figure.colorbar(ScalarMappable(norm, colour_map), cax=figure.add_axes(place))
    bar.set_label(meaning, fontsize=13)
    bar.ax.tick_params(labelsize=11)


def fit_titles(figure, width: float) -> None:
    """Make the letters of all titles so small that none is wider than a view (pixels)."""
    titles = [axes.title for axes in figure.axes]
    widest = max(title.get_window_extent(figure.canvas.get_renderer()).width for title in titles)
    for title in titles:
        title.set_fontsize(title.get_fontsize() * min(1.0, 0.96 * width / widest))


class Camera:
    """A parallel projection, from the side that shows most of the surfaces, that all views share.

    What lies in the plane of x and y, and stays there, is seen from above.

    Attributes
    ----------
    exaggeration : of heights along z where the structure is shallow
    frame : rows to the right, up and towards the eye
    pixels : size of each view, after `fit`
    """

    def __init__(self, views: list[View], exaggerated: bool = True):
        self.exaggeration = 1
        places = np.concatenate([v.places for v in views])
        extent = np.ptp(places, axis=0)
        if exaggerated and 0 < extent[2] < SHALLOW * max(extent[:2]):
            self.exaggeration = max([1, *(e for e in EXAGGERATIONS if e * extent[2] <= RISE * max(extent[:2]))])
        self.frame = self._frame(views) if extent[2] else np.eye(3)
        across = self.place(places) @ self.frame.T
        self._low, self._high = across.min(axis=0), across.max(axis=0)

    def _frame(self, views: list[View]) -> np.ndarray:
        area = np.concatenate([np.zeros((1, 3)), *(self._areas(s) for v in views for s in v.surfaces)])
        seen = [np.abs(area @ side).sum() for side in SIDES]
        best = int(np.argmax(seen))
        back = SIDES[0 if seen[best] <= PREFERENCE * seen[0] else best]
        back = back / np.linalg.norm(back)
        right = np.cross([0.0, 0.0, 1.0], back)
        right /= np.linalg.norm(right)
        return np.array([right, np.cross(back, right), back])

    def _areas(self, surface: Surface) -> np.ndarray:
        a, b, c = (self.place(surface.current)[surface.faces[:, i]] for i in range(3))
        return np.cross(b - a, c - a)

    def place(self, places: np.ndarray) -> np.ndarray:
        """Places in the drawing, heights exaggerated."""
        return places * (1, 1, self.exaggeration)

    def fit(self, count: int, picture: tuple[int, int] = SIZE) -> tuple[int, int]:
        """Columns and rows in which `count` views are largest, in a picture of a size in pixels."""
        size, best = np.maximum((self._high - self._low)[:2], 1e-9), 0.0
        for columns in range(1, count + 1):
            rows = -(-count // columns)
            pixels = np.array([picture[0] - BAR, picture[1] - BOTTOM]) // (columns, rows) - (0, TITLE)
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


def render(shown: View, camera: Camera, norm, colour_map: str) -> np.ndarray:
    """A view without its title, pixels (rows, columns, 3); needs an X server."""
    import pyvista

    plotter = pyvista.Plotter(off_screen=True, window_size=[int(OVERSAMPLING * p) for p in camera.pixels],
                              lighting="light kit")
    plotter.set_background("white")
    plotter.render_window.SetMultiSamples(0)  # oversampling smooths edges, in half of the time
    for surface in shown.surfaces:
        outline = surface.mesh(camera.place(surface.undeformed)).extract_feature_edges(feature_angle=FOLD)
        plotter.add_mesh(outline, color=OUTLINE, line_width=1.2 * OVERSAMPLING, lighting=False)
        plotter.add_mesh(surface.mesh(camera.place(surface.current)), scalars="colours", cmap=colour_map,
                         clim=(norm.vmin, norm.vmax), show_scalar_bar=False, smooth_shading=True,
                         split_sharp_edges=True, feature_angle=FOLD, ambient=0.35, specular=0.1)
        if len(surface.borders) <= MOST_CELLS_WITH_EDGES:
            plotter.add_mesh(surface.edges(camera.forward(surface.current)), color=LINE, opacity=0.5,
                             line_width=0.6 * OVERSAMPLING, lighting=False)
    if shown.beams_before is not None and len(shown.beams_before):
        plotter.add_mesh(lines(camera.place(shown.beams_before)), color=OUTLINE, line_width=1.5 * OVERSAMPLING,
                         lighting=False)
    if shown.beams is not None and len(shown.beams):
        mesh, colours = lines(camera.forward(shown.beams)), {"color": BEAM}
        if shown.beam_values is not None:
            mesh["colours"] = shown.beam_values.ravel()
            colours = {"scalars": "colours", "cmap": colour_map, "clim": (norm.vmin, norm.vmax),
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
