"""Arrows between rooms run one way, and no room's file has grown too large (sheetfx/README.md)."""

from __future__ import annotations

import ast
import re
from pathlib import Path

HOUSE = Path(__file__).parents[1] / "sheetfx"
ROOMS = [["compat", "checks", "communicators", "interrupts", "jit", "notices", "recipes", "rounding", "widening"],
         ["forms"], ["mesh"], ["model"], ["discrete"], ["continuation"], ["stability"],
         ["path", "plain", "state_files", "archive"], ["show"], ["record"], ["case"], ["scenes"], ["studies"], ["cli"]]
FLOOR = {room: level for level, rooms in enumerate(ROOMS) for room in rooms}
FILES = [f for f in HOUSE.rglob("*.py") if f.parent != HOUSE or f.stem in FLOOR]


def imported(file: Path) -> set[str]:
    """Rooms that a file imports from, inside functions too, but for annotations."""
    tree, here = ast.parse(file.read_text()), file.relative_to(HOUSE).parts
    skipped = {id(n) for block in ast.walk(tree) if isinstance(block, ast.If)
               and ast.unparse(block.test) == "TYPE_CHECKING" for n in ast.walk(block)}
    rooms = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom) and node.level and id(node) not in skipped:
            path = [*here[:len(here) - node.level], *(node.module or "").split(".")]
            names = [path[0]] if path[0] else [alias.name for alias in node.names]
            rooms.update(names)
    return rooms


def test_arrows_run_one_way():
    wrong = [f"{file.relative_to(HOUSE)} imports {room}" for file in FILES for room in imported(file)
             if room in FLOOR and FLOOR[room] > FLOOR[file.relative_to(HOUSE).parts[0].removesuffix(".py")]]
    assert not wrong, "\n".join(wrong)
    rooms = {room for file in FILES for room in imported(file) if (HOUSE / room).is_dir()}
    assert rooms - {"meshes"} <= set(FLOOR), "a room that has no floor"


def test_objects_are_sent_by_communicators_that_are_never_freed():
    """See sheetfx/communicators.py; arrays are sent without a lock."""
    freed = re.compile(r"(domain|index_map|space\.mesh)\.comm\.[a-z]+\(|tompi4py\(\)\.[a-z]+\(")
    assert not [str(file) for file in FILES if freed.search(file.read_text())]


def test_files_stay_readable():
    lengths = {str(f.relative_to(HOUSE)): len(f.read_text().splitlines()) for f in FILES}
    assert max(lengths.values()) <= 330, lengths
    assert lengths["discrete/discretisation.py"] < 200


def test_system_knows_no_contribution_by_name():
    """It imports the protocol, and of the contributions nothing but the matrix of a bilinear form."""
    names = {alias.name for node in ast.walk(ast.parse((HOUSE / "discrete" / "system.py").read_text()))
             if isinstance(node, ast.ImportFrom) for alias in node.names}
    assert not names & {"ElementWork", "FormWork", "NodalLoads", "FixedIncrements", "PointWork", "ContactWork"}
