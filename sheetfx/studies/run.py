"""The command `sheetfx run`: one scene as a command with options of its own, and its run with progress."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Annotated, Any

import typer
from typer.core import TyperCommand, TyperGroup

from ..checks import POSITIVE, Like, require
from ..scenes import load_case, option_of, scene_names
from .suggesting import Completed, Single, scripts

FINEST = 4  # times that --within halves cells
PLAIN = {"add_completion": False, "pretty_exceptions_enable": False}


def option(name: str, annotation, default, help_text: str, *flags: str, rules: Sequence = (),
           **settings) -> inspect.Parameter:
    """A parameter of a command that is an option; `rules` are of `checks`."""
    return inspect.Parameter(name, inspect.Parameter.KEYWORD_ONLY, default=default, annotation=Annotated[
        annotation, *rules, typer.Option(*flags, help=help_text, **settings)])


OF_A_FOLDER = Like("a text", lambda name: name is None or isinstance(name, str))  # "" is refused by `folder_of`
OUTPUT = option("output", str | None, None, "Folder of the results; default results/NAME.", "-o", "--output",
                metavar="PATH", rules=[OF_A_FOLDER])
RESUME = option("resume", bool, False, "Go on with an interrupted run in that folder, or begin it there.", "--resume")
BALANCE = option("balance", float | None, None, "Accuracy of the energy balance, such as 1e-6; finds more states "
                 "within steps, in about the time of the path.", "--balance", rules=[POSITIVE])
ANIMATE = option("animate", bool, False, "Draw animation.gif, the motion along the path.", "--animate")
NO_PICTURES = option("no_pictures", bool, False, "Draw no pictures, and write no files for ParaView.", "--no-pictures")
ERROR = option("error", bool | None, None, "Estimate the discretisation error of critical loads; default: where it "
               "costs a quarter of the path at most.", "--error/--no-error")
WITHIN = option("within", str | None, None, "Find critical points again on finer meshes until errors are less than "
                "that share of their loads, such as 1%.", "--within", metavar="SHARE")
SNAPS = option("snaps", bool, False, "Let the structure fall where it has lost its stability, and go on from there.",
               "--snaps")
TABLES = option("tables", bool, False, "Write reactions, energies and section forces of all states as CSV.", "--tables")


class Scenes(TyperGroup):
    """Sub-commands of `run`, made from the signature of each scene's function.

    Attributes
    ----------
    runner : function (name, function of the scene) -> function that becomes the command
    """

    @staticmethod
    def runner(name: str, function):
        """A command with the options of a scene's function and of every run."""
        return with_options(run_scene, name, function,
                            [OUTPUT, RESUME, TABLES, BALANCE, ERROR, WITHIN, ANIMATE, NO_PICTURES, SNAPS])

    def list_commands(self, context):
        return scene_names()

    def get_command(self, context, name):
        try:
            function = load_case(name)
        except ValueError as error:
            context.fail(str(error))
        single = typer.Typer(**PLAIN)
        single.command(name=Path(name).stem, help=inspect.getdoc(function), cls=Single)(
            self.runner(name, function))
        return typer.main.get_command(single)

    def shell_complete(self, context, incomplete):
        """Names of scenes, and scripts, without importing any."""
        names = [name for name in scene_names() if name.startswith(incomplete)]
        options = TyperCommand.shell_complete(self, context, incomplete) if incomplete.startswith("-") else []
        return [*map(Completed, (*names, *scripts(incomplete))), *options]

    def format_help(self, context, formatter):
        self.epilog = ("A script of your own stands in place of a scene: it has a function `case` that returns a "
                       "sheetfx.Case, and whose annotated parameters become options.\n\n"
                       f"Example: {context.command_path} FOLDER/script.py --size 2.0, where the script has "
                       "def case(size: float = 1.0) -> fx.Case")
        super().format_help(context, formatter)


run_app = typer.Typer(cls=Scenes)


@run_app.callback(invoke_without_command=True, no_args_is_help=True)
def run_group(listing: Annotated[bool, typer.Option("--list", help="Print the names of all scenes.")] = False) -> None:
    """Trace the path of a scene and write its folder."""
    if listing:
        typer.echo("\n".join(scene_names()))
        raise typer.Exit


