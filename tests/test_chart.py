"""Speed-accuracy charts: numbers, picture, ratios to peers, and what is left out."""

import csv
import json
import os
import subprocess
import sys

import pytest

from sheetfx.studies.chart import Member, Peer, Point, Unusable, error_percent, measure, options, rivals

SCRIPT = '''
from sheetfx.scenes.bend import case as bend

REFERENCE = {"tip_x": 15.558, "tip_z": 53.61}
CHART = [{"elements": 4, "degree": 1}, {"elements": 4, "degree": 2}]
PEERS = [{"driver": DRIVER, "arguments": ["--cells", 7]}, {"driver": ABSENT, "arguments": []}]


def case(elements: int = 8, degree: int = 2, plain_tangent: bool = False):
    """The bend in one step fewer."""
    return bend(elements=elements, degree=degree, plain_tangent=plain_tangent, steps=5)
'''
DRIVER = '''
import json, sys
assert sys.argv[1:] == ["--cells", "7"]
print(json.dumps({"peer": "Slow", "unknowns": 90, "iterations": 12, "cpu_s": 1000.0,
                  "quantities": {"tip_x": 15.558, "tip_z": 54.1461}}))
print("a banner after the report")
'''


def point(method="own", cpu=1.0, error=1.0, peer=False):
    return Point(method, "", peer, 100, 10, 10, cpu, error, {})


@pytest.fixture
def script(tmp_path):
    (tmp_path / "slow.py").write_text(DRIVER)
    (tmp_path / "absent.py").write_text("import a_package_that_is_not_there\n")
    file = tmp_path / "bent.py"
    file.write_text(f"DRIVER, ABSENT = {str(tmp_path / 'slow.py')!r}, {str(tmp_path / 'absent.py')!r}\n" + SCRIPT)
    return file


def chart(*arguments):
    return subprocess.run([sys.executable, "-m", "sheetfx", "chart", *map(str, arguments)], text=True,
                          capture_output=True, timeout=300, env=os.environ | {"COLUMNS": "200"})


@pytest.mark.slow
def test_chart_of_a_script_beside_a_peer(script, tmp_path):
    """The peer's error is 1 %: the coarse member with 4 % does not count, the other one does."""
    result = chart(script, "--repeat", 1, "-o", tmp_path / "out")
    assert result.returncode == 0, result.stderr
    with (tmp_path / "out" / "chart.csv").open() as stream:
        rows = list(csv.DictReader(stream))
    assert [r["method"] for r in rows] == ["sheetfx", "sheetfx", "Slow"]
    assert rows[1]["label"] == "elements 4, degree 2" and rows[1]["unknowns"] == "48"
    assert float(rows[0]["error_percent"]) > 2 > 0.1 > float(rows[1]["error_percent"])
    assert float(rows[2]["error_percent"]) == pytest.approx(1.0)
    assert float(rows[1]["tip_z"]) == pytest.approx(53.61, rel=1e-3)
    assert (tmp_path / "out" / "chart.png").read_bytes()[:4] == b"\x89PNG"
    ratio = float(rows[1]["cpu_seconds"]) / 1000
    assert f"{ratio:.3f} of the CPU time of Slow" in result.stdout
    absent = [line for line in result.stdout.splitlines() if line.startswith("absent")]
    assert len(absent) == 1 and "cannot be imported" in absent[0]


@pytest.mark.parametrize(("arguments", "words"), [
    (["roll-up"], ["roll-up", "REFERENCE"]),
    (["nowhere"], ["nowhere", "choose one of"]),
    (["roll-up", "--repeat", 0], ["--repeat", "1"]),
])
def test_errors_name_object_and_remedy(arguments, words, command):
    status, _, errors = command("chart", *arguments)
    assert status == 2 and errors.count("\n") == 1
    for word in words:
        assert word in errors


def test_help_lists_what_can_be_chosen(command):
    shown = " ".join(command("chart", "--help")[1].split())
    assert "hemisphere" in shown and "slit-annulus" in shown and "--resume" in shown and "roll-up" not in shown


def test_options_come_from_the_scene(script):
    given = {"elements": 6, "plain_tangent": True}
    assert options(str(script), given) == ["--elements", "6", "--plain-tangent"]
    assert options("bend", {"polar": True, "plain_tangent": False}) == ["--polar"]
    with pytest.raises(ValueError, match="'cells'"):
        options("bend", {"cells": 3})


def test_names_of_members():
    member = Member("roof", {"cells": 8, "form": "naghdi-q3", "thickness": 6.35, "full": True, "coarse": False})
    assert member.method == "sheetfx, form naghdi-q3, full"
    assert member.label == "cells 8, thickness 6.35"


def test_rivals_are_the_cheapest_of_equal_or_smaller_error():
    peer, good = point("peer", 4.0, 1.0, peer=True), point("good", 2.0, 1.0)
    assert rivals([point("coarse", 0.1, 1.1), point("fine", 3.0, 0.1), good, peer]) == [(peer, good)]
    assert rivals([point("coarse", 0.1, 1.1), peer]) == [(peer, None)]


def test_error_is_the_largest_of_the_reference():
    assert error_percent({"a": 1.01, "b": -1.9, "c": 7.0}, {"a": 1.0, "b": -2.0}) == pytest.approx(5.0)
    with pytest.raises(Unusable, match="b"):
        error_percent({"a": 1.0}, {"a": 1.0, "b": 2.0})


@pytest.fixture
def order(monkeypatch):
    """Grows with the labels of what runs; of three runs after the first the median takes 2 s."""
    labels = []

    def run(method):
        labels.append(method.label)
        return {"method": "m", "unknowns": 1, "factorisations": 1, "iterations": 1,
                "cpu_seconds": [9.0, 1.0, 5.0, 2.0][labels.count(method.label) - 1], "quantities": {"a": 1.0}}

    monkeypatch.setattr(Member, "run", run)
    monkeypatch.setattr(Peer, "run", run)
    return labels


MEMBERS, PEERS = [Member("s", {"n": 1}), Member("s", {"n": 2})], [Peer("p.py", ["x"])]


def test_turns_mix_peers_with_members_and_take_medians(order):
    """The first turn warms up and does not count; a peer stands between the members."""
    kept = []
    points = measure({"a": 1.0}, MEMBERS, PEERS, 3, keep=lambda points, _: kept.append([p.label for p in points]))
    assert order == ["n 1", "x", "n 2"] * 4
    assert kept == [["n 1"], ["n 1", "x"]] + 10 * [["n 1", "n 2", "x"]], "every result is kept as it comes"
    assert [(p.cpu_seconds, p.runs) for p in points] == [(2.0, 3)] * 3
    assert [p.peer for p in points] == [False, False, True]


def test_interrupted_chart_goes_on(order):
    """After the first turn and one run that counts."""
    kept = []

    def interrupt(points, runs):
        kept[:] = points, json.loads(json.dumps(runs))
        if len(order) == 4:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        measure({"a": 1.0}, MEMBERS, PEERS, 3, keep=interrupt)
    assert [(p.label, p.cpu_seconds, p.runs) for p in kept[0]] == [("n 1", 1.0, 1), ("n 2", 9.0, 0), ("x", 9.0, 0)]
    points = measure({"a": 1.0}, MEMBERS, PEERS, 3, keep=interrupt, earlier=kept[1])
    assert order == ["n 1", "x", "n 2"] * 4
    assert [(p.cpu_seconds, p.runs) for p in points] == [(2.0, 3)] * 3
