"""A view that can be turned, of a run's folder or of a record."""

from __future__ import annotations

import importlib.util
import json
import sys
from collections.abc import Sequence
from pathlib import Path
from shutil import rmtree
from tempfile import mkdtemp

import numpy as np

from .display import answers, display
from .evaluate import communicator, unit_of, with_unit
from .files import paraview
from .measure import Along, Measure
from .saving import File, on_process_0, require_ending
from .shown import Shown

SHARE = 0.05  # of the structure's size, by which buckling modes are moved
SMOOTH = 2  # divisions of the edges of curved cells
WIDTH, SIZE = 4, (1280, 800)  # of curves, and of the window, in pixels
NO_UNITS = "deflection", "load"


def view_record(record: Shown, along: Along = None, file: File | None = None):
    """View all states of a record, see `view_folder`; what ParaView would read goes through a temporary folder."""
    comm = communicator(record)
    folder = Path(comm.bcast(mkdtemp() if comm.rank == 0 else None))
    try:
        paraview(record, folder)
        return on_process_0(record, lambda: view_folder(folder, along, file, record.case.axes))
    finally:
        comm.barrier()
        rmtree(folder, ignore_errors=True)


def view_folder(folder: File, along: Along = None, file: File | None = None, axes: Sequence[str] | None = None):
    """Open a view of a finished run that can be turned, with a slider for its states or buckling modes.

    In a notebook it is the value of the cell: one that can be turned where the package trame is installed and an X
    server answers, otherwise a picture of the last state.

    Parameters
    ----------
    folder : of a run, with its files for ParaView
    along : direction "x", "y" or "z", or a vector, along which displacements colour all parts; None: their size
    file : .png that a picture of the last state is written to; nothing opens then
    axes : names of deflection and load, whose units are told; None: the run's

    Raises
    ------
    ValueError
        Where the folder has no files for ParaView, or no view can be opened.
    """
    measure, scenes = Measure(along), _Scenes(Path(folder), axes or _axes(Path(folder)))
    if file is not None:
        require_ending("view", file, [".png"])
        _image(scenes, measure).save(file)
        return None
    if _in_notebook():
        if importlib.util.find_spec("trame") is None or not answers():
            return _image(scenes, measure)
        return scenes.plotter(measure, notebook=True).show(jupyter_backend="trame", return_viewer=True)
    if not answers():
        raise ValueError("view: no X server answers, so that no view can be opened; write a picture "
                         "(sheetfx view FOLDER --picture FILE.png, or file= in scripts), or set DISPLAY")
    return scenes.plotter(measure).show()


def _image(scenes: _Scenes, measure: Measure):
    """A picture of the last state or the first mode, an image of Pillow."""
    from PIL import Image

    with display():
        plotter = scenes.plotter(measure, off_screen=True)
        pixels = plotter.screenshot(return_img=True)
        plotter.close()  # before the X server may end, which would end the process too
    return Image.fromarray(pixels)


def _axes(folder: Path) -> Sequence[str]:
    """The names of deflection and load in the summary of a run, without units where there is none."""
    summary = folder / "summary.json"
    return json.loads(summary.read_text()).get("axes", NO_UNITS) if summary.exists() else NO_UNITS


def _in_notebook() -> bool:
    """Whether this is a kernel of Jupyter."""
    shell = sys.modules.get("IPython")  # which a kernel has imported
    return shell is not None and type(shell.get_ipython()).__name__ == "ZMQInteractiveShell"


class _Scenes:
    """States of a path, or buckling modes, as ParaView's files have them: for each mesh one collection.

    Attributes
    ----------
    count : of states or modes
    """

    def __init__(self, folder: Path, axes: Sequence[str]):
        import pyvista

        files = [sorted((folder / "paraview").glob(f"{kind}*.pvd")) for kind in ("path", "modes")]
        found = next(filter(None, files), None)
        if found is None:
            raise ValueError(f"view: {folder} holds no paraview/path.pvd and no paraview/modes.pvd; give the folder of "
                             "a finished run whose pictures include those for ParaView")
        self._length, self._force = map(unit_of, axes)
        self._readers = [pyvista.PVDReader(str(file)) for file in found]
        self._modes = found[0].name.startswith("modes")
        self._field = "mode" if self._modes else "displacement"
        self.count = len(self._readers[0].time_values)
        self._undeformed = [self._read(reader, 0) for reader in self._readers]
        places = np.concatenate([mesh.points for mesh in self._undeformed])
        self._scale = SHARE * float(np.linalg.norm(np.ptp(places, axis=0))) if self._modes else 1.0

    def plotter(self, measure: Measure, **options):
        """A pyvista plotter of the last state or the first mode; a slider shows the others."""
        import pyvista

        self._measure = measure
        self._plotter = pyvista.Plotter(window_size=SIZE, **options)
        self._plotter.set_background("white")
        self._range = measure.limits([measure(self._read(reader, n)[self._field])
                                      for reader in self._readers for n in range(self.count)])
        for number, mesh in enumerate(self._undeformed):
            self._plotter.add_mesh(mesh.extract_surface(nonlinear_subdivision=SMOOTH).extract_feature_edges()
                                   if _surfaces(mesh) else mesh, color="#8c8c8c", line_width=1, name=f"before {number}")
        self._show(0 if self._modes else self.count - 1)
        if self.count > 1 and not options.get("off_screen"):
            self._plotter.add_slider_widget(lambda value: self._show(round(value)), (0, self.count - 1),
                                            0 if self._modes else self.count - 1, self._field, fmt="%.0f",
                                            interaction_event="always")
        if all(np.ptp(self._moved(reader, n).points[:, 2]) == 0 for reader in self._readers for n in range(self.count)):
            self._plotter.view_xy()
        self._plotter.add_axes()
        return self._plotter

    def _read(self, reader, number: int):
        reader.set_active_time_point(number)
        return reader.read()[0]

    def _moved(self, reader, number: int):
        mesh = self._read(reader, number)
        mesh.points = mesh.points + self._scale * mesh[self._field]
        return mesh

    def _show(self, number: int) -> None:
        meaning = f"{self._measure.name},\nover the largest" if self._modes else self._measure.said(self._length)
        for place, reader in enumerate(self._readers):
            mesh = self._moved(reader, number)
            mesh[meaning] = self._measure(mesh[self._field])
            surface = mesh.extract_surface(nonlinear_subdivision=SMOOTH) if _surfaces(mesh) else mesh
            self._plotter.add_mesh(surface, scalars=meaning, cmap=self._measure.colour_map, clim=self._range,
                                   line_width=WIDTH, name=f"now {place}", reset_camera=False, ambient=0.35,
                                   scalar_bar_args={"vertical": True, "color": "black", "title_font_size": 14,
                                                    "label_font_size": 14, "position_x": 0.86, "position_y": 0.15})
        load = mesh.cell_data["load"][0] if "load" in mesh.cell_data else None
        title = f"mode {number + 1}" if load is None else f"step {number}, load {with_unit(load, self._force)}"
        self._plotter.add_text(title, name="title", font_size=10, color="black")


def _surfaces(mesh) -> bool:
    return mesh.get_cell(0).dimension == 2
