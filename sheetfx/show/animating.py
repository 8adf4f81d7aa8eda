"""The motion along a path as a GIF."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path as Folder
from typing import Any

import numpy as np

from ..continuation.state import State
from .curves import draw_course, frame
from .display import display
from .evaluate import last_state_kept, unit_of, with_unit
from .measure import OF_SIZE, Measure
from .saving import File, save_picture
from .shown import Shown
from .views import BAR, BOTTOM, Camera, View, colour_bar, render, view

STRUCTURE, CURVE = (860, 560), 420  # in pixels: the structure's picture, and the width of the curve beside it
MOST, FRAME, REST = 60, 100, 1000  # frames, and how long each and the last one are shown (ms): at most 7 s in all
COLOURS = 256  # the most that a GIF has


def animation(record: Shown, folder: Folder, name: str = "animation.gif") -> None:
    """Draw animation.gif, the motion along the path (process 0 writes the file)."""
    moving = Animation.of(record)
    save_picture(record, lambda: moving, Folder(folder) / name)


@dataclass
class Animation:
    """Views of states along a path, on process 0, beside the path with a mark where each is, in a figure."""

    record: Shown
    states: list[State]
    views: list[View | None]
    measure: Measure
    figure: Any

    @classmethod
    def of(cls, record: Shown, measure: Measure = OF_SIZE) -> Animation:
        """Of the states of a record, spread evenly where there are more than are drawn."""
        numbers = np.unique(np.linspace(0, len(record.states) - 1, MOST).round().astype(int))
        states, views = [record.states[n] for n in numbers], []
        with last_state_kept(record):
            for state in states:
                record.show(state)
                views.append(view(record, "", measure))
        width, height = STRUCTURE[0] + CURVE, STRUCTURE[1]
        figure, axes = frame(record, (0.06 + STRUCTURE[0] / width, 0.14, CURVE / width - 0.08, 0.74), (width, height))
        draw_course(axes, record)
        return cls(record, states, views, measure, figure)

    def savefig(self, file: File) -> None:
        """Draw and write all frames; needs what views need."""
        from PIL import Image

        (picture, mark, title), camera, norm = self._prepared()
        frames, stages = [], self.record.case.scene.all_stages
        length, force = map(unit_of, self.record.case.axes)
        with display():
            for state, shown in zip(self.states, self.views, strict=True):
                picture.set_data(render(shown, camera, norm, self.measure.colour_map))
                mark.set_data([state.deflection], [state.load])
                mark.set_visible(state.stage == self.states[-1].stage)
                stage = f"{stages[state.stage].name}: " if len(stages) > 1 else ""
                title.set_text(f"{stage}load {with_unit(state.load, force)}, "
                               f"deflection {with_unit(state.deflection, length)}")
                self.figure.canvas.draw()
                pixels = np.asarray(self.figure.canvas.buffer_rgba())[..., :3].copy()
                frames.append(Image.fromarray(pixels).quantize(COLOURS, Image.Quantize.FASTOCTREE))
        frames[0].save(file, save_all=True, append_images=frames[1:], loop=0,
                       duration=[FRAME] * (len(frames) - 1) + [REST])

    def _prepared(self):
        """What changes in the figure, and how the structure is seen and coloured."""
        from matplotlib.colors import Normalize

        camera, size = Camera(self.views), np.array([STRUCTURE[0] + CURVE, STRUCTURE[1]])
        camera.fit(1, STRUCTURE)
        norm = Normalize(*self.measure.limits([c for v in self.views for c in v.colours]))
        figure, curve = self.figure, self.figure.axes[0]
        (mark,) = curve.plot([], [], "o", color="black", markersize=7, zorder=5)
        axes = figure.add_axes((0, BOTTOM / size[1], *(camera.pixels / size)))
        axes.set_axis_off()
        picture = axes.imshow(np.ones((*(camera.pixels[::-1]), 3)), interpolation="antialiased", aspect="auto",
                              vmin=0, vmax=1)
        colour_bar(figure, ((STRUCTURE[0] - 0.9 * BAR) / size[0], 0.2, 0.012, 0.6), norm, self.measure.colour_map,
                   self.measure.said(unit_of(self.record.case.axes[0])))
        title = figure.text(0.02, 0.95, "", fontsize=13)
        if camera.exaggeration > 1:
            figure.text(0.02, 0.02, f"heights (z) x {camera.exaggeration}", fontsize=11, color="#555555")
        return (picture, mark, title), camera, norm
