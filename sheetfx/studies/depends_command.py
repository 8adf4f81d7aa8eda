"""The command `sheetfx depends`: what a critical load of a scene depends on."""

from __future__ import annotations

import typer

from .run import OF_A_FOLDER, folder_of, option, scenes_app

DRAWN = 1e-4  # largest movement in the picture over the size, small beside a cell

OWN = [
    option("point", int, 1, "Number of the limit point or bifurcation along the path.", "--point", min=1),
    option("nodes", bool, False, "Tell the derivatives by the place of each node too: nodes.csv and nodes.png.",
           "--nodes"),
    option("output", str | None, None, "Folder of the results; default results/NAME-depends.", "-o", "--output",
           metavar="PATH", rules=[OF_A_FOLDER]),
]



def tell_scene(name: str, function, parameters: dict, point: int, nodes: bool, output: str | None) -> None:
    """Write and print the dependences of one critical point."""
    from mpi4py import MPI

    from ..archive.folder import Archive
    from ..critical.limit_gradient import rubbing
    from ..discrete.discretisation import Discretisation
    from .depends import dependences, draw, table
    from .numbered_point import path_to_point

    folder = folder_of(name, output, "-depends")
    archive = Archive(folder, MPI.COMM_WORLD, ("depends.json", "depends.png", "nodes.csv", "nodes.png"))
    with archive.opened({"command": "depends", "scene": name, "point": point} | parameters, False):
        case, found = function(**parameters), []
        if refused := rubbing(Discretisation(case.scene).system):
            raise ValueError(f"depends {name}: {refused}")
        record, chosen = path_to_point(case, point, name)
        for one in dependences(record, chosen, function, parameters):
            if not isinstance(one, str):
                found.append(one)
            elif archive.comm.rank == 0:
                typer.echo(f"left out: {one}")
        idle = [one.name for one in found if not one.derivative]
        found = sorted((one for one in found if one.derivative), key=_size, reverse=True)
        if archive.comm.rank == 0:
            typer.echo(str(chosen))
            for one in found:
                typer.echo(_told(one))
            if idle:
                typer.echo(f"without effect: {', '.join(idle)}")
            archive.write_json("depends.json", table(found))
            draw(found, str(chosen), folder / "depends.png")
        if nodes:
            _tell_nodes(record, chosen, folder, archive)
        if archive.comm.rank == 0:
            typer.echo(f"results in {folder}")


def _tell_nodes(record, point, folder, archive) -> None:
    """Derivatives by the places of nodes, as a table and a picture of the shape along which the load grows most."""
    import numpy as np

    from ..mesh.nodal_shapes import nodal_shapes
    from .depends import by_nodes, write_nodes
    from .shape_files import draw_shape

    shapes = nodal_shapes(record.case.scene.meshes)

    def told(done: int) -> None:
        if archive.comm.rank == 0 and (done % 20 == 0 or done == len(shapes)):
            typer.echo(f"nodes: {done} of {len(shapes)} movements")

    derivatives = by_nodes(record, point, shapes, told)
    if archive.comm.rank == 0:
        write_nodes(folder, shapes, derivatives)
    ways = np.nan_to_num(derivatives)
    if size := np.abs(ways).max():
        small = DRAWN * max(mesh.size for mesh in record.case.scene.meshes) / size
        draw_shape(folder / "nodes.png", record, shapes, small * ways, f"{point}: movement that raises it most")


def _size(one) -> float:
    return abs(one.derivative if one.percent_per_percent is None else one.percent_per_percent)


def _told(one) -> str:
    if one.percent_per_percent is None:
        return f"  {one.name} = {one.value:g}: {one.derivative:+.4g} by one more"
    return f"  a per cent more {one.name} (now {one.value:g}): {one.percent_per_percent:+.3g} % load"


depends_app = scenes_app(
    OWN, tell_scene, "Tell what a critical load depends on: derivatives, as a ranked table and a picture.",
    "Trace the path of a scene, and rank what the load of a critical point depends on.")
