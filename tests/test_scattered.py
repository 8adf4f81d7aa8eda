"""Runs that go on with another number of processes than they began with."""

from __future__ import annotations

import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from helpers import on_two_processes
from mpi4py import MPI
from test_pair_contact import sliding_tip

import sheetfx as fx
from sheetfx.archive.folder import Archive
from sheetfx.case import Case, run
from sheetfx.scenes import arch, plastic_cylinder, roof


def tied_sheet():
    """An elastic-plastic sheet whose far edge moves as one, and turns by a prescribed angle."""
    mesh = fx.read(lambda: fx.meshes.rectangle((4, 2)), dimension=3, order=2,
                   place=lambda x: np.column_stack((4 * x[:, 0], x[:, 1], 0 * x[:, 0])))
    sheet = fx.Shell(mesh, fx.Plate(0.1, points=3), fx.Plastic(1e4, 0.3, yield_stress=20.0), form="naghdi-q2")
    return fx.Scene([sheet], [fx.clamp(mesh, "west")],
                    [fx.PrescribedRotation(mesh, "south-east", (0.0, 0.5, 0.0))],
                    fx.Monitor(mesh, "south-east", "z", -1.0), joints=[fx.Uniform(mesh, "east", "z")])


STEPS = fx.LoadControl(step=0.2, fixed=True)
CASES = {
    "cubic shell": lambda: replace(roof.case(cells=2), control=fx.ArcLength(0.02)),
    "history of layers": lambda: replace(plastic_cylinder.case(cells=4), control=fx.ArcLength(0.1)),
    "multipliers at points": lambda: Case(tied_sheet(), STEPS),
    "multipliers of contact": lambda: replace(arch.case(elements=8, enforcement="uzawa"),
                                              control=fx.DisplacementControl(0.4)),
    "pairs that slide": lambda: sliding_tip(0.2),
}


def follow(name, folder, steps, resume=False):
    case = replace(CASES[name](), until=fx.Until(steps=steps), pictures=(), quantities=lambda record: {})
    run(case, name, {}, folder, resume)


def cut(folder, steps):
    """Leave the first states of a run alone, as if it had been killed."""
    for file in folder.glob("states/0*.npz"):
        if int(file.name[:6]) > steps:
            file.unlink()


@pytest.fixture(scope="module")
def runs(tmp_path_factory):
    """Folders of whole runs by one process, and of runs that one process and two have begun and the others ended."""
    folder = tmp_path_factory.mktemp("runs")
    for name in CASES:
        follow(name, folder / "one" / name, 3)
        shutil.copytree(folder / "one" / name, folder / "one, two" / name)
        cut(folder / "one, two" / name, 1)
    on_two_processes(f"""
from pathlib import Path
from test_scattered import CASES, follow
for name in CASES:
    follow(name, Path({str(folder)!r}) / "two, one" / name, 1)
    follow(name, Path({str(folder)!r}) / "one, two" / name, 3, resume=True)
""")
    for name in CASES:
        follow(name, folder / "two, one" / name, 3, resume=True)
    return folder


def table(folder: Path):
    columns = (0, 1, 2, 3, 9)  # step, load, deflection, factor, points that touch
    return np.loadtxt(folder / "path.csv", delimiter=",", skiprows=1, usecols=columns)


@pytest.mark.parametrize("name", CASES)
@pytest.mark.parametrize("order", ["one, two", "two, one"])
@pytest.mark.slow
def test_other_number_of_processes_goes_on(runs, name, order):
    """The path is that of one process, but for what tolerances of equilibrium leave."""
    whole = table(runs / "one" / name)
    np.testing.assert_allclose(table(runs / order / name), whole, rtol=1e-7, atol=1e-9 * np.abs(whole).max())
    assert not (runs / order / name / ".aside").exists()


@pytest.mark.slow
def test_state_of_one_process_again(runs):
    """The states that two processes have begun with are those of one, digit by digit but for rounding."""
    name = "cubic shell"
    (first, *_), whole = (Archive(runs / order / name, MPI.COMM_SELF).states() for order in ("two, one", "one"))
    path = fx.Path(CASES[name]().scene, start=[first])
    assert path.start[0].fields.keys() == whole[0].fields.keys()
    for key, values in path.start[0].fields.items():
        np.testing.assert_allclose(values, whole[0].fields[key], atol=1e-12)
    np.testing.assert_allclose(path.start[0].response, whole[0].response, rtol=1e-9)


@pytest.mark.slow
def test_part_that_is_lost_ends_what_is_taken(runs, tmp_path):
    name, folder = "cubic shell", tmp_path / "run"
    shutil.copytree(runs / "two, one" / name, folder)
    cut(folder, 1)
    (folder / "states" / "000001.1.npz").unlink()
    with pytest.warns(UserWarning, match="states/000001.1.npz is missing; the path goes on from step 0"):
        follow(name, folder, 3, resume=True)
    np.testing.assert_allclose(table(folder), table(runs / "one" / name), rtol=1e-7)
    shutil.rmtree(tmp_path / "run")
    shutil.copytree(runs / "two, one" / name, folder)
    (folder / "states" / "origins2.1.npz").unlink()
    with pytest.raises(ValueError, match="has processes = 2, not 1; start it with mpirun -n 2, or choose"):
        follow(name, folder, 3, resume=True)
