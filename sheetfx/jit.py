"""Compilation of weak forms by DOLFINx, whose cache on disk stays sound where a process is killed while it compiles.

Kernels of expressions are found again by what the expressions are made of (`recipes.py`), without a form compiler.

FFCx lets the first process that needs a kernel compile it, and others wait for the file that says it is done. A
process that is killed in between (Ctrl-C, a time limit, memory) would leave all later ones waiting for ever. Here each
process holds a lock, with the time at which it began, while it compiles or waits; the system lets go of it where the
process is killed, so that the next one finds it, and takes away the kernels that were left unfinished.
"""

from __future__ import annotations

import fcntl
import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from functools import lru_cache, partial
from hashlib import sha256
from importlib import import_module, metadata
from importlib.machinery import EXTENSION_SUFFIXES
from importlib.util import module_from_spec, spec_from_file_location
from inspect import getsourcefile
from pathlib import Path
from tempfile import mkstemp
from typing import IO

import cffi
import dolfinx.jit
import numpy as np
from dolfinx import fem
from llvmlite.binding import get_host_cpu_features

from .communicators import lasting
from .recipes import Description, Recipe, Undescribed
from .widening import ARGUMENT, CellExpression, builder_for

# Python may have been built with -g, and passes it on: debugging information is a third of the time of compilation.
# Kernels are long straight lines: more than -O1 makes the compiler slower, not them; fused products a quarter faster.
# Their many values are SHORT of registers whatever is tried: the search for the best ones, for expressions to be
# moved to where they are used and for three instructions in one takes more than half of the time, and gains nothing.
# Vectors of cells go from no library to another, so that it does not matter how processors pass them.
SHORT = ["-fno-tree-ter", "--param=max-combine-insns=2", "--param=ira-max-conflict-table-size=1"]
INSTRUCTIONS = ("avx2", "fma"), ("avx512f",)  # what a processor must have for them, and for eight cells at once


def _instructions() -> list[str]:
    """The compiler's arguments for instructions that the processor has; none where a platform does not tell."""
    try:
        features = get_host_cpu_features()
    except RuntimeError:
        return []
    return [f"-m{name}" for names in INSTRUCTIONS if all(features.get(name) for name in names) for name in names]


OPTIONS = {"timeout": 600,
           "cffi_extra_compile_args": ["-O1", "-g0", "-ffp-contract=fast", "-Wno-psabi", *SHORT, ARGUMENT,
                                       *_instructions()]}
ANNOUNCED, RECIPES = "compiling", "recipes"  # folders in the cache: files of processes that compile, and of kernels
_looked_after: set[Path] = set()  # caches, by this process
_entry_points = lru_cache(metadata.entry_points)


def _symbols(numberer, expression) -> list[int]:
    """What FFCx's `get_node_symbols` returns, which compares an expression with all others of its graph."""
    return numberer.V_symbols[numberer.G.e2i[expression]]


with suppress(ImportError):
    import_module(f"{dolfinx.jit.ffcx.__name__}.ir.analysis.valuenumbering").ValueNumberer.get_node_symbols = _symbols


def _options() -> dict:
    """Those above, but for what the user's dolfinx_jit_options.json says otherwise."""
    usual = dolfinx.jit.DOLFINX_DEFAULT_JIT_OPTIONS
    return OPTIONS | {name: value for name, value in dolfinx.jit.get_options().items()
                      if name in OPTIONS and name != "cache_dir" and value != usual[name][0]}


def compiled_form(form) -> fem.Form:
    """A UFL form, or an array of them, as kernels and data for assembly."""
    compiler = dolfinx.jit.ffcx.codegeneration.jit
    usual, compiler.get_cached_module = compiler.get_cached_module, partial(_on_disk, compiler.get_cached_module)
    try:
        with _announced(), _entry_points_kept():
            return fem.form(form, jit_options=_options())
    finally:
        compiler.get_cached_module = usual


def compiled_expression(expression, points: np.ndarray, prepare: Callable | None = None) -> fem.Expression:
    """A UFL expression as a kernel for its values at points of the reference cell, shape (n, dimension).

    Parameters
    ----------
    prepare : what is done with the expression before it is compiled, a function of it alone; not called where the
        kernel is there
    """
    folder = Path(dolfinx.jit.get_options(_options())["cache_dir"]) / RECIPES
    try:
        description = Description(expression, _asked(), points.shape, points.tobytes(), _source_of(prepare))
    except Undescribed:
        return _compile(expression, points, prepare)[0]
    file = folder / f"{description.key}.json"
    if recipe := _recipe(file, lasting(description.domains[0].ufl_cargo().comm)):
        return _with_kernel(recipe.standing_in(description), points, lambda *_, **__: _kernel(folder.parent, recipe),
                            lambda: folder.parent / recipe.library)
    found, prepared, library = _compile(expression, points, prepare)
    recipe = Recipe.of(description, prepared, *library)
    if recipe:
        _recipes[file] = recipe
        recipe.write(file)
    return found


