"""Bifurcation diagrams of structures whose branches are known: none is missed, and none listed twice."""

import csv
import json
import os
import subprocess
import sys
from collections import Counter

import numpy as np
import pytest
from scipy.special import ellipe, ellipk
from test_first_piece import RigidMast
from test_multiple_bifurcations import displacements
from truss import Truss

from sheetfx.case import trace
from sheetfx.continuation.state import State
from sheetfx.scenes import star_dome
from sheetfx.studies import diagram, diagram_branch
from sheetfx.studies.diagram import Bounds, Plan, everything, trace_diagram
from sheetfx.studies.diagram_picture import describe, draw_diagram
from sheetfx.studies.run import folder_of


@pytest.fixture
def here(monkeypatch):
    """Trace branches in this process."""
    monkeypatch.setattr(diagram, "_process", lambda home: diagram_branch.follow(home) or "")


def drawn(folder, name, bounds, levels=1, **parameters):
    """Branches of a diagram by name, and what its files hold."""
    primary = trace_diagram(Plan(name, parameters, bounds, levels), folder)
    tree = json.loads((folder / "diagram.json").read_text())
    with (folder / "diagram.csv").open() as stream:
        rows = list(csv.DictReader(stream))
    return {branch.name: branch for branch in everything(primary)}, tree, rows


def out_of_balance(row, rise=3.0):
    """Forces on the apex of the truss of von Mises at a state, where two nodes of three are fixed; length of a bar.

    The direction of a bar is as uncertain as its length is small.
    """
    load, deflection, norm = (float(row[name]) for name in ("load", "deflection", "norm"))
    x, y = np.sqrt(max(3 * norm**2 - deflection**2, 0.0)), rise - deflection
    arms = np.array([(x + 1, y), (x - 1, y)])
    lengths, whole = np.linalg.norm(arms, axis=1), np.hypot(1, rise)
    return ((lengths / whole - 1) / lengths) @ arms + (0, load), lengths.min()


@pytest.mark.slow
def test_two_bars(here, tmp_path):
    """Both kinds of sideways branches: one joins two bifurcations, on the other a bar shrinks to a point.

    All states are equilibria of the two bars by their geometry. On the second kind the bar has no length where the apex
    is at a support, at the deflection 3: no path leads on.
    """
    found, tree, rows = drawn(tmp_path, "von-mises-truss", Bounds(deflection=6.6, steps=60), levels=2)
    assert {name: b.half["equivalent"] for name, b in found.items() if b.half} == dict.fromkeys(
        ("1a", "3a", "4a", "6a"), 2)
    assert {row["branch"] for row in rows} == set(found)
    for row in rows:
        forces, shortest = out_of_balance(row)
        assert shortest < 1e-3 or forces == pytest.approx([0, 0], abs=1e-7)
    assert found["1a"].result["arrival"]["point"] == "0:6" and found["6a"].result["arrival"]["point"] == "0:1"
    assert found["6a"].reverse_of == "1a" and not found["1a"].reverse_of
    for name in ("3a", "4a"):
        result = found[name].result
        assert result["status"] == "failed" and "even with a step of" in result["message"]
        assert result["states"][-1]["deflection"] == pytest.approx(3.0, abs=1e-3)
    assert [b["status"] for p in tree["path"]["points"] for b in p["branches"]] == ["finished", "failed",
        "failed", "finished"]
    assert all("2 equivalent" in describe(branch) for branch in found.values() if branch.half)
    figure = draw_diagram(found["0"], ("deflection", "load"))
    lines = [line for line in figure.axes[0].lines if line.get_linestyle() in ("-", "--") and line.get_zorder() == 2]
    assert len({line.get_linestyle() for line in lines}) == 2


def test_a_closed_path_ends_where_it_began(here, tmp_path):
    """With the loads bounded the primary path knows one bifurcation; its branch comes back by the inverted truss."""
    found, _, rows = drawn(tmp_path, "von-mises-truss", Bounds(load=0.5))
    assert list(found) == ["0", "1a"]
    result = found["1a"].result
    assert result["arrival"]["point"] == "0:1"
    assert result["arrival"]["load"] == pytest.approx(0.24776384332, rel=1e-6)
    assert [p["kind"] for p in result["points"]] == ["bifurcation"], "where its load turns it passes the inverted truss"
    assert result["points"][0]["load"] == pytest.approx(-0.24776384332, rel=1e-6)
    for row in rows:
        assert out_of_balance(row)[0] == pytest.approx([0, 0], abs=1e-7)


