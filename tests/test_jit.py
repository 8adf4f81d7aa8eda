"""The cache of compiled forms stays sound where a process is killed while it compiles."""

import os
import signal
import subprocess
import sys
import time
from importlib import import_module

import dolfinx.jit
import numpy as np
import pytest
import ufl
from dolfinx import fem
from dolfinx.mesh import create_interval
from mpi4py import MPI

from sheetfx import jit
from sheetfx.mesh.numbers import with_constants

KILLED = """
import os, signal, sys
import sheetfx  # the wheel of DOLFINx loads MPI
from pathlib import Path
sys.path.insert(0, {tests!r})
import ffcx.codegeneration.jit as ffcx
from test_jit import expression, jit
ffcx._compile_objects = lambda *_, **__: os.kill(os.getpid(), signal.SIGKILL)
jit.OPTIONS["cache_dir"] = Path({cache!r})
expression()
"""


def expression():
    """Of an interval, compiled."""
    domain = create_interval(MPI.COMM_SELF, 1, (0.0, 1.0))
    return jit.compiled_expression(ufl.SpatialCoordinate(domain)[0] ** 2, np.array([[0.5]]))


@pytest.fixture
def cache(tmp_path, monkeypatch):
    monkeypatch.setitem(jit.OPTIONS, "cache_dir", tmp_path)
    monkeypatch.setitem(jit.OPTIONS, "timeout", 5)
    return tmp_path


def unfinished(cache):
    return [f for f in cache.glob("libffcx_*.c") if not f.with_suffix(".c.cached").exists()]


@pytest.fixture
def left(cache, request):
    """The kernel that a process was killed in."""
    script = KILLED.format(tests=str(request.path.parent), cache=str(cache))
    result = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, timeout=100)
    assert result.returncode == -signal.SIGKILL, result.stderr
    return unfinished(cache)[0]


def test_kernel_that_a_process_was_killed_in_is_compiled_again(cache, left):
    assert expression().eval(create_interval(MPI.COMM_SELF, 1, (0.0, 1.0)), np.array([0]))[0, 0] == pytest.approx(0.25)
    assert left.with_suffix(".c.cached").exists()
    assert not list((cache / jit.ANNOUNCED).iterdir())


def test_kernel_that_was_left_long_ago_is_compiled_again(cache, left):
    """By a process that told nobody of itself."""
    for file in (cache / jit.ANNOUNCED).iterdir():
        file.unlink()
    os.utime(left, (0, 0))
    assert expression() and left.with_suffix(".c.cached").exists()


def test_kernel_that_a_process_is_at_is_left_alone(cache, left):
    """Begun after this process announced itself, it may be this one's; when this one is done, it is nobody's."""
    with jit._announced():
        assert not left.exists()
        left.touch()
        (cache / jit.ANNOUNCED / "dead").touch()
        with jit._announced():
            assert left.exists()
    time.sleep(0.05)  # times of files are those of the last tick of the system's clock
    with jit._announced():
        assert not left.exists()


def slope(factor=1.7, early=True):
    """Of factor * (a f^2 + b g f) by f, with f = 2 and g, a, b = 3, 5, 7; a is made before b or after it."""
    domain = create_interval(MPI.COMM_SELF, 1, (0.0, 1.0))
    f, g = (fem.Function(fem.functionspace(domain, ("P", 1))) for _ in range(2))
    f.x.array[:], g.x.array[:] = 2, 3
    made = [fem.Constant(domain, value) for value in ((5.0, 7.0) if early else (7.0, 5.0))]
    a, b = made if early else made[::-1]
    variable = ufl.variable(f)
    expression = ufl.diff(factor * (a * variable**2 + b * g * variable), variable)
    return jit.compiled_expression(expression, np.array([[0.5]]), with_constants).eval(domain, np.array([0]))[0, 0]


def value(factor):
    return factor * (2 * 5 * 2 + 7 * 3)


@pytest.fixture
def compiled(cache, monkeypatch):
    """Grows with each expression that is given to the form compiler."""
    given, compiler = [], dolfinx.jit.ffcx_jit
    monkeypatch.setattr(jit, "_recipes", {})
    monkeypatch.setattr(dolfinx.jit, "ffcx_jit", lambda *a, **o: given.append(a) or compiler(*a, **o))
    return given


def test_kernel_is_found_by_what_its_expression_is_made_of(compiled, monkeypatch):
    """In the process and on disk, for other coefficients; not with other numbers, nor constants in another order."""
    assert slope() == pytest.approx(value(1.7), rel=1e-14)
    for recipes in (jit._recipes, {}):
        monkeypatch.setattr(jit, "_recipes", recipes)
        assert slope() == pytest.approx(value(1.7), rel=1e-14)
    assert len(compiled) == 1
    assert slope(0.3) == pytest.approx(value(0.3), rel=1e-14)
    assert slope(early=False) == pytest.approx(value(1.7), rel=1e-14)
    assert len(compiled) == 3


def test_kernel_that_was_taken_away_is_compiled_again(compiled, cache, monkeypatch):
    slope()
    for file in cache.glob("libffcx_*"):
        file.unlink()
    monkeypatch.setattr(jit, "_recipes", {})
    assert slope() == pytest.approx(value(1.7), rel=1e-14)
    assert len(compiled) == 2


def test_options_of_the_user_come_first(monkeypatch):
    assert jit._options() == jit.OPTIONS
    monkeypatch.setattr(dolfinx.jit, "_load_options", lambda: ({"cffi_extra_compile_args": ["-O0"]}, {}))
    assert jit._options() == jit.OPTIONS | {"cffi_extra_compile_args": ["-O0"]}


def test_forms_on_disk_are_found_without_a_list_of_all_files(cache, monkeypatch):
    domain = create_interval(MPI.COMM_SELF, 2, (0.0, 1.0))
    length = fem.Constant(domain, 1.0) * ufl.dx

    def refused(*arguments):
        raise AssertionError("FFCx looks for the form itself")

    first = fem.assemble_scalar(jit.compiled_form(length))
    monkeypatch.setattr(dolfinx.jit.ffcx.codegeneration.jit, "get_cached_module", refused)
    jit._libraries.clear()
    assert fem.assemble_scalar(jit.compiled_form(length)) == first == 1.0


def test_expressions_are_found_by_the_index_of_their_graph():
    """As where each is compared with all others, which is what FFCx does by itself."""
    graphs, numbering = (import_module(f"ffcx.ir.analysis.{name}") for name in ("graph", "valuenumbering"))
    x = ufl.SpatialCoordinate(create_interval(MPI.COMM_SELF, 1, (0.0, 1.0)))
    graph = graphs.build_graph_vertices([ufl.outer(ufl.as_vector([x[0], 2 * x[0]]), ufl.as_vector([x[0], 3.0]))[1, 0]])
    numberer = numbering.ValueNumberer(graph)
    symbols = numberer.compute_symbols()
    expressions = [node["expression"] for node in graph.nodes.values()]
    assert len(expressions) > 5
    for one in expressions:
        assert numberer.get_node_symbols(one) == symbols[next(i for i, e in enumerate(expressions) if e == one)]
