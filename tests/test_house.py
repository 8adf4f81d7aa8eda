"""Arrows between rooms and between files run one way, and what is read at once stays small (sheetfx/README.md)."""

from __future__ import annotations

import ast
import re
from functools import cache
from graphlib import TopologicalSorter
from pathlib import Path

HOUSE = Path(__file__).parents[1] / "sheetfx"
ROOMS = [["compat", "checks", "communicators", "interrupts", "jit", "notices", "recipes", "rooms", "rounding",
          "widening"],
         ["forms"], ["mesh"], ["model"], ["discrete"], ["continuation"], ["events"], ["critical"],
         ["path", "plain", "archive", "richer_path"], ["show"], ["record"], ["case"], ["ladder"],
         ["scenes"], ["studies"], ["cli"]]
FLOOR = {room: level for level, rooms in enumerate(ROOMS) for room in rooms}
FILES = [f for f in HOUSE.rglob("*.py") if f.parent != HOUSE or f.stem in FLOOR]


@cache
def relative_imports(file: Path) -> list[ast.ImportFrom]:
    """Inside functions too, but for annotations."""
    tree = ast.parse(file.read_text())
    skipped = {id(n) for block in ast.walk(tree) if isinstance(block, ast.If)
               and ast.unparse(block.test) == "TYPE_CHECKING" for n in ast.walk(block)}
    return [n for n in ast.walk(tree) if isinstance(n, ast.ImportFrom) and n.level and id(n) not in skipped]


def imported(file: Path) -> set[str]:
    """Rooms that a file imports from."""
    here, rooms = file.relative_to(HOUSE).parts, set()
    for node in relative_imports(file):
        path = [*here[:len(here) - node.level], *(node.module or "").split(".")]
        rooms.update([path[0]] if path[0] else [alias.name for alias in node.names])
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


def neighbours(file: Path) -> set[Path]:
    """Files that a file imports from."""
    here, found = file.parent, set()
    for node in relative_imports(file):
        home = [here, *here.parents][node.level - 1].joinpath(*(node.module or "").split("."))
        found |= {f for f in (home.with_suffix(".py"), *(home / f"{alias.name}.py" for alias in node.names))
                  if f.is_file()}
    return found


def test_files_have_an_order():
    """Each can be read, tested and replaced with those below it alone."""
    assert len(tuple(TopologicalSorter({file: neighbours(file) for file in FILES}).static_order())) >= len(FILES)


def test_files_stay_readable():
    """A function fits on a screen without its docstring, and a file is understood with a few others.

    Length alone is no measure of a file: what one idea needs stands in one. Loops that numba compiles are one function.
    """
    known = {file: len(neighbours(file)) for file in FILES if "scenes" not in file.parts}
    assert max(known.values()) <= 25, known
    lengths = {(str(file.relative_to(HOUSE)), function.name): own_lines(function) for file in FILES
               for function in ast.walk(ast.parse(file.read_text())) if isinstance(function, ast.FunctionDef)
               and not any("njit" in ast.unparse(decorator) for decorator in function.decorator_list)}
    assert max(lengths.values()) <= 55, max(lengths, key=lengths.__getitem__)


def own_lines(function: ast.FunctionDef) -> int:
    """Lines of a function, those of its docstring and of functions within it excepted."""
    documented = ast.get_docstring(function) is not None
    inner = [n for n in ast.walk(function) if isinstance(n, ast.FunctionDef) and n is not function]
    within = {line for n in [*inner, *function.body[:documented]] for line in range(n.lineno, n.end_lineno + 1)}
    return len(set(range(function.lineno, function.end_lineno + 1)) - within)


def test_system_knows_no_contribution_by_name():
    """It imports the protocol, and of the contributions nothing but the matrix of a bilinear form."""
    names = {alias.name for node in ast.walk(ast.parse((HOUSE / "discrete" / "system.py").read_text()))
             if isinstance(node, ast.ImportFrom) for alias in node.names}
    assert not names & {"ElementWork", "FormWork", "NodalLoads", "FixedIncrements", "PointWork", "ContactWork"}
