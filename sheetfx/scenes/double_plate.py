"""Two plates that slide on each other (thesis, section 4.5.1).

Each plate is 80 x 20 x 0.7 mm and clamped at one end; a force at the middle of the free end of plate 1 presses it onto
plate 2. The thesis has E = 1.92e5 MPa, Poisson's ratio 0.3, a yield stress of 195 MPa without hardening, and friction
of 0.2 between the plates. It does not say how the plates lie (its figure 4.3 is missing), and has no numbers of the
path, but describes it: at A plate 1 touches and stiffens sharply, at B it softens as it slides, then stiffens again,
until at C it slides off. Of plausible layouts this one shows all that: plate 1 is clamped at x = 0, `gap` above plate
2, which is clamped at x = 160 - overlap and reaches back towards plate 1. Half of it is modelled, by symmetry about the
long axis. The free end of plate 1 is what touches.

Past B plate 1 turns about a plastic hinge at its clamp, which is as short as cells allow where nothing hardens: the
cell there is divided, and strains are those that hold where faces are stretched by as much as themselves
(`forms.shell.biot`; Naghdi's let the hinge lose its moment, so that the load at C fell from 11.7 to 5.8 N as that cell
was refined).

With a force along the free end, and as strips that do not contract laterally, elastic plates without friction follow
two inextensible elasticas, which slide off at 81.6 N, to 0.1 %.
"""

from __future__ import annotations

from dataclasses import replace
from functools import cached_property
from typing import Annotated

import numpy as np
from typer import Option

from .. import meshes
from ..case import Case
from ..checks import NOT_NEGATIVE, POSITIVE, Range
from ..continuation.control import ArcLength
from ..continuation.state import State
from ..events.event import Event
from ..events.sliding import first_touch, slide_off
from ..forms.shell import biot
from ..mesh.reader import read
from ..model.loads import EdgeForce, PointForce
from ..model.plasticity import Plastic
from ..model.plate import Plate
from ..model.scene import Monitor, Scene
from ..model.section import Elastic
from ..model.shell import Shell
from ..model.supports import clamp, symmetry
from ..model.surface_contact import SurfaceContact
from ..path import Path, Until
from ..record import Record
from ..show.evaluate import last_state_kept
from ..show.pairs import pair_history
from ..show.plastic import plastic_zones
from ..show.standard import STANDARD
from . import looked_at
from ._plastic import plastic_quantities, yield_events
from ._stages import stages, touches

LENGTH, WIDTH, THICKNESS, MODULUS, POISSON, YIELD = 80.0, 20.0, 0.7, 1.92e5, 0.3, 195.0
HINGE = 0.0, 0.1, 0.25, 0.45, 0.7  # lines of the cell next to the clamp, in which a plastic hinge forms
FORM, LOADED = "naghdi-q2", "south-east"
A, B, AGAIN, C = "A first touch", "B softens", "stiffens again", "C slide-off"


@looked_at
def case(
    friction: Annotated[float, NOT_NEGATIVE, Option(help="Coulomb's coefficient")] = 0.2,
    elastic: Annotated[bool, Option("--elastic", help="no yielding")] = False,
    gap: Annotated[float, POSITIVE, Option(help="between the plates in mm")] = 20.0,
    overlap: Annotated[float, Range(above=0, below=LENGTH), Option(help="of the plates in mm")] = 40.0,
    cells: Annotated[int, Range(least=4), Option(help="cells along each plate")] = 16,
    layers: Annotated[int, Range(least=2), Option(help="points through the thickness where plates yield")] = 10,
    line_load: Annotated[bool, Option("--line-load", help="spread the force along the free end")] = False,
    stiffness: Annotated[float | None, POSITIVE,
                         Option(help="of contact on the way to no penetration (N/mm3)")] = None,
    step: Annotated[float, POSITIVE, Option(help="first arc length")] = 0.01,
) -> Case:
    """Double plate: stages A, B and C of its path, contact force and slip."""
    material = Elastic(MODULUS, POISSON) if elastic else Plastic(MODULUS, POISSON, yield_stress=YIELD)
    return plates(material, friction, gap, overlap, cells, line_load, step, layers=layers, stiffness=stiffness)


