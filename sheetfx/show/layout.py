"""A drawing of curves in pyvista with axes and legend of matplotlib."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from ..model.obstacles import RigidCylinder, RigidPlane

DPI, OVERSAMPLING = 100, 2
EXAGGERATIONS = (3, 4, 5, 6, 8, 10, 15, 20, 30, 50)
MARGIN, LAYER = 1.12, 0.02
BOX = "#cccccc"
LEGEND_COLUMNS, LEGEND_ROW, LETTERS = 2, 27, 13
LEFT, RIGHT, TOP, BOTTOM = 85, 25, 20, 62


class Sheet:
    """Collects what is drawn, then draws it to scale.

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

    def save(self, file: Path) -> None:
        """Draw and write a PNG; needs an X server."""
        from matplotlib.backends.backend_agg import FigureCanvasAgg
        from matplotlib.figure import Figure

        image = self._render()
        width, height = self.size
        figure = Figure(figsize=(width / DPI, height / DPI), dpi=DPI)
        FigureCanvasAgg(figure)
        left, bottom = (0, self._legend_height) if self.spatial else (LEFT, self._legend_height + BOTTOM)
        axes = figure.add_axes((left / width, bottom / height, *(self._window / self.size)))
        if self.spatial:
            axes.imshow(image, interpolation="antialiased")
            axes.set_axis_off()
        else:
            self._planar_axes(axes, image)
        self.add_legend(figure)
        figure.savefig(file, dpi=DPI)

    def add_legend(self, figure) -> None:
        """Add the legend in letters that let it fit into the width."""
        layout = {"loc": "lower center", "ncols": LEGEND_COLUMNS, "frameon": False, "columnspacing": 3,
                  "handlelength": 2.2, "labelspacing": 0.35, "borderpad": 0.3}
        legend = figure.legend(handles=self._handles(), fontsize=LETTERS, **layout)
        excess = legend.get_window_extent(figure.canvas.get_renderer()).width / (0.98 * self.size[0])
        if excess > 1:
            legend.remove()
            figure.legend(handles=self._handles(), fontsize=LETTERS / excess, **layout)

    def _planar_axes(self, axes, image: np.ndarray) -> None:
        extent = (self._low[0], self._high[0], self._low[1], self._high[1])
        axes.imshow(image, extent=extent, aspect="auto", interpolation="antialiased")
        unit = f" ({self.unit})" if self.unit else ""
        part = f", one of {self.symmetry_factor} equal parts" if self.symmetry_factor > 1 else ""
        times = f", heights x {self.exaggeration}" if self.exaggeration > 1 else ""
        axes.set_xlabel(f"x{unit}{part}", fontsize=14)
        axes.set_ylabel(f"y{unit}{times}", fontsize=14)
        axes.tick_params(labelsize=12)
        axes.spines[["top", "right"]].set_visible(False)

    def _render(self) -> np.ndarray:
        """The picture without axes and legend, pixels (rows, columns, 3)."""
        import pyvista

        columns, rows = OVERSAMPLING * self._window
        plotter = pyvista.Plotter(off_screen=True, window_size=(int(columns), int(rows)), lighting="light kit")
        plotter.set_background("white")
        front = 0.0
        for colour, cells in self._obstacles:
            self._add_curve(plotter, cells, colour, 2.0, front)
        for _, colour, cells, width in self._lines:
            front += 1
            self._add_curve(plotter, cells, colour, width, front)
        for colour, _, places in self._spheres:
            plotter.add_mesh(pyvista.PolyData(self._place(places, front + 1)), color=colour, point_size=28,
                             render_points_as_spheres=True, ambient=0.3)
        self._aim(plotter)
        image = plotter.screenshot(return_img=True)
        plotter.close()
        return image

    def _add_curve(self, plotter, cells: np.ndarray, colour: str, width: float, front: float) -> None:
        import pyvista

        count, points = cells.shape[:2]
        numbers = np.column_stack([np.full(count, points), np.arange(count * points).reshape(count, points)])
        places, width = self._place(cells.reshape(count * points, -1), front), width * OVERSAMPLING
        curve, joints = pyvista.PolyData(places, lines=numbers.ravel()), pyvista.PolyData(places)
        plotter.add_mesh(curve, color=colour, line_width=width, lighting=False)
        plotter.add_mesh(joints, color=colour, point_size=width, render_points_as_spheres=True, lighting=False)

    def _place(self, places: np.ndarray, front: float) -> np.ndarray:
        """Places in the drawing: heights exaggerated, and later lines in front of earlier ones in the plane."""
        places = np.pad(places, [(0, 0), (0, 3 - places.shape[1])])
        if self.spatial:
            return places
        depth = front * LAYER * (self._high - self._low)[0]
        return np.column_stack([places[:, 0], self.exaggeration * places[:, 1], np.full(len(places), depth)])

    def _aim(self, plotter) -> None:
        plotter.enable_parallel_projection()
        if self.spatial:
            self._aim_isometric(plotter)
            return
        x, y = (self._low + self._high) / 2 * (1, self.exaggeration)
        width = (self._high - self._low)[0]
        plotter.camera.up = (0, 1, 0)
        plotter.camera.focal_point = (x, y, 0)
        plotter.camera.position = (x, y, 2 * width)
        plotter.camera.parallel_scale = self.exaggeration * (self._high - self._low)[1] / 2
        plotter.camera.clipping_range = (width / 10, 3 * width)

    def _aim_isometric(self, plotter) -> None:
        """Isometric view that all lines and the box around them fill."""
        import pyvista

        low, high = self._corners
        right, up, back = np.array([[-1, 1, 0], [-1, -1, 2], [1, 1, 1]]) / np.sqrt([[2], [6], [3]])
        corners = np.array(np.meshgrid(*np.column_stack([low, high]))).reshape(3, -1).T
        across, along = corners @ right, corners @ up
        middle = (low + high) / 2
        width, height = self._window
        distance = 10 * np.linalg.norm(high - low)
        behind = pyvista.Box(np.column_stack([low, high]).ravel()).outline().translate(-distance / 5 * back)
        plotter.add_mesh(behind, color=BOX, lighting=False, line_width=OVERSAMPLING)
        plotter.camera.up = up
        plotter.camera.focal_point = middle
        plotter.camera.position = middle + distance * back
        plotter.camera.parallel_scale = MARGIN * max(np.ptp(along), np.ptp(across) * height / width) / 2
        plotter.camera.clipping_range = (distance / 10, 2 * distance)
        plotter.add_axes(line_width=4)

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
