"""Progress of a run on the terminal."""

from __future__ import annotations

import time
from pathlib import Path

from mpi4py import MPI
from rich.console import Console
from rich.live import Live
from rich.table import Table
from rich.text import Text

from ..continuation.state import State
from ..model.reported import NOT_ASKED
from .evaluate import told
from .shown import ShownCase

INTERVAL = 10.0  # seconds


class Progress:
    """One line that follows the path on a terminal; a line every 10 s elsewhere, and on several processes.

    A reader of a log sees by that interval that the run lives. The last state is always told.

    Only process 0 prints.
    """

    def __init__(self, name: str, folder: Path):
        self.name, self.folder = name, folder
        comm = MPI.COMM_WORLD  # mpirun gives its processes terminals, whatever it writes to itself
        self.console = Console(quiet=comm.rank > 0, highlight=False, force_terminal=False if comm.size > 1 else None)
        self._live = Live(Text(f"{name}: compiling forms, meshing"), console=self.console, transient=True)
        self._until, self._stages, self._load, self._deflection = None, [], "load", "deflection"
        self._start = self._told = time.perf_counter()
        self._last: State | None = None  # that is not told yet

    def __enter__(self) -> Progress:
        if self.console.is_terminal:
            self._live.start()
        return self

    def __exit__(self, *_) -> None:
        if self.console.is_terminal:
            self._live.stop()
        self._tell()

    def begin(self, case: ShownCase) -> None:
        self._until = case.until
        self._stages = [stage.name for stage in case.scene.all_stages]
        self._deflection, self._load = (told(axis, plain) for axis, plain in zip(
            case.axes, ("deflection", "load"), strict=True))

    def __call__(self, state: State) -> None:
        for point in state.critical:
            coefficients = "" if point.slope is None else f", a = {point.slope:.4g}"
            coefficients += "" if point.curvature is None else f", b = {point.curvature:.4g}"
            self.console.print(f"{point.title}: {self._load} {point.load:.6g} at {self._deflection} "
                               f"{point.deflection:.6g} "
                               f"(step {point.step}){coefficients}", soft_wrap=True)
        if self.console.is_terminal:
            self._live.update(Text(self._line(state)))
            return
        self._last = state
        if time.perf_counter() - self._told >= INTERVAL:
            self._tell()

    def tell(self, text: str) -> None:
        """Print a line."""
        self.console.print(text, soft_wrap=True)

    def _tell(self) -> None:
        if self._last is not None:
            self.console.print(self._line(self._last), soft_wrap=True)
            self._told, self._last = time.perf_counter(), None

    def _line(self, state: State) -> str:
        stage = f", stage {self._stages[state.stage]!r}" if len(self._stages) > 1 else ""
        line = (f"{self.name}{stage}: step {state.step}, {self._load} {state.load:.5g}, "
                f"{self._deflection} {state.deflection:.5g}, {state.iterations} iterations")
        if state.contact_points:
            line += f", {state.contact_points} contact points"
        if state.unstable_modes:
            line += f", {state.unstable_modes} unstable modes"
        return line + self._rest(state)

    def _rest(self, state: State) -> str:
        """Estimated rest, from the share of the final deflection that is reached."""
        if self._until is None or not self._until.deflection or state.step < 3:
            return ""
        share = min(1.0, abs(state.deflection) / self._until.deflection)
        spent = time.perf_counter() - self._start
        return f", about {spent * (1 - share) / share:.0f} s to go" if share > 0 else ""

    def report(self, summary: dict) -> None:
        """Print the result of a run; why it stopped is an error, and goes where errors do."""
        self._tell()
        stopped = summary["status"] != "finished"
        console = Console(stderr=True, quiet=self.console.quiet, highlight=False) if stopped else self.console
        console.print(f"{summary['status']}: {summary['message']}", soft_wrap=True)
        for sentence in summary["searched"]:
            self.console.print(f"  {sentence}", soft_wrap=True, style="dim")
        for point in summary["critical_points"]:
            if said := _error(point):
                self.console.print(f"  {said}", soft_wrap=True)
        table = Table(show_header=False, box=None)
        for key, value in summary["quantities"].items():
            table.add_row(key.replace("_", " "), f"{value:.6g}")
        table.add_row("load", summary["load"])
        table.add_row("energy balance", _balance(summary["energy"]))
        table.add_row("steps, iterations", f"{summary['steps']}, {summary['iterations']}")
        table.add_row("unknowns", str(summary["unknowns"]))
        spent = summary["timings"]
        table.add_row("CPU seconds", f"{spent['total']:.2f}, of the path {spent['path']:.2f}, of pictures and files "
                                     f"{spent['output']:.2f}")
        table.add_row("results in", str(self.folder))
        self.console.print(table)


def _error(point: dict) -> str:
    """The text on the error of a critical load that was asked for; "": nothing."""
    load, error, reason = f"{point['kind']} point at load {point['load']:.6g}", point["error"], point["error_reason"]
    if error is None:
        return "" if reason == NOT_ASKED or point["kind"] == "event" else f"{load}: no error estimate ({reason})"
    share = f" ({abs(error / point['load']):.2g} of it)" if point["load"] else ""
    doubt = f"; {reason}" if reason else ""
    return f"{load} is too {'high' if error > 0 else 'low'} by about {abs(error):.2g}{share}{doubt}"


def _balance(energy: dict) -> str:
    """The text on the balance of energy."""
    if energy["off"] is None:
        return f"not known: {', '.join(energy['not_balanced'])}"
    return f"holds to {energy['off']:.1e}; steps as long as these show it to {energy['accuracy']:.1e}"