def plates(material: Elastic, friction: float, gap: float, overlap: float, cells: int, line_load: bool, step: float,
           distance: float = THICKNESS, layers: int = 10, stiffness: float | None = None) -> Case:
    """The case for a material.

    Parameters
    ----------
    distance : of the mid-surfaces where the plates touch
    layers, stiffness : of plates that yield, and of the contact, as in a SurfaceContact
    """
    one = _mesh(cells, (0.0, 0.0, gap + distance), 0.0)
    two = _mesh(cells, (LENGTH - overlap, 0.0, 0.0), LENGTH)
    shells = [Shell(m, Plate(THICKNESS, points=layers), material, form=FORM, strains=biot) for m in (one, two)]
    touch = SurfaceContact(one, "east", (two, None), distance=distance, friction=friction, stiffness=stiffness)
    load = (EdgeForce(one, "east", (0.0, 0.0, -1 / WIDTH)) if line_load
            else PointForce(one, LOADED, (0.0, 0.0, -0.5)))
    scene = Scene(
        shells, [clamp(one, "west"), clamp(two, "east"), symmetry(one, "south", "y"), symmetry(two, "south", "y")],
        [load], Monitor(one, LOADED, "z", -1.0), symmetry_factor=2, joints=[touch])
    off = replace(slide_off(scene, touch), name=C)
    control = ArcLength(step=step, largest=2.5)
    alone = _Alone(shells[0], [clamp(one, "west"), symmetry(one, "south", "y")], load, gap, control)
    zones = [plastic_zones] if isinstance(material, Plastic) else []
    events = [replace(first_touch(), name=A), Event(B, alone.stiffening, way=-1), Event(AGAIN, alone.stiffening, way=1),
              *yield_events(scene)]
    pictures = [*STANDARD, stages, *zones, pair_history]
    return Case(scene, control, Until(event=off), quantities, pictures,
                ("deflection of the free end of plate 1 (mm)", "force (N)"), events=events)


def _mesh(cells: int, origin, clamped: float):
    """A plate of equal cells but for that next to its clamp, at x = 0 or x = LENGTH, which is divided towards it."""
    across = max(1, round(cells * WIDTH / 2 / LENGTH))
    lines = np.array([*HINGE, *range(1, cells + 1)]) * LENGTH / cells
    count = len(lines) - 1

    def place(x):
        off = np.interp(np.abs(x[:, 0] - clamped) * count / LENGTH, np.arange(count + 1), lines)
        return np.column_stack((np.abs(off - clamped), x[:, 1:])) + np.array(origin)

    return read(lambda: meshes.rectangle((count, across), (LENGTH, WIDTH / 2), name="plate"), 3, 1, place)


class _Alone:
    """Plate 1 without plate 2, as stiff as it is where it would touch."""

    def __init__(self, shell, supports, load, gap, control):
        self._scene = Scene([shell], supports, [load], Monitor(shell.mesh, LOADED, "z", -1.0), symmetry_factor=2)
        self._gap, self._control = gap, control

    @cached_property
    def _stiffness(self) -> float:
        """Current stiffness parameter at first touch."""
        *_, last = Path(self._scene, self._control, Until(deflection=self._gap))
        return last.current_stiffness

    def stiffening(self, state: State) -> float:
        """By how much plate 1 is stiffer than before it touched; positive until then."""
        return state.current_stiffness / self._stiffness - 1 if state.contact_points else 1.0


def quantities(record: Record) -> dict[str, float]:
    """Load and deflection at the stages, contact force, slip and angle of the tip."""
    found = {}
    for point in record.critical_points:
        if point.kind == "event" and point.name in (A, B, C):
            found |= {f"{point.name[0]}_load": point.load, f"{point.name[0]}_deflection": point.deflection}
    touched = touches(record)
    largest = max(range(len(touched)), key=lambda n: touched[n].force)
    found |= {"largest_contact_force": touched[largest].force, "its_load": record.states[largest].load,
              "its_deflection": record.states[largest].deflection, "last_contact_force": touched[-1].force,
              "slip": touched[-1].slip, "tip_angle": tip_angle(record)}
    return found | plastic_quantities(record)


def tip_angle(record: Record) -> float:
    """Angle by which the free end of plate 1 has turned in the last state, in degrees."""
    with last_state_kept(record):
        turned = record.rotation(LOADED, record.case.scene.meshes[0])
    return float(np.degrees(2 * np.arctan2(turned[2], turned[0])))
