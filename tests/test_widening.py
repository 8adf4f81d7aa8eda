"""Kernels that do several cells at once have the values of those that FFCx writes."""

import re
import subprocess
import warnings

import cffi
import numpy as np
import pytest
import ufl
from dolfinx import fem
from dolfinx.jit import ffcx
from dolfinx.mesh import CellType, create_unit_square
from mpi4py import MPI

from sheetfx import jit, widening
from sheetfx.compat import interpolation_points
from sheetfx.jit import compiled_expression

POINTS = np.array([[0.2, 0.1], [0.3, 0.4], [0.1, 0.7]])


def fields(cell, order=3):
    """A mesh of 30 or 60 cells with two random fields of unlike elements, and a constant."""
    mesh, random = create_unit_square(MPI.COMM_SELF, 6, 5, cell), np.random.default_rng(1)
    found = [fem.Function(fem.functionspace(mesh, element)) for element in (("Lagrange", order, (2,)), ("DG", 1))]
    for f in found:
        f.x.array[:] = random.normal(size=len(f.x.array))
    return mesh, *found, fem.Constant(mesh, (2.5, -1.0))


def straight(f, g, k):
    """Arithmetic, roots and powers, numbers that are the same in all cells, and zeros."""
    slopes = ufl.grad(f) * k
    x = ufl.SpatialCoordinate(ufl.domain.extract_unique_domain(f))
    return ufl.as_vector([f[0] * x[0] + g, ufl.sqrt(f[1] ** 2 + 1), slopes[0] / (2 + slopes[1] ** 2), 3 * k[0], 0 * g])


@pytest.mark.parametrize("cell", [CellType.triangle, CellType.quadrilateral])
@pytest.mark.parametrize("count", [1, 3, 4, 29])
def test_several_cells_at_once(cell, count, monkeypatch):
    mesh, f, g, k = fields(cell)
    expression = straight(f, g, k)
    compiled = compiled_expression(expression, POINTS)
    assert compiled.several
    cells = np.random.default_rng(2).permutation(30)[:count].astype(np.int32)
    for change in ((2.5, -1.0), 1.0), ((1.0, 3.0), 2.0):
        k.value[:], f.x.array[:] = change[0], change[1] * f.x.array
        usual = fem.Expression(expression, POINTS).eval(mesh, cells)
        with monkeypatch.context() as patch:
            patch.delattr(fem.Expression, "eval")  # which does one cell after the other
            found = compiled.eval(mesh, cells)
        assert found.ravel() == pytest.approx(usual.ravel(), rel=1e-13, abs=1e-13)


CHOICES = {
    "of two fields": lambda f, g, k: ufl.conditional(ufl.gt(f[0], 0), f[0], g),
    "of numbers": lambda f, g, k: ufl.conditional(ufl.le(f[0], g), 1, ufl.conditional(ufl.eq(g, 2.0), -1.0, k[0])),
    "by numbers": lambda f, g, k: ufl.conditional(ufl.lt(k[0], 2.0), f[0], 2.0) * g,
    "of what is not a number elsewhere": lambda f, g, k: ufl.conditional(ufl.ge(f[0], 0), ufl.sqrt(f[0]), g),
    "by several": lambda f, g, k: ufl.conditional(ufl.And(ufl.Not(ufl.gt(f[0], 0)), ufl.Or(
        ufl.lt(g, 0), ufl.ne(f[1], k[0]))), f[1], g),
    "sign, size": lambda f, g, k: ufl.sign(f[0]) * abs(g),
    "larger, smaller": lambda f, g, k: ufl.max_value(f[0], g) * ufl.min_value(f[1], k[1]) + ufl.max_value(k[0], 2.0)}


@pytest.mark.parametrize("name", CHOICES)
def test_choices(name, monkeypatch):
    """Cells beside each other choose differently."""
    mesh, f, g, k = fields(CellType.triangle)
    expression, cells = CHOICES[name](f, g, k), np.arange(29, dtype=np.int32)
    compiled, usual = compiled_expression(expression, POINTS), fem.Expression(expression, POINTS).eval(mesh, cells)
    assert compiled.several
    monkeypatch.delattr(fem.Expression, "eval")
    assert compiled.eval(mesh, cells).ravel() == pytest.approx(usual.ravel(), rel=1e-13, abs=1e-13)


@pytest.mark.parametrize("expression", [
    lambda f, g, k: ufl.sin(f[0]), lambda f, g, k: ufl.conditional(ufl.gt(f[0], 0), ufl.cos(g), g),
    lambda f, g, k: (2 + ufl.sqrt(f[0] ** 2 + 1)) ** (1 + g ** 2)], ids=["sine", "cosine by choice", "power"])
def test_other_functions_stay(expression):
    mesh, f, g, k = fields(CellType.triangle)
    compiled, cells = compiled_expression(expression(f, g, k), POINTS), np.arange(7, dtype=np.int32)
    assert not compiled.several
    assert (compiled.eval(mesh, cells) == fem.Expression(expression(f, g, k), POINTS).eval(mesh, cells)).all()


