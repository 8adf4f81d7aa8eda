"""Figures without pyplot, which notebooks show as they show pyplot's."""

from __future__ import annotations

from io import BytesIO

from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure


class Picture(Figure):
    """A figure with a canvas of its own, whose size in letters and pixels is known before it is saved."""

    def __init__(self, *arguments, **options):
        super().__init__(*arguments, **options)
        FigureCanvasAgg(self)

    def _repr_png_(self) -> bytes:
        """What a notebook shows where a picture is the value of a cell."""
        stream = BytesIO()
        self.savefig(stream, format="png")
        return stream.getvalue()