def with_options(do: Callable[..., None], name: str, function, own: Sequence[inspect.Parameter]):
    """A command that takes the parameters of a scene's function as options, and some of its own.

    Parameters
    ----------
    do : function (name, function of the scene, its parameters, **own)
    """
    parameters = inspect.signature(function, eval_str=True).parameters.values()

    def command(**options):
        for parameter in own:
            require("sheetfx", **{option_of(parameter): (options[parameter.name], parameter.annotation)})
        mine = {parameter.name: options.pop(parameter.name) for parameter in own}
        do(name, function, options, **mine)

    command.__signature__ = inspect.Signature([
        *(p.replace(kind=inspect.Parameter.KEYWORD_ONLY) for p in parameters), *own])
    return command


def scenes_app(own: Sequence[inspect.Parameter], do: Callable[..., None], summary: str, what: str) -> typer.Typer:
    """Commands that do something with one scene each, with its options and some of their own.

    Parameters
    ----------
    own : options, named as parameters of `do`
    do : function (name, function of the scene, its parameters, **own)
    summary, what : help of the group in the list of commands, and of itself
    """
    class Commands(Scenes):
        """Sub-commands, one for each scene."""

        @staticmethod
        def runner(name: str, function):
            return with_options(do, name, function, own)

    def group() -> None:
        pass

    group.__doc__ = what
    app = typer.Typer(cls=Commands, no_args_is_help=True, help=summary)
    app.callback()(group)
    return app


def folder_of(name: str, output: str | None, ending: str = "") -> Path:
    """Folder of a command's results."""
    if output == "":
        raise ValueError("-o: the name '' is empty; give the name of a folder, or leave -o out")
    return Path("results") / f"{Path(name).stem}{ending}" if output is None else Path(output)


def share_of(text: str) -> float:
    """A share from a text such as "2%" or "0.02".

    Raises
    ------
    ValueError
        If it is no number above 0 and below 1.
    """
    number = text.strip()
    try:
        share = float(number.removesuffix("%")) / (100.0 if number.endswith("%") else 1.0)
    except ValueError:
        share = 0.0
    if not 0.0 < share < 1.0:
        raise ValueError(f"--within is {text!r}; it must be a share above 0 and below 1, such as 2% or 0.02")
    return share


def run_scene(name: str, function, parameters: dict, output: str | None, resume: bool, tables: bool,
              balance: float | None, error: bool | None, within: str | None, animate: bool, no_pictures: bool,
              snaps: bool) -> None:
    """Run one scene with progress on the terminal."""
    from ..case import run
    from ..ladder.meshes import by_halving, by_option
    from ..show.animating import animation
    from ..show.progress import Progress
    from ..show.tables import tables as written

    folder, share = folder_of(name, output), None if within is None else share_of(within)
    with Progress(Path(name).stem, folder) as progress:
        case = function(**parameters)
        pictures = [*(() if no_pictures else case.pictures), *([written] if tables else []),
                    *([animation] if animate else [])]
        case = replace(case, pictures=pictures, balance=balance or case.balance,
                       error=case.error if error is None else error, snaps=case.snaps or snaps)
        meshes = None if share is None else (by_option(function, parameters, FINEST) or by_halving(case, FINEST))
        further = meshes and partial(_refined, meshes, share, progress.tell)
        progress.begin(case)
        bars = partial(_bars, partial(by_option, function, parameters))
        summary = run(case, Path(name).stem, parameters, folder, resume, [progress], further, bars)
        progress.report(summary)
    if summary["status"] != "finished":
        raise typer.Exit(1)


def _bars(meshes: Callable[[], Any], record) -> None:
    """Error bars of a record beside its structure with larger cells."""
    from ..ladder.coarser_bars import error_bars_beside

    error_bars_beside(record, meshes())


def _refined(meshes, share: float, told: Callable[[str], None], record) -> dict:
    """Critical points of a record on finer meshes, for its summary."""
    from ..ladder.refined import Refinement

    found = Refinement(record, meshes, share, lambda refined: told(str(refined))).all()
    return {"refined": [vars(one) | {"point": record.critical_points.index(one.point)} for one in found]}
