"""The command `sheetfx`."""

from __future__ import annotations

import importlib
import importlib.util
import inspect
import os
import pkgutil
import sys
from pathlib import Path
from typing import Annotated

import click
import typer
from typer.core import TyperGroup

PLAIN = {"add_completion": False, "pretty_exceptions_enable": False}
app = typer.Typer(help="Stability of thin sheet-and-bar structures.", no_args_is_help=True, **PLAIN)


def scene_names() -> list[str]:
    """Names of the built-in scenes."""
    folder = Path(__file__).parent / "scenes"
    return sorted(m.name.replace("_", "-") for m in pkgutil.iter_modules([str(folder)]))


def load_scene(name: str):
    """The function `scene` of a built-in scene or of a user's script.

    Raises
    ------
    ValueError
        Where there is no such scene or script, or the script cannot be used.
    """
    if name.endswith(".py"):
        file = Path(name)
        if not file.is_file():
            raise ValueError(f"cannot read the script {name}: no such file; check the path")
        spec = importlib.util.spec_from_file_location(file.stem, file)
        module = importlib.util.module_from_spec(spec)
        sys.modules[file.stem] = module
        try:
            spec.loader.exec_module(module)
        except SyntaxError as error:
            raise ValueError(f"cannot read the script {name}: {error}; mend that line") from None
    elif name in scene_names():
        module = importlib.import_module(f"sheetfx.scenes.{name.replace('-', '_')}")
    else:
        raise ValueError(f"unknown scene {name!r}; choose one of {', '.join(scene_names())}, or a script ending in .py")
    if not hasattr(module, "scene"):
        raise ValueError(f"the script {name} has no function `scene` that returns a sheetfx.Case; add one")
    return module.scene


class Scenes(TyperGroup):
    """Sub-commands of `run`, made from the signature of each scene's function."""

    def list_commands(self, context):
        return scene_names()

    def get_command(self, context, name):
        try:
            function = load_scene(name)
        except ValueError as error:
            raise click.UsageError(str(error)) from None
        single = typer.Typer(**PLAIN)
        single.command(name=Path(name).stem, help=inspect.getdoc(function))(_runner(name, function))
        return typer.main.get_command(single)

    def format_commands(self, context, formatter):
        """List the names without importing every scene."""
        with formatter.section("Scenes"):
            formatter.write_text(", ".join(scene_names()) + "; or your own script.py with a function `scene`")


run_app = typer.Typer(cls=Scenes)
app.add_typer(run_app, name="run")


@run_app.callback(invoke_without_command=True, no_args_is_help=True)
def run_group(listing: Annotated[bool, typer.Option("--list", help="Print the names of all scenes.")] = False) -> None:
    """Trace the path of a scene and write its folder."""
    if listing:
        typer.echo("\n".join(scene_names()))
        raise typer.Exit


def _runner(name: str, function):
    """A command with the options of a scene's function and those of every run."""
    def command(output: Path | None, resume: bool, **parameters):
        run_scene(name, function, parameters, output, resume)

    own = [
        inspect.Parameter("output", inspect.Parameter.KEYWORD_ONLY, default=None, annotation=Annotated[
            Path | None, typer.Option("-o", "--output", help="Folder of the results; default results/NAME.")]),
        inspect.Parameter("resume", inspect.Parameter.KEYWORD_ONLY, default=False, annotation=Annotated[
            bool, typer.Option("--resume", help="Go on with an interrupted run in that folder.")]),
    ]
    signature = inspect.signature(function, eval_str=True)
    scene_parameters = [p.replace(kind=inspect.Parameter.KEYWORD_ONLY) for p in signature.parameters.values()]
    command.__signature__ = inspect.Signature(scene_parameters + own)
    return command


