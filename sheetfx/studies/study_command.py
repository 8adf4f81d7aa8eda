"""The command `sheetfx study`: one scene with the values of some of its options varied."""

from __future__ import annotations

import inspect
import os
from collections.abc import Callable, Sequence
from typing import Any

import typer

from ..scenes import meant
from .run import OF_A_FOLDER, RESUME, folder_of, option, run_app, scenes_app

OWN = [
    option("vary", list[str] | None, None, "An option of the scene and its values, separated by commas; repeat it for "
           "all combinations with those of another option.", "--vary", metavar="OPTION=VALUE,..."),
    option("jobs", int, len(os.sched_getaffinity(0)), "Runs at a time, each on one thread; under mpirun "
           "one on each further process.", "--jobs", min=1),
    option("pictures", bool, False, "Let every run draw the pictures of its scene too.", "--pictures"),
    option("output", str | None, None, "Folder of the results; default results/NAME-study.", "-o", "--output",
           metavar="PATH", rules=[OF_A_FOLDER]),
    RESUME,
]



def variations(name: str, function, parameters: dict[str, Any], texts: Sequence[str]) -> dict[str, list[Any]]:
    """Values of each varied parameter, from texts OPTION=VALUE,VALUE; parts of one value are separated by spaces.

    Raises
    ------
    ValueError
        Where an option is not one of the scene, is given too, or a value is not fit for it.
    """
    if not texts:
        raise ValueError(f"study of {name}: nothing is varied; add --vary option=value,value")
    said = f"study of {name}"
    varied: dict[str, list[Any]] = {}
    for text in texts:
        parameter, values = varied_option(said, name, function, parameters, "--vary", text)
        key = parameter.name
        if key in varied:
            raise ValueError(f"{said}: --vary {key} is given twice; give all its values at once")
        varied[key] = [value_of(f"{said}: --vary", parameter, value.strip(), "value,value")
                       for value in values.split(",")]
        if repeated := [value for n, value in enumerate(varied[key]) if value in varied[key][:n]]:
            raise ValueError(f"study of {name}: --vary {text}: {repeated[0]} is there twice; leave one out")
    return varied


def varied_option(said: str, name: str, function, parameters: dict[str, Any], flag: str, text: str,
                  fit: Callable[[Any], bool] = lambda parameter: True, which: str = "") -> tuple[Any, str]:
    """Option of a scene's command, and the text of its values, from a text OPTION=VALUES.

    Parameters
    ----------
    said, flag : the command and its option, for errors
    fit, which : whether an option may be varied, and how those are called that may

    Raises
    ------
    ValueError
        Where the option is not one of those, or is given too.
    """
    key, _, values = text.partition("=")
    key = key.strip().lstrip("-").replace("-", "_")
    signature = inspect.signature(function).parameters
    command = typer.main.get_command(run_app).get_command(None, name)
    fitting = [p for p in command.params if p.name in signature and fit(p)]
    known = {name: p for p in fitting for name in (p.name, p.opts[0].lstrip("-").replace("-", "_"))}
    if key not in known:
        names = [p.opts[0].lstrip("-") for p in fitting]
        raise ValueError(f"{said}: {flag} {text}: no option {key!r}{which}; {meant(key, names)}choose from "
                         f"{', '.join(names)}")
    parameter = known[key]
    if parameters[parameter.name] != signature[parameter.name].default:
        raise ValueError(f"{said}: {key} is both {parameters[parameter.name]} and varied; leave one out")
    return parameter, values


def value_of(said: str, parameter, text: str, form: str) -> Any:
    """A value of an option of a scene, as its command would read it; `form` is of all its values, for errors."""
    if not text:
        raise ValueError(f"{said} {parameter.name}: a value is missing; say {parameter.name}={form}")
    try:
        return parameter.process_value(None, text.split() if parameter.nargs > 1 else text)
    except typer.BadParameter as error:
        why = error.message if repr(text) in error.message else f"{text!r}: {error.message}"  # as typer has it
        raise ValueError(f"{said} {parameter.name}: {why}") from None


def study_scene(name: str, function, parameters: dict[str, Any], vary: list[str] | None, jobs: int, pictures: bool,
                output: str | None, resume: bool) -> None:
    """Trace a study and compare its runs, with progress on the terminal; exit status 1 where one failed."""
    from pathlib import Path

    from mpi4py import MPI
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

    from .study import FINISHED, Study, trace_study
    from .study_picture import describe, draw_study, print_table, write_points, write_table

    varied = variations(name, function, parameters, vary or [])
    study = Study(name, {key: value for key, value in parameters.items() if key not in varied}, varied)
    folder = folder_of(name, output, "-study")
    layout = TextColumn("runs"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn()
    with Progress(*layout, transient=True, disable=MPI.COMM_WORLD.rank > 0) as progress:
        task = progress.add_task("", total=len(study.runs(folder)))

        def say(run) -> None:
            progress.console.print(describe(run), soft_wrap=True, markup=False, highlight=False)
            progress.advance(task)

        runs = trace_study(study, folder, jobs, resume, pictures, say)
    axes = function(**study.fixed | runs[0].chosen).axes
    if MPI.COMM_WORLD.rank:
        return
    write_table(runs, folder / "study.csv")
    write_points(runs, folder / "critical_points.csv")
    print_table(runs, Console(highlight=False))
    if any(run.states for run in runs):
        draw_study(runs, Path(name).stem, axes).savefig(folder / "study.png", dpi=150)
    unfinished = [run for run in runs if run.status != FINISHED]
    typer.echo(f"{len(runs)} runs, {len(unfinished)} failed; results in {folder}")
    if unfinished:
        raise typer.Exit(1)


study_app = scenes_app(OWN, study_scene, "Run a scene with several values of its options, and compare the paths.",
                       "Run a scene with all combinations of values of its options, and compare their paths.")