@pytest.mark.slow
def test_branches_of_branches(here, tmp_path):
    """A mast with nearly equal stays sways along the weaker ones, then askew, from where its geometry says so.

    Two levels lead to all its equilibria; 3e-4: places of critical points between the states of a branch.
    """
    script = tmp_path / "mast.py"
    script.write_text("from test_first_piece import stayed_mast\n"
                      "def case():\n    return stayed_mast(1.05, 2.0).case\n")
    found, tree, _ = drawn(tmp_path / "out", str(script), Bounds(load=4.6), levels=2)
    assert list(found) == ["0", "1a", "1a.1a", "2a"]
    assert {found[name].half["equivalent"] for name in ("1a", "2a", "1a.1a")} == {2}
    askew = found["1a.1a"]
    assert abs(askew.origin["deflection"]) == pytest.approx(RigidMast(1.05, 2.0).secondary(), rel=3e-4)
    assert [askew.result["states"][i]["unstable"] for i in (0, -1)] == [1, 0]
    (point,) = (p for p in tree["path"]["points"][0]["branches"][0]["points"] if p["kind"] == "bifurcation")
    assert [branch["name"] for branch in point["branches"]] == ["1a.1a"]


def test_bounds_hold_for_all_paths(here, tmp_path):
    """Within a deflection of 1.5 there is one bifurcation, whose branch ends there too."""
    found, tree, _ = drawn(tmp_path, "von-mises-truss", Bounds(deflection=1.5), levels=1)
    assert list(found) == ["0", "1a"]
    assert all(branch.result["message"] == "deflection 1.5 reached" for branch in found.values())
    (point,) = tree["path"]["points"]
    assert point["not_followed"] is None and point["kind"] == "bifurcation"
    _, tree, _ = drawn(tmp_path, "von-mises-truss", Bounds(deflection=1.5), levels=0)
    assert tree["path"]["points"][0]["not_followed"] == "lies beyond 0 levels of branches"


def test_mirror_images_of_a_column(here, tmp_path):
    """It bends to either side, listed once, by the elastica; the second branch has one unstable mode.

    With the modulus p the load is (2 n K / pi)^2 and the shortening 2 - 2 E / K (Timoshenko and Gere 1961, 2.7), beside
    the axial strain, which is h^2 pi^2 / 12 times the load. 1e-3: shear, which it neglects, and elements.
    """
    found, _, _ = drawn(tmp_path, "column", Bounds(load=6.0, deflection=0.4), to=6.0)
    assert {name: b.half["equivalent"] for name, b in found.items() if b.half} == {"1a": 2, "2a": 2}
    for waves, name in enumerate(("1a", "2a"), 1):
        for state in found[name].result["states"]:
            assert state["unstable"] == waves - 1
            modulus = np.linspace(0, 0.9, 10001)
            shortening = 2 - 2 * ellipe(modulus**2) / ellipk(modulus**2) + 0.01**2 * np.pi**2 / 12 * state["load"]
            load = (2 * waves * ellipk(modulus**2) / np.pi) ** 2
            assert state["load"] == pytest.approx(np.interp(state["deflection"], shortening, load), rel=2e-3)


def test_halves_that_are_not_equivalent(here, tmp_path):
    """Roorda's frame: the load rises on one half and falls on the other; each is listed."""
    found, _, _ = drawn(tmp_path, "roorda-frame", Bounds(load=3.2, steps=5), elements=8)
    assert [found[name].half["equivalent"] for name in ("1a", "1b")] == [1, 1]
    assert sorted(found[name].result["states"][0]["unstable"] for name in ("1a", "1b")) == [0, 1]


