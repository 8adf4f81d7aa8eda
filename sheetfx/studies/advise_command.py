"""The command `sheetfx advise`: the least model that a critical load needs, and the load by it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer

from .run import OF_A_FOLDER, folder_of, option, scenes_app, share_of

if TYPE_CHECKING:
    from ..ladder.decision import Advice
    from ..ladder.meshes import Meshes

SCRIPT = '''"""Enough of {name} for its first critical load to {within:.3g}, by `sheetfx advise`: {words}, {mesh}."""

import sheetfx as fx


def case() -> fx.Case:
    """The scene without what its first critical load does not need."""
    case = {scene}
    case = {made}
    return fx.LeftOut({left}).of(case)
'''
OWN = [
    option("within", str, "2%", "Half of the interval of the load, over the load.", "--within", metavar="SHARE"),
    option("finest", int, 2, "How often cells may be halved beyond those of the scene.", "--finest", min=0, max=4),
    option("refine", str | None, None, "An option of the scene that makes its mesh, a number of cells or their size; "
           "default: cells, elements or divisions, else gmsh halves cells.", "--refine", metavar="OPTION"),
    option("output", str | None, None, "Folder of the results; default results/NAME-advice.", "-o", "--output",
           metavar="PATH", rules=[OF_A_FOLDER]),
]


def advise_scene(name: str, function: Callable, parameters: dict[str, Any], within: str, finest: int,
                 refine: str | None, output: str | None) -> None:
    """Write and print the advice; exit status 1 where there is no load."""
    from mpi4py import MPI

    from ..archive.folder import Archive, write_whole
    from ..ladder.climb import Climb
    from ..ladder.decision import Decision
    from ..ladder.meshes import by_halving, by_option

    share, folder = share_of(within), folder_of(name, output, "-advice")
    archive = Archive(folder, MPI.COMM_WORLD, ("advice.json", "advised.py"))
    own = {"within": share, "finest": finest, "refine": refine}
    with archive.opened({"command": "advise", "scene": name} | own | parameters, False):

        def told(decision: Decision) -> None:
            if archive.comm.rank == 0:
                typer.echo(str(decision))

        meshes = by_option(function, parameters, finest, refine) or by_halving(function(**parameters), finest)
        advice = Climb(meshes, share, told).advice()
        if archive.comm.rank == 0:
            archive.write_json("advice.json", {"scene": name, "parameters": parameters} | own | written(advice))
            write_whole(folder / "advised.py", _script(name, parameters, share, meshes, advice))
            typer.echo(str(advice))
            typer.echo(f"results in {folder}; sheetfx run {folder / 'advised.py'} runs the model")
    if advice.load is None:
        raise typer.Exit(1)


def written(advice: Advice) -> dict[str, Any]:
    """What `advice.json` has of an advice."""
    model = asdict(advice.left) | {"mesh": advice.mesh, "level": advice.level, "doubled": advice.doubled}
    return {"load": advice.load, "interval": advice.interval, "kind": advice.kind, "reached": advice.reached,
            "model": model, "decisions": [asdict(one) for one in advice.decisions], "cpu_seconds": advice.cpu_seconds}


def _script(name: str, parameters: dict[str, Any], within: float, meshes: Meshes, advice: Advice) -> str:
    """A script whose case is the model."""
    script = str(Path(name).resolve()) if name.endswith(".py") else name
    options = ",\n        ".join(f"{key}={value!r}" for key, value in
                                 (parameters | meshes.options(advice.level)).items())
    made = meshes.made(advice.level)
    if advice.doubled:
        made = f"fx.integrated_finer({made}, {advice.doubled})"
    return SCRIPT.format(
        name=Path(name).stem, within=within, words=advice.left.words, mesh=advice.mesh, made=made,
        scene=f"fx.load_case({script!r})(\n        {options})",
        left=", ".join(f"{key}=True" for key, out in asdict(advice.left).items() if out)).replace(
            "    case = case\n", "")


advise_app = scenes_app(OWN, advise_scene, "Find the first critical load with no more model than it needs.",
                        "Find the first critical load of a scene with no more model than it needs, and say why.")
