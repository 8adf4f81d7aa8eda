"""Compilation of weak forms by DOLFINx, whose cache on disk stays sound where a process is killed while it compiles.

FFCx lets the first process that needs a kernel compile it, and others wait for the file that says it is done. A
process that is killed in between (Ctrl-C, a time limit, memory) would leave all later ones waiting for ever. Here each
process holds a lock, with the time at which it began, while it compiles or waits; the system lets go of it where the
process is killed, so that the next one finds it, and takes away the kernels that were left unfinished.
"""

from __future__ import annotations

import fcntl
import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from tempfile import mkstemp
from typing import IO

import dolfinx.jit
from dolfinx import fem

# Python may have been built with -g, and passes it on: debugging information is a third of the time of compilation.
OPTIONS = {"timeout": 600, "cffi_extra_compile_args": ["-O2", "-g0"]}
ANNOUNCED = "compiling"  # folder in the cache with a file of each process that compiles
_looked_after: set[Path] = set()  # caches, by this process


def compiled_form(form) -> fem.Form:
    """A UFL form, or an array of them, as kernels and data for assembly."""
    with _announced():
        return fem.form(form, jit_options=OPTIONS)


def compiled_expression(expression, points) -> fem.Expression:
    """A UFL expression as a kernel for its values at points of the reference cell, shape (n, dimension)."""
    with _announced():
        return fem.Expression(expression, points, jit_options=OPTIONS)


@contextmanager
def _announced() -> Iterator[None]:
    """Hold the lock of a process that compiles, after kernels are gone that others were killed in."""
    cache = Path(dolfinx.jit.get_options(OPTIONS)["cache_dir"])
    folder = cache / ANNOUNCED
    folder.mkdir(parents=True, exist_ok=True)
    lock, mine = _locked_file(folder)
    try:
        others = [file for file in folder.iterdir() if file != mine]
        if others or cache not in _looked_after:
            _remove_unfinished(cache, others, os.fstat(lock).st_mtime)
            _looked_after.add(cache)
        yield
    finally:
        mine.unlink(missing_ok=True)
        os.close(lock)


def _locked_file(folder: Path) -> tuple[int, Path]:
    """A new file whose lock this process holds: until it does, another one may take it away as that of a dead one."""
    while True:
        lock, name = mkstemp(dir=folder)
        fcntl.flock(lock, fcntl.LOCK_EX)
        if Path(name).exists():
            return lock, Path(name)
        os.close(lock)


def _remove_unfinished(cache: Path, others: list[Path], now: float) -> None:
    """Take away kernels that nobody finishes.

    They were begun before all processes that live, and after one that is dead, or longer ago than others wait.
    """
    living, dead = {}, {}
    for file in others:
        with suppress(FileNotFoundError), open(file) as lock:
            (dead if _is_free(lock) else living)[file] = file.stat().st_mtime
    files = {file.name for file in os.scandir(cache)}
    begun = {}
    for name in files:
        if name.endswith(".c") and f"{name}.cached" not in files:
            with suppress(FileNotFoundError):
                begun[name] = (cache / name).stat().st_mtime
    last = min([*living.values(), now])
    for name, time in begun.items():
        if time < last and (time >= min(dead.values(), default=now) or time < now - OPTIONS["timeout"]):
            (cache / name).unlink(missing_ok=True)
    if all(time < last for time in begun.values()):  # else some may be theirs or those of the living
        for file in dead:
            file.unlink(missing_ok=True)


def _is_free(lock: IO) -> bool:
    """Whether no process holds the lock of a file."""
    try:
        fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    return True
