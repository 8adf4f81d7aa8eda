"""The command `sheetfx imperfections`: the worst and the likely imperfections of a scene."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict
from functools import partial
from pathlib import Path
from typing import Any

import typer

from ..checks import POSITIVE
from .run import OF_A_FOLDER, RESUME, folder_of, option, scenes_app

MOST = 500  # loads for a quantile, whose time goes with their fourth power

OWN = [
    option("amplitude", float | None, None, "Size of the worst imperfection: the norm of the coefficients of shapes, "
           "whose largest displacement is 1.", "--amplitude", rules=[POSITIVE], metavar="LENGTH"),
    option("shapes", int, 4, "Number of shapes.", "--shapes", min=1),
    option("correlation", float | None, None, "Shapes are those of a random field along the normal, whose correlation "
           "is 1/e at this distance; default: the softest modes at the first critical point.", "--correlation",
           rules=[POSITIVE], metavar="LENGTH"),
    option("nodes", bool, False, "Shapes are single nodes: along the normal, of bars in space in three directions.",
           "--nodes"),
    option("quantile", list[float], [0.05], "Probability that the load is less, which may be given several times.",
           "--quantile", rules=[], metavar="SHARE"),
    option("deviation", float | None, None, "Standard deviation of each coefficient; default: the amplitude.",
           "--deviation", rules=[POSITIVE], metavar="LENGTH"),
    option("samples", int, 50, "Paths for each quantile; 0: no quantiles.", "--samples", min=0, max=MOST),
    option("starts", int, 3, "Searches for the worst shape.", "--starts", min=1),
    option("reduced", int, 0, "Loads by the energy of the softest modes (Koiter), which takes no paths, for each "
           "quantile; the search then starts from its worst shapes. 0: it is not made.", "--reduced", min=0, max=MOST),
    option("seed", int, 0, "Of the random numbers.", "--seed", min=0),
    option("output", str | None, None, "Folder of the results; default results/NAME-imperfections.", "-o", "--output",
           metavar="PATH", rules=[OF_A_FOLDER]),
    RESUME,
]



def search_scene(name: str, function: Callable, parameters: dict[str, Any], amplitude: float | None,
                 deviation: float | None, output: str | None, resume: bool, **options) -> None:
    """Write and print the worst imperfection and the quantiles of one scene."""
    from mpi4py import MPI

    from ..archive.folder import Archive
    from ..critical.imperfections import Imperfections
    from ..critical.worst import ImperfectLoad
    from ..show.evaluate import unit_of, with_unit
    from . import imperfections as study
    from .shape_files import draw_shape, write_shape

    if amplitude is None:
        raise ValueError(f"imperfections of {name}: no size is given; add --amplitude, a length")
    if wrong := [probability for probability in options["quantile"] if not 0 < probability < 0.5]:
        raise ValueError(f"imperfections of {name}: --quantile is {wrong[0]:g}; it must be above 0 and below 0.5")
    if options["nodes"] and options["correlation"] is not None:
        raise ValueError(f"imperfections of {name}: --nodes and --correlation are both given; leave one out")
    if alone := [flag for flag in ("samples", "reduced") if options[flag] == 1]:
        raise ValueError(f"imperfections of {name}: --{alone[0]} is 1; it must be 0 or at least 2")
    search = study.Search(amplitude=amplitude, deviation=deviation or amplitude, **options)
    folder, comm = folder_of(name, output, "-imperfections"), MPI.COMM_WORLD
    mine, loads = folder / f"kept/{comm.rank}.npz", list[ImperfectLoad]()

    def told(one: ImperfectLoad) -> None:
        loads.append(one)
        if comm.rank == 0:
            typer.echo(f"{len(loads)}: {one}")
            study.write_loads(loads, folder)

    archive = Archive(folder, comm, study.FILES, lambda: f"{len(loads)} path{'' if len(loads) == 1 else 's'}")
    with archive.opened({"command": "imperfections", "scene": name} | asdict(search) | parameters, resume):
        case = function(**parameters)
        record, ideal = study.perfect(name, case, search.shapes)
        if resume and comm.allreduce(int(mine.exists())) == comm.size:
            ideal = study.Perfect.load_from(mine)
            loads += study.read_loads(folder)
        else:
            ideal.save(mine)
        if comm.rank == 0:
            typer.echo(f"perfect: {ideal.kind} at load {ideal.load:.6g}")
        shapes = search.shapes_of(case, ideal)
        paths = Imperfections(case.scene, shapes, partial(study.path_of, case), known=loads, told=told)
        near, told_by_energy = study.by_energy(search, record, ideal, paths)
        worst, quantiles = search.results(paths, near)
        title = f"worst imperfection: {with_unit(worst[0].load, unit_of(case.axes[1]))}"
        write_shape(folder / "worst.csv", case.scene, shapes, worst[0].coefficients)
        draw_shape(folder / "worst.png", record, shapes, worst[0].coefficients, title)
        if comm.rank == 0:
            about = {"perfect": ideal.load, "shapes": len(shapes), "paths": len(loads)} | told_by_energy
            study.write_results(folder, search, about, worst, quantiles)
            study.draw(folder, case.axes[1], Path(name).stem, ideal.load, loads, worst[0], quantiles)
            typer.echo("\n".join([f"worst of size {amplitude:g}: {worst[0]}", *map(str, quantiles),
                                  f"{len(loads)} paths; results in {folder}"]))


imperfections_app = scenes_app(
    OWN, search_scene, "Find the worst imperfection of a size, and quantiles of the critical load.",
    "Search the imperfections of a scene for the worst one, and for the quantiles of critical loads.")