def test_a_branch_that_fails_is_listed(here, monkeypatch, tmp_path):
    """The others go on, and a new start traces only those that are not finished."""
    traced = []

    def process(home, broken=("3a",)):
        traced.append(home.name)
        return "MemoryError: no more" if home.name in broken else diagram_branch.follow(home) or ""

    monkeypatch.setattr(diagram, "_process", process)
    plan = Plan("von-mises-truss", {}, Bounds(deflection=2.5), 1)
    primary = trace_diagram(plan, tmp_path)
    branches = {branch.name: branch for branch in everything(primary)}
    assert branches["3a"].result["message"] == "MemoryError: no more" and branches["1a"].result["states"]
    draw_diagram(primary, ("deflection", "load"))
    traced.clear()
    monkeypatch.setattr(diagram, "_process", lambda home: process(home, ()))
    primary = trace_diagram(plan, tmp_path, resume=True)
    assert traced == ["3a"]
    assert all(branch.result["status"] == "finished" for branch in everything(primary))
    with pytest.raises(ValueError, match="--resume: .* has bounds"):
        trace_diagram(Plan("von-mises-truss", {}, Bounds(deflection=2.0), 1), tmp_path, resume=True)


@pytest.mark.slow
def test_command(tmp_path):
    """Each path in a process of its own, with progress; the folder holds what the README says."""
    command = [sys.executable, "-m", "sheetfx", "diagram", "von-mises-truss", "--rise", "3", "--max-deflection", "1",
               "--processes", "2", "-o", str(tmp_path / "out")]
    result = subprocess.run(command, capture_output=True, text=True, timeout=120, env=os.environ)
    assert result.returncode == 0, result.stderr
    assert "branch 1a" in result.stdout and "2 paths, 0 failed" in result.stdout
    names = {file.name for file in (tmp_path / "out").iterdir()}
    assert {"diagram.png", "diagram.csv", "diagram.json", "branches", "manifest.json"} <= names
    with pytest.raises(ValueError, match="-o: the name '' is empty"):
        folder_of("column", "")


def symmetries(names):
    """The twelve symmetries of the dome: numbers of the nodes that free ones go to, and matrices."""
    ring = {name: int(name[-1]) for name in names if name.startswith("inner")}
    for turn in range(6):
        c, s = np.cos(turn * np.pi / 3), np.sin(turn * np.pi / 3)
        for mirror in (1, -1):
            matrix = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]]) @ np.diag([1, mirror, 1])
            images = {name: f"inner{(mirror * i + turn) % 6}" for name, i in ring.items()}
            yield [names.index(images.get(name, name)) for name in names], matrix


@pytest.mark.slow
def test_star_dome(here, tmp_path):
    """Half-branches that a symmetry takes into each other are listed once, and no others.

    A half-branch whose states keep k of the dome's twelve symmetries stands for 12 / k of them. All states are
    equilibria of an independent truss.
    """
    found, _, _ = drawn(tmp_path, "star-dome", Bounds(deflection=14.0), levels=1)
    case = star_dome.case(to=1.0)
    record = trace(case)
    nodes, members = star_dome.dome()
    names = list(nodes)
    free = [i for i, name in enumerate(names) if not name.startswith("outer")]
    bars = np.array([[names.index(end) for end in ends] for ends in members.values()])
    truss = Truss(np.array(list(nodes.values())), bars, free, np.zeros((len(free), 3)))
    moving = [names[i] for i in free]
    kept = Counter()
    for name in found:
        files = sorted((tmp_path / "branches" / name / "states").glob("*.npz"))
        for state in map(State.load_from, files):
            moves = displacements(record, state, moving)
            load = np.array([(0.0, 0.0, -state.factor * (n == "apex")) for n in moving])
            assert truss.derivatives(moves)[0] == pytest.approx(load.ravel(), abs=1e-7)
        first = displacements(record, State.load_from(files[0]), moving)
        kept[name] = sum(np.allclose(first[images], first @ matrix.T, atol=1e-4)
                         for images, matrix in symmetries(moving))
    assert kept.pop("0") == 12
    assert {name: found[name].half["equivalent"] for name in kept} == {name: 12 // k for name, k in kept.items()}
    assert sorted(kept.values()) == sorted(2 * [2, 2, 4, 4, 6])  # and those of the inverted dome
