"""Snippets of the README and the pages run as they stand and print what they say; commands have the options shown."""

from __future__ import annotations

import dataclasses
import importlib
import inspect
import re
import shlex
from contextlib import redirect_stdout
from io import StringIO
from pathlib import Path

import pytest
import typer

import sheetfx as fx
from sheetfx.cli import app
from sheetfx.continuation.options import Options
from sheetfx.scenes import scene_names

ROOT = Path(__file__).parents[1]
README = ROOT / "README.md"
PAGES = [README, *sorted((ROOT / "demos" / "pages").glob("*.md"))]


def blocks(page: Path, language: str) -> list[str]:
    return re.findall(rf"^```{language}\n(.*?)^```", page.read_text(), re.MULTILINE | re.DOTALL)


SNIPPETS = [(page, number) for page in PAGES for number in range(len(blocks(page, "python")))]
COMMANDS = [line for page in PAGES for block in blocks(page, "sh")
            for line in block.splitlines() if line.startswith("docker/run sheetfx ")]
OWN = "my_scene.py", "truss.py"  # scripts that readers have written


def printed_by(snippet: str) -> str:
    printed = StringIO()
    with redirect_stdout(printed):
        exec(compile(snippet, "README.md", "exec"), {"__name__": "__main__"})
    return printed.getvalue()


def announced(snippet: str) -> list[str]:
    """Lines that a snippet says it prints: the comments behind its last line."""
    lines = snippet.rstrip().splitlines()
    return [line[2:] for line in lines[max(i for i, line in enumerate(lines) if not line.startswith("# ")) + 1:]]


def assert_same_words(found: str, expected: str):
    """Words are equal, numbers to the digits that are shown."""
    assert len(found.split()) == len(expected.split()), (found, expected)
    for one, other in zip(found.split(), expected.split(), strict=True):
        try:
            assert float(one) == pytest.approx(float(other), rel=1e-3, abs=1e-6)
        except ValueError:
            assert one == other


@pytest.mark.parametrize(("page", "number"), SNIPPETS, ids=lambda v: v.stem if isinstance(v, Path) else str(v))
def test_snippets_run_and_print_what_they_say(page, number, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    snippet = blocks(page, "python")[number]
    found, expected = printed_by(snippet).splitlines(), announced(snippet)
    assert found, "nothing is printed"
    for line, said in zip(found, expected, strict=False):
        assert_same_words(line, said)
    assert not expected or len(found) == len(expected)


def test_a_stranger_reads_the_readme_in_five_minutes():
    """One snippet, which says what it prints; links to pages; the rest stands there."""
    text = README.read_text()
    assert len(text.split()) <= 700 and len(text.splitlines()) <= 130
    assert [bool(announced(snippet)) for snippet in blocks(README, "python")] == [True]
    assert len(SNIPPETS) > 20 and len(COMMANDS) >= 8


def test_every_page_can_be_reached():
    """From the README over links, and in the tree of the site."""
    reached, left = set(), [README]
    while left:
        page = left.pop()
        if page in reached or not page.exists():
            continue
        reached.add(page)
        links = re.findall(r"\]\(([^)#:]+\.md)(?:#[^)]*)?\)", page.read_text())
        left += [(page.parent / link).resolve() for link in links]
    settings = (ROOT / "demos" / "pages" / "conf.py").read_text()
    for page in sorted((ROOT / "demos" / "pages").glob("*.md")):
        assert page in reached, page
        assert page.stem == "index" or f'"{page.stem}"' in settings, page


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_links_lead_to_files(page):
    links = re.findall(r"\]\(([^)#:]+)\)", page.read_text())
    assert [link for link in links if not (page.parent / link).exists()] == []


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_names_of_pages_exist(page):
    assert set(re.findall(r"`fx\.(\w+)", page.read_text())) <= set(dir(fx))


def test_reference_has_all_names():
    """Each public name has a docstring to show."""
    assert [name for name in dir(fx) if not inspect.getdoc(getattr(fx, name))] == []


@pytest.mark.parametrize("line", COMMANDS)
def test_commands_exist_with_their_options(line):
    """Each command of the page, its scene and its options are there; they are not run."""
    words = shlex.split(line, comments=True)
    words = words[words.index("sheetfx") + 1:]
    command = typer.main.get_command(app)
    while words and hasattr(command, "get_command"):
        if words[0].startswith("-"):
            break
        name = words.pop(0)
        if name in OWN:
            return
        if name.endswith(".py"):
            name = str(ROOT / name)
            assert Path(name).exists(), name
        context = typer.Context(command)
        assert name.endswith(".py") or name in command.list_commands(context) or name in scene_names(), name
        command = command.get_command(context, name)
    known = {flag for parameter in command.params for flag in parameter.opts + parameter.secondary_opts} | {"--help"}
    scene = next((w for w in words if w in scene_names()), None)
    if scene and not words[0].startswith("-"):
        return
    assert {w.split("=")[0] for w in words if w.startswith("-")} <= known, line


def test_the_page_on_the_method_names_what_there_is_in_few_words():
    page = (ROOT / "demos" / "pages" / "method.md").read_text()
    names = re.findall(r"`((?:continuation|events|critical)\.[\w.]+)`", page)
    assert len(names) > 15
    for name in names:
        found = importlib.import_module(f"sheetfx.{'.'.join(name.split('.')[:2])}")
        for part in name.split(".")[2:]:
            found = getattr(found, part)
    keywords = set(re.findall(r"`([a-z_]+)`", page)) - {"code", "spread"}
    assert keywords <= {field.name for field in dataclasses.fields(Options)}
    assert len(page.split()) <= 1500


def test_scripts_import_sheetfx_before_dolfinx():
    """The wheel of DOLFINx 0.11 finds its MPI by what `import sheetfx` loads."""
    texts = [block for page in PAGES for block in blocks(page, "python")]
    texts += [file.read_text() for file in (ROOT / "demos").rglob("*.py")]
    with_dolfinx = [text for text in texts if re.search(r"^(from|import) dolfinx", text, re.MULTILINE)]
    assert len(with_dolfinx) > 1
    for text in with_dolfinx:
        assert re.search(r"^(from|import) sheetfx", text, re.MULTILINE).start() < text.index(" dolfinx")
