"""A drawing of curves, in the plane or from one side, with axes and legend."""

from __future__ import annotations

from itertools import combinations, product

import numpy as np

from ..model.obstacles import RigidCylinder, RigidPlane

DPI, POINT = 100, 1 / 72
EXAGGERATIONS = (3, 4, 5, 6, 8, 10, 15, 20, 30, 50)
MARGIN, DOT = 1.12, 14
BOX = "#cccccc"
ISOMETRIC = np.array([[-1, 1, 0], [-1, -1, 2]]) / np.sqrt([[2], [6]])  # to the right and up, seen from (1, 1, 1)
COMPASS, ARM = (0.06, 0.2), 0.06
LEGEND_COLUMNS, LEGEND_ROW, LETTERS = 2, 27, 13
LEFT, RIGHT, TOP, BOTTOM = 85, 25, 20, 62


class Sheet:
    """Collects the things to draw, then draws them to scale.

    Parameters
    ----------
    size : of the picture in pixels
    spatial : isometric view; otherwise the plane of x and y, with heights exaggerated where the
        structure is shallow
    unit : of lengths
    symmetry_factor : of the drawn part in the whole structure
    entries : in the legend besides the lines, at most
    """

    def __init__(self, size: tuple[int, int], spatial: bool, unit: str, symmetry_factor: int, entries: int):
        self.size, self.spatial, self.unit, self.symmetry_factor = size, spatial, unit, symmetry_factor
        self._entries = entries
        self._lines: list[tuple[str, str, np.ndarray, float]] = []
        self._obstacles: list[tuple[str, np.ndarray]] = []
        self._spheres: list[tuple[str, str, np.ndarray]] = []
        self.exaggeration = 1

    def line(self, label: str, colour: str, cells: np.ndarray, width: float) -> None:
        """Add a curve: (cells, points, 3), drawn `width` pixels wide."""
        self._lines.append((label, colour, cells, width))

    def fit(self) -> None:
        """Choose scale and exaggeration for the lines so far; what follows is cut to this view."""
        places = np.concatenate([cells.reshape(-1, 3) for _, _, cells, _ in self._lines])
        low, high = places.min(axis=0), places.max(axis=0)
        rows = -(-(len(self._lines) + self._entries) // LEGEND_COLUMNS)
        self._legend_height = LEGEND_ROW * rows + 14
        edges = (0, 0, 0) if self.spatial else (LEFT + RIGHT, TOP, BOTTOM)
        pixels = np.array([self.size[0] - edges[0], self.size[1] - self._legend_height - edges[1] - edges[2]])
        self._window = pixels
        width, height = (high - low)[:2]
        room = pixels[1] / pixels[0] * width * 0.8
        if not self.spatial and height > 0:
            self.exaggeration = max([1, *(e for e in EXAGGERATIONS if e * height <= room)])
        scale = np.array([1, self.exaggeration])
        needed = (high - low)[:2] * scale * MARGIN
        per_pixel = max(needed / pixels)
        half = per_pixel * pixels / 2 / scale
        middle = (low + high)[:2] / 2
        self._low, self._high = middle - half, middle + half
        self._corners = low, high

    def obstacle(self, colour: str, obstacle: RigidCylinder | RigidPlane, shift: np.ndarray) -> None:
        """Add the part of an obstacle's surface that lies in the view."""
        middle, size = (self._low + self._high) / 2, np.linalg.norm(self._high - self._low)
        if isinstance(obstacle, RigidCylinder):
            centre = np.asarray(obstacle.centre) + shift
            towards = np.arctan2(*(middle - centre)[::-1])
            width = min(np.pi, 2 * size / obstacle.radius)
            angle = towards + np.linspace(-width, width, 2001)
            surface = centre + obstacle.radius * np.column_stack([np.cos(angle), np.sin(angle)])
        else:
            point, normal = np.asarray(obstacle.point) + shift, np.asarray(obstacle.normal)
            tangent = np.array([-normal[1], normal[0]])
            foot = point + tangent * (tangent @ (middle - point))
            surface = foot + tangent * np.linspace(-size, size, 2001)[:, None]
        inside = ((surface >= self._low) & (surface <= self._high)).all(axis=1)
        pairs = np.flatnonzero(inside[:-1] & inside[1:])
        if len(pairs):
            self._obstacles.append((colour, np.stack([surface[pairs], surface[pairs + 1]], axis=1)))

    def spheres(self, colour: str, label: str, places: np.ndarray) -> None:
        """Add points: (n, 2 or 3)."""
        if len(places):
            self._spheres.append((colour, label, np.pad(places, [(0, 0), (0, 3 - places.shape[1])])))

    def draw(self):
        """The figure."""
        from .figure import Picture

        width, height = self.size
        figure = Picture(figsize=(width / DPI, height / DPI), dpi=DPI)
        left, bottom = (0, self._legend_height) if self.spatial else (LEFT, self._legend_height + BOTTOM)
        axes = figure.add_axes((left / width, bottom / height, *(self._window / self.size)))
        if self.spatial:
            self._box(axes)
        else:
            self._planar_axes(axes)
        for colour, cells in self._obstacles:
            self._curve(axes, cells, colour, 2.0)
        for _, colour, cells, line_width in self._lines:
            self._curve(axes, cells, colour, line_width)
        for colour, _, places in self._spheres:
            axes.plot(*self._place(places).T, "o", color=colour, markeredgecolor="#00000066", zorder=3,
                      markersize=DOT / DPI / POINT)
        self.add_legend(figure)
        return figure

    def add_legend(self, figure) -> None:
        """Add the legend in letters that let it fit into the width."""
        layout = {"loc": "lower center", "ncols": LEGEND_COLUMNS, "frameon": False, "columnspacing": 3,
                  "handlelength": 2.2, "labelspacing": 0.35, "borderpad": 0.3}
        legend = figure.legend(handles=self._handles(), fontsize=LETTERS, **layout)
        excess = legend.get_window_extent(figure.canvas.get_renderer()).width / (0.98 * self.size[0])
        if excess > 1:
            legend.remove()
            figure.legend(handles=self._handles(), fontsize=LETTERS / excess, **layout)

    def _planar_axes(self, axes) -> None:
        axes.set_xlim(self._low[0], self._high[0])
        axes.set_ylim(self._low[1], self._high[1])
        unit = f" ({self.unit})" if self.unit else ""
        part = f", one of {self.symmetry_factor} equal parts" if self.symmetry_factor > 1 else ""
        times = f", heights x {self.exaggeration}" if self.exaggeration > 1 else ""
        axes.set_xlabel(f"x{unit}{part}", fontsize=14)
        axes.set_ylabel(f"y{unit}{times}", fontsize=14)
        axes.tick_params(labelsize=12)
        axes.spines[["top", "right"]].set_visible(False)

    def _curve(self, axes, cells: np.ndarray, colour: str, width: float) -> None:
        """Draw cells (n, points, 2 or 3) by lines `width` pixels wide."""
        from matplotlib.collections import LineCollection

        axes.add_collection(LineCollection(self._place(cells), colors=colour, linewidths=width / DPI / POINT,
                                           capstyle="round", joinstyle="round", zorder=2))

    def _place(self, places: np.ndarray) -> np.ndarray:
        """Places in the drawing, (..., 2)."""
        return places @ ISOMETRIC.T if self.spatial else places[..., :2]

    def _box(self, axes) -> None:
        """An isometric view that all lines and the box around them fill, and the directions of the axes."""
        low, high = self._corners
        corners = np.array(list(product(*zip(low, high, strict=True))))
        edges = [pair for pair in combinations(corners, 2) if np.count_nonzero(pair[0] != pair[1]) == 1]
        if edges:
            self._curve(axes, np.array(edges), BOX, 1.0)
        placed = self._place(corners)
        middle, extent = self._place((low + high) / 2), np.ptp(placed, axis=0)
        half = MARGIN / 2 * max(extent / self._window) * self._window
        axes.set_xlim(middle[0] - half[0], middle[0] + half[0])
        axes.set_ylim(middle[1] - half[1], middle[1] + half[1])
        axes.set_axis_off()
        for name, arm in zip("xyz", ARM * ISOMETRIC.T * (self._window[1] / self._window[0], 1), strict=True):
            axes.annotate(name, COMPASS, COMPASS + 1.3 * arm, xycoords="axes fraction", fontsize=LETTERS, ha="center",
                          va="center", arrowprops={"arrowstyle": "<-", "color": "#555555"})

    def _handles(self) -> list:
        from matplotlib.lines import Line2D

        lines = [Line2D([], [], color=colour, linewidth=width, label=label) for label, colour, _, width in self._lines]
        if self._obstacles:
            lines.append(Line2D([], [], color=self._obstacles[0][0], linewidth=1.5,
                                label="obstacle, in its state's colour"))
        if self.spatial:
            sides = " x ".join(f"{side:.4g}" for side in self._corners[1] - self._corners[0])
            lines.append(Line2D([], [], color=BOX, linewidth=1, label=f"box of {sides} {self.unit}".rstrip()))
        meanings = {label: colour for colour, label, _ in self._spheres}
        return lines + [Line2D([], [], color=colour, marker="o", markersize=10, linestyle="",
                               label=f"contact point, {label}") for label, colour in meanings.items()]
