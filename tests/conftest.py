import sys
from collections import Counter

import pytest

import sheetfx  # noqa: F401  before DOLFINx and PETSc, as the wheel of DOLFINx 0.11 needs


def pytest_addoption(parser):
    parser.addoption("--slow", action="store_true", help="also run the long studies")


@pytest.hookimpl(trylast=True)
def pytest_collection_modifyitems(config, items):
    """Skip what is slow; of a test with `slow(quick=n)` all but the first n cases that are chosen and not slow."""
    quick = Counter()
    for item in [] if config.getoption("--slow") else items:
        left = min((mark.kwargs.get("quick", 0) for mark in item.iter_markers("slow")), default=None)
        test = item.nodeid.partition("[")[0]
        if left is not None and quick[test] >= left:
            item.add_marker(pytest.mark.skip(reason="long study: add --slow"))
        quick[test] += bool(left)


@pytest.fixture
def command(capfd, monkeypatch):
    """Function (words of the command) -> status, output, errors; in this process, since a start takes seconds."""
    from sheetfx import cli

    def command(*words):
        monkeypatch.setattr(sys, "argv", ["sheetfx", *map(str, words)])
        with pytest.raises(SystemExit) as ended:
            cli.main()
        told = capfd.readouterr()
        return ended.value.code or 0, told.out, told.err

    monkeypatch.setenv("COLUMNS", "400")
    monkeypatch.setattr("atexit.register", lambda *_: None)
    return command
