"""Constants that are moved and guards that are switched off, in the running program.

A constant of a module is set wherever it has been imported to, an unnamed float in the code of its function, a guard
by compiling its function without the place that raises.
"""

from __future__ import annotations

import ast
import functools
import importlib
import inspect
import sys
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path

import numpy as np
from rows import PACKAGE, Row

MISSING = object()


@contextmanager
def changed(row: Row, factor: float | None = None) -> Iterator[bool]:
    """Move a constant by a factor, or switch a guard off.

    Yields
    ------
    Whether that is possible: a constant that is no number, or whose function is wrapped, cannot be moved.
    """
    with ExitStack() as stack:
        if row.kind == "guard":
            yield _switched(row, stack)
        else:
            yield _set(row, lambda value: moved(value, factor), stack)


def moved(value, factor: float):
    """A constant times a factor; whole numbers move by one at least, and stay 1 or more."""
    if isinstance(value, (tuple, list)):
        return type(value)(moved(v, factor) for v in value)
    if isinstance(value, (bool, str)) or not isinstance(value, (int, float, np.floating, np.ndarray)):
        return value
    if isinstance(value, int):
        return value if value <= 0 else max(1, round(value * factor), (value + 1) * (factor > 1))
    return type(value)(value * factor) if not isinstance(value, np.ndarray) else value * factor


def _set(row: Row, change, stack: ExitStack) -> bool:
    """Have another value of a constant; whether it differs."""
    module = importlib.import_module(row.module)
    if row.line:
        return _in_code(_function(module, row.name.split(":")[0]), row.value, change, stack)
    owner, _, name = row.name.rpartition(".")
    if owner:
        return _default(getattr(module, owner), name, change, stack)
    value = getattr(module, name)
    new = change(value)
    for place in [m for key, m in sys.modules.items() if key.startswith("sheetfx") and vars(m).get(name) is value]:
        _replace(place, name, new, stack)
    return new is not value and repr(new) != repr(value)


def _default(owner: type, name: str, change, stack: ExitStack) -> bool:
    """Another default of a dataclass and of those that derive from it."""
    value = getattr(owner, name)
    new = change(value)
    for cls in [c for c in (owner, *_derived(owner)) if getattr(c, name, MISSING) is value]:
        if name in vars(cls):
            _replace(cls, name, new, stack)
        start = cls.__init__
        positional, defaults = start.__code__.co_varnames[:start.__code__.co_argcount], list(start.__defaults__ or ())
        if name in (start.__kwdefaults__ or {}):
            _replace(start, "__kwdefaults__", start.__kwdefaults__ | {name: new}, stack)
        elif defaults and name in positional[-len(defaults):]:
            defaults[positional.index(name) - len(positional)] = new
            _replace(start, "__defaults__", tuple(defaults), stack)
    return repr(new) != repr(value)


def _derived(owner: type) -> list[type]:
    return [cls for sub in owner.__subclasses__() for cls in (sub, *_derived(sub))]


def _in_code(function, value: float, change, stack: ExitStack) -> bool:
    if function is None:
        return False
    code = _with_constant(function.__code__, value, change(value))
    _replace(function, "__code__", code, stack)
    return True


def _with_constant(code, value: float, new):
    """Code with another number, in functions and comprehensions inside too."""
    constants = tuple(new if isinstance(c, float) and type(c) is float and c == value else
                      _with_constant(c, value, new) if inspect.iscode(c) else c for c in code.co_consts)
    return code.replace(co_consts=constants)


def _function(module, title: str):
    """The plain function of a title `name` or `Class.name` behind wrappers and properties; None: there is none."""
    found = functools.reduce(lambda owner, name: vars(owner)[name], title.split("."), module)
    for attribute in ("func", "fget", "__func__"):
        found = getattr(found, attribute, None) or found
    found = inspect.unwrap(found)
    return found if inspect.isfunction(found) else None


def _switched(row: Row, stack: ExitStack) -> bool:
    module = importlib.import_module(row.module)
    if not row.line:
        owner, _, name = row.name.rpartition(".")
        place = getattr(module, owner) if owner else module
        function, value = vars(place)[name], row.value
        places = [place] if owner else [m for key, m in sys.modules.items()
                                        if key.startswith("sheetfx") and vars(m).get(name) is function]
        off = property(lambda _: value) if isinstance(function, property) else lambda *_, **__: value
        for place in places:
            _replace(place, name, off, stack)
        return True
    function = _function(module, row.name.split(":")[0])
    if function is None:
        return False
    _replace(function, "__code__", _without_raise(row, function), stack)
    return True


def _without_raise(row: Row, function):
    """Code of a function that passes the place where it raises."""
    path = PACKAGE / row.file
    tree = ast.parse(path.read_text())

    class Passing(ast.NodeTransformer):
        def visit_Raise(self, node):
            return ast.copy_location(ast.Pass(), node) if node.lineno == row.line else node

    code = compile(ast.fix_missing_locations(Passing().visit(tree)), function.__code__.co_filename, "exec")
    first = function.__code__.co_firstlineno
    return next(c for c in _codes(code) if c.co_firstlineno == first and c.co_name == function.__name__)


def _codes(code) -> Iterator:
    for inner in filter(inspect.iscode, code.co_consts):
        yield inner
        yield from _codes(inner)


def _replace(owner, name: str, new, stack: ExitStack) -> None:
    stack.callback(setattr, owner, name, vars(owner)[name] if isinstance(owner, type) else getattr(owner, name))
    setattr(owner, name, new)


def uses(row: Row) -> list[tuple[Path, ast.AST]]:
    """Files and nodes of the source that use a constant, or raise."""
    if row.line:
        file, title = PACKAGE / row.file, row.name.split(":")[0].rpartition(".")[2]
        inside = [n for f in ast.walk(_tree(file)) if isinstance(f, ast.FunctionDef) and f.name == title
                  for n in ast.walk(f) if getattr(n, "lineno", 0)]
        if row.kind == "constant":
            return [(file, n) for n in inside if isinstance(n, ast.Constant) and n.value == row.value]
        return [(file, n) for n in inside if n.lineno == row.line]
    found = _loads().get(row.name.rpartition(".")[2], [])
    return found if "." in row.name else [(file, node) for file, node in found if row.name in _known(file, row.module)]


@functools.cache
def _known(file: Path, module: str) -> set[str]:
    """Names of a module that a file knows: its own, or those that it imports from there."""
    if "sheetfx." + str(file.relative_to(PACKAGE)).removesuffix(".py").replace("/", ".") == module:
        return {node.id for node in ast.walk(_tree(file)) if isinstance(node, ast.Name)}
    last, nodes = module.rpartition(".")[2], list(ast.walk(_tree(file)))
    imported = {alias.name for node in nodes if isinstance(node, ast.ImportFrom)
                and (node.module or "").rpartition(".")[2] == last for alias in node.names}
    return imported | {node.attr for node in nodes if isinstance(node, ast.Attribute)
                       and isinstance(node.value, ast.Name) and node.value.id == last}


@functools.cache
def _loads() -> dict[str, list[tuple[Path, ast.AST]]]:
    """By name, where the package reads it."""
    found: dict[str, list] = {}
    for file in PACKAGE.rglob("*.py"):
        for node in ast.walk(_tree(file)):
            name = node.id if isinstance(node, ast.Name) else node.attr if isinstance(node, ast.Attribute) else None
            if name and isinstance(node.ctx, ast.Load):
                found.setdefault(name, []).append((file, node))
    return found


@functools.cache
def _tree(file: Path) -> ast.Module:
    return ast.parse(file.read_text())
