"""Scenes that `sheetfx run NAME` knows: each module's function `case` makes one."""

from __future__ import annotations

import importlib
import importlib.util
import pkgutil
import sys
from pathlib import Path


def scene_names() -> list[str]:
    """Names of the built-in scenes."""
    names = (module.name for module in pkgutil.iter_modules(__path__))
    return sorted(name.replace("_", "-") for name in names if not name.startswith("_"))


def load_case(name: str):
    """The function `case` of a built-in scene or of a user's script.

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
            raise ValueError(f"cannot read the script {name}: {error}; mend that line") from None
    elif name in scene_names():
        module = importlib.import_module(f"{__name__}.{name.replace('-', '_')}")
    else:
        raise ValueError(f"unknown scene {name!r}; choose one of {', '.join(scene_names())}, or a script ending in .py")
    if not hasattr(module, "case"):
        raise ValueError(f"the script {name} has no function `case` that returns a sheetfx.Case; add one")
    return module.case
