"""What an installation needs is declared, what the system lacks is said, and distributions are whole."""

import ast
import importlib.util
import os
import re
import shutil
import subprocess
import sys
import tarfile
import tomllib
import zipfile
from pathlib import Path

import pytest

import sheetfx
from sheetfx import compat

TREE = Path(__file__).parents[1]
PROJECT = tomllib.loads((TREE / "pyproject.toml").read_text())["project"]
IN_WHEEL = {"dolfinx", "dolfinx_solver", "petsc4py", "slepc4py"}  # all come with one package
PACKAGES = {"PIL": "pillow", "basix": "fenics-basix", "ufl": "fenics-ufl", "mpl_toolkits": "matplotlib",
            "myst_parser": "myst-parser"} | dict.fromkeys(IN_WHEEL, "dolfinx-solver-real")
INTO_TREE = re.compile(r"\]\((?!https?://|#)")  # a link of Markdown
CONDA = {"dolfinx-solver-real": {"fenics-dolfinx", "petsc4py", "slepc4py"}, "gmsh": {"python-gmsh"},
         "matplotlib": {"matplotlib-base"}}


def declared(*groups):
    """Names of packages without their versions."""
    listed = PROJECT["dependencies"] + [d for group in groups for d in PROJECT["optional-dependencies"][group]]
    return {re.split(r"[<>=~! ;\[]", dependency)[0] for dependency in listed}


def imported(*folders):
    """Packages that files import, inside functions too, but for the standard library and the tree's own."""
    files = [file for folder in folders for file in (TREE / folder).rglob("*.py") if "peers" not in file.parts]
    own = {"sheetfx", *(file.parent.name for file in TREE.glob("demos/*/__init__.py")), *(file.stem for file in files)}
    found = set()
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
    assert of(imported("sheetfx", "meshes")) == declared("fenicsx", "files") - {"h5py"}  # which meshio takes
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


def test_one_version():
    """Of the package, whose build reads it there, and of the citation."""
    assert PROJECT["dynamic"] == ["readme", "version"]
    (cited,) = re.findall(r"^version: (.*)$", (TREE / ".github" / "CITATION.cff").read_text(), re.M)
    assert sheetfx.__version__ == cited


def test_long_description_has_no_way_into_the_tree():
    spec = importlib.util.spec_from_file_location("packing", TREE / ".ci" / "packing.py")
    packing = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(packing)
    text = packing.description((TREE / "README.md").read_text())
    assert "![" not in text and not INTO_TREE.findall(text) and "(six minutes). All ways." in text
    wanted = {"![a](b.png)\n\n*c\nd*\n\n*e*": "*e*", "![a](b.png)\n\n**c**": "**c**", "[c](#d)": "[c](#d)",
              "a\n\n| b |\n|---|\n| [![c](d)](e) |\n\nf": "a\n\nf", "| b |\n|---|\n| c |\n": "| b |\n|---|\n| c |\n",
              "[`a`](b) [c](https://d) ![e](f)": "`a` [c](https://d) ",
              "`x[0](1)`\n```py\nx[0](1)\n```\n[a](b)": "`x[0](1)`\n```py\nx[0](1)\n```\na"}
    assert {one: packing.description(one) for one in wanted} == wanted


@pytest.mark.slow
def test_distributions_hold_all_that_a_run_needs(tmp_path):
    """Scenes, meshes with their tables, and nothing else; the wheel is made of the source distribution."""
    tree = tmp_path / "tree"
    tree.mkdir()
    for name in (".ci", "meshes", "sheetfx"):
        shutil.copytree(TREE / name, tree / name, symlinks=True)
    for name in ("LICENSE", "README.md", "pyproject.toml"):
        shutil.copy(TREE / name, tree)
    build = "import sys; sys.path.insert(0, '.ci'); import packing; packing.build_sdist('..')"
    subprocess.run([sys.executable, "-c", build], check=True, capture_output=True, cwd=tree)
    (sources,) = tmp_path.glob("sheetfx-*.tar.gz")
    with tarfile.open(sources) as archive:
        names = {name.partition("/")[2] for name in archive.getnames()}
    assert {".ci/packing.py", "LICENSE", "README.md", "pyproject.toml", "sheetfx/py.typed"} <= names
    made = {"", "PKG-INFO", "setup.cfg", "sheetfx", "sheetfx.egg-info"}
    assert {name.partition("/")[0] for name in names} == made | {".ci", "LICENSE", "README.md", "pyproject.toml"}
    subprocess.run([sys.executable, "-m", "pip", "wheel", "--no-deps", "--no-build-isolation", "-w", str(tmp_path),
                    str(sources)], check=True, capture_output=True)
    (wheel,) = tmp_path.glob("*.whl")
    with zipfile.ZipFile(wheel) as archive:
        names = {name for name in archive.namelist() if ".dist-info/" not in name}
        (metadata,) = (archive.read(name).decode() for name in archive.namelist() if name.endswith("/METADATA"))
    source = {str(file.relative_to(TREE)) for file in (TREE / "sheetfx").rglob("*.py")} | {"sheetfx/py.typed"}
    source |= {f"sheetfx/{file.relative_to(TREE)}" for file in (TREE / "meshes").rglob("*.*") if file.suffix != ".pyc"}
    assert names == source
    assert f"Version: {sheetfx.__version__}" in metadata and "Author: sheetfx developers" in metadata
    assert not INTO_TREE.findall(metadata)
