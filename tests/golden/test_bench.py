"""The bench moves what it says it moves and puts it back; each constant and guard has its row in the table."""

import csv
import json
from collections import Counter
from contextlib import contextmanager
from dataclasses import asdict, replace

import bench
import moved
import pytest
import rows
import structures

from sheetfx import ArcLength, DisplacementControl
from sheetfx.continuation import defect

ROWS = rows.rows()


def row(name, file):
    return next(r for r in ROWS if (r.name, r.file) == (name, file))


def test_rows_are_told_apart():
    assert [key for key, n in Counter(r.key for r in ROWS).items() if n > 1] == []
    assert {r.kind for r in ROWS} == {"constant", "guard"}


@pytest.mark.parametrize("factor", [0.5, 2.0])
def test_constant_is_moved_wherever_it_is_and_put_back(factor):
    def now():
        return vars(defect)["SHORTEST"]

    usual = now()
    with moved.changed(row("SHORTEST", "continuation/defect.py"), factor) as possible:
        assert possible and now() == factor * usual
    assert now() == usual


def test_default_of_an_option_is_moved():
    for name, usual in (("largest", 8.0), ("turn", 0.8)):
        with moved.changed(row(f"Options.{name}", "continuation/options.py"), 2.0) as possible:
            assert possible and getattr(ArcLength(), name) == getattr(DisplacementControl(), name) == 2 * usual
        assert getattr(ArcLength(), name) == usual


def test_every_place_that_raises_can_be_switched_off():
    for guard in (r for r in ROWS if r.kind == "guard"):
        with moved.changed(guard) as possible:
            assert possible, guard.key


def test_switched_guard_and_its_code():
    before = defect.has_small_defect
    with moved.changed(row("has_small_defect", "continuation/defect.py")):
        assert defect.has_small_defect(None, 0.0, 1.0) is True
    assert defect.has_small_defect is before


def test_every_constant_and_guard_has_its_row():
    """A new one gets its row by `bench.py table`; one that is gone leaves the table by the same command."""
    with bench.TABLE.open() as file:
        table = list(csv.DictReader(file))
    assert tuple(table[0]) == bench.COLUMNS
    assert Counter((row["name"], row["kind"], row["file"]) for row in table) == Counter(
        (row.name, row.kind, row.file) for row in ROWS), "run tests/golden/bench.py table"
    fragile = [f"{row['file']}:{row['name']} {row['margin']}" for row in table
               if row["margin"] and float(row["margin"]) < 2]
    print(f"{len(fragile)} constants with a margin below 2:", *fragile, sep="\n")


def test_structures_that_rows_name_have_golden_figures():
    with bench.TABLE.open() as file:
        named = {name for row in csv.DictReader(file) for name in row["needed_by"].split(";") if name}
    assert named <= json.loads(bench.FIGURES.read_text()).keys()


@pytest.mark.parametrize("needed", [(), ("b",), ("a", "d")])
def test_groups_are_halved_down_to_rows_that_change_an_outcome(monkeypatch, needed):
    """A structure whose outcome changes with some rows: each is found, and no other."""
    changed = set()

    @contextmanager
    def pretend(row, factor):
        changed.add(row.key)
        yield True
        changed.discard(row.key)

    first = structures.Outcome((), 1.0, 1.0, 2, 2, 0.1, "deflection 1 reached")
    monkeypatch.setattr(bench.moved, "changed", pretend)
    monkeypatch.setattr(bench.rows, "rows", lambda: [rows.Row(name, "constant", "", 0, 1.0) for name in "abcde"])
    monkeypatch.setattr(structures, "outcome",
                        lambda name, within=0.0: replace(first, load=1.0 + len(changed & {f":{n}" for n in needed})))
    found = bench.trials("", 2.0, [f":{name}" for name in "abcde"], asdict(first) | {"accuracy": 0.0}, 4)
    assert found["differing"].keys() == {f":{name}" for name in needed} and found["together"] == []


def test_quick_structures_give_their_golden_figures():
    """The cheapest of each kind; `bench.py check` compares all."""
    kept = json.loads(bench.FIGURES.read_text())
    for name in ("trap:von-mises-truss", "truss:2", "frame:1", "untried:plastic-portal", "after:branches-frame"):
        assert bench.against(name, kept[name])[0] == "", name
