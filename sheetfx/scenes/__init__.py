"""Scenes that `sheetfx run NAME` knows: each module's function `case` makes one."""

from __future__ import annotations

import importlib
import inspect
import pkgutil
from collections.abc import Callable, Iterable
from difflib import get_close_matches
from functools import wraps
from pathlib import Path

from ..checks import checked
from ._scripts import case_of, of_script


def scene_names() -> list[str]:
    """Names of the built-in scenes."""
    names = (module.name for module in pkgutil.iter_modules(__path__))
    return sorted(name.replace("_", "-") for name in names if not name.startswith("_"))


def meant(name: str, known: Iterable[str]) -> str:
    """A question for the nearest of known names, "" where none is near."""
    near = get_close_matches(name.lower().replace("_", "-"), known, 1)
    return f"did you mean {near[0]!r}? " if near else ""


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
        return _as_command(name, case_of(name))
    if name not in scene_names():
        raise ValueError(f"unknown scene {name!r}; {meant(name, scene_names())}choose one of "
                         f"{', '.join(scene_names())}, or a script ending in .py")
    module = importlib.import_module(f"{__name__}.{name.replace('-', '_')}")
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
            kind = type(case).__name__
            value = f"{case!r}, " if isinstance(case, (int, float, str)) else ""
            found = "None" if case is None else f"{value}{'an' if kind[0] in 'AEIOUaeiou' else 'a'} {kind}"
            remedy = "return fx.Case(scene)" if kind == "Scene" else "return a sheetfx.Case"
            raise ValueError(f"the script {name}: case returns {found}; {remedy}")
        return case

    return checked(wraps(function)(made) if name.endswith(".py") else function, Path(name).stem, option_of)


def option_of(parameter: inspect.Parameter) -> str:
    """The option of a command that a parameter becomes."""
    flags = [flag for rule in getattr(parameter.annotation, "__metadata__", ())
             for flag in (getattr(rule, "default", None), *(getattr(rule, "param_decls", None) or ()))
             if isinstance(flag, str) and flag.startswith("--")]
    return flags[-1] if flags else "--" + parameter.name.replace("_", "-")
