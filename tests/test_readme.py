"""The README's snippets run as they stand and print what they say; its commands have the options that it shows."""

from __future__ import annotations

import re
import shlex
from contextlib import redirect_stdout
from io import StringIO
from pathlib import Path

import pytest
import typer

from sheetfx.cli import app
from sheetfx.scenes import scene_names

PAGE = (Path(__file__).parents[1] / "README.md").read_text()
SNIPPETS = re.findall(r"^```python\n(.*?)^```", PAGE, re.MULTILINE | re.DOTALL)
COMMANDS = [line for block in re.findall(r"^```sh\n(.*?)^```", PAGE, re.MULTILINE | re.DOTALL)
            for line in block.splitlines() if line.startswith("docker/run sheetfx ")]


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


@pytest.mark.parametrize("number", range(len(SNIPPETS)))
def test_snippets_run_and_print_what_they_say(number, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    found, expected = printed_by(SNIPPETS[number]).splitlines(), announced(SNIPPETS[number])
    assert found, "nothing is printed"
    for line, said in zip(found, expected, strict=False):
        assert_same_words(line, said)
    assert not expected or len(found) == len(expected)
    if number == 0:
        loads = [float(load) for load in re.findall(r"kind='limit', load=([\d.e+-]+)", "\n".join(found))]
        said = re.search(r"limit points at (\d+) N and (\d+) N", PAGE).groups()
        assert [f"{load:.0f}" for load in loads] == list(said)


def test_there_are_snippets_of_all_kinds():
    assert len(SNIPPETS) >= 6 and sum(bool(announced(s)) for s in SNIPPETS) >= 3 and len(COMMANDS) >= 8


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
        if name == "my_scene.py":
            return
        context = typer.Context(command)
        assert name in command.list_commands(context) or name in scene_names(), name
        command = command.get_command(context, name)
    known = {flag for parameter in command.params for flag in parameter.opts + parameter.secondary_opts} | {"--help"}
    scene = next((w for w in words if w in scene_names()), None)
    if scene and not words[0].startswith("-"):
        return
    assert {w.split("=")[0] for w in words if w.startswith("-")} <= known, line
