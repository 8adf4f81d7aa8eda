"""Rows of the table: constants and guards of the path follower and of contact, as the source has them.

A constant is an upper-case number (or numbers) of a module, a number in a dataclass of options other than 0, or an
unnamed float in a function, 0, 1, -1, 0.5 and 2 excepted; rules of quadrature, bases and tables of indices are none.
A guard is a place that raises a result of a step (`SIGNALS`), a predicate that refuses one, or a retry that is tried
where one fails (`SWITCHES`).
"""

from __future__ import annotations

import ast
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

PACKAGE = Path(__file__).parents[2] / "sheetfx"
ROOMS = ("continuation/*.py", "events/*.py", "critical/*.py", "path.py", "rounding.py", "*/*contact*.py", "*/*pair*.py",
         "*/obstacle*.py", "*/zones.py", "*/layer.py", "*/growth.py", "*/surface_*.py", "*/partners.py",
         "*/closest_point.py")
TRIVIAL = 0.0, 1.0, -1.0, 0.5, 2.0
# files whose dataclasses are a user's
OPTIONS = "continuation/options.py", "continuation/control.py", "events/until.py", "model/"
# Sizes and indices that follow from a formulation, and what a user says: a load, a number of repeated parts.
NO_CONSTANTS = ("discrete/closest_point.py:ROWS",
                "discrete/obstacle_work.py:DISTANCE", "discrete/obstacle_work.py:BEFORE",
                "discrete/obstacle_work.py:SLIPPED",
                "discrete/zones.py:SAMPLES", "discrete/zones.py:POINTS", "continuation/work.py:POINTS",
                "critical/fall.py:POINTS", "critical/fall.py:WEIGHTS", "critical/branches.py:TURN",
                "continuation/control.py:LoadControl.target",
                # fields of the state, before there is one
                "continuation/control.py:LoadResponse.initial_norm2",
                "continuation/control.py:LoadResponse.current_stiffness")
SIGNALS = "Jump", "Missed", "Hidden", "Uncounted", "Unsettled"
# What each predicate, retry or homotopy gives where it is switched off.
SWITCHES = {
    "continuation/visited.py:VisitedStates.holds": False,
    "continuation/defect.py:has_small_defect": True,
    "continuation/work.py:require_work": None,
    "events/leaping.py:require_convergence": None,
    "events/heading.py:hides": False,
    "continuation/corrector.py:BorderedNewton._gives_way": False,
    "continuation/elimination.py:Elimination._is_patient": False,
    "continuation/enforcement.py:Enforcement._detours": [1.0],
    "continuation/enforcement.py:Enforcement._multiples": [1.0],
    "discrete/condensed_pairs.py:CondensedPairs.freeze_open_contacts": False,
    "discrete/growth.py:Growth.retreats": False,
    "discrete/growth.py:Growth.turns_round": False,
    "discrete/pair_work.py:PairWork.foresee": None,
    "discrete/pair_work.py:PairWork._is_little": True,
    "path.py:Path._past_corner": None,
    "path.py:Path._by_change": None,
    "path.py:Path._around_corner": None,
}


@dataclass(frozen=True)
class Row:
    """A constant or a guard.

    Attributes
    ----------
    name : `NAME`, `Class.field`, `function: value` or `function: "message"`, unique in its file
    kind : "constant" or "guard"
    file : below the package
    line : of the source, of an unnamed float or a place that raises; 0 for others
    value : of a constant; what a switched predicate gives
    """

    name: str
    kind: str
    file: str
    line: int
    value: object

    @property
    def module(self) -> str:
        return "sheetfx." + self.file.removesuffix(".py").replace("/", ".")

    @property
    def key(self) -> str:
        return f"{self.file}:{self.name}"


def files() -> list[Path]:
    """Files that have rows."""
    return sorted({file for pattern in ROOMS for file in PACKAGE.glob(pattern)
                   if file.relative_to(PACKAGE).parts[0] not in ("forms", "scenes", "show", "studies")})


