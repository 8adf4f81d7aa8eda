"""The command `sheetfx`."""

from __future__ import annotations

import atexit
import gc
import json
import os
import sys
import traceback
import warnings
from pathlib import Path
from typing import Annotated

import typer

from .archive.folder import Stopped, write_whole
from .interrupts import release, tell
from .scenes import load_case, of_script, scene_names
from .studies.advise_command import advise_app
from .studies.curve_command import curve_app
from .studies.depends_command import depends_app
from .studies.diagram_command import diagram_app
from .studies.imperfections_command import imperfections_app
from .studies.map_command import Listing, draw_failure_map
from .studies.run import PLAIN, run_app
from .studies.study_command import study_app
from .studies.suggesting import Resumed, Single, Suggesting, with_choices
from .studies.view_command import view

app = typer.Typer(help="Stability of thin sheet-and-bar structures.", no_args_is_help=True, cls=Suggesting,
                  **PLAIN | {"add_completion": True})
app.add_typer(run_app, name="run")
app.add_typer(diagram_app, name="diagram")
app.add_typer(depends_app, name="depends")
app.add_typer(curve_app, name="curve")
app.add_typer(imperfections_app, name="imperfections")
app.add_typer(advise_app, name="advise")
app.add_typer(study_app, name="study")
app.command(cls=Single)(view)
app.command(name="map", cls=Listing)(draw_failure_map)


def _charts() -> str:
    from .studies.chart import charts

    return (f"Scenes with a chart of their own: {', '.join(charts())}, and scripts with REFERENCE and CHART; others "
            "have one of what advise climbs: first critical loads without and with contact, friction, plasticity.")


def _tell_version(asked: bool) -> None:
    if asked:
        from . import __version__

        typer.echo(f"sheetfx {__version__}")
        raise typer.Exit


@app.callback()
def every_command(
    context: typer.Context,
    trace: Annotated[bool, typer.Option("--traceback", help="Show where in the program an error arose.")] = False,
    quiet: Annotated[bool, typer.Option("--quiet", "-q", help="Tell errors and warnings only.")] = False,
    version: Annotated[bool, typer.Option("--version", help="Print the version.", is_eager=True,
                                          callback=_tell_version)] = False,
) -> None:
    """Stability of thin sheet-and-bar structures."""
    if trace:
        os.environ["SHEETFX_TRACEBACK"] = "1"  # for processes that it starts, too
    if quiet:
        sys.stdout = context.with_resource(open(os.devnull, "w"))  # noqa: SIM115  closed with the context


@app.command(cls=Single)
def warm(scenes: Annotated[list[str] | None, typer.Argument(help="Names of scenes; default all.")] = None) -> None:
    """Compile the forms of scenes and of all shells, so that their first run starts at once."""
    from .discrete.discretisation import Discretisation
    from .model.shell import FORMS

    for name in scenes or scene_names():
        typer.echo(f"compiling the forms of {name}")
        Discretisation(load_case(name)().scene)
    for form in () if scenes else FORMS:
        typer.echo(f"compiling {form}")
        Discretisation(load_case("hemisphere")(form=form).scene)


@app.command(cls=with_choices(_charts))
def chart(
    name: Annotated[str, typer.Argument(help="Name of a scene, or a script.")],
    repeat: Annotated[int, typer.Option(min=1, help="Runs of each method; the median counts.")] = 3,
    no_peers: Annotated[bool, typer.Option("--no-peers", help="Leave other programs out.")] = False,
    output: Annotated[Path | None, typer.Option("-o", "--output", help="Folder; default results/NAME-chart.")] = None,
    resume: Resumed = False,
) -> None:
    """Draw error against CPU time of a scene's meshes and forms, beside other programs, or of its ladder of models.

    The table chart.csv has each result as soon as it is there.
    """
    from rich.console import Console

    from .studies.chart import family, measure
    from .studies.chart_picture import draw_chart, print_table, write_table

    console, title = Console(highlight=False), Path(name).stem
    folder = output or Path("results") / f"{title}-chart"
    folder.mkdir(parents=True, exist_ok=True)
    kept = folder / "runs.json"
    earlier = json.loads(kept.read_text()) if resume and kept.exists() else {"scene": title, "runs": None}

    def say(line: str) -> None:
        console.print(line, soft_wrap=True, markup=False)

    if earlier.get("scene") != title:
        raise ValueError(f"--resume: the chart in {folder} is of {earlier.get('scene', 'an older version')}, not of "
                         f"{title}; choose another folder with -o")

    reference, members, peers = family(name, say, earlier.get("reference"))

    def keep(points, runs) -> None:
        write_table(points, folder / "chart.csv")
        write_whole(kept, json.dumps({"scene": title, "runs": runs, "reference": reference}))
        tell(lambda: f"{sum(map(len, runs.values()))} runs are kept in {folder}")

    points = measure(reference, members, [] if no_peers else peers, repeat, say, keep, earlier["runs"])
    if not points:
        raise ValueError(f"chart of {name}: no method gave a result; the lines above say why")
    draw_chart(points, title).savefig(folder / "chart.png", dpi=150)
    print_table(points, console)
    console.print(f"results in {folder}", soft_wrap=True)


def main() -> None:
    """Entry point: errors and warnings are one line; on input they name object, value and remedy."""
    warnings.showwarning = _warn
    atexit.register(gc.freeze)  # at the end, too, nothing needs to be looked through that goes with the process
    try:
        try:
            sys.exit(app(prog_name="sheetfx", standalone_mode=False))
        finally:
            release()
    except Exception as error:
        if os.environ.get("SHEETFX_TRACEBACK") and not hasattr(error, "format_message"):
            raise
        said = _said(error)
        sys.stderr.write(f"sheetfx: error: {said}\n")
        if isinstance(error, Stopped):
            _end_other_processes()
        sys.exit(1 if isinstance(error, Stopped) else 2)


def _warn(message, category, filename, lineno, file=None, line=None) -> None:
    """A warning in one line, with the line of the user's script that it is about, if any."""
    scripts = [Path(word).resolve() for word in sys.argv if word.endswith(".py") and Path(word).is_file()]
    own = any(Path(filename).resolve().is_relative_to(script.parent) for script in scripts)
    where = f"{filename}, line {lineno}: " if own else ""
    sys.stderr.write(f"sheetfx: warning: {where}{message}\n")


def _said(error: Exception) -> str:
    """An error in one line; what passed through a script of the user's names its line.

    Errors of the words themselves, which typer finds, have a method `format_message` in all its versions.
    """
    if hasattr(error, "format_message"):
        command = f"{error.ctx.command_path} --help" if error.ctx else "--help"
        return f"{' '.join(error.format_message().split()).rstrip('.')}; {command} says more"
    files = {Path(frame.filename).resolve() for frame in traceback.extract_tb(error.__traceback__)}
    script = next((word for word in sys.argv if word.endswith(".py") and Path(word).resolve() in files), None)
    if script is not None and not isinstance(error, Stopped):
        return of_script(script, error)
    if isinstance(error, (ValueError, FileNotFoundError, Stopped)):
        return str(error)
    return f"{type(error).__name__}: {error}; sheetfx --traceback ... shows where"


def _end_other_processes() -> None:
    """Processes of an MPI run, which wait for one that the system has stopped."""
    from mpi4py import MPI

    if MPI.COMM_WORLD.size > 1:
        sys.stderr.flush()
        MPI.COMM_WORLD.Abort(1)
