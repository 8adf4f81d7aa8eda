"""Scenes that `sheetfx run NAME` knows: each module's function `case` makes one."""

from __future__ import annotations

import importlib
import importlib.util
import inspect
import pkgutil
import sys
import traceback
from collections.abc import Callable
from functools import wraps
from pathlib import Path

from ..checks import checked


def scene_names() -> list[str]:
    """Names of the built-in scenes."""
    names = (module.name for module in pkgutil.iter_modules(__path__))
    return sorted(name.replace("_", "-") for name in names if not name.startswith("_"))


def looked_at(function: Callable) -> Callable:
    """The function `case` of a scene, which refuses what its annotations do not allow."""
    return checked(function, function.__module__.rpartition(".")[2].replace("_", "-"))


def load_case(name: str):
    """The function `case` of a built-in scene or of a user's script, which looks at what it is given.

    Raises
    ------
    ValueError
        Where there is no such scene or script, or the script cannot be used.
    """
    if name.endswith(".py"):
        file = Path(name)
        if not file.is_file():
            raise ValueError(f"cannot read the script {name}: no such file; check the path")
        spec = importlib.util.spec_from_file_location(file.stem, file)
        module = importlib.util.module_from_spec(spec)
        sys.modules[file.stem] = module
        try:
            spec.loader.exec_module(module)
        except SyntaxError as error:
            raise ValueError(f"cannot read the script {name}: {error}; mend that line") from error
        except Exception as error:
            raise ValueError(of_script(name, error)) from error
    elif name in scene_names():
        module = importlib.import_module(f"{__name__}.{name.replace('-', '_')}")
    else:
        raise ValueError(f"unknown scene {name!r}; choose one of {', '.join(scene_names())}, or a script ending in .py")
    if not hasattr(module, "case"):
        raise ValueError(f"the script {name} has no function `case` that returns a sheetfx.Case; add one")
    return _as_command(name, module.case)


def _as_command(name: str, function: Callable) -> Callable:
    """The function of a scene, which calls its parameters as options are; a script's gives a Case or names its line."""
    def made(*positional, **named):
        try:
            case = function(*positional, **named)
        except Exception as error:
            raise ValueError(of_script(name, error)) from error
        from ..case import Case

        if not isinstance(case, Case):
            raise ValueError(f"the script {name}: case returns {case!r}; return a sheetfx.Case")
        return case

    return checked(wraps(function)(made) if name.endswith(".py") else function, Path(name).stem, option_of)


def option_of(parameter: inspect.Parameter) -> str:
    """The option of a command that a parameter becomes."""
    flags = [flag for rule in getattr(parameter.annotation, "__metadata__", ())
             for flag in (getattr(rule, "default", None), *(getattr(rule, "param_decls", None) or ()))
             if isinstance(flag, str) and flag.startswith("--")]
    return flags[-1] if flags else "--" + parameter.name.replace("_", "-")


def of_script(name: str, error: BaseException) -> str:
    """What happened in a script, and on which of its lines."""
    script = Path(name).resolve()
    lines = [f.lineno for f in traceback.extract_tb(error.__traceback__) if Path(f.filename).resolve() == script]
    where = f", line {lines[-1]}" if lines else ""
    if isinstance(error, ValueError) and str(error).startswith(f"the script {name}"):
        return str(error)
    kind = "" if type(error) is ValueError else f"{type(error).__name__}: "
    return f"the script {name}{where}: {kind}{error}; sheetfx --traceback ... shows how it came to that"
