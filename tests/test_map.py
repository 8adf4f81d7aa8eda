"""The failure map reproduces the classical failures, and judges paths without asking the method."""

import csv
import os
import subprocess
import sys
from dataclasses import replace
from functools import partial

import pytest
from failure_map.cells import REFERENCE, Cell, choose, trace, within
from failure_map.judgement import BACK, JUMPED, PASSED, STALLED, WRONG, Judge, Trail
from failure_map.methods import METHODS
from failure_map.picture import explanations
from failure_map.traps import TRAPS, Expected, Trap
from mpi4py import MPI

from sheetfx.archive.folder import Archive
from sheetfx.continuation.state import CriticalPoint
from sheetfx.path import Path, Until
from sheetfx.scenes import arch

TILTING = Trap(
    "tilting-arch", "The determinant is positive again behind the bifurcation.",
    partial(arch.case, no_punch=True, elements=10, full=True, half_angle=12.0, to=45.0),
    (Expected("limit", 101.95), Expected("bifurcation", 93.67)), "its own states with small steps")


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("map")


@pytest.fixture(scope="module")
def cell(folder):
    """Function (trap, method) -> cell, with one reference path for each trap."""
    traced = set()

    def trace_with_reference(trap, method):
        if trap.name not in traced:
            assert trace(trap, REFERENCE, folder, 60.0).outcome == PASSED
            traced.add(trap.name)
        return trace(trap, method, folder, 30.0)
    return trace_with_reference


@pytest.mark.parametrize(("trap", "method", "outcome", "words"), [
    pytest.param(TRAPS["lee-frame"], "default", PASSED, "", marks=pytest.mark.slow),
    pytest.param(TRAPS["lee-frame"], "load", STALLED, "load 18557", marks=pytest.mark.slow),  # the first limit
    pytest.param(TRAPS["lee-frame"], "displacement", STALLED, "deflection 61", marks=pytest.mark.slow),  # an extreme
    pytest.param(TRAPS["lee-frame"], "determinant", PASSED, "", marks=pytest.mark.slow),
    pytest.param(TRAPS["lee-frame"], "current-stiffness", BACK, "deflection 6",  # the same extreme
                 marks=pytest.mark.slow),
    pytest.param(TRAPS["lee-frame"], "displacement-extremes", PASSED, "", marks=pytest.mark.slow),
    pytest.param(TRAPS["roof-6.35"], "displacement", JUMPED, "-383.75", marks=pytest.mark.slow),  # the crown moves back
    pytest.param(TRAPS["punch-arch"], "load", STALLED, "205.6", marks=pytest.mark.slow),  # the limit
    pytest.param(TRAPS["punch-arch"], "penalty-small", WRONG, "drifts", marks=pytest.mark.slow),  # by its penetration
    (TRAPS["punch-arch"], "penalty", PASSED, ""),
    pytest.param(TRAPS["contact-stick-slip"], "default", PASSED, "",  # behind a stage whose load begins at zero
                 marks=pytest.mark.slow),
    pytest.param(TRAPS["closed-path"], "cylindrical", PASSED, "", marks=pytest.mark.slow),  # two turns are told apart
    pytest.param(TRAPS["closed-path"], "displacement", PASSED, "", marks=pytest.mark.slow),  # it ends in the third turn
    (TRAPS["twisted-shaft"], "cylindrical", PASSED, ""),  # a step far beyond its bifurcation, which stays as it is
    (TILTING, "cylindrical", PASSED, ""),
    (TILTING, "determinant", BACK, "returns"),  # behind the bifurcation
], ids=lambda value: value.name if isinstance(value, Trap) else None)
@pytest.mark.slow
def test_classical_failures(cell, trap, method, outcome, words):
    found = cell(trap, method)
    assert (found.outcome, found.trap, found.method) == (outcome, trap.name, method), found.reason
    assert words in found.reason
    assert bool(found.reason) == (outcome != PASSED)
    assert found.factorisations > 0


@pytest.mark.slow
def test_a_penalty_too_large_fails(cell):
    """Contact points take turns: which failure they bring depends on rounding."""
    assert cell(TRAPS["punch-arch"], "penalty-large").outcome in (JUMPED, STALLED, WRONG, BACK)


def test_first_steps_of_all_controls_load_the_structure_alike():
    """The load increments of their predictors on the unloaded frame are equal."""
    case = TRAPS["lee-frame"].case()
    first = {}
    for name in ("default", "load", "displacement", "spherical"):
        changed = METHODS[name](case)
        path = Path(changed.scene, changed.control)
        first[name] = changed.control.predict(changed.control.first, 1.0, path.tracer.tangent)
    assert list(first.values()) == pytest.approx([first["default"]] * 4, rel=1e-12)


@pytest.fixture(scope="module")
def trail(cell, folder):
    cell(TRAPS["lee-frame"], "default")
    return Trail(Archive(folder / "lee-frame" / REFERENCE, MPI.COMM_SELF).states())


@pytest.mark.parametrize(("loads", "outcome", "words"), [
    ((18556.7, -9414.4), PASSED, ""),
    ((18556.7,), JUMPED, "-9414.4"),
    ((18556.7, -9314.4), WRONG, "-9314.4 instead of -9414.4"),
    ((18556.7, 12000.0, -9414.4), WRONG, "12000 that is not there"),
])
@pytest.mark.slow
def test_conclusions(trail, loads, outcome, words):
    points = [CriticalPoint("limit", load, 0.0, 1, name="maximum" if load > 0 else "minimum") for load in loads]
    verdict, reason = Judge(TRAPS["lee-frame"].points, trail).conclude(points)
    assert verdict == outcome and words in reason


