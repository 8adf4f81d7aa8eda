"""Cantilever rolled up by an end moment (Sze, Liu and Lo 2004)."""

from __future__ import annotations

from math import cos, hypot, pi, sin
from typing import Annotated

from typer import Option

from .. import meshes
from ..case import Case
from ..checks import AT_LEAST_1, Choice
from ..continuation.control import LoadControl
from ..mesh.reader import NamedMesh, read
from ..model.beam import Beam
from ..model.loads import Moment
from ..model.plate import Plate
from ..model.scene import Monitor, Scene
from ..model.section import Elastic, Rectangle
from ..model.shell import FORMS, Shell
from ..model.supports import Support, clamp, symmetry
from ..record import Record
from . import looked_at
from ._benchmark import surface

LENGTH = 12.0
SECTION, MATERIAL = Rectangle(1.0, 0.1), Elastic(1.2e6, 0.0)


@looked_at
def case(
    turns: Annotated[int, AT_LEAST_1, Option(help="full turns of the tip")] = 2,
    elements: Annotated[int, AT_LEAST_1, Option(help="elements on the cantilever")] = 24,
    degree: Annotated[int, Choice((1, 2, 3)), Option(help="of the elements: 1 (two nodes) or 2")] = 2,
    spatial: Annotated[bool, Option("--spatial", help="in space instead of in the plane")] = False,
    form: Annotated[str | None, Choice(tuple(FORMS)),
                    Option(help=f"shell instead of a beam: {', '.join(FORMS)}")] = None,
    steps: Annotated[int, AT_LEAST_1, Option(help="load steps to a full turn")] = 10,
) -> Case:
    """Cantilever rolled into circles: after each full turn the tip is back at the clamp."""
    moment = 2 * pi * turns * SECTION.stiffness(MATERIAL, 2)[2] / LENGTH
    part, supports, load = _shell(form, elements, moment) if form else _beam(degree, elements, moment, spatial)
    mesh = part.mesh
    return Case(
        scene=Scene(
            parts=[part], supports=supports, loads=[load], monitor=Monitor(mesh, "tip", "x", -1.0)),
        control=LoadControl(step=1 / (turns * steps), fixed=True),
        quantities=lambda record: quantities(record, mesh), axes=("displacement of the tip", "moment"))


def _beam(degree: int, elements: int, moment: float, spatial: bool) -> tuple[Beam, list[Support], Moment]:
    """Beam, its clamp and its end moment about z."""
    nodes = {"base": (0, 0), "tip": (LENGTH, 0)}
    mesh = read(lambda: meshes.frame(nodes, {"cantilever": ("base", "tip", elements)}), 3 if spatial else 2)
    beam = Beam(mesh, SECTION, MATERIAL, degree=degree, up=(0.0, 1.0, 0.0))
    return beam, [clamp(mesh, "base")], Moment(mesh, "tip", (0.0, 0.0, moment) if spatial else moment)


def _shell(form: str, elements: int, moment: float) -> tuple[Shell, list[Support], Moment]:
    """Strip of shell that stays in its plane of symmetry, with its end moment about z."""
    width = SECTION.width
    mesh = surface(form, (elements, 1), lambda s, t: (LENGTH * s, 0 * s, width * t), {"tip": (1, 0)})
    shell = Shell(mesh, Plate(SECTION.depth), MATERIAL, form=form)
    supports = [clamp(mesh, "west"), symmetry(mesh, "south", "z")]
    return shell, supports, Moment(mesh, "east", (0.0, 0.0, moment / width))


def quantities(record: Record, mesh: NamedMesh) -> dict[str, float]:
    """Place of the tip at the end, its error over the length, and its angle in the plane.

    The exact tip is LENGTH (sin a, 1 - cos a) / a when the tip has turned by the angle a, since a
    constant moment bends a straight beam into an arc.
    """
    last = record.states[-1]
    angle = last.load * LENGTH / SECTION.stiffness(MATERIAL, 2)[2]
    record.show(last)
    kinematics = record.path.discretisation.kinematics(mesh)
    tip = kinematics.displacement(mesh, "tip")
    x, y = float(LENGTH + tip[0]), float(tip[1])
    error = hypot(x - LENGTH * sin(angle) / angle, y - LENGTH * (1 - cos(angle)) / angle) / LENGTH
    values = {"tip_x": x, "tip_y": y, "tip_error": error}
    if mesh.dimension == 2:
        values["tip_angle"] = kinematics.turned(mesh, "tip")
    return values
