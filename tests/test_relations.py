"""Relations that hold whatever is right: each over random structures of pairs of features, see `random_scenes.py`.

A structure is the same in halves and whole, in one part and in two that are joined, turned and mirrored, in other
units, with loads at once and in stages, on one process and two, of a material that never yields, and gone on with from
files; reactions and loads balance. `-k "[17]"` is the case of the number 17, `print(draw(17))` what it is.
"""

from __future__ import annotations

import json
import warnings
from dataclasses import replace

import numpy as np
import pytest
from helpers import on_two_processes
from random_scenes import Builder, Structure, View, draw, measures, off, turned

import sheetfx as fx
from sheetfx.continuation.state import State

ALL = 1120
QUICK = {*range(12), 324, 348}  # 324: multipliers hold all that is free, so that no eigenvalue is finite; 348: one
# unknown is free, and the tangent changes by a matrix of rank one
TOLERANCE = 1e-6
TOUCHING = 1e-4  # a millionth of a cell may penetrate, and displacements are some hundredths of one
WELDED = 0.03  # of shells along a line, whose multipliers are linear on cells, and by penalties

pytestmark = pytest.mark.filterwarnings("ignore")


def compared(structure: Structure, view: View, tolerance: float = TOLERANCE, **more) -> None:
    """Measures of a view are those of the structure as drawn."""
    if structure.gap is not None:
        tolerance = max(tolerance, TOUCHING)
    agree(measures(Builder(structure, View())), measures(Builder(structure, replace(view, **more))), tolerance)


def agree(one: dict, other: dict, tolerance: float = TOLERANCE) -> None:
    wrong = {name: value for name, value in off(one, other).items() if not value <= tolerance}
    assert not wrong, {name: (value, *(m[name].tolist() for m in (one, other) if name in m))
                       for name, value in wrong.items()}


def half(structure, _):
    compared(structure, View(half=True))


def groups(structure, _):
    compared(structure, View(parts="groups"))


def compatible(structure, _):
    compared(structure, View(parts="compatible"))


def weld(structure, _):
    """Beams by three kinds of joints, shells by one, on two cells a side at least: forces are linear along each."""
    structure = replace(structure, cells=max(structure.cells, 1 + structure.surface))
    how = "weld" if structure.surface else ("weld", "link", "penalty")[structure.number // len(CHECKS) % 3]
    compared(structure, View(parts=how), TOLERANCE if how in ("weld", "link") and not structure.surface else WELDED)


def rotated(structure, _):
    compared(structure, turned(structure, mirrored=False))


def mirrored(structure, _):
    compared(structure, turned(structure, mirrored=True))


def units(structure, _):
    """Newtons and millimetres against kilonewtons and metres."""
    compared(structure, View(length=1e3, force=1e3))


def stages(structure, _):
    """By loads so small that neither way passes a critical point: beyond one they may end on different branches."""
    for _ in range(5):
        found = [measures(Builder(structure, view)) for view in (View(), View(staged=True))]
        if not any("stopped" in one or len(one["critical"]) for one in found):
            break
        structure = replace(structure, loads=tuple((name, 0.5 * size) for name, size in structure.loads))
    agree(*found)


def plastic(structure, _):
    compared(structure, View(plastic=True))


def processes(structure, _):
    (line,) = on_two_processes(
        f"import json, random_scenes as r\nfound = r.measures(r.Builder(r.draw({structure.number}), r.View()))\n"
        "print(json.dumps({name: value.tolist() for name, value in found.items()}))")
    agree(measures(Builder(structure, View())), {name: np.array(value) for name, value in json.loads(line).items()})


def restart(structure, folder):
    """From the files of all states but the last."""
    builder = Builder(structure, View())
    case = builder.case()
    whole = fx.trace(case)
    for state in whole.states[:-1]:
        state.save(folder / f"{state.step}.npz")
    read = [State.load_from(folder / f"{n}.npz") for n in range(len(whole.states) - 1)]
    again = fx.trace(case, start=read)
    assert len(again.states) == len(whole.states)
    agree(measures(builder, whole), measures(builder, again))


def balance(structure, _):
    """Energies; where loads have a direction of their own forces, and where they act at points moments too."""
    builder = Builder(structure, View())
    record = fx.trace(builder.case())
    assert not record.balance().broken
    scene, state, kinds = record.case.scene, record.states[-1], {name for name, _ in structure.loads}
    if structure.gap is not None or structure.foundation or kinds & {"pressure", "heat"} or (
            structure.spring and structure.surface):
        return
    record.show(state)
    now = builder.places[1] + np.pad(record.displacement("m"), (0, 3 - structure.dimension))
    held = [reaction for _, reaction in record.shown_reactions()]
    forces, moments = [one.force for one in held], [one.moment(np.zeros(structure.dimension)) for one in held]
    for spring in (joint for joint in scene.joints if isinstance(joint, fx.Spring)):
        along = np.array(("x", "y", "z"))[:structure.dimension] == spring.component
        moved = np.where(along, record.displacement("m", spring.mesh), 0.0)
        forces.append(-spring.stiffness * moved)
        moments.append(about_origin(now, forces[-1]))
    for number, loads in enumerate((*(stage.loads for stage in scene.stages), scene.loads)):
        factor = state.factor if number == state.stage else 1.0
        for load in loads:
            if isinstance(load, fx.Moment):
                moments.append(factor * np.atleast_1d(load.moment))
            elif not isinstance(load, fx.PrescribedDisplacement):
                way = np.array(load.force) / np.linalg.norm(load.force)
                forces.append(factor * load.total(None) * way)
                moments.append(about_origin(now, forces[-1]))
    largest = max(np.abs(forces).max(), np.abs(moments).max())  # of structures as long as a unit
    assert np.abs(sum(forces)).max() < 1e-7 * largest, forces
    if not structure.surface and not structure.imperfect and "spread" not in kinds:
        assert np.abs(sum(moments)).max() < 1e-7 * largest, moments


def about_origin(place: np.ndarray, force: np.ndarray) -> np.ndarray:
    """Moment of a force, a number in the plane."""
    moment = np.cross(place, np.pad(force, (0, 3 - len(force))))
    return moment if len(force) == 3 else moment[2:]


CHECKS = {check.__name__: check for check in (
    half, groups, compatible, weld, rotated, mirrored, units, stages, processes, plastic, restart, balance)}


@pytest.mark.parametrize("number", [n if n in QUICK else pytest.param(n, marks=pytest.mark.slow) for n in range(ALL)])
def test_relation(number, tmp_path):
    structure = draw(number)
    print(structure)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        CHECKS[structure.relation](structure, tmp_path)
