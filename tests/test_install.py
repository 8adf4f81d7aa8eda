"""What an installation needs is declared, and what the system lacks is said."""

import ast
import os
import re
import shutil
import subprocess
import sys
import tomllib
import zipfile
from pathlib import Path

import pytest

from sheetfx import compat

TREE = Path(__file__).parents[1]
PROJECT = tomllib.loads((TREE / "pyproject.toml").read_text())["project"]
IN_WHEEL = {"dolfinx", "dolfinx_solver", "petsc4py", "slepc4py"}  # all come with one package
PACKAGES = {"basix": "fenics-basix", "ufl": "fenics-ufl", "mpl_toolkits": "matplotlib",
            "myst_parser": "myst-parser"} | dict.fromkeys(IN_WHEEL, "dolfinx-solver-real")
CONDA = {"dolfinx-solver-real": {"fenics-dolfinx", "petsc4py", "slepc4py"}, "gmsh": {"python-gmsh"},
         "matplotlib": {"matplotlib-base"}}


def declared(*groups):
    """Names of packages without their versions."""
    listed = PROJECT["dependencies"] + [d for group in groups for d in PROJECT["optional-dependencies"][group]]
    return {re.split(r"[<>=~! ;\[]", dependency)[0] for dependency in listed}


def imported(*folders):
    """Packages that files import, inside functions too, but for the standard library and those beside them."""
    files = [file for folder in folders for file in (TREE / folder).rglob("*.py") if "peers" not in file.parts]
    found, own = set(), {"sheetfx", *(file.stem for file in files)}
    for file in files:
        for node in ast.walk(ast.parse(file.read_text())):
            if isinstance(node, ast.Import):
                found |= {alias.name.partition(".")[0] for alias in node.names}
            elif isinstance(node, ast.ImportFrom) and not node.level:
                found.add(node.module.partition(".")[0])
    return found - own - set(sys.stdlib_module_names)


def of(names):
    return {PACKAGES.get(name, {"vtkmodules": "pyvista"}.get(name, name)) for name in names}


def test_every_import_is_declared():
    """And nothing else: a dependency that is gone from the code goes from the list."""
    assert of(imported("sheetfx", "meshes")) == declared("fenicsx")
    assert of(imported("demos")) <= declared("fenicsx", "demos", "pages")
    assert of(imported("tests")) <= declared("fenicsx", "test")


def test_conda_has_the_same():
    lines = (TREE / "docker" / "environment.yml").read_text().splitlines()
    listed = {re.split(r"[<>=]", line.strip(" -"))[0] for line in lines if line.startswith("  - ")}
    wanted = {name for package in declared("fenicsx", "test") for name in CONDA.get(package, {package})}
    assert wanted <= listed


@pytest.mark.parametrize(("variable", "value", "words"), [
    ("CC", "no-such-compiler -O2", "C compiler 'no-such-compiler' is missing.*install one"),
    ("headers", "/nowhere", "/nowhere/Python.h is missing.*install the headers"),
])
def test_a_system_that_cannot_compile_is_refused(variable, value, words, monkeypatch):
    compat.require_compiler()
    if variable == "CC":
        monkeypatch.setenv("CC", value)
    else:
        monkeypatch.setattr(compat.sysconfig, "get_path", lambda name: value)
    with pytest.raises(FileNotFoundError, match=words):
        compat.require_compiler()


def test_a_system_without_the_libraries_of_gmsh_is_refused(tmp_path):
    (tmp_path / "gmsh.py").write_text("raise OSError('libGLU.so.1: cannot open shared object file')")
    result = subprocess.run([sys.executable, "-c", "import sheetfx.meshes"], capture_output=True, text=True,
                            env=os.environ | {"PYTHONPATH": os.pathsep.join((str(tmp_path), str(TREE)))})
    assert result.returncode and "libGLU.so.1" in result.stderr and "apt-get install libgl1 libglu1" in result.stderr


@pytest.mark.slow
def test_wheel_holds_all_that_a_run_needs(tmp_path):
    """Scenes, meshes with their tables, and nothing else."""
    tree = shutil.copytree(TREE, tmp_path / "tree", symlinks=True, ignore=shutil.ignore_patterns(".*", "results"))
    subprocess.run([sys.executable, "-m", "pip", "wheel", "--no-deps", "--no-build-isolation", "-w", str(tmp_path),
                    str(tree)], check=True, capture_output=True)
    (wheel,) = tmp_path.glob("*.whl")
    names = {name for name in zipfile.ZipFile(wheel).namelist() if ".dist-info/" not in name}
    source = {str(file.relative_to(TREE)) for file in (TREE / "sheetfx").rglob("*.py")}
    source |= {f"sheetfx/{file.relative_to(TREE)}" for file in (TREE / "meshes").rglob("*.*") if file.suffix != ".pyc"}
    assert names == source