def run_scene(name: str, function, parameters: dict, output: Path | None, resume: bool) -> None:
    """Run one scene with progress on the terminal."""
    from .case import run
    from .show.progress import Progress

    folder = output or Path("results") / Path(name).stem
    with Progress(Path(name).stem, folder) as progress:
        case = function(**parameters)
        progress.begin(case)
        summary = run(case, Path(name).stem, parameters, folder, resume, [progress])
        progress.report(summary)
    if summary["status"] != "finished":
        raise typer.Exit(1)


@app.command()
def warm(scenes: Annotated[list[str] | None, typer.Argument(help="Names of scenes; default all.")] = None) -> None:
    """Compile the forms of scenes and of all shells, so that their first run starts at once."""
    from .discretise import Discretisation
    from .shell import FORMS

    for name in scenes or scene_names():
        typer.echo(f"compiling the forms of {name}")
        Discretisation(load_scene(name)().scene)
    for form in () if scenes else FORMS:
        typer.echo(f"compiling {form}")
        Discretisation(load_scene("hemisphere")(form=form).scene)


@app.command()
def chart(
    name: Annotated[str, typer.Argument(help="Name of a scene, or a script.")],
    repeat: Annotated[int, typer.Option(min=1, help="Runs of each method; the median counts.")] = 3,
    no_peers: Annotated[bool, typer.Option("--no-peers", help="Leave other programs out.")] = False,
    output: Annotated[Path | None, typer.Option("-o", "--output", help="Folder; default results/NAME-chart.")] = None,
) -> None:
    """Draw error against CPU time of a scene's meshes and forms, beside other programs."""
    from rich.console import Console

    from .show.chart import draw_chart, print_table, write_table
    from .study import family, measure

    console, title = Console(highlight=False), Path(name).stem
    reference, members, peers = family(name)
    points = measure(reference, members, [] if no_peers else peers, repeat,
                     lambda line: console.print(line, soft_wrap=True, markup=False))
    if not points:
        raise ValueError(f"chart of {name}: no method gave a result; the lines above say why")
    folder = output or Path("results") / f"{title}-chart"
    folder.mkdir(parents=True, exist_ok=True)
    write_table(points, folder / "chart.csv")
    draw_chart(points, title).savefig(folder / "chart.png", dpi=150)
    print_table(points, console)
    console.print(f"results in {folder}", soft_wrap=True)


@app.command(name="map")
def failure_map(
    traps: Annotated[str | None, typer.Option(help="Names of traps, separated by commas; default all.")] = None,
    methods: Annotated[str | None, typer.Option(help="Names of methods, separated by commas; default all.")] = None,
    output: Annotated[Path, typer.Option("-o", "--output", help="Folder of the results.")] = Path("results/map"),
    limit: Annotated[float, typer.Option(min=1, help="Seconds that a path may take.")] = 60.0,
) -> None:
    """Draw which method of path following passes which trap, and how the others fail."""
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

    from .failure_map import choose, failure_map, write_map
    from .methods import METHODS
    from .show.failure_map import draw_map
    from .traps import TRAPS

    rows, columns = choose("trap", traps, TRAPS), choose("method", methods, METHODS)
    layout = TextColumn("paths"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn()
    with Progress(*layout, transient=True) as progress:
        task = progress.add_task("", total=len(rows) * (len(columns) + 1))

        def say(cell) -> None:
            line = f"{cell.trap}, {cell.method}: {cell.outcome}{'; ' if cell.reason else ''}{cell.reason}"
            progress.console.print(line, soft_wrap=True, markup=False, highlight=False)
            progress.advance(task)

        cells = failure_map(rows, columns, output, limit, say)
        if not cells:
            raise ValueError("map: no method applies; those of contact need traps with contact")
    write_map(cells, output / "map.csv")
    draw_map(cells).savefig(output / "map.png", dpi=110)
    typer.echo(f"results in {output}")


def main() -> None:
    """Entry point: errors of input are one line that names object, value and remedy."""
    try:
        app()
    except (ValueError, FileNotFoundError) as error:
        if os.environ.get("SHEETFX_TRACEBACK"):
            raise
        sys.stderr.write(f"sheetfx: error: {error}\n")
        sys.exit(2)
