import pytest

import sheetfx  # noqa: F401  before DOLFINx and PETSc, as the wheel of DOLFINx 0.11 needs


def pytest_addoption(parser):
    parser.addoption("--slow", action="store_true", help="also run the long studies")


def pytest_collection_modifyitems(config, items):
    if not config.getoption("--slow"):
        for item in items:
            if "slow" in item.keywords:
                item.add_marker(pytest.mark.skip(reason="long study: add --slow"))
