"""The command `sheetfx diagram`: the bifurcation diagram of one scene, with the options of the scene."""

from __future__ import annotations

import os

import typer

from ..checks import POSITIVE
from .run import OF_A_FOLDER, RESUME, folder_of, option, scenes_app

OWN = [
    option("levels", int, 1, "Levels of branches: 1, those of the primary path; 2, theirs too.", "--levels", min=0),
    option("max_load", float | None, None, "Load at which every path ends; default as the scene's path.",
           "--max-load", rules=[POSITIVE]),
    option("max_deflection", float | None, None, "Deflection at which every path ends, likewise.", "--max-deflection",
           rules=[POSITIVE]),
    option("max_steps", int, 200, "Steps of each path.", "--max-steps", min=1),
    option("processes", int, len(os.sched_getaffinity(0)), "Branches traced at a time; under mpirun one on each "
           "further process.", "--processes", min=1),
    option("output", str | None, None, "Folder of the results; default results/NAME-diagram.", "-o", "--output",
           metavar="PATH", rules=[OF_A_FOLDER]),
    RESUME,
]



def draw_scene(name: str, function, parameters: dict, levels: int, max_load: float | None,
               max_deflection: float | None, max_steps: int, processes: int, output: str | None, resume: bool) -> None:
    """Trace and draw a diagram with progress on the terminal; exit status 1 where a path failed."""
    from mpi4py import MPI
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

    from .diagram import Plan, bounds_of, everything, trace_diagram
    from .diagram_picture import describe, draw_diagram

    folder, case = folder_of(name, output, "-diagram"), function(**parameters)
    plan = Plan(name, parameters, bounds_of(case, max_load, max_deflection, max_steps), levels, processes)
    layout = TextColumn("branches"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn()
    with Progress(*layout, transient=True, disable=MPI.COMM_WORLD.rank > 0) as progress:
        task, ended = progress.add_task("", total=1), 0

        def say(branch, left: int) -> None:
            nonlocal ended
            ended += 1
            progress.console.print(describe(branch), soft_wrap=True, markup=False, highlight=False)
            progress.update(task, completed=ended, total=ended + left)

        primary = trace_diagram(plan, folder, resume, say)
    if primary is None:
        return
    if primary.result["states"]:
        draw_diagram(primary, case.axes).savefig(folder / "diagram.png", dpi=150)
    for branch in everything(primary):
        if branch.reverse_of:
            typer.echo(f"branch {branch.name} is branch {branch.reverse_of} from its other end")
    failed = [branch for branch in everything(primary) if branch.result["status"] == "failed"]
    typer.echo(f"{sum(1 for _ in everything(primary))} paths, {len(failed)} failed; results in {folder}")
    if failed:
        raise typer.Exit(1)


diagram_app = scenes_app(OWN, draw_scene, "Follow the branches of a scene's path, and draw its bifurcation diagram.",
                         "Follow the branches of a scene's path, theirs in turn, and draw its bifurcation diagram.")
