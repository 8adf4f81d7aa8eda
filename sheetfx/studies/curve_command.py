"""The command `sheetfx curve`: a critical load of a scene against one of its options."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import typer

from .run import OF_A_FOLDER, RESUME, folder_of, option, scenes_app
from .study_command import value_of, varied_option

OWN = [
    option("against", str | None, None, "An option of the scene that is a number, and the range of its values.",
           "--against", metavar="OPTION=FROM:TO"),
    option("point", int, 1, "Number of the critical point along the path at the first value.", "--point", min=1),
    option("parts", int, 20, "Parts of the range, of which a step takes one or two.", "--parts", min=1),
    option("output", str | None, None, "Folder of the results; default results/NAME-curve.", "-o", "--output",
           metavar="PATH", rules=[OF_A_FOLDER]),
    RESUME,
]



def range_of(name: str, function, parameters: dict[str, Any], text: str | None) -> tuple[str, float, float]:
    """Option and range, from a text OPTION=FROM:TO.

    Raises
    ------
    ValueError
        Where the option is none of the scene, no number or given too, or a value is not fit for it.
    """
    if not text:
        raise ValueError(f"curve of {name}: nothing is varied; add --against option=from:to")
    said, flag = f"curve of {name}", "--against"

    def is_number(parameter) -> bool:
        return isinstance(parameters[parameter.name], float) or parameter.type.name == "float"

    parameter, values = varied_option(said, name, function, parameters, flag, text, is_number, " that is a number")
    ends = [value_of(f"{said}: {flag}", parameter, value.strip(), "from:to") for value in values.split(":")]
    if len(ends) != 2 or ends[0] == ends[1]:
        raise ValueError(f"{said}: {flag} {text}: give two values, as {parameter.name}=0:1")
    return parameter.name, float(ends[0]), float(ends[1])


def follow_scene(name: str, function: Callable, parameters: dict[str, Any], against: str | None, point: int, parts: int,
                 output: str | None, resume: bool) -> None:
    """Write and print the curve of one critical point; exit status 1 where it ends on the way."""
    from mpi4py import MPI

    from ..archive.folder import Archive
    from ..critical.curve import CriticalCurve, CurveEnds, CurvePoint, Kept
    from .curve import FILES, begun, curve_of, draw, written

    key, at, to = range_of(name, function, parameters, against)
    folder, comm = folder_of(name, output, "-curve"), MPI.COMM_WORLD
    mine, points, failure = folder / f"kept/{comm.rank}.npz", list[CurvePoint](), ""

    def case(value: float):
        return function(**parameters | {key: value})

    archive = Archive(folder, comm, FILES, lambda: f"{len(points)} point{'' if len(points) == 1 else 's'}")
    with archive.opened({"command": "curve", "scene": name, "against": against, "point": point, "parts": parts}
                        | parameters, resume):
        if resume and (folder / "curve.csv").exists():
            points += begun(folder)
        kept = Kept.load(mine) if points and comm.allreduce(int(mine.exists())) == comm.size else None
        first = case(at)
        curve = curve_of(name, first, case, point, key, (at, to), parts, kept and kept[0], points)
        if isinstance(curve, CriticalCurve):
            points = points[:kept[1] if kept else 0]
        elif comm.rank == 0:
            typer.echo("contact, what laws remember or forces without a potential: each point by its whole path")
        try:
            for one in curve:
                points.append(replace(one, modes=(), fields={}))
                if comm.rank == 0:
                    typer.echo(str(one).replace(" at ", f" at {key} = ", 1))
                    written(points, folder)
                if isinstance(curve, CriticalCurve) and curve.kept and not one.name:
                    mine.parent.mkdir(exist_ok=True)
                    curve.kept.save(mine, len(points))
        except CurveEnds as ends:
            failure = str(ends)
        if comm.rank == 0 and points:
            draw(points, key, first.axes[1], Path(name).stem, folder / "curve.png")
            typer.echo(f"{len(points)} points, {curve.factorisations} factorisations; results in {folder}")
    if failure:
        typer.echo(failure, err=True)
        raise typer.Exit(1)


curve_app = scenes_app(OWN, follow_scene, "Follow a critical load over the values of an option, from one path.",
                       "Trace the path of a scene, and follow one of its critical points over the values of an option.")