def test_interpolation_goes_cell_by_cell():
    """DOLFINx calls the kernel of one cell there."""
    mesh, f, g, k = fields(CellType.triangle)
    found = [fem.Function(fem.functionspace(mesh, ("DG", 1))) for _ in range(2)]
    points = interpolation_points(found[0].function_space)
    for function, compile_it in zip(found, (compiled_expression, fem.Expression), strict=True):
        function.interpolate(compile_it(f[0] / (1 + g**2), points))
    assert found[0].x.array == pytest.approx(found[1].x.array, rel=1e-13)


HEAD = re.compile(r"^void tabulate_tensor_expression_\w+\((.*?)\)\n", re.M | re.S)


@pytest.fixture
def cache(tmp_path, monkeypatch):
    monkeypatch.setitem(jit.OPTIONS, "cache_dir", tmp_path)
    monkeypatch.setattr(jit, "_recipes", {})


@pytest.fixture
def sources(cache):
    """What FFCx writes of an expression, and what is made of such a text."""
    seen = []

    def see(builder, **options):
        seen.append(builder)
        raise NotImplementedError

    with pytest.MonkeyPatch.context() as patch, pytest.raises(NotImplementedError):
        patch.setattr(widening.Builder, "compile", see)
        compiled_expression(straight(*fields(CellType.triangle)[1:]), POINTS)
    return seen[0]._source, seen[0]._rewritten


@pytest.mark.parametrize("more", ["", ",\n  void* custom_data", ", int a,\n  const double* restrict b"])
def test_signature_is_that_of_ffcx(sources, more):
    """Whatever parameters a version of FFCx has."""
    source, widened = sources
    (usual,) = HEAD.findall(source)
    changed = source.replace(f"{usual})", f"{usual}{more})")
    assert HEAD.findall(widened(changed)) == [usual + more]
    assert widened(changed) != changed


@pytest.mark.parametrize("instructions", [True, False], ids=["this processor", "any processor"])
def test_compiler_has_nothing_to_say(sources, tmp_path, instructions):
    """And takes a parameter less for an error."""
    source, widened = sources
    (usual,) = HEAD.findall(source)
    wanted = [a for a in jit.OPTIONS["cffi_extra_compile_args"] if instructions or not a.startswith("-m")]
    words = ["-std=c17", "-Wall", "-Werror", *wanted, "-c", "-I", ffcx.codegeneration.get_include_path(), "kernel.c"]
    said = []
    for text in widened(source), widened(source).replace(f"{usual})", f"{usual.rpartition(',')[0]})"):
        (tmp_path / "kernel.c").write_text(text)
        said.append(subprocess.run(["cc", *words], cwd=tmp_path, capture_output=True, text=True).stderr)
    assert said[0] == "" and "incompatible pointer type" in said[1]


def test_kernel_that_the_compiler_refuses_stays(cache, monkeypatch, capfd):
    mesh, f, g, k = fields(CellType.triangle)
    cells = np.arange(7, dtype=np.int32)
    monkeypatch.setattr(widening, "AFTER", "\n#error not with this compiler\n")
    with pytest.warns(RuntimeWarning, match="one cell at a time, since the compiler refuses several: .*not with"):
        compiled = compiled_expression(straight(f, g, k), POINTS)
    assert not compiled.several and capfd.readouterr().err == ""
    usual = fem.Expression(straight(f, g, k), POINTS).eval(mesh, cells)
    assert compiled.eval(mesh, cells).ravel() == pytest.approx(usual.ravel(), rel=1e-13, abs=1e-13)


def test_warnings_of_the_compiler_are_passed_on(cache, monkeypatch, capfd):
    """And are none for what is written here."""
    mesh, f, g, k = fields(CellType.triangle)
    monkeypatch.delenv("CFLAGS", raising=False)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert compiled_expression(straight(f, g, k), POINTS).several and capfd.readouterr().err == ""
        monkeypatch.setattr(widening, "AFTER", "\n#warning take care\n" + widening.AFTER)
        assert compiled_expression(2 * straight(f, g, k), POINTS).several
    assert "take care" in capfd.readouterr().err


def test_no_compiler_is_the_error_of_both(cache, monkeypatch):
    mesh, f, g, k = fields(CellType.triangle)
    monkeypatch.setitem(jit.OPTIONS, "cffi_extra_compile_args", ["-no-such-option"])
    with pytest.raises(cffi.VerificationError):
        compiled_expression(straight(f, g, k), POINTS)


def test_processor_that_does_not_tell_has_no_instructions(monkeypatch):
    def unknown():
        raise RuntimeError("no features here")

    monkeypatch.setattr(jit, "get_host_cpu_features", unknown)
    assert jit._instructions() == []
    monkeypatch.setattr(jit, "get_host_cpu_features", lambda: {"avx2": True, "fma": True, "avx512f": False})
    assert jit._instructions() == ["-mavx2", "-mfma"]