@pytest.mark.slow
def test_names_and_null_vectors_are_compared(trail):
    """A bifurcation with another name, and a double one taken for a simple one."""
    point = CriticalPoint("bifurcation", 1.0, 0.0, 1, name="asymmetric")
    for expected, words in ((Expected("bifurcation", 1.0, name="stable symmetric"), "instead of 'stable symmetric'"),
                            (Expected("bifurcation", 1.0, multiplicity=2), "where there are 2")):
        verdict, reason = Judge((expected,), trail).conclude([point])
        assert verdict == WRONG and words in reason


def test_states_are_watched_on_their_way(trail):
    """Long steps and limits that are found are right; a limit that is not found and states visited before are not."""
    highest = next(n for n, s in enumerate(trail.states) if s.critical)
    before, behind = trail.states[1:highest - 1:10], trail.states[highest:highest + 12:3]
    judge = Judge((), trail)
    assert not any(judge.watch(state) for state in [*before, *behind])
    assert judge.watch(before[-1])[0] == BACK
    careless = Judge((), trail)
    found = [careless.watch(replace(state, critical=())) for state in behind]
    assert found[0] is None and found[-1] == (JUMPED, "passes the limit point at load 18557 without finding it")


@pytest.mark.slow
def test_states_off_the_path(trail):
    """One with other fields at once, one that creeps away by and by."""
    final = trail.states[-1].fields

    def moved(state, by):
        return replace(state, fields={k: v + by * abs(final[k]).max() for k, v in state.fields.items()})

    assert Judge((), trail).watch(moved(trail.states[20], 0.5))[0] == JUMPED
    creeping = Judge((), trail)
    stable = [s for s in trail.states if s.unstable_modes == 0]
    found = (creeping.watch(moved(state, 0.0006 * n)) for n, state in enumerate(stable))
    assert next(filter(None, found))[0] == WRONG


def test_points_behind_the_end_do_not_count():
    """Those that the last step, longer with one method than with another, finds beyond the bound."""
    point = CriticalPoint("limit", -2.0, 3.0, 1)
    assert within(Until(deflection=3.5, load=2.0), point) and within(Until(), point)
    assert not within(Until(load=1.9), point) and not within(Until(deflection=2.9, load=2.0), point)


def test_unknown_names_are_refused():
    with pytest.raises(ValueError, match="no trap 'lee'; choose from lee-frame"):
        choose("trap", "lee", TRAPS)
    with pytest.raises(ValueError, match="no method 'newton'; choose from default, load"):
        choose("method", "load,newton", METHODS)


def test_failures_of_one_kind_have_one_letter():
    """Their reasons differ in numbers only; the more frequent kind comes first, and what passed has no letter."""
    def failed(outcome, reason):
        return Cell("lee-frame", "load", outcome, reason, 1.0, 2)

    reasons = ["stops at load 1.3e-05, deflection -2, does not converge even with a step of 7.7e-07",
               "is still at load 0.3, deflection 9 after 30 s",
               "stops at load -4, deflection 0.5, does not converge even with a step of 0.001"]
    letters = explanations([failed(PASSED, ""), *(failed(STALLED, r) for r in reasons), failed(JUMPED, reasons[1])])
    assert letters == {(JUMPED, "is still at a state after … s"): "a",
                       (STALLED, "stops at a state, does not converge even with a step of …"): "b",
                       (STALLED, "is still at a state after … s"): "c"}


@pytest.mark.slow
def test_map_of_the_command_line(tmp_path):
    command = [sys.executable, "-m", "sheetfx", "map", "--traps", "von-mises-truss", "--methods",
               "default,load,uzawa"]
    result = subprocess.run([*command, "-o", tmp_path], capture_output=True, text=True, timeout=120)
    assert result.returncode == 0, result.stderr
    with (tmp_path / "map.csv").open() as stream:
        rows = list(csv.DictReader(stream))
    assert list(rows[0]) == ["trap", "method", "outcome", "reason", "cpu_seconds", "factorisations"]
    assert [(r["method"], r["outcome"]) for r in rows] == [("default", PASSED), ("load", JUMPED)]
    assert (tmp_path / "map.png").stat().st_size > 5000
    (tmp_path / "map.csv").write_text("\n".join((tmp_path / "map.csv").read_text().splitlines()[:2]) + "\n")
    resumed = subprocess.run([*command, "-o", tmp_path, "--resume"], capture_output=True, text=True, timeout=120)
    assert "truss, load: " in resumed.stdout and "truss, default: " not in resumed.stdout
    with (tmp_path / "map.csv").open() as stream:
        assert [row["outcome"] for row in csv.DictReader(stream)] == [PASSED, JUMPED]


def test_help_lists_traps_and_methods(command):
    shown = command("map", "--help")[1]
    for name in ("lee-frame", "closed-path", "current-stiffness", "--resume"):
        assert name in shown.replace("\n", " ")


@pytest.mark.slow
def test_map_is_not_for_mpi(tmp_path):
    command = ["mpirun", "-n", "2", sys.executable, "-m", "sheetfx", "map", "-o", str(tmp_path)]
    result = subprocess.run(command, capture_output=True, text=True, timeout=60, env=os.environ)
    assert result.returncode and "leave mpirun out" in result.stderr


def test_an_installed_package_says_where_the_traps_are(command, monkeypatch, tmp_path):
    monkeypatch.setattr("sheetfx.studies.map_command.DEMOS", tmp_path)
    status, _, error = command("map", "--traps", "lee-frame")
    assert status == 2
    assert "map: the traps belong to the source tree" in error
    assert "docker/run sheetfx map" in error
    assert "source tree" in " ".join(command("map", "--help")[1].split())