def rows() -> list[Row]:
    """All rows, by file and place."""
    found = list({row.key: row for file in files() for row in _rows_of(file) if row.key not in NO_CONSTANTS}.values())
    for switch, off in SWITCHES.items():
        file, name = switch.split(":")
        found.append(Row(name, "guard", file, 0, off))
    return found


def _rows_of(file: Path) -> Iterator[Row]:
    tree, place = ast.parse(file.read_text()), str(file.relative_to(PACKAGE))
    for node in tree.body:
        if isinstance(node, ast.Assign):
            yield from (Row(name, "constant", place, 0, value) for name, value in _assigned(node))
        if isinstance(node, ast.ClassDef) and place.startswith(OPTIONS):
            yield from (Row(f"{node.name}.{f.target.id}", "constant", place, 0, f.value.value) for f in node.body
                        if isinstance(f, ast.AnnAssign) and isinstance(f.target, ast.Name) and _is_number(f.value)
                        and f.value.value)
    seen: dict[str, int] = {}
    for title, function in _functions(tree):
        for node in _own_nodes(function):
            row = None
            if isinstance(node, ast.Constant) and isinstance(node.value, float) and node.value not in TRIVIAL:
                row = f"{title}: {node.value!r}", "constant", node.value
            elif isinstance(node, ast.Raise) and (told := _signal(node)):
                row = f"{title}: {told}", "guard", None
            if row:
                seen[row[0]] = seen.get(row[0], 0) + 1
                name = row[0] if seen[row[0]] == 1 else f"{row[0]} ({seen[row[0]]})"
                yield Row(name, row[1], place, node.lineno, row[2])


def _is_number(node) -> bool:
    return isinstance(node, ast.Constant) and type(node.value) in (int, float)


def _holds_number(node) -> bool:
    return _is_number(node) or any(_holds_number(child) for child in ast.iter_child_nodes(node))


def _is_rule(node) -> bool:
    """Whether a value is a rule of quadrature, a basis or a table of indices: its numbers follow from one another."""
    return any(isinstance(part, ast.Subscript)
               or (isinstance(part, ast.Call) and not ast.unparse(part.func).endswith("finfo"))
               for part in ast.walk(node))


def _assigned(node: ast.Assign) -> Iterator[tuple[str, object]]:
    """Upper-case names that an assignment gives numbers, with the literal value where there is one."""
    if not _holds_number(node.value):
        return
    for target in node.targets:
        names = target.elts if isinstance(target, ast.Tuple) else [target]
        parts = node.value.elts if isinstance(target, ast.Tuple) and isinstance(node.value, ast.Tuple) else [node.value]
        for name, part in zip(names, parts if len(parts) == len(names) else parts * len(names), strict=True):
            if isinstance(name, ast.Name) and name.id.isupper() and _holds_number(part) and not _is_rule(part):
                yield name.id, ast.unparse(part)


def _functions(tree: ast.Module) -> Iterator[tuple[str, ast.FunctionDef]]:
    for node in tree.body:
        if isinstance(node, ast.FunctionDef):
            yield node.name, node
        elif isinstance(node, ast.ClassDef):
            yield from ((f"{node.name}.{f.name}", f) for f in node.body if isinstance(f, ast.FunctionDef))


def _own_nodes(function: ast.FunctionDef) -> Iterator[ast.AST]:
    """Nodes of the body, in the order of the source."""
    found = [node for part in function.body for node in ast.walk(part)]
    return iter(sorted((n for n in found if hasattr(n, "lineno")), key=lambda n: (n.lineno, n.col_offset)))


def _signal(node: ast.Raise) -> str:
    """What a place that raises a result of a step tells; "" for other errors."""
    if not isinstance(node.exc, ast.Call) or getattr(node.exc.func, "id", "") not in SIGNALS:
        return ""
    return ast.unparse(node.exc)