@contextmanager
def _entry_points_kept() -> Iterator[None]:
    """Have setuptools, by which cffi compiles, read the entry points of all packages once, not for each kernel."""
    usual, metadata.entry_points = metadata.entry_points, _entry_points
    try:
        yield
    finally:
        metadata.entry_points = usual


@contextmanager
def _announced() -> Iterator[None]:
    """Hold the lock of a process that compiles, after kernels are gone that others were killed in."""
    cache = Path(dolfinx.jit.get_options(_options())["cache_dir"])
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
    """A new file whose lock this process holds: until it does, another one may take it away as a dead one's."""
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
        if time < last and (time >= min(dead.values(), default=now) or time < now - _options()["timeout"]):
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


_recipes: dict[Path, Recipe] = {}  # of this process, by their files
_libraries: dict[Path, object] = {}  # that are loaded


def _asked() -> tuple:
    """Options on which kernels depend."""
    options = dolfinx.jit.get_options(_options())
    return {**options, "cache_dir": None, "timeout": None}, dolfinx.jit.ffcx.get_options()


@lru_cache
def _source_of(function: Callable | None) -> str:
    """A function and the file that it stands in; "" for none."""
    return "" if function is None else function.__qualname__ + sha256(
        Path(getsourcefile(function)).read_bytes()).hexdigest()


def _recipe(file: Path, comm) -> Recipe | None:
    """The recipe in a file, process 0's on all."""
    if file not in _recipes:
        found = comm.bcast(Recipe.read(file) if comm.rank == 0 else None)
        if found is None:
            return None
        _recipes[file] = found
    return _recipes[file]


def _compile(expression, points: np.ndarray, prepare: Callable | None) -> tuple[fem.Expression, object, tuple]:
    """A compiled expression, the expression that was compiled, and the kernel's library and name."""
    prepared, made = expression if prepare is None else prepare(expression), []

    def compile_it(*arguments, **options):
        made.append(compiler(*arguments, **options))
        return made[0]

    compiler, usual = dolfinx.jit.ffcx_jit, cffi.FFI
    cffi.FFI = builder_for(prepared, points)
    try:
        with _announced(), _entry_points_kept():
            found = _with_kernel(prepared, points, compile_it, lambda: Path(made[0][1].__file__))
    finally:
        cffi.FFI = usual
    library = Path(made[0][1].__file__)
    _libraries[library] = made[0][1]
    return found, prepared, (library.name, next(n for n in dir(made[0][1].lib) if n.startswith("expression_")))


def _on_disk(usual: Callable, module: str, names: list[str], folder: Path, timeout: int) -> tuple:
    """What FFCx's `get_cached_module` returns, which lists all files of the cache for each form."""
    library = Path(folder) / (module + EXTENSION_SUFFIXES[0])
    if library not in _libraries and not (library.exists() and (Path(folder) / f"{module}.c.cached").exists()):
        return usual(module, names, folder, timeout)
    return [getattr(_library(library).lib, name) for name in names], _library(library)


def _library(file: Path):
    """The module in a file, loaded once."""
    if file not in _libraries:
        spec = spec_from_file_location(file.name.partition(".")[0], file)
        module = module_from_spec(spec)
        spec.loader.exec_module(module)
        _libraries[file] = module
    return _libraries[file]


def _kernel(folder: Path, recipe: Recipe) -> tuple:
    """What `dolfinx.jit.ffcx_jit` returns of a kernel on disk."""
    library = _library(folder / recipe.library)
    return getattr(library.lib, recipe.name), library, (None, None)


def _with_kernel(expression, points: np.ndarray, compiler: Callable, library: Callable[[], Path]) -> fem.Expression:
    """DOLFINx's expression with the kernel that a compiler in the place of its own gives."""
    usual, dolfinx.jit.ffcx_jit = dolfinx.jit.ffcx_jit, compiler
    try:
        return CellExpression(expression, points, library, jit_options=_options())
    finally:
        dolfinx.jit.ffcx_jit = usual
