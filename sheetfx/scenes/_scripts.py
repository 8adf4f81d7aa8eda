"""Scripts of a user's: their module, their function `case`, and what messages say of both."""

from __future__ import annotations

import importlib.util
import inspect
import sys
import traceback
import types
from collections.abc import Callable
from datetime import datetime
from enum import Enum
from pathlib import Path, PurePath
from typing import Annotated, Literal, Union, get_args, get_origin
from uuid import UUID

REMEDY = "add `def case(size: float = 1.0) -> fx.Case`"
SIMPLE = bool, int, float, str
VARIABLE = {inspect.Parameter.VAR_POSITIONAL: "*", inspect.Parameter.VAR_KEYWORD: "**"}


def module_of(name: str):
    """The module of a script, which finds modules beside it first, as those that Python itself runs do.

    Raises
    ------
    ValueError
        Where there is no such file, or the script fails.
    """
    file = Path(name)
    if not file.is_file():
        raise ValueError(f"cannot read the script {name}: no such file; check the path")
    folder = str(file.resolve().parent)
    sys.path[:] = [folder, *(entry for entry in sys.path if entry != folder)]
    spec = importlib.util.spec_from_file_location(file.stem, file)
    module = importlib.util.module_from_spec(spec)
    sys.modules[file.stem] = module
    try:
        spec.loader.exec_module(module)
    except SyntaxError as error:
        raise ValueError(f"cannot read the script {name}: {error}; mend that line") from error
    except ImportError as error:
        at = [f for f in traceback.extract_tb(error.__traceback__) if "importlib" not in f.filename][-1]
        raise ValueError(f"the script {name}: {error} ({at.filename}, line {at.lineno}); install that package, put the "
                         "module beside the script, or mend the name") from error
    except Exception as error:
        raise ValueError(of_script(name, error)) from error
    return module


def case_of(name: str) -> Callable:
    """The function `case` of a script, whose parameters can all be options.

    Raises
    ------
    ValueError
        Names the script, and the parameter that cannot be one.
    """
    function = getattr(module_of(name), "case", None)
    if not callable(function):
        raise ValueError(f"the script {name} has no function `case` that returns a sheetfx.Case; {REMEDY}")
    try:
        parameters = inspect.signature(function, eval_str=True).parameters.values()
    except NameError as error:
        raise ValueError(f"the script {name}: an annotation of case is not known: {error}; import that name") from error
    for parameter in parameters:
        _check_option(f"the script {name}: case: ", parameter)
    return function


def _check_option(where: str, parameter: inspect.Parameter) -> None:
    """Refuse a parameter that cannot be an option of a command."""
    name, annotation, default = parameter.name, parameter.annotation, parameter.default
    if parameter.kind in VARIABLE:
        raise ValueError(f"{where}{VARIABLE[parameter.kind]}{name} cannot be an option; name each parameter, with its "
                         "annotation and default, such as size: float = 1.0")
    if parameter.kind is inspect.Parameter.POSITIONAL_ONLY:
        raise ValueError(f"{where}{name} stands before a /, and cannot be an option; take the / out")
    if annotation is parameter.empty:
        kind = type(default).__name__ if type(default) in SIMPLE else "float"
        value = f" = {default!r}" if default is not parameter.empty else ""
        raise ValueError(f"{where}the parameter {name} has no annotation, so that its option has no type; write "
                         f"{name}: {kind}{value}")
    if not _written_in_words(annotation):
        raise ValueError(f"{where}the parameter {name} is annotated {_words(annotation)}, which cannot be an option; "
                         "take float, int, bool, str, or a tuple of these, and make the rest inside case")
    if default not in (parameter.empty, None) and not _fits(default, annotation):
        raise ValueError(f"{where}the default of {name} is {default!r}, but its annotation is {_words(annotation)}; "
                         "give both the same type")


def _written_in_words(annotation) -> bool:
    """Whether values are read from the command line: plain ones, choices, paths, and several or none of these."""
    origin, inner = get_origin(annotation), get_args(annotation)
    if origin is Annotated:
        own = any(getattr(rule, "parser", None) or getattr(rule, "click_type", None) for rule in inner[1:])
        return own or _written_in_words(inner[0])
    if origin in (Union, types.UnionType, tuple, list):
        return all(_written_in_words(kind) for kind in inner if kind is not Ellipsis)
    written = isinstance(annotation, type) and issubclass(annotation, (Enum, PurePath, datetime, UUID))
    return origin is Literal or written or annotation in (*SIMPLE, types.NoneType)


def _words(annotation) -> str:
    return annotation.__name__ if isinstance(annotation, type) and not get_args(annotation) else str(annotation)


def _fits(default, annotation) -> bool:
    """Whether a default is of an annotation's type, where that is simple."""
    if get_origin(annotation) is Annotated:
        annotation = get_args(annotation)[0]
    kinds = get_args(annotation) if get_origin(annotation) in (Union, types.UnionType) else (annotation,)
    if not all(kind in (*SIMPLE, type(None)) for kind in kinds):
        return True
    if isinstance(default, bool):
        return bool in kinds
    return isinstance(default, tuple(kinds)) or (float in kinds and isinstance(default, int))


def of_script(name: str, error: BaseException) -> str:
    """What happened in a script, and on which of its lines."""
    script = Path(name).resolve()
    lines = [f.lineno for f in traceback.extract_tb(error.__traceback__) if Path(f.filename).resolve() == script]
    where = f", line {lines[-1]}" if lines else ""
    if isinstance(error, ValueError) and str(error).startswith(f"the script {name}"):
        return str(error)
    kind = "" if type(error) is ValueError else f"{type(error).__name__}: "
    return f"the script {name}{where}: {kind}{error}; sheetfx --traceback ... shows how it came to that"
