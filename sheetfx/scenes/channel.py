"""Cantilever of channel section under a force at a corner of its free end (Chroscielewski, Makowski and Stumpf 1992).

Set-up, also of Betsch, Gruttmann and Stein (1996): length 36, web 6 and flanges 2 between middle surfaces, thickness
0.05, modulus 1e7, Poisson's ratio 0.333 (inches and pounds). One end is clamped. At the other end a force acts in the
plane of the web, at the corner of web and upper flange, towards the lower flange. The force does not pass through the
shear centre: the beam bends and twists, until its upper flange buckles near the clamp, as warping compresses its free
edge by more than bending stretches it, and the load falls.

Converged: a limit load of 114.4 at a deflection of 0.28 under the force, by "naghdi-q2" on 54 cells along, 9 across
the web and 3 across each flange, as on 36, 12 and 4 (114.43 both; 114.60 on 36, 6 and 2). Triangles come from below:
they are soft in twist beside free edges, in the first order of their size. Both publications give curves, no figures;
Kratos (MITC4, `demos/peers`) has 115.62 on 36 x 10 and 114.72 on 72 x 20 cells, which lead to 114.42.
"""

from __future__ import annotations

from math import sqrt, tanh
from typing import Annotated

from typer import Option

from .. import meshes
from ..case import Case
from ..checks import POSITIVE, Range
from ..continuation.control import ArcLength
from ..mesh.reader import read
from ..model.loads import PointForce
from ..model.plate import Plate
from ..model.scene import Monitor, Scene
from ..model.section import Elastic
from ..model.shell import TRIANGLE, Shell, named_form
from ..model.supports import clamp
from ..path import Until
from ..record import Record
from . import looked_at
from ._benchmark import Form, Reading, slopes

LENGTH, WEB, FLANGE, THICKNESS, MODULUS, POISSON = 36.0, 6.0, 2.0, 0.05, 1e7, 0.333
LIMIT = 114.4  # converged limit load
LOADED = "upper corner at end"
READING = {"deflection": Reading(LOADED, "z", -1.0)}


@looked_at
def case(
    cells: Annotated[int, Range(least=6), Option(help="cells along the beam")] = 36,
    across: Annotated[tuple[int, int], Option(help="cells across web and flange; 0: cells / 6 and / 18")] = (0, 0),
    form: Form = "naghdi-q2",
    to: Annotated[float, POSITIVE, Option(help="deflection under the force at which the path ends")] = 1.5,
    step: Annotated[float, POSITIVE, Option(help="first arc length")] = 0.02,
) -> Case:
    """Channel-section cantilever: it twists, and its compressed flange buckles at a limit point."""
    if min(across) < 0:
        raise ValueError(f"channel: across is {across[0]} and {across[1]}; numbers of cells must not be negative")
    web, flange = across[0] or max(1, round(cells / 6)), across[1] or max(1, round(cells / 18))
    walls = {"upper": ("upper edge", "upper corner", flange), "web": ("upper corner", "lower corner", web),
             "lower": ("lower corner", "lower edge", flange)}
    corners = {"upper edge": (FLANGE, WEB), "upper corner": (0.0, WEB), "lower corner": (0.0, 0.0),
               "lower edge": (FLANGE, 0.0)}
    triangles = named_form(form).cell == TRIANGLE
    mesh = read(lambda: meshes.profile(corners, walls, LENGTH, cells, triangles), 3)
    return Case(
        scene=Scene(
            [Shell(mesh, Plate(THICKNESS), Elastic(MODULUS, POISSON), form=form)],
            [clamp(mesh, f"{wall} at start") for wall in walls], [PointForce(mesh, LOADED, (0.0, 0.0, -1.0))],
            Monitor(mesh, LOADED, "z", -1.0)),
        control=ArcLength(step=step), until=Until(deflection=to), quantities=quantities,
        axes=("deflection under the force (in)", "force (lb)"))


def quantities(record: Record) -> dict[str, float]:
    """First limit load and its deflection, the last load, and the flexibility at the start over Vlasov's."""
    limit = next((p for p in record.critical_points if p.kind == "limit"), None)
    found = {"limit_load": limit.load, "deflection": limit.deflection} if limit else {}
    flexibility = slopes(record, READING, 0)["deflection"]
    return found | {"last_load": record.states[-1].load, "flexibility_over_theory": flexibility / vlasov()}


def vlasov() -> float:
    """Deflection under a unit of force: bending, shear of the web, and torsion with warping (Vlasov 1961, chapter 2).

    The shear centre lies 3 f^2 / (w + 6 f) behind a web of height w with flanges of width f.
    """
    shear_modulus = MODULUS / 2 / (1 + POISSON)
    second_moment = THICKNESS * (WEB**3 / 12 + FLANGE * WEB**2 / 2)
    arm = 3 * FLANGE**2 / (WEB + 6 * FLANGE)
    torsion = shear_modulus * THICKNESS**3 * (WEB + 2 * FLANGE) / 3
    warping = MODULUS * THICKNESS * WEB**2 * FLANGE**3 / 12 * (3 * FLANGE + 2 * WEB) / (6 * FLANGE + WEB)
    decay = sqrt(torsion / warping)
    bending = LENGTH**3 / 3 / MODULUS / second_moment + LENGTH / shear_modulus / (THICKNESS * WEB)
    return bending + arm**2 / torsion * (LENGTH - tanh(decay * LENGTH) / decay)
